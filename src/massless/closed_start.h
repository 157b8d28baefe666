/* A consistent start from closed positions, by Newton systems.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_CLOSED_START_H
#define MBSRI_CLOSED_START_H

#include "massless/start.h"

/* What starts of one model need. */
typedef struct mbsri_closed_start {
    const mbsr_model *m;
    mbsr_data *d;
    mbsr_completion *completion;
    mbsri_start search;
    double *q, *u;  /* nq, nu: a state that one begins with */
    double *length; /* rows: what their velocities are compared with (algebra/pivots.h) */
} mbsri_closed_start;

/* Statuses of mbsr_completion_create, reported in d. */
int mbsri_closed_start_open(mbsri_closed_start *s, const mbsr_model *m, mbsr_data *d);
void mbsri_closed_start_close(mbsri_closed_start *s);

/* From positions q, closed but for offset (position rows; NULL: none) without the rows that the
 * data leaves out, and velocities u: u changes by impulses of the loops, and where directions move
 * no mass until forces along them balance, q too where springs alone hold some; u' (nu) and loop
 * forces lambda (rows; of springs zero), at first those that act at q, u. Statuses of
 * mbsr_dae_consistent, reported in d; MBSR_LOOP_OPEN where rows contradict each other. */
int mbsri_closed_start_find(mbsri_closed_start *s, double t, const double *offset, double *q,
                            double *u, double *udot, double *lambda, const mbsr_consistent_opt *opt,
                            mbsr_consistent_info *info);

#endif
