/* Forward and inverse dynamics of one tree at several states side by side.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The recursion and the certificate of the sweeps with every number a vector over the states. A
 * joint of several axes is taken apart into one body for each step, without inertia but the last;
 * this is the elimination of the columns of its block one after the other. */
#ifndef MBSRI_BATCH_RECORD_H
#define MBSRI_BATCH_RECORD_H

#include "sweeps/tree.h"

#include <mbsrank/batch.h>
#include <mbsrank/threads.h>

/* More flags of a body. */
enum {
    MBSRI_BALL = 1024,   /* its joint is a quaternion */
    MBSRI_HERE = 2048,   /* its origin is its predecessor's */
    MBSRI_MOVED = 4096,  /* its coordinate is prescribed: q counts these, n = 0 */
    MBSRI_SEEN = 262144, /* and moved by the lanes: see seen.h */
    MBSRI_HINGE =
        4194304, /* a joint that turns by a coordinate without armature, and nothing more */
    MBSRI_TWISTED = 8388608, /* beta and alpha, see below, are not zero */
    MBSRI_TILTED = 67108864
};

/* Constants of a body. Its frame stands on the predecessor's as in the theory of mechanisms, z
 * along the joint's axis,
 *
 *   R_pred^T R = Rz(beta) Rx(alpha) Rz(theta),   theta = q + offset where the joint turns
 *
 * Turning is a rotation by two numbers each time (McMillan and Orin, Efficient computation of
 * articulated-body inertias using successive axial screws, 1995). Frames are chosen so that beta is
 * zero for the first successor of a body that turns, and theta where the joint does not turn
 * (frames.c). */
typedef struct mbsri_batch_body {
    double twist[5]; /* cos, sin, cos^2, sin^2, sin cos of beta */
    double tilt[5];  /* cosine and sine of alpha, and products of them */
    double base[2];  /* cos, sin of the offset */
    double offset;
    double
        own[2];  /* cos, sin of the angle about z from the frame of mbsri_sweep_body to this one */
    double x[3]; /* its origin in the predecessor's frame, m */
    double I[6]; /* inertia tensor about its origin: xx, yy, zz, xy, xz, yz */
    double c[3], mass;                    /* first moment, kg m; mass, kg */
    double normal[3];                     /* LEVEL: 1 where an axis is the plane's normal, else 0 */
    double pitch, soft, spread, armature; /* as those of mbsri_sweep_body */
    int parent, flags, q, u, n;
} mbsri_batch_body;

/* What an evaluation of a group of states works on. Vectors over the states: as many numbers as
 * the kernels have lanes. */
typedef struct mbsri_batch_run {
    const mbsri_batch_body *body; /* bodies + 1, the root first */
    int bodies;
    double area, per_area; /* L^2 and its inverse */
    mbsri_rank_rule rule;
    double R[9], omega[3];      /* rotation and angular velocity of the root */
    double A[6];                /* its acceleration, gravity taken away */
    double r[4], v[3];          /* its origin and angle, and velocity */
    double *drive;              /* prescribed coordinates, their first and second derivatives */
    const double *q, *u, *load; /* lanes x nq, nu, nu in the order of the sweeps; load: joint
                                 * forces, for inverse dynamics u' */
    double *out;                /* lanes x nu: u', or joint forces */
    /* bodies + 1 each, balls, depth, of the sizes that the kernels say */
    void *state, *motion, *ball, *stack;
    /* of trees with bodies in the sweeps; else NULL */
    mbsri_sweep_run *lane; /* as many as lanes: the same states one by one */
    const int *origin;     /* bodies + 1: the model's body of which it is the last part */
    void *place;           /* bodies + 1, likewise */
    int count;             /* lanes with states */
    unsigned served;       /* bit k: state k is served so far */
} mbsri_batch_run;

/* The sweeps, compiled once for every kind of processor. Results are sets of states, bit by bit. */
typedef struct mbsri_batch_kernels {
    const char *name;
    int lanes;
    size_t state_size, motion_size, ball_size, stack_size, place_size;
    /* n numbers of each of `count` states into the lanes, those without a state as the last one;
     * place: where the caller's k-th stands in the order of the sweeps, NULL: k. Which are finite.
     */
    unsigned (*gather)(int n, const int *place, int count, const double *from, double *to);
    unsigned (*scatter)(int n, const int *place, int count, const double *from, double *to);
    /* Which states are served: forward dynamics leaves out those with a joint whose rank is not
     * clearly full. */
    unsigned (*forward)(mbsri_batch_run *run);
    unsigned (*inverse)(mbsri_batch_run *run);
    /* With bodies in the sweeps: the motion comes first, then the forces of elements on the bodies,
     * which go to the runs of the lanes. */
    unsigned (*move_seen)(mbsri_batch_run *run);
    unsigned (*forward_seen)(mbsri_batch_run *run);
    unsigned (*inverse_seen)(mbsri_batch_run *run);
} mbsri_batch_kernels;

extern const mbsri_batch_kernels mbsri_batch_base;
#if defined(MBSR_WITH_V3)
extern const mbsri_batch_kernels mbsri_batch_v3;
#endif
#if defined(MBSR_WITH_V4)
extern const mbsri_batch_kernels mbsri_batch_v4;
#endif

struct mbsr_batch {
    const mbsr_model *model;
    const mbsri_batch_kernels *kernels; /* code of the lanes; NULL: all states go one by one */
    mbsr_data *data;                    /* data of states that go one by one */
    mbsr_error error;
    int failed, single; /* first state of the last call that failed; states that went one by one */
    mbsri_batch_run run;
    mbsri_batch_body *body; /* the run's bodies, writable */
    double *q, *u, *load;
    int *q_place,
        *u_place; /* where the caller's coordinates stand in the order of the sweeps, or NULL */
    int *origin;
    mbsr_allocator allocator;
    void *block; /* where all of this was allocated */
    int result;  /* status of the last call, or of this share of it */
    /* of a batch whose calls are shared out: */
    mbsr_parallel parallel;
    int shares;         /* 1: they are not */
    mbsr_batch **share; /* the first is the batch itself */
};

#endif
