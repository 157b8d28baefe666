/* What the parts of the test of joints share: joint_check.c compares the functions with positions,
 * joint_check_tangents.c the derivatives with the functions.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_VERIFIER_H
#define MBSRI_VERIFIER_H

#include "base/error.h"

#include <mbsrank/verify.h>

#include <stdbool.h>
#include <stddef.h>

/* A state of the joint and its predecessor, with the pose that follows. */
typedef struct mbsri_place {
    double t, *q, *p_pred, *p;
} mbsri_place;

/* K, H, J (one after the other) and kI. */
typedef struct mbsri_jacobians {
    double *K, *H, *J, *kI;
} mbsri_jacobians;

/* A state with velocities, or its change: q, p_pred, p, u, V_pred, V one after the other. */
typedef struct mbsri_moving {
    mbsri_place at;
    double *u, *V_pred, *V;
} mbsri_moving;

/* All that the functions of a joint write, or its change: p, K, H, J, kI, kII, K', H', J', a vector
 * that is not used, and q', one after the other. */
typedef struct mbsri_written {
    double *p, *kII, *qdot;
    mbsri_jacobians jacobians, rates;
} mbsri_written;

typedef struct mbsri_verifier {
    const mbsr_joint *joint;
    const mbsr_joint_test *at;
    mbsr_joint_errors *errors;
    mbsr_error *error;
    int d, np, n, nq, d_pred, np_pred;
    bool own, pred;           /* whether x' is V of the body, and of the predecessor */
    double speed, h;          /* largest rate of the motion; step in time, s */
    mbsri_place base, on, by; /* the state itself, one on the motion, one beside it */
    struct {
        mbsri_jacobians given, passing; /* as written at `base` and at `on` */
        mbsri_jacobians truth, slope;   /* by differences */
        double *row;                    /* d: largest entry of K, H, J in each row */
    } jacobians;
    double *unit;        /* one rate is 1 */
    double *x;           /* 4 d: samples of one difference */
    double *V, *A, *kII; /* d */
    double *V_pred;      /* d_pred: the caller's, or zero where the predecessor has none */
    double *qdot, *flow; /* nq, 2 nq */
    struct {
        double *K, *work; /* d x d, 4 d: K^-1, where V is from (8) */
        int pivots[MBSR_MAX_D];
    } inverse;
    struct {
        mbsri_moving state, change; /* a state beside `base`, the direction */
        mbsri_written sample;       /* what is written there */
        mbsri_written expected;     /* its slope by differences */
        mbsri_written given;        /* its slope as the table gives it */
        double *scale;              /* nq: length of the directions of q */
        double *row;                /* d: largest entry of K^-1 (K, H, J) in each row */
    } tangents;                     /* of joint_check_tangents.c */
} mbsri_verifier;

static inline bool mbsri_verifier_unit_K(const mbsri_verifier *w)
{
    return (w->joint->table->flags & MBSR_JOINT_UNIT_K) != 0;
}

/* The arguments at a state; u, V_pred and V may be NULL. */
mbsr_joint_args mbsri_verifier_args(const mbsri_verifier *w, const mbsri_place *at, const double *u,
                                    const double *V_pred, const double *V);

/* The status of a function and whether what it wrote, `count` numbers, is finite. */
int mbsri_verifier_settle(mbsri_verifier *w, int status, const char *function, size_t count,
                          const double *x);

/* What the functions of those names write: at->p, *out, and q' = G(q) u into w->qdot. */
int mbsri_verifier_pose(mbsri_verifier *w, mbsri_place *at);
int mbsri_verifier_jacobians(mbsri_verifier *w, const mbsri_place *at, mbsri_jacobians *out);
int mbsri_verifier_qdot(mbsri_verifier *w, const mbsri_place *at, const double *u);

/* V from (8) with K, H, J, kI in `x`. */
int mbsri_verifier_velocity(mbsri_verifier *w, const mbsri_jacobians *x, const double *u,
                            const double *V_pred, double *V);

/* The predecessor's pose p moves on for s seconds with V constant. */
void mbsri_verifier_move(const mbsri_verifier *w, const double *V, double s, double *p);

/* Raises a field to the error found, and with it the largest and its text. */
void mbsri_verifier_note(mbsri_verifier *w, double *field, double value, const char *format, ...)
    MBSRI_FORMAT(4, 5);

/* Raises a field to the largest error of a matrix, and from NaN to 0 where the matrix has columns;
 * rate: what its entries are compared with, beside themselves, times the size of the row. */
void mbsri_verifier_compare(mbsri_verifier *w, double *field, const char *name, int columns,
                            const double *given, const double *expected, double rate);

/* Arrays one after the other in memory (NULL: none yet). */
double *mbsri_verifier_take(double *memory, size_t *used, int rows, int columns);
void mbsri_verifier_lay_out_place(const mbsri_verifier *w, mbsri_place *x, double *memory,
                                  size_t *used);
void mbsri_verifier_lay_out_jacobians(const mbsri_verifier *w, mbsri_jacobians *x, double *memory,
                                      size_t *used);

#endif
