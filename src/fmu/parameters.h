/* The numbers of a plan that an importer may change before a run.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FMU_PARAMETERS_H
#define MBSRI_FMU_PARAMETERS_H

#include "fmu/plan.h"
#include "fmu/variable.h"

/* Adds them to a list of mbsri_variable. False: no memory. */
bool mbsri_list_parameters(mbsri_plan *plan, mbsri_list *list);

#endif
