/* modelDescription.xml.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FMU_DESCRIBE_H
#define MBSRI_FMU_DESCRIBE_H

#include "files/write_text.h"
#include "fmu/sources.h"
#include "fmu/variables.h"

/* What is described. */
typedef struct mbsri_described {
    const mbsri_unit_plan *plan;
    const mbsr_model *model; /* model of the plan */
    const mbsri_variables *variables;
    const char *identifier, *token;
    int kinds;
    double stop_time, step_size;
    const mbsri_unit_sources *sources; /* count 0: none */
} mbsri_described;

/* By FMI 2.0 and 3.0. */
void mbsri_describe2(mbsri_text *t, const mbsri_described *d);
void mbsri_describe3(mbsri_text *t, const mbsri_described *d);

/* ---- what both have ---- */

/* <UnitDefinitions>, <LogCategories>, <DefaultExperiment>. */
void mbsri_describe_common(mbsri_text *t, const mbsri_described *d);

bool mbsri_is_output(const mbsri_variable *v);
bool mbsri_is_derivative(const mbsri_variable *v);
bool mbsri_has_start(const mbsri_variable *v);

/* Whether it is unknown in initialization mode: outputs, states and their derivatives. */
bool mbsri_is_initial_unknown(const mbsri_variable *v);

/* "parameter", "input", ...; */
const char *mbsri_causality(const mbsri_variable *v);

/* Attributes unit and displayUnit: degrees for angles. */
void mbsri_put_unit(mbsri_text *t, const mbsri_variable *v);

/* Attributes dependencies and dependenciesKind of an output, with numbers of variables from `first`
 * on; none where it may depend on all. */
void mbsri_put_dependencies(mbsri_text *t, const mbsri_described *d, const mbsri_variable *v,
                            int first);

#endif
