/* The model of a plan, and what its functions of time read.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FMU_BUILD_H
#define MBSRI_FMU_BUILD_H

#include "fmu/plan.h"

#include <mbsrank/parameters.h>

/* A motion that follows the importer's numbers x, x', x'' of time t0, each coordinate by x + x' s +
 * x'' s^2 / 2, s = t - t0. */
typedef struct mbsri_held_motion {
    int count;
    const double *value; /* three numbers a coordinate */
    const double *t0;
} mbsri_held_motion;

/* A model with all that it uses. */
typedef struct mbsri_built {
    mbsr_model *model;     /* finished */
    mbsr_parameters *list; /* its parameters as the plan has them */
    int tables, flexes, objects;
    mbsr_table **table;
    mbsr_flex **flex;
    mbsr_contacts **contacts; /* as many as objects */
    mbsri_held_motion *motion;
} mbsri_built;

/* Builds it from the plan as it stands, in memory of its own. input: the plan's inputs, read in
 * every evaluation; t0: when those of each motion were set. On failure nothing is left of it, and
 * *error (not NULL) names the part. Statuses of mbsr_model_add_body and the like. */
int mbsri_build(const mbsri_unit_plan *plan, const double *input, const double *t0,
                mbsri_built *built, mbsr_error *error);
void mbsri_built_destroy(mbsri_built *built);

#endif
