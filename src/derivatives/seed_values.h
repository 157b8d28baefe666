/* Values of seeds at a state.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_DERIVATIVES_SEED_VALUES_H
#define MBSRI_DERIVATIVES_SEED_VALUES_H

#include "derivatives/seeds.h"

/* Of one parameter, as mbsri_seeds_find. */
int mbsri_seed_values(mbsri_seeds *s, const mbsri_seeded *p, const mbsri_linear *l, mbsr_data *d);

/* Whether body j moves along where a frame of the joint of body i is moved, by another way than
 * with its predecessor: i itself, or what stands rigidly on an i that is welded. By index. */
bool mbsri_rides(const mbsr_model *m, int i, int j);

/* Which free rate coordinate k of a joint is, as it was given; -1: it is locked. */
int mbsri_rate_as_given(const mbsri_body *b, int k);

#endif
