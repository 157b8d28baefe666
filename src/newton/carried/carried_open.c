/* Closures in the elimination on the tree, at one factorisation: see carried.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "newton/carried/carried.h"
#include "newton/carried/follower.h"

#include "algebra/dense.h"
#include "newton/slopes/closure_slopes.h"
#include "newton/front/front.h"
#include "recursion/closures.h"
#include "recursion/pose.h"

#include <math.h>

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

/* ---- at a factorisation ---- */

/* What of its rows stands in the multipliers alone. */
static void add_diagonal(mbsr_newton *w, const mbsr_data *d, int number, double c)
{
    mbsri_carried *v = &w->carried;
    const mbsri_closure *closure = mbsri_closure_at(w->model, (size_t)number);
    mbsri_pool *pool = mbsri_carried_at(w, v->loop[number].pool);
    double *T = v->store + mbsri_pool_T(pool);
    for (int k = 0; k < closure->position_rows; ++k) {
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

/* The square of a row over the motion of the first body that has a part in it, which moves by the
 * length what it turns. */
static double square_of_row(const mbsr_model *m, const mbsr_data *d, const mbsri_closure *c,
                            int row)
{
    const int l = c->column[0] >= 0 ? 0 : 1, rows = c->rows;
    const mbsri_body *b = m->body + c->body[l];
    const double *C = d->closure_C + c->at + (size_t)(c->column[l] * rows + row),
                 length = m->typical.length > 0.0 ? m->typical.length : 1.0;
    double sum = 0.0;
    for (int j = 0; j < b->d; ++j, C += rows) {
        const double moved = mbsri_is_angle(b->joint.space, j) ? *C / length : *C;
        sum += moved * moved;
    }
    return sum;
}

/* Of squares: what eta moves along a row, beside what that row would be moved by at most; and the
 * largest of rows that are looked at, so that others cost nothing. */
static const double nothing = 1e-24, doubtful = 1e-13, largest = 1e6;

/* Position row of that name, which eta moves so much along. Stiff rows have their compliance, and
 * couplings read the joints themselves. */
static int judge_row(const mbsr_newton *w, mbsr_data *d, int k, int name, double moved)
{
    const mbsri_carried *v = &w->carried;
    const mbsr_model *m = w->model;
    const int number = v->closure[name];
    const mbsri_closure *c = mbsri_closure_at(m, (size_t)number);
    const int row = name - m->rows - c->position_row;
    if (v->loop[number].pool != k || mbsri_is_coupling(c) || mbsri_is_stiff(c, row)) return MBSR_OK;
    const double size = v->mobility * square_of_row(m, d, c, row);
    if (moved < nothing * size) return mbsri_front_refuse_row(m, d, number, row);
    return moved < doubtful * size ? MBSRI_NOT_SERVED : MBSR_OK;
}

/* Scaled to 1 a row of rounding would pass for any other. */
int mbsri_carried_judge(const mbsr_newton *w, mbsr_data *d, int k, double c)
{
    const mbsri_carried *v = &w->carried;
    const mbsri_pool *pool = mbsri_carried_at(w, k);
    const int *name = v->numbers + pool->column, first = w->model->rows,
              end = first + w->model->position_rows;
    const double *T = v->store + mbsri_pool_T(pool), limit = doubtful * largest * v->mobility;
    int status = MBSR_OK;
    if (!v->front[k].judged) return status;
    for (int l = 0; l < pool->count; ++l, T += pool->most + 1) {
        const double moved = fabs(c * *T);
        if (!(moved < limit) || name[l] < first || name[l] >= end) continue;
        const int found = judge_row(w, d, k, name[l], moved);
        if (found && status != MBSR_LOOP_SINGULAR) status = found;
    }
    return status;
}

void mbsri_carried_seat(mbsr_newton *w, int k)
{
    mbsri_carried *v = &w->carried;
    const mbsri_pool *pool = mbsri_carried_at(w, k);
    const int *row = v->numbers + mbsri_pool_row(pool),
              multipliers = w->model->rows + w->model->position_rows;
    for (int l = 0; l < pool->count; ++l) {
        if (row[l] < multipliers && v->loop[v->closure[row[l]]].pool == k)
            v->multiplier[row[l]].right = (ptrdiff_t)pool->right + l;
    }
}

/* Row k of a closure: what r and delta count. Of a stiff one delta counts the force of the spring
 * alone. */
static void open_multipliers(mbsr_newton *w, const mbsri_closure *closure, int k, double c)
{
    mbsri_multiplier *multiplier = w->carried.multiplier;
    const double stiffness = closure->def.stiffness[k], damping = closure->def.damping[k];
    const bool stiff = mbsri_is_stiff(closure, k);
    multiplier[mbsri_name_lambda(closure, k)] = (mbsri_multiplier){
        -1, stiff ? -1.0 : 1.0, stiff ? -stiffness / (stiffness + c * damping) : 1.0 / c};
    if (k < closure->position_rows)
        multiplier[mbsri_name_eta(w->model, closure, k)] = (mbsri_multiplier){-1, 1.0, 1.0 / c};
}

/* The derivatives of closure k. */
static int open_loop(mbsr_newton *w, mbsr_data *d, int k, double factor)
{
    mbsri_carried *v = &w->carried;
    mbsri_loop *loop = v->loop + k;
    const mbsri_closure *c = mbsri_closure_at(w->model, (size_t)k);
    mbsri_closure_tangents out = {v->store + loop->S,
                                  v->store + loop->slope,
                                  v->store + loop->left,
                                  v->store + loop->read,
                                  loop->most,
                                  0};
    for (int l = 0; l < c->rows; ++l) open_multipliers(w, c, l, factor);
    loop->follower = false;
    loop->rank = 0;
    if (mbsri_closure_is_constant(c)) return MBSR_OK;
    const int status = mbsri_closure_tangents_of(w->model, d, c, v->work, &out);
    if (status || loop->most == 0) return status;
    loop->follower = mbsri_follower_open(w, d, k, factor);
    if (loop->follower) {
        loop->next_follower = v->first_follower;
        v->first_follower = k;
        return MBSR_OK;
    }
    mbsri_closure_across(w->model, c, v->work, &out);
    loop->rank = out.rank;
    return MBSR_OK;
}

int mbsri_carried_open(mbsr_newton *w, mbsr_data *d, double c)
{
    mbsri_carried *v = &w->carried;
    v->first_follower = -1;
    for (int k = 0; k < v->uses; ++k) v->lane_pool[v->used[k]].count = 0;
    for (int k = 0; k < (int)w->model->closures.count; ++k) {
        mbsri_expect_closure(w->model, mbsri_closure_at(w->model, (size_t)k));
        const int status = open_loop(w, d, k, c);
        if (status) return status;
    }
    return MBSR_OK;
}
