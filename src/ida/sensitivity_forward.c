/* Sensitivities of runs: forward.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "ida/error.h"
#include "ida/sensitivity_record.h"

#include <string.h>

static void give_output(const mbsri_forward_run *f, const mbsri_formula *at, int output,
                        double *all_dq, double *all_du)
{
    const mbsr_sensitivity *s = f->s;
    const size_t nq = (size_t)s->nq, nu = (size_t)s->nu, times = s->time.count;
    for (int k = 0; k < s->parameters; ++k) {
        const size_t line = (size_t)k * times + (size_t)output;
        double *dq = all_dq ? all_dq + line * nq : NULL, *du = all_du ? all_du + line * nu : NULL;
        if (dq) memset(dq, 0, nq * sizeof *dq);
        if (du) memset(du, 0, nu * sizeof *du);
        for (int i = 0; i <= at->order; ++i) {
            const double *x = mbsri_forward_node(f, at->node - i, k), *u = x + nq + nu;
            for (size_t l = 0; l < nq && dq; ++l) dq[l] += at->weight[i] * x[l];
            for (size_t l = 0; l < nu && du; ++l) du[l] += at->weight[i] * u[l];
        }
    }
}

/* Along all nodes, to the outputs. */
static int run_forward(mbsri_forward_run *f, double *dq, double *du, mbsri_step_errors *errors)
{
    const mbsr_sensitivity *s = f->s;
    const double *time = s->time.data;
    const int times = (int)s->time.count;
    mbsri_formula at = mbsri_sensitivity_output(s, 1, time[0]);
    int status = MBSR_OK, next = 0;
    for (long node = 1; next < times && !status; ++node) {
        status = mbsri_forward_step(f, node);
        if (!status) mbsri_sensitivity_note_errors(f, node, errors);
        while (!status && next < times && at.node == node) {
            give_output(f, &at, next, dq, du);
            if (++next < times) at = mbsri_sensitivity_output(s, node, time[next]);
        }
    }
    return status;
}

int mbsr_sensitivity_forward(mbsr_sensitivity *sensitivity, double *dq, double *du)
{
    mbsr_sensitivity *s = sensitivity;
    if (!s) return MBSR_ERR_NULL;
    if (!s->run.made)
        return mbsri_ida_refuse(&s->error, MBSR_ERR_SEQUENCE,
                                "mbsr_sensitivity_forward: call mbsr_sensitivity_run first");
    const size_t parameters = (size_t)s->parameters,
                 nodes = (size_t)MBSRI_NODES * parameters * (size_t)s->size,
                 sources = parameters * (size_t)s->nu, count = nodes + sources + 2 * parameters;
    double *memory = mbsri_sensitivity_take(count);
    if (!memory)
        return mbsri_ida_refuse(&s->error, MBSR_ERR_NO_MEMORY,
                                "mbsr_sensitivity_forward: no memory for %d parameters",
                                s->parameters);
    mbsri_forward_run f = {.s = s, .count = s->parameters, .node = memory, .tau = memory + nodes};
    mbsri_step_errors errors = {f.tau + sources, f.tau + sources + parameters};
    int status = run_forward(&f, dq, du, &errors);
    if (!status && !s->run.divided && !mbsri_sensitivity_is_fine(&f, &errors)) {
        status = mbsri_sensitivity_divide(s);
        memset(memory, 0, count * sizeof *memory);
        if (!status) status = run_forward(&f, dq, du, &errors);
    }
    s->run.checked = s->run.checked || !status;
    mbsri_sensitivity_free(memory);
    return status;
}
