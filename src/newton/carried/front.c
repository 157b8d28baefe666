/* Fronts while they are made and eliminated: see front.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Of body i, y = P x + Q v + b with the unknowns v that are carried there, and as many rows R x + T
 * v = s wait. All columns over (v, x) and all rows (waiting, y) make the matrix of the front. */
#include "newton/carried/front.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "base/error.h"
#include "model/query.h"
#include "newton/carried/elimination.h"
#include "recursion/closure_view.h"

#include <math.h>

typedef struct build {
    mbsr_newton *w;
    mbsr_data *d;
    mbsri_carried *v;
    mbsri_carried_front *front;
    int i, k;             /* the front; unknowns */
    int motions, actions; /* of the body above */
    double *P;            /* its matrix */
    int *name_column, *name_row;
    double *M;        /* the front's matrix */
    double *kappa_up; /* work: d of the body above x k */
    double *rest;
} build;

/* ---- what is carried ---- */

static int join(int *list, int *count, int name)
{
    int at = mbsri_carried_find(list, *count, name);
    if (at >= 0) return at;
    list[(*count)++] = name;
    return *count - 1;
}

/* The names of the pool, and the places of its rows among them. */
static void collect(build *b)
{
    int rows = 0;
    b->k = 0;
    mbsri_carried_seat(b->w, b->i);
    const mbsri_pool *pool = b->v->swept + b->i;
    const int *column = b->v->numbers + pool->column, *row = b->v->numbers + mbsri_pool_row(pool);
    int *place = b->v->numbers + pool->place;
    for (int j = 0; j < pool->count; ++j) {
        (void)join(b->name_column, &b->k, column[j]);
        place[j] = join(b->name_row, &rows, row[j]);
    }
}

static double *take(build *b, size_t count)
{
    double *place = b->rest;
    b->rest += count;
    mbsri_zero(count, place);
    return place;
}

static void open_front(build *b)
{
    mbsri_carried *v = b->v;
    mbsri_carried_front *front = b->front;
    b->name_column = v->numbers + front->column;
    b->name_row = v->numbers + front->row;
    collect(b);
    front->size = b->k;
    const mbsri_pool *up = mbsri_carried_up(b->w, b->i);
    front->motions = b->motions = mbsri_carried_motions(b->w, up);
    front->actions = b->actions = mbsri_carried_actions(b->w, up);
    b->M = v->matrix;
    mbsri_zero((size_t)((b->k + b->actions) * (b->k + b->motions)), b->M);
    b->rest = v->work;
    b->kappa_up = take(b, (size_t)(up->stride / 3) * (size_t)b->k);
}

/* T, R, Q of the pool. */
static void add_pool(build *b)
{
    const mbsri_pool *pool = b->v->swept + b->i;
    const double *store = b->v->store;
    const int *column = b->v->numbers + pool->column, *place = b->v->numbers + pool->place;
    const size_t rows = (size_t)(b->k + b->actions);
    const int most = pool->most, d = pool->stride / 3;
    for (int l = 0; l < pool->count; ++l) {
        const int to = mbsri_carried_find(b->name_column, b->k, column[l]);
        double *M = b->M + (size_t)to * rows;
        for (int i = 0; i < pool->count; ++i)
            M[place[i]] += store[mbsri_pool_T(pool) + (size_t)(l * most + i)];
        if (b->actions == 0) continue;
        mbsri_copy((size_t)b->actions, store + pool->Q + (size_t)(l * pool->stride), M + b->k);
        mbsri_copy((size_t)d, store + mbsri_pool_kappa(pool) + (size_t)(l * d),
                   b->kappa_up + to * d);
    }
    for (int i = 0; i < pool->count; ++i) {
        const double *R = store + mbsri_pool_R(pool) + (size_t)(i * pool->motions);
        for (int l = 0; l < b->motions; ++l)
            b->M[(size_t)(b->k + l) * rows + (size_t)place[i]] = R[l];
    }
}

/* ---- elimination ---- */

/* The largest derivative of the row of a multiplier lambda. */
static double unit_of(const build *b, int name)
{
    const mbsri_closure *c =
        (const mbsri_closure *)b->w->model->closures.data + b->v->closure[name];
    const double *C = b->d->closure_C + c->at + (name - c->row);
    double unit = 0.0;
    for (int j = 0; j < c->columns; ++j) unit = fmax(unit, fabs(C[j * c->rows]));
    return unit;
}

/* Kinds of rows and columns, by name. */
static void sort_names(const build *b, const int *names, int *kind, double *unit)
{
    for (int l = 0; l < b->k; ++l) {
        const int name = names[l];
        const bool multiplier = name < b->v->multipliers;
        if (!multiplier)
            kind[l] = MBSRI_HELD;
        else if (mbsri_carried_level(b->w, name) < b->front->level)
            kind[l] = MBSRI_WAITS;
        else
            kind[l] = MBSRI_CLOSES;
        unit[l] = name < b->w->model->rows ? unit_of(b, name) : 0.0;
    }
}

/* What is left singular: the text names a joint, or a closure and its row. */
static int singular(const build *b, const mbsri_elimination *e)
{
    const mbsr_model *m = b->w->model;
    int joint = 0, closure = MBSR_NONE, row = 0;
    for (int l = e->done; l < e->size; ++l) {
        if (e->column_kind[e->column[l]] == MBSRI_WAITS) continue;
        const int name = b->name_column[e->column[l]];
        if (name < b->v->multipliers) {
            if (closure != MBSR_NONE) continue;
            closure = b->v->closure[name];
            const mbsri_closure *c = (const mbsri_closure *)m->closures.data + closure;
            row = name < m->rows             ? name - c->row
                  : name < m->rows + m->held ? name - m->rows - c->held_row
                                             : 0;
        } else {
            for (int i = m->bodies; i > 0 && joint == 0; --i)
                joint = name >= mbsri_name_own(b->w, i, 0) ? i : 0;
        }
    }
    char label[MBSRI_LABEL];
    if (joint > 0) {
        const mbsri_body *body = m->body + joint;
        return mbsri_fail(&b->d->error, MBSR_SINGULAR_BLOCK, body->id, MBSR_NONE,
                          "%s: joint '%s': no loop holds its massless motion at t = %g; %s",
                          mbsri_body_label(m, joint, label), body->joint.table->name, b->d->t,
                          MBSRI_SINGULAR_ADVICE);
    }
    const mbsri_closure *c = (const mbsri_closure *)m->closures.data + closure;
    return mbsri_fail(&b->d->error, MBSR_LOOP_SINGULAR, MBSR_NONE, MBSR_NONE,
                      "%s (%s): row '%s' depends on other rows at t = %g; mbsr_closures_report "
                      "names redundant rows and singular positions",
                      mbsri_closure_label(m, closure, label), c->def.table->name,
                      mbsri_closure_row_name(m, c, row), b->d->t);
}

/* What is left goes to the pool above: T, R, Q and P. */
static void hand_on(const build *b, const mbsri_elimination *e)
{
    mbsr_newton *w = b->w;
    mbsri_carried *v = b->v;
    mbsri_pool *pool = mbsri_carried_up(w, b->i);
    int *place = v->numbers + b->front->place, *to = v->list, left = e->size - e->done;
    const int ld = e->rows;
    for (int l = 0; l < left; ++l) { /* those that wait have equal rows and columns */
        const int at = e->column[e->done + l];
        to[l] = e->column_kind[at] == MBSRI_WAITS ? mbsri_carried_join(w, pool, b->name_column[at])
                                                  : -1;
    }
    int *column = v->numbers + pool->column, *row = v->numbers + mbsri_pool_row(pool);
    const int fresh = pool->count;
    for (int l = 0; l < left; ++l) {
        if (to[l] < 0) to[l] = mbsri_carried_join(w, pool, b->name_column[e->column[e->done + l]]);
    }
    int next = fresh;
    for (int l = 0; l < left; ++l) {
        const int at = e->row[e->done + l], name = b->name_row[at];
        if (e->row_kind[at] == MBSRI_WAITS) {
            place[l] = mbsri_carried_find(column, pool->count, name);
        } else {
            place[l] = next++;
            row[place[l]] = name;
        }
    }
    double *store = v->store;
    const int d = pool->stride / 3;
    for (int l = 0; l < left; ++l) {
        const double *from = e->M + (size_t)(e->done + l) * (size_t)ld;
        for (int i = 0; i < left; ++i)
            store[mbsri_pool_T(pool) + (size_t)(to[l] * pool->most + place[i])] +=
                from[e->done + i];
        mbsri_ax(b->actions, 1, 1.0, from + e->size, &(double){1.0},
                 store + pool->Q + (size_t)(to[l] * pool->stride));
        const int at = e->column[e->done + l];
        if (b->actions > 0)
            mbsri_ax(d, 1, 1.0, b->kappa_up + at * d, &(double){1.0},
                     store + mbsri_pool_kappa(pool) + (size_t)(to[l] * d));
    }
    for (int l = 0; l < b->motions; ++l) {
        const double *from = e->M + (size_t)(e->size + l) * (size_t)ld;
        for (int i = 0; i < left; ++i)
            store[mbsri_pool_R(pool) + (size_t)(place[i] * pool->motions + l)] += from[e->done + i];
        mbsri_ax(b->actions, 1, 1.0, from + e->size, &(double){1.0}, b->P + l * b->actions);
    }
}

static int not_finite(const build *b)
{
    const int closure = b->v->closure[b->name_column[0]];
    char label[MBSRI_LABEL];
    return mbsri_fail(&b->d->error, MBSR_NOT_FINITE, MBSR_NONE, MBSR_NONE,
                      "%s: the Newton equations of its loop are not finite at t = %g",
                      mbsri_closure_label(b->w->model, closure, label), b->d->t);
}

/* Columns of L, then rows of U, of what was eliminated. */
static void keep(const build *b, const mbsri_elimination *e)
{
    double *L = b->v->store + b->front->LU, *U = L + e->done * e->rows;
    mbsri_copy((size_t)e->done * (size_t)e->rows, e->M, L);
    for (int k = 0; k < e->done; ++k) {
        for (int l = k; l < e->columns; ++l)
            U[k * e->columns + l] = e->M[(size_t)l * (size_t)e->rows + (size_t)k];
    }
}

static int eliminate(build *b)
{
    mbsri_carried *v = b->v;
    double *scale = take(b, 4 * (size_t)b->k);
    int *kind = v->list + v->most;
    mbsri_elimination e = {.size = b->k, .rows = b->k + b->actions, .M = b->M};
    e.columns = b->k + b->motions;
    e.row = v->numbers + b->front->swap_row;
    e.column = v->numbers + b->front->swap_column;
    e.row_kind = kind;
    e.column_kind = kind + v->most;
    e.row_scale = scale;
    e.column_scale = scale + b->k;
    double *row_unit = scale + 2 * b->k, *column_unit = scale + 3 * b->k;
    e.row_unit = row_unit;
    e.column_unit = column_unit;
    if (!mbsri_finite((size_t)e.rows * (size_t)e.columns, e.M)) return not_finite(b);
    mbsri_elimination_begin(&e);
    sort_names(b, b->name_row, e.row_kind, row_unit);
    sort_names(b, b->name_column, e.column_kind, column_unit);
    const bool regular = mbsri_eliminate_held(&e, b->front->delayed);
    b->front->done = e.done;
    if (!regular) return singular(b, &e);
    if (!mbsri_finite((size_t)e.rows * (size_t)e.columns, e.M)) return not_finite(b);
    keep(b, &e);
    hand_on(b, &e);
    return MBSR_OK;
}

int mbsri_front_close_one(mbsr_newton *w, mbsr_data *d, int k, double *P)
{
    build b = {.w = w, .d = d, .v = &w->carried, .i = k, .P = P};
    b.front = b.v->front + k;
    open_front(&b);
    b.front->done = 0;
    if (b.k == 0) return MBSR_OK;
    add_pool(&b);
    return eliminate(&b);
}
