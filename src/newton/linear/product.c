/* Products with the Newton matrix: see product.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Of a given delta, root to leaves the perturbations x of the bodies; then forces by them, of
 * elements and closures; leaves to root y, what it makes of the momenta, their rates and the
 * missing joint forces, and L^-1 of these:
 *
 *   r_q = c dq - d(G u) - G w C_h^T c deta
 *   r_p = c dp - dP
 *   r_u = (1 - P) L^-1 (d(M u) - dp) + P L^-1 d(J^T mu - tau)
 *
 * and the rows of closures as in src/forms/loops.c. */
#include "newton/linear/product.h"

#include "algebra/dense.h"
#include "base/memory.h"
#include "newton/linear/groups.h"
#include "newton/linear/product_sources.h"
#include "newton/slopes/relation.h"
#include "recursion/closures.h"

#include <mbsrank/dae.h>

/* The longest that a joint, element or closure reads or gives. */
static size_t widest(const mbsri_linear *w)
{
    const mbsr_model *m = w->model;
    size_t most = 2 * (size_t)(m->most.columns > m->rows ? m->most.columns : m->rows);
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        const size_t count = (size_t)(w->e[b->parent] + 2 * b->pred.d + b->nq + b->n + b->group.n +
                                      b->group.nq + w->e[i] + 2 * b->d);
        if (count > most) most = count;
    }
    for (size_t k = 0; k < m->forces.count; ++k) {
        int rows, columns;
        mbsri_slopes_shape(m, mbsri_force_at(w->model, k), &rows, &columns);
        if ((size_t)(rows + columns) > most) most = (size_t)(rows + columns);
    }
    return most;
}

size_t mbsri_vectors_place(const mbsri_linear *w, double *memory, mbsri_vectors *v)
{
    const mbsr_model *m = w->model;
    const size_t nu = (size_t)m->nu, most = widest(w);
    size_t used = 0;
    v->motion = mbsri_take(&memory, &used, w->motions);
    v->action = mbsri_take(&memory, &used, 3 * m->size.v);
    double **const of_rates[] = {&v->torque, &v->push, &v->momentum, &v->balance};
    for (int l = 0; l < 4; ++l) *of_rates[l] = mbsri_take(&memory, &used, nu);
    v->own = mbsri_take(&memory, &used, 3 * nu);
    double **const of_bodies[] = {&v->mbar, &v->fbar, &v->kappa};
    for (int l = 0; l < 3; ++l) *of_bodies[l] = mbsri_take(&memory, &used, m->size.v);
    v->in = mbsri_take(&memory, &used, most);
    v->out = mbsri_take(&memory, &used, most);
    return used;
}

/* ---- multiplying ---- */

/* c deta of the position rows that count -> w C_h^T, in the order of the sweeps, and forces on
 * bodies on the way; only with closures. */
static void find_push(const mbsri_linear *w, const double *delta, mbsri_vectors *v)
{
    const mbsr_model *m = w->model;
    const double *eta = delta + m->nq + 2 * m->nu + m->rows;
    mbsri_zero((size_t)m->nu, v->push);
    mbsri_zero(m->size.v, v->kappa);
    for (size_t l = 0; l < m->closures.count; ++l) {
        const mbsri_closure *c = mbsri_closure_at(w->model, l);
        const double *C = mbsri_linear_closure(w, l).C;
        for (int r = 0; r < c->rows; ++r) {
            const bool counts = r < c->position_rows && !w->dropped[c->row + r];
            v->in[r] = counts ? w->c * eta[c->position_row + r] : 0.0;
        }
        for (int k = 0; k < c->bodies; ++k) {
            const mbsri_body *b = m->body + c->body[k];
            if (c->column[k] < 0 || c->body[k] == 0) continue;
            const double *block = C + (size_t)c->column[k] * (size_t)c->rows;
            mbsri_atx(c->rows, b->d, 1.0, block, v->in, v->kappa + b->v);
            if (c->def.table->flags & MBSR_CLOSURE_JOINTS)
                mbsri_atx(c->rows, b->n, 1.0, block + (size_t)(b->d * c->rows), v->in,
                          v->push + b->iu);
        }
    }
    for (int i = m->bodies; i >= 1; --i) {
        const mbsri_body *b = m->body + i;
        const mbsri_terms k = mbsri_linear_terms(w, i);
        mbsri_atx(b->d, b->n, -1.0, k.J, v->kappa + b->v, v->push + b->iu);
        mbsri_atx(b->d, b->pred.d, -1.0, k.H, v->kappa + b->v, v->kappa + b->pred.v);
        for (int l = 0; l < b->n; ++l) v->push[b->iu + l] *= m->typical.weight[b->iu + l];
    }
}

static void add_to(int n, const double *x, double *y)
{
    for (int k = 0; k < n; ++k) y[k] += x[k];
}

/* Root to leaves, joint i: x, r_q, what of the joint's equations depends on its variables alone. */
static void move_joint(const mbsri_linear *w, int i, const double *delta, const mbsri_sources *more,
                       mbsri_vectors *v, double *r)
{
    const mbsr_model *m = w->model;
    const mbsri_body *b = m->body + i;
    const mbsri_terms k = mbsri_linear_terms(w, i);
    const int x = mbsri_linear_motions(w, i), x_pred = mbsri_linear_motions(w, b->parent), n = b->n,
              nq = b->nq, columns = x_pred + nq + n, rows = (w->below_massless[i] ? 3 : 2) * n;
    double *z = v->in, *u = z + x_pred + nq, *rq = r + b->q, *action = v->action + 3 * b->pred.v;
    mbsri_copy((size_t)x_pred, v->motion + w->motion[b->parent], z);
    mbsri_copy((size_t)nq, delta + b->q, z + x_pred);
    mbsri_copy((size_t)n, delta + m->nq + m->nu + b->u, u);
    mbsri_zero((size_t)x, v->motion + w->motion[i]);
    mbsri_ax(x, columns, 1.0, k.x, z, v->motion + w->motion[i]);
    if (more) add_to(x, more->motion + w->motion[i], v->motion + w->motion[i]);
    mbsri_zero((size_t)rows, v->own + 3 * b->iu);
    mbsri_ax(rows, columns, 1.0, k.own, z, v->own + 3 * b->iu);
    mbsri_ax(mbsri_linear_actions(w, b->parent), columns, 1.0, k.below, z, action);
    for (int l = 0; l < n && m->rows > 0; ++l) u[l] += v->push[b->iu + l];
    for (int l = 0; l < nq; ++l) rq[l] = w->c * delta[b->q + l];
    mbsri_ax(nq, columns, -1.0, k.qdot, z, rq);
}

/* f enters sigma with -1 and mu with 1. */
static void add_force(const mbsri_body *b, const double *f, const double *tau, mbsri_vectors *v)
{
    double *action = v->action + 3 * b->v;
    for (int l = 0; l < b->d; ++l) {
        action[b->d + l] -= f[l];
        action[2 * b->d + l] += f[l];
    }
    for (int l = 0; l < b->n && tau; ++l) v->torque[b->iu + l] += tau[l];
}

static void add_elements(const mbsri_linear *w, const double *delta, mbsri_vectors *v)
{
    const mbsr_model *m = w->model;
    for (size_t k = 0; k < m->forces.count; ++k) {
        const mbsri_force *force = mbsri_force_at(w->model, k);
        int first, last;
        mbsri_linear_calls(w, k, &first, &last);
        for (int i = first; i <= last; ++i) {
            const int *list;
            const int bodies = mbsri_linear_bodies(w, force, i, &list);
            int rows, columns;
            double *z = v->in, *f = v->out;
            const double *matrix = mbsri_linear_element(w, k, i, &rows, &columns);
            for (int l = 0; l < bodies; ++l) {
                const mbsri_body *b = m->body + list[l];
                if (list[l] == 0) continue;
                const size_t x = (size_t)(w->e[list[l]] + b->d);
                mbsri_copy(x, v->motion + w->motion[list[l]], z);
                mbsri_copy((size_t)b->nq, delta + b->q, z + x);
                mbsri_copy((size_t)b->n, delta + m->nq + m->nu + b->u, z + x + b->nq);
                z += x + (size_t)(b->nq + b->n);
            }
            mbsri_zero((size_t)rows, f);
            mbsri_ax(rows, columns, 1.0, matrix, v->in, f);
            for (int l = 0; l < bodies; ++l) {
                const mbsri_body *b = m->body + list[l];
                if (list[l] == 0) continue;
                add_force(b, f, f + b->d, v);
                f += b->d + b->n;
            }
        }
    }
}

/* Displacements and velocities of a closure's bodies and joints, the columns of C. */
static void read_closure(const mbsri_linear *w, const mbsri_closure *c, const double *delta,
                         const mbsri_vectors *v, double *place, double *rate)
{
    const mbsr_model *m = w->model;
    mbsri_zero((size_t)c->columns, place);
    mbsri_zero((size_t)c->columns, rate);
    for (int k = 0; k < c->bodies; ++k) {
        const int i = c->body[k];
        const mbsri_body *b = m->body + i;
        if (c->column[k] < 0 || i == 0) continue;
        const double *x = v->motion + w->motion[i];
        double *e = place + c->column[k], *e_rate = rate + c->column[k];
        mbsri_copy((size_t)b->d, x, e);
        mbsri_copy((size_t)b->d, x + w->e[i], e_rate);
        if (!(c->def.table->flags & MBSR_CLOSURE_JOINTS)) continue;
        mbsri_copy((size_t)b->n, delta + b->q, e + b->d);
        mbsri_copy((size_t)b->n, delta + m->nq + m->nu + b->u, e_rate + b->d);
    }
}

/* The rows of a closure, where its velocity rows change by `rate` and its position rows by `place`,
 * and dlambda. */
static void close_rows(const mbsri_linear *w, const mbsri_closure *c, const double *delta,
                       const double *rate, const double *place, double *lambda, double *r)
{
    const mbsr_model *m = w->model;
    const int first = m->nq + 2 * m->nu;
    for (int k = 0; k < c->rows; ++k) {
        const int row = first + c->row + k, position = first + m->rows + c->position_row + k;
        const double stiffness = c->def.stiffness[k], s = delta[row], f = w->c;
        if (stiffness > 0.0) {
            lambda[k] = -(s + c->def.damping[k] / stiffness * f * s);
            r[row] = f * s / stiffness - rate[k];
            if (k < c->position_rows)
                r[position] = w->dropped[c->row + k] ? delta[position] : place[k] - s / stiffness;
        } else if (w->dropped[c->row + k]) {
            lambda[k] = 0.0;
            r[row] = s;
            if (k < c->position_rows) r[position] = delta[position];
        } else {
            lambda[k] = f * s;
            r[row] = rate[k];
            if (k < c->position_rows) r[position] = place[k];
        }
    }
}

static void add_closures(const mbsri_linear *w, const double *delta, const mbsri_sources *more,
                         mbsri_vectors *v, double *r)
{
    const mbsr_model *m = w->model;
    for (size_t l = 0; l < m->closures.count; ++l) {
        const mbsri_closure *c = mbsri_closure_at(w->model, l);
        const int columns = c->columns, rows = c->rows;
        const mbsri_closure_part of = mbsri_linear_closure(w, l);
        double *place = v->in, *rate = place + columns, *force = v->out,
               velocity[MBSR_CLOSURE_ROWS] = {0.0}, gap[MBSR_CLOSURE_ROWS] = {0.0},
               lambda[MBSR_CLOSURE_ROWS];
        read_closure(w, c, delta, v, place, rate);
        mbsri_ax(rows, columns, 1.0, of.slope, place, velocity);
        mbsri_ax(rows, columns, 1.0, of.C, rate, velocity);
        mbsri_ax(rows, columns, 1.0, of.C, place, gap);
        close_rows(w, c, delta, velocity, gap, lambda, r);
        if (more) add_to(rows, more->lambda + c->row, lambda);
        mbsri_zero((size_t)columns, force);
        mbsri_ax(columns, columns, 1.0, of.S, place, force);
        mbsri_atx(rows, columns, 1.0, of.C, lambda, force);
        for (int k = 0; k < c->bodies; ++k) {
            const mbsri_body *b = m->body + c->body[k];
            if (c->column[k] < 0 || c->body[k] == 0) continue;
            const double *f = force + c->column[k];
            const bool joints = (c->def.table->flags & MBSR_CLOSURE_JOINTS);
            add_force(b, f, joints ? f + b->d : NULL, v);
        }
    }
}

/* Leaves to root, joint i: y, r_p, and d(M u) - dp and d(J^T mu - tau) before L^-1. */
static void act(const mbsri_linear *w, int i, const double *delta, const mbsri_sources *more,
                mbsri_vectors *v, double *r)
{
    const mbsr_model *m = w->model;
    const mbsri_body *b = m->body + i;
    const mbsri_terms k = mbsri_linear_terms(w, i);
    const int d = b->d, n = b->n;
    const bool reacts = w->below_massless[i];
    const double *own = v->own + 3 * b->iu, *tau = v->torque + b->iu, *dp = delta + m->nq + b->u;
    double *y = v->action + 3 * b->v, *momentum = v->momentum + b->group.iu,
           *balance = v->balance + b->group.iu, *rp = r + m->nq + b->u;
    mbsri_ax(mbsri_linear_actions(w, i), mbsri_linear_motions(w, i), 1.0, k.P,
             v->motion + w->motion[i], y);
    for (int l = 0; l < n; ++l) {
        momentum[l] = own[l] - dp[l];
        balance[l] = reacts ? own[2 * n + l] - tau[l] : 0.0;
        rp[l] = w->c * dp[l] - own[n + l] - tau[l];
    }
    mbsri_atx(d, n, 1.0, k.J, y, momentum);
    if (reacts) mbsri_atx(d, n, 1.0, k.J, y + 2 * d, balance);
    mbsri_atx(d, n, -1.0, k.J, y + d, rp);
    mbsri_atx(d, n, -1.0, k.Jdot, y, rp);
    for (int l = 0; l < n && more; ++l) {
        momentum[l] += more->pulse[b->u + l];
        if (reacts) balance[l] += more->load[b->u + l];
        rp[l] -= more->drift[b->u + l];
    }
    mbsri_linear_pass(b, &k, w->below_massless[b->parent], y, v->action + 3 * b->pred.v);
}

/* The step of L^-1 for joint i, whose members are done: x <- x - J^T xbar, and what the head passes
 * on, xbar + G x. */
static void condense(const mbsri_linear *w, int i, double *x, double *xbar)
{
    const mbsr_model *m = w->model;
    const mbsri_body *b = m->body + i;
    const mbsri_terms k = mbsri_linear_terms(w, i);
    mbsri_atx(b->d, b->n, -1.0, k.J, xbar + b->v, x + b->group.iu);
    if (mbsri_linear_leads(w, i))
        mbsri_ax(b->d, mbsri_linear_group(w, i).n, 1.0, k.G, x + b->group.iu, xbar + b->v);
    mbsri_atx(b->d, b->pred.d, -1.0, k.H, xbar + b->v, xbar + b->pred.v);
}

/* r_u of a joint, or of the group of that head. */
static void balance_of(const mbsri_linear *w, int i, mbsri_vectors *v, double *r)
{
    const mbsr_model *m = w->model;
    const mbsri_terms k = mbsri_linear_terms(w, i);
    const mbsri_group g = mbsri_linear_group(w, i);
    const double s = mbsri_linear_rate(w, i);
    double *x = v->momentum + g.ig, *gamma = v->balance + g.ig, *range = v->in;
    mbsri_linear_split(&k, g.n, w->rank[i], gamma, range);
    mbsri_linear_split(&k, g.n, w->rank[i], x, range);
    for (int l = 0; l < g.n; ++l) x[l] = s * range[l] + gamma[l];
    mbsri_group_scatter(m, &g, x, r + m->nq + m->nu);
}

/* Of r = (dF/dy + c dF/dy') delta, not the same, what does not need L^-1: r_q, r_p and the rows of
 * closures, with d(M u) - dp and d(J^T mu - tau) in v. */
static void apply_linear(const mbsri_linear *w, const double *delta, const mbsri_sources *more,
                         mbsri_vectors *v, double *r)
{
    const mbsr_model *m = w->model;
    mbsri_zero(w->motions, v->motion);
    mbsri_zero(3 * m->size.v, v->action);
    mbsri_zero((size_t)m->nu, v->torque);
    if (more) {
        mbsri_copy(3 * m->size.v, more->action, v->action);
        mbsri_copy((size_t)m->nu, more->torque, v->torque);
    }
    if (m->rows > 0) find_push(w, delta, v);
    for (int i = 1; i <= m->bodies; ++i) move_joint(w, i, delta, more, v, r);
    add_elements(w, delta, v);
    add_closures(w, delta, more, v, r);
    for (int i = m->bodies; i >= 1; --i) act(w, i, delta, more, v, r);
    if (more) add_to(m->rows + m->position_rows, more->rows, r + m->nq + 2 * m->nu);
}

/* L^-1 of both, and r_u. */
static void pass_to_root(const mbsri_linear *w, mbsri_vectors *v, double *r)
{
    const mbsr_model *m = w->model;
    mbsri_zero(m->size.v, v->mbar);
    mbsri_zero(m->size.v, v->fbar);
    for (int i = m->bodies; i >= 1; --i) {
        condense(w, i, v->momentum, v->mbar);
        condense(w, i, v->balance, v->fbar);
    }
    for (int i = 1; i <= m->bodies; ++i) {
        if (mbsri_linear_leads(w, i)) balance_of(w, i, v, r);
    }
}

void mbsri_product_with(const mbsri_linear *w, const double *delta, const mbsri_sources *sources,
                        mbsri_vectors *v, double *r)
{
    apply_linear(w, delta, sources, v, r);
    pass_to_root(w, v, r);
}

void mbsri_product(const mbsri_linear *w, const double *delta, mbsri_vectors *v, double *r)
{
    mbsri_product_with(w, delta, NULL, v, r);
}

void mbsri_product_of_torque(const mbsri_linear *w, const double *tau, mbsri_vectors *v, double *r)
{
    const mbsr_model *m = w->model;
    mbsri_zero((size_t)mbsr_dae_size(m, MBSR_DAE_MOMENTUM), r);
    mbsri_zero((size_t)m->nu, v->momentum);
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        for (int l = 0; l < b->n; ++l) {
            v->balance[b->group.iu + l] = w->below_massless[i] ? -tau[b->u + l] : 0.0;
            r[m->nq + b->u + l] = -tau[b->u + l];
        }
    }
    pass_to_root(w, v, r);
}
