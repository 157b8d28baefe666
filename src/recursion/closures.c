/* Closures over the tree: rows, their derivatives, and what they exert.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A closure writes its velocity rows in the velocities V of its bodies and the rates u of their
 * joints,
 *
 *   rate = C (V, u) + g_t,
 *
 * and the tree does the rest: with V_i = -(H_i V_pi + J_i u_i + kI_i), body forces f = C_V^T lambda
 * and joint forces tau = C_u^T lambda act on the joints as tau_i - J_i^T f_i, f_pi += -H_i^T f_i. A
 * root that moves is a body whose V is given. */
#include "recursion/closures.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "base/error.h"
#include "model/query.h"
#include "recursion/closure_differences.h"
#include "recursion/closure_rows.h"

const mbsri_closure *mbsri_all_closures(const mbsr_model *m)
{
    static const mbsri_closure none = {.row = 0};
    return m->closures.data ? m->closures.data : &none;
}

static int number_of(const mbsr_model *m, const mbsri_closure *c)
{
    return (int)(c - mbsri_all_closures(m));
}

int mbsri_closure_failed(const mbsr_model *m, mbsr_data *d, const mbsri_closure *c, int status,
                         const char *function)
{
    char label[MBSRI_LABEL];
    return mbsri_fail(&d->error, status, MBSR_NONE, MBSR_NONE, "%s (%s): %s returned %d at t = %g",
                      mbsri_closure_label(m, number_of(m, c), label), c->def.table->name, function,
                      status, d->t);
}

/* MBSR_NOT_FINITE, with the closure's name, if x (n) is not finite. */
static int check_rows_finite(const mbsr_model *m, mbsr_data *d, const mbsri_closure *c, size_t n,
                             const double *x, const char *what)
{
    if (mbsri_finite(n, x)) return MBSR_OK;
    char label[MBSRI_LABEL];
    return mbsri_fail(
        &d->error, MBSR_NOT_FINITE, MBSR_NONE, MBSR_NONE, "%s (%s): %s is not finite at t = %g",
        mbsri_closure_label(m, number_of(m, c), label), c->def.table->name, what, d->t);
}

/* Those of closure c. */
static int gaps_of(const mbsr_model *m, mbsr_data *d, const mbsri_closure *c,
                   const mbsri_closure_view *view, double *g)
{
    const int status = mbsri_closure_position(c, &view->args, g);
    if (status) return mbsri_closure_failed(m, d, c, status, "position");
    return check_rows_finite(m, d, c, (size_t)c->position_rows, g, "a gap");
}

int mbsri_closure_gaps(const mbsr_model *m, mbsr_data *d, double *g)
{
    mbsri_closure_view view;
    mbsri_zero((size_t)m->position_rows, g);
    for (const mbsri_closure *c = mbsri_all_closures(m), *end = c + m->closures.count; c < end;
         ++c) {
        if (c->position_rows == 0) continue;
        mbsri_view_closure(m, d, c, false, &view);
        const int status = gaps_of(m, d, c, &view, g + c->position_row);
        if (status) return status;
    }
    return MBSR_OK;
}

/* The derivatives of closure c into closure_C, where it is zero. */
static int jacobian_of(const mbsr_model *m, mbsr_data *d, const mbsri_closure *c,
                       const mbsri_closure_view *view)
{
    const mbsr_closure_table *table = c->def.table;
    double *C = d->closure_C + c->at;
    const mbsr_closure_jacobian out = {C, c->rows, c->columns, c->column};
    const int status = table->jacobian ? mbsri_closure_jacobian(c, &view->args, &out)
                                       : mbsri_closure_slopes(m, c, view, d->closure_x, C);
    if (status)
        return mbsri_closure_failed(m, d, c, status, table->jacobian ? "jacobian" : "position");
    const size_t size = (size_t)c->rows * (size_t)c->columns;
    return check_rows_finite(m, d, c, size, C, "a derivative");
}

int mbsri_closure_jacobian_of(const mbsr_model *m, mbsr_data *d, const mbsri_closure *c)
{
    mbsri_closure_view view;
    mbsri_zero((size_t)c->rows * (size_t)c->columns, d->closure_C + c->at);
    mbsri_view_closure(m, d, c, false, &view);
    return jacobian_of(m, d, c, &view);
}

int mbsri_closure_jacobians(const mbsr_model *m, mbsr_data *d)
{
    int status = MBSR_OK;
    for (const mbsri_closure *c = mbsri_all_closures(m), *end = c + m->closures.count;
         c < end && !status; ++c)
        status = mbsri_closure_jacobian_of(m, d, c);
    return status;
}

/* The rates of closure c alone: its rows. `C` are its derivatives. */
static int closure_rate_of(const mbsr_model *m, mbsr_data *d, const mbsri_closure *c,
                           const mbsri_closure_view *view, const double *C, double *rate)
{
    const mbsr_closure_table *table = c->def.table;
    const bool bodies = !mbsri_is_coupling(c); /* V need not be there */
    mbsri_zero((size_t)c->rows, rate);
    const int status = table->drift ? mbsri_closure_table_drift(c, &view->args, rate)
                                    : mbsri_closure_drift(m, c, view, d->closure_x, rate);
    if (status) return mbsri_closure_failed(m, d, c, status, table->drift ? "drift" : "position");
    for (int k = 0; k < c->bodies; ++k) {
        const mbsr_force_body *body = view->body + k;
        if (c->column[k] < 0) continue;
        const double *block = C + (size_t)c->column[k] * (size_t)c->rows;
        if (bodies) mbsri_ax(c->rows, body->d, 1.0, block, body->V, rate);
        if (!mbsri_reads_joints(c) || !body->u) continue;
        mbsri_ax(c->rows, body->n, 1.0, block + (size_t)body->d * (size_t)c->rows, body->u, rate);
    }
    return check_rows_finite(m, d, c, (size_t)c->rows, rate, "a rate");
}

int mbsri_closure_rates(const mbsr_model *m, mbsr_data *d, double *rate)
{
    mbsri_closure_view view;
    for (const mbsri_closure *c = mbsri_all_closures(m), *end = c + m->closures.count; c < end;
         ++c) {
        mbsri_view_closure(m, d, c, true, &view);
        const int status = closure_rate_of(m, d, c, &view, d->closure_C + c->at, rate + c->row);
        if (status) return status;
    }
    return MBSR_OK;
}

/* Adds what the accelerations of the bodies are where u' is zero, times C: kII and the root's A. */
static void add_accelerations(const mbsr_model *m, mbsr_data *d, double *bias)
{
    double *A = d->closure_V;
    mbsri_copy((size_t)m->root.d, d->A, A);
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        for (int k = 0; k < b->d; ++k) A[b->v + (size_t)k] = -d->kII[b->v + (size_t)k];
        mbsri_ax(b->d, b->pred.d, -1.0, d->H + b->dp, A + b->pred.v, A + b->v);
    }
    for (const mbsri_closure *c = mbsri_all_closures(m), *end = c + m->closures.count; c < end;
         ++c) {
        for (int k = 0; k < c->bodies; ++k) {
            const mbsri_body *b = m->body + c->body[k];
            if (c->column[k] < 0) continue;
            mbsri_ax(c->rows, b->d, 1.0,
                     d->closure_C + c->at + (size_t)c->column[k] * (size_t)c->rows, A + b->v,
                     bias + c->row);
        }
    }
}

int mbsri_closure_errors(const mbsr_model *m, mbsr_data *d, double *rate, double *g)
{
    mbsri_closure_view view;
    mbsri_zero((size_t)m->position_rows, g);
    for (const mbsri_closure *c = mbsri_all_closures(m), *end = c + m->closures.count; c < end;
         ++c) {
        mbsri_view_closure(m, d, c, false, &view);
        int status = c->position_rows > 0 ? gaps_of(m, d, c, &view, g + c->position_row) : MBSR_OK;
        mbsri_view_velocities(m, d, c, &view);
        if (!status) status = closure_rate_of(m, d, c, &view, d->closure_C + c->at, rate + c->row);
        if (status) return status;
    }
    return MBSR_OK;
}

/* Of closure c where all accelerations of bodies are zero, added to its rows. */
static int bias_of(const mbsr_model *m, mbsr_data *d, const mbsri_closure *c,
                   const mbsri_closure_view *view, double *bias)
{
    const int status = c->def.table->bias ? mbsri_closure_table_bias(c, &view->args, bias)
                                          : mbsri_closure_curvature(m, d, c, view, bias);
    if (status) return mbsri_closure_failed(m, d, c, status, "bias");
    return check_rows_finite(m, d, c, (size_t)c->rows, bias, "a bias");
}

int mbsri_closure_rows_here(const mbsr_model *m, mbsr_data *d, double *bias)
{
    mbsri_closure_view view;
    for (const mbsri_closure *c = mbsri_all_closures(m), *end = c + m->closures.count; c < end;
         ++c) {
        mbsri_expect_closure(m, c);
        mbsri_view_closure(m, d, c, false, &view);
        mbsri_zero((size_t)c->rows * (size_t)c->columns, d->closure_C + c->at);
        mbsri_zero((size_t)c->rows, bias + c->row);
        int status = jacobian_of(m, d, c, &view);
        mbsri_view_velocities(m, d, c, &view);
        if (!status) status = bias_of(m, d, c, &view, bias + c->row);
        if (status) return status;
    }
    return MBSR_OK;
}

int mbsri_closure_bias(const mbsr_model *m, mbsr_data *d, double *bias)
{
    mbsri_closure_view view;
    mbsri_zero((size_t)m->rows, bias);
    for (const mbsri_closure *c = mbsri_all_closures(m), *end = c + m->closures.count; c < end;
         ++c) {
        mbsri_view_closure(m, d, c, true, &view);
        const int status = bias_of(m, d, c, &view, bias + c->row);
        if (status) return status;
    }
    add_accelerations(m, d, bias);
    for (const mbsri_closure *c = mbsri_all_closures(m), *end = c + m->closures.count; c < end;
         ++c) {
        const int status = check_rows_finite(m, d, c, (size_t)c->rows, bias + c->row, "a bias");
        if (status) return status;
    }
    return MBSR_OK;
}

/* What closure c exerts with lambda (of all rows). */
static void load_of(const mbsr_model *m, const mbsr_data *d, const mbsri_closure *c,
                    const double *lambda, double *f, double *tau)
{
    const bool joints = mbsri_reads_joints(c), bodies = !mbsri_is_coupling(c);
    for (int k = 0; k < c->bodies; ++k) {
        const mbsri_body *b = m->body + c->body[k];
        if (c->column[k] < 0 || c->body[k] == 0) continue;
        const double *block = d->closure_C + c->at + (size_t)c->column[k] * (size_t)c->rows;
        if (bodies) mbsri_atx(c->rows, b->d, 1.0, block, lambda + c->row, f + b->v);
        if (joints)
            mbsri_atx(c->rows, b->n, 1.0, block + (size_t)b->d * (size_t)c->rows, lambda + c->row,
                      tau + b->iu);
    }
}

void mbsri_closure_load(const mbsr_model *m, const mbsr_data *d, const double *lambda, double *f,
                        double *tau)
{
    for (const mbsri_closure *c = mbsri_all_closures(m), *end = c + m->closures.count; c < end; ++c)
        load_of(m, d, c, lambda, f, tau);
}

int mbsri_closure_loads_here(const mbsr_model *m, mbsr_data *d, const double *lambda,
                             const double *eta)
{
    mbsri_closure_view view;
    if (eta) mbsri_zero(m->size.v, d->closure_V);
    if (eta) mbsri_zero((size_t)m->nu, d->closure_w);
    for (const mbsri_closure *c = mbsri_all_closures(m), *end = c + m->closures.count; c < end;
         ++c) {
        mbsri_expect_closure(m, c);
        mbsri_view_closure(m, d, c, false, &view);
        mbsri_zero((size_t)c->rows * (size_t)c->columns, d->closure_C + c->at);
        const int status = jacobian_of(m, d, c, &view);
        if (status) return status;
        load_of(m, d, c, lambda, d->f, d->tau);
        if (eta) load_of(m, d, c, eta, d->closure_V, d->closure_w);
    }
    return MBSR_OK;
}

void mbsri_closure_transpose(const mbsr_model *m, mbsr_data *d, const double *x, double *y)
{
    double *f = d->closure_V, *tau = d->closure_w;
    mbsri_zero(m->size.v, f);
    mbsri_zero((size_t)m->nu, tau);
    mbsri_closure_load(m, d, x, f, tau);
    for (int i = m->bodies; i >= 1; --i) {
        const mbsri_body *b = m->body + i;
        mbsri_atx(b->d, b->n, -1.0, d->J + b->dn, f + b->v, tau + b->iu);
        mbsri_atx(b->d, b->pred.d, -1.0, d->H + b->dp, f + b->v, f + b->pred.v);
    }
    if (y) mbsri_scatter(m, tau, y);
}

void mbsri_closure_apply(const mbsr_model *m, mbsr_data *d, const double *x, double *y)
{
    double *V = d->closure_V, *u = d->closure_w;
    mbsri_gather(m, x, u);
    mbsri_zero(m->size.v, V);
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        mbsri_ax(b->d, b->pred.d, -1.0, d->H + b->dp, V + b->pred.v, V + b->v);
        mbsri_ax(b->d, b->n, -1.0, d->J + b->dn, u + b->iu, V + b->v);
    }
    mbsri_zero((size_t)m->rows, y);
    for (const mbsri_closure *c = mbsri_all_closures(m), *end = c + m->closures.count; c < end;
         ++c) {
        const bool joints = mbsri_reads_joints(c);
        for (int k = 0; k < c->bodies; ++k) {
            const mbsri_body *b = m->body + c->body[k];
            if (c->column[k] < 0) continue;
            const double *block = d->closure_C + c->at + (size_t)c->column[k] * (size_t)c->rows;
            mbsri_ax(c->rows, b->d, 1.0, block, V + b->v, y + c->row);
            if (joints)
                mbsri_ax(c->rows, b->n, 1.0, block + (size_t)b->d * (size_t)c->rows, u + b->iu,
                         y + c->row);
        }
    }
}

/* Gaps and rates of all rows, into the data's scratch. */
static int measure_rows(const mbsr_model *m, mbsr_data *d, double **g, double **rate)
{
    *g = d->closure_x + 2 * (size_t)m->most.columns + 2 * (size_t)m->rows;
    *rate = *g + m->rows;
    const int status = mbsri_closure_jacobians(m, d);
    return status ? status : mbsri_closure_errors(m, d, *rate, *g);
}

int mbsri_closure_sum(const mbsr_model *m, mbsr_data *d, bool energy, double *sum)
{
    double *g, *rate;
    const int status = measure_rows(m, d, &g, &rate);
    if (status) return status;
    for (const mbsri_closure *c = mbsri_all_closures(m), *end = c + m->closures.count; c < end;
         ++c) {
        for (int k = 0; k < c->position_rows; ++k) {
            const double gap = g[c->position_row + k], speed = rate[c->row + k];
            *sum +=
                energy ? 0.5 * c->def.stiffness[k] * gap * gap : c->def.damping[k] * speed * speed;
        }
    }
    return MBSR_OK;
}

static bool any_springs(const mbsr_model *m)
{
    for (const mbsri_closure *c = mbsri_all_closures(m), *end = c + m->closures.count; c < end;
         ++c) {
        for (int k = 0; k < c->position_rows; ++k) {
            if (c->def.stiffness[k] > 0.0 || c->def.damping[k] > 0.0) return true;
        }
    }
    return false;
}

int mbsri_closure_springs(const mbsr_model *m, mbsr_data *d)
{
    double *g, *rate;
    mbsri_zero((size_t)m->rows, d->loop_lambda);
    if (!any_springs(m)) return mbsri_closure_jacobians(m, d);
    const int status = measure_rows(m, d, &g, &rate);
    if (status) return status;
    for (const mbsri_closure *c = mbsri_all_closures(m), *end = c + m->closures.count; c < end;
         ++c) {
        for (int k = 0; k < c->position_rows; ++k) {
            d->loop_lambda[c->row + k] = -c->def.stiffness[k] * g[c->position_row + k] -
                                         c->def.damping[k] * rate[c->row + k];
        }
    }
    return MBSR_OK;
}
