/* States of an instance, kept and brought back: see saved.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A state is one array of numbers, in the order of `pass`; its size follows from the FMU. */
#include "fmu/saved.h"

#include "fmu/driver.h"
#include "fmu/solve.h"

#include <mbsrank/closure.h>
#include <mbsrank/driver.h>

#include <stdlib.h>
#include <string.h>

struct mbsri_saved {
    size_t count;
    double number[];
};

enum { FLAGS = 8 };

static size_t count_of(const mbsri_instance *in)
{
    const mbsri_unit_plan *p = &in->plan;
    return FLAGS + (size_t)in->variables.parameters + (size_t)(p->inputs + p->motions) +
           3 * (size_t)(p->nq + p->nu) + 2 * (size_t)in->size + 2 * (size_t)in->rows;
}

/* Copies between an array of the instance and the next numbers of a state. */
static void pass_array(bool save, double **at, double *array, size_t count)
{
    if (save)
        memcpy(*at, array, count * sizeof *array);
    else
        memcpy(array, *at, count * sizeof *array);
    *at += count;
}

/* Which rows of closures the data leaves out as redundant. */
static int pass_dropped(mbsri_instance *in, bool save, double *at)
{
    const mbsr_model *m = in->built.model;
    int *dropped = calloc((size_t)in->rows + 1, sizeof *dropped);
    if (!dropped) return MBSR_ERR_NO_MEMORY;
    int status = save ? mbsr_closures_redundant(m, in->solver.data, dropped) : MBSR_OK;
    for (int k = 0; k < in->rows; ++k)
        if (save)
            at[k] = dropped[k];
        else
            dropped[k] = at[k] != 0.0;
    if (!save) status = mbsr_closures_set_redundant(m, in->solver.data, dropped);
    free(dropped);
    return status;
}

/* All but these and the parameters: flags stand first. */
static void pass_arrays(mbsri_instance *in, bool save, double *at)
{
    const size_t nq = (size_t)in->plan.nq, nu = (size_t)in->plan.nu;
    pass_array(save, &at, in->input, (size_t)(in->plan.inputs + in->plan.motions));
    pass_array(save, &at, in->start.q, nq + nu);
    pass_array(save, &at, in->q, nq);
    pass_array(save, &at, in->u, nu);
    pass_array(save, &at, in->x, nq + nu);
    pass_array(save, &at, in->y, (size_t)in->size);
    pass_array(save, &at, in->yp, (size_t)in->size);
    pass_array(save, &at, in->lambda, (size_t)in->rows);
}

/* The state of the driver or the stepper into y and yp, from where it begins anew. */
static mbsri_result take_state(mbsri_instance *in)
{
    int status = MBSR_OK;
    const mbsr_error *error = NULL;
    if (in->solver.ida && !in->fresh) status = mbsri_driver_state(in, &error);
    if (in->solver.stepper && !in->fresh) {
        status = mbsr_stepper_state(in->solver.stepper, NULL, in->y, in->yp);
        error = mbsr_stepper_error(in->solver.stepper);
    }
    if (status) return mbsri_failed(in, "no state to be kept", status, error);
    in->fresh = in->solver.ida || in->solver.stepper;
    in->evaluated = false;
    return MBSRI_OK;
}

mbsri_result mbsri_save(mbsri_instance *in, const char *function, mbsri_saved **saved)
{
    const size_t count = count_of(in);
    if (!saved || !in->q)
        return mbsri_say(in, MBSRI_ERROR, "%s: %s", function,
                         saved ? "there is no state" : "an argument is NULL");
    const mbsri_result taken = in->mode == MBSRI_TERMINATED ? MBSRI_OK : take_state(in);
    if (taken) return taken;
    mbsri_saved *to = *saved;
    if (to && to->count != count)
        return mbsri_say(in, MBSRI_ERROR, "%s: the state is of another FMU", function);
    if (!to) to = calloc(1, sizeof *to + count * sizeof *to->number);
    if (!to) return mbsri_say(in, MBSRI_ERROR, "%s: no memory", function);
    to->count = count;
    const double flags[FLAGS] = {in->t,
                                 in->start.t,
                                 in->tolerance,
                                 (double)in->mode,
                                 in->started,
                                 in->inputs_changed,
                                 in->solver.ode != NULL,
                                 in->solver.ida || in->solver.stepper};
    memcpy(to->number, flags, sizeof flags);
    double *at = to->number + FLAGS;
    const size_t parameters = (size_t)in->variables.parameters;
    memcpy(at, in->parameters.value, parameters * sizeof *at);
    at += parameters;
    pass_arrays(in, true, at);
    const int status = pass_dropped(in, true, to->number + count - in->rows);
    if (status) mbsri_failed(in, function, status, NULL);
    *saved = to;
    return status ? MBSRI_ERROR : MBSRI_OK;
}

/* The parameters, and whether they are others. */
static bool set_parameters(mbsri_instance *in, const double *value)
{
    bool others = false;
    for (int k = 0; k < in->variables.parameters; ++k) {
        double *place = in->parameters.value + k;
        others = others || *place < value[k] || *place > value[k];
        *place = value[k];
    }
    return others;
}

static bool is_mode(double mode)
{
    for (int k = 0; k < 6; ++k)
        if (mode == (double)(1 << k)) return true;
    return false;
}

mbsri_result mbsri_restore(mbsri_instance *in, const char *function, const mbsri_saved *saved)
{
    if (!saved || saved->count != count_of(in) || !is_mode(saved->number[3]))
        return mbsri_say(in, MBSRI_ERROR, "%s: the state is NULL or of another FMU", function);
    const double *flags = saved->number;
    const bool tolerance = in->tolerance < flags[2] || in->tolerance > flags[2];
    if (set_parameters(in, saved->number + FLAGS) || in->parameters.stale || !in->q) {
        const mbsri_result made = mbsri_make_model(in);
        if (made) return made;
    }
    pass_arrays(in, false, (double *)saved->number + FLAGS + in->variables.parameters);
    const int status = pass_dropped(in, false, (double *)saved->number + saved->count - in->rows);
    if (status) return mbsri_failed(in, function, status, NULL);
    in->t = flags[0];
    in->start.t = flags[1];
    in->tolerance = flags[2];
    in->started = flags[4] != 0.0;
    in->inputs_changed = flags[5] != 0.0;
    in->evaluated = false;
    in->mode = (mbsri_unit_mode)(int)flags[3];
    const bool wanted = flags[6] != 0.0 || flags[7] != 0.0,
               there = in->solver.ode || in->solver.ida || in->solver.stepper;
    if (wanted && (!there || tolerance)) {
        const bool changed = in->inputs_changed;
        const mbsri_result made = mbsri_make_solver(in);
        if (made) return made;
        in->inputs_changed = changed;
        pass_arrays(in, false, (double *)saved->number + FLAGS + in->variables.parameters);
    }
    in->fresh = flags[7] != 0.0;
    return MBSRI_OK;
}

void mbsri_saved_destroy(mbsri_saved *saved)
{
    free(saved);
}

/* ---- as bytes: a token of the FMU, then the numbers ---- */

size_t mbsri_saved_size(const mbsri_saved *saved)
{
    return MBSRI_TOKEN + saved->count * 8;
}

static void token_of(const mbsri_instance *in, char token[MBSRI_TOKEN])
{
    mbsri_plan_token(in->resources.bytes, in->resources.size, token);
}

mbsri_result mbsri_serialize(mbsri_instance *in, const char *function, const mbsri_saved *saved,
                             unsigned char *bytes, size_t size)
{
    char token[MBSRI_TOKEN];
    if (!saved || !bytes || size < mbsri_saved_size(saved))
        return mbsri_say(in, MBSRI_ERROR, "%s: no state, or no room for it", function);
    token_of(in, token);
    memcpy(bytes, token, sizeof token);
    memcpy(bytes + sizeof token, saved->number, saved->count * 8);
    return MBSRI_OK;
}

mbsri_result mbsri_deserialize(mbsri_instance *in, const char *function, const unsigned char *bytes,
                               size_t size, mbsri_saved **saved)
{
    const size_t count = count_of(in);
    char token[MBSRI_TOKEN];
    if (!bytes || !saved) return mbsri_say(in, MBSRI_ERROR, "%s: an argument is NULL", function);
    token_of(in, token);
    if (size != MBSRI_TOKEN + count * 8 || memcmp(bytes, token, sizeof token) != 0)
        return mbsri_say(in, MBSRI_ERROR, "%s: the state is of another FMU", function);
    mbsri_saved *made = calloc(1, sizeof *made + count * sizeof *made->number);
    if (!made) return mbsri_say(in, MBSRI_ERROR, "%s: no memory", function);
    made->count = count;
    memcpy(made->number, bytes + MBSRI_TOKEN, count * 8);
    *saved = made;
    return MBSRI_OK;
}
