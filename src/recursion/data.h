/* The data: all that changes in one evaluation context, in one block.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_DATA_H
#define MBSRI_DATA_H

#include "algebra/twofold.h"
#include "model/record.h"

#include <mbsrank/data.h>

/* ARRAY(name, length): arrays of doubles in the block, body after body. Shapes in mbsri_body's
 * terms. K is divided out: H, J, kI, kII are those of (7)-(9) multiplied by K^-1, mu is K^T mu,
 * Mbar is K^T Mbar K; D, tau and the residuals are the same with and without. */
/* clang-format off */
#define MBSRI_DATA_ARRAYS(ARRAY)                                                                   \
    ARRAY(q, m->nq)             /* nq         joint positions, as swept             positions */   \
    ARRAY(q_full, m->size_full) /* joint.n    with those held, where some are       positions */   \
    ARRAY(u_full, m->size_full) /* joint.n                                          velocities */  \
    ARRAY(u, m->nu)             /* nu         joint velocities, as swept            velocities */  \
    ARRAY(p, m->size_p)         /* np         pose (7)                              positions */   \
    ARRAY(Kinv, m->size_k)      /* d x d      K^-1, where K is not the unit matrix  positions */   \
    ARRAY(H, m->size_dp)        /* d x d_pred                                       positions */   \
    ARRAY(J, m->size_dn)        /* d x n                                            positions */   \
    ARRAY(kI, m->size_v)        /* d                                                positions */   \
    ARRAY(M, m->size_dd)        /* d x d      body mass matrix                      positions */   \
    ARRAY(V, m->size_v)         /* d          velocity (8)                          velocities */  \
    ARRAY(kII, m->size_v)       /* d                                                velocities */  \
    ARRAY(h, m->size_v)         /* d          gyroscopic force                      velocities */  \
    ARRAY(f, m->size_v)         /* d          applied and gyroscopic forces         forces */      \
    ARRAY(tau, m->nu)           /* n          joint forces                          forces */      \
    ARRAY(Mbar, m->size_dd)     /* d x d      (17a)                                 backward */    \
    ARRAY(W, m->size_dd)        /* d x d      size of the rounding errors in Mbar   backward */    \
    ARRAY(unsure, m->size_dd)   /* d x d      the same after twofold precision      backward */    \
    ARRAY(fbar, m->size_v)      /* d          (17b)                                 backward */    \
    ARRAY(D, m->size_nn)        /* n x n      J^T Mbar J                            backward */    \
    ARRAY(Dinv, m->size_nn)     /* n x n      its pseudo-inverse                    backward */    \
    ARRAY(X, m->size_nn)        /* n x n      eigenvectors of S D S, range first    backward */    \
    ARRAY(s, m->nu)             /* n          S = diag(s)                           backward */    \
    ARRAY(lambda, m->nu)        /* n          eigenvalues of S D S, descending      backward */    \
    ARRAY(judged, m->nu)        /* n          those with S of W                     backward */    \
    ARRAY(U, m->size_dg)        /* d x n      Mbar J                                backward */    \
    ARRAY(G, m->size_dg)        /* d x n      Mbar J D^+                            backward */    \
    ARRAY(e, m->nu)             /* n          tau - J^T (fbar + Mbar kII)           backward */    \
    ARRAY(turned, (size_t)m->bodies + 1) /* 1 moments of inertia that were turned   backward */    \
    ARRAY(scale, (size_t)m->bodies + 1) /* 1  largest entry of diag(J^T W J)        backward */    \
    ARRAY(A, m->size_v)         /* d          acceleration (9), its known part      inverse */     \
    ARRAY(Az, m->size_v)        /* d          part of null accelerations            forward */     \
    ARRAY(mu, m->size_v)        /* d          joint reaction                        inverse */     \
    ARRAY(vec, m->nu)           /* n          null accelerations                    forward */     \
    ARRAY(Hdot, m->size_dp)     /* d x d_pred rate of H along the motion            rates */       \
    ARRAY(Jdot, m->size_dn)     /* d x n      rate of J                             rates */       \
    ARRAY(Mdot, m->size_dd)     /* d x d      rate of M                             rates */       \
    ARRAY(qdot, m->nq)          /* nq         q' = G u, as the caller's q           rates */       \
    ARRAY(udot, m->nu)          /* n          u' in the order of the sweeps   inverse, forward */  \
    ARRAY(out, m->nu)           /* n          a result in that order          inverse, forward */  \
    ARRAY(q_base, m->nq)        /* nq         the caller's q while displaced        rates */       \
    ARRAY(u_base, m->nu)        /* nu         the caller's u, likewise              rates */       \
    ARRAY(q_moved, m->nq)       /* nq         the displaced q                       rates */       \
    ARRAY(imp, m->size_v)       /* d          joint impulse m                       momentum */    \
    ARRAY(sigma, m->size_v)     /* d          its rate but for the reaction         momentum */    \
    ARRAY(impbar, m->size_v)    /* d          (17b) for momenta                     momentum */    \
    ARRAY(ep, m->nu)            /* n          p - J^T (impbar + Mbar kI)            momentum */    \
    ARRAY(w, m->nu)             /* n          index-1 velocities before X           index1 */      \
    ARRAY(Y, m->size_v)         /* d          Vz' - Az                              index1 */      \
    ARRAY(Mbardot, m->size_dd)  /* d x d      rate of Mbar                          index1 */      \
    ARRAY(Gdot, m->size_dg)     /* d x n      rate of G                             index1 */      \
    ARRAY(Xdot, m->size_nn)     /* n x n      rate of X                             index1 */      \
    ARRAY(s_frame, m->nu)       /* n          S of the reference                    frame */       \
    ARRAY(X_frame, m->size_nn)  /* n x n      X of the reference                    frame */       \
    ARRAY(u_given, m->nu)       /* nu         the caller's u, found from v          index1 */      \
    ARRAY(v_given, m->nu)       /* nu         the caller's v                        index1 */      \
    ARRAY(q_last, m->nq)        /* nq         the caller's q, evaluation pending    sweeps */      \
    ARRAY(u_last, m->nu)        /* nu         u                                     sweeps */      \
    ARRAY(load_last, m->nu)     /* nu         tau, or for inverse dynamics u'       sweeps */      \
    ARRAY(sincos, sincos_size(m)) /* 2 a coordinate                                 sweeps */      \
    ARRAY(closure_C, m->size_c) /* rows x columns  of each closure                closures */      \
    ARRAY(closure_q, m->max_columns) /* coordinates displaced                     closures */      \
    ARRAY(closure_D, (size_t)MBSR_CLOSURE_ROWS * (size_t)m->max_columns) /* C there closures */    \
    ARRAY(closure_w, m->rows > 0 ? m->nu : 0) /* n a vector over the joints       closures */      \
    ARRAY(closure_V, m->rows > 0 ? m->size_v : 0) /* d  and over the bodies       closures */      \
    ARRAY(closure_x, 2 * (size_t)m->max_columns + 4 * (size_t)m->rows) /* scratch closures */      \
    ARRAY(loop_lambda, m->rows) /* m          loop forces                         closures */      \
    ARRAY(scratch, scratch_size(m))

/* What is left of them in lean data. */
#define MBSRI_LEAN_ARRAYS(ARRAY)                                                                   \
    ARRAY(q, m->nq)                                                                                \
    ARRAY(u, m->nu)                                                                                \
    ARRAY(p, m->root.np)                                                                           \
    ARRAY(V, m->root.d)                                                                            \
    ARRAY(A, m->root.d)                                                                            \
    ARRAY(tau, m->nu)                                                                              \
    ARRAY(udot, m->nu)                                                                             \
    ARRAY(out, m->nu)                                                                              \
    ARRAY(vec, m->nu)                                                                              \
    ARRAY(w, m->nu)                                                                                \
    ARRAY(u_given, m->nu)                                                                          \
    ARRAY(q_last, m->nq)                                                                           \
    ARRAY(u_last, m->nu)                                                                           \
    ARRAY(load_last, m->nu)                                                                        \
    ARRAY(sincos, sincos_size(m))
/* clang-format on */

typedef enum mbsri_stage {
    MBSRI_STAGE_NONE,
    MBSRI_STAGE_POSITIONS,
    MBSRI_STAGE_VELOCITIES,
    MBSRI_STAGE_FORCES,
    MBSRI_STAGE_BACKWARD
} mbsri_stage;

/* A whole evaluation by the vectorised sweeps, whose stages run when somebody asks for what they
 * hold (dynamics/entry.h). */
typedef enum mbsri_pending {
    MBSRI_PENDING_NONE,
    MBSRI_PENDING_FORWARD,
    MBSRI_PENDING_INVERSE
} mbsri_pending;

struct mbsr_data {
    const mbsr_model *model;
    bool lean;  /* only the arrays of MBSRI_LEAN_ARRAYS are there */
    bool owned; /* by the model's allocator */
    mbsr_allocator allocator;
    mbsr_error error;
    mbsri_stage stage;
    double t;
    int total_rank;
    bool loaded;           /* loop_lambda holds at this state: mbsri_forces adds its forces */
    bool *dropped;         /* m->rows: rows of closures left to the others, being redundant */
    bool accelerated;      /* A and mu are those of given joint accelerations */
    bool single;           /* every joint is a group of its own (group.h) */
    mbsri_two *exact_work; /* of recursion/exact.c */
    bool *apart;           /* N + 1: so are those of the group of this head */
    mbsri_pending pending; /* what the stages would hold if the sweeps had not been taken */
    struct mbsri_sweep_state *sweep_state; /* N + 1 */
    struct mbsri_sweep_multi *sweep_multi;
    struct mbsri_carry *sweep_stack, *sweep_noise;
    struct mbsri_flow *sweep_flows;
    struct mbsri_sweep_load *sweep_load;
    int *rank;    /* N + 1 */
    int *watched; /* N + 1: the ranks expected, where `watching` */
    bool watching;
    int *frame_rank;               /* N + 1: ranks of the reference of the index-1 form */
    bool framed;                   /* there is such a reference */
    bool use_frame;                /* joint blocks are scaled by its S */
    bool keep_scale;               /* and by the S they have, but for groups taken apart */
    double alignment;              /* cosine of the largest angle to it */
    int *pivots;                   /* max_d */
    bool *carries;                 /* N + 1: whether Az of the body may differ from zero */
    mbsr_force_body *force_bodies; /* max_force_bodies */
#define MBSRI_DECLARE(name, length) double *name;
    MBSRI_DATA_ARRAYS(MBSRI_DECLARE)
#undef MBSRI_DECLARE
};

#endif
