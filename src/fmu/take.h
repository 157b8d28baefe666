/* The plan of a model.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FMU_TAKE_H
#define MBSRI_FMU_TAKE_H

#include "fmu/plan.h"

/* Takes a finished model apart into a plan that is open; what it points to is the model's, or in
 * the plan's arena. opt: checked. Statuses of mbsr_fmu_export. */
int mbsri_plan_take(mbsri_unit_plan *plan, const mbsr_model *model, const mbsr_fmu_opt *opt,
                    mbsr_error *error);

#endif
