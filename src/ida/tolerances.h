/* Tolerances and norms of the driver.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_IDA_TOLERANCES_H
#define MBSRI_IDA_TOLERANCES_H

#include "ida/record.h"

/* Absolute tolerances that the options say, and from the data at mbsr_stage_backward those of what
 * stands beside q and u: errors that atol in a velocity makes, momenta with the mass on their
 * joint, index-1 velocities with its square root. What has no scales there, without memory say, is
 * refused. */
void mbsri_ida_set_tolerances(mbsr_ida *ida);
int mbsri_ida_scale_tolerances(mbsr_ida *ida);

/* Tolerance of entry k at y, and IDA's weights, its reciprocals. A momentum is tested with the
 * error it makes in its joint's velocity: mass (rtol |u| + atol). */
double mbsri_ida_tolerance(const mbsr_ida *ida, const double *y, int k);
int mbsri_ida_weights(N_Vector y, N_Vector weight, void *user);

/* Norm of the first n entries of x as in IDA's error test. */
double mbsri_ida_norm(const mbsr_ida *ida, int n, const double *x);

/* Vectors cloned from v measure by the largest entry where IDA calls for a root mean square. */
void mbsri_ida_use_max_norm(N_Vector v);

#endif
