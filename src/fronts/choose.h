/* The cheapest of several orders of elimination.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FRONTS_CHOOSE_H
#define MBSRI_FRONTS_CHOOSE_H

#include "fronts/plan.h"

/* `far`: orders that take motions of far ends into borders are among them. Only where all joints
 * have inertia: what is left of a joint's inertia by rows eliminated so is zero but for rounding
 * along motions without mass. False: there is no memory. */
bool mbsri_plan_create(const mbsr_model *m, bool far, mbsri_plan **plan);
void mbsri_plan_destroy(const mbsr_model *m, mbsri_plan *plan);

#endif
