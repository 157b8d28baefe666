/* Sensitivities of runs: adjoint.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The systems of sensitivity_forward.c transposed, the last first. What later steps and outputs say
 * of a node stands in `node`. */
#include "ida/error.h"
#include "ida/sensitivity_record.h"

#include <math.h>
#include <string.h>

typedef struct adjoint_run {
    mbsr_sensitivity *s;
    double *node;            /* MBSRI_NODES x size */
    double *tau, *by;        /* nu; parameters: of one step */
    const double *w_q, *w_u; /* the caller's */
} adjoint_run;

static double *node_of(const adjoint_run *a, long node)
{
    return a->node + (size_t)(node % MBSRI_NODES) * (size_t)a->s->size;
}

/* R^T x and -E^T x of the x with (A + c E)^T x = v. */
static int solve_back(adjoint_run *a, const double *v, double *tau, double *history)
{
    mbsr_sensitivity *s = a->s;
    const int status = mbsr_newton_solve_adjoint(s->back, v, tau, history);
    return status ? mbsri_sensitivity_fail(s, status, mbsr_newton_error(s->back),
                                           "mbsr_sensitivity_adjoint")
                  : MBSR_OK;
}

/* by += T^T tau at the step. */
static int add_gradient(adjoint_run *a, long node, double *by)
{
    mbsr_sensitivity *s = a->s;
    int status = mbsri_sensitivity_sources(s, node);
    if (status) return status;
    status = mbsr_derivatives_parameter_adjoint(s->derivatives, a->tau, NULL, a->by);
    if (status)
        return mbsri_sensitivity_fail(s, status, mbsr_derivatives_error(s->derivatives),
                                      "mbsr_sensitivity_adjoint");
    for (int k = 0; k < s->parameters; ++k) by[k] += a->by[k];
    return MBSR_OK;
}

/* The short step before the first of a segment; tau += what it says. What was said of the node
 * before becomes what that node's own value has to say. */
static int end_segment(adjoint_run *a, long node, double *by)
{
    mbsr_sensitivity *s = a->s;
    const double c = mbsri_sensitivity_short(s, node);
    double *before = node_of(a, node - 1), *tau = s->work + s->size;
    int status = mbsri_sensitivity_at(s, s->back, node, c);
    if (!status) status = solve_back(a, before, tau, before);
    if (status) return status;
    for (int l = 0; l < s->size; ++l) before[l] *= -c;
    for (int k = 0; k < s->nu; ++k) a->tau[k] += tau[k];
    return mbsri_sensitivity_jump_back(s, node, before + s->nq, by);
}

static int step_back(adjoint_run *a, long node, double *by)
{
    mbsr_sensitivity *s = a->s;
    const mbsri_formula rate = mbsri_sensitivity_rate(s, node);
    double *said = node_of(a, node), *history = s->work;
    int status = mbsri_sensitivity_at(s, s->back, node, rate.weight[0]);
    if (!status) status = solve_back(a, said, a->tau, history);
    if (status) return status;
    memset(said, 0, (size_t)s->size * sizeof *said);
    for (int i = 1; i <= rate.order; ++i) {
        double *before = node_of(a, node - i);
        for (int l = 0; l < s->size; ++l) before[l] += rate.weight[i] * history[l];
    }
    if (mbsri_kept_at(s, node)->since == 0) status = end_segment(a, node, by);
    return status ? status : add_gradient(a, node, by);
}

/* What an output says of its nodes. */
static void take_output(const adjoint_run *a, const mbsri_formula *at, int output)
{
    const mbsr_sensitivity *s = a->s;
    const size_t nq = (size_t)s->nq, nu = (size_t)s->nu;
    for (int i = 0; i <= at->order; ++i) {
        double *x = node_of(a, at->node - i), *u = x + nq + nu;
        for (size_t l = 0; l < nq && a->w_q; ++l)
            x[l] += at->weight[i] * a->w_q[(size_t)output * nq + l];
        for (size_t l = 0; l < nu && a->w_u; ++l)
            u[l] += at->weight[i] * a->w_u[(size_t)output * nu + l];
    }
}

/* The formulas of all outputs. */
static void find_outputs(const mbsr_sensitivity *s, mbsri_formula *at)
{
    const double *time = s->time.data;
    long from = 1;
    for (size_t k = 0; k < s->time.count; ++k) {
        at[k] = mbsri_sensitivity_output(s, from, time[k]);
        from = at[k].node;
    }
}

static int run_back(adjoint_run *a, mbsri_formula *at, double *by)
{
    mbsr_sensitivity *s = a->s;
    int left = (int)s->time.count, status = MBSR_OK;
    find_outputs(s, at);
    for (long node = at[left - 1].node; node >= 1 && !status; --node) {
        for (; left > 0 && at[left - 1].node == node; --left)
            take_output(a, at + left - 1, left - 1);
        status = step_back(a, node, by);
    }
    return status;
}

static bool weights_are_finite(size_t count, const double *w)
{
    for (size_t k = 0; k < count && w; ++k)
        if (!isfinite(w[k])) return false;
    return true;
}

int mbsr_sensitivity_adjoint(mbsr_sensitivity *sensitivity, const double *w_q, const double *w_u,
                             double *by)
{
    static const char name[] = "mbsr_sensitivity_adjoint";
    mbsr_sensitivity *s = sensitivity;
    if (!s) return MBSR_ERR_NULL;
    if (!by) return mbsri_ida_refuse(&s->error, MBSR_ERR_NULL, "%s: by is NULL", name);
    if (!s->run.made)
        return mbsri_ida_refuse(&s->error, MBSR_ERR_SEQUENCE, "%s: call mbsr_sensitivity_run first",
                                name);
    const size_t times = s->time.count;
    if (!weights_are_finite(times * (size_t)s->nq, w_q) ||
        !weights_are_finite(times * (size_t)s->nu, w_u))
        return mbsri_ida_refuse(&s->error, MBSR_NOT_FINITE, "%s: a weight is not finite", name);
    int status = mbsri_sensitivity_check(s);
    if (status) return status;
    const size_t nodes = (size_t)MBSRI_NODES * (size_t)s->size, nu = (size_t)s->nu,
                 count = nodes + nu + 2 * (size_t)s->parameters;
    double *memory = mbsri_sensitivity_take(count);
    mbsri_kept outputs = {0};
    if (!memory || !mbsri_sensitivity_reserve(&outputs, times, sizeof(mbsri_formula)))
        status = mbsri_ida_refuse(&s->error, MBSR_ERR_NO_MEMORY, "%s: no memory", name);
    if (!status) {
        adjoint_run a = {.s = s,
                         .node = memory,
                         .tau = memory + nodes,
                         .by = memory + nodes + nu,
                         .w_q = w_q,
                         .w_u = w_u};
        double *sum = a.by + s->parameters;
        status = run_back(&a, outputs.data, sum);
        if (!status) memcpy(by, sum, (size_t)s->parameters * sizeof *by);
    }
    mbsri_sensitivity_free(memory);
    mbsri_sensitivity_free(outputs.data);
    return status;
}
