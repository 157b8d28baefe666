/* Whether the forces along directions without mass balance at a state.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "massless/imbalance.h"

#include "algebra/dense.h"
#include "base/error.h"
#include "base/memory.h"
#include "dynamics/entry.h"
#include "forms/dae.h"
#include "recursion/backward.h"
#include "recursion/elements.h"
#include "recursion/kinematics.h"
#include "recursion/not_finite.h"
#include "recursion/rank.h"
#include "recursion/sizes.h"
#include "recursion/spans.h"

#include <mbsrank/newton.h>
#include <mbsrank/driver.h>

#include <math.h>

/* gamma of null vector l of a group, from the forces in vec; the vector itself. */
static double defect_of(const mbsr_model *m, const mbsr_data *d, const mbsri_group *g, int l,
                        double *vector)
{
    const double *X = d->X + m->body[g->member[0]].nn + (size_t)(l * g->n);
    double gamma = 0.0;
    for (int k = 0; k < g->n; ++k) {
        vector[k] = d->s[g->ig + k] * X[k];
        gamma += vector[k] * d->vec[k];
    }
    return gamma;
}

/* The group that body i heads, of no rates where it heads none, with its forces to vec; its rank.
 */
static int open_group(const mbsr_model *m, mbsr_data *d, int i, mbsri_group *g)
{
    g->n = 0;
    if (!mbsri_heads(m, d, i)) return 0;
    *g = mbsri_group_of(m, d, i);
    const int rank = mbsri_group_rank(d, g);
    if (rank < g->n) mbsri_null_force(m, d, g, d->e + g->ig, d->vec);
    return rank;
}

/* The work of gamma on a motion along the vector over the span of one of its rates, the first to be
 * passed, J. */
static double work_of(const mbsr_model *m, const mbsri_spans *spans, const mbsri_group *g,
                      const double *vector, double gamma)
{
    double passed = 0.0;
    int at = 0;
    for (int k = 0; k < g->members; ++k) {
        const mbsri_body *b = m->body + g->member[k];
        for (int l = 0; l < b->n; ++l, ++at)
            passed = fmax(passed, fabs(vector[at]) / mbsri_coordinate_span(spans, m, b, true, l));
    }
    return passed > 0.0 ? fabs(gamma) / passed : 0.0;
}

double mbsri_work_of_forces(const mbsr_model *m, const mbsr_data *d)
{
    const mbsri_spans spans = mbsri_spans_of(m, NULL);
    double largest = 0.0;
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        for (int c = 0; c < b->d; ++c)
            largest = fmax(largest, fabs(d->f[b->v + (size_t)c]) * mbsri_pose_span(&spans, b, c));
        for (int k = 0; k < b->n; ++k)
            largest = fmax(largest,
                           fabs(d->tau[b->iu + k]) * mbsri_coordinate_span(&spans, m, b, true, k));
    }
    return largest;
}

double mbsri_largest_defect(const mbsr_model *m, mbsr_data *d, bool relative, double least,
                            int *head)
{
    const mbsri_spans spans = mbsri_spans_of(m, NULL);
    double largest = 0.0, *vector = d->scratch;
    if (head) *head = 0;
    if (relative) mbsri_gross_forces(m, d);
    for (int i = 1; i <= m->bodies; ++i) {
        mbsri_group g;
        const int rank = open_group(m, d, i, &g);
        for (int l = rank; l < g.n; ++l) {
            const double gamma = fabs(defect_of(m, d, &g, l, vector));
            const double size = relative ? mbsri_gross_load(m, d, &g, vector) : 1.0;
            if (!(gamma > largest * size)) continue;
            if (!(work_of(m, &spans, &g, vector, gamma) > least)) continue;
            largest = gamma / size;
            if (head) *head = i;
        }
    }
    return largest;
}

double mbsri_largest_load(const mbsr_model *m, mbsr_data *d)
{
    double largest = 0.0, *vector = d->scratch;
    mbsri_gross_forces(m, d);
    for (int i = 1; i <= m->bodies; ++i) {
        mbsri_group g;
        const int rank = open_group(m, d, i, &g);
        for (int l = rank; l < g.n; ++l) {
            defect_of(m, d, &g, l, vector);
            largest = fmax(largest, mbsri_gross_load(m, d, &g, vector));
        }
    }
    return largest;
}

void mbsri_defects(const mbsr_model *m, mbsr_data *d, double share, double *list)
{
    const mbsri_spans spans = mbsri_spans_of(m, NULL);
    double *vector = d->scratch;
    mbsri_zero((size_t)m->bodies + 1, list);
    mbsri_gross_forces(m, d);
    for (int i = 1; i <= m->bodies; ++i) {
        mbsri_group g;
        const int rank = open_group(m, d, i, &g);
        for (int l = rank; l < g.n; ++l) {
            const double gamma = fabs(defect_of(m, d, &g, l, vector));
            if (gamma > share * mbsri_gross_load(m, d, &g, vector))
                list[i] = fmax(list[i], work_of(m, &spans, &g, vector, gamma));
        }
    }
}

/* Evaluates all stages at q and u. */
static int evaluate_stages(const mbsr_model *m, mbsr_data *d, double t, const double *q,
                           const double *u)
{
    int status = mbsri_positions(m, d, t, q);
    if (!status) status = mbsri_velocities(m, d, u);
    if (!status) status = mbsri_forces(m, d, NULL, NULL);
    return status ? status : mbsri_backward(m, d);
}

/* One step of Newton's method on F_u = 0 of the momentum form; zero and not *found where it cannot
 * be had. */
static int correct(const mbsr_model *m, mbsr_data *d, double t, const double *q, const double *u,
                   double *dq, double *du, bool *found)
{
    const mbsri_spans spans = mbsri_spans_of(m, NULL);
    const double c = 100.0 * mbsri_span_rate(&spans);
    const size_t nq = (size_t)m->nq, nu = (size_t)m->nu, size = nq + 2 * nu;
    mbsr_newton *newton;
    mbsr_error error;
    *found = false;
    mbsri_zero(nq, dq);
    mbsri_zero(nu, du);
    double *y = mbsri_allocate(&m->allocator, 4 * size * sizeof *y), *yp = y + size, *r = yp + size,
           *x = r + size;
    if (!y)
        return mbsri_fail(&d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "mbsr_dae_imbalance: no memory for %zu numbers", 4 * size);
    int status = mbsr_newton_create(m, MBSR_DAE_MOMENTUM, NULL, &newton, &error);
    if (status) {
        d->error = error;
        mbsri_release(&m->allocator, y);
        return status;
    }
    mbsri_zero(size, yp);
    status = mbsri_pack(&mbsri_form_momentum, m, d, t, q, u, y);
    if (!status) status = mbsr_dae_residual(m, d, MBSR_DAE_MOMENTUM, t, y, yp, r);
    mbsri_zero(nq + nu, r);
    if (!status) {
        const mbsr_error before = d->error;
        int solved = mbsr_newton_factor(newton, d, t, y, yp, c);
        if (!solved) solved = mbsr_newton_solve(newton, r, x);
        d->error = before;
        *found = solved == MBSR_OK;
        if (*found) {
            for (size_t k = 0; k < nq; ++k) dq[k] = -x[k];
            for (size_t k = 0; k < nu; ++k) du[k] = -x[nq + nu + k];
            status = mbsri_check_result(m, d, size, x, "mbsr_dae_imbalance");
        }
    }
    mbsr_newton_destroy(newton);
    mbsri_release(&m->allocator, y);
    return status;
}

/* Whether changes of positions and rates are rounding beside what these span: the former in
 * Newton's c, which makes rates of them. */
static bool is_rounding(const mbsr_model *m, const double *u, const double *du)
{
    static const double nothing = 1e-6;
    const mbsri_spans spans = mbsri_spans_of(m, NULL);
    double rate = mbsri_span_rate(&spans), change = 0.0;
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        for (int k = 0; k < b->n; ++k) {
            const double span = mbsri_rate_span(&spans, m, b, k);
            rate = fmax(rate, fabs(u[b->u + k]) / span);
            change = fmax(change, fabs(du[b->u + k]) / span);
        }
    }
    return change <= nothing * rate;
}

/* The share at the state q, u with the data at its forces; where some is left, Newton's step (dq,
 * du; `asked`: in any case) says whether it is more than what rounding of q and u makes of forces
 * that are next to none. */
static int measure_balance(const mbsr_model *m, mbsr_data *d, double t, const double *q, bool asked,
                           double *share, int *body, double *dq, double *du)
{
    static const double some = 1e-9;
    const double *u = q + m->nq;
    bool found = false;
    int head = 0;
    const double largest = mbsri_largest_defect(m, d, true, 0.0, &head);
    int status = mbsri_check_result(m, d, 1, &largest, "mbsr_dae_imbalance");
    if (!status && (asked || largest > some)) status = correct(m, d, t, q, u, dq, du, &found);
    if (status) return status;
    const bool none = largest > some && found && is_rounding(m, u, du);
    *share = none ? 0.0 : largest;
    *body = head > 0 && !none ? m->body[head].id : MBSR_NONE;
    return MBSR_OK;
}

int mbsr_dae_imbalance(const mbsr_model *model, mbsr_data *data, mbsr_dae_form form, double t,
                       const double *y, double *share, int *body, double *dq, double *du)
{
    static const char name[] = "mbsr_dae_imbalance";
    int status = mbsri_enter(model, data, y && share && body, MBSRI_STAGE_NONE, name);
    if (status) return status;
    if (model->rows > 0)
        return mbsri_fail(&data->error, MBSR_ERR_CLOSURES, MBSR_NONE, MBSR_NONE,
                          "%s: the model has closures, which may hold directions without mass",
                          name);
    const mbsri_dae_form *found = mbsri_find_form(form);
    if (!found)
        return mbsri_fail(&data->error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                          "%s: form is %d, no such form", name, (int)form);
    const size_t nq = (size_t)model->nq, nu = (size_t)model->nu, count = nq + nu;
    double *q = mbsri_allocate(&model->allocator, 2 * count * sizeof *q), *step = q + count;
    if (!q)
        return mbsri_fail(&data->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "%s: no memory for %zu coordinates", name, count);
    status = mbsri_unpack(found, model, data, t, y, q, q + nq);
    if (!status) status = evaluate_stages(model, data, t, q, q + nq);
    if (!status)
        status = measure_balance(model, data, t, q, dq && du, share, body, step, step + nq);
    if (!status && dq && du) {
        mbsri_copy(nq, step, dq);
        mbsri_copy(nu, step + nq, du);
    }
    mbsri_release(&model->allocator, q);
    return status;
}
