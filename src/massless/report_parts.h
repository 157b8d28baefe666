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
    double *weights;           /* k x k: found directions as weights of the null directions */
    mbsr_direction_kind *kind; /* k */
    bool *listed;              /* bodies + 1: those of elements that determine a direction */
    int found;
    double *u, *twist, *q_rate; /* nu, size_v, nq: of a found direction */
    double *other;              /* nu */
    double *size;               /* the most of these: scratch of mbsri_null_mix */
    double *sizes;              /* k: scratch */
    double *work;
    int lwork;
    void *memory;
} mbsri_report;

/* Spreads the number of l's component over all directions coupled to it. */
void mbsri_report_mark(mbsri_report *r, int l, int number);

/* u, twist and q_rate of a direction. */
void mbsri_report_combine(mbsri_report *r, const double *weights);

/* Whether an element determines the direction of this kind in u, twist and q_rate. */
int mbsri_report_determines(mbsri_report *r, const mbsri_force *force, mbsr_direction_kind kind,
                            bool *determined);

/* The directions of a component, by kind; writes the conditioning of the report. */
int mbsri_report_classify(mbsri_report *r, int number, mbsr_index_report *report);

/* Everything in one block: report, directions, terms, forces, text. */
int mbsri_report_write(mbsri_report *r, mbsr_index_report result, mbsr_index_report **report);

#endif
