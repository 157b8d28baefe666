/* Derivatives of variables with respect to inputs and states: see values.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Central differences of the evaluation along the seed s of the knowns v, with steps h s, h = 1e-6
 * / max(|s_k| / (1 + |v_k|)); of the adjoint along one known after the other. Nothing is taken from
 * analytic derivatives. */
#include "fmu/exchange.h"
#include "fmu/solve.h"
#include "fmu/values.h"

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
        most = fmax(most, fabs(seed[k]) / (1.0 + fabs(d->base[k])));
    memset(sensitivity, 0, d->unknowns * sizeof *sensitivity);
    if (!(most > 0.0)) return MBSRI_OK;
    const double h = 1e-6 / most;
    mbsri_result result = ask_moved(d, h, seed, d->forth);
    if (!result) result = ask_moved(d, -h, seed, d->back);
    for (size_t k = 0; k < d->unknowns && !result; ++k)
        sensitivity[k] = (d->forth[k] - d->back[k]) / (2.0 * h);
    return result;
}

/* One known after the other, against the seed of the unknowns. */
static mbsri_result against(const quotient *d, const double *seed, double *sensitivity,
                            double *unit, double *column)
{
    mbsri_result result = MBSRI_OK;
    for (size_t k = 0; k < d->knowns && !result; ++k) {
        memset(unit, 0, d->knowns * sizeof *unit);
        unit[k] = 1.0;
        result = along_seed(d, unit, column);
        sensitivity[k] = 0.0;
        for (size_t l = 0; l < d->unknowns; ++l) sensitivity[k] += seed[l] * column[l];
    }
    return result;
}

static mbsri_result check_references(const quotient *d)
{
    for (size_t k = 0; k < d->knowns; ++k)
        if (!place_of_known(d->in, d->known[k]))
            return mbsri_say(d->in, MBSRI_ERROR,
                             "%s: value reference %u is neither an input nor a state", d->function,
                             d->known[k]);
    return MBSRI_OK;
}

mbsri_result mbsri_differentiate(mbsri_instance *in, const char *function, bool adjoint,
                                 const unsigned *unknown, size_t unknowns, const unsigned *known,
                                 size_t knowns, const double *seed, double *sensitivity)
{
    quotient d = {in, function, unknown, known, unknowns, knowns, NULL, NULL, NULL};
    if ((unknowns > 0 && !unknown) || (knowns > 0 && !known) || !seed || !sensitivity)
        return mbsri_say(in, MBSRI_ERROR, "%s: an argument is NULL", function);
    mbsri_result result = in->started ? MBSRI_OK : mbsri_find_start(in);
    if (!result && in->exchange && !in->solver.ode) result = mbsri_make_solver(in);
    if (!result) result = check_references(&d);
    if (result) return result;
    d.base = calloc(2 * knowns + 3 * unknowns + 1, sizeof *d.base);
    if (!d.base) return mbsri_say(in, MBSRI_ERROR, "%s: no memory", function);
    d.forth = d.base + knowns;
    d.back = d.forth + unknowns;
    for (size_t k = 0; k < knowns; ++k) d.base[k] = *place_of_known(in, known[k]);
    const bool changed = in->inputs_changed;
    result = adjoint
                 ? against(&d, seed, sensitivity, d.back + unknowns + unknowns, d.back + unknowns)
                 : along_seed(&d, seed, sensitivity);
    for (size_t k = 0; k < knowns; ++k) *place_of_known(in, known[k]) = d.base[k];
    in->inputs_changed = changed;
    in->evaluated = false;
    free(d.base);
    return result;
}
