/* Sensitivities of runs: a step of the forward equations, for sums of parameters.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "ida/sensitivity_record.h"

#include <string.h>

/* T of all sums of parameters. */
static int find_sources(mbsri_forward_run *f, long node)
{
    mbsr_sensitivity *s = f->s;
    double *unit = s->work + 4 * s->size;
    int status = mbsri_sensitivity_sources(s, node);
    memset(unit, 0, (size_t)s->parameters * sizeof *unit);
    for (int k = 0; k < f->count && !status; ++k) {
        const double *weight = f->weight ? f->weight + (size_t)k * (size_t)s->parameters : unit;
        if (!f->weight) unit[k] = 1.0;
        status = mbsr_derivatives_parameter_tangent(s->derivatives, weight,
                                                    f->tau + (size_t)k * (size_t)s->nu, NULL);
        if (!f->weight) unit[k] = 0.0;
        if (status)
            mbsri_sensitivity_fail(s, status, mbsr_derivatives_error(s->derivatives),
                                   "mbsr_sensitivity_forward");
    }
    return status;
}

/* Solves (A + c E) x = R T - E history for sum k, into x. */
static int solve_forward(mbsri_forward_run *f, int k, const double *history, double *x)
{
    mbsr_sensitivity *s = f->s;
    const double *tau = f->tau + (size_t)k * (size_t)s->nu;
    const int status = mbsr_newton_solve_sensitivity(s->newton, tau, history, x);
    return status ? mbsri_sensitivity_fail(s, status, mbsr_newton_error(s->newton),
                                           "mbsr_sensitivity_forward")
                  : MBSR_OK;
}

/* p of all sums jumps. */
static int jump_forward(mbsri_forward_run *f, long node)
{
    mbsr_sensitivity *s = f->s;
    const size_t nu = (size_t)s->nu, parameters = (size_t)s->parameters;
    double *p = mbsri_forward_node(f, node - 1, 0) + s->nq;
    if (!f->weight) return mbsri_sensitivity_jump(s, node, p, (size_t)s->size);
    memset(f->jump, 0, parameters * nu * sizeof *f->jump);
    const int status = mbsri_sensitivity_jump(s, node, f->jump, nu);
    for (int k = 0; k < f->count && !status; ++k, p += s->size) {
        for (size_t l = 0; l < parameters; ++l) {
            const double weight = f->weight[(size_t)k * parameters + l];
            for (size_t j = 0; j < nu && weight != 0.0; ++j) p[j] += weight * f->jump[l * nu + j];
        }
    }
    return status;
}

/* The short step before the first of a segment. */
static int begin_segment(mbsri_forward_run *f, long node)
{
    mbsr_sensitivity *s = f->s;
    const double c = mbsri_sensitivity_short(s, node);
    double *history = s->work + 2 * s->size;
    int status = jump_forward(f, node);
    if (!status) status = find_sources(f, node);
    if (!status) status = mbsri_sensitivity_at(s, s->newton, node, c);
    for (int k = 0; k < f->count && !status; ++k) {
        double *before = mbsri_forward_node(f, node - 1, k);
        for (int l = 0; l < s->size; ++l) history[l] = -c * before[l];
        status = solve_forward(f, k, history, before);
    }
    return status;
}

int mbsri_forward_step(mbsri_forward_run *f, long node)
{
    mbsr_sensitivity *s = f->s;
    const mbsri_formula rate = mbsri_sensitivity_rate(s, node);
    double *history = s->work + 2 * s->size;
    int status =
        mbsri_kept_at(s, node)->since == 0 ? begin_segment(f, node) : find_sources(f, node);
    if (!status) status = mbsri_sensitivity_at(s, s->newton, node, rate.weight[0]);
    for (int k = 0; k < f->count && !status; ++k) {
        memset(history, 0, (size_t)s->size * sizeof *history);
        for (int i = 1; i <= rate.order; ++i) {
            const double *before = mbsri_forward_node(f, node - i, k);
            for (int l = 0; l < s->size; ++l) history[l] += rate.weight[i] * before[l];
        }
        status = solve_forward(f, k, history, mbsri_forward_node(f, node, k));
    }
    return status;
}
