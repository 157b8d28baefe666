/* Impulses by which joint rates keep the values that they are given in a consistent start.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_KEPT_RATES_H
#define MBSRI_KEPT_RATES_H

#include "recursion/data.h"

/* A consistent state of the momentum form, and what it lacks. */
typedef struct mbsri_kept_rates {
    double t;
    const double *y, *yp; /* of the momentum form */
    int count;            /* rates that are kept */
    const int *rate;      /* their places in u */
    const double *wanted; /* count: what they are to be */
    double *missing;      /* count: what they lack of that */
    double speed;         /* 1/s: how fast the model moves */
    double *size;         /* count: of what is added up in them; of changes too, afterwards */
} mbsri_kept_rates;

/* Adds to the velocities `tried` (nu) that the start began with what impulses of motors at these
 * joints make of them, so that a start from there has what is missing. MBSR_LOOP_OPEN or
 * MBSR_NO_CONVERGENCE, with joint and closure in the text, where no impulses do that. Ranks are not
 * watched; stages of the data are lost. */
int mbsri_kept_rates_push(const mbsr_model *m, mbsr_data *d, const mbsri_kept_rates *k,
                          double *tried);

#endif
