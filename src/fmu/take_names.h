/* What an importer sees of a model: names and start of its coordinates, sites.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FMU_TAKE_NAMES_H
#define MBSRI_FMU_TAKE_NAMES_H

#include "fmu/plan.h"

/* Adds them to a plan that has the parts. MBSR_ERR_NO_MEMORY, MBSR_ERR_VALUE (a site, a start that
 * is not finite). */
int mbsri_take_names(mbsri_unit_plan *plan, const mbsr_model *model, const mbsr_fmu_opt *opt,
                     mbsr_error *error);

#endif
