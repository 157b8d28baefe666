/* Derivatives of inverse and forward dynamics of trees of rigid bodies on stock joints, by sweeps.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Everything is along the world's axes about one point a body, and changes are those seen in the
 * moving body: along dq its axes turn with it, and neither its inertia nor an axis that is fixed in
 * it changes. With r from the predecessor's point, w the angular velocity against it, omega and
 * (alpha, a) angular velocity and acceleration, and x, y, z of a joint along dq, du, du',
 *
 *   domega = domega_pi + sum of (S_w y + T x)
 *   dalpha = dalpha_pi + domega_pi x w + sum of (S_w z + U_w y + Q_w x)
 *   da     = da_pi + dalpha_pi x r + domega_pi x s + omega_pi x (domega_pi x r)
 *            + sum of (S_v z + U_v y + Q_v x),      s = omega_pi x r + 2 r'
 *   dL = I dalpha + c x da + domega x I omega + omega x I domega
 *   dp = m da + dalpha x c + domega x (omega x c) + omega x (domega x c)     root to leaves
 *   df = (dL, dp) + sum of successors (X^T (df + sum of C x)),   dtau = S^T df     and back
 *
 * where C = S x* f is what a turn of the joint makes of the force f that it bears; axis k of a
 * joint sees it of the axes behind k. With the articulated inertia's D and G = Mbar S D^-1 the way
 * back is that of differentiated forward dynamics, e = dtau - S^T df, df += G e, and once more to
 * the leaves, du' = D^-1 e - G^T X A_pi. The adjoint runs through the same from its end. */
#ifndef MBSRI_DERIVATIVES_RIGID_RECORD_H
#define MBSRI_DERIVATIVES_RIGID_RECORD_H

#include "sweeps/tree.h"

/* At the state. Vectors of four numbers, matrices by diagonals (sweeps/lane.h). */
typedef struct mbsri_rigid_body {
    double r[4], w[4], s[4], omega[4];
    double I[8], c[4]; /* tensor of inertia about its point, first moment and mass */
    double spin[4];    /* I omega */
    int parent, flags;
    int n, first; /* its columns */
    int multi;    /* index of its D^-1; -1: of one column */
    int place;    /* of its first column in the order of matrices */
    int idle[2];
} mbsri_rigid_body;
MBSRI_CHECK_LAYOUT(mbsri_rigid_body);

/* Of a rate, in the order of the joint's axes. Pairs: angular and linear part. */
typedef struct mbsri_rigid_column {
    double S[8], T[8], Q[8], U[8], C[8];
    double G[8], F[8], P[8]; /* Mbar S D^-1, Mbar S; G about the predecessor's point */
    double Dinv;             /* of one column */
    double tau_q, tau_u;     /* slopes of elements on this coordinate */
    double armature;         /* kg m^2 or kg */
    int u, link;             /* index in the caller's u; 3 for those of a quaternion, else 1 */
    int place, idle;         /* index in the order of the sweeps */
    double pad[2];
} mbsri_rigid_column;
MBSRI_CHECK_LAYOUT(mbsri_rigid_column);

/* Of one product: changes of omega, alpha, a, or accelerations (w, v), or gradients; forces. */
typedef struct mbsri_rigid_work {
    double x[3][4], f[8];
} mbsri_rigid_work;
MBSRI_CHECK_LAYOUT(mbsri_rigid_work);

/* Of a body as elements see it: from its point to its own origin, velocities of both, what elements
 * exert there (moment, force); along the world's axes. */
typedef struct mbsri_rigid_own {
    double arm[3], v[3], v_own[3], f[6];
} mbsri_rigid_own;

/* Of a body and all behind it, about its point: inertia [I G^T; G M]; components of the forces by
 * omega, for omega along each axis. */
typedef struct mbsri_rigid_composite {
    double I[8], G[12], M[8], B[6][4];
} mbsri_rigid_composite;
MBSRI_CHECK_LAYOUT(mbsri_rigid_composite);

/* What the frame of a joint changes of the body: omega, alpha, a; C before and behind the joint's
 * axes; what elements see: turn, displacement of the point, its velocity. Or gradients by them. */
typedef struct mbsri_rigid_frame {
    double x[3][4], C[2][8], motion[3][4];
} mbsri_rigid_frame;
MBSRI_CHECK_LAYOUT(mbsri_rigid_frame);

/* Of parameters, see rigid_seeds.h; arrays of bodies + 1. */
typedef struct mbsri_rigid_seeds {
    int *frame;                  /* which frame is the body's, or -1 */
    mbsri_rigid_frame *sum, *by; /* frames: along a change of all parameters; gradients */
    double *load;                /* 8 a body: of loads about its point */
    double (*own)[3], (*arm)[3]; /* from there to its own origin, in the body and in the world */
    bool active;                 /* whether products take these in */
    void *memory;
} mbsri_rigid_seeds;

/* Of a column: where its row begins; those of the `count` columns before it. */
typedef struct mbsri_rigid_way {
    size_t row, count;
    const size_t *path;
} mbsri_rigid_way;

/* The columns in an order in which those behind a body stand together, and what matrices need of
 * it. Rows of places, of four parts side by side: three matrices, and Lambda. On their way to the
 * root columns stand in slots, four in a block; those of a branch begin with a block. */
typedef struct mbsri_rigid_order {
    int *first, *end; /* bodies + 1: place of its columns; where those behind it end */
    int *u, *place;   /* nu: index in the caller's u; the place of that */
    int *slot;        /* nu */
    /* blocks: place of its first slot, from where the others go on; where they end; the joint
     * before all of them */
    int *block_place, *block_end, *block_joint;
    double *travel; /* MBSRI_RIGID_TRAVEL x blocks */
    size_t blocks;
    double *rows;         /* nu + 4 rows of `down` numbers */
    size_t down, part;    /* of a row, of its parts; 0: there are no rows */
    int width;            /* four times so many columns are summed at once */
    size_t *path;         /* where rows of columns before each column begin; NULL: too many */
    mbsri_rigid_way *way; /* nu */
} mbsri_rigid_order;

/* Numbers of a block; columns side by side in sweeps to the leaves; vectors of four in a row. */
enum { MBSRI_RIGID_TRAVEL = 108, MBSRI_RIGID_SIDE = 8, MBSRI_RIGID_WIDTH = 9 };

typedef struct mbsri_rigid mbsri_rigid;

/* The sweeps, compiled for every kind of processor. Products: vectors in the caller's order. */
typedef struct mbsri_rigid_kernels {
    int (*prepare)(mbsri_rigid *r, const mbsri_sweep_run *run, const double *udot, bool factors);
    void (*tangent)(mbsri_rigid *r, const double *dq, const double *du, const double *dudot,
                    double *dtau);
    void (*forward_tangent)(mbsri_rigid *r, const double *dq, const double *du, const double *dtau,
                            double *dudot);
    /* The adjoint: Y of the weights, or of x = M^-1 by, then `sign` times the gradient. */
    void (*move)(mbsri_rigid *r, const double *by);
    void (*solve)(mbsri_rigid *r, const double *by, double *x);
    void (*gradients)(mbsri_rigid *r, double sign, const double *by, double *dq, double *du,
                      double *dudot);
    /* nu x nu, column-major, any may be NULL; without other elements. Whether all is finite. */
    bool (*matrices)(mbsri_rigid *r, double *by_q, double *by_u, double *by_load, bool forward);
} mbsri_rigid_kernels;

extern const mbsri_rigid_kernels mbsri_rigid_base;
#if defined(MBSR_WITH_V3)
extern const mbsri_rigid_kernels mbsri_rigid_v3;
#endif

struct mbsri_rigid {
    const mbsr_model *model;
    const mbsri_rigid_kernels *kernels;
    const mbsri_sweeps *tree;             /* of the state */
    mbsri_rigid_body *body;               /* bodies + 1 */
    mbsri_rigid_column *column;           /* nu */
    mbsri_rigid_work *work;               /* bodies + 1 */
    double (*Dinv)[6][6];                 /* of joints of several axes */
    double *y;                            /* nu */
    double *q, *u, *tau_q, *tau_u;        /* in the order of the sweeps */
    mbsri_rigid_composite *composite;     /* bodies + 1 */
    double (*force)[6][MBSRI_RIGID_SIDE]; /* bodies + 1: accelerations where branches begin */
    double (*side)[MBSRI_RIGID_SIDE];     /* nu + 3 */
    int *along;                           /* bodies + 1, so that those behind one stand together */
    mbsri_rigid_order order;
    /* with other elements than gravity and those on one coordinate */
    bool elements;
    mbsri_rigid_own *own;     /* bodies + 1, of those with loads */
    double (*motion)[12];     /* bodies + 1 */
    double *load;             /* 8 a body: changes of loads, about its point; NULL: none */
    double *G;                /* of joints with q' = G u, by columns */
    double *by_q, *by_u;      /* nu: gradients by elements */
    mbsri_rigid_seeds *seeds; /* NULL: none are chosen */
    void *memory;
};

#endif
