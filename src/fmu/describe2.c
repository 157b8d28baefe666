/* modelDescription.xml by FMI 2.0: see describe.h. Variables are numbered from 1 on in its
 * structure, value references from 0.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fmu/describe.h"

#include <math.h>

static void put_sources(mbsri_text *t, const mbsri_unit_sources *sources)
{
    mbsri_begin(t, "SourceFiles");
    mbsri_into(t);
    for (int k = 0; k < sources->count; ++k) {
        const char *name = mbsri_source_name(sources->file + k);
        if (!name) continue;
        mbsri_begin(t, "File");
        mbsri_set_text(t, "name", name);
        mbsri_end(t);
    }
    mbsri_out(t, "SourceFiles");
}

static void put_interface(mbsri_text *t, const mbsri_described *d, bool exchange)
{
    const char *element = exchange ? "ModelExchange" : "CoSimulation";
    mbsri_begin(t, element);
    mbsri_set_text(t, "modelIdentifier", d->identifier);
    if (exchange)
        mbsri_set_text(t, "completedIntegratorStepNotNeeded", "true");
    else
        mbsri_set_text(t, "canHandleVariableCommunicationStepSize", "true");
    mbsri_set_text(t, "canNotUseMemoryManagementFunctions", "true");
    mbsri_set_text(t, "canGetAndSetFMUstate", "true");
    mbsri_set_text(t, "canSerializeFMUstate", "true");
    mbsri_set_text(t, "providesDirectionalDerivative", "true");
    if (d->sources->count == 0) {
        mbsri_end(t);
        return;
    }
    mbsri_into(t);
    put_sources(t, d->sources);
    mbsri_out(t, element);
}

static const char *initial_of(const mbsri_variable *v)
{
    if (v->kind == MBSRI_PARAMETER) return "exact";
    if (v->kind == MBSRI_TIME || v->kind == MBSRI_INPUT) return "";
    return mbsri_has_start(v) ? "approx" : "calculated";
}

static void put_variable(mbsri_text *t, const mbsri_described *d, int k)
{
    const mbsri_variable *v = d->variables->list + k;
    mbsri_begin(t, "ScalarVariable");
    mbsri_set_text(t, "name", v->name);
    mbsri_set_number(t, "valueReference", k);
    mbsri_set_text(t, "description", v->description);
    mbsri_set_text(t, "causality", mbsri_causality(v));
    mbsri_set_text(t, "variability", v->kind == MBSRI_PARAMETER ? "fixed" : "continuous");
    mbsri_set_text(t, "initial", initial_of(v));
    mbsri_into(t);
    mbsri_begin(t, "Real");
    mbsri_put_unit(t, v);
    if (v->kind == MBSRI_INPUT) {
        const double *range = d->plan->input[v->of].range;
        if (isfinite(range[0]) && v->start >= range[0]) mbsri_set_number(t, "min", range[0]);
        if (isfinite(range[1]) && v->start <= range[1]) mbsri_set_number(t, "max", range[1]);
    }
    if (mbsri_has_start(v)) mbsri_set_number(t, "start", v->start);
    if (mbsri_is_derivative(v)) mbsri_set_number(t, "derivative", v->derivative_of + 1);
    mbsri_end(t);
    mbsri_out(t, "ScalarVariable");
}

/* <Outputs>, <Derivatives> or <InitialUnknowns>: all variables for which `is` holds. */
static void put_unknowns(mbsri_text *t, const mbsri_described *d, const char *name,
                         bool (*is)(const mbsri_variable *v), bool dependencies)
{
    const mbsri_variables *all = d->variables;
    int count = 0;
    for (int k = 0; k < all->count; ++k) count += is(all->list + k);
    if (count == 0) return;
    mbsri_begin(t, name);
    mbsri_into(t);
    for (int k = 0; k < all->count; ++k) {
        if (!is(all->list + k)) continue;
        mbsri_begin(t, "Unknown");
        mbsri_set_number(t, "index", k + 1);
        if (dependencies) mbsri_put_dependencies(t, d, all->list + k, 1);
        mbsri_end(t);
    }
    mbsri_out(t, name);
}

void mbsri_describe2(mbsri_text *t, const mbsri_described *d)
{
    static const char head[] = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
    mbsri_put(t, head, sizeof head - 1);
    mbsri_begin(t, "fmiModelDescription");
    mbsri_set_text(t, "fmiVersion", "2.0");
    mbsri_set_text(t, "modelName", d->plan->name);
    mbsri_set_text(t, "guid", d->token);
    mbsri_set_text(t, "generationTool", "mbsrank");
    mbsri_set_text(t, "variableNamingConvention", "structured");
    mbsri_set_number(t, "numberOfEventIndicators",
                     d->kinds & MBSR_FMU_MODEL_EXCHANGE ? d->variables->indicators : 0);
    mbsri_into(t);
    if (d->kinds & MBSR_FMU_MODEL_EXCHANGE) put_interface(t, d, true);
    if (d->kinds & MBSR_FMU_CO_SIMULATION) put_interface(t, d, false);
    mbsri_describe_common(t, d);
    mbsri_begin(t, "ModelVariables");
    mbsri_into(t);
    for (int k = 0; k < d->variables->count; ++k) put_variable(t, d, k);
    mbsri_out(t, "ModelVariables");
    mbsri_begin(t, "ModelStructure");
    mbsri_into(t);
    put_unknowns(t, d, "Outputs", mbsri_is_output, true);
    put_unknowns(t, d, "Derivatives", mbsri_is_derivative, false);
    put_unknowns(t, d, "InitialUnknowns", mbsri_is_initial_unknown, false);
    mbsri_out(t, "ModelStructure");
    mbsri_out(t, "fmiModelDescription");
}
