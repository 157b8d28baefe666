/* Sensitivities of runs: errors of steps.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The error of a step of backward differences of order k is about
 *
 *   |x - x_expected| / (k + 1)
 *
 * with x the derivatives of q in a parameter, by the tolerances of q, and what the nodes before
 * lead to expect of it. Of the first step of all, what x changes by is twice the error or more. */
#include "ida/record.h"
#include "ida/sensitivity_record.h"

#include <math.h>

/* The largest of q in x, less those of y (NULL: 0), by their tolerances. */
static double by_tolerances(const mbsr_sensitivity *s, const double *x, const double *y)
{
    const double *atol = N_VGetArrayPointer(s->ida->tol.atol);
    double largest = 0.0;
    for (int k = 0; k < s->nq; ++k) {
        if (atol[k] > 0.0) largest = fmax(largest, fabs(x[k] - (y ? y[k] : 0.0)) / atol[k]);
    }
    return largest;
}

/* What the nodes before lead to expect of sum k at the node, less what it is, into x. */
static void miss(const mbsri_forward_run *f, long node, int nodes, int k, double *x)
{
    const mbsr_sensitivity *s = f->s;
    const double t = mbsri_sensitivity_time(s, node), *now = mbsri_forward_node(f, node, k);
    for (int l = 0; l < s->nq; ++l) x[l] = -now[l];
    for (int i = 1; i <= nodes; ++i) {
        const double at = mbsri_sensitivity_time(s, node - i),
                     *before = mbsri_forward_node(f, node - i, k);
        double weight = 1.0;
        for (int j = 1; j <= nodes; ++j) {
            const double other = mbsri_sensitivity_time(s, node - j);
            if (j != i) weight *= (t - other) / (at - other);
        }
        for (int l = 0; l < s->nq; ++l) x[l] += weight * before[l];
    }
}

/* The error of sum k at a node. */
double mbsri_sensitivity_error_of(const mbsri_forward_run *f, long node, int k)
{
    mbsr_sensitivity *s = f->s;
    const int since = mbsri_kept_at(s, node)->since, order = mbsri_sensitivity_rate(s, node).order,
              nodes = order < since ? order + 1 : since + 1;
    if (node == 1)
        return 0.5 * by_tolerances(s, mbsri_forward_node(f, 1, k), mbsri_forward_node(f, 0, k));
    if (since == 0 || nodes >= MBSRI_NODES) return 0.0;
    miss(f, node, nodes, k, s->work);
    return by_tolerances(s, s->work, NULL) / (order + 1);
}

void mbsri_sensitivity_note_errors(const mbsri_forward_run *f, long node, mbsri_step_errors *e)
{
    for (int k = 0; k < f->count; ++k) {
        e->largest[k] =
            fmax(e->largest[k], by_tolerances(f->s, mbsri_forward_node(f, node, k), NULL));
        if (node > 1) e->worst[k] = fmax(e->worst[k], mbsri_sensitivity_error_of(f, node, k));
    }
}

double mbsri_sensitivity_allowed(const mbsri_forward_run *f, int k, double largest)
{
    static const double part = 0.3;
    const mbsr_sensitivity *s = f->s;
    const double value = f->weight || s->value[k] == 0.0 ? 1.0 : fabs(s->value[k]);
    return part * fmax(s->opt.ida.rtol * largest, 1.0 / value);
}

bool mbsri_sensitivity_is_fine(const mbsri_forward_run *f, const mbsri_step_errors *e)
{
    static const double many = 100.0; /* allowed errors: all together they are far too much */
    bool fine = true;
    for (int k = 0; k < f->count; ++k)
        fine = fine && e->worst[k] <= many * mbsri_sensitivity_allowed(f, k, e->largest[k]);
    return fine;
}
