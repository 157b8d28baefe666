/* The cheapest of several orders of elimination.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FRONTS_CHOOSE_H
#define MBSRI_FRONTS_CHOOSE_H

#include "fronts/plan.h"

/* False: there is no memory. */
bool mbsri_plan_create(const mbsr_model *m, mbsri_plan **plan);
void mbsri_plan_destroy(const mbsr_model *m, mbsri_plan *plan);

#endif
