/* Products with the Newton matrix: see product.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The linearised equations of src/newton/blocks/factor.c, joint by joint and body by body, before anything is
 * eliminated from them. Of a given delta, root to leaves the perturbations x of the bodies; then
 * forces by them, of elements and closures; leaves to root y, what it makes of the momenta, their
 * rates and the missing joint forces, and L^-1 of these:
 *
 *   r_q = c dq - d(G u) - G w C_h^T c deta
 *   r_p = c dp - dP
 *   r_u = (1 - P) L^-1 (d(M u) - dp) + P L^-1 d(J^T mu - tau)
 *
 * and the rows of closures as in src/forms/loops.c. */
#include "newton/product.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "newton/blocks/factor.h"
#include "newton/blocks/kept.h"
#include "newton/slopes/body_slopes.h"
#include "newton/slopes/closure_slopes.h"
#include "newton/slopes/joint_slopes.h"
#include "newton/slopes/relation.h"
#include "recursion/backward.h"
#include "recursion/closures.h"
#include "recursion/group.h"

/* ---- what is kept ---- */

/* Of a body and its joint: the derivatives of mbsri_joint_slopes but for the columns of u', the body's
 * own P, and what of the data is needed. G, s and X are those of a group, at its head. What concerns A
 * and mu stands there where the body, or for columns and `below` its predecessor, is deep (mbsri_node). */
typedef struct terms {
    double *x, *below, *own, *qdot;
    double *P;
    double *H, *Hdot, *J, *Jdot, *G, *s, *X;
} terms;

/* Vectors of one product, body by body, in the order of the sweeps or of groups. */
typedef struct vectors {
    double *motion;             /* size_x: x */
    double *action;             /* 3 size_v: y */
    double *torque, *push;      /* nu: dtau; w C_h^T c deta */
    double *own;                /* 3 nu, joint by joint */
    double *momentum, *balance; /* nu: d(M u) - dp and d(J^T mu - tau); then L^-1 of them */
    double *mbar, *fbar;        /* size_v: what L^-1 passes on of both */
    double *kappa;              /* size_v: C_h^T c deta */
    double *in, *out;           /* of one joint, element or closure: what it reads, what it gives */
} vectors;

static double *take(double **memory, size_t *used, size_t count)
{
    double *here = *memory;
    if (here) *memory += count;
    *used += count;
    return here;
}

/* Numbers of pose, V and perhaps A of a body, and of its actions. */
static int motions(const mbsr_newton *w, int i, bool accelerated)
{
    return w->node[i].e + (accelerated ? 2 : 1) * w->model->body[i].d;
}

static int actions(int d, bool accelerated)
{
    return (accelerated ? 3 : 2) * d;
}

/* Numbers of a joint's variables, but for u'. */
static int variables(const mbsr_newton *w, int i, bool accelerated)
{
    const mbsri_body *b = w->model->body + i;
    return motions(w, b->parent, accelerated) + b->nq + b->n;
}

/* own, above: whether the body and its predecessor are deep. */
static size_t place_terms(const mbsr_newton *w, int i, bool own, bool above, double *memory,
                          terms *k)
{
    const mbsri_body *b = w->model->body + i;
    const size_t d = (size_t)b->d, dp = (size_t)b->d_pred, n = (size_t)b->n, nq = (size_t)b->nq,
                 x = (size_t)motions(w, i, own), columns = (size_t)variables(w, i, above),
                 y = (size_t)actions(b->d, own), y_pred = (size_t)actions(b->d_pred, above),
                 rows = (size_t)actions(b->n, own), all = (size_t)b->group_n;
    double **const array[] = {&k->x,    &k->below, &k->own,  &k->qdot, &k->P, &k->H,
                              &k->Hdot, &k->J,     &k->Jdot, &k->G,    &k->s, &k->X};
    const size_t length[] = {x * columns, y_pred * columns, rows * columns, nq * columns, y * x,
                             d * dp,      d * dp,           d * n,          d * n,        d * all,
                             all,         all * all};
    size_t used = 0;
    for (size_t l = 0; l < sizeof length / sizeof length[0]; ++l)
        *array[l] = take(&memory, &used, length[l]);
    return used;
}

static int *ranks(const mbsr_newton *w)
{
    return w->product.flags;
}

static int *deep(const mbsr_newton *w)
{
    return ranks(w) + w->model->bodies + 1;
}

static int *coupled(const mbsr_newton *w)
{
    return deep(w) + w->model->bodies + 1;
}

static int *dropped(const mbsr_newton *w)
{
    return coupled(w) + w->model->bodies + 1;
}

static terms terms_of(const mbsr_newton *w, int i)
{
    const int parent = w->model->body[i].parent;
    terms k;
    place_terms(w, i, deep(w)[i] != 0, deep(w)[parent] != 0, w->product.store + w->node[i].product,
                &k);
    return k;
}

static const mbsri_force *force_of(const mbsr_newton *w, size_t k)
{
    return (const mbsri_force *)w->model->forces.data + k;
}

static const mbsri_closure *closure_of(const mbsr_newton *w, size_t k)
{
    return (const mbsri_closure *)w->model->closures.data + k;
}

static bool on_every_body(const mbsri_force *force)
{
    return (force->def.table->flags & MBSR_FORCE_EVERY_BODY) != 0;
}

/* Bodies that an element sees in a call; of one on every body that is body i. */
static int bodies_of(const mbsr_newton *w, const mbsri_force *force, int i, const int **list)
{
    *list = on_every_body(force) ? w->model->member + w->model->body[i].at
                                 : w->model->list_index + force->list;
    return on_every_body(force) ? 1 : force->def.bodies;
}

/* Rows and columns of its derivatives. */
static void shape(const mbsr_newton *w, const mbsri_force *force, int i, int *rows, int *columns)
{
    const mbsri_body *b = w->model->body + i;
    mbsri_slopes_shape(w->model, force, rows, columns);
    if (!on_every_body(force)) return;
    *rows = b->d + b->n;
    *columns = w->node[i].e + b->d + b->nq + b->n;
}

/* How often an element is called: for body `first` .. `last`. */
static void calls(const mbsr_newton *w, const mbsri_force *force, int *first, int *last)
{
    *first = on_every_body(force) ? 1 : 0;
    *last = on_every_body(force) ? w->model->bodies : 0;
}

static size_t place_vectors(const mbsr_newton *w, double *memory, vectors *v)
{
    const mbsr_model *m = w->model;
    const size_t nu = (size_t)m->nu;
    size_t used = 0, most = 2 * (size_t)(m->max_columns > m->rows ? m->max_columns : m->rows);
    for (int i = 1; i <= m->bodies; ++i) {
        const size_t count =
            (size_t)(variables(w, i, true) + m->body[i].group_n + m->body[i].group_nq);
        if (count > most) most = count;
    }
    for (size_t k = 0; k < m->forces.count; ++k) {
        int first, last;
        calls(w, force_of(w, k), &first, &last);
        for (int i = first; i <= last; ++i) {
            int rows, columns;
            shape(w, force_of(w, k), i, &rows, &columns);
            if ((size_t)(rows + columns) > most) most = (size_t)(rows + columns);
        }
    }
    v->motion = take(&memory, &used, w->size_x);
    v->action = take(&memory, &used, 3 * m->size_v);
    double **const of_rates[] = {&v->torque, &v->push, &v->momentum, &v->balance};
    for (int l = 0; l < 4; ++l) *of_rates[l] = take(&memory, &used, nu);
    v->own = take(&memory, &used, 3 * nu);
    double **const of_bodies[] = {&v->mbar, &v->fbar, &v->kappa};
    for (int l = 0; l < 3; ++l) *of_bodies[l] = take(&memory, &used, m->size_v);
    v->in = take(&memory, &used, most);
    v->out = take(&memory, &used, most);
    return used;
}

/* Of closures: S, slope and C of each, one after the other. */
static size_t closure_size(const mbsri_closure *c)
{
    return (size_t)c->columns * (size_t)(c->columns + 2 * c->rows);
}

size_t mbsri_product_size(mbsr_newton *w)
{
    const mbsr_model *m = w->model;
    size_t used = 0, work = 0;
    vectors v;
    for (int i = 1; i <= m->bodies; ++i) {
        terms k;
        w->node[i].product = used;
        used += place_terms(w, i, true, true, NULL, &k);
    }
    w->product.elements = used;
    for (size_t k = 0; k < m->forces.count; ++k) {
        int first, last;
        calls(w, force_of(w, k), &first, &last);
        for (int i = first; i <= last; ++i) {
            int rows, columns;
            shape(w, force_of(w, k), i, &rows, &columns);
            used += (size_t)rows * (size_t)columns;
        }
    }
    w->product.closures = used;
    for (size_t k = 0; k < m->closures.count; ++k) {
        const size_t size = mbsri_closure_tangents_work(closure_of(w, k));
        used += closure_size(closure_of(w, k));
        if (size > work) work = size;
    }
    w->product.work = used;
    used += work;
    w->product.vectors = used;
    return used + place_vectors(w, NULL, &v);
}

/* rank, deep and coupled of bodies; dropped of rows. */
size_t mbsri_product_flags(const mbsr_newton *w)
{
    return 3 * ((size_t)w->model->bodies + 1) + (size_t)w->model->rows;
}

/* ---- linearising ---- */

/* Ranks, and which bodies are in the subtree of a deficient joint, as mbsri_tree_mark; whether any. */
static bool mark(const mbsr_newton *w, const mbsr_data *d)
{
    const mbsr_model *m = w->model;
    bool some = false;
    for (size_t k = 0; k < 3 * ((size_t)m->bodies + 1); ++k) w->product.flags[k] = 0;
    for (int i = 1; i <= m->bodies; ++i) {
        if (!mbsri_heads(m, d, i)) continue;
        const mbsri_group g = mbsri_group_of(m, d, i);
        ranks(w)[i] = mbsri_group_rank(d, &g);
        for (int k = 0; k < g.members; ++k) {
            const int at = g.member[k];
            coupled(w)[at] = g.members > 1;
            deep(w)[at] = g.members > 1 || deep(w)[m->body[i].parent] || ranks(w)[i] < g.n;
            some = some || deep(w)[at];
        }
    }
    return some;
}

/* The first rows of a column of one matrix, to a column of another that has these alone. */
static void copy_column(int from, int rows_from, const double *A, int to, int rows, double *B)
{
    mbsri_copy((size_t)rows, A + (size_t)from * (size_t)rows_from, B + (size_t)to * (size_t)rows);
}

static int keep_joint(mbsr_newton *w, mbsr_data *d, int i)
{
    const mbsr_model *m = w->model;
    const mbsri_body *b = m->body + i;
    const bool accelerated = deep(w)[i] != 0, above = deep(w)[b->parent] != 0,
               group = coupled(w)[i] != 0;
    const terms k = terms_of(w, i);
    const int x = motions(w, i, accelerated), columns = variables(w, i, above),
              x_pred = motions(w, b->parent, above);
    mbsri_joint_slopes s;
    mbsri_joint_slopes_place(&s, w->joint);
    int status = mbsri_joint_slopes_of(m, d, i, accelerated, d->udot + b->iu, &s);
    if (status) return status;
    for (int at = 0; at < columns; ++at) {
        const int from = at < x_pred ? at : s.q + at - x_pred;
        copy_column(from, s.e + 2 * b->d, s.x, at, x, k.x);
        copy_column(from, 3 * b->d_pred, s.below, at, actions(b->d_pred, above), k.below);
        copy_column(from, 3 * b->n, s.own, at, actions(b->n, accelerated), k.own);
        copy_column(from, b->nq, s.qdot, at, b->nq, k.qdot);
    }
    const size_t nd = (size_t)b->d, n = (size_t)b->n, dp = nd * (size_t)b->d_pred, dn = nd * n;
    mbsri_zero((size_t)actions(b->d, accelerated) * (size_t)x, k.P);
    status = mbsri_body_slopes_add(m, d, i, accelerated, k.P, w->body);
    mbsri_copy(dp, d->H + b->dp, k.H);
    mbsri_copy(dp, d->Hdot + b->dp, k.Hdot);
    mbsri_copy(dn, d->J + b->dn, k.J);
    mbsri_copy(dn, d->Jdot + b->dn, k.Jdot);
    if (group && b->head != i) return status;
    const size_t all = group ? (size_t)b->group_n : n;
    mbsri_copy(nd * all, d->G + b->dg, k.G);
    mbsri_copy(all, d->s + b->ig, k.s);
    mbsri_copy(all * all, d->X + b->nn, k.X);
    return status;
}

static int keep_elements(mbsr_newton *w, mbsr_data *d)
{
    double *to = w->product.store + w->product.elements;
    for (size_t k = 0; k < w->model->forces.count; ++k) {
        int first, last;
        calls(w, force_of(w, k), &first, &last);
        for (int i = first; i <= last; ++i) {
            const int status = mbsri_force_slopes(w->model, d, force_of(w, k), i, &w->slopes);
            if (status) return status;
            const mbsr_force_derivatives *s = &w->slopes.out;
            const size_t size = (size_t)s->rows * (size_t)s->columns;
            mbsri_copy(size, s->matrix, to);
            to += size;
        }
    }
    return MBSR_OK;
}

static int keep_closures(mbsr_newton *w, mbsr_data *d)
{
    double *to = w->product.store + w->product.closures;
    for (size_t k = 0; k < w->model->closures.count; ++k) {
        const mbsri_closure *c = closure_of(w, k);
        const size_t columns = (size_t)c->columns, rows = (size_t)c->rows;
        mbsri_closure_tangents out = {.S = to, .slope = to + columns * columns};
        const int status =
            mbsri_closure_tangents_of(w->model, d, c, w->product.store + w->product.work, &out);
        if (status) return status;
        mbsri_copy(rows * columns, d->closure_C + c->at, out.slope + rows * columns);
        to += closure_size(c);
        for (int r = c->row; r < c->row + c->rows; ++r) dropped(w)[r] = d->dropped[r];
    }
    return MBSR_OK;
}

int mbsri_product_linearise(mbsr_newton *w, mbsr_data *d, double t, const double *y,
                            const double *yp, double c)
{
    const mbsr_model *m = w->model;
    w->product.c = c;
    int status = mbsri_tree_state(w, d, t, y, yp);
    if (status) return status;
    if (mark(w, d)) mbsri_tree_reactions(w, d);
    for (int i = 1; i <= m->bodies && !status; ++i) status = keep_joint(w, d, i);
    if (!status) status = keep_elements(w, d);
    if (!status) status = keep_closures(w, d);
    if (!status && m->grouped) status = mbsri_backward(m, d);
    return status;
}

/* ---- multiplying ---- */

/* c deta of the position rows that count -> w C_h^T, in the order of the sweeps, and forces on bodies
 * on the way; only with closures. */
static void find_push(const mbsr_newton *w, const double *delta, vectors *v)
{
    const mbsr_model *m = w->model;
    const double *eta = delta + m->nq + 2 * m->nu + m->rows,
                 *from = w->product.store + w->product.closures;
    mbsri_zero((size_t)m->nu, v->push);
    mbsri_zero(m->size_v, v->kappa);
    for (size_t l = 0; l < m->closures.count; ++l) {
        const mbsri_closure *c = closure_of(w, l);
        const double *C = from + (size_t)c->columns * (size_t)(c->columns + c->rows);
        for (int r = 0; r < c->rows; ++r) {
            const bool counts = r < c->held && !dropped(w)[c->row + r];
            v->in[r] = counts ? w->product.c * eta[c->held_row + r] : 0.0;
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
        from += closure_size(c);
    }
    for (int i = m->bodies; i >= 1; --i) {
        const mbsri_body *b = m->body + i;
        const terms k = terms_of(w, i);
        mbsri_atx(b->d, b->n, -1.0, k.J, v->kappa + b->v, v->push + b->iu);
        mbsri_atx(b->d, b->d_pred, -1.0, k.H, v->kappa + b->v, v->kappa + b->pred_v);
        for (int l = 0; l < b->n; ++l) v->push[b->iu + l] *= m->weight[b->iu + l];
    }
}

/* Root to leaves, joint i: x, r_q, what of the joint's equations depends on its variables alone. */
static void move(const mbsr_newton *w, int i, const double *delta, vectors *v, double *r)
{
    const mbsr_model *m = w->model;
    const mbsri_body *b = m->body + i;
    const mbsri_node *node = w->node + i, *above = w->node + b->parent;
    const terms k = terms_of(w, i);
    const bool own = deep(w)[i] != 0, of_pred = deep(w)[b->parent] != 0;
    const int x = motions(w, i, own), x_pred = motions(w, b->parent, of_pred), n = b->n, nq = b->nq,
              columns = variables(w, i, of_pred), rows = actions(n, own);
    double *z = v->in, *u = z + x_pred + nq, *rq = r + b->q, *action = v->action + 3 * b->pred_v;
    mbsri_copy((size_t)x_pred, v->motion + above->x, z);
    mbsri_copy((size_t)nq, delta + b->q, z + x_pred);
    mbsri_copy((size_t)n, delta + m->nq + m->nu + b->u, u);
    mbsri_zero((size_t)x, v->motion + node->x);
    mbsri_ax(x, columns, 1.0, k.x, z, v->motion + node->x);
    mbsri_zero((size_t)rows, v->own + 3 * b->iu);
    mbsri_ax(rows, columns, 1.0, k.own, z, v->own + 3 * b->iu);
    mbsri_ax(actions(b->d_pred, of_pred), columns, 1.0, k.below, z, action);
    for (int l = 0; l < n && m->rows > 0; ++l) u[l] += v->push[b->iu + l];
    for (int l = 0; l < nq; ++l) rq[l] = w->product.c * delta[b->q + l];
    mbsri_ax(nq, columns, -1.0, k.qdot, z, rq);
}

/* f enters sigma with -1 and mu with 1. */
static void add_force(const mbsri_body *b, const double *f, const double *tau, vectors *v)
{
    double *action = v->action + 3 * b->v;
    for (int l = 0; l < b->d; ++l) {
        action[b->d + l] -= f[l];
        action[2 * b->d + l] += f[l];
    }
    for (int l = 0; l < b->n && tau; ++l) v->torque[b->iu + l] += tau[l];
}

static void add_elements(const mbsr_newton *w, const double *delta, vectors *v)
{
    const mbsr_model *m = w->model;
    const double *matrix = w->product.store + w->product.elements;
    for (size_t k = 0; k < m->forces.count; ++k) {
        const mbsri_force *force = force_of(w, k);
        int first, last;
        calls(w, force, &first, &last);
        for (int i = first; i <= last; ++i) {
            const int *list;
            const int bodies = bodies_of(w, force, i, &list);
            int rows, columns;
            double *z = v->in, *f = v->out;
            shape(w, force, i, &rows, &columns);
            for (int l = 0; l < bodies; ++l) {
                const mbsri_body *b = m->body + list[l];
                if (list[l] == 0) continue;
                const size_t x = (size_t)(w->node[list[l]].e + b->d);
                mbsri_copy(x, v->motion + w->node[list[l]].x, z);
                mbsri_copy((size_t)b->nq, delta + b->q, z + x);
                mbsri_copy((size_t)b->n, delta + m->nq + m->nu + b->u, z + x + b->nq);
                z += x + (size_t)(b->nq + b->n);
            }
            mbsri_zero((size_t)rows, f);
            mbsri_ax(rows, columns, 1.0, matrix, v->in, f);
            matrix += (size_t)rows * (size_t)columns;
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
static void read_closure(const mbsr_newton *w, const mbsri_closure *c, const double *delta,
                         const vectors *v, double *place, double *rate)
{
    const mbsr_model *m = w->model;
    mbsri_zero((size_t)c->columns, place);
    mbsri_zero((size_t)c->columns, rate);
    for (int k = 0; k < c->bodies; ++k) {
        const int i = c->body[k];
        const mbsri_body *b = m->body + i;
        if (c->column[k] < 0 || i == 0) continue;
        const double *x = v->motion + w->node[i].x;
        double *e = place + c->column[k], *e_rate = rate + c->column[k];
        mbsri_copy((size_t)b->d, x, e);
        mbsri_copy((size_t)b->d, x + w->node[i].e, e_rate);
        if (!(c->def.table->flags & MBSR_CLOSURE_JOINTS)) continue;
        mbsri_copy((size_t)b->n, delta + b->q, e + b->d);
        mbsri_copy((size_t)b->n, delta + m->nq + m->nu + b->u, e_rate + b->d);
    }
}

/* The rows of a closure, where its velocity rows change by `rate` and its position rows by `place`,
 * and dlambda. */
static void close_rows(const mbsr_newton *w, const mbsri_closure *c, const double *delta,
                       const double *rate, const double *place, double *lambda, double *r)
{
    const mbsr_model *m = w->model;
    const int first = m->nq + 2 * m->nu;
    for (int k = 0; k < c->rows; ++k) {
        const int row = first + c->row + k, held = first + m->rows + c->held_row + k;
        const double stiffness = c->def.stiffness[k], s = delta[row], f = w->product.c;
        if (stiffness > 0.0) {
            lambda[k] = -(s + c->def.damping[k] / stiffness * f * s);
            r[row] = f * s / stiffness - rate[k];
            if (k < c->held)
                r[held] = dropped(w)[c->row + k] ? delta[held] : place[k] - s / stiffness;
        } else if (dropped(w)[c->row + k]) {
            lambda[k] = 0.0;
            r[row] = s;
            if (k < c->held) r[held] = delta[held];
        } else {
            lambda[k] = f * s;
            r[row] = rate[k];
            if (k < c->held) r[held] = place[k];
        }
    }
}

static void add_closures(const mbsr_newton *w, const double *delta, vectors *v, double *r)
{
    const mbsr_model *m = w->model;
    const double *S = w->product.store + w->product.closures;
    for (size_t l = 0; l < m->closures.count; ++l) {
        const mbsri_closure *c = closure_of(w, l);
        const int columns = c->columns, rows = c->rows;
        const double *slope = S + (size_t)columns * (size_t)columns,
                     *C = slope + (size_t)rows * (size_t)columns;
        double *place = v->in, *rate = place + columns, *force = v->out,
               velocity[MBSR_CLOSURE_ROWS] = {0.0}, gap[MBSR_CLOSURE_ROWS] = {0.0},
               lambda[MBSR_CLOSURE_ROWS];
        read_closure(w, c, delta, v, place, rate);
        mbsri_ax(rows, columns, 1.0, slope, place, velocity);
        mbsri_ax(rows, columns, 1.0, C, rate, velocity);
        mbsri_ax(rows, columns, 1.0, C, place, gap);
        close_rows(w, c, delta, velocity, gap, lambda, r);
        mbsri_zero((size_t)columns, force);
        mbsri_ax(columns, columns, 1.0, S, place, force);
        mbsri_atx(rows, columns, 1.0, C, lambda, force);
        for (int k = 0; k < c->bodies; ++k) {
            const mbsri_body *b = m->body + c->body[k];
            if (c->column[k] < 0 || c->body[k] == 0) continue;
            const double *f = force + c->column[k];
            const bool joints = (c->def.table->flags & MBSR_CLOSURE_JOINTS) != 0;
            add_force(b, f, joints ? f + b->d : NULL, v);
        }
        S += closure_size(c);
    }
}

/* Leaves to root, joint i: y, r_p, and d(M u) - dp and d(J^T mu - tau) before L^-1. */
static void act(const mbsr_newton *w, int i, const double *delta, vectors *v, double *r)
{
    const mbsr_model *m = w->model;
    const mbsri_body *b = m->body + i;
    const terms k = terms_of(w, i);
    const mbsri_kept kept = {.H = k.H, .Hdot = k.Hdot};
    const int d = b->d, n = b->n;
    const bool reacts = deep(w)[i] != 0;
    const double *own = v->own + 3 * b->iu, *tau = v->torque + b->iu, *dp = delta + m->nq + b->u;
    double *y = v->action + 3 * b->v, *momentum = v->momentum + b->ig,
           *balance = v->balance + b->ig, *rp = r + m->nq + b->u;
    mbsri_ax(actions(d, reacts), motions(w, i, reacts), 1.0, k.P, v->motion + w->node[i].x, y);
    for (int l = 0; l < n; ++l) {
        momentum[l] = own[l] - dp[l];
        balance[l] = reacts ? own[2 * n + l] - tau[l] : 0.0;
        rp[l] = w->product.c * dp[l] - own[n + l] - tau[l];
    }
    mbsri_atx(d, n, 1.0, k.J, y, momentum);
    if (reacts) mbsri_atx(d, n, 1.0, k.J, y + 2 * d, balance);
    mbsri_atx(d, n, -1.0, k.J, y + d, rp);
    mbsri_atx(d, n, -1.0, k.Jdot, y, rp);
    mbsri_pass_action(b, &kept, deep(w)[b->parent] != 0, y, v->action + 3 * b->pred_v);
}

/* The step of L^-1 for joint i, whose members are done: x <- x - J^T xbar, and what the head passes
 * on, xbar + G x. */
static void condense(const mbsr_newton *w, int i, double *x, double *xbar)
{
    const mbsr_model *m = w->model;
    const mbsri_body *b = m->body + i;
    const terms k = terms_of(w, i);
    mbsri_atx(b->d, b->n, -1.0, k.J, xbar + b->v, x + b->ig);
    if (!coupled(w)[i] || b->head == i)
        mbsri_ax(b->d, coupled(w)[i] ? b->group_n : b->n, 1.0, k.G, x + b->ig, xbar + b->v);
    mbsri_atx(b->d, b->d_pred, -1.0, k.H, xbar + b->v, xbar + b->pred_v);
}

/* r_u of a joint, or of the group of that head. */
static void balance_of(const mbsr_newton *w, int i, vectors *v, double *r)
{
    const mbsr_model *m = w->model;
    const mbsri_body *b = m->body + i;
    const bool group = coupled(w)[i] != 0;
    const terms k = terms_of(w, i);
    const mbsri_kept kept = {.s = k.s, .X = k.X};
    const int n = group ? b->group_n : b->n, rank = ranks(w)[i];
    double *x = v->momentum + b->ig, *gamma = v->balance + b->ig, *range = v->in;
    mbsri_kept_split(&kept, n, rank, gamma, range);
    mbsri_kept_split(&kept, n, rank, x, range);
    for (int l = 0; l < n; ++l) x[l] = range[l] + gamma[l];
    const mbsri_group g =
        group ? mbsri_group_in_model(m, i) : (mbsri_group){m->member + b->at, 1, b->n, b->ig};
    mbsri_group_scatter(m, &g, x, r + m->nq + m->nu);
}

void mbsri_product_multiply(mbsr_newton *w, const double *delta, double *r)
{
    const mbsr_model *m = w->model;
    vectors v;
    place_vectors(w, w->product.store + w->product.vectors, &v);
    mbsri_zero(w->size_x, v.motion);
    mbsri_zero(3 * m->size_v, v.action);
    mbsri_zero((size_t)m->nu, v.torque);
    mbsri_zero(m->size_v, v.mbar);
    mbsri_zero(m->size_v, v.fbar);
    if (m->rows > 0) find_push(w, delta, &v);
    for (int i = 1; i <= m->bodies; ++i) move(w, i, delta, &v, r);
    add_elements(w, delta, &v);
    add_closures(w, delta, &v, r);
    for (int i = m->bodies; i >= 1; --i) act(w, i, delta, &v, r);
    for (int i = m->bodies; i >= 1; --i) {
        condense(w, i, v.momentum, v.mbar);
        condense(w, i, v.balance, v.fbar);
    }
    for (int i = 1; i <= m->bodies; ++i) {
        if (!coupled(w)[i] || m->body[i].head == i) balance_of(w, i, &v, r);
    }
}
