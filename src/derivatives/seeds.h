/* Parameters that derivatives are asked for: their choice, and products with their seeds.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_DERIVATIVES_SEEDS_H
#define MBSRI_DERIVATIVES_SEEDS_H

#include "derivatives/seed_values.h"

/* Chooses parameters which[k] of the list, which is of this model or of one with other values, for
 * `use`: of the sweeps > 0, frames of joints at the index of their body. Memory is the model's
 * allocator's. A status; *s is empty then. */
int mbsri_seeds_create(mbsri_seeds *s, const mbsri_linear *l, int use, const mbsr_parameters *list,
                       int count, const int *which, const char *function, mbsr_error *error);
void mbsri_seeds_destroy(mbsri_seeds *s, const mbsr_model *m);

/* mbsri_seed_values of all. */
int mbsri_seeds_find(mbsri_seeds *s, const mbsri_linear *l, mbsr_data *d);

/* sum: that of all seeds times theta (count). */
void mbsri_seeds_along(mbsri_seeds *s, const double *theta);

/* `by`: their products with gradients, vectors of each place. */
void mbsri_seeds_back(mbsri_seeds *s, const double *const gradient[MBSRI_SEED_PLACES]);

#endif
