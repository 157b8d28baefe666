/* What the steps of a consistent start share: see tree_start.c.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_START_H
#define MBSRI_START_H

#include "forms/dae.h"
#include "massless/null_space.h"
#include "massless/reduction.h"

#include <mbsrank/dae.h>

#include <float.h>

/* Of gamma, beside the sizes of what was added up to it. */
#define MBSRI_GAMMA_ROUNDING (1e3 * DBL_EPSILON)

enum { MBSRI_HALVINGS = 60 };

typedef struct mbsri_start {
    mbsri_null_space w;
    const mbsri_dae_form *form;
    const mbsr_consistent_opt *opt;
    mbsr_consistent_info info;
    double t;
    int damped;                /* rank of C */
    bool by_rows;              /* it is told by what elements see of the directions (seen.h), */
    int open;                  /* and so is one that is not determined, -1: none */
    bool moved_off;            /* u was moved to where forces change with it */
    double first_defect;       /* the elastic force at the start */
    double *q_given, *u_given; /* nq, nu */
    double *q, *u;             /* nq, nu: the state being improved */
    double *qdot, *udot;       /* nq, nu */
    double *change;            /* nu */
    mbsri_reduction reduced;   /* of C */
    mbsri_reduction rest;      /* of T = B Z, B = Y^T S or slopes of Y^T gamma'' */
    double *left, *left_error; /* k x k: [Yc Y], and what Y may be wrong by */
    double *Z, *Z_error;       /* k x (k - damped): right null vectors of C */
    double *B, *B_error;       /* (k - damped) x k */
    double *sizes;             /* k: of the forces in the null directions at the velocities given */
    double *defect, *weights, *moved, *trial; /* k */
    double *y, *yp;                           /* the result in the form asked for */
    void *memory, *more;
} mbsri_start;

/* Basis, C and S at (q, u); [Yc Y] and the rank of C. Of Yc, unit vectors for the rows of C with a
 * pivot serve: they and Y are independent. */
int mbsri_start_directions(mbsri_start *s);

/* out (k) = [Yc Y]^T x */
void mbsri_start_turn(const mbsri_start *s, const double *x, double *out);

/* Clears numbers from `first` on, `count` of them, of [Yc Y]^T gamma if all of them may be rounding of the
 * springs that hold these directions, where elements tell that. */
void mbsri_start_drop_rounding(const mbsri_start *s, int first, int count, double *turned);

/* B = Y^T S with its errors. */
void mbsri_start_springs(mbsri_start *s);

/* Reduces T = B Z; a column without pivot is a direction that is not determined. */
int mbsri_start_factor(mbsri_start *s, double small);

/* Pivots of x from A x = right, which has numbers for the pivot rows, in their order or (pivots
 * false) for all rows. */
void mbsri_start_back(const mbsri_reduction *r, bool pivots, const double *right, double *x);

/* weights with Yc^T C weights = right, B weights = the rest of right: those of the pivots of C
 * first, then weights of Z. */
void mbsri_start_solve(mbsri_start *s, const double *right);

/* Largest |x| beside typical sizes. */
double mbsri_start_relative(int n, const double *x, const double *scale);

/* sizes (k) of the forces that were added up last, in the null directions. */
void mbsri_start_loads(mbsri_start *s, double *sizes);

/* sizes (k) += what dampers add up to forces inside, where relative velocities are differences: C_lm
 * times the multiple of direction m whose largest rate is `speed` times its typical size. */
void mbsri_start_add_dampers(const mbsri_start *s, double speed, double *sizes);

/* Largest |gamma_l| beside the sizes of the forces, over all l, or those whose rows of C have a
 * pivot. Leaves the sizes in w.force. */
double mbsri_start_imbalance(mbsri_start *s, const double *gamma, bool damped_only);

/* Whether gamma may be nothing but rounding of the positions that springs are stretched between, of the
 * forces added up last, and what rounding leaves of that elsewhere in the tree. Overwrites s->trial. */
bool mbsri_start_relaxed(mbsri_start *s, const double *gamma, bool damped_only);

/* Whether a correction of this size, to a vector of that size, is the last, both beside typical
 * sizes; `near`: from where one counts that does not get smaller. *last: the correction before. */
bool mbsri_start_settled(const mbsri_start *s, double *last, double change, double size,
                         double near);

/* No state found: names the joint at which the largest force is left. */
int mbsri_start_unbalanced(mbsri_start *s, const char *what, const double *gamma);

/* A time in which state and time change by about `share` of their size. */
double mbsri_start_short_time(const mbsri_start *s, double share);

/* gamma' and, unless NULL, gamma'' along q', u', from gamma at the state, of the second and the
 * first order in h: from gamma before and after it, or on one side. */
int mbsri_start_differences(mbsri_start *s, double h, bool accelerated, const double *gamma,
                            double *first, double *second);

/* ---- the steps, one after the other: q, u and at last u' and q' of s ---- */

int mbsri_start_positions(mbsri_start *s);
/* From the velocities given; if no step from there leads on, from rest. */
int mbsri_start_velocities(mbsri_start *s);
int mbsri_start_rates(mbsri_start *s);

#endif
