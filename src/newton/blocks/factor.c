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
#include "newton/blocks/coupled.h"
#include "newton/blocks/front.h"
#include "newton/blocks/joint.h"
#include "newton/blocks/kept.h"
#include "newton/blocks/linked.h"
#include "newton/linear/linear.h"
#include "recursion/backward.h"
#include "recursion/modal.h"

/* ---- factoring one joint ---- */

typedef mbsri_block_joint joint;

size_t mbsri_tree_work(const mbsr_newton *w)
{
    size_t largest = 0;
    for (int i = 1; i <= w->model->bodies; ++i) {
        const size_t size =
            w->model->body[i].members > 1 ? mbsri_coupled_work(w, i) : mbsri_block_size(w, i);
        if (size > largest) largest = size;
    }
    return largest;
}

void mbsri_tree_clear(const mbsr_newton *w, int i)
{
    mbsri_zero(w->slot_size, mbsri_tree_matrix(w, i));
}

/* ---- the columns of X, y, y_pi and of the joint's rows ---- */

static void fill_column(joint *j, double c, const mbsri_joint_slopes *s, int k)
{
    const mbsri_body *b = j->b;
    const mbsri_kept *kept = &j->kept;
    const int d = b->d, n = b->n, dp = b->d_pred, from = mbsri_block_source(j, s, k),
              all = s->e + 2 * d;
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
    int waiting = -1;
    for (int l = 0; l < j->motions; ++l) {
        if (x[l] == 0.0) continue;
        if (waiting >= 0)
            mbsri_add_two_long(j->actions, j->P + waiting * j->actions, x[waiting],
                               j->P + l * j->actions, x[l], y);
        waiting = waiting >= 0 ? -1 : l;
    }
    if (waiting >= 0) mbsri_ax(j->actions, 1, 1.0, j->P + waiting * j->actions, x + waiting, y);
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
    mbsri_add_rates(b, kept->J, y, momentum);
    for (int l = 0; l < n; ++l) rate[l] = own[n + l] + torque[l];
    mbsri_add_rates(b, kept->J, y + d, rate);
    mbsri_add_rates_dot(b, kept->Jdot, y, rate);
    if (k >= j->q) {
        const mbsri_column_kind kind = k < j->u   ? MBSRI_COLUMN_Q
                                       : k < j->a ? MBSRI_COLUMN_U
                                                  : MBSRI_COLUMN_A;
        mbsri_block_measure(j, c, kind, y, own, torque);
    }
    if (!deep) return;
    /* d(J^T mu - tau) */
    double *reaction = j->reaction + (size_t)k * (size_t)n;
    for (int l = 0; l < n; ++l) reaction[l] = own[2 * n + l] - torque[l];
    mbsri_add_rates(b, kept->J, y + 2 * d, reaction);
}

/* Whether q' is made of finite numbers. */
static bool rates_finite(const joint *j, const mbsri_joint_slopes *s)
{
    const size_t n = (size_t)j->b->n, nq = (size_t)j->b->nq;
    return mbsri_finite(nq * (nq + n), s->qdot + (size_t)s->q * nq);
}

int mbsri_tree_eliminate(mbsr_newton *w, mbsr_data *d, int i, double c)
{
    const mbsr_model *m = w->model;
    if (w->node[i].coupled) {
        const bool head = m->body[i].head == i;
        return head ? mbsri_coupled_eliminate(w, d, i, c) : MBSR_OK;
    }
    joint j;
    int status = mbsri_block_begin(w, d, i, w->work, &j);
    if (status) return status;
    mbsri_joint_slopes s;
    mbsri_joint_slopes_place(&s, w->joint);
    status = mbsri_joint_slopes_of(m, d, i, j.node->deep, d->udot + j.b->iu, &s);
    if (status) return status;
    mbsri_zero((size_t)j.b->n, j.size);
    mbsri_zero((size_t)j.b->n, j.size_mu);
    mbsri_zero((size_t)j.b->n, j.size_a);
    for (int k = 0; k < j.columns; ++k) fill_column(&j, c, &s, k);
    if (!rates_finite(&j, &s)) return mbsri_block_not_finite(&j);
    if (!mbsri_block_coordinates(j.b, c, &s, j.kept.Cq, j.kept.Q, j.kept.E, j.kept.row_scale,
                                 j.kept.column_scale, w->pivots + j.node->v))
        return mbsri_block_singular(&j, "c - d(q')/dq is singular", "take a shorter step");
    if (!mbsri_is_front(w, i)) return mbsri_block_finish(&j, c);
    return mbsri_front_finish(&j, 1, &(mbsri_front_joint){&j, -1, 0, 0}, c);
}

/* ---- the whole tree ---- */

void mbsri_tree_mark(mbsr_newton *w, int i, int rank)
{
    const mbsri_body *b = w->model->body + i;
    mbsri_node *node = w->node + i;
    node->rank = rank;
    node->coupled = false;
    node->deep = w->node[b->parent].deep || rank < b->n;
    node->unknowns = node->deep ? b->n + rank : b->n;
}

void mbsri_tree_mark_coupled(mbsr_newton *w, const mbsri_group *g, int rank)
{
    for (int k = 0; k < g->members; ++k) {
        mbsri_node *node = w->node + g->member[k];
        node->coupled = node->deep = true;
        node->rank = k == 0 ? rank : 0;
        node->unknowns = k == 0 ? g->n + rank : 0;
    }
}

/* The state, and what w->node says of it. */
static int evaluate(mbsr_newton *w, mbsr_data *d, double t, const double *y, const double *yp)
{
    const mbsr_model *m = w->model;
    const int status = mbsri_linear_state(m, d, t, y, yp, w->spare);
    if (status) return status;
    w->node[0].deep = false;
    bool some = false;
    for (int i = 1; i <= m->bodies; ++i) {
        if (!mbsri_heads(m, d, i)) continue;
        const mbsri_group g = mbsri_group_of(m, d, i);
        if (g.members > 1)
            mbsri_tree_mark_coupled(w, &g, mbsri_group_rank(d, &g));
        else
            mbsri_tree_mark(w, i, d->rank[i]);
        some = some || w->node[i].deep;
    }
    if (some) mbsri_linear_react(m, d, w->spare, w->work, w->work + m->max_d);
    return MBSR_OK;
}

int mbsri_tree_factor(mbsr_newton *w, mbsr_data *d, double t, const double *y, const double *yp,
                      double c)
{
    const mbsr_model *m = w->model;
    w->mixed = false;
    int status = evaluate(w, d, t, y, yp);
    w->c = c;
    if (!status && m->rows > 0) status = mbsri_carried_open(w, d, c, false);
    if (!status && w->linked) status = mbsri_links_open(w, d, NULL);
    for (int k = 0; k < m->bodies && !status; ++k) {
        const int i = mbsri_links_turn(w, k), parent = m->body[i].parent;
        if (w->node[i].last == 0) mbsri_tree_clear(w, i);
        if (parent > 0 && w->node[parent].last == i) mbsri_tree_clear(w, parent);
        if (m->rows > 0) status = mbsri_front_close(w, d, i);
        if (!status) status = mbsri_tree_eliminate(w, d, i, c);
        if (!status) mbsri_links_pass(w, i);
    }
    if (!status && m->rows > 0) status = mbsri_front_close(w, d, 0);
    if (!status && m->grouped) status = mbsri_backward(m, d);
    return status;
}
