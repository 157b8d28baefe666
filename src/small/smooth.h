/* Consistent states of the reduced model on the slow motion.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_SMALL_SMOOTH_H
#define MBSRI_SMALL_SMOOTH_H

#include "small/record.h"

/* The consistent state y, yp of the reduced model near (q, u) at t, under the loads that are set;
 * in lightly damped directions (slow.h) that of the slow motion. */
int mbsri_small_settle(mbsr_small_masses *s, double t, const double *q, const double *u, double *y,
                       double *yp);

/* The same at from + h, on the slow motion through the start s->y, s->yp; with the derivatives of
 * its rates in lightly damped directions. */
int mbsri_small_beside(mbsr_small_masses *s, double h, double *y, double *yp);

/* u (nu), or u' with derivative 1, with those of lightly damped directions as they are on the slow
 * motion at t. */
void mbsri_small_impose(mbsr_small_masses *s, double t, int derivative, double *u);

#endif
