/* Oscillations about a state.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSR_WEB_MODES_H
#define MBSR_WEB_MODES_H

#include <mbsrank/dae.h>

/* Of the linear equations about the consistent state near q and u those modes exp(s t) that swing:
 * real and imaginary part of s (1/s), slowest first, `count` pairs of numbers that the caller
 * frees. A status, with its text in *error. Of models with 400 coordinates and momenta at most:
 * their cube is what it costs. */
int web_find_modes(const mbsr_model *model, mbsr_data *data, double t, const double *q,
                   const double *u, double **found, int *count, mbsr_error *error);

#endif
