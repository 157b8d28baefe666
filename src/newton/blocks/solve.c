/* Solving with the elimination of factor.c: the two sweeps.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Symbols as there. Leaves to root, b of a body and r of its joint give v0 and what b of the
 * predecessor gets; root to leaves, v = v0 - K x_pi. dp follows from F_u where D takes it up, and
 * from F_p elsewhere. */
#include "newton/blocks/solve.h"

#include "algebra/dense.h"
#include "newton/blocks/block.h"
#include "newton/blocks/front_solve.h"
#include "newton/blocks/kept.h"
#include "recursion/group.h"

void mbsri_tree_load(mbsr_newton *w, int i, const double *r, const double *load)
{
    const mbsr_model *m = w->model;
    const mbsri_body *b = m->body + i;
    const size_t n = (size_t)b->n, nq = (size_t)b->nq;
    mbsri_tree_clear_load(w, i);
    if (r) {
        const double *rp = r + m->nq, *ru = rp + m->nu;
        mbsri_copy(nq, r + b->q, w->rq + b->igq);
        mbsri_copy(n, rp + b->u, w->rp + b->ig);
        mbsri_copy(n, ru + b->u, w->ru + b->ig);
    } else {
        mbsri_zero(nq, w->rq + b->igq);
        mbsri_zero(n, w->rp + b->ig);
        mbsri_zero(n, w->ru + b->ig);
    }
    double *y = w->b + 3 * b->v;
    for (int k = 0; k < b->d && load; ++k) {
        y[b->d + k] = -load[b->v + (size_t)k];
        y[2 * b->d + k] = load[b->v + (size_t)k];
    }
}

void mbsri_tree_clear_load(mbsr_newton *w, int i)
{
    const mbsri_body *b = w->model->body + i;
    mbsri_zero(3 * (size_t)b->d, w->b + 3 * b->v);
    mbsri_zero((size_t)b->d, w->wbar + b->v);
}

/* The joint of body i, or the group it is the head of; vectors over a group begin at g.ig and igq. */
typedef struct unit {
    mbsri_group g;
    const mbsri_body *b; /* the head */
    const mbsri_node *node;
    mbsri_kept kept;
    int nq;
} unit;

static unit unit_of(const mbsr_newton *w, int i)
{
    const mbsri_body *b = w->model->body + i;
    const bool coupled = w->node[i].coupled;
    unit x = {.b = b, .node = w->node + i, .nq = coupled ? b->group_nq : b->nq};
    x.g = coupled ? mbsri_group_in_model(w->model, i)
                  : (mbsri_group){w->model->member + b->at, 1, b->n, b->ig};
    mbsri_keep(w, i, w->store + x.node->store, &x.kept);
    return x;
}

/* Whether body i is done with the head of its group. */
static bool follows(const mbsr_newton *w, int i)
{
    return w->node[i].coupled && w->model->body[i].head != i;
}

/* A member and what is kept of it. */
static const mbsri_body *member_of(const mbsr_newton *w, const unit *x, int k, mbsri_kept *kept)
{
    const int i = x->g.member[k];
    if (k == 0)
        *kept = x->kept;
    else
        mbsri_keep(w, i, w->store + w->node[i].store, kept);
    return w->model->body + i;
}

/* w->momentum = L (1 - P) r_u, leaving P r_u in w->ru. */
static void lift(mbsr_newton *w, const unit *x)
{
    const mbsri_body *b = x->b;
    double *wbar = w->wbar + b->v, *range = w->range + x->g.ig;
    mbsri_kept_split(&x->kept, x->g.n, x->node->rank, w->ru + x->g.ig, range);
    for (int k = 0; k < x->g.members; ++k) {
        mbsri_kept kept;
        const mbsri_body *at = member_of(w, x, k, &kept);
        double *out = w->momentum + at->ig;
        mbsri_copy((size_t)at->n, w->range + at->ig, out);
        mbsri_atx(at->d, at->n, 1.0, kept.J, w->wbar + at->v, out);
    }
    mbsri_ax(b->d, x->g.n, 1.0, x->kept.G, range, wbar);
    mbsri_atx(b->d, b->d_pred, -1.0, x->kept.H, wbar, w->wbar + b->pred_v);
}

/* What a member that is not the head hands on of b and wbar. */
static void hand_on(mbsr_newton *w, int i)
{
    const mbsri_body *b = w->model->body + i;
    mbsri_kept kept;
    mbsri_keep(w, i, w->store + w->node[i].store, &kept);
    mbsri_atx(b->d, b->d_pred, -1.0, kept.H, w->wbar + b->v, w->wbar + b->pred_v);
    mbsri_pass_action(b, &kept, true, w->b + 3 * b->v, w->b + 3 * b->pred_v);
}

/* (a): r_p + c w - (c J^T m - J^T sigma - J'^T m), (b): P r_u - J^T mu */
static void right_sides(mbsr_newton *w, const unit *x, const double *tau, double *rhs,
                        double *reaction)
{
    for (int i = 0; i < x->g.members; ++i) {
        mbsri_kept kept;
        const mbsri_body *b = member_of(w, x, i, &kept);
        const double *y = w->b + 3 * b->v;
        const int d = b->d, n = b->n;
        double *a = rhs + b->ig - x->g.ig, *r = reaction + b->ig - x->g.ig;
        for (int k = 0; k < n; ++k) {
            const double load = tau ? tau[b->iu + k] : 0.0;
            a[k] = w->rp[b->ig + k] + w->c * w->momentum[b->ig + k] + load;
            r[k] = w->ru[b->ig + k] + load;
        }
        mbsri_atx(d, n, -w->c, kept.J, y, a);
        mbsri_atx(d, n, 1.0, kept.J, y + d, a);
        mbsri_atx(d, n, 1.0, kept.Jdot, y, a);
        if (x->node->deep) mbsri_atx(d, n, -1.0, kept.J, y + 2 * d, r);
    }
}

/* Leaves to root: v0, and b of the predecessor. */
void mbsri_tree_reduce(mbsr_newton *w, int i, const double *tau)
{
    if (follows(w, i)) {
        hand_on(w, i);
        return;
    }
    const unit x = unit_of(w, i);
    const mbsri_body *b = x.b;
    const mbsri_node *node = x.node, *above = w->node + b->parent;
    const mbsri_kept *kept = &x.kept;
    const int n = x.g.n, nq = x.nq, unknowns = node->unknowns;
    lift(w, &x);
    double *v = w->v + node->v, *below = w->b + 3 * b->pred_v, *q0 = w->q0 + b->igq;
    double *rhs = w->work, *reaction = rhs + n;
    mbsri_zero((size_t)nq, q0);
    mbsri_ax(nq, nq, 1.0, kept->Cq, w->rq + b->igq, q0);
    right_sides(w, &x, tau, rhs, reaction);
    if (mbsri_is_front(w, i)) {
        double *own = reaction + n;
        mbsri_kept_rows(&x.kept, node, n, rhs, reaction, own);
        mbsri_front_reduce(w, i, own, q0);
        if (b->parent > 0) mbsri_pass_action(b, kept, above->deep, w->b + 3 * b->v, below);
        return;
    }
    mbsri_copy((size_t)n, rhs, v);
    if (node->deep) {
        for (int r = 0; r < node->rank; ++r) {
            v[r] = 0.0;
            for (int k = 0; k < n; ++k) v[r] += kept->X[r * n + k] * kept->s[k] * rhs[k];
        }
        mbsri_copy((size_t)n, reaction, v + node->rank);
    }
    mbsri_ax(unknowns, nq, -1.0, kept->Eq, q0, v);
    mbsri_block_solve(unknowns, kept->E, kept->row_scale, kept->column_scale, w->pivots + node->v,
                      v);
    if (b->parent == 0) return;
    const int pred = above->deep ? 3 * b->d_pred : 2 * b->d_pred;
    mbsri_pass_action(b, kept, above->deep, w->b + 3 * b->v, below);
    mbsri_ax(pred, nq, 1.0, kept->Uq, q0, below);
    mbsri_ax(pred, unknowns, 1.0, kept->U, v, below);
}

/* z = (x_pi, dq, du, du') from what is known of the predecessor; the length. */
static int variables(mbsr_newton *w, const unit *x, double *z)
{
    const mbsri_body *b = x->b;
    const mbsri_node *node = x->node, *above = w->node + b->parent;
    const mbsri_kept *kept = &x->kept;
    const int n = x->g.n, nq = x->nq, unknowns = node->unknowns,
              x_pred = above->e + (above->deep ? 2 : 1) * b->d_pred;
    double *v = w->v + node->v;
    double *q = z + x_pred, *u = q + nq, *a = u + n;
    mbsri_copy((size_t)x_pred, w->x + above->x, z);
    mbsri_copy((size_t)nq, w->q0 + b->igq, q);
    if (mbsri_is_front(w, x->g.member[0])) {
        mbsri_front_substitute(w, x->g.member[0]);
        mbsri_kept_rates(kept, node, n, v, u, a);
        mbsri_ax(nq, n, 1.0, kept->Q, u, q);
        mbsri_front_apply(w, x->g.member[0], q, NULL, NULL);
        return node->deep ? x_pred + nq + 2 * n : x_pred + nq + n;
    }
    mbsri_ax(unknowns, x_pred, -1.0, kept->K, z, v);
    mbsri_ax(nq, n, 1.0, kept->Q, v, q);
    mbsri_copy((size_t)n, v, u);
    if (!node->deep) return x_pred + nq + n;
    mbsri_zero((size_t)n, a);
    for (int r = 0; r < node->rank; ++r) {
        for (int k = 0; k < n; ++k)
            a[k] += *kept->unit * kept->s[k] * kept->X[r * n + k] * v[n + r];
    }
    return x_pred + nq + 2 * n;
}

/* dp (n) = d(M u) - w in the range of D, (r_p + dP) / c in its null space. */
static void momentum_change(mbsr_newton *w, const unit *x, const double *z, int columns,
                            const double *tau, double *dp)
{
    const int n = x->g.n, rank = x->node->rank;
    const bool deficient = rank < n;
    double *range = w->range + x->g.ig, *rate = w->rp + x->g.ig;
    for (int k = 0; k < n; ++k) dp[k] = -w->momentum[x->g.ig + k];
    mbsri_ax(n, columns, 1.0, x->kept.momentum, z, dp);
    if (deficient) mbsri_ax(n, columns, 1.0, x->kept.rate, z, rate);
    if (mbsri_is_front(w, x->g.member[0]))
        mbsri_front_apply(w, x->g.member[0], NULL, dp, deficient ? rate : NULL);
    for (int i = 0; i < x->g.members; ++i) {
        mbsri_kept kept;
        const mbsri_body *b = member_of(w, x, i, &kept);
        const int d = b->d, at = b->ig - x->g.ig;
        const double *y = w->b + 3 * b->v;
        mbsri_atx(d, b->n, 1.0, kept.J, y, dp + at);
        if (!deficient) continue;
        for (int k = 0; k < b->n && tau; ++k) rate[at + k] += tau[b->iu + k];
        mbsri_atx(d, b->n, 1.0, kept.J, y + d, rate + at);
        mbsri_atx(d, b->n, 1.0, kept.Jdot, y, rate + at);
    }
    if (!deficient) return;
    mbsri_kept_split(&x->kept, n, rank, dp, range);
    mbsri_kept_split(&x->kept, n, rank, rate, dp);
    for (int k = 0; k < n; ++k) dp[k] = range[k] + rate[k] / w->c;
}

/* x of a member. */
static void move_member(mbsr_newton *w, const mbsri_kept *kept, int i, const double *z, int columns)
{
    const int motions = mbsri_motions(w->node + i, w->model->body + i);
    double *motion = w->x + w->node[i].x;
    mbsri_zero((size_t)motions, motion);
    mbsri_ax(motions, columns, 1.0, kept->x, z, motion);
}

void mbsri_tree_move(mbsr_newton *w, int i)
{
    const unit x = unit_of(w, i);
    const int columns = variables(w, &x, w->work);
    for (int k = 0; k < x.g.members; ++k) {
        mbsri_kept kept;
        (void)member_of(w, &x, k, &kept);
        move_member(w, &kept, x.g.member[k], w->work, columns);
    }
}

/* Root to leaves: v, x and delta of the joint. */
void mbsri_tree_substitute(mbsr_newton *w, int i, const double *tau, double *delta)
{
    if (follows(w, i)) return;
    const mbsr_model *m = w->model;
    const unit x = unit_of(w, i);
    double *z = w->work;
    const int columns = variables(w, &x, z);
    const double *q = z + columns - (x.node->deep ? 2 : 1) * x.g.n - x.nq;
    double *dp = z + columns;
    momentum_change(w, &x, z, columns, tau, dp);
    for (int k = 0; k < x.g.members; ++k) {
        mbsri_kept kept;
        const mbsri_body *b = member_of(w, &x, k, &kept);
        const int at = b->ig - x.g.ig;
        move_member(w, &kept, x.g.member[k], z, columns);
        mbsri_copy((size_t)b->nq, q + b->igq - x.b->igq, delta + b->q);
        mbsri_copy((size_t)b->n, dp + at, delta + m->nq + b->u);
        mbsri_copy((size_t)b->n, q + x.nq + at, delta + m->nq + m->nu + b->u);
    }
}
