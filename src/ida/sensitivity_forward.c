/* Sensitivities of runs: forward.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "ida/error.h"
#include "ida/sensitivity_record.h"

#include <string.h>

/* What is known of the last nodes: for each node, parameter by parameter. */
typedef struct forward_run {
    mbsr_sensitivity *s;
    double *node;    /* MBSRI_NODES x parameters x size */
    double *tau;     /* parameters x nu: T */
    double *dq, *du; /* the caller's */
    int next;        /* output */
} forward_run;

static double *node_of(const forward_run *f, long node, int parameter)
{
    const size_t size = (size_t)f->s->size, parameters = (size_t)f->s->parameters;
    return f->node + ((size_t)(node % MBSRI_NODES) * parameters + (size_t)parameter) * size;
}

/* T of all parameters. */
static int find_sources(forward_run *f, long node)
{
    mbsr_sensitivity *s = f->s;
    double *unit = s->work + 4 * s->size;
    int status = mbsri_sensitivity_sources(s, node);
    memset(unit, 0, (size_t)s->parameters * sizeof *unit);
    for (int k = 0; k < s->parameters && !status; ++k) {
        unit[k] = 1.0;
        status = mbsr_derivatives_parameter_tangent(s->derivatives, unit,
                                                    f->tau + (size_t)k * (size_t)s->nu, NULL);
        unit[k] = 0.0;
        if (status)
            mbsri_sensitivity_fail(s, status, mbsr_derivatives_error(s->derivatives),
                                   "mbsr_sensitivity_forward");
    }
    return status;
}

/* Solves (A + c E) x = R T - E history for parameter k, into x. */
static int solve_forward(forward_run *f, int k, const double *history, double *x)
{
    mbsr_sensitivity *s = f->s;
    const double *tau = f->tau + (size_t)k * (size_t)s->nu;
    const int status = mbsr_newton_solve_sensitivity(s->newton, tau, history, x);
    return status ? mbsri_sensitivity_fail(s, status, mbsr_newton_error(s->newton),
                                           "mbsr_sensitivity_forward")
                  : MBSR_OK;
}

/* The short step before the first of a segment. */
static int begin_segment(forward_run *f, long node)
{
    mbsr_sensitivity *s = f->s;
    const double c = mbsri_sensitivity_short(s, node);
    double *history = s->work + 2 * s->size;
    int status = mbsri_sensitivity_jump(s, node, node_of(f, node - 1, 0) + s->nq, (size_t)s->size);
    if (!status) status = find_sources(f, node);
    if (!status) status = mbsri_sensitivity_at(s, s->newton, node, c);
    for (int k = 0; k < s->parameters && !status; ++k) {
        double *before = node_of(f, node - 1, k);
        for (int l = 0; l < s->size; ++l) history[l] = -c * before[l];
        status = solve_forward(f, k, history, before);
    }
    return status;
}

static int step_forward(forward_run *f, long node)
{
    mbsr_sensitivity *s = f->s;
    const mbsri_formula rate = mbsri_sensitivity_rate(s, node);
    double *history = s->work + 2 * s->size;
    int status =
        mbsri_kept_at(s, node)->since == 0 ? begin_segment(f, node) : find_sources(f, node);
    if (!status) status = mbsri_sensitivity_at(s, s->newton, node, rate.weight[0]);
    for (int k = 0; k < s->parameters && !status; ++k) {
        memset(history, 0, (size_t)s->size * sizeof *history);
        for (int i = 1; i <= rate.order; ++i) {
            const double *before = node_of(f, node - i, k);
            for (int l = 0; l < s->size; ++l) history[l] += rate.weight[i] * before[l];
        }
        status = solve_forward(f, k, history, node_of(f, node, k));
    }
    return status;
}

static void give_output(const forward_run *f, const mbsri_formula *at, int output)
{
    const mbsr_sensitivity *s = f->s;
    const size_t nq = (size_t)s->nq, nu = (size_t)s->nu, times = s->time.count;
    for (int k = 0; k < s->parameters; ++k) {
        const size_t line = (size_t)k * times + (size_t)output;
        double *dq = f->dq ? f->dq + line * nq : NULL, *du = f->du ? f->du + line * nu : NULL;
        if (dq) memset(dq, 0, nq * sizeof *dq);
        if (du) memset(du, 0, nu * sizeof *du);
        for (int i = 0; i <= at->order; ++i) {
            const double *x = node_of(f, at->node - i, k), *u = x + nq + nu;
            for (size_t l = 0; l < nq && dq; ++l) dq[l] += at->weight[i] * x[l];
            for (size_t l = 0; l < nu && du; ++l) du[l] += at->weight[i] * u[l];
        }
    }
}

int mbsr_sensitivity_forward(mbsr_sensitivity *sensitivity, double *dq, double *du)
{
    mbsr_sensitivity *s = sensitivity;
    if (!s) return MBSR_ERR_NULL;
    if (!s->ready)
        return mbsri_ida_refuse(&s->error, MBSR_ERR_SEQUENCE,
                                "mbsr_sensitivity_forward: call mbsr_sensitivity_run first");
    const size_t nodes = (size_t)MBSRI_NODES * (size_t)s->parameters * (size_t)s->size,
                 sources = (size_t)s->parameters * (size_t)s->nu;
    double *memory = mbsri_sensitivity_take(nodes + sources + 1);
    if (!memory)
        return mbsri_ida_refuse(&s->error, MBSR_ERR_NO_MEMORY,
                                "mbsr_sensitivity_forward: no memory for %d parameters",
                                s->parameters);
    forward_run f = {.s = s, .node = memory, .tau = memory + nodes, .dq = dq, .du = du};
    const double *time = s->time.data;
    const int times = (int)s->time.count;
    mbsri_formula at = mbsri_sensitivity_output(s, 1, time[0]);
    int status = MBSR_OK;
    for (long node = 1; f.next < times && !status; ++node) {
        status = step_forward(&f, node);
        while (!status && f.next < times && at.node == node) {
            give_output(&f, &at, f.next);
            if (++f.next < times) at = mbsri_sensitivity_output(s, node, time[f.next]);
        }
    }
    mbsri_sensitivity_free(memory);
    return status;
}
