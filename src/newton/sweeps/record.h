/* The Newton system of the momentum form on trees of rigid bodies in space: what the sweeps keep.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * (dF/dy + c dF/dy') delta = r is eliminated leaves to root and solved root to leaves, with what
 * the vectorised sweeps make of a rigid body: world axes, one point per body. The equations are in
 * perturbation.h. */
#ifndef MBSRI_NEWTON_RECORD_H
#define MBSRI_NEWTON_RECORD_H

#include "newton/slopes/force_slopes.h"
#include "sweeps/tree.h"

typedef struct mbsri_newton_sweeps mbsri_newton_sweeps;

/* Of one joint coordinate: what the solution reads root to leaves stands in front, S and row in
 * both sweeps, then what it reads leaves to root. Perturbations of motion stand in groups of three
 * numbers: rotation, nu angular and linear, and displacement; those of forces: chi angular and
 * linear, moment, and force. x: the predecessor's, at its point. Groups are written in this order,
 * each with a fourth number that the next overwrites. The fourth groups have memory in models with
 * elements on bodies or with loops only; in others the one before and the one behind stand there.
 */
typedef struct mbsri_newton_column {
    double K_last[3], Q_last[3], idle[2];
    double K[9];    /* du = k - K x */
    double Q[9];    /* d(Mu) = p + Q x */
    double S[6];    /* the axis: angular and linear part */
    double row[6];  /* S - S' / c */
    double C[9];    /* what du adds to the forces of the subtree */
    double U[9];    /* what r_q (or what a quaternion makes of it) adds to them */
    double G[6];    /* Mbar S D^-1 */
    double inverse; /* of the pivot of the joint's row; joints of one axis only */
    double gain;    /* what r_q adds to the row; likewise */
    double C_last[3], U_last[3], idle_behind[2];
} mbsri_newton_column;

/* Of a joint of several axes. w are the rotations and displacements along its columns,
 * w = A (du + g), with g = r_q but for a quaternion. Matrices by rows. */
typedef struct mbsri_newton_block {
    double A[6][6];
    double inverse[6][6]; /* of the joint's rows; where it is delayed, see multi_fronts.h, what g
                                        adds to the balances of forces */
    double gain[6][6];    /* what g adds to them */
    double couple[6][6];  /* d(Mu)_k = Q_k x + p_k - sum of couple_kl w_l */
    double T[6][8];       /* T = V_a x S: nu += S du + T w */
    double length[6];     /* what a change of the quaternion's length adds to the rows */
    double tau_q[6][7], tau_u[6][6]; /* slopes of its joint forces */
    double q[4], u[3];               /* the quaternion and its rate, where there is one */
    int quaternion;
    int step[6]; /* of each column: its place in the sequence of axes */
    int idle[3];
} mbsri_newton_block;
MBSRI_CHECK_LAYOUT(mbsri_newton_block);

/* What a body is in a factorisation with joints whose block is zero (reaction.h). */
enum {
    MBSRI_BELOW_MASSLESS = 1, /* in the subtree of one of them */
    MBSRI_NO_INERTIA = 2      /* its joint is one of them */
};

/* Of the coordinate of a joint below a massless one: what du and r_q add to the reaction; what they
 * add to the row of F_p, where the joint's block is zero. */
typedef struct mbsri_newton_below_massless {
    double C[6], U[6];
    double pivot, gain;
} mbsri_newton_below_massless;

/* What the joint of a body has to exert on it. */
typedef struct mbsri_newton_reaction {
    double W[8];
} mbsri_newton_reaction;
MBSRI_CHECK_LAYOUT(mbsri_newton_reaction);

/* Of a body, for the solution. */
typedef struct mbsri_newton_step {
    double rho[4];
    int parent, flags, n, q, u, multi;
    int branch; /* number among the bodies where the tree branches */
    int below_massless;
} mbsri_newton_step;
MBSRI_CHECK_LAYOUT(mbsri_newton_step);

/* And where motions or loads are asked for: from its point to the origin of its own frame, the
 * angular velocity, and the velocity of that origin. */
typedef struct mbsri_newton_own {
    double arm[4], omega[4], v[4];
} mbsri_newton_own;
MBSRI_CHECK_LAYOUT(mbsri_newton_own);

/* Slopes of the forces on a body, (moment about its own origin, force), over the pose and V of a
 * body: columns of its rotation, its displacement, omega and v, three of each. */
typedef struct mbsri_newton_slopes {
    double by[4][3][2][4];
} mbsri_newton_slopes;
MBSRI_CHECK_LAYOUT(mbsri_newton_slopes);

/* Groups of columns and of rows (perturbation.h); of psi (reaction.h). */
enum { ROTATION, SPIN, DRIFT, DISPLACEMENT };
enum { CHI_L, CHI_P, MOMENT, FORCE };
enum { PSI_L, PSI_P };

/* What elimination hands from a body to its predecessor: the matrix, and momentum and applied
 * forces of the subtree. Columns: rotation, nu angular and linear, displacement, three of each;
 * rows: chi angular and linear, moment, force, four numbers each; Y: psi, likewise. */
typedef struct mbsri_newton_carry {
    double P[4][3][4][4], Y[4][3][2][4];
    double L[4], p[4], N[4], F[4];
} mbsri_newton_carry;
MBSRI_CHECK_LAYOUT(mbsri_newton_carry);

/* And in the solution: chi, moment and force; the recursion for L r_u. */
typedef struct mbsri_newton_flow {
    double b[16], psi[8], L_bar[4], p_bar[4];
} mbsri_newton_flow;
MBSRI_CHECK_LAYOUT(mbsri_newton_flow);

struct mbsri_newton_sweeps {
    const mbsr_model *model;
    const mbsri_sweeps *tree;
    const struct mbsri_newton_kernels *kernels;
    double c, by_c;            /* c and 1 / c */
    unsigned char *column;     /* nu records mbsri_newton_column, */
    size_t column_size;        /* so many bytes apart */
    mbsri_newton_step *step;   /* bodies + 1 */
    mbsri_newton_block *block; /* tree->multi */
    struct {
        /* slopes of the forces on a body over its own motion, over that of its predecessor, and of
         * the forces on the predecessor over the body's */
        mbsri_newton_slopes *at, *by_pred, *on_pred;
        int *number, *pair;    /* N + 1: index in `at`, and in `by_pred` and `on_pred`; -1: none */
        size_t acted, pairs;   /* lengths of `at`, and of `by_pred` and `on_pred` */
        mbsri_newton_own *own; /* bodies + 1 */
    } acting;                  /* elements on bodies */
    double *k, *p;             /* nu: k of du = k - K x, p of d(M u) = p + Q x, last solution */
    double (*x)[16];           /* motions of the bodies where the tree branches */
    mbsri_newton_flow *said;   /* loads of these bodies, in transposed solutions alone */
    mbsri_newton_carry *carry; /* tree->depth */
    mbsri_newton_flow *flow;   /* tree->depth */
    double *tau_q, *tau_u;     /* slopes of joint forces of joints of one axis, by coordinate; tau_u
                                  less c times armature, which adds to the same pivot */
    mbsri_slopes slopes;
    double least_pivot; /* of joints of several axes; below, the front takes over */
    bool large;         /* the model does not fit into a cache */
    struct {
        bool unclear;          /* the bound of rounding errors did not tell once: not tried again */
        bool below_massless;   /* some joint block was zero */
        bool massless_on_loop; /* bodies without inertia on loops were passed as such */
        bool looped;           /* loops were eliminated */
        bool marked;           /* marks below massless joints are those of `massless_on_loop` */
        bool joint_slopes;     /* those of joint forces were added (newton/sweeps/sweeps.c) */
    } last;                    /* factorisation */
    struct mbsr_newton *blocks;         /* has what is carried; NULL: there are no loops */
    struct mbsri_front *mixed;          /* passes the joints of blocks; NULL: there are none */
    int status;                         /* of the last failure in loops or in `mixed` */
    mbsri_newton_below_massless *below; /* nu; NULL: no joint block is expected to be zero */
    mbsri_newton_reaction *reaction;    /* bodies + 1 */
};

static inline mbsri_newton_column *mbsri_newton_column_at(const mbsri_newton_sweeps *newton, int u)
{
    return (mbsri_newton_column *)(void *)(newton->column + newton->column_size * (size_t)u);
}

/* The sweeps, compiled once for every kind of processor. The factorisations return 0, a body whose
 * rows are singular, or one of these: the sweeps do not serve; those for bodies below massless
 * joints have to; see `status`. The first sweeps as backward of sweeps/tree.h; the second is for
 * trees with joint blocks that are zero, the third for those with blocks, the last for those with
 * loops. Solve: see mbsri_newton_sweeps_solve; transposed: for trees without blocks and loops. */
enum { MBSRI_NOT_CLEAR = -1, MBSRI_DEFICIENT = -2, MBSRI_BLOCK_FAILED = -3 };
typedef struct mbsri_newton_kernels {
    int (*factor)(const mbsri_sweep_run *run, mbsri_newton_sweeps *newton);
    int (*factor_below_massless)(const mbsri_sweep_run *run, mbsri_newton_sweeps *newton);
    int (*factor_mixed)(const mbsri_sweep_run *run, mbsri_newton_sweeps *newton);
    int (*factor_looped)(const mbsri_sweep_run *run, mbsri_newton_sweeps *newton);
    void (*solve)(mbsri_newton_sweeps *newton, const double *r, const double *load, double *delta,
                  double *motion);
    void (*solve_transposed)(mbsri_newton_sweeps *newton, const double *v, double *x, double *tau);
} mbsri_newton_kernels;

extern const mbsri_newton_kernels mbsri_newton_base;
#if defined(MBSR_WITH_V3)
extern const mbsri_newton_kernels mbsri_newton_v3;
#endif

/* Pivots below this, relative to the size of what was summed, are zero but for rounding. */
#define MBSRI_LEAST_PIVOT 1e-14

/* Of blocks of several rows: a smaller one lets rounding errors grow by its inverse squared.
 * Between bodies nothing is exchanged that would avoid it. */
#define MBSRI_CLEAR_PIVOT 1e-3

/* Of loops that close, scaled: below, less than nine digits are left. */
#define MBSRI_SHARP_PIVOT 1e-6

#endif
