/* Derivatives with respect to parameters: see by_parameters.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fmu/by_parameters.h"

#include "fmu/solve.h"
#include "fmu/values.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const mbsri_variable *variable_of(const mbsri_instance *in, unsigned reference)
{
    return in->variables.list + reference;
}

/* ---- by differences ---- */

/* The state of another instance of the same FMU: that of its start, or q and p, or q and u. */
static mbsri_result take_state_of(mbsri_instance *twin, const mbsri_instance *in)
{
    const size_t nq = (size_t)in->plan.nq, nu = (size_t)in->plan.nu;
    if (in->mode == MBSRI_INITIALIZATION) {
        const mbsri_result found = mbsri_find_start(twin);
        return found || !in->exchange ? found : mbsri_make_solver(twin);
    }
    memcpy(twin->q, in->q, nq * sizeof *twin->q);
    memcpy(twin->u, in->u, nu * sizeof *twin->u);
    memcpy(twin->lambda, in->lambda, (size_t)in->rows * sizeof *twin->lambda);
    twin->started = true;
    const mbsri_result made = in->exchange ? mbsri_make_solver(twin) : MBSRI_OK;
    if (!made) memcpy(twin->x, in->x, (nq + nu) * sizeof *twin->x);
    return made;
}

/* Unknowns with parameters moved by h seed, of a model of its own; quiet: without a message. */
static mbsri_result ask_with(const mbsri_instance *in, const mbsri_by_parameters *d, bool quiet,
                             double h, const double *seed, double *value)
{
    const size_t count = (size_t)in->variables.parameters;
    mbsri_instance twin = *in;
    twin.parameters.value = malloc((count + 1) * sizeof *twin.parameters.value);
    twin.built.model = NULL;
    memset(&twin.solver, 0, sizeof twin.solver);
    twin.q = NULL;
    twin.started = twin.evaluated = twin.fresh = false;
    if (quiet) twin.importer.logger = NULL;
    if (!twin.parameters.value) return mbsri_say(&twin, MBSRI_ERROR, "%s: no memory", d->function);
    memcpy(twin.parameters.value, in->parameters.value, count * sizeof *twin.parameters.value);
    for (size_t k = 0; k < d->parameters; ++k)
        twin.parameters.value[variable_of(in, d->parameter[k])->of] += h * seed[k];
    mbsri_result result = mbsri_make_model(&twin);
    if (!result) result = take_state_of(&twin, in);
    if (!result) result = mbsri_get(&twin, d->function, d->unknown, d->unknowns, value);
    mbsri_drop_model(&twin);
    mbsr_model_destroy(twin.built.model);
    free(twin.parameters.value);
    return result;
}

/* The size of a parameter; of what is rounding beside the largest of its unit, or the length of the
 * model, a tenth of that. */
static double parameter_size(const mbsri_instance *in, const mbsri_variable *v)
{
    const double value = fabs(in->parameters.value[v->of]);
    double largest = strcmp(v->unit, "m") == 0 ? mbsr_model_length(in->built.model) : 0.0;
    for (int k = 0; k < in->variables.count; ++k) {
        const mbsri_variable *other = in->variables.list + k;
        if (other->kind == MBSRI_PARAMETER && strcmp(other->unit, v->unit) == 0)
            largest = fmax(largest, fabs(in->parameters.value[other->of]));
    }
    return value > 1e-9 * largest ? value : largest > 0.0 ? 0.1 * largest : 0.1;
}

/* The step along a seed: a hundred thousandth of each parameter's size. */
static double step_along(const mbsri_instance *in, const mbsri_by_parameters *d, const double *seed)
{
    double most = 0.0;
    for (size_t k = 0; k < d->parameters; ++k)
        most = fmax(most, fabs(seed[k]) / parameter_size(in, variable_of(in, d->parameter[k])));
    return most > 0.0 ? 1e-5 / most : 0.0;
}

/* At a border of what parameters may be: from one side, of order 2, where slopes over h and 2 h
 * show that there is a derivative. Ranks that change there leave none. */
static mbsri_result differ_aside(mbsri_instance *in, const mbsri_by_parameters *d, double h,
                                 const double *seed, double *room, double *sensitivity)
{
    double *here = room, *near = here + d->unknowns, *far = near + d->unknowns;
    mbsri_result result = ask_with(in, d, false, 0.0, seed, here);
    if (!result) result = ask_with(in, d, false, h, seed, near);
    if (!result) result = ask_with(in, d, false, 2.0 * h, seed, far);
    if (result) in->mode = MBSRI_TERMINATED;
    for (size_t k = 0; k < d->unknowns && !result; ++k) {
        const double one = (near[k] - here[k]) / h, both = (far[k] - here[k]) / (2.0 * h);
        if (fabs(one - both) > 0.01 * fabs(both) + 1e-4 * (1.0 + fabs(here[k])))
            return mbsri_say(in, MBSRI_ERROR, "%s: %s has no derivative in %s", d->function,
                             variable_of(in, d->unknown[k])->name,
                             variable_of(in, d->parameter[0])->name);
        sensitivity[k] += 2.0 * one - both;
    }
    return result;
}

/* room: three times as many numbers as unknowns. */
static mbsri_result differ(mbsri_instance *in, const mbsri_by_parameters *d, const double *seed,
                           double *room, double *sensitivity)
{
    double *forth = room, *back = room + d->unknowns;
    const double h = step_along(in, d, seed);
    if (!(h > 0.0) || d->unknowns == 0) return MBSRI_OK;
    const bool upwards = !ask_with(in, d, true, h, seed, forth),
               downwards = !ask_with(in, d, true, -h, seed, back);
    if (!upwards || !downwards)
        return differ_aside(in, d, downwards ? -h : h, seed, room, sensitivity);
    for (size_t k = 0; k < d->unknowns; ++k) sensitivity[k] += (forth[k] - back[k]) / (2.0 * h);
    return MBSRI_OK;
}

/* ---- by products ---- */

static bool is_served(const mbsri_variable *v)
{
    return v->kind == MBSRI_UDOT || v->kind == MBSRI_LOOP;
}

/* Forward dynamics linearised in the parameters at q and u. False: it has no such products. */
static bool linearise_forward(mbsri_instance *in, const mbsri_by_parameters *d)
{
    bool wanted = false;
    int *which = malloc((d->parameters + 1) * sizeof *which), status = MBSR_OK;
    for (size_t k = 0; k < d->unknowns; ++k)
        wanted = wanted || is_served(variable_of(in, d->unknown[k]));
    for (size_t k = 0; k < d->parameters && which; ++k)
        which[k] = variable_of(in, d->parameter[k])->of;
    wanted = wanted && which && !in->exchange && in->mode != MBSRI_INITIALIZATION;
    if (wanted && !in->solver.forward)
        status = mbsr_derivatives_create(in->built.model, &in->solver.forward, NULL);
    if (wanted && !status)
        status = mbsr_derivatives_parameters(in->solver.forward, in->built.list, (int)d->parameters,
                                             which);
    if (wanted && !status)
        status =
            mbsr_derivatives_forward(in->solver.forward, in->t, in->q, in->u, NULL, NULL, NULL);
    free(which);
    return wanted && !status;
}

/* What products serve; *served: they did. room: nu and rows numbers. */
static void multiply_along(mbsri_instance *in, const mbsri_by_parameters *d, const double *seed,
                           double *room, double *sensitivity, bool *served)
{
    double *udot = room, *lambda = room + in->plan.nu;
    *served = !mbsr_derivatives_parameter_tangent(in->solver.forward, seed, udot,
                                                  in->rows > 0 ? lambda : NULL);
    for (size_t k = 0; k < d->unknowns && *served; ++k) {
        const mbsri_variable *v = variable_of(in, d->unknown[k]);
        if (is_served(v)) sensitivity[k] += v->kind == MBSRI_UDOT ? udot[v->of] : lambda[v->of];
    }
}

static void multiply_against(mbsri_instance *in, const mbsri_by_parameters *d, const double *seed,
                             double *room, double *sensitivity, bool *served)
{
    double *udot = room, *lambda = room + in->plan.nu;
    memset(room, 0, (size_t)(in->plan.nu + in->rows) * sizeof *room);
    for (size_t k = 0; k < d->unknowns; ++k) {
        const mbsri_variable *v = variable_of(in, d->unknown[k]);
        if (is_served(v)) *(v->kind == MBSRI_UDOT ? udot + v->of : lambda + v->of) += seed[k];
    }
    *served = !mbsr_derivatives_parameter_adjoint(in->solver.forward, udot,
                                                  in->rows > 0 ? lambda : NULL, sensitivity);
}

/* ---- both ---- */

/* What is left for differences, and its seeds or sensitivities. */
typedef struct leftover {
    mbsri_by_parameters d;
    unsigned *unknown;
    size_t *at; /* which of the unknowns */
    double *value, *unit, *room;
} leftover;

static bool begin_leftover(mbsri_instance *in, const mbsri_by_parameters *d, leftover *r)
{
    const size_t room = 3 * d->unknowns + (size_t)(in->plan.nu + in->rows);
    *r = (leftover){.d = *d};
    r->unknown = malloc((d->unknowns + 1) * sizeof *r->unknown);
    r->at = malloc((d->unknowns + 1) * sizeof *r->at);
    r->value = calloc(d->unknowns + d->parameters + room + 1, sizeof *r->value);
    if (!r->unknown || !r->at || !r->value) return false;
    r->unit = r->value + d->unknowns;
    r->room = r->unit + d->parameters;
    return true;
}

static void leave_served(const mbsri_instance *in, leftover *r, bool served)
{
    size_t left = 0;
    for (size_t k = 0; k < r->d.unknowns; ++k) {
        if (served && is_served(variable_of(in, r->d.unknown[k]))) continue;
        r->unknown[left] = r->d.unknown[k];
        r->at[left++] = k;
    }
    r->d.unknown = r->unknown;
    r->d.unknowns = left;
}

static mbsri_result end_leftover(mbsri_instance *in, leftover *r, mbsri_result result)
{
    if (in->solver.forward)
        mbsr_derivatives_parameters(in->solver.forward, in->built.list, 0, NULL);
    free(r->unknown);
    free(r->at);
    free(r->value);
    return result;
}

/* At a state that is evaluated and, with `linear`, linearised. */
static mbsri_result open_leftover(mbsri_instance *in, const mbsri_by_parameters *d, leftover *r,
                                  bool *linear)
{
    const mbsri_result result = mbsri_evaluate(in);
    if (result) return result;
    if (!begin_leftover(in, d, r))
        return end_leftover(in, r, mbsri_say(in, MBSRI_ERROR, "%s: no memory", d->function));
    *linear = linearise_forward(in, d);
    return MBSRI_OK;
}

mbsri_result mbsri_along_parameters(mbsri_instance *in, const mbsri_by_parameters *d,
                                    const double *seed, double *sensitivity)
{
    leftover r;
    bool linear, served = false;
    mbsri_result result = open_leftover(in, d, &r, &linear);
    if (result) return result;
    if (linear) multiply_along(in, d, seed, r.room, sensitivity, &served);
    leave_served(in, &r, served);
    result = differ(in, &r.d, seed, r.room, r.value);
    for (size_t k = 0; k < r.d.unknowns; ++k) sensitivity[r.at[k]] += r.value[k];
    return end_leftover(in, &r, result);
}

mbsri_result mbsri_against_parameters(mbsri_instance *in, const mbsri_by_parameters *d,
                                      const double *seed, double *sensitivity)
{
    leftover r;
    bool linear, served = false;
    mbsri_result result = open_leftover(in, d, &r, &linear);
    if (result) return result;
    memset(sensitivity, 0, d->parameters * sizeof *sensitivity);
    if (linear) multiply_against(in, d, seed, r.room, sensitivity, &served);
    if (!served) memset(sensitivity, 0, d->parameters * sizeof *sensitivity);
    leave_served(in, &r, served);
    for (size_t k = 0; k < d->parameters && !result; ++k) {
        r.unit[k] = 1.0;
        memset(r.value, 0, d->unknowns * sizeof *r.value);
        result = differ(in, &r.d, r.unit, r.room, r.value);
        r.unit[k] = 0.0;
        for (size_t l = 0; l < r.d.unknowns; ++l) sensitivity[k] += seed[r.at[l]] * r.value[l];
    }
    return end_leftover(in, &r, result);
}
