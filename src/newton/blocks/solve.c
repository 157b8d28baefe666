/* Solving with the elimination of factor.c: what is kept of each joint, and the two sweeps.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Symbols as there. Leaves to root, b of a body and r of its joint give v0 and what b of the
 * predecessor gets; root to leaves, v = v0 - K x_pi. dp follows from F_u where D takes it up, and
 * from F_p elsewhere. */
#include "newton/blocks/solve.h"

#include "algebra/dense.h"
#include "newton/blocks/block.h"

size_t mbsri_keep(const mbsr_newton *w, int i, double *memory, mbsri_kept *k)
{
    const mbsri_body *b = w->model->body + i;
    const mbsri_node *node = w->node + i, *above = w->node + b->parent;
    const size_t d = (size_t)b->d, dp = (size_t)b->d_pred, n = (size_t)b->n, nq = (size_t)b->nq,
                 x = (size_t)node->e + 2 * d, x_pred = (size_t)above->e + 2 * dp,
                 columns = x_pred + nq + 2 * n, k2 = nq > 2 * n ? nq : 2 * n;
    double **const array[] = {
        &k->unit, &k->H,        &k->Hdot, &k->J,  &k->Jdot, &k->G, &k->s,         &k->X,
        &k->x,    &k->momentum, &k->rate, &k->Cq, &k->Q,    &k->E, &k->row_scale, &k->column_scale,
        &k->Eq,   &k->K,        &k->U,    &k->Uq};
    const size_t length[] = {1,           d * dp,     d * dp,         d * n,          d * n,
                             d * n,       n,          n * n,          x * columns,    n * columns,
                             n * columns, nq * nq,    nq * n,         k2 * k2,        k2,
                             k2,          2 * n * nq, 2 * n * x_pred, 3 * dp * 2 * n, 3 * dp * nq};
    size_t used = 0;
    for (size_t l = 0; l < sizeof length / sizeof length[0]; ++l) {
        *array[l] = memory ? memory + used : NULL;
        used += length[l];
    }
    return used;
}

/* y_pi += B y:  -H^T m,  -(H^T sigma + H'^T m),  -H^T mu */
void mbsri_pass_action(const mbsri_body *b, const mbsri_kept *kept, bool deep, const double *y,
                       double *below)
{
    const int d = b->d, dp = b->d_pred;
    mbsri_atx(d, dp, -1.0, kept->H, y, below);
    mbsri_atx(d, dp, -1.0, kept->H, y + d, below + dp);
    mbsri_atx(d, dp, -1.0, kept->Hdot, y, below + dp);
    if (deep) mbsri_atx(d, dp, -1.0, kept->H, y + 2 * d, below + 2 * dp);
}

/* y = (1 - P) x and x = P x for momenta of a joint: P = S^-1 X_N X_N^T S as mbsri_null_force. */
static void split(const mbsri_kept *kept, int n, int rank, double *x, double *y)
{
    for (int k = 0; k < n; ++k) y[k] = x[k], x[k] = 0.0;
    for (int l = rank; l < n; ++l) {
        const double *X = kept->X + l * n;
        double weight = 0.0;
        for (int k = 0; k < n; ++k) weight += X[k] * kept->s[k] * y[k];
        for (int k = 0; k < n; ++k) x[k] += X[k] * weight / kept->s[k];
    }
    for (int k = 0; k < n; ++k) y[k] -= x[k];
}

void mbsri_tree_load(mbsr_newton *w, int i, const double *r, const double *load)
{
    const mbsr_model *m = w->model;
    const mbsri_body *b = m->body + i;
    const size_t n = (size_t)b->n, nq = (size_t)b->nq;
    mbsri_tree_clear_load(w, i);
    if (r) {
        const double *rp = r + m->nq, *ru = rp + m->nu;
        mbsri_copy(nq, r + b->q, w->rq + b->iq);
        mbsri_copy(n, rp + b->u, w->rp + b->iu);
        mbsri_copy(n, ru + b->u, w->ru + b->iu);
    } else {
        mbsri_zero(nq, w->rq + b->iq);
        mbsri_zero(n, w->rp + b->iu);
        mbsri_zero(n, w->ru + b->iu);
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

/* w->momentum = L (1 - P) r_u, leaving P r_u in w->ru. */
static void lift(mbsr_newton *w, int i, const mbsri_kept *kept)
{
    const mbsri_body *b = w->model->body + i;
    double *wbar = w->wbar + b->v, *range = w->range + b->iu, *out = w->momentum + b->iu;
    split(kept, b->n, w->node[i].rank, w->ru + b->iu, range);
    mbsri_copy((size_t)b->n, range, out);
    mbsri_atx(b->d, b->n, 1.0, kept->J, wbar, out);
    mbsri_ax(b->d, b->n, 1.0, kept->G, range, wbar);
    mbsri_atx(b->d, b->d_pred, -1.0, kept->H, wbar, w->wbar + b->pred_v);
}

/* Leaves to root: v0, and b of the predecessor. */
void mbsri_tree_reduce(mbsr_newton *w, int i, const double *tau)
{
    const mbsri_body *b = w->model->body + i;
    const mbsri_node *node = w->node + i, *above = w->node + b->parent;
    const int d = b->d, n = b->n, nq = b->nq, unknowns = node->unknowns;
    mbsri_kept kept;
    mbsri_keep(w, i, w->store + node->store, &kept);
    lift(w, i, &kept);
    const double *y = w->b + 3 * b->v;
    double *v = w->v + node->v, *below = w->b + 3 * b->pred_v, *q0 = w->q0 + b->iq;
    double *rhs = w->work, *reaction = rhs + n;
    mbsri_zero((size_t)nq, q0);
    mbsri_ax(nq, nq, 1.0, kept.Cq, w->rq + b->iq, q0);
    /* (a): r_p + c w - (c J^T m - J^T sigma - J'^T m), (b): P r_u - J^T mu */
    for (int k = 0; k < n; ++k) {
        const double load = tau ? tau[b->iu + k] : 0.0;
        rhs[k] = w->rp[b->iu + k] + w->c * w->momentum[b->iu + k] + load;
        reaction[k] = w->ru[b->iu + k] + load;
    }
    mbsri_atx(d, n, -w->c, kept.J, y, rhs);
    mbsri_atx(d, n, 1.0, kept.J, y + d, rhs);
    mbsri_atx(d, n, 1.0, kept.Jdot, y, rhs);
    mbsri_copy((size_t)n, rhs, v);
    if (node->deep) {
        mbsri_atx(d, n, -1.0, kept.J, y + 2 * d, reaction);
        for (int r = 0; r < node->rank; ++r) {
            v[r] = 0.0;
            for (int k = 0; k < n; ++k) v[r] += kept.X[r * n + k] * kept.s[k] * rhs[k];
        }
        mbsri_copy((size_t)n, reaction, v + node->rank);
    }
    mbsri_ax(unknowns, nq, -1.0, kept.Eq, q0, v);
    mbsri_block_solve(unknowns, kept.E, kept.row_scale, kept.column_scale, w->pivots + node->v, v);
    if (b->parent == 0) return;
    const int pred = above->deep ? 3 * b->d_pred : 2 * b->d_pred;
    mbsri_pass_action(b, &kept, above->deep, y, below);
    mbsri_ax(pred, nq, 1.0, kept.Uq, q0, below);
    mbsri_ax(pred, unknowns, 1.0, kept.U, v, below);
}

/* z = (x_pi, dq, du, du') of joint i from what is known of its predecessor; the length. */
static int variables(mbsr_newton *w, int i, const mbsri_kept *kept, double *z)
{
    const mbsri_body *b = w->model->body + i;
    const mbsri_node *node = w->node + i, *above = w->node + b->parent;
    const int n = b->n, nq = b->nq, unknowns = node->unknowns,
              x_pred = above->e + (above->deep ? 2 : 1) * b->d_pred;
    double *v = w->v + node->v;
    mbsri_copy((size_t)x_pred, w->x + above->x, z);
    mbsri_ax(unknowns, x_pred, -1.0, kept->K, z, v);
    double *q = z + x_pred, *u = q + nq, *a = u + n;
    mbsri_copy((size_t)nq, w->q0 + b->iq, q);
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

/* dp = d(M u) - w in the range of D, (r_p + dP) / c in its null space. */
static void momentum_change(mbsr_newton *w, int i, const mbsri_kept *kept, const double *z,
                            int columns, const double *tau, double *dp)
{
    const mbsri_body *b = w->model->body + i;
    const int d = b->d, n = b->n, rank = w->node[i].rank;
    const double *y = w->b + 3 * b->v;
    for (int k = 0; k < n; ++k) dp[k] = -w->momentum[b->iu + k];
    mbsri_ax(n, columns, 1.0, kept->momentum, z, dp);
    mbsri_atx(d, n, 1.0, kept->J, y, dp);
    if (rank == n) return;
    double *range = w->range + b->iu, *rate = w->rp + b->iu;
    split(kept, n, rank, dp, range);
    for (int k = 0; k < n && tau; ++k) rate[k] += tau[b->iu + k];
    mbsri_ax(n, columns, 1.0, kept->rate, z, rate);
    mbsri_atx(d, n, 1.0, kept->J, y + d, rate);
    mbsri_atx(d, n, 1.0, kept->Jdot, y, rate);
    split(kept, n, rank, rate, dp);
    for (int k = 0; k < n; ++k) dp[k] = range[k] + rate[k] / w->c;
}

/* Root to leaves: v, x and delta of the joint. */
void mbsri_tree_substitute(mbsr_newton *w, int i, const double *tau, double *delta)
{
    const mbsr_model *m = w->model;
    const mbsri_body *b = m->body + i;
    mbsri_kept kept;
    mbsri_keep(w, i, w->store + w->node[i].store, &kept);
    double *z = w->work, *x = w->x + w->node[i].x, *dp = delta + m->nq + b->u;
    const int columns = variables(w, i, &kept, z), motions = mbsri_motions(w->node + i, b);
    mbsri_zero((size_t)motions, x);
    mbsri_ax(motions, columns, 1.0, kept.x, z, x);
    const double *q = z + columns - (w->node[i].deep ? 2 : 1) * b->n - b->nq;
    mbsri_copy((size_t)b->nq, q, delta + b->q);
    mbsri_copy((size_t)b->n, q + b->nq, delta + m->nq + m->nu + b->u);
    momentum_change(w, i, &kept, z, columns, tau, dp);
}

void mbsri_tree_solve(mbsr_newton *w, const double *r, const double *load, double *delta)
{
    const mbsr_model *m = w->model;
    const double *tau = load ? load + m->size_v : NULL;
    mbsri_tree_clear_load(w, 0);
    for (int i = 1; i <= m->bodies; ++i) mbsri_tree_load(w, i, r, load);
    for (int i = m->bodies; i >= 1; --i) mbsri_tree_reduce(w, i, tau);
    mbsri_zero((size_t)mbsri_motions(w->node, m->body), w->x);
    for (int i = 1; i <= m->bodies; ++i) mbsri_tree_substitute(w, i, tau, delta);
}
