/* The Newton system of the momentum form on trees of rigid bodies in space, in sweeps of their own.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * (dF/dy + c dF/dy') delta = r is eliminated leaves to root and solved root to leaves, with what
 * the sweeps of fast.h make of a rigid body: world axes, one point per body. The equations are in
 * newton_kernels.h. */
#ifndef MBSRI_FAST_NEWTON_H
#define MBSRI_FAST_NEWTON_H

#include "../newton/newton.h"
#include "fast.h"

/* ---- what callers need ---- */

typedef struct mbsri_fast_newton mbsri_fast_newton;

/* Returned by mbsri_fast_newton_factor where these sweeps do not serve. */
enum { MBSRI_NOT_SERVED = 1 << 20 };

/* Bytes of a solver of the model, 0 if it is never served. It is placed in memory aligned to
 * MBSR_DATA_ALIGNMENT. */
size_t mbsri_fast_newton_size(const mbsr_model *m);
mbsri_fast_newton *mbsri_fast_newton_place(const mbsr_model *m, void *memory);

/* Linearises and eliminates at (t, q, u), given in the caller's order. 0: there is a factorisation,
 * and the data is as after mbsri_fast_momentum_residual. MBSRI_NOT_SERVED: it is for the general
 * version. Else a status, with its text in d->error. */
int mbsri_fast_newton_factor(mbsri_fast_newton *newton, mbsr_data *d, double t, const double *q,
                             const double *u, double c);

/* delta from r = (r_q, r_p, r_u), both in the caller's order and perhaps the same; r == NULL: zero.
 * The other two are for models with elements on bodies only (tree->body_forces). load: NULL, or
 * perturbations of the forces on the bodies, six numbers at offset body.v. motion: NULL, or where
 * the perturbations of body i's pose (rotation, displacement of its origin) and of its V go, twelve
 * numbers at 12 i. */
void mbsri_fast_newton_solve(mbsri_fast_newton *newton, const double *r, const double *load,
                             double *delta, double *motion);

/* ---- what the sweeps keep ---- */

/* What they return, besides 0 and bodies whose rows are singular. */
enum { MBSRI_NOT_CLEAR = -1, MBSRI_DEFICIENT = -2 };

/* Of one joint coordinate, in the order in which the solution reads it. Perturbations of motion
 * stand in groups of three numbers: rotation, nu angular and linear, and, in `last`, displacement;
 * those of forces: chi angular and linear, moment, and, in `last`, force. x: the predecessor's, at
 * its point. Groups are written in this order, each with a fourth number that the next overwrites.
 * */
typedef struct mbsri_newton_column {
    double C[9];     /* what du adds to the forces of the subtree */
    double U[9];     /* what r_q (or what a quaternion makes of it) adds to them */
    double G[6];     /* Mbar S D^-1 */
    double S[6];     /* the axis: angular and linear part */
    double row[6];   /* S - S' / c */
    double K[9];     /* du = k - K x */
    double Q[9];     /* d(Mu) = p + Q x */
    double inverse;  /* of the pivot of the joint's row; joints of one axis only */
    double gain;     /* what r_q adds to the row; likewise */
    double last[13]; /* fourth groups of C, U, K, Q; models with elements on bodies only */
} mbsri_newton_column;

/* Of a joint of several axes. w are the rotations and displacements along its columns,
 * w = A (du + g), with g = r_q but for a quaternion. Matrices by rows. */
typedef struct mbsri_newton_block {
    double A[6][6];
    double inverse[6][6];            /* of the joint's rows */
    double gain[6][6];               /* what g adds to them */
    double couple[6][6];             /* d(Mu)_k = Q_k x + p_k - sum of couple_kl w_l */
    double T[6][8];                  /* T = V_a x S: nu += S du + T w */
    double length[6];                /* what a change of the quaternion's length adds to the rows */
    double tau_q[6][7], tau_u[6][6]; /* slopes of its joint forces */
    double q[4], u[3];               /* the quaternion and its rate, where there is one */
    int quaternion;
    int step[6]; /* of each column: its place in the sequence of axes */
    double idle;
} mbsri_newton_block;
MBSRI_CHECK_LAYOUT(mbsri_newton_block);

/* Of a body, for the solution. */
typedef struct mbsri_newton_step {
    double rho[4];
    int parent, flags, n, q, u, many;
    int branch; /* number among the bodies where the tree branches */
    int idle;
} mbsri_newton_step;
MBSRI_CHECK_LAYOUT(mbsri_newton_step);

/* And where motions or loads are asked for: from its point to the origin of its own frame, the
 * angular velocity, and the velocity of that origin. */
typedef struct mbsri_newton_own {
    double arm[4], omega[4], v[4];
} mbsri_newton_own;
MBSRI_CHECK_LAYOUT(mbsri_newton_own);

/* What elimination hands from a body to its predecessor: the matrix, and momentum and applied
 * forces of the subtree. Columns: rotation, nu angular and linear, displacement, three of each;
 * rows: chi angular and linear, moment, force, four numbers each. */
typedef struct mbsri_newton_carry {
    double P[4][3][4][4];
    double L[4], p[4], N[4], F[4];
} mbsri_newton_carry;
MBSRI_CHECK_LAYOUT(mbsri_newton_carry);

/* And in the solution: chi, moment and force; the recursion for L r_u. */
typedef struct mbsri_newton_flow {
    double b[16], L_bar[4], p_bar[4];
} mbsri_newton_flow;
MBSRI_CHECK_LAYOUT(mbsri_newton_flow);

struct mbsri_fast_newton {
    const mbsr_model *model;
    const mbsri_fast *tree;
    double c, by_c; /* c and 1 / c */
    unsigned char *column;
    size_t column_size;        /* bytes from one to the next */
    mbsri_newton_step *step;   /* bodies + 1 */
    mbsri_newton_block *block; /* tree->many */
    mbsri_newton_own *own;     /* bodies + 1, with elements on bodies */
    double *k, *p;             /* of the last solution, by coordinate */
    double (*x)[16];           /* motions of the bodies where the tree branches */
    mbsri_newton_carry *carry; /* tree->depth */
    mbsri_newton_flow *flow;   /* tree->depth */
    double *tau_q, *tau_u;     /* slopes of joint forces of joints of one axis, by coordinate */
    mbsri_slopes slopes;
};

static inline mbsri_newton_column *mbsri_newton_column_at(const mbsri_fast_newton *newton, int u)
{
    return (mbsri_newton_column *)(void *)(newton->column + newton->column_size * (size_t)u);
}

#endif
