/* The search for the first quantity that is not finite.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_NOT_FINITE_H
#define MBSRI_NOT_FINITE_H

#include "recursion/data.h"

/* MBSR_NOT_FINITE with a text that names the first quantity along the evaluation that is not
 * finite. */
int mbsri_report_not_finite(const mbsr_model *m, mbsr_data *d);

#endif
