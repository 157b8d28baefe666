/* Sensitivities of runs: where u jumps.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * p of s is less by dM u, and the momenta do not jump. Where joint frames turn the directions
 * without mass, dM has something to do with these, and closures change u by impulses. M x is
 * inverse dynamics of the accelerations x at rest, less that of none. */
#include "ida/sensitivity_record.h"

/* q behind the jump, and what u jumps by. */
static const double *find_jump(const mbsr_sensitivity *s, long node, double *jump)
{
    const double *q = s->given + s->nq + s->nu, *u = q + s->nq;
    const bool held = mbsr_model_closures(s->model) > 0; /* as the start has made them */
    if (node == 1) {
        for (int k = 0; k < s->nu; ++k) jump[k] = held ? 0.0 : u[k] - s->given[s->nq + k];
        return q;
    }
    /* the first step of the run is one of implicit Euler, from the state behind the kink */
    const int at = s->nq + s->nu;
    const double *before = mbsri_sensitivity_state(s, node - 1),
                 *behind = mbsri_sensitivity_state(s, node), *rate = behind + s->size,
                 h = mbsri_sensitivity_time(s, node) - mbsri_sensitivity_time(s, node - 1);
    for (int k = 0; k < s->nu; ++k) jump[k] = behind[at + k] - h * rate[at + k] - before[at + k];
    return before;
}

/* The derivatives of M x in the parameters, or those of none; x NULL: none. */
static int linearise_at_rest(mbsr_sensitivity *s, long node, const double *q, const double *x)
{
    const double *zero = s->given + 2 * (s->nq + s->nu) + s->nu;
    const int status = mbsr_derivatives_inverse(s->derivatives, mbsri_sensitivity_time(s, node - 1),
                                                q, zero, x ? x : zero, NULL);
    return status ? mbsri_sensitivity_fail(s, status, mbsr_derivatives_error(s->derivatives),
                                           "sensitivity")
                  : MBSR_OK;
}

int mbsri_sensitivity_jump(mbsr_sensitivity *s, long node, double *p, size_t stride)
{
    double *jump = s->given + 2 * (s->nq + s->nu), *tau = s->work, *unit = s->work + 4 * s->size;
    if (s->plain || mbsri_kept_at(s, node)->crossed) return MBSR_OK;
    const double *q = find_jump(s, node, jump);
    int status = MBSR_OK;
    for (int way = 0; way < 2 && !status; ++way) {
        status = linearise_at_rest(s, node, q, way == 0 ? jump : NULL);
        for (int k = 0; k < s->parameters && !status; ++k) {
            for (int l = 0; l < s->parameters; ++l) unit[l] = l == k ? 1.0 : 0.0;
            status = mbsr_derivatives_parameter_tangent(s->derivatives, unit, tau, NULL);
            double *to = p + (size_t)k * stride;
            for (int l = 0; l < s->nu && !status; ++l) to[l] += way == 0 ? -tau[l] : tau[l];
        }
    }
    return status;
}

int mbsri_sensitivity_jump_back(mbsr_sensitivity *s, long node, const double *w, double *by)
{
    double *jump = s->given + 2 * (s->nq + s->nu), *part = jump + 2 * s->nu;
    if (s->plain || mbsri_kept_at(s, node)->crossed) return MBSR_OK;
    const double *q = find_jump(s, node, jump);
    int status = MBSR_OK;
    for (int way = 0; way < 2 && !status; ++way) {
        status = linearise_at_rest(s, node, q, way == 0 ? jump : NULL);
        if (!status) status = mbsr_derivatives_parameter_adjoint(s->derivatives, w, NULL, part);
        for (int l = 0; l < s->parameters && !status; ++l) by[l] += way == 0 ? -part[l] : part[l];
    }
    return status;
}
