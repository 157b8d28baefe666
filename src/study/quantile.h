/* Quantiles of distributions.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_QUANTILE_H
#define MBSRI_QUANTILE_H

/* z, between 0 and 1, exclusive, of the standard normal distribution. */
double mbsri_normal_quantile(double z);

/* Of Student's with n freedoms, to a hundredth for n >= 3 (expansion of Cornish and Fisher in 1 /
 * n). */
double mbsri_student_quantile(double z, int n);

#endif
