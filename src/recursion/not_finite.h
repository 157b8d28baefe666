/* The search for the first quantity that is not finite.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_NOT_FINITE_H
#define MBSRI_NOT_FINITE_H

#include "recursion/data.h"

/* MBSR_NOT_FINITE with a text that names the first quantity along the evaluation that is not
 * finite, or else the function, or the body, whose result overflowed. */
int mbsri_report_not_finite(const mbsr_model *m, mbsr_data *d, const char *function);

/* The same unless the result x (n numbers) is finite: MBSR_OK. */
int mbsri_check_result(const mbsr_model *m, mbsr_data *d, size_t n, const double *x,
                       const char *function);

/* MBSR_NOT_FINITE unless what the caller passed as `name`, x (n numbers), is finite. */
int mbsri_check_input(mbsr_data *d, size_t n, const double *x, const char *function,
                      const char *name);

#endif
