/* Derivatives of variables: see values.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * By analytic products where these serve; else central differences of the evaluation along the seed
 * s of the knowns v, with steps h s, h = 3e-6 / max(|s_k| / (e_k + |v_k|)), e the lengths and
 * momenta typical of the model, else 1; of the adjoint along one known after the other. */
#include "fmu/by_parameters.h"
#include "fmu/exchange.h"
#include "fmu/products.h"
#include "fmu/solve.h"
#include "fmu/values.h"

#include <mbsrank/driver.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Where a known stands; NULL: it is none. */
static double *place_of_known(mbsri_instance *in, unsigned reference)
{
    if (reference >= (unsigned)in->variables.count) return NULL;
    const mbsri_variable *v = in->variables.list + reference;
    if (v->kind == MBSRI_INPUT) return in->input + v->of;
    if (in->exchange && v->kind == MBSRI_Q) return in->x + v->of;
    if (in->exchange && v->kind == MBSRI_P) return in->x + in->plan.nq + v->of;
    return NULL;
}

/* What is differentiated, and room for both ends of a difference. */
typedef struct quotient {
    mbsri_instance *in;
    const char *function;
    const unsigned *unknown, *known;
    size_t unknowns, knowns;
    double *base, *forth, *back; /* knowns; unknowns each */
    double *unit, *column;       /* knowns; unknowns */
    double *span;                /* knowns: what changes them much */
} quotient;

/* Unknowns with the knowns moved by h seed from where they were. */
static mbsri_result ask_moved(const quotient *d, double h, const double *seed, double *value)
{
    for (size_t k = 0; k < d->knowns; ++k)
        *place_of_known(d->in, d->known[k]) = d->base[k] + h * seed[k];
    d->in->evaluated = false;
    d->in->inputs_changed = true;
    return mbsri_get(d->in, d->function, d->unknown, d->unknowns, value);
}

/* (d unknowns / d knowns) seed. */
static mbsri_result along_seed(const quotient *d, const double *seed, double *sensitivity)
{
    double most = 0.0;
    for (size_t k = 0; k < d->knowns; ++k)
        most = fmax(most, fabs(seed[k]) / (d->span[k] + fabs(d->base[k])));
    memset(sensitivity, 0, d->unknowns * sizeof *sensitivity);
    if (!(most > 0.0)) return MBSRI_OK;
    const double h = 3e-6 / most;
    mbsri_result result = ask_moved(d, h, seed, d->forth);
    if (!result) result = ask_moved(d, -h, seed, d->back);
    for (size_t k = 0; k < d->unknowns && !result; ++k)
        sensitivity[k] = (d->forth[k] - d->back[k]) / (2.0 * h);
    return result;
}

/* One known after the other, against the seed of the unknowns; added. */
static mbsri_result against_seed(const quotient *d, const double *seed, double *sensitivity)
{
    mbsri_result result = MBSRI_OK;
    for (size_t k = 0; k < d->knowns && d->unknowns > 0 && !result; ++k) {
        memset(d->unit, 0, d->knowns * sizeof *d->unit);
        d->unit[k] = 1.0;
        result = along_seed(d, d->unit, d->column);
        for (size_t l = 0; l < d->unknowns; ++l) sensitivity[k] += seed[l] * d->column[l];
    }
    return result;
}

static const mbsri_variable *variable_of(const quotient *d, unsigned reference)
{
    return d->in->variables.list + reference;
}

static bool is_parameter(const quotient *d, unsigned reference)
{
    return reference < (unsigned)d->in->variables.count &&
           variable_of(d, reference)->kind == MBSRI_PARAMETER;
}

static mbsri_result check_references(const quotient *d)
{
    for (size_t k = 0; k < d->knowns; ++k)
        if (!place_of_known(d->in, d->known[k]) && !is_parameter(d, d->known[k]))
            return mbsri_say(d->in, MBSRI_ERROR,
                             "%s: value reference %u is no input, parameter or state", d->function,
                             d->known[k]);
    for (size_t k = 0; k < d->unknowns; ++k)
        if (d->unknown[k] >= (unsigned)d->in->variables.count)
            return mbsri_say(d->in, MBSRI_ERROR,
                             "%s: there is no variable with the value reference %u of a real",
                             d->function, d->unknown[k]);
    return MBSRI_OK;
}

/* ---- sizes of knowns ---- */

static double or_one(double x)
{
    return x > 0.0 && isfinite(x) ? x : 1.0;
}

/* mass (nu): of momenta at the state. */
static double known_span(const quotient *d, const mbsri_variable *v, const double *mass)
{
    const mbsr_model *m = d->in->built.model;
    if (v->kind != MBSRI_Q && v->kind != MBSRI_P) return 1.0;
    const mbsri_unit_plan *plan = &d->in->plan;
    const int kind = v->kind == MBSRI_Q ? plan->q[v->of].kind : plan->u[v->of].kind;
    const double way = kind == MBSR_COORDINATE_TRANSLATION ? or_one(mbsr_model_length(m)) : 1.0;
    return v->kind == MBSRI_Q ? way : or_one(mass[v->of] * way * or_one(mbsr_model_rate(m)));
}

/* mass (nu): scratch. */
static mbsri_result find_spans(quotient *d, double *mass)
{
    mbsri_instance *in = d->in;
    const mbsri_result result = mbsri_evaluate(in);
    if (result) return result;
    if (mbsr_stage_backward(in->built.model, in->solver.data) ||
        mbsr_momentum_scales(in->built.model, in->solver.data, mass))
        memset(mass, 0, (size_t)in->plan.nu * sizeof *mass);
    for (size_t k = 0; k < d->knowns; ++k)
        d->span[k] = known_span(d, variable_of(d, d->known[k]), mass);
    return MBSRI_OK;
}

/* ---- by analytic products ---- */

static bool is_of_motion(const mbsri_instance *in, int input)
{
    for (int k = 0; k < in->plan.motions; ++k) {
        const mbsri_plan_motion *m = in->plan.motion + k;
        if (input >= m->input && input < m->input + 3 * m->count) return true;
    }
    return false;
}

/* Whether unknowns need accelerations, and knowns are numbers of motions. */
static bool begin_products(const quotient *d, mbsri_products *p)
{
    bool accelerations = false, motions = false;
    for (size_t k = 0; k < d->unknowns; ++k) {
        const mbsri_variable_kind kind = variable_of(d, d->unknown[k])->kind;
        accelerations = accelerations || kind == MBSRI_UDOT || kind == MBSRI_LOOP;
    }
    for (size_t k = 0; k < d->knowns; ++k) {
        const mbsri_variable *v = variable_of(d, d->known[k]);
        motions = motions || (v->kind == MBSRI_INPUT && is_of_motion(d->in, v->of));
    }
    return mbsri_products_begin(p, d->in, accelerations, motions);
}

static bool tell_along(const quotient *d, mbsri_products *p, const double *seed,
                       double *sensitivity)
{
    for (size_t k = 0; k < d->knowns; ++k) {
        const mbsri_variable *v = variable_of(d, d->known[k]);
        double *to = v->kind == MBSRI_INPUT ? p->dw : v->kind == MBSRI_Q ? p->dx : p->dx + p->nq;
        to[v->of] += seed[k];
    }
    if (!mbsri_products_along(p)) return false;
    for (size_t k = 0; k < d->unknowns; ++k) {
        const mbsri_variable *v = variable_of(d, d->unknown[k]);
        if (mbsri_products_serve(p, v)) sensitivity[k] = mbsri_products_of(p, v);
    }
    return true;
}

static bool tell_against(const quotient *d, mbsri_products *p, const double *seed,
                         double *sensitivity)
{
    for (size_t k = 0; k < d->unknowns; ++k) {
        const mbsri_variable *v = variable_of(d, d->unknown[k]);
        if (mbsri_products_serve(p, v)) mbsri_products_weigh(p, v, seed[k]);
    }
    if (!mbsri_products_against(p)) return false;
    for (size_t k = 0; k < d->knowns; ++k)
        if (!mbsri_products_gradient(p, variable_of(d, d->known[k]), sensitivity + k)) return false;
    return true;
}

/* Unknowns that products do not serve, the others taken out: into `left`, where each stood into
 * `at`. Of the adjoint, sensitivities are what products make of the rest. */
static mbsri_result use_products(const quotient *d, bool adjoint, const double *seed,
                                 double *sensitivity, unsigned *left, size_t *at, size_t *lefts)
{
    mbsri_products p;
    const size_t results = adjoint ? d->knowns : d->unknowns;
    if (!d->in->exchange) {
        const mbsri_result result = mbsri_evaluate(d->in);
        if (result) return result;
    }
    memset(sensitivity, 0, results * sizeof *sensitivity);
    if (!begin_products(d, &p)) return mbsri_say(d->in, MBSRI_ERROR, "%s: no memory", d->function);
    bool serve = p.states || p.accelerations;
    if (serve) serve = (adjoint ? tell_against : tell_along)(d, &p, seed, sensitivity);
    if (!serve) memset(sensitivity, 0, results * sizeof *sensitivity);
    *lefts = 0;
    for (size_t k = 0; k < d->unknowns; ++k) {
        if (serve && mbsri_products_serve(&p, variable_of(d, d->unknown[k]))) continue;
        left[*lefts] = d->unknown[k];
        at[(*lefts)++] = k;
    }
    mbsri_products_end(&p);
    return MBSRI_OK;
}

/* ---- both ---- */

/* The rest by differences; seeds and results of the adjoint and of the other in their places. */
static mbsri_result use_differences(quotient *d, bool adjoint, const double *seed,
                                    double *sensitivity, const unsigned *left, const size_t *at,
                                    size_t lefts, double *room)
{
    d->unknown = left;
    d->unknowns = lefts;
    if (lefts == 0) return MBSRI_OK;
    mbsri_result result = find_spans(d, room + lefts);
    if (result) return result;
    if (adjoint) {
        for (size_t k = 0; k < lefts; ++k) room[k] = seed[at[k]];
        return against_seed(d, room, sensitivity);
    }
    result = along_seed(d, seed, room);
    for (size_t k = 0; k < lefts; ++k) sensitivity[at[k]] = room[k];
    return result;
}

static mbsri_result differentiate(quotient *d, bool adjoint, const double *seed,
                                  double *sensitivity, double *room)
{
    mbsri_instance *in = d->in;
    const bool changed = in->inputs_changed;
    const size_t unknowns = d->unknowns;
    size_t *at = calloc(unknowns + 1, sizeof *at), lefts = 0;
    unsigned *left = calloc(unknowns + 1, sizeof *left);
    mbsri_result result =
        at && left ? MBSRI_OK : mbsri_say(in, MBSRI_ERROR, "%s: no memory", d->function);
    for (size_t k = 0; k < d->knowns; ++k) d->base[k] = *place_of_known(in, d->known[k]);
    if (!result) result = use_products(d, adjoint, seed, sensitivity, left, at, &lefts);
    if (!result) result = use_differences(d, adjoint, seed, sensitivity, left, at, lefts, room);
    for (size_t k = 0; k < d->knowns; ++k) *place_of_known(in, d->known[k]) = d->base[k];
    in->inputs_changed = changed;
    in->evaluated = false;
    free(at);
    free(left);
    return result;
}

/* In inputs and states. */
static mbsri_result differentiate_moving(quotient *d, bool adjoint, const double *seed,
                                         double *sensitivity)
{
    const size_t knowns = d->knowns, unknowns = d->unknowns;
    double *room = calloc(3 * knowns + 4 * unknowns + (size_t)d->in->plan.nu + 1, sizeof *room);
    if (!room) return mbsri_say(d->in, MBSRI_ERROR, "%s: no memory", d->function);
    d->base = room;
    d->unit = d->base + knowns;
    d->span = d->unit + knowns;
    d->forth = d->span + knowns;
    d->back = d->forth + unknowns;
    d->column = d->back + unknowns;
    const mbsri_result result = differentiate(d, adjoint, seed, sensitivity, d->column + unknowns);
    free(room);
    return result;
}

/* ---- parameters among the knowns ---- */

/* Parameters go to the end of `known`, where each stood into `at`; returns how many others. */
static size_t part_knowns(const quotient *d, unsigned *known, size_t *at)
{
    size_t others = 0, end = d->knowns;
    for (size_t k = 0; k < d->knowns; ++k) {
        const size_t to = is_parameter(d, d->known[k]) ? --end : others++;
        known[to] = d->known[k];
        at[to] = k;
    }
    return others;
}

/* The others, then the parameters; numbers of the knowns in their order in `of_known`. */
static mbsri_result differentiate_parts(quotient *d, bool adjoint, const double *seed,
                                        double *sensitivity, const unsigned *known, size_t others,
                                        double *of_known)
{
    const mbsri_by_parameters by = {.function = d->function,
                                    .unknown = d->unknown,
                                    .parameter = known + others,
                                    .unknowns = d->unknowns,
                                    .parameters = d->knowns - others};
    mbsri_result result = MBSRI_OK;
    d->known = known;
    d->knowns = others;
    if (!adjoint) memset(sensitivity, 0, d->unknowns * sizeof *sensitivity);
    if (others > 0)
        result = differentiate_moving(d, adjoint, adjoint ? seed : of_known,
                                      adjoint ? of_known : sensitivity);
    if (result || by.parameters == 0) return result;
    return adjoint ? mbsri_against_parameters(d->in, &by, seed, of_known + others)
                   : mbsri_along_parameters(d->in, &by, of_known + others, sensitivity);
}

mbsri_result mbsri_differentiate(mbsri_instance *in, const char *function, bool adjoint,
                                 const unsigned *unknown, size_t unknowns, const unsigned *known,
                                 size_t knowns, const double *seed, double *sensitivity)
{
    quotient d = {.in = in,
                  .function = function,
                  .unknown = unknown,
                  .known = known,
                  .unknowns = unknowns,
                  .knowns = knowns};
    if ((unknowns > 0 && !unknown) || (knowns > 0 && !known) || !seed || !sensitivity)
        return mbsri_say(in, MBSRI_ERROR, "%s: an argument is NULL", function);
    mbsri_result result = in->started ? MBSRI_OK : mbsri_find_start(in);
    if (!result && in->exchange && !in->solver.ode) result = mbsri_make_solver(in);
    if (!result) result = check_references(&d);
    if (result) return result;
    unsigned *parted = malloc((knowns + 1) * sizeof *parted);
    size_t *at = malloc((knowns + 1) * sizeof *at);
    double *of_known = calloc(knowns + 1, sizeof *of_known);
    if (parted && at && of_known) {
        const size_t others = part_knowns(&d, parted, at);
        for (size_t k = 0; k < knowns && !adjoint; ++k) of_known[k] = seed[at[k]];
        result = differentiate_parts(&d, adjoint, seed, sensitivity, parted, others, of_known);
        for (size_t k = 0; k < knowns && adjoint; ++k) sensitivity[at[k]] = of_known[k];
    } else {
        result = mbsri_say(in, MBSRI_ERROR, "%s: no memory", function);
    }
    free(parted);
    free(at);
    free(of_known);
    return result;
}
