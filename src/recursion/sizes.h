/* Sizes of what is added up to forces, before anything cancels: the scale of the rounding errors in
 * them.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_SIZES_H
#define MBSRI_SIZES_H

#include "recursion/data.h"

/* Of fbar + Mbar kII of every body, into Az of the data. At the state of mbsri_backward; the loads
 * may be newer. */
void mbsri_gross_forces(const mbsr_model *m, mbsr_data *d);

/* After mbsri_gross_forces: of e = tau - J^T (fbar + Mbar kII) of body i along x (n). */
double mbsri_gross_load(const mbsr_model *m, const mbsr_data *d, int i, const double *x);

#endif
