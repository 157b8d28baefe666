/* modelDescription.xml by FMI 3.0: see describe.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fmu/describe.h"

#include <math.h>

static void put_interface(mbsri_text *t, const mbsri_described *d, bool exchange)
{
    const bool fixed = d->plan->steps.fixed_step > 0.0;
    mbsri_begin(t, exchange ? "ModelExchange" : "CoSimulation");
    mbsri_set_text(t, "modelIdentifier", d->identifier);
    mbsri_set_text(t, "canGetAndSetFMUState", "true");
    mbsri_set_text(t, "canSerializeFMUState", "true");
    mbsri_set_text(t, "providesDirectionalDerivatives", "true");
    mbsri_set_text(t, "providesAdjointDerivatives", "true");
    if (!exchange) {
        mbsri_set_text(t, "canHandleVariableCommunicationStepSize", "true");
        mbsri_set_text(t, "providesIntermediateUpdate", "true");
        mbsri_set_text(t, "mightReturnEarlyFromDoStep", "true");
        mbsri_set_text(t, "canReturnEarlyAfterIntermediateUpdate", "true");
        if (!fixed && d->variables->indicators > 0) mbsri_set_text(t, "hasEventMode", "true");
    }
    mbsri_end(t);
}

static void put_variable(mbsri_text *t, const mbsri_described *d, int k)
{
    const mbsri_variable *v = d->variables->list + k;
    const bool given = v->kind == MBSRI_TIME || v->kind == MBSRI_INPUT;
    mbsri_begin(t, "Float64");
    mbsri_set_text(t, "name", v->name);
    mbsri_set_number(t, "valueReference", k);
    mbsri_set_text(t, "description", v->description);
    mbsri_set_text(t, "causality", mbsri_causality(v));
    mbsri_set_text(t, "variability", v->kind == MBSRI_PARAMETER ? "fixed" : "continuous");
    if (!given)
        mbsri_set_text(t, "initial",
                       v->kind == MBSRI_PARAMETER ? "exact"
                       : mbsri_has_start(v)       ? "approx"
                                                  : "calculated");
    if (d->kinds & MBSR_FMU_CO_SIMULATION && (mbsri_is_output(v) || v->kind == MBSRI_INPUT))
        mbsri_set_text(t, "intermediateUpdate", "true");
    mbsri_put_unit(t, v);
    if (v->kind == MBSRI_INPUT) {
        const double *range = d->plan->input[v->of].range;
        if (isfinite(range[0]) && v->start >= range[0]) mbsri_set_number(t, "min", range[0]);
        if (isfinite(range[1]) && v->start <= range[1]) mbsri_set_number(t, "max", range[1]);
    }
    if (mbsri_has_start(v)) mbsri_set_number(t, "start", v->start);
    if (mbsri_is_derivative(v)) mbsri_set_number(t, "derivative", v->derivative_of);
    mbsri_end(t);
}

static bool is_indicator(const mbsri_variable *v)
{
    return v->kind == MBSRI_INDICATOR;
}

/* An element of the structure for each variable for which `is` holds. */
static void put_all(mbsri_text *t, const mbsri_described *d, const char *name,
                    bool (*is)(const mbsri_variable *v), bool dependencies)
{
    for (int k = 0; k < d->variables->count; ++k) {
        if (!is(d->variables->list + k)) continue;
        mbsri_begin(t, name);
        mbsri_set_number(t, "valueReference", k);
        if (dependencies) mbsri_put_dependencies(t, d, d->variables->list + k, 0);
        mbsri_end(t);
    }
}

void mbsri_describe3(mbsri_text *t, const mbsri_described *d)
{
    static const char head[] = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
    mbsri_put(t, head, sizeof head - 1);
    mbsri_begin(t, "fmiModelDescription");
    mbsri_set_text(t, "fmiVersion", "3.0");
    mbsri_set_text(t, "modelName", d->plan->name);
    mbsri_set_text(t, "instantiationToken", d->token);
    mbsri_set_text(t, "generationTool", "mbsrank");
    mbsri_set_text(t, "variableNamingConvention", "structured");
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
    put_all(t, d, "Output", mbsri_is_output, true);
    put_all(t, d, "ContinuousStateDerivative", mbsri_is_derivative, false);
    put_all(t, d, "InitialUnknown", mbsri_is_initial_unknown, false);
    if (d->kinds & MBSR_FMU_MODEL_EXCHANGE) put_all(t, d, "EventIndicator", is_indicator, false);
    mbsri_out(t, "ModelStructure");
    mbsri_out(t, "fmiModelDescription");
}
