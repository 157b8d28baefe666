/* What the parts of an index report share: see report.c.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_REPORT_PARTS_H
#define MBSRI_REPORT_PARTS_H

#include "massless/null_space.h"
#include "massless/reduction.h"

#include <mbsrank/index.h>

/* Workspace of one report; k null directions, a component has c <= k. */
typedef struct mbsri_report {
    mbsri_null_space w;
    int *component; /* k: number of the component of each direction */
    int *member;    /* k: the directions of the present component */
    mbsri_reduction reduced;
    double *C, *values;        /* c x c, c: scaled C and its singular values */
    double *Y, *Z;             /* c x (c - damped): null vectors of C */
    double *Y_error, *Z_error; /* of the same shape */
    double *x, *sparse;        /* c: a direction as weights of the component's, two choices */
    double *other_x, *span;    /* c: another choice, sizes of the directions */
    double *weights;           /* k x k: found directions as weights of the null directions */
    mbsr_direction_kind *kind; /* k */
    bool *listed;              /* bodies + 1: those of elements that determine a direction */
    bool *determining;         /* force elements: which these are */
    int found;
    double *u, *twist, *q_rate; /* nu, size_v, nq: of a found direction */
    double *other;              /* nu */
    double *size;               /* the most of these: scratch of mbsri_null_mix */
    double *sizes;              /* k: scratch */
    double least;               /* rates below do not count, after mbsri_report_see */
    double *work;
    int lwork;
    void *memory;
} mbsri_report;

/* Spreads the number of l's component over all directions coupled to it. */
void mbsri_report_mark(mbsri_report *r, int l, int number);

/* u, twist and q_rate of a direction, but for rates that do not count. */
void mbsri_report_combine(mbsri_report *r, const double *weights);

/* Notes in `seen` which elements determine the direction of this kind in u, twist and q_rate, and
 * their number in *count: those that see more than rates that do not count, or if none does, any.
 */
int mbsri_report_see(mbsri_report *r, mbsr_direction_kind kind, int *count);

/* The directions of a component, by kind; writes the conditioning of the report. */
int mbsri_report_classify(mbsri_report *r, int number, mbsr_index_report *report);

/* One more direction of the component: x (c). */
void mbsri_report_add(mbsri_report *r, int c, const double *x, mbsr_direction_kind kind);

/* x, or in its stead `sparse` (NULL: none) if that has fewer terms and still names the bodies on
 * which the elements act that determine x. */
int mbsri_report_add_shorter(mbsri_report *r, int c, const double *x, const double *sparse,
                             mbsr_direction_kind kind);

/* N (c x n): directions that the next kind of element does not see, for mbsri_report_choose. */
void mbsri_report_unseen(mbsri_report *r, int c, int n, const double *N);

/* x (c) becomes what it has beside the `shown` directions that this was asked for before, since
 * mbsri_report_unseen, if that is next to nothing: they would look the same in a report. */
void mbsri_report_part(mbsri_report *r, int c, int n, int shown, double *x);

/* x, or in its stead x less its share in the n directions N if that shows more of the elements that
 * determine it, and of the bodies on which these act. */
int mbsri_report_choose(mbsri_report *r, int c, const double *x, int n, mbsr_direction_kind kind);

/* Everything in one block: report, directions, terms, forces, text. */
int mbsri_report_write(mbsri_report *r, mbsr_index_report result, mbsr_index_report **report);

#endif
