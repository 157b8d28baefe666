/* Instances: making and resetting. See open.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fmu/open.h"

#include "fmu/resource.h"
#include "fmu/solve.h"

#include <stdlib.h>
#include <string.h>

/* ---- the plan ---- */

static bool take_arrays(mbsri_instance *in)
{
    const size_t nq = (size_t)in->plan.nq, nu = (size_t)in->plan.nu;
    in->input = calloc((size_t)(in->plan.inputs + in->plan.motions) + 1, sizeof *in->input);
    in->start.q = calloc(nq + nu + 1, sizeof *in->start.q);
    if (!in->input || !in->start.q) return false;
    in->t_motion = in->input + in->plan.inputs;
    in->start.u = in->start.q + nq;
    for (int k = 0; k < in->plan.inputs; ++k) in->input[k] = in->plan.input[k].start;
    for (size_t k = 0; k < nq; ++k) in->start.q[k] = in->plan.q[k].start;
    for (size_t k = 0; k < nu; ++k) in->start.u[k] = in->plan.u[k].start;
    return true;
}

static bool take_parameters(mbsri_instance *in)
{
    const size_t count = (size_t)in->variables.parameters + 1;
    in->parameters.value = calloc(2 * count, sizeof *in->parameters.value);
    in->parameters.which = calloc(count, sizeof *in->parameters.which);
    if (!in->parameters.value || !in->parameters.which) return false;
    in->parameters.changed = in->parameters.value + count;
    for (size_t k = 1; k < count; ++k) in->parameters.value[k - 1] = in->variables.list[k].start;
    return true;
}

static bool open_plan(mbsri_instance *in)
{
    const mbsr_allocator standard = {NULL, NULL, NULL};
    mbsr_error error;
    mbsri_plan_open(&in->plan, &standard);
    if (mbsri_plan_read(&in->plan, in->resources.bytes, in->resources.size, &error)) {
        mbsri_say(in, MBSRI_ERROR, "the model in the resources cannot be read: %s", error.text);
        return false;
    }
    if (!take_arrays(in)) {
        mbsri_say(in, MBSRI_ERROR, "no memory for the model");
        return false;
    }
    if (in->exchange && !in->plan.model_exchange) {
        mbsri_say(in, MBSRI_ERROR, "the FMU does not offer model exchange");
        return false;
    }
    in->mode = MBSRI_INSTANTIATED;
    if (mbsri_make_model(in)) return false;
    if (mbsri_list_variables(&in->plan, &in->built, &in->variables) && take_parameters(in))
        return true;
    mbsri_say(in, MBSRI_ERROR, "no memory for the variables");
    return false;
}

static void close_plan(mbsri_instance *in)
{
    mbsri_drop_model(in);
    mbsri_built_destroy(&in->built);
    free(in->parameters.value);
    free(in->parameters.which);
    in->parameters.value = in->parameters.changed = NULL;
    in->parameters.which = NULL;
    free(in->input);
    free(in->start.q);
    in->input = in->start.q = in->start.u = NULL;
    mbsri_plan_close(&in->plan);
    in->plan = (mbsri_unit_plan){.name = ""};
    in->variables = (mbsri_variables){.list = NULL};
    in->size = in->rows = 0;
}

/* ---- instances ---- */

mbsri_instance *mbsri_instance_create(const mbsri_instance *as, const char *folder,
                                      const char *token)
{
    mbsri_instance *in = malloc(sizeof *in);
    mbsri_instance first = *as;
    char own[MBSRI_TOKEN];
    if (in) *in = *as, in->name = malloc(strlen(as->name) + 1);
    if (!in || !in->name) {
        mbsri_say(&first, MBSRI_ERROR, "no memory for an instance");
        free(in);
        return NULL;
    }
    memcpy(in->name, as->name, strlen(as->name) + 1);
    in->resources.bytes = mbsri_read_resource(folder, &in->resources.size);
    bool good = in->resources.bytes != NULL;
    if (!good) {
        mbsri_say(in, MBSRI_ERROR, "%s: the model cannot be read", folder);
    } else {
        mbsri_plan_token(in->resources.bytes, in->resources.size, own);
        good = strcmp(own, token) == 0;
        if (!good)
            mbsri_say(in, MBSRI_ERROR,
                      "the model in the resources is another one: '%.40s' is not "
                      "its token",
                      token);
    }
    if (good && open_plan(in)) return in;
    mbsri_instance_destroy(in);
    return NULL;
}

void mbsri_instance_destroy(mbsri_instance *in)
{
    if (!in) return;
    close_plan(in);
    free(in->resources.bytes);
    free(in->name);
    free(in);
}

mbsri_result mbsri_instance_reset(mbsri_instance *in)
{
    close_plan(in);
    in->t = in->start.t = in->tolerance = 0.0;
    in->inputs_changed = in->started = in->evaluated = in->fresh = false;
    in->parameters.stale = false;
    return open_plan(in) ? MBSRI_OK : MBSRI_FATAL;
}
