/* The Newton system of the momentum form by elimination on the tree, for joints and bodies of any
 * kind.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * d stands for a derivative along (dq, du). With the impulses m, their rates sigma and the
 * reactions mu of forms/momentum.c and recursion/inverse.c,
 *
 *   F_q:  c dq - d(G u) = r_q
 *   F_p:  c dp - dP = r_p,     P = J'^T m + J^T sigma + tau
 *   F_u:  L^-1 (d(M u) - dp) = r_u           in the range of each D
 *         L^-1 d(J^T mu - tau) = r_u         in its null space, u' held
 *
 * where M u = J^T m and L^-1 is the backward recursion. The first half of F_u leaves, up to a null
 * part that F_p gives, and F_p becomes with it, in the range of D,
 *
 *   dp = d(M u) - L (1 - P) r_u
 *   c d(M u) - dP = r_p + c L (1 - P) r_u                                                 (a)
 *
 * In the second half L^-1 is got rid of by an unknown du' in the range of D, which moves what the
 * range takes up:
 *
 *   d(J^T mu - tau) + M du' = P r_u                                                       (b)
 *
 * Why the derivative of L^-1 does not show in either: docs/newton.md. (b) is written only where a
 * deficient joint is at or above the body ("deep"), as only there its null space reaches.
 *
 * Of body i, x is the perturbation of pose, V and, where deep, A; y that of (m, sigma, mu). With
 * the joint's variables z = (x_pi, dq, du, du'), all derivatives are matrices:
 *
 *   x = X z,   y = P x + b,   y_pi += B y + C z,   (a) and (b): R y + W z = r
 *
 * Leaves to root: dq = Cq (G du + r_q) is put in, (a) and (b) give v = (du, du') = v0 - K x_pi, and
 * P and b of the predecessor get what is left. Root to leaves: v, x. */
#include "newton/blocks/factor.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "base/error.h"
#include "forms/momentum.h"
#include "model/query.h"
#include "newton/blocks/block.h"
#include "newton/blocks/solve.h"
#include "newton/slopes/body_slopes.h"
#include "newton/slopes/force_slopes.h"
#include "newton/slopes/joint_slopes.h"
#include "newton/slopes/relation.h"
#include "recursion/backward.h"
#include "recursion/forward.h"
#include "recursion/inverse.h"
#include "recursion/kinematics.h"

#include <math.h>

/* ---- factoring one joint ---- */

/* A joint while its block is made. */
typedef struct joint {
    mbsr_newton *w;
    mbsr_data *d;
    const mbsri_body *b;
    const mbsri_node *node, *above;
    mbsri_kept kept;
    int i;
    int motions, actions, motions_pred, actions_pred; /* lengths of x, y, x_pi, y_pi */
    int columns, q, u, a;                             /* of z, and where its parts begin */
    double *P;
    double *action;         /* actions x columns: y = P x + action z of force elements */
    double *below;          /* actions_pred x columns: y_pi */
    double *reaction;       /* n x columns: d(J^T mu - tau) */
    double *torque;         /* n x columns: dtau */
    double *torque_x;       /* n x motions: likewise, along x */
    double *pull;           /* d_pred x motions: f of the predecessor along x */
    double *pull_z;         /* d_pred x columns */
    double *y;              /* actions */
    double *size, *size_mu; /* n: what is added up in the rows of (a) and of (b) */
    double *size_a;         /* n: likewise, in the columns of du' of (b) */
    bool elements;          /* action, torque, pull are not all zero */
} joint;

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

size_t mbsri_tree_work(const mbsr_newton *w)
{
    size_t largest = 0;
    for (int i = 1; i <= w->model->bodies; ++i) {
        const mbsri_body *b = w->model->body + i;
        joint j = {.b = b, .node = w->node + i, .above = w->node + b->parent};
        const size_t size = place_work(&j, NULL);
        if (size > largest) largest = size;
    }
    return largest;
}

double *mbsri_tree_matrix(const mbsr_newton *w, int i)
{
    return w->slot + (size_t)w->node[i].slot * w->slot_size;
}

void mbsri_tree_clear(const mbsr_newton *w, int i)
{
    mbsri_zero(w->slot_size, mbsri_tree_matrix(w, i));
}

static void open_joint(mbsr_newton *w, mbsr_data *d, int i, joint *j)
{
    const mbsri_body *b = w->model->body + i;
    *j = (joint){.w = w, .d = d, .b = b, .node = w->node + i, .above = w->node + b->parent, .i = i};
    mbsri_keep(w, i, w->store + j->node->store, &j->kept);
    place_work(j, w->work);
    j->motions = mbsri_motions(j->node, b);
    j->actions = mbsri_actions(j->node, b);
    const mbsri_body *pred = w->model->body + b->parent;
    j->motions_pred = mbsri_motions(j->above, pred);
    j->actions_pred = mbsri_actions(j->above, pred);
    j->q = j->motions_pred;
    j->u = j->q + b->nq;
    j->a = j->u + b->n;
    j->columns = j->node->deep ? j->a + b->n : j->a;
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
    mbsri_copy(dn, d->G + b->dn, j->kept.G);
    if (j->w->mixed && j->node->rank == b->n) {
        whole_range(j);
        return;
    }
    mbsri_copy((size_t)b->n, d->s + b->iu, j->kept.s);
    mbsri_copy((size_t)b->n * (size_t)b->n, d->X + b->nn, j->kept.X);
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

/* ---- the columns of X, y, y_pi and of the joint's rows ---- */

/* Column of z <- column of the joint's derivatives, which always have those of A. */
static int source(const joint *j, const mbsri_joint_slopes *s, int k)
{
    if (k < j->q) return k;
    return s->q + k - j->q;
}

/* row (n) += sum of |A^T| |y| */
static void add_sizes(int d, int n, double factor, const double *A, const double *y, double *row)
{
    for (int k = 0; k < n; ++k) {
        for (int l = 0; l < d; ++l) row[k] += fabs(factor * A[k * d + l] * y[l]);
    }
}

/* What is added up in the rows of the joint in column k, if an unknown belongs to it. */
static void measure(joint *j, double c, int k, const double *own)
{
    const mbsri_body *b = j->b;
    const mbsri_kept *kept = &j->kept;
    const int d = b->d, n = b->n;
    const double *y = j->y, *torque = j->torque + (size_t)k * (size_t)n;
    /* dq = Cq G du: of the order of du / c */
    const double share = k < j->u ? 1.0 / fabs(c) : 1.0;
    add_sizes(d, n, share * c, kept->J, y, j->size);
    add_sizes(d, n, share, kept->J, y + d, j->size);
    add_sizes(d, n, share, kept->Jdot, y, j->size);
    for (int l = 0; l < n; ++l)
        j->size[l] += share * (fabs(c * own[l]) + fabs(own[n + l]) + fabs(torque[l]));
    if (!j->node->deep) return;
    double *size = k < j->a ? j->size_mu : j->size_a;
    for (int l = 0; l < n; ++l) size[l] += share * (fabs(own[2 * n + l]) + fabs(torque[l]));
    add_sizes(d, n, share, kept->J, y + 2 * d, size);
}

static void fill_column(joint *j, double c, const mbsri_joint_slopes *s, int k)
{
    const mbsri_body *b = j->b;
    const mbsri_kept *kept = &j->kept;
    const int d = b->d, n = b->n, dp = b->d_pred, from = source(j, s, k), all = s->e + 2 * d;
    const bool deep = j->node->deep;
    double *x = kept->x + (size_t)k * (size_t)j->motions, *y = j->y,
           *below = j->below + (size_t)k * (size_t)j->actions_pred,
           *torque = j->torque + (size_t)k * (size_t)n,
           *momentum = kept->momentum + (size_t)k * (size_t)n,
           *rate = kept->rate + (size_t)k * (size_t)n;
    const double *own = s->own + (size_t)from * (size_t)(3 * n);
    mbsri_copy((size_t)j->motions, s->x + (size_t)from * (size_t)all, x);
    /* y = P x + action z; much of x is zero */
    mbsri_copy((size_t)j->actions, j->action + (size_t)k * (size_t)j->actions, y);
    for (int l = 0; l < j->motions; ++l) {
        if (x[l] != 0.0) mbsri_ax(j->actions, 1, 1.0, j->P + l * j->actions, x + l, y);
    }
    /* y_pi */
    mbsri_copy((size_t)j->actions_pred, s->below + (size_t)from * (size_t)(3 * dp), below);
    mbsri_pass_action(b, kept, j->above->deep, y, below);
    if (j->elements) {
        double *pull = j->pull_z + (size_t)k * (size_t)dp;
        mbsri_ax(dp, j->node->e + d, 1.0, j->pull, x, pull);
        for (int l = 0; l < dp; ++l) below[dp + l] -= pull[l];
        for (int l = 0; l < dp && j->above->deep; ++l) below[2 * dp + l] += pull[l];
        mbsri_ax(n, j->node->e + d, 1.0, j->torque_x, x, torque);
    }
    /* d(M u) = J^T m + dJ^T m,  dP = J^T sigma + J'^T m + (.) + dtau */
    mbsri_copy((size_t)n, own, momentum);
    mbsri_atx(d, n, 1.0, kept->J, y, momentum);
    for (int l = 0; l < n; ++l) rate[l] = own[n + l] + torque[l];
    mbsri_atx(d, n, 1.0, kept->J, y + d, rate);
    mbsri_atx(d, n, 1.0, kept->Jdot, y, rate);
    if (k >= j->q) measure(j, c, k, own);
    if (!deep) return;
    /* d(J^T mu - tau) */
    double *reaction = j->reaction + (size_t)k * (size_t)n;
    for (int l = 0; l < n; ++l) reaction[l] = own[2 * n + l] - torque[l];
    mbsri_atx(d, n, 1.0, kept->J, y + 2 * d, reaction);
}

/* ---- the joint's block ---- */

/* Cq = (c - d(G u)/dq)^-1, Q = Cq G, both nq rows. */
static bool coordinates(joint *j, double c, const mbsri_joint_slopes *s)
{
    const int nq = j->b->nq, n = j->b->n;
    const double *qdot_q = s->qdot + (size_t)s->q * (size_t)nq,
                 *qdot_u = s->qdot + (size_t)s->u * (size_t)nq;
    double *A = j->kept.E, *rows = j->kept.row_scale, *columns = j->kept.column_scale;
    int *pivots = j->w->pivots + j->node->v;
    mbsri_zero((size_t)(nq * nq), j->kept.Cq);
    if (!j->b->joint.table->coordinate_rates) {
        for (int k = 0; k < nq; ++k) j->kept.Cq[k * (nq + 1)] = 1.0 / c;
    } else {
        for (int k = 0; k < nq; ++k) rows[k] = fabs(c);
        for (int k = 0; k < nq * nq; ++k) {
            A[k] = -qdot_q[k];
            rows[k % nq] += fabs(qdot_q[k]);
        }
        for (int k = 0; k < nq; ++k) A[k * (nq + 1)] += c;
        if (!mbsri_block_factor(nq, A, rows, columns, pivots)) return false;
        for (int k = 0; k < nq; ++k) {
            j->kept.Cq[k * (nq + 1)] = 1.0;
            mbsri_block_solve(nq, A, rows, columns, pivots, j->kept.Cq + k * nq);
        }
    }
    mbsri_zero((size_t)(nq * n), j->kept.Q);
    mbsri_ab(nq, nq, n, 1.0, j->kept.Cq, qdot_u, j->kept.Q);
    return true;
}

/* Rows (a), in the range of D where deep, and (b) of one column (momentum, rate, reaction). */
static void rows_of(const joint *j, double c, const double *momentum, const double *rate,
                    const double *reaction, double *out)
{
    const int n = j->b->n, rank = j->node->rank;
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

/* The unit of du' as an unknown, in which it weighs as much in (b) as du. Where accelerations are
 * large, as those of light bodies, (b) would else look singular to the rounding errors of dq and
 * du. */
static double acceleration_unit(const joint *j)
{
    if (j->node->rank == 0) return 1.0; /* there is none, and size_a is zero up to rounding */
    const double unit = mbsri_largest(j->b->n, j->size_mu) / mbsri_largest(j->b->n, j->size_a);
    return unit > 0.0 && isfinite(unit) ? unit : 1.0;
}

/* The unknown directions: column l of du with what dq follows, or of u' in the range of D; of a
 * matrix over z with `rows` rows. */
static void along(const joint *j, int l, int rows, const double *matrix, double *out)
{
    const int n = j->b->n, nq = j->b->nq;
    mbsri_zero((size_t)rows, out);
    if (l < n) {
        mbsri_ax(rows, 1, 1.0, matrix + (size_t)(j->u + l) * (size_t)rows, &(double){1.0}, out);
        mbsri_ax(rows, nq, 1.0, matrix + (size_t)j->q * (size_t)rows, j->kept.Q + l * nq, out);
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
    const int n = j->b->n, rank = j->node->rank;
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
    const int n = j->b->n, nq = j->b->nq, unknowns = j->node->unknowns, pred = j->actions_pred;
    const mbsri_kept *kept = &j->kept;
    double *momentum = j->y, *rate = momentum + n, *reaction = rate + n; /* y is done with */
    *kept->unit = j->node->deep ? acceleration_unit(j) : 1.0;
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

static int singular(joint *j, const char *what, const char *advice)
{
    char label[MBSRI_LABEL];
    const mbsri_body *b = j->b;
    return mbsri_fail(
        &j->d->error, MBSR_SINGULAR_BLOCK, b->id, MBSR_NONE, "%s: joint '%s': %s at t = %g; %s",
        mbsri_body_label(j->w->model, j->i, label), b->joint.table->name, what, j->d->t, advice);
}

static int not_finite(joint *j)
{
    char label[MBSRI_LABEL];
    const mbsri_body *b = j->b;
    return mbsri_fail(&j->d->error, MBSR_NOT_FINITE, b->id, MBSR_NONE,
                      "%s: joint '%s': its Newton equations are not finite at t = %g",
                      mbsri_body_label(j->w->model, j->i, label), b->joint.table->name, j->d->t);
}

/* Whether what was added up in the rows is, and what q' is made of. */
static bool rows_finite(const joint *j, const mbsri_joint_slopes *s)
{
    const size_t n = (size_t)j->b->n, nq = (size_t)j->b->nq;
    return mbsri_finite(n, j->size) && mbsri_finite(n, j->size_mu) && mbsri_finite(n, j->size_a) &&
           mbsri_finite(nq * (nq + n), s->qdot + (size_t)s->q * nq);
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
        mbsri_ax(j->actions_pred, j->node->unknowns, -1.0, j->kept.U,
                 j->kept.K + (size_t)k * (size_t)j->node->unknowns, column);
    }
}

/* mu over A is -Mbar, of which successors among the sweeps have not handed on their part. */
static void place_masses(const joint *j)
{
    const int d = j->b->d, first = j->node->e + d;
    const double *Mbar = j->d->Mbar + j->b->dd;
    for (int k = 0; k < d; ++k) {
        double *column = j->P + (size_t)(first + k) * (size_t)j->actions + 2 * d;
        for (int l = 0; l < d; ++l) column[l] = -Mbar[k * d + l];
    }
}

int mbsri_tree_eliminate(mbsr_newton *w, mbsr_data *d, int i, double c)
{
    const mbsr_model *m = w->model;
    joint j;
    open_joint(w, d, i, &j);
    keep_data(&j);
    int status = mbsri_body_slopes_add(m, d, i, j.node->deep, j.P, w->body);
    if (w->mixed && j.node->deep) place_masses(&j);
    if (!status) status = add_elements(&j);
    if (status) return status;
    mbsri_joint_slopes s;
    mbsri_joint_slopes_place(&s, w->joint);
    status = mbsri_joint_slopes_of(m, d, i, j.node->deep, d->udot + j.b->iu, &s);
    if (status) return status;
    mbsri_zero((size_t)j.b->n, j.size);
    mbsri_zero((size_t)j.b->n, j.size_mu);
    mbsri_zero((size_t)j.b->n, j.size_a);
    for (int k = 0; k < j.columns; ++k) fill_column(&j, c, &s, k);
    if (!rows_finite(&j, &s)) return not_finite(&j);
    if (!coordinates(&j, c, &s))
        return singular(&j, "c - d(q')/dq is singular", "take a shorter step");
    if (!eliminate(&j, c)) return singular(&j, "its equations are singular", MBSRI_SINGULAR_ADVICE);
    if (!mbsri_finite((size_t)(j.node->unknowns * j.motions_pred), j.kept.K)) return not_finite(&j);
    pass_on(&j);
    return MBSR_OK;
}

/* ---- the whole tree ---- */

void mbsri_tree_mark(mbsr_newton *w, int i, int rank)
{
    const mbsri_body *b = w->model->body + i;
    mbsri_node *node = w->node + i;
    node->rank = rank;
    node->deep = w->node[b->parent].deep || rank < b->n;
    node->unknowns = node->deep ? b->n + rank : b->n;
}

/* The data at the state, with ranks, momenta and rates; then A and mu where they are needed. */
static int evaluate(mbsr_newton *w, mbsr_data *d, double t, const double *q, const double *u)
{
    const mbsr_model *m = w->model;
    int status = mbsri_positions(m, d, t, q);
    if (!status) status = mbsri_velocities(m, d, u);
    if (!status) status = mbsri_momentum_derivatives(m, d, w->spare, w->spare + m->nq);
    if (!status) status = mbsri_backward(m, d);
    if (status) return status;
    w->node[0].deep = false;
    bool some = false;
    for (int i = 1; i <= m->bodies; ++i) {
        mbsri_tree_mark(w, i, d->rank[i]);
        some = some || w->node[i].deep;
    }
    if (!some) return MBSR_OK;
    double *x = w->work, *rates = w->spare;
    for (int i = 1; i <= m->bodies; ++i) mbsri_known_part(m, d, i, x, rates + m->body[i].u);
    mbsri_inverse(m, d, rates);
    return MBSR_OK;
}

int mbsri_tree_factor(mbsr_newton *w, mbsr_data *d, double t, const double *q, const double *u,
                      double c)
{
    const mbsr_model *m = w->model;
    w->mixed = false;
    int status = evaluate(w, d, t, q, u);
    w->c = c;
    for (int i = m->bodies; i >= 1 && !status; --i) {
        const int parent = m->body[i].parent;
        if (w->node[i].last == 0) mbsri_tree_clear(w, i);
        if (parent > 0 && w->node[parent].last == i) mbsri_tree_clear(w, parent);
        status = mbsri_tree_eliminate(w, d, i, c);
    }
    return status;
}
