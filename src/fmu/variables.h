/* The variables of an FMU: the same list for its description and for its run.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A variable's number in the list, from 0 on, is its value reference. The order: time; parameters;
 * inputs; joint coordinates, rates, accelerations; momenta and derivatives of the states (model
 * exchange); sites, forces, reactions, energies; event indicators. */
#ifndef MBSRI_FMU_VARIABLES_H
#define MBSRI_FMU_VARIABLES_H

#include "fmu/build.h"
#include "fmu/variable.h"

typedef struct mbsri_variables {
    mbsri_variable *list;
    int count, parameters;              /* in all; parameters stand from 1 on */
    int inputs_at, q_at, u_at, udot_at; /* numbers of the first ones */
    int p_at, derivatives_at; /* first momentum and first derivative; -1 without model exchange */
    int indicators_at, indicators;
} mbsri_variables;

/* In memory of the plan; `built` of that plan, whose list of parameters is to live as long. False:
 * no memory. */
bool mbsri_list_variables(mbsri_unit_plan *plan, const mbsri_built *built,
                          mbsri_variables *variables);

#endif
