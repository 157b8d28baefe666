/* The data: all that changes in one evaluation context, in one block.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_DATA_H
#define MBSRI_DATA_H

#include "algebra/twofold.h"
#include "model/record.h"

#include <mbsrank/data.h>

/* Arrays of doubles in the block, body after body. EVERY(name, length); LEAN(name, unit): by
 * that field of mbsri_lengths, in lean data over the bodies in the sweeps; FULL(name, length): not
 * in lean data. Shapes in mbsri_body's terms. K is divided out: H, J, kI, kII are those of (7)-(9)
 * multiplied by K^-1, mu is K^T mu, Mbar is K^T Mbar K; D, tau and the residuals are the same with
 * and without. */
/* clang-format off */
#define MBSRI_DATA_ARRAYS(EVERY, LEAN, FULL)                                                       \
    EVERY(q, m->nq)           /* nq         joint positions, sweeps' order       positions */     \
    LEAN(q_full, full)        /* joint.n    with those held, where some are       positions */     \
    LEAN(u_full, full)        /* joint.n                                         velocities */     \
    EVERY(u, m->nu)           /* nu         joint velocities, sweeps' order     velocities */     \
    LEAN(p, p)                /* np         pose (7)                              positions */     \
    LEAN(Kinv, k)             /* d x d      K^-1, where K is not the unit matrix  positions */     \
    LEAN(H, dp)               /* d x d_pred                                       positions */     \
    LEAN(J, dn)               /* d x n                                            positions */     \
    LEAN(kI, v)               /* d                                                positions */     \
    LEAN(M, dd)               /* d x d      body mass matrix                      positions */     \
    LEAN(V, v)                /* d          velocity (8)                         velocities */     \
    LEAN(kII, v)              /* d                                               velocities */     \
    LEAN(h, v)                /* d          gyroscopic force                     velocities */     \
    LEAN(f, v)                /* d          applied and gyroscopic forces            forces */     \
    EVERY(tau, m->nu)         /* n          joint forces                             forces */     \
    LEAN(Mbar, dd)            /* d x d      (17a)                                  backward */     \
    LEAN(W, dd)               /* d x d      size of the rounding errors in Mbar    backward */     \
    FULL(unsure, m->size.dd)  /* d x d      the same after twofold precision       backward */     \
    LEAN(fbar, v)             /* d          (17b)                                  backward */     \
    LEAN(D, nn)               /* n x n      J^T Mbar J                             backward */     \
    LEAN(Dinv, nn)            /* n x n      its pseudo-inverse                     backward */     \
    LEAN(X, nn)               /* n x n      eigenvectors of S D S, range first     backward */     \
    LEAN(s, rates)            /* n          S = diag(s)                            backward */     \
    LEAN(lambda, rates)       /* n          eigenvalues of S D S, descending       backward */     \
    LEAN(judged, rates)       /* n          those with S of W                      backward */     \
    LEAN(U, dg)               /* d x n      Mbar J                                 backward */     \
    LEAN(G, dg)               /* d x n      Mbar J D^+                             backward */     \
    LEAN(e, rates)            /* n          tau - J^T (fbar + Mbar kII)            backward */     \
    LEAN(rotated, bodies)     /* 1          moments of inertia that were rotated   backward */     \
    LEAN(scale, bodies)       /* 1          largest entry of diag(J^T W J)         backward */     \
    LEAN(A, v)                /* d          acceleration (9), its known part        inverse */     \
    LEAN(Az, v)               /* d          part of null accelerations              forward */     \
    LEAN(mu, v)               /* d          joint reaction                          inverse */     \
    EVERY(vec, m->nu)         /* n          null accelerations                      forward */     \
    LEAN(Hdot, dp)            /* d x d_pred rate of H along the motion                rates */     \
    LEAN(Jdot, dn)            /* d x n      rate of J                                 rates */     \
    LEAN(Mdot, dd)            /* d x d      rate of M                                 rates */     \
    FULL(qdot, m->nq)         /* nq         q' = G u, as the caller's q               rates */     \
    EVERY(udot, m->nu)        /* n          u' in the order of the sweeps   inverse, forward */    \
    EVERY(out, m->nu)         /* n          a result in that order          inverse, forward */    \
    FULL(q_base, m->nq)       /* nq         the caller's q while displaced            rates */     \
    FULL(u_base, m->nu)       /* nu         the caller's u, likewise                  rates */     \
    FULL(q_moved, m->nq)      /* nq         the displaced q                           rates */     \
    EVERY(displaced, m->most.displaced) /* q, q', pose of the predecessor, its rate     rates */ \
    LEAN(imp, v)              /* d          joint impulse m                        momentum */     \
    LEAN(sigma, v)            /* d          its rate but for the reaction          momentum */     \
    LEAN(impbar, v)           /* d          (17b) for momenta                      momentum */     \
    LEAN(ep, rates)           /* n          p - J^T (impbar + Mbar kI)             momentum */     \
    EVERY(w, m->nu)           /* n          index-1 velocities before X              index1 */     \
    FULL(Y, m->size.v)        /* d          Vz' - Az                                 index1 */     \
    FULL(Mbardot, m->size.dd) /* d x d      rate of Mbar                             index1 */     \
    FULL(Gdot, m->size.dg)    /* d x n      rate of G                                index1 */     \
    FULL(Xdot, m->size.nn)    /* n x n      rate of X                                index1 */     \
    FULL(s_frame, m->nu)      /* n          S of the reference                        frame */     \
    FULL(X_frame, m->size.nn) /* n x n      X of the reference                        frame */     \
    EVERY(u_given, m->nu)     /* nu         the caller's u, found from v             index1 */     \
    FULL(v_given, m->nu)      /* nu         the caller's v                           index1 */     \
    EVERY(q_last, m->nq)      /* nq         the caller's q, evaluation pending       sweeps */     \
    EVERY(u_last, m->nu)      /* nu         u                                        sweeps */     \
    EVERY(load_last, m->nu)   /* nu         tau, or for inverse dynamics u'          sweeps */     \
    EVERY(sincos, sincos_size(m)) /* 2 a coordinate                                  sweeps */     \
    FULL(closure_C, m->size_c) /* rows x columns  of each closure                  closures */     \
    FULL(closure_q, m->most.columns) /* coordinates displaced                       closures */    \
    FULL(closure_D, (size_t)MBSR_CLOSURE_ROWS * (size_t)m->most.columns) /* C there closures */    \
    FULL(closure_w, m->nu)    /* n          a vector over the joints              closures */     \
    FULL(closure_V, m->size.v) /* d         and over the bodies                   closures */     \
    FULL(closure_x, 2 * (size_t)m->most.columns + 4 * (size_t)m->rows) /* scratch   closures */    \
    FULL(loop_lambda, m->rows) /* m          loop forces                           closures */     \
    FULL(loop_eta, m->rows)   /* m          Eta' of position rows                  closures */     \
    FULL(udot_last, m->nu)    /* nu         u' that was found                       sweeps */     \
    FULL(loop_store, loop_store_size(m)) /* see sweeps/loops.h                      sweeps */     \
    EVERY(scratch, has_steps(m, lean) ? scratch_size(m) : 0)
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
    MBSRI_PENDING_INVERSE,
    MBSRI_PENDING_MOTION /* accelerations known: forces, and what belongs to udot_last */
} mbsri_pending;

/* State and scratch of the sweeps in vector code (sweeps/tree.h). */
typedef struct mbsri_sweep_memory {
    struct mbsri_sweep_state *state; /* N + 1 */
    struct mbsri_sweep_multi *multi; /* of each joint of other than one axis */
    struct mbsri_carry *stack, *noise;
    struct mbsri_flow *flows;
    struct mbsri_sweep_load *load; /* N + 1; none where no element acts on a body */
} mbsri_sweep_memory;

struct mbsr_data {
    const mbsr_model *model;
    bool lean;       /* whether arrays are left out, or do not have all bodies */
    bool owned;      /* whether the block is from the model's allocator */
    mbsr_model *own; /* the model, where it is the data's; else NULL */
    mbsr_allocator allocator;
    mbsr_error error;
    mbsri_stage stage;
    mbsri_pending pending; /* evaluation by the sweeps whose stages have not run yet */
    double t;
    int *rank; /* N + 1: rank of each joint block */
    int total_rank;
    int *pivots;            /* most.d: order of pivots of one block */
    bool *carries;          /* N + 1: whether Az of the body may differ from zero */
    bool *apart;            /* N + 1: whether the joints of the group of this head are such */
    bool single;            /* whether every joint is a group of its own (group.h) */
    const double *armature; /* nu, as in the sweeps: in place of that of joints; or NULL */
    bool accelerated;       /* whether A and mu are those of given joint accelerations */
    bool keep_scale; /* whether joint blocks keep the S they have, but for groups taken apart */
    bool exactly;    /* whether masses are in twofold precision where it is not needed, too */
    mbsri_two *exact_work; /* scratch of recursion/exact.c */
    bool lambda_known;     /* whether loop_lambda are the loop forces of the velocities here */
    bool *dropped;         /* m->rows: whether a row of the closures is redundant, and left out */
    struct {
        void *memory; /* memory of one elimination (fronts/fronts.h) */
        bool taken;   /* whether it is in use */
    } fronts;
    struct {
        int *rank;   /* N + 1: ranks expected, where `active` */
        bool active; /* whether another rank than expected ends mbsri_backward */
    } watch;
    struct {
        int *rank;        /* N + 1: ranks of the reference of the index-1 form */
        bool known;       /* whether there is such a reference */
        bool used;        /* whether joint blocks are scaled by the S of the reference */
        double alignment; /* cosine of the largest angle to the reference */
    } frame;
    struct {
        bool allowed; /* whether blocks of flexible bodies may be in factors at present */
        int *rows;    /* N + 1: rows of V (recursion/flexible_factors.c); -1: block in one piece */
    } factors;
    struct {
        bool *off;               /* whether a force element is off, in the order of the sweeps */
        mbsr_force_body *bodies; /* most.element_bodies */
        char *text;              /* what the element that was called last says of its status */
        unsigned char *memory;   /* elements.memory: bytes that elements want of their own */
        int (*pairs)[2];         /* most.pairs: of the element by pairs that was asked last */
    } element;
    mbsri_sweep_memory sweep;
    struct mbsr_split *split; /* the tree for several threads (sweeps/split.h), or NULL */
#define MBSRI_DECLARE(name, length) double *name;
    MBSRI_DATA_ARRAYS(MBSRI_DECLARE, MBSRI_DECLARE, MBSRI_DECLARE)
#undef MBSRI_DECLARE
};

#endif
