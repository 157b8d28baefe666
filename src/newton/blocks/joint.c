/* One joint, or a group of joints, in the elimination of the Newton system: its force elements, its
 * equations, and the unknowns eliminated. Symbols as in factor.c.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "newton/blocks/joint.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "base/error.h"
#include "model/query.h"
#include "newton/blocks/block.h"
#include "newton/blocks/kept.h"
#include "newton/blocks/linked.h"
#include "newton/slopes/body_slopes.h"
#include "newton/slopes/force_slopes.h"
#include "newton/slopes/relation.h"
#include "recursion/group.h"
#include "recursion/modal.h"
#include "recursion/rank_pivots.h"

#include <math.h>

typedef mbsri_block_joint joint;

static size_t place_work(joint *j, double *memory)
{
    const size_t d = (size_t)j->b->d, dp = (size_t)j->b->d_pred, n = (size_t)j->b->n,
                 x = (size_t)j->node->e + 2 * d, x_pred = (size_t)j->above->e + 2 * dp,
                 columns = x_pred + (size_t)j->b->nq + 2 * n;
    double **const array[] = {&j->action,   &j->below,   &j->reaction, &j->torque,
                              &j->torque_x, &j->pull,    &j->pull_z,   &j->y,
                              &j->size,     &j->size_mu, &j->size_a};
    const size_t length[] = {3 * d * columns,
                             3 * dp * columns,
                             n * columns,
                             n * columns,
                             n * x,
                             dp * x,
                             dp * columns,
                             3 * d,
                             n,
                             n,
                             n};
    size_t used = 0;
    for (size_t l = 0; l < sizeof length / sizeof length[0]; ++l) {
        *array[l] = memory ? memory + used : NULL;
        used += length[l];
    }
    return used;
}

size_t mbsri_block_size(const mbsr_newton *w, int i)
{
    const mbsri_body *b = w->model->body + i;
    joint j = {.b = b, .node = w->node + i, .above = w->node + b->parent};
    return place_work(&j, NULL);
}

double *mbsri_tree_matrix(const mbsr_newton *w, int i)
{
    return w->slot + (size_t)w->node[i].slot * w->slot_size;
}

static void open_joint(mbsr_newton *w, mbsr_data *d, int i, double *memory, joint *j)
{
    const mbsri_body *b = w->model->body + i;
    *j = (joint){.w = w, .d = d, .b = b, .node = w->node + i, .above = w->node + b->parent, .i = i};
    mbsri_keep(w, i, w->store + j->node->store, &j->kept);
    place_work(j, memory);
    j->motions = mbsri_motions(j->node, b);
    j->actions = mbsri_actions(j->node, b);
    const mbsri_body *pred = w->model->body + b->parent;
    j->motions_pred = mbsri_motions(j->above, pred);
    j->actions_pred = mbsri_actions(j->above, pred);
    j->q = j->motions_pred;
    j->u = j->q + b->nq;
    j->a = j->u + b->n;
    j->columns = j->node->deep ? j->a + b->n : j->a;
    j->n = b->n;
    j->nq = b->nq;
    j->P = mbsri_tree_matrix(w, i);
    const size_t d_pred = (size_t)b->d_pred, n = (size_t)b->n, columns = (size_t)j->columns;
    mbsri_zero((size_t)j->actions * columns, j->action);
    mbsri_zero(n * columns, j->torque);
    mbsri_zero(n * (size_t)j->motions, j->torque_x);
    mbsri_zero(d_pred * (size_t)j->motions, j->pull);
    mbsri_zero(d_pred * columns, j->pull_z);
}

/* s and X where D is regular, whose eigenvectors the bound of rounding errors does not need: any
 * basis will do. */
static void whole_range(joint *j)
{
    const mbsri_body *b = j->b;
    const size_t n = (size_t)b->n;
    mbsri_zero(n * n, j->kept.X);
    for (size_t k = 0; k < n; ++k) {
        const double D = j->d->D[b->nn + k * (n + 1)];
        j->kept.s[k] = D > 0.0 ? 1.0 / sqrt(D) : 1.0;
        j->kept.X[k * (n + 1)] = 1.0;
    }
}

/* What of the data solving needs. */
static void keep_data(joint *j)
{
    const mbsri_body *b = j->b;
    const mbsr_data *d = j->d;
    const size_t dp = (size_t)b->d * (size_t)b->d_pred, dn = (size_t)b->d * (size_t)b->n;
    mbsri_copy(dp, d->H + b->dp, j->kept.H);
    mbsri_copy(dp, d->Hdot + b->dp, j->kept.Hdot);
    mbsri_copy(dn, d->J + b->dn, j->kept.J);
    mbsri_copy(dn, d->Jdot + b->dn, j->kept.Jdot);
    if (j->node->coupled) {
        if (b->head != j->i) return;
        const size_t n = (size_t)b->group_n;
        mbsri_copy((size_t)b->d * n, d->G + b->dg, j->kept.G);
        mbsri_copy(n, d->s + b->ig, j->kept.s);
        mbsri_copy(n * n, d->X + b->nn, j->kept.X);
        return;
    }
    mbsri_copy(dn, d->G + b->dg, j->kept.G);
    if (j->w->mixed && j->node->rank == b->n) {
        whole_range(j);
        return;
    }
    mbsri_copy((size_t)b->n, d->s + b->ig, j->kept.s);
    mbsri_copy((size_t)b->n * (size_t)b->n, d->X + b->nn, j->kept.X);
    if (j->w->mixed && b->modal) mbsri_complete_basis(b->n, j->node->rank, j->kept.X, d->scratch);
}

/* ---- force elements on a body ---- */

/* dest (rows of `stride`, from `row` on) += factor times a block of the element's derivatives. */
static void add_block(const mbsr_force_derivatives *from, int row, int rows, int column,
                      int columns, double factor, double *dest, int stride)
{
    for (int k = 0; k < columns; ++k) {
        const double *x = from->matrix + (size_t)(column + k) * (size_t)from->rows + row;
        double *y = dest + (size_t)k * (size_t)stride;
        for (int l = 0; l < rows; ++l) y[l] += factor * x[l];
    }
}

/* f of the body enters sigma with -1 and mu with 1. */
static void add_force(const joint *j, const mbsr_force_derivatives *from, int row, int column,
                      int columns, double *dest)
{
    const int d = j->b->d;
    add_block(from, row, d, column, columns, -1.0, dest + d, j->actions);
    if (j->node->deep) add_block(from, row, d, column, columns, 1.0, dest + 2 * d, j->actions);
}

/* What the element's body number `row` feels by its body number `column`, of which one is body i
 * and the other that or its predecessor. */
static void place_pair(joint *j, const mbsr_force_derivatives *s, int row, int column,
                       mbsri_relation relation)
{
    const mbsri_body *b = j->b;
    const int n = b->n, dp = b->d_pred, x = j->node->e + b->d, x_pred = j->above->e + dp,
              columns = b->nq + n, f = s->row[row], at = s->column[column];
    const size_t q = (size_t)j->q;
    switch (relation) {
    case MBSRI_SAME:
        add_force(j, s, f, at, x, j->P);
        add_force(j, s, f, at + x, columns, j->action + q * (size_t)j->actions);
        add_block(s, f + b->d, n, at, x, 1.0, j->torque_x, n);
        add_block(s, f + b->d, n, at + x, columns, 1.0, j->torque + q * (size_t)n, n);
        break;
    case MBSRI_BELOW:
        add_force(j, s, f, at, x_pred, j->action);
        add_block(s, f + b->d, n, at, x_pred, 1.0, j->torque, n);
        break;
    case MBSRI_ABOVE:
        add_block(s, f, dp, at, x, 1.0, j->pull, dp);
        add_block(s, f, dp, at + x, columns, 1.0, j->pull_z + q * (size_t)dp, dp);
        break;
    case MBSRI_APART: break;
    }
}

/* All that an element has to do with body i and its predecessor. */
static void place_element(joint *j, const mbsri_force *force)
{
    const mbsr_model *m = j->w->model;
    const int *bodies = m->list_index + force->list;
    if (force->def.table->flags & MBSR_FORCE_EVERY_BODY) {
        place_pair(j, &j->w->slopes.out, 0, 0, MBSRI_SAME);
        return;
    }
    for (int k = 0; k < force->def.bodies; ++k) {
        for (int l = 0; l < force->def.bodies; ++l) {
            const mbsri_relation relation = mbsri_relate(m, bodies[k], bodies[l]);
            const int lower = relation == MBSRI_ABOVE ? bodies[l] : bodies[k];
            if (lower == j->i) place_pair(j, &j->w->slopes.out, k, l, relation);
        }
    }
}

static int add_elements(joint *j)
{
    mbsr_newton *w = j->w;
    const mbsri_force *forces = w->model->forces.data;
    for (int k = 0; k < w->every + j->node->count; ++k) {
        const int number =
            k < w->every ? w->listed[w->first_every + k] : w->listed[j->node->first + k - w->every];
        const int status = mbsri_force_slopes(w->model, j->d, forces + number, j->i, &w->slopes);
        if (status) return status;
        place_element(j, forces + number);
        j->elements = true;
    }
    return MBSR_OK;
}

/* What loop forces that act on body i change with its place. */
static void add_closures(joint *j)
{
    const mbsri_carried *v = &j->w->carried;
    if (!v->memory) return;
    for (int k = v->first_end[j->i]; k >= 0; k = v->end[k].next) {
        const int number = v->end[k].closure, d = j->b->d, n = j->n;
        const mbsri_closure *c = (const mbsri_closure *)j->w->model->closures.data + number;
        const mbsr_force_derivatives S = {
            .matrix = v->store + v->loop[number].S, .rows = c->columns, .columns = c->columns};
        const int f = c->column[v->end[k].slot], tau = f + d;
        add_force(j, &S, f, f, d, j->P);
        if (!(c->def.table->flags & MBSR_CLOSURE_JOINTS)) continue;
        add_force(j, &S, f, tau, n, j->action + (size_t)j->q * (size_t)j->actions);
        add_block(&S, tau, n, f, d, 1.0, j->torque_x, n);
        add_block(&S, tau, n, tau, n, 1.0, j->torque + (size_t)j->q * (size_t)n, n);
        j->elements = true;
    }
}

/* row (n) += sum of |A^T| |y|, A = J, or J' without the rows of -1 and 0 (recursion/modal.h) */
static void add_sizes(const mbsri_body *b, double factor, const double *A, const double *y,
                      double *row)
{
    const int rows = b->upright ? 0 : mbsri_upper_rows(b);
    for (int k = 0; k < b->n; ++k) {
        for (int l = 0; l < rows; ++l) row[k] += fabs(factor * A[k * b->d + l] * y[l]);
    }
}

static void add_sizes_of_J(const mbsri_body *b, double factor, const double *J, const double *y,
                           double *row)
{
    add_sizes(b, factor, J, y, row);
    for (int k = 0; k < b->n && b->modal; ++k) row[k] += fabs(factor * y[MBSRI_FRAME_ROWS + k]);
}

void mbsri_block_measure(joint *j, double c, mbsri_column_kind kind, const double *y,
                         const double *own, const double *torque)
{
    const mbsri_body *b = j->b;
    const mbsri_kept *kept = &j->kept;
    const int d = b->d, n = b->n;
    /* dq = Cq G du: of the order of du / c */
    const double share = kind == MBSRI_COLUMN_Q ? 1.0 / fabs(c) : 1.0;
    add_sizes_of_J(b, share * c, kept->J, y, j->size);
    add_sizes_of_J(b, share, kept->J, y + d, j->size);
    add_sizes(b, share, kept->Jdot, y, j->size);
    for (int l = 0; l < n; ++l)
        j->size[l] += share * (fabs(c * own[l]) + fabs(own[n + l]) + fabs(torque[l]));
    if (!j->node->deep) return;
    double *size = kind == MBSRI_COLUMN_A ? j->size_a : j->size_mu;
    for (int l = 0; l < n; ++l) size[l] += share * (fabs(own[2 * n + l]) + fabs(torque[l]));
    add_sizes_of_J(b, share, kept->J, y + 2 * d, size);
}

/* ---- the joint's block ---- */

bool mbsri_block_coordinates(const mbsri_body *b, double c, const mbsri_joint_slopes *s, double *Cq,
                             double *Q, double *A, double *rows, double *columns, int *pivots)
{
    const int nq = b->nq, n = b->n;
    const double *qdot_q = s->qdot + (size_t)s->q * (size_t)nq,
                 *qdot_u = s->qdot + (size_t)s->u * (size_t)nq;
    mbsri_zero((size_t)(nq * nq), Cq);
    if (!b->joint.table->coordinate_rates) {
        for (int k = 0; k < nq; ++k) Cq[k * (nq + 1)] = 1.0 / c;
    } else {
        for (int k = 0; k < nq; ++k) rows[k] = fabs(c);
        for (int k = 0; k < nq * nq; ++k) {
            A[k] = -qdot_q[k];
            rows[k % nq] += fabs(qdot_q[k]);
        }
        for (int k = 0; k < nq; ++k) A[k * (nq + 1)] += c;
        if (!mbsri_block_factor(nq, A, rows, columns, pivots)) return false;
        for (int k = 0; k < nq; ++k) {
            Cq[k * (nq + 1)] = 1.0;
            mbsri_block_solve(nq, A, rows, columns, pivots, Cq + k * nq);
        }
    }
    mbsri_zero((size_t)(nq * n), Q);
    if (b->joint.table->coordinate_rates)
        mbsri_ab(nq, nq, n, 1.0, Cq, qdot_u, Q);
    else
        mbsri_ax(nq * n, 1, 1.0 / c, qdot_u, &(double){1.0}, Q);
    return true;
}

/* Rows (a), in the range of D where deep, and (b) of one column (momentum, rate, reaction). */
static void rows_of(const joint *j, double c, const double *momentum, const double *rate,
                    const double *reaction, double *out)
{
    const int n = j->n, rank = j->node->rank;
    if (!j->node->deep) {
        for (int l = 0; l < n; ++l) out[l] = c * momentum[l] - rate[l];
        return;
    }
    for (int r = 0; r < rank; ++r) {
        const double *X = j->kept.X + r * n;
        out[r] = 0.0;
        for (int l = 0; l < n; ++l) out[r] += X[l] * j->kept.s[l] * (c * momentum[l] - rate[l]);
    }
    mbsri_copy((size_t)n, reaction, out + rank);
}

double mbsri_block_unit(const mbsri_block_joint *j)
{
    if (j->node->rank == 0) return 1.0; /* there is none, and size_a is zero up to rounding */
    const double unit = mbsri_largest(j->n, j->size_mu) / mbsri_largest(j->n, j->size_a);
    return unit > 0.0 && isfinite(unit) ? unit : 1.0;
}

/* The unknown directions: column l of du with what dq follows, or of u' in the range of D; of a
 * matrix over z with `rows` rows. */
static void along(const joint *j, int l, int rows, const double *matrix, double *out)
{
    const int n = j->n, nq = j->nq;
    mbsri_zero((size_t)rows, out);
    if (l < n) {
        mbsri_ax(rows, 1, 1.0, matrix + (size_t)(j->u + l) * (size_t)rows, &(double){1.0}, out);
        for (int k = 0; k < nq; ++k) { /* mostly Q is diagonal */
            const double rate = j->kept.Q[l * nq + k];
            if (rate == 0.0) continue;
            const double *column = matrix + (size_t)(j->q + k) * (size_t)rows;
            mbsri_ax(rows, 1, rate, column, &(double){1.0}, out);
        }
        return;
    }
    for (int k = 0; k < n; ++k) {
        const double weight = *j->kept.unit * j->kept.s[k] * j->kept.X[(l - n) * n + k];
        mbsri_ax(rows, 1, weight, matrix + (size_t)(j->a + k) * (size_t)rows, &(double){1.0}, out);
    }
}

/* What was added up in the rows of E. */
static void row_sizes(const joint *j, double *rows)
{
    const int n = j->n, rank = j->node->rank;
    if (!j->node->deep) {
        mbsri_copy((size_t)n, j->size, rows);
        return;
    }
    for (int r = 0; r < rank; ++r) {
        rows[r] = 0.0;
        for (int l = 0; l < n; ++l)
            rows[r] += fabs(j->kept.X[r * n + l] * j->kept.s[l]) * j->size[l];
    }
    for (int l = 0; l < n; ++l) rows[rank + l] = j->size_mu[l] + *j->kept.unit * j->size_a[l];
}

/* E, factored, Eq, K and U. */
static bool eliminate(joint *j, double c)
{
    const int n = j->n, nq = j->nq, unknowns = j->node->unknowns, pred = j->actions_pred;
    const mbsri_kept *kept = &j->kept;
    double *momentum = j->y, *rate = momentum + n, *reaction = rate + n; /* y is done with */
    *kept->unit = j->node->deep ? mbsri_block_unit(j) : 1.0;
    for (int l = 0; l < unknowns; ++l) {
        along(j, l, n, kept->momentum, momentum);
        along(j, l, n, kept->rate, rate);
        if (j->node->deep) along(j, l, n, j->reaction, reaction);
        rows_of(j, c, momentum, rate, reaction, kept->E + l * unknowns);
        along(j, l, pred, j->below, kept->U + l * pred);
    }
    for (int k = 0; k < j->u; ++k) {
        double *out = k < j->q ? kept->K + k * unknowns : kept->Eq + (k - j->q) * unknowns;
        rows_of(j, c, kept->momentum + k * n, kept->rate + k * n, j->reaction + k * n, out);
    }
    mbsri_copy((size_t)(pred * nq), j->below + (size_t)j->q * (size_t)pred, kept->Uq);
    row_sizes(j, kept->row_scale);
    int *pivots = j->w->pivots + j->node->v;
    if (!mbsri_block_factor(unknowns, kept->E, kept->row_scale, kept->column_scale, pivots))
        return false;
    for (int k = 0; k < j->q; ++k) {
        mbsri_block_solve(unknowns, kept->E, kept->row_scale, kept->column_scale, pivots,
                          kept->K + k * unknowns);
    }
    return true;
}

int mbsri_block_singular(joint *j, const char *what, const char *advice)
{
    char label[MBSRI_LABEL];
    const mbsri_body *b = j->b;
    return mbsri_fail(
        &j->d->error, MBSR_SINGULAR_BLOCK, b->id, MBSR_NONE, "%s: joint '%s': %s at t = %g; %s",
        mbsri_body_label(j->w->model, j->i, label), b->joint.table->name, what, j->d->t, advice);
}

int mbsri_block_not_finite(joint *j)
{
    char label[MBSRI_LABEL];
    const mbsri_body *b = j->b;
    return mbsri_fail(&j->d->error, MBSR_NOT_FINITE, b->id, MBSR_NONE,
                      "%s: joint '%s': its Newton equations are not finite at t = %g",
                      mbsri_body_label(j->w->model, j->i, label), b->joint.table->name, j->d->t);
}

/* P_pi += y_pi along x_pi, the unknowns eliminated. */
static void pass_on(joint *j)
{
    if (j->b->parent == 0) return;
    double *P = mbsri_tree_matrix(j->w, j->b->parent);
    for (int k = 0; k < j->motions_pred; ++k) {
        double *column = P + (size_t)k * (size_t)j->actions_pred;
        mbsri_ax(j->actions_pred, 1, 1.0, j->below + (size_t)k * (size_t)j->actions_pred,
                 &(double){1.0}, column);
        mbsri_ax_long(j->actions_pred, j->node->unknowns, -1.0, j->kept.U,
                      j->kept.K + (size_t)k * (size_t)j->node->unknowns, column);
    }
}

/* mu over A is -Mbar, of which successors among the sweeps have not handed on their part; those of
 * the same group will. */
static void place_masses(const joint *j)
{
    const mbsr_model *m = j->w->model;
    const int d = j->b->d, first = j->node->e + d;
    const size_t dd = (size_t)d * (size_t)d;
    double *own = j->d->scratch, *of_group = own + dd, *work = of_group + dd;
    mbsri_copy(dd, j->d->Mbar + j->b->dd, own);
    mbsri_zero(dd, of_group);
    const mbsri_group g = mbsri_group_in_model(m, j->b->head);
    for (int k = 0; k < g.members && j->node->coupled; ++k) {
        const mbsri_body *member = m->body + g.member[k];
        if (member->parent != j->i) continue;
        mbsri_congruence(member->d, d, j->d->H + member->dp, j->d->Mbar + member->dd, of_group,
                         work);
    }
    for (int k = 0; k < d; ++k) {
        double *column = j->P + (size_t)(first + k) * (size_t)j->actions + 2 * d;
        for (int l = 0; l < d; ++l) column[l] = of_group[k * d + l] - own[k * d + l];
    }
}

int mbsri_block_finish(joint *j, double c)
{
    const size_t n = (size_t)j->n;
    if (!mbsri_finite(n, j->size) || !mbsri_finite(n, j->size_mu) || !mbsri_finite(n, j->size_a))
        return mbsri_block_not_finite(j);
    if (!eliminate(j, c))
        return mbsri_block_singular(j, "its equations are singular", MBSRI_SINGULAR_ADVICE);
    if (!mbsri_finite((size_t)(j->node->unknowns * j->motions_pred), j->kept.K))
        return mbsri_block_not_finite(j);
    pass_on(j);
    return MBSR_OK;
}

/* What bodies do that are tied to body i and were eliminated before. */
static void add_links(joint *j)
{
    const double *own = mbsri_links_own(j->w, j->i);
    const int stride = mbsri_links_stride(j->w, j->i), count = j->node->e + j->b->d;
    for (int k = 0; k < count; ++k) {
        double *column = j->P + (size_t)k * (size_t)j->actions;
        for (int l = 0; l < j->actions; ++l) column[l] += own[k * stride + l];
    }
}

int mbsri_block_begin(mbsr_newton *w, mbsr_data *d, int i, double *memory, joint *j)
{
    open_joint(w, d, i, memory, j);
    keep_data(j);
    const int status = mbsri_body_slopes_add(w->model, d, i, j->node->deep, j->P, w->body);
    if (w->mixed && j->node->deep) place_masses(j);
    add_closures(j);
    if (j->w->linked) add_links(j);
    return status ? status : add_elements(j);
}
