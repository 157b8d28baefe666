/* Products with the transposed Newton matrix: see product_transposed.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Step by step that of product.c, the last first: each vector holds what r says of it, and b += A a
 * becomes a += A^T b. */
#include "newton/linear/product_transposed.h"

#include "newton/linear/product_sources.h"

#include "algebra/dense.h"
#include "newton/linear/groups.h"
#include "recursion/closures.h"

/* ---- L^-1 ---- */

/* r_u of a joint or group: into its parts of the momenta and of the balances. */
static void balance_of(const mbsri_linear *w, int i, const double *r, mbsri_vectors *v)
{
    const mbsr_model *m = w->model;
    const mbsri_terms k = mbsri_linear_terms(w, i);
    const mbsri_group g = mbsri_linear_group(w, i);
    const double s = mbsri_linear_rate(w, i);
    double *x = v->momentum + g.ig, *gamma = v->balance + g.ig;
    mbsri_group_gather(m, &g, r + m->nq + m->nu, x);
    mbsri_linear_split_transposed(&k, g.n, w->rank[i], x, gamma);
    for (int l = 0; l < g.n; ++l) x[l] *= s;
}

/* Root to leaves: x <- x - J^T xbar, and what the head passes on, xbar + G x. */
static void condense(const mbsri_linear *w, int i, double *x, double *xbar)
{
    const mbsri_body *b = w->model->body + i;
    const mbsri_terms k = mbsri_linear_terms(w, i);
    mbsri_ax(b->d, b->pred.d, -1.0, k.H, xbar + b->pred.v, xbar + b->v);
    if (mbsri_linear_leads(w, i))
        mbsri_atx(b->d, mbsri_linear_group(w, i).n, 1.0, k.G, xbar + b->v, x + b->group.iu);
    mbsri_ax(b->d, b->n, -1.0, k.J, x + b->group.iu, xbar + b->v);
}

/* ---- the sweeps ---- */

/* Root to leaves, joint i: what r says of y, of x, and of the joint's own terms. */
static void act(const mbsri_linear *w, int i, const double *r, mbsri_vectors *v, double *delta)
{
    const mbsr_model *m = w->model;
    const mbsri_body *b = m->body + i;
    const mbsri_terms k = mbsri_linear_terms(w, i);
    const int d = b->d, n = b->n;
    const bool reacts = w->below_massless[i];
    const double *momentum = v->momentum + b->group.iu, *balance = v->balance + b->group.iu,
                 *rp = r + m->nq + b->u;
    double *y = v->action + 3 * b->v, *own = v->own + 3 * b->iu, *tau = v->torque + b->iu;
    mbsri_linear_pass_transposed(b, &k, w->below_massless[b->parent], v->action + 3 * b->pred.v, y);
    for (int l = 0; l < n; ++l) {
        own[l] = momentum[l];
        own[n + l] = -rp[l];
        if (reacts) own[2 * n + l] = balance[l];
        tau[l] = -rp[l] - (reacts ? balance[l] : 0.0);
        delta[m->nq + b->u + l] = w->c * rp[l] - momentum[l];
    }
    mbsri_ax(d, n, 1.0, k.J, momentum, y);
    mbsri_ax(d, n, -1.0, k.Jdot, rp, y);
    mbsri_ax(d, n, -1.0, k.J, rp, y + d);
    if (reacts) mbsri_ax(d, n, 1.0, k.J, balance, y + 2 * d);
    mbsri_atx(mbsri_linear_actions(w, i), mbsri_linear_motions(w, i), 1.0, k.P, y,
              v->motion + w->motion[i]);
}

/* Leaves to root, joint i: what is said of its motion goes to that of the predecessor and to delta.
 */
static void move_joint(const mbsri_linear *w, int i, const double *r, mbsri_vectors *v,
                       double *delta)
{
    const mbsr_model *m = w->model;
    const mbsri_body *b = m->body + i;
    const mbsri_terms k = mbsri_linear_terms(w, i);
    const int x = mbsri_linear_motions(w, i), x_pred = mbsri_linear_motions(w, b->parent), n = b->n,
              nq = b->nq, columns = x_pred + nq + n, rows = (w->below_massless[i] ? 3 : 2) * n;
    const double *rq = r + b->q;
    double *z = v->in, *push = v->push + b->iu, *motion = v->motion + w->motion[b->parent];
    mbsri_zero((size_t)columns, z);
    mbsri_atx(nq, columns, -1.0, k.qdot, rq, z);
    for (int l = 0; l < n && m->rows > 0; ++l) push[l] = z[x_pred + nq + l];
    mbsri_atx(x, columns, 1.0, k.x, v->motion + w->motion[i], z);
    mbsri_atx(rows, columns, 1.0, k.own, v->own + 3 * b->iu, z);
    mbsri_atx(mbsri_linear_actions(w, b->parent), columns, 1.0, k.below, v->action + 3 * b->pred.v,
              z);
    for (int l = 0; l < x_pred; ++l) motion[l] += z[l];
    for (int l = 0; l < nq; ++l) delta[b->q + l] += z[x_pred + l] + w->c * rq[l];
    for (int l = 0; l < n; ++l) delta[m->nq + m->nu + b->u + l] += z[x_pred + nq + l];
}

/* ---- elements and closures ---- */

/* What is said of f on a body, which enters sigma with -1 and mu with 1, and of tau on its joint.
 */
static void read_force(const mbsri_linear *w, int i, const mbsri_vectors *v, double *f, double *tau)
{
    const mbsri_body *b = w->model->body + i;
    const double *action = v->action + 3 * b->v;
    for (int l = 0; l < b->d; ++l)
        f[l] = (w->below_massless[i] ? action[2 * b->d + l] : 0.0) - action[b->d + l];
    for (int l = 0; l < b->n && tau; ++l) tau[l] = v->torque[b->iu + l];
}

static void add_elements(const mbsri_linear *w, mbsri_vectors *v, double *delta)
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
                read_force(w, list[l], v, f, f + b->d);
                f += b->d + b->n;
            }
            mbsri_zero((size_t)columns, z);
            mbsri_atx(rows, columns, 1.0, matrix, v->out, z);
            for (int l = 0; l < bodies; ++l) {
                const mbsri_body *b = m->body + list[l];
                const int x = w->e[list[l]] + b->d;
                if (list[l] == 0) continue;
                double *motion = v->motion + w->motion[list[l]];
                for (int j = 0; j < x; ++j) motion[j] += *z++;
                for (int j = 0; j < b->nq; ++j) delta[b->q + j] += *z++;
                for (int j = 0; j < b->n; ++j) delta[m->nq + m->nu + b->u + j] += *z++;
            }
        }
    }
}

/* What the rows of a closure, and its multipliers, say of their rates and places. */
static void open_rows(const mbsri_linear *w, const mbsri_closure *c, const double *r,
                      const double *lambda, double *rate, double *place, double *delta)
{
    const mbsr_model *m = w->model;
    const int first = m->nq + 2 * m->nu;
    for (int k = 0; k < c->rows; ++k) {
        const int row = first + c->row + k, position = first + m->rows + c->position_row + k;
        const double stiffness = c->def.stiffness[k], f = w->c;
        const bool dropped = w->dropped[c->row + k], holds = k < c->position_rows;
        if (holds && dropped) delta[position] += r[position];
        place[k] = holds && !dropped ? r[position] : 0.0;
        if (stiffness > 0.0) {
            delta[row] = (f * r[row] - place[k]) / stiffness -
                         (1.0 + c->def.damping[k] / stiffness * f) * lambda[k];
            rate[k] = -r[row];
        } else {
            delta[row] = dropped ? r[row] : f * lambda[k];
            rate[k] = dropped ? 0.0 : r[row];
        }
    }
}

static void add_closures(const mbsri_linear *w, const double *r, mbsri_vectors *v, double *delta,
                         mbsri_sources *by)
{
    const mbsr_model *m = w->model;
    for (size_t l = 0; l < m->closures.count; ++l) {
        const mbsri_closure *c = mbsri_closure_at(w->model, l);
        const int columns = c->columns, rows = c->rows;
        const bool joints = (c->def.table->flags & MBSR_CLOSURE_JOINTS) != 0;
        const mbsri_closure_part of = mbsri_linear_closure(w, l);
        double *force = v->out, *place = v->in, *rate = place + columns,
               velocity[MBSR_CLOSURE_ROWS] = {0.0}, gap[MBSR_CLOSURE_ROWS] = {0.0},
               lambda[MBSR_CLOSURE_ROWS] = {0.0};
        mbsri_zero((size_t)columns, force);
        mbsri_zero(2 * (size_t)columns, place);
        for (int k = 0; k < c->bodies; ++k) {
            double *f = force + c->column[k];
            if (c->column[k] < 0 || c->body[k] == 0) continue;
            read_force(w, c->body[k], v, f, joints ? f + m->body[c->body[k]].d : NULL);
        }
        mbsri_ax(rows, columns, 1.0, of.C, force, lambda);
        if (by) mbsri_copy((size_t)rows, lambda, by->lambda + c->row);
        open_rows(w, c, r, lambda, velocity, gap, delta);
        mbsri_atx(columns, columns, 1.0, of.S, force, place);
        mbsri_atx(rows, columns, 1.0, of.slope, velocity, place);
        mbsri_atx(rows, columns, 1.0, of.C, gap, place);
        mbsri_atx(rows, columns, 1.0, of.C, velocity, rate);
        for (int k = 0; k < c->bodies; ++k) {
            const int i = c->body[k], at = c->column[k];
            const mbsri_body *b = m->body + i;
            if (at < 0 || i == 0) continue;
            double *x = v->motion + w->motion[i];
            for (int j = 0; j < b->d; ++j) x[j] += place[at + j];
            for (int j = 0; j < b->d; ++j) x[w->e[i] + j] += rate[at + j];
            for (int j = 0; j < b->n && joints; ++j) {
                delta[b->q + j] += place[at + b->d + j];
                delta[m->nq + m->nu + b->u + j] += rate[at + b->d + j];
            }
        }
    }
}

/* What is said of the pushes of eta. */
static void find_push(const mbsri_linear *w, mbsri_vectors *v, double *delta)
{
    const mbsr_model *m = w->model;
    double *eta = delta + m->nq + 2 * m->nu + m->rows;
    mbsri_zero(m->size.v, v->kappa);
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        const mbsri_terms k = mbsri_linear_terms(w, i);
        for (int l = 0; l < b->n; ++l) v->push[b->iu + l] *= m->typical.weight[b->iu + l];
        mbsri_ax(b->d, b->n, -1.0, k.J, v->push + b->iu, v->kappa + b->v);
        mbsri_ax(b->d, b->pred.d, -1.0, k.H, v->kappa + b->pred.v, v->kappa + b->v);
    }
    for (size_t l = 0; l < m->closures.count; ++l) {
        const mbsri_closure *c = mbsri_closure_at(w->model, l);
        const double *C = mbsri_linear_closure(w, l).C;
        mbsri_zero((size_t)c->rows, v->in);
        for (int k = 0; k < c->bodies; ++k) {
            const mbsri_body *b = m->body + c->body[k];
            if (c->column[k] < 0 || c->body[k] == 0) continue;
            const double *block = C + (size_t)c->column[k] * (size_t)c->rows;
            mbsri_ax(c->rows, b->d, 1.0, block, v->kappa + b->v, v->in);
            if (c->def.table->flags & MBSR_CLOSURE_JOINTS)
                mbsri_ax(c->rows, b->n, 1.0, block + (size_t)(b->d * c->rows), v->push + b->iu,
                         v->in);
        }
        for (int r = 0; r < c->position_rows; ++r) {
            if (!w->dropped[c->row + r]) eta[c->position_row + r] += w->c * v->in[r];
        }
    }
}

/* r_u, and L^-1 of its parts. */
static void pass_to_leaves(const mbsri_linear *w, const double *r, mbsri_vectors *v)
{
    const mbsr_model *m = w->model;
    mbsri_zero(m->size.v, v->mbar);
    mbsri_zero(m->size.v, v->fbar);
    for (int i = 1; i <= m->bodies; ++i) {
        if (mbsri_linear_leads(w, i)) balance_of(w, i, r, v);
    }
    for (int i = 1; i <= m->bodies; ++i) {
        condense(w, i, v->momentum, v->mbar);
        condense(w, i, v->balance, v->fbar);
    }
}

/* What it says of sources at joints and in rows. */
static void read_sources(const mbsri_linear *w, const double *r, const mbsri_vectors *v,
                         mbsri_sources *by)
{
    const mbsr_model *m = w->model;
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        for (int l = 0; l < b->n; ++l) {
            by->pulse[b->u + l] = v->momentum[b->group.iu + l];
            by->load[b->u + l] = w->below_massless[i] ? v->balance[b->group.iu + l] : 0.0;
            by->drift[b->u + l] = -r[m->nq + b->u + l];
        }
    }
    mbsri_copy((size_t)(m->rows + m->position_rows), r + m->nq + 2 * m->nu, by->rows);
}

void mbsri_product_transposed_with(const mbsri_linear *w, const double *r, mbsri_vectors *v,
                                   double *delta, mbsri_sources *by)
{
    const mbsr_model *m = w->model;
    mbsri_zero((size_t)(m->nq + 2 * m->nu + m->rows + m->position_rows), delta);
    mbsri_zero(w->motions, v->motion);
    mbsri_zero(3 * m->size.v, v->action);
    pass_to_leaves(w, r, v);
    for (int i = 1; i <= m->bodies; ++i) act(w, i, r, v, delta);
    add_closures(w, r, v, delta, by);
    add_elements(w, v, delta);
    for (int i = m->bodies; i >= 1; --i) move_joint(w, i, r, v, delta);
    if (m->rows > 0) find_push(w, v, delta);
    if (by) read_sources(w, r, v, by);
}

void mbsri_product_transposed(const mbsri_linear *w, const double *r, mbsri_vectors *v,
                              double *delta)
{
    mbsri_product_transposed_with(w, r, v, delta, NULL);
}

void mbsri_product_of_torque_transposed(const mbsri_linear *w, const double *r, mbsri_vectors *v,
                                        double *tau)
{
    const mbsr_model *m = w->model;
    pass_to_leaves(w, r, v);
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        for (int l = 0; l < b->n; ++l)
            tau[b->u + l] =
                -r[m->nq + b->u + l] - (w->below_massless[i] ? v->balance[b->group.iu + l] : 0.0);
    }
}
