/* Sensitivities of runs: formulas and matrices of a step.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "ida/sensitivity_record.h"

#include <string.h>

/* ---- formulas ---- */

double mbsri_sensitivity_time(const mbsr_sensitivity *s, long node)
{
    return node == 0 ? s->start : mbsri_kept_at(s, node)->t;
}

mbsri_formula mbsri_sensitivity_rate(const mbsr_sensitivity *s, long node)
{
    const mbsri_kept_step *step = mbsri_kept_at(s, node);
    mbsri_formula f = {.node = node,
                       .order = step->order < step->since + 1 ? step->order : step->since + 1};
    double h[MBSRI_NODES]; /* from each node to the last */
    for (int i = 0; i <= f.order; ++i) h[i] = step->t - mbsri_sensitivity_time(s, node - i);
    for (int i = 1; i <= f.order; ++i) {
        f.weight[0] += 1.0 / h[i];
        f.weight[i] = -1.0 / h[i];
        for (int j = 1; j <= f.order; ++j)
            if (j != i) f.weight[i] *= h[j] / (h[j] - h[i]);
    }
    return f;
}

mbsri_formula mbsri_sensitivity_output(const mbsr_sensitivity *s, long from, double t)
{
    const long last = (long)s->step.count;
    mbsri_formula f = {.node = from};
    while (f.node < last && mbsri_kept_at(s, f.node)->t < t) ++f.node;
    /* the first step of a segment has no other before it */
    if (mbsri_kept_at(s, f.node)->since == 0 && f.node < last &&
        mbsri_kept_at(s, f.node + 1)->since == 1)
        ++f.node;
    const mbsri_kept_step *step = mbsri_kept_at(s, f.node);
    f.order = step->since == 0 ? 1 : step->order < step->since ? step->order : step->since;
    for (int i = 0; i <= f.order; ++i) {
        const double at = mbsri_sensitivity_time(s, f.node - i);
        f.weight[i] = 1.0;
        for (int j = 0; j <= f.order; ++j) {
            const double other = mbsri_sensitivity_time(s, f.node - j);
            if (j != i) f.weight[i] *= (t - other) / (at - other);
        }
    }
    return f;
}

double mbsri_sensitivity_short(const mbsr_sensitivity *s, long node)
{
    static const double part = 1e-3; /* of the step that follows */
    return 1.0 / (part * (mbsri_kept_at(s, node)->t - mbsri_sensitivity_time(s, node - 1)));
}

/* ---- matrices ---- */

const double *mbsri_sensitivity_state(const mbsr_sensitivity *s, long node)
{
    return (const double *)s->state.data + 2 * (size_t)s->size * (size_t)(node - 1);
}

int mbsri_sensitivity_at(mbsr_sensitivity *s, mbsr_newton *newton, long node, double c)
{
    const double *y = mbsri_sensitivity_state(s, node), *yp = y + s->size;
    const double t = mbsri_kept_at(s, node)->t;
    const int status = mbsr_newton_factor(newton, s->data, t, y, yp, c);
    return status ? mbsri_sensitivity_fail(s, status, mbsr_newton_error(newton), "sensitivity")
                  : MBSR_OK;
}

int mbsri_sensitivity_sources(mbsr_sensitivity *s, long node)
{
    const double *y = mbsri_sensitivity_state(s, node), *yp = y + s->size, *u = y + s->nq + s->nu;
    const int status = mbsr_derivatives_inverse(s->derivatives, mbsri_kept_at(s, node)->t, y, u,
                                                yp + s->nq + s->nu, NULL);
    return status ? mbsri_sensitivity_fail(s, status, mbsr_derivatives_error(s->derivatives),
                                           "sensitivity")
                  : MBSR_OK;
}
