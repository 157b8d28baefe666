/* One stage of a step: Newton's method, bounded.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_STEPPER_STAGE_H
#define MBSRI_STEPPER_STAGE_H

#include "stepper/record.h"

typedef struct mbsri_stage_task {
    double t, h, c;  /* s: its time, the length of its substep; 1/s: K = c (Y - base) */
    int corrections; /* most */
    double enough;   /* what the last of these may be */
} mbsri_stage_task;

/* Solves F(t, Y, K) = 0 from a guess in s->Y; Y and K are the result. MBSR_NO_CONVERGENCE, and
 * the statuses of the residual and of the Newton solver, with the text in s->cause. */
int mbsri_stepper_stage(mbsr_stepper *s, const mbsri_stage_task *task);

#endif
