/* Closures in the elimination on the tree, at one factorisation: see carried.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "newton/blocks/carried.h"
#include "newton/blocks/turned.h"

#include "algebra/dense.h"
#include "newton/slopes/closure_slopes.h"
#include "recursion/closures.h"

static const mbsri_closure *closure_of(const mbsr_newton *w, int k)
{
    return (const mbsri_closure *)w->model->closures.data + k;
}

/* ---- names in a pool ---- */

/* Place `at` of the pool, with nothing in it. */
static void clear(mbsr_newton *w, const mbsri_pool *pool, int at)
{
    double *store = w->carried.store;
    const int most = pool->most, d = pool->stride / 3;
    mbsri_zero((size_t)pool->stride, store + pool->Q + (size_t)(at * pool->stride));
    mbsri_zero((size_t)d, store + mbsri_pool_kappa(pool) + (size_t)(at * d));
    mbsri_zero((size_t)pool->motions, store + mbsri_pool_R(pool) + (size_t)(at * pool->motions));
    for (int l = 0; l <= at; ++l) {
        store[mbsri_pool_T(pool) + (size_t)(l * most + at)] = 0.0;
        store[mbsri_pool_T(pool) + (size_t)(at * most + l)] = 0.0;
    }
}

int mbsri_carried_join(mbsr_newton *w, mbsri_pool *pool, int name)
{
    int *column = w->carried.numbers + pool->column,
        *row = w->carried.numbers + mbsri_pool_row(pool);
    int at = mbsri_carried_find(column, pool->count, name);
    if (at >= 0) return at;
    at = pool->count++;
    column[at] = row[at] = name;
    clear(w, pool, at);
    return at;
}

/* ---- what a closure is at a body ---- */

/* The place of the body's columns in matrices over all of the closure. */
typedef struct site {
    const mbsri_closure *c;
    mbsri_loop *loop;
    mbsri_pool *pool;
    int column, d, e;
} site;

/* Adds to row `at` of the pool s times what row k of `from` (rows) reads of the body's columns, from
 * column `to` of x on. */
static void add_row(mbsr_newton *w, const site *s, int at, int to, double factor, int rows,
                    const double *from, int k)
{
    double *R = w->carried.store + mbsri_pool_R(s->pool);
    for (int l = 0; l < s->d; ++l)
        R[at * s->pool->motions + to + l] +=
            factor * from[(size_t)(s->column + l) * (size_t)rows + (size_t)k];
}

/* Adds a force on the body to column `at` of the pool: entry l is from[l * stride]. */
static void add_force(mbsr_newton *w, const site *s, int at, const double *from, int stride)
{
    const int body = s->pool->body;
    double *Q = w->carried.store + s->pool->Q + (size_t)(at * s->pool->stride);
    for (int l = 0; l < s->d; ++l) {
        Q[s->d + l] -= from[l * stride];
        if (w->node[body].deep) Q[2 * s->d + l] += from[l * stride];
    }
}

static void add_end(mbsr_newton *w, const mbsr_data *d, int closure, int slot)
{
    const mbsr_model *m = w->model;
    mbsri_carried *v = &w->carried;
    const mbsri_closure *c = closure_of(w, closure);
    const int body = c->body[slot];
    site s = {.c = c, .loop = v->loop + closure, .column = c->column[slot]};
    if (body == 0) return;
    const int number = body == v->pool[s.loop->pool].body ? s.loop->pool : body;
    if (w->mixed && v->swept[number].swept) return; /* see swept.h */
    s.pool = v->pool + number;
    s.d = m->body[body].d;
    s.e = w->node[body].e;
    const double *C = d->closure_C + c->at, *slope = v->store + s.loop->slope;
    for (int k = 0; k < c->rows; ++k) {
        if (d->dropped[c->row + k] && !mbsri_is_stiff(c, k)) continue;
        const int lambda = mbsri_carried_join(w, s.pool, mbsri_name_lambda(c, k));
        const double *row = C + (size_t)s.column * (size_t)c->rows + k;
        add_force(w, &s, lambda, row, c->rows);
        add_row(w, &s, lambda, s.e, 1.0, c->rows, C, k);
        add_row(w, &s, lambda, 0, 1.0, c->rows, slope, k);
        if (k >= c->held || d->dropped[c->row + k]) continue;
        const int eta = mbsri_carried_join(w, s.pool, mbsri_name_eta(m, c, k));
        double *kappa = v->store + mbsri_pool_kappa(s.pool) + (size_t)(eta * s.d);
        for (int l = 0; l < s.d; ++l) kappa[l] += row[l * c->rows];
        add_row(w, &s, eta, 0, 1.0, c->rows, C, k);
    }
    for (int k = 0; k < s.loop->rank; ++k) {
        const int at = mbsri_carried_join(w, s.pool, s.loop->across + k);
        add_force(w, &s, at, v->store + s.loop->left + (size_t)(k * c->columns + s.column), 1);
        add_row(w, &s, at, 0, -1.0, s.loop->most, v->store + s.loop->read, k);
    }
}

/* What of its rows stands in the multipliers alone. */
static void add_diagonal(mbsr_newton *w, const mbsr_data *d, int number, double c)
{
    mbsri_carried *v = &w->carried;
    const mbsri_closure *closure = closure_of(w, number);
    mbsri_pool *pool = mbsri_carried_at(w, v->loop[number].pool);
    double *T = v->store + mbsri_pool_T(pool);
    for (int k = 0; k < closure->held; ++k) {
        if (!mbsri_is_stiff(closure, k)) continue;
        const int lambda = mbsri_carried_join(w, pool, mbsri_name_lambda(closure, k));
        const double compliance = 1.0 / (closure->def.stiffness[k] + c * closure->def.damping[k]);
        T[lambda * pool->most + lambda] += c * compliance;
        if (d->dropped[closure->row + k]) continue;
        const int eta = mbsri_carried_join(w, pool, mbsri_name_eta(w->model, closure, k));
        T[lambda * pool->most + eta] += compliance;
    }
    for (int k = 0; k < v->loop[number].rank; ++k) {
        const int at = mbsri_carried_join(w, pool, v->loop[number].across + k);
        T[at * pool->most + at] += 1.0;
    }
}

void mbsri_carried_diagonal(mbsr_newton *w, const mbsr_data *d, int k, double c)
{
    const mbsri_carried *v = &w->carried;
    for (int l = v->front[k].first_loop; l >= 0; l = v->loop[l].next) add_diagonal(w, d, l, c);
}

/* Whether what waits in pool k may go where loops close in another: in the front of one group of joints, whose
 * members hand nothing on to each other. */
static bool same_group(const mbsr_newton *w, int closing, int k)
{
    const mbsri_carried *v = &w->carried;
    const int at = v->pool[closing].body, body = v->pool[k].body;
    return !v->swept[k].swept && w->node[at].coupled && w->node[body].coupled &&
           w->model->body[at].head == w->model->body[body].head;
}

void mbsri_carried_seat(mbsr_newton *w, int k)
{
    mbsri_carried *v = &w->carried;
    const mbsri_pool *pool = mbsri_carried_at(w, k);
    const int *row = v->numbers + mbsri_pool_row(pool),
              multipliers = w->model->rows + w->model->held;
    for (int l = 0; l < pool->count; ++l) {
        if (row[l] >= multipliers) continue;
        const int closing = v->loop[v->closure[row[l]]].pool;
        if (closing == k || same_group(w, closing, k))
            v->multiplier[row[l]].right = (ptrdiff_t)pool->right + l;
    }
}

/* Row k of a closure: what r and delta count. Of a stiff one delta counts the force of the spring alone. */
static void open_multipliers(mbsr_newton *w, const mbsri_closure *closure, int k, double c)
{
    mbsri_multiplier *multiplier = w->carried.multiplier;
    const double stiffness = closure->def.stiffness[k], damping = closure->def.damping[k];
    const bool stiff = mbsri_is_stiff(closure, k);
    multiplier[mbsri_name_lambda(closure, k)] = (mbsri_multiplier){
        -1, stiff ? -1.0 : 1.0, stiff ? -stiffness / (stiffness + c * damping) : 1.0 / c};
    if (k < closure->held)
        multiplier[mbsri_name_eta(w->model, closure, k)] = (mbsri_multiplier){-1, 1.0, 1.0 / c};
}

/* The derivatives of closure k. */
static int open_loop(mbsr_newton *w, mbsr_data *d, int k, double factor, bool looped)
{
    mbsri_carried *v = &w->carried;
    mbsri_loop *loop = v->loop + k;
    const mbsri_closure *c = closure_of(w, k);
    mbsri_closure_tangents out = {v->store + loop->S,
                                  v->store + loop->slope,
                                  v->store + loop->left,
                                  v->store + loop->read,
                                  loop->most,
                                  0};
    for (int l = 0; l < c->rows; ++l) open_multipliers(w, c, l, factor);
    loop->turned = false;
    loop->rank = 0;
    if (mbsri_closure_is_constant(c)) return MBSR_OK;
    const int status = mbsri_closure_tangents_of(w->model, d, c, v->work, &out);
    if (status || loop->most == 0) return status;
    loop->turned = looped && mbsri_turned_open(w, d, k, factor);
    if (loop->turned) {
        loop->next_turned = v->first_turned;
        v->first_turned = k;
        return MBSR_OK;
    }
    mbsri_closure_across(c, v->work, &out);
    loop->rank = out.rank;
    return MBSR_OK;
}

int mbsri_carried_open(mbsr_newton *w, mbsr_data *d, double c, bool looped)
{
    mbsri_carried *v = &w->carried;
    v->first_turned = -1;
    for (int k = 0; k < v->uses; ++k) {
        const int i = v->used[k];
        v->pool[i].count = v->swept[i].count = 0;
        v->swept[i].closed = false;
    }
    for (int k = 0; k < (int)w->model->closures.count; ++k) {
        mbsri_expect_closure(w->model, closure_of(w, k));
        const int status = open_loop(w, d, k, c, looped);
        if (status) return status;
    }
    for (int k = 0; k < (int)w->model->closures.count; ++k) {
        for (int l = 0; l < closure_of(w, k)->def.bodies; ++l) add_end(w, d, k, l);
    }
    for (int k = 0; k < (int)w->model->closures.count; ++k) {
        if (!mbsri_carried_at(w, v->loop[k].pool)->swept) add_diagonal(w, d, k, c);
    }
    return MBSR_OK;
}
