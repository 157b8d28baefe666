/* Fronts while they are made and eliminated: see front.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Of body i, y = P x + Q v + b with the unknowns v that are carried there, and as many rows R x + T v
 * = s wait. eta moves joints, dq = Cq (G (du + w C_h^T deta) + r_q). Of a joint, v has two kinds of
 * columns: by dq, as if that were given, and direct ones with dq held. All columns over (own
 * unknowns, v, x_pi) and all rows (of the joint, waiting, y_pi) make the matrix of the front. Own
 * unknowns stand in the basis S X of D where the joint is deep: in that, the null directions are
 * those that loops may hold. */
#include "newton/blocks/front.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "base/error.h"
#include "model/query.h"
#include "newton/blocks/elimination.h"
#include "newton/blocks/kept.h"
#include "recursion/closure_view.h"
#include "recursion/group.h"

#include <math.h>

typedef struct build {
    mbsr_newton *w;
    mbsr_data *d;
    mbsri_carried *v;
    mbsri_carried_front *front;
    mbsri_block_joint *all; /* NULL: loops close */
    const mbsri_front_joint *member;
    int members, i;
    int own, k, size, n, nq, columns; /* k: carried; columns of z */
    int motions, actions;             /* of the body above */
    double *P;                        /* its matrix */
    int *name_column, *name_row;
    double *M;                            /* the front's matrix */
    double *Mq, *along, *momentum, *rate; /* kept */
    /* work */
    double *waiting;              /* k x columns: rows that wait, over z */
    double *reaction, *below, *T; /* direct columns: n x k, actions x k, k x k */
    double *kappa_up;             /* d of the body above x k */
    double *y[MBSRI_GROUP_MOST], *kappa[MBSRI_GROUP_MOST]; /* direct, of the members */
    double *weight, *column;                               /* columns of z; one raw column */
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

/* The names of all pools, and the places of a pool's rows among them. */
static void collect(build *b)
{
    int rows = 0, at, number;
    b->k = 0;
    for (int l = 0; (number = mbsri_carried_pool(b->w, b->i, l, &at)) >= 0; ++l) {
        mbsri_carried_seat(b->w, number);
        const mbsri_pool *pool = mbsri_carried_at(b->w, number);
        const int *column = b->v->numbers + pool->column,
                  *row = b->v->numbers + mbsri_pool_row(pool);
        int *place = b->v->numbers + pool->place;
        for (int j = 0; j < pool->count; ++j) {
            (void)join(b->name_column, &b->k, column[j]);
            place[j] = join(b->name_row, &rows, row[j]);
        }
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
    b->size = b->own + b->k;
    front->own = b->own;
    front->size = b->size;
    front->n = b->n;
    front->nq = b->nq;
    const mbsri_pool *up = mbsri_carried_up(b->w, b->i);
    front->motions = b->motions = mbsri_carried_motions(b->w, up);
    front->actions = b->actions = mbsri_carried_actions(b->w, up);
    b->P = b->actions > 0 && !up->swept ? mbsri_tree_matrix(b->w, up->body) : b->P;
    b->M = v->matrix;
    b->Mq = v->store + front->Mq;
    b->along = v->store + front->along;
    b->momentum = v->store + front->momentum;
    b->rate = v->store + front->rate;
    const size_t rows = (size_t)(b->size + b->actions), k = (size_t)b->k, n = (size_t)b->n;
    mbsri_zero(rows * (size_t)(b->size + b->motions), b->M);
    b->rest = v->work;
    b->T = take(b, k * k);
    b->kappa_up = take(b, (size_t)(up->stride / 3) * k);
    if (!b->all) return;
    mbsri_zero(rows * (size_t)b->nq, b->Mq);
    mbsri_zero((size_t)b->nq * k, b->along);
    mbsri_zero(n * k, b->momentum);
    mbsri_zero(n * k, b->rate);
    b->waiting = take(b, k * (size_t)b->columns);
    b->reaction = take(b, n * k);
    b->below = take(b, (size_t)b->actions * k);
    b->weight = take(b, (size_t)b->columns);
    b->column = take(b, 3 * n + k + (size_t)b->actions);
    for (int l = 0; l < b->members; ++l) {
        const size_t d = (size_t)b->member[l].j->b->d;
        b->y[l] = take(b, 3 * d * k);
        b->kappa[l] = take(b, d * k);
    }
}

/* ---- pools and ends of closures at the members ---- */

/* Adds a pool to the columns and rows of the member that has its body. */
static void add_pool(build *b, int number, int at)
{
    const mbsri_pool *pool = mbsri_carried_at(b->w, number);
    const mbsri_block_joint *j = b->all ? b->member[at].j : NULL;
    const double *store = b->v->store;
    const int *column = b->v->numbers + pool->column, *place = b->v->numbers + pool->place;
    const int most = pool->most;
    for (int l = 0; l < pool->count; ++l) {
        const int to = mbsri_carried_find(b->name_column, b->k, column[l]);
        for (int i = 0; i < pool->count; ++i)
            b->T[to * b->k + place[i]] += store[mbsri_pool_T(pool) + (size_t)(l * most + i)];
        if (!j) continue;
        const int actions = j->actions, d = j->b->d;
        mbsri_ax(actions, 1, 1.0, store + pool->Q + (size_t)(l * pool->stride), &(double){1.0},
                 b->y[at] + to * actions);
        mbsri_ax(d, 1, 1.0, store + mbsri_pool_kappa(pool) + (size_t)(l * d), &(double){1.0},
                 b->kappa[at] + to * d);
    }
    if (!j) return;
    for (int l = 0; l < b->columns; ++l) {
        const double *x = j->kept.x + (size_t)l * (size_t)j->motions;
        double *out = b->waiting + (size_t)l * (size_t)b->k;
        for (int i = 0; i < pool->count; ++i)
            out[place[i]] +=
                mbsri_dot(j->motions, store + mbsri_pool_R(pool) + (size_t)(i * pool->motions), x);
    }
}

/* Adds what closures that read joint coordinates are at a member: loads tau (n x k), rows over dq
 * and du. */
static void add_coordinates(build *b, int at, double *tau, double *force)
{
    const mbsri_front_joint *member = b->member + at;
    const mbsri_body *body = member->j->b;
    const int n = body->n, k = b->k;
    for (int l = b->v->first_end[member->j->i]; l >= 0; l = b->v->end[l].next) {
        const int number = b->v->end[l].closure;
        const mbsri_closure *c = (const mbsri_closure *)b->w->model->closures.data + number;
        const mbsri_loop *loop = b->v->loop + number;
        if (!(c->def.table->flags & MBSR_CLOSURE_JOINTS)) continue;
        const size_t first = (size_t)(c->column[b->v->end[l].slot] + body->d);
        const double *C = b->d->closure_C + c->at + first * (size_t)c->rows,
                     *slope = b->v->store + loop->slope + first * (size_t)c->rows,
                     *read = b->v->store + loop->read + first * (size_t)loop->most,
                     *left = b->v->store + loop->left + first;
        double *dq = b->waiting + (size_t)((b->all->q + member->q) * k),
               *du = b->waiting + (size_t)((b->all->u + member->u) * k);
        for (int r = 0; r < c->rows; ++r) {
            const int lambda = mbsri_carried_find(b->name_column, k, mbsri_name_lambda(c, r)),
                      row = mbsri_carried_find(b->name_row, k, mbsri_name_lambda(c, r));
            if (lambda < 0) continue; /* left out */
            for (int i = 0; i < n; ++i) {
                tau[lambda * n + i] += C[i * c->rows + r];
                du[i * k + row] += C[i * c->rows + r];
                dq[i * k + row] += slope[i * c->rows + r];
            }
            if (r >= c->held) continue;
            const int name = mbsri_name_eta(b->w->model, c, r),
                      eta = mbsri_carried_find(b->name_column, k, name),
                      place = mbsri_carried_find(b->name_row, k, name);
            for (int i = 0; i < n && eta >= 0; ++i) {
                force[eta * n + i] += C[i * c->rows + r];
                dq[i * k + place] += C[i * c->rows + r];
            }
        }
        for (int r = 0; r < loop->rank; ++r) {
            const int column = mbsri_carried_find(b->name_column, k, loop->across + r),
                      row = mbsri_carried_find(b->name_row, k, loop->across + r);
            for (int i = 0; i < n; ++i) {
                tau[column * n + i] += left[r * c->columns + i];
                dq[i * k + row] -= read[i * loop->most + r];
            }
        }
    }
}

/* Direct columns of a member, and what it hands on to the one above, or to the body above. */
static void add_direct(build *b, int at)
{
    const mbsri_front_joint *member = b->member + at;
    const mbsri_block_joint *j = member->j;
    const int d = j->b->d, n = j->n, dp = j->b->d_pred, k = b->k;
    double *tau = take(b, (size_t)(n * k)), *force = take(b, (size_t)(n * k));
    add_coordinates(b, at, tau, force);
    for (int l = 0; l < k; ++l) {
        const double *y = b->y[at] + l * j->actions, *kappa = b->kappa[at] + l * d;
        const size_t row = (size_t)(l * b->n + member->u);
        double *momentum = b->momentum + row, *rate = b->rate + row, *reaction = b->reaction + row;
        mbsri_atx(d, n, 1.0, j->kept.J, y, momentum);
        mbsri_atx(d, n, 1.0, j->kept.J, y + d, rate);
        mbsri_atx(d, n, 1.0, j->kept.Jdot, y, rate);
        if (j->node->deep) mbsri_atx(d, n, 1.0, j->kept.J, y + 2 * d, reaction);
        for (int i = 0; i < n; ++i) {
            rate[i] += tau[l * n + i];
            reaction[i] -= tau[l * n + i];
        }
        /* dq = Q (w C_h^T deta) */
        double *push = force + l * n;
        mbsri_atx(d, n, -1.0, j->kept.J, kappa, push);
        for (int i = 0; i < n; ++i) push[i] *= b->w->model->weight[j->b->iu + i];
        mbsri_ax(b->nq, n, 1.0, b->all->kept.Q + member->u * b->nq, push, b->along + l * b->nq);
        if (member->above < 0 && b->actions == 0) continue;
        double *up = member->above < 0 ? b->below + l * b->actions
                                       : b->y[member->above] + l * j->actions_pred,
               *kappa_up = (member->above < 0 ? b->kappa_up : b->kappa[member->above]) + l * dp;
        mbsri_pass_action(j->b, &j->kept, j->above->deep, y, up);
        mbsri_atx(d, dp, -1.0, j->kept.H, kappa, kappa_up);
    }
    b->rest = tau; /* done with */
}

/* ---- the matrix ---- */

/* The column of M (or Mq) where z is b->weight, and for one of v what is direct. */
static void compose(build *b, double c, int direct, double *out)
{
    const mbsri_block_joint *j = b->all;
    const int n = b->n, k = b->k;
    double *momentum = b->column, *rate = momentum + n, *reaction = rate + n,
           *waiting = reaction + n, *below = waiting + k;
    mbsri_zero((size_t)(3 * n + k + b->actions), momentum);
    for (int l = 0; l < b->columns; ++l) {
        const double *x = b->weight + l;
        if (*x == 0.0) continue;
        mbsri_ax(n, 1, 1.0, j->kept.momentum + (size_t)l * (size_t)n, x, momentum);
        mbsri_ax(n, 1, 1.0, j->kept.rate + (size_t)l * (size_t)n, x, rate);
        if (j->node->deep) mbsri_ax(n, 1, 1.0, j->reaction + (size_t)l * (size_t)n, x, reaction);
        mbsri_ax(k, 1, 1.0, b->waiting + (size_t)l * (size_t)k, x, waiting);
        mbsri_ax(b->actions, 1, 1.0, j->below + (size_t)l * (size_t)j->actions_pred, x, below);
    }
    if (direct >= 0) {
        const double one = 1.0;
        mbsri_ax(n, 1, 1.0, b->momentum + direct * n, &one, momentum);
        mbsri_ax(n, 1, 1.0, b->rate + direct * n, &one, rate);
        mbsri_ax(n, 1, 1.0, b->reaction + direct * n, &one, reaction);
        mbsri_ax(k, 1, 1.0, b->T + direct * k, &one, waiting);
        mbsri_ax(b->actions, 1, 1.0, b->below + direct * b->actions, &one, below);
    }
    for (int l = 0; l < n; ++l) momentum[l] = c * momentum[l] - rate[l];
    mbsri_kept_rows(&j->kept, j->node, n, momentum, reaction, out);
    mbsri_copy((size_t)(k + b->actions), waiting, out + b->own);
}

/* b->weight for own unknown l: du and the dq that follows, or du' in the range of D. */
static void weigh_own(build *b, int l)
{
    const mbsri_block_joint *j = b->all;
    double *own = b->column; /* not yet in use */
    mbsri_zero((size_t)b->own, own);
    own[l] = 1.0;
    mbsri_kept_rates(&j->kept, j->node, b->n, own, b->weight + j->u, b->weight + j->a);
    mbsri_ax(b->nq, b->n, 1.0, j->kept.Q, b->weight + j->u, b->weight + j->q);
}

static void fill_matrix(build *b, double c)
{
    const mbsri_block_joint *j = b->all;
    const size_t rows = (size_t)(b->size + b->actions), z = (size_t)b->columns;
    for (int l = 0; l < b->size + b->motions + b->nq; ++l) {
        const int direct = l >= b->own && l < b->size ? l - b->own : -1,
                  q = l - b->size - b->motions;
        mbsri_zero(z, b->weight);
        if (l < b->own)
            weigh_own(b, l);
        else if (direct >= 0)
            mbsri_copy((size_t)b->nq, b->along + direct * b->nq, b->weight + j->q);
        else
            b->weight[q < 0 ? l - b->size : j->q + q] = 1.0;
        compose(b, c, direct, q < 0 ? b->M + (size_t)l * rows : b->Mq + (size_t)q * rows);
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
            kind[b->own + l] = MBSRI_HELD;
        else if (mbsri_carried_level(b->w, name) < b->front->level)
            kind[b->own + l] = MBSRI_WAITS;
        else
            kind[b->own + l] = MBSRI_CLOSES;
        unit[b->own + l] = name < b->w->model->rows ? unit_of(b, name) : 0.0;
    }
}

/* Own rows and columns: those without inertia are directions that loops may hold. */
static void sort_own(const build *b, mbsri_elimination *e)
{
    if (!b->all) return;
    const mbsri_block_joint *j = b->all;
    const int n = b->n, rank = j->node->rank;
    for (int l = 0; l < b->own; ++l) {
        const bool deep = j->node->deep;
        const int row = deep && l >= rank ? l - rank : l;
        e->row_kind[l] = deep && row >= rank ? MBSRI_HELD : MBSRI_MASSIVE;
        e->column_kind[l] = deep && l >= rank && l < n ? MBSRI_HELD : MBSRI_MASSIVE;
        e->row_scale[l] = deep ? 0.0 : j->size[l];
        for (int i = 0; i < n && deep; ++i) {
            const double size =
                l < rank ? j->size[i] : j->size_mu[i] + *j->kept.unit * j->size_a[i];
            e->row_scale[l] += fabs(j->kept.X[row * n + i] * j->kept.s[i]) * size;
        }
    }
}

static int name_of(const build *b, const int *names, int at)
{
    return at < b->own ? mbsri_name_own(b->w, b->i, at) : names[at - b->own];
}

/* What is left singular: the text names a joint, or a closure and its row. */
static int singular(const build *b, const mbsri_elimination *e)
{
    const mbsr_model *m = b->w->model;
    int joint = 0, closure = MBSR_NONE, row = 0;
    for (int l = e->done; l < e->size; ++l) {
        if (e->column_kind[e->column[l]] == MBSRI_WAITS) continue;
        const int name = name_of(b, b->name_column, e->column[l]);
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
        to[l] = e->column_kind[at] == MBSRI_WAITS
                    ? mbsri_carried_join(w, pool, name_of(b, b->name_column, at))
                    : -1;
    }
    int *column = v->numbers + pool->column, *row = v->numbers + mbsri_pool_row(pool);
    const int fresh = pool->count;
    for (int l = 0; l < left; ++l) {
        if (to[l] < 0)
            to[l] = mbsri_carried_join(w, pool, name_of(b, b->name_column, e->column[e->done + l]));
    }
    int next = fresh;
    for (int l = 0; l < left; ++l) {
        const int at = e->row[e->done + l], name = name_of(b, b->name_row, at);
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
        if (at >= b->own && b->actions > 0)
            mbsri_ax(d, 1, 1.0, b->kappa_up + (at - b->own) * d, &(double){1.0},
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
    if (b->all) return mbsri_block_not_finite(b->all);
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
    double *scale = take(b, 4 * (size_t)b->size);
    int *kind = v->list + v->most;
    mbsri_elimination e = {.size = b->size, .rows = b->size + b->actions, .M = b->M};
    e.columns = b->size + b->motions;
    e.row = v->numbers + b->front->swap_row;
    e.column = v->numbers + b->front->swap_column;
    e.row_kind = kind;
    e.column_kind = kind + v->most;
    e.row_scale = scale;
    e.column_scale = scale + b->size;
    double *row_unit = scale + 2 * b->size, *column_unit = scale + 3 * b->size;
    e.row_unit = row_unit;
    e.column_unit = column_unit;
    if (!mbsri_finite((size_t)e.rows * (size_t)e.columns, e.M)) return not_finite(b);
    mbsri_elimination_begin(&e);
    sort_own(b, &e);
    sort_names(b, b->name_row, e.row_kind, row_unit);
    sort_names(b, b->name_column, e.column_kind, column_unit);
    mbsri_eliminate_massive(&e);
    const bool regular = mbsri_eliminate_held(&e, b->front->delayed);
    b->front->done = e.done;
    if (!regular) return singular(b, &e);
    if (!mbsri_finite((size_t)e.rows * (size_t)e.columns, e.M)) return not_finite(b);
    keep(b, &e);
    hand_on(b, &e);
    return MBSR_OK;
}

/* ---- entries ---- */

int mbsri_front_finish(mbsri_block_joint *all, int members, const mbsri_front_joint *member,
                       double c)
{
    const size_t n = (size_t)all->n;
    const bool deep = all->node->deep;
    if (!mbsri_finite(n, all->size) || !mbsri_finite(n, all->size_mu) ||
        !mbsri_finite(n, all->size_a))
        return mbsri_block_not_finite(all);
    mbsr_newton *w = all->w;
    build b = {.w = w, .d = all->d, .v = &w->carried, .all = all, .member = member};
    b.members = members;
    b.i = all->i;
    b.front = b.v->front + b.i;
    b.n = all->n;
    b.nq = all->nq;
    b.columns = all->columns;
    b.own = deep ? b.n + all->node->rank : b.n;
    *all->kept.unit = deep ? mbsri_block_unit(all) : 1.0;
    open_front(&b);
    int at, number;
    for (int l = 0; (number = mbsri_carried_pool(w, b.i, l, &at)) >= 0; ++l)
        add_pool(&b, number, at);
    for (int l = members - 1; l >= 0; --l) add_direct(&b, l);
    fill_matrix(&b, c);
    return eliminate(&b);
}

int mbsri_front_close_one(mbsr_newton *w, mbsr_data *d, int k, double *P)
{
    build b = {.w = w, .d = d, .v = &w->carried, .i = k, .P = P};
    b.front = b.v->front + k;
    open_front(&b);
    if (b.size == 0) {
        b.front->done = 0;
        return MBSR_OK;
    }
    add_pool(&b, k, 0);
    const mbsri_pool *pool = mbsri_carried_at(w, k);
    const double *store = b.v->store;
    const size_t rows = (size_t)(b.size + b.actions);
    const int d_up = pool->stride / 3;
    for (int l = 0; l < b.k; ++l) { /* names and rows stand as in the pool */
        mbsri_copy((size_t)b.k, b.T + l * b.k, b.M + (size_t)l * rows);
        mbsri_copy((size_t)b.actions, store + pool->Q + (size_t)(l * pool->stride),
                   b.M + (size_t)l * rows + b.size);
        if (b.actions > 0)
            mbsri_copy((size_t)d_up, store + mbsri_pool_kappa(pool) + (size_t)(l * d_up),
                       b.kappa_up + l * d_up);
    }
    for (int i = 0; i < b.k; ++i) {
        const double *R = store + mbsri_pool_R(pool) + (size_t)(i * pool->motions);
        for (int l = 0; l < b.motions; ++l) b.M[(size_t)(b.size + l) * rows + (size_t)i] = R[l];
    }
    return eliminate(&b);
}

int mbsri_front_close(mbsr_newton *w, mbsr_data *d, int body)
{
    int status = MBSR_OK;
    if (body > 0 && w->node[body].coupled) return status;
    for (int k = w->carried.first_closing[body]; k > 0 && !status; k = w->carried.front[k].next)
        status = mbsri_front_close_one(w, d, k, NULL);
    return status;
}
