/* The front of one step: see assemble.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * First everything stands over x of the body: fronts of earlier steps, elements, closures, its own
 * momentum. Then x = X z takes the columns of x to those of z, and what the joint makes of y,
 *
 *   q'   c dq - d(G u) - G w (push - J^T kappa)
 *   (a)  c d(J^T m) - d(J'^T m + J^T sigma + tau)
 *   (b)  d(J^T mu - tau)                                                  u' free in the range of D
 *   y_pi += B y + (slopes of B) z,   kappa_pi -= H^T kappa
 *
 * takes its rows to equations of the joint and to y of the predecessor (docs/newton.md). N gets the sizes
 * of what is added up, along the unknowns. */
#include "newton/front/assemble.h"

#include "algebra/dense.h"
#include "model/query.h"
#include "recursion/closures.h"
#include "recursion/group.h"

#include <math.h>

typedef mbsri_front_build build;

static double *M_at(const build *b, int row, int column)
{
    return b->M + (size_t)column * (size_t)b->all_rows + row;
}

static double *N_at(const build *b, int row, int column)
{
    return b->N + (size_t)column * (size_t)b->all_rows + row;
}

int mbsri_front_members(const mbsri_front *f, int i, const int **member)
{
    const mbsri_body *b = f->model->body + i;
    *member = f->model->member + b->at;
    return f->linear->coupled[i] ? b->members : 1;
}

/* Whether the member's rows and columns are pending: its group is complete further up. */
static bool waits(const mbsri_front *f, int i)
{
    return f->linear->coupled[i] && f->model->body[i].head != i;
}

/* Whether the sizes of what is added up in a column are wanted. */
static bool is_measured(const build *b, int column)
{
    return b->watched || column < b->size || column >= b->columns;
}

/* ---- numbers ---- */

static void add_rows(build *b, int first, int count)
{
    for (int l = 0; l < count; ++l) {
        b->f->row_at[first + l] = b->all_rows;
        b->row[b->all_rows++] = first + l;
    }
}

static void add_columns(build *b, int first, int count)
{
    for (int l = 0; l < count; ++l) {
        b->f->column_at[first + l] = b->all_columns;
        b->column[b->all_columns++] = first + l;
    }
}

/* What the rows and columns of a body are: pending until its group is complete. */
static void sort_body(mbsri_front *f, int i, bool pending)
{
    const mbsri_front_names *at = f->names + i;
    const unsigned char own = pending ? MBSRI_FRONT_PENDING : MBSRI_FRONT_OWN;
    for (int l = 0; l < f->model->body[i].n; ++l) {
        f->row_kind[at->a + l] = f->row_kind[at->b + l] = f->column_kind[at->u + l] = own;
        f->column_kind[at->rates + l] = MBSRI_FRONT_PENDING;
    }
}

static void sort_own(build *b)
{
    const int *member, members = mbsri_front_members(b->f, b->i, &member);
    const bool pending = waits(b->f, b->i);
    sort_body(b->f, b->i, pending);
    for (int l = 1; l < members && !pending; ++l) sort_body(b->f, member[l], false);
}

/* Own rows and columns. */
static void list_own(build *b)
{
    const int n = b->b->n, nq = b->b->nq, rank = b->f->linear->rank[b->i];
    add_rows(b, b->at.place, nq);
    add_columns(b, b->at.q, nq);
    add_columns(b, b->at.u, n);
    if (!b->deep) {
        add_rows(b, b->at.a, n);
        return;
    }
    add_rows(b, b->at.b, n);
    if (b->closes) {
        add_rows(b, b->at.range_of_a, rank);
        add_columns(b, b->at.range, rank);
    } else {
        add_rows(b, b->at.a, n);
        add_columns(b, b->at.rates, n);
    }
}

/* Whether a number is among those of a body, from `first` on, whose group the step closes: its (a) and u'
 * give way to those in the range of D. */
static bool gives_way(const build *b, int owner, int first, int number)
{
    const mbsri_body *body = b->f->model->body + (owner > 0 ? owner : 0);
    return owner > 0 && b->closes && body->head == b->i && number >= first &&
           number < first + body->n;
}

static bool row_gives_way(const build *b, int row)
{
    const int owner = b->f->owner_row[row];
    return gives_way(b, owner, b->f->names[owner > 0 ? owner : 0].a, row);
}

static bool column_gives_way(const build *b, int column)
{
    const int owner = b->f->owner_column[column];
    return gives_way(b, owner, b->f->names[owner > 0 ? owner : 0].rates, column);
}

/* What earlier steps hand on. */
static void list_carried(build *b)
{
    const mbsri_front *f = b->f;
    for (int l = 0; l < b->step->children; ++l) {
        const int child = f->plan.child[b->step->first_child + l];
        const mbsri_front_left *left = f->left + child;
        const int *row = f->numbers + f->plan.step[child].numbers, *column = row + left->rows;
        for (int j = left->done; j < left->done + left->carried; ++j) {
            if (!row_gives_way(b, row[j])) add_rows(b, row[j], 1);
            if (!column_gives_way(b, column[j])) add_columns(b, column[j], 1);
        }
    }
}

static bool counts(const mbsri_front *f, const mbsri_closure *c, int k)
{
    return !f->linear->dropped[c->row + k] || mbsri_is_stiff(c, k);
}

static bool holds(const mbsri_front *f, const mbsri_closure *c, int k)
{
    return k < c->held && !f->linear->dropped[c->row + k];
}

static const mbsri_closure *closure_of(const mbsri_front *f, int element)
{
    return (const mbsri_closure *)f->model->closures.data + element - (int)f->model->forces.count;
}

static void list_multipliers(build *b)
{
    const mbsri_front *f = b->f;
    for (int l = 0; l < b->step->elements; ++l) {
        const int element = f->plan.element[b->step->first_element + l];
        if (element < (int)f->model->forces.count) continue;
        const mbsri_closure *c = closure_of(f, element);
        for (int r = 0; r < c->rows; ++r) {
            if (!counts(f, c, r)) continue;
            add_rows(b, f->row_count + c->row + r, 1);
            add_columns(b, f->column_count + c->row + r, 1);
            if (!holds(f, c, r)) continue;
            add_rows(b, f->row_count + f->model->rows + c->held_row + r, 1);
            add_columns(b, f->column_count + f->model->rows + c->held_row + r, 1);
        }
    }
}

static void list_body(build *b, int i)
{
    const mbsri_front *f = b->f;
    const mbsri_body *body = f->model->body + i;
    const mbsri_front_names *at = f->names + i;
    add_rows(b, at->y, mbsri_linear_actions(f->linear, i));
    if (f->model->held > 0) add_rows(b, at->kappa, body->d);
    add_columns(b, at->x, mbsri_linear_motions(f->linear, i));
    if (!f->plan.coordinates[i]) return;
    add_rows(b, at->tau, body->n);
    add_rows(b, at->push, body->n);
    add_columns(b, at->q, body->nq);
    add_columns(b, at->u, body->n);
}

/* What the step takes away. */
static void list_rest(build *b)
{
    const mbsri_front *f = b->f;
    const int *member, members = mbsri_front_members(f, b->i, &member);
    add_rows(b, b->at.y, mbsri_linear_actions(f->linear, b->i));
    if (f->model->held > 0) add_rows(b, b->at.kappa, b->b->d);
    add_rows(b, b->at.tau, b->b->n);
    add_rows(b, b->at.push, b->b->n);
    add_columns(b, b->at.x, mbsri_linear_motions(f->linear, b->i));
    for (int l = 0; l < members && b->closes; ++l) {
        add_rows(b, f->names[member[l]].a, f->model->body[member[l]].n);
        add_columns(b, f->names[member[l]].rates, f->model->body[member[l]].n);
    }
}

static void list_all(build *b)
{
    const mbsri_front *f = b->f;
    b->all_rows = b->all_columns = 0;
    sort_own(b);
    list_own(b);
    const int own = b->all_columns;
    list_carried(b);
    list_multipliers(b);
    b->watched = b->watched || b->all_columns > own || waits(f, b->i);
    b->size = b->all_columns;
    for (int l = 0; l < b->step->borders; ++l)
        list_body(b, f->plan.border[b->step->first_border + l]);
    b->rows = b->all_rows;
    b->columns = b->all_columns;
    list_rest(b);
}

/* ---- what is known over x ---- */

static void add_children(build *b)
{
    const mbsri_front *f = b->f;
    for (int l = 0; l < b->step->children; ++l) {
        const int child = f->plan.child[b->step->first_child + l];
        const mbsri_front_left *left = f->left + child;
        const int *row = f->numbers + f->plan.step[child].numbers, *column = row + left->rows;
        const double *from = f->matrices + f->plan.step[child].matrix;
        for (int j = left->done; j < left->columns; ++j) {
            double *to = M_at(b, 0, f->column_at[column[j]]);
            for (int r = left->done; r < left->rows; ++r) to[f->row_at[row[r]]] += *from++;
        }
    }
}

/* Numbers of an element's columns at one of its bodies: `count` from `first` on. */
typedef struct span {
    int first, count;
} span;

/* Adds a block of an element's derivatives, rows x columns of `from` (stride): forces f on body `on`, and
 * loads on its joint from row d on, if it has any, along the columns. */
static void add_forces(build *b, int on, bool joint, const double *from, int stride, span column)
{
    const mbsri_front *f = b->f;
    const mbsri_body *body = f->model->body + on;
    const mbsri_front_names *at = f->names + on;
    const int d = body->d, sigma = f->row_at[at->y] + d;
    for (int l = 0; l < column.count; ++l) {
        double *to = M_at(b, 0, f->column_at[column.first + l]);
        const double *force = from + (size_t)l * (size_t)stride;
        for (int r = 0; r < d; ++r) to[sigma + r] -= force[r];
        for (int r = 0; r < d && f->linear->deep[on]; ++r) to[sigma + d + r] += force[r];
        for (int r = 0; r < body->n && joint; ++r) to[f->row_at[at->tau] + r] += force[d + r];
    }
}

static void add_element(build *b, int element)
{
    const mbsri_front *f = b->f;
    const mbsri_linear *w = f->linear;
    const mbsri_force *force = (const mbsri_force *)f->model->forces.data + element;
    const bool joint = !(force->def.table->flags & MBSR_FORCE_NO_JOINT);
    const int *list, count = mbsri_linear_bodies(w, force, b->i, &list);
    int rows, columns, column = 0;
    const double *matrix = mbsri_linear_element(w, (size_t)element, b->i, &rows, &columns);
    for (int l = 0; l < count; ++l) {
        if (list[l] == 0) continue;
        const mbsri_body *by = f->model->body + list[l];
        const mbsri_front_names *at = f->names + list[l];
        const int x = w->e[list[l]] + by->d;
        int row = 0;
        for (int j = 0; j < count; ++j) {
            if (list[j] == 0) continue;
            const double *from = matrix + (size_t)column * (size_t)rows + row;
            add_forces(b, list[j], joint, from, rows, (span){at->x, x});
            from += (size_t)x * (size_t)rows;
            if (joint) add_forces(b, list[j], joint, from, rows, (span){at->q, by->nq});
            from += (size_t)by->nq * (size_t)rows;
            if (joint) add_forces(b, list[j], joint, from, rows, (span){at->u, by->n});
            row += f->model->body[list[j]].d + f->model->body[list[j]].n;
        }
        column += x + by->nq + by->n;
    }
}

/* Row r of a closure: at its bodies, and what its multipliers exert there. */
static void add_row(build *b, const mbsri_closure *c, int r, int l, const double *slope,
                    const double *C)
{
    mbsri_front *f = b->f;
    const int i = c->body[l], first = c->column[l], rows = c->rows;
    const mbsri_body *body = f->model->body + i;
    const mbsri_front_names *at = f->names + i;
    const bool joint = mbsri_reads_joints(c), held = holds(f, c, r);
    const int velocity = f->row_at[f->row_count + c->row + r],
              lambda = f->column_count + c->row + r,
              position = held ? f->row_at[f->row_count + f->model->rows + c->held_row + r] : 0,
              eta = held ? f->column_at[f->column_count + f->model->rows + c->held_row + r] : 0;
    double *to = M_at(b, 0, f->column_at[lambda]);
    const int count = body->d + (joint ? body->n : 0);
    for (int j = 0; j < count; ++j) {
        const double read = C[(size_t)(first + j) * (size_t)rows + (size_t)r],
                     turn = slope[(size_t)(first + j) * (size_t)rows + (size_t)r];
        const bool own = j >= body->d;
        const int place = f->column_at[own ? at->q + j - body->d : at->x + j],
                  rate = f->column_at[own ? at->u + j - body->d : at->x + f->linear->e[i] + j];
        *M_at(b, velocity, rate) += read;
        *M_at(b, velocity, place) += turn;
        if (held) *M_at(b, position, place) += read;
        if (held) *M_at(b, f->row_at[own ? at->push + j - body->d : at->kappa + j], eta) += read;
        if (own) {
            to[f->row_at[at->tau] + j - body->d] += read;
            continue;
        }
        to[f->row_at[at->y] + body->d + j] -= read;
        if (f->linear->deep[i]) to[f->row_at[at->y] + 2 * body->d + j] += read;
    }
}

static bool at_body(const mbsri_closure *c, int l)
{
    return c->body[l] > 0 && c->column[l] >= 0;
}

static void add_closure(build *b, int element)
{
    mbsri_front *f = b->f;
    const mbsri_closure *c = closure_of(f, element);
    const size_t columns = (size_t)c->columns, rows = (size_t)c->rows;
    const double *S = mbsri_linear_closure(f->linear,
                                           (size_t)(element - (int)f->model->forces.count)),
                 *slope = S + columns * columns, *C = slope + rows * columns;
    const bool joint = mbsri_reads_joints(c);
    for (int l = 0; l < c->bodies; ++l) {
        if (!at_body(c, l)) continue;
        const mbsri_front_names *at = f->names + c->body[l];
        const mbsri_body *by = f->model->body + c->body[l];
        for (int j = 0; j < c->bodies; ++j) {
            if (!at_body(c, j)) continue;
            const double *from = S + (size_t)c->column[l] * columns + c->column[j];
            add_forces(b, c->body[j], joint, from, c->columns, (span){at->x, by->d});
            from += (size_t)by->d * columns;
            if (joint) add_forces(b, c->body[j], joint, from, c->columns, (span){at->q, by->n});
        }
        for (int r = 0; r < c->rows; ++r) {
            if (counts(f, c, r)) add_row(b, c, r, l, slope, C);
        }
    }
    for (int r = 0; r < c->held; ++r) {
        if (!mbsri_is_stiff(c, r)) continue;
        const double compliance = 1.0 / (c->def.stiffness[r] + f->c * c->def.damping[r]);
        const int lambda = f->column_at[f->column_count + c->row + r];
        *M_at(b, f->row_at[f->row_count + c->row + r], lambda) += f->c * compliance;
        if (holds(f, c, r))
            *M_at(b, f->row_at[f->row_count + f->model->rows + c->held_row + r], lambda) +=
                compliance;
    }
}

/* The body's own momentum, and all elements and closures that come with it. */
static void add_own(build *b)
{
    mbsri_front *f = b->f;
    const int x = mbsri_linear_motions(f->linear, b->i), y = mbsri_linear_actions(f->linear, b->i);
    for (int l = 0; l < x; ++l) {
        double *to = M_at(b, f->row_at[b->at.y], f->column_at[b->at.x + l]);
        for (int r = 0; r < y; ++r) to[r] += b->terms.P[l * y + r];
    }
    for (int k = 0; k < f->model->anywhere; ++k) {
        const mbsri_force *force = (const mbsri_force *)f->model->forces.data + k;
        if (force->def.table->flags & MBSR_FORCE_EVERY_BODY) add_element(b, k);
    }
    for (int l = 0; l < b->step->elements; ++l) {
        const int element = f->plan.element[b->step->first_element + l];
        if (element < (int)f->model->forces.count)
            add_element(b, element);
        else
            add_closure(b, element);
    }
}

/* ---- x = X z ---- */

/* Adds a column of X, or of what is like it, to a column; `from`: the first row that has anything. */
static void add_motion(build *b, double factor, const double *X, int count, int first, int column)
{
    const mbsri_front *f = b->f;
    const bool measured = is_measured(b, column);
    double *to = M_at(b, 0, column), *sum = N_at(b, 0, column);
    for (int l = 0; l < count; ++l) {
        const double x = factor * X[l], size = fabs(x);
        if (x == 0.0) continue;
        const double *from = M_at(b, 0, f->column_at[b->at.x + first + l]);
        for (int r = 0; r < b->all_rows; ++r) to[r] += x * from[r];
        for (int r = 0; r < b->all_rows && measured; ++r) sum[r] += size * fabs(from[r]);
    }
}

/* The column of a number of z. */
static int column_of_z(const build *b, int k)
{
    const mbsri_front *f = b->f;
    const int parent = b->b->parent, x = mbsri_linear_motions(f->linear, parent), nq = b->b->nq;
    if (k >= x + nq) return f->column_at[b->at.u + k - x - nq];
    if (k >= x) return f->column_at[b->at.q + k - x];
    return parent > 0 ? f->column_at[f->names[parent].x + k] : -1;
}

static int variables(const build *b)
{
    return mbsri_linear_motions(b->f->linear, b->b->parent) + b->b->nq + b->b->n;
}

static void replace_x(build *b)
{
    const mbsri_linear *w = b->f->linear;
    const int x = mbsri_linear_motions(w, b->i), d = b->b->d;
    for (int j = 0; j < b->all_columns; ++j) {
        const bool measured = is_measured(b, j);
        for (int r = 0; r < b->all_rows && measured; ++r) *N_at(b, r, j) = fabs(*M_at(b, r, j));
    }
    for (int k = 0; k < variables(b); ++k) {
        const int column = column_of_z(b, k);
        if (column >= 0) add_motion(b, 1.0, b->terms.x + k * x, x, 0, column);
    }
    for (int l = 0; l < b->b->n && b->deep; ++l)
        add_motion(b, -1.0, b->terms.J + l * d, d, w->e[b->i] + d,
                   b->f->column_at[b->at.rates + l]);
}

/* ---- rows of the joint ---- */

/* out (n) += factor A^T y; with sizes. */
static void add_products(int d, int n, double factor, const double *A, const double *y, double *out,
                         const double *sizes, double *sum)
{
    for (int k = 0; k < n; ++k) {
        double value = 0.0, size = 0.0;
        for (int l = 0; l < d; ++l) value += A[k * d + l] * y[l];
        for (int l = 0; l < d && sum; ++l) size += fabs(A[k * d + l]) * sizes[l];
        out[k] += factor * value;
        if (sum) sum[k] += fabs(factor) * size;
    }
}

/* Rows of one column, from those of y, tau, push. */
static void make_rows(build *b, int j)
{
    mbsri_front *f = b->f;
    const mbsri_terms *k = &b->terms;
    const int d = b->b->d, dp = b->b->d_pred, n = b->b->n, nq = b->b->nq, parent = b->b->parent;
    const bool measured = is_measured(b, j);
    double *M = M_at(b, 0, j), *N = N_at(b, 0, j);
    const double *y = M + f->row_at[b->at.y], *tau = M + f->row_at[b->at.tau],
                 *size = N + f->row_at[b->at.y], *size_tau = N + f->row_at[b->at.tau];
    double *a = M + f->row_at[b->at.a], *sum_a = measured ? N + f->row_at[b->at.a] : NULL;
    add_products(d, n, f->c, k->J, y, a, size, sum_a);
    add_products(d, n, -1.0, k->J, y + d, a, size + d, sum_a);
    add_products(d, n, -1.0, k->Jdot, y, a, size, sum_a);
    for (int l = 0; l < n; ++l) a[l] -= tau[l];
    for (int l = 0; l < n && measured; ++l) sum_a[l] += size_tau[l];
    if (b->deep) {
        double *react = M + f->row_at[b->at.b], *sum = measured ? N + f->row_at[b->at.b] : NULL;
        add_products(d, n, 1.0, k->J, y + 2 * d, react, size + 2 * d, sum);
        for (int l = 0; l < n; ++l) react[l] -= tau[l];
        for (int l = 0; l < n && measured; ++l) sum[l] += size_tau[l];
    }
    if (parent > 0)
        mbsri_linear_pass(b->b, k, f->linear->deep[parent], y, M + f->row_at[f->names[parent].y]);
    if (f->model->held == 0) return;
    const double *kappa = M + f->row_at[b->at.kappa], *push = M + f->row_at[b->at.push],
                 *qdot = k->qdot + (size_t)((variables(b) - n) * nq);
    for (int l = 0; l < n; ++l) {
        const double moved =
            f->model->weight[b->b->iu + l] * (push[l] - mbsri_dot(d, k->J + l * d, kappa));
        for (int r = 0; r < nq && moved != 0.0; ++r)
            M[f->row_at[b->at.place] + r] -= qdot[l * nq + r] * moved;
    }
    if (parent > 0) mbsri_atx(d, dp, -1.0, k->H, kappa, M + f->row_at[f->names[parent].kappa]);
}

/* What the joint's equations have of z with y held. */
static void add_slopes(build *b)
{
    mbsri_front *f = b->f;
    const mbsri_terms *k = &b->terms;
    const int n = b->b->n, nq = b->b->nq, parent = b->b->parent, rows = (b->deep ? 3 : 2) * n,
              pred = mbsri_linear_actions(f->linear, parent),
              q = mbsri_linear_motions(f->linear, parent);
    for (int l = 0; l < variables(b); ++l) {
        const int j = column_of_z(b, l);
        const double *own = k->own + l * rows, *below = k->below + l * pred,
                     *qdot = k->qdot + l * nq;
        if (j < 0) continue;
        double *M = M_at(b, 0, j), *N = N_at(b, 0, j);
        for (int r = 0; r < n; ++r) {
            const int a = f->row_at[b->at.a] + r;
            M[a] += f->c * own[r] - own[n + r];
            N[a] += fabs(f->c * own[r]) + fabs(own[n + r]);
            if (!b->deep) continue;
            M[f->row_at[b->at.b] + r] += own[2 * n + r];
            N[f->row_at[b->at.b] + r] += fabs(own[2 * n + r]);
        }
        for (int r = 0; r < nq; ++r) {
            M[f->row_at[b->at.place] + r] -= qdot[r];
            N[f->row_at[b->at.place] + r] += fabs(qdot[r]);
        }
        if (l >= q && l < q + nq) M[f->row_at[b->at.place] + l - q] += f->c;
        if (l >= q && l < q + nq) N[f->row_at[b->at.place] + l - q] += fabs(f->c);
        for (int r = 0; r < pred && parent > 0; ++r)
            M[f->row_at[f->names[parent].y] + r] += below[r];
    }
    for (int l = 0; l < n && b->deep; ++l) {
        const int row = f->row_at[b->at.b] + l, column = f->column_at[b->at.rates] + l;
        *M_at(b, row, column) += b->b->armature[l];
        *N_at(b, row, column) += b->b->armature[l];
    }
}

/* ---- the range of D ---- */

/* u' = S X a, and the rows X^T S (a), of the joint or group that is complete. */
static void take_range(build *b)
{
    mbsri_front *f = b->f;
    const mbsri_terms *k = &b->terms;
    const int *member, members = mbsri_front_members(f, b->i, &member),
                       rank = f->linear->rank[b->i],
                       n = f->linear->coupled[b->i] ? b->b->group_n : b->b->n;
    for (int r = 0; r < rank; ++r) {
        double *M = M_at(b, 0, f->column_at[b->at.range + r]),
               *N = N_at(b, 0, f->column_at[b->at.range + r]);
        for (int l = 0; l < members; ++l) {
            const mbsri_body *of = f->model->body + member[l];
            for (int j = 0; j < of->n; ++j) {
                const int at = of->ig - b->b->ig + j,
                          column = f->column_at[f->names[member[l]].rates + j];
                const double weight = k->X[r * n + at] * k->s[at];
                for (int row = 0; row < b->all_rows; ++row) {
                    M[row] += weight * *M_at(b, row, column);
                    N[row] += fabs(weight) * *N_at(b, row, column);
                }
            }
        }
    }
    for (int column = 0; column < b->columns; ++column) {
        double *M = M_at(b, 0, column), *N = N_at(b, 0, column);
        for (int r = 0; r < rank; ++r) {
            double value = 0.0, size = 0.0;
            for (int l = 0; l < members; ++l) {
                const mbsri_body *of = f->model->body + member[l];
                for (int j = 0; j < of->n; ++j) {
                    const int at = of->ig - b->b->ig + j,
                              row = f->row_at[f->names[member[l]].a] + j;
                    const double weight = k->X[r * n + at] * k->s[at];
                    value += weight * M[row];
                    size += fabs(weight) * N[row];
                }
            }
            M[f->row_at[b->at.range_of_a] + r] = value;
            N[f->row_at[b->at.range_of_a] + r] = size;
        }
    }
}

void mbsri_front_assemble(mbsri_front *f, int k, bool watched, mbsri_front_build *b)
{
    const mbsri_front_step *step = f->plan.step + k;
    const int i = step->body;
    *b = (mbsri_front_build){.f = f, .step = step, .k = k, .i = i, .b = f->model->body + i};
    b->watched = watched;
    b->at = f->names[i];
    b->terms = mbsri_linear_terms(f->linear, i);
    b->deep = f->linear->deep[i];
    b->closes = b->deep && !waits(f, i);
    b->row = f->row;
    b->column = f->column;
    b->M = f->M;
    b->N = f->N;
    list_all(b);
    mbsri_zero((size_t)b->all_rows * (size_t)b->all_columns, b->M);
    add_children(b);
    add_own(b);
    replace_x(b);
    for (int j = 0; j < b->all_columns; ++j) {
        if (f->owner_column[b->column[j]] != i || b->column[j] < b->at.x || b->column[j] >= b->at.q)
            make_rows(b, j);
    }
    add_slopes(b);
    if (b->closes) take_range(b);
}
