/* What is kept of a joint between factoring and solving: see kept.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "newton/blocks/kept.h"

#include "algebra/dense.h"
#include "recursion/modal.h"

size_t mbsri_keep(const mbsr_newton *w, int i, double *memory, mbsri_kept *k)
{
    const mbsri_body *b = w->model->body + i, *head = w->model->body + b->head;
    const mbsri_node *node = w->node + i, *above = w->node + b->parent;
    const size_t d = (size_t)b->d, dp = (size_t)b->d_pred, n = (size_t)b->group_n,
                 nq = (size_t)b->group_nq, x = (size_t)node->e + 2 * d,
                 x_pred = (size_t)above->e + 2 * dp, columns = x_pred + nq + 2 * n,
                 of_head = (size_t)w->node[head->parent].e + 2 * (size_t)head->d_pred +
                           (size_t)head->group_nq + 2 * (size_t)head->group_n,
                 widest = of_head > columns ? of_head : columns, k2 = nq > 2 * n ? nq : 2 * n;
    double **const array[] = {
        &k->unit, &k->H,        &k->Hdot, &k->J,  &k->Jdot, &k->G, &k->s,         &k->X,
        &k->x,    &k->momentum, &k->rate, &k->Cq, &k->Q,    &k->E, &k->row_scale, &k->column_scale,
        &k->Eq,   &k->K,        &k->U,    &k->Uq};
    const size_t length[] = {1,           d * dp,     d * dp,         d * n,          d * n,
                             d * n,       n,          n * n,          x * widest,     n * columns,
                             n * columns, nq * nq,    nq * n,         k2 * k2,        k2,
                             k2,          2 * n * nq, 2 * n * x_pred, 3 * dp * 2 * n, 3 * dp * nq};
    size_t used = 0;
    for (size_t l = 0; l < sizeof length / sizeof length[0]; ++l) {
        *array[l] = memory ? memory + used : NULL;
        used += length[l];
    }
    return used;
}

void mbsri_kept_split(const mbsri_kept *kept, int n, int rank, double *x, double *y)
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

/* As below, of a mount: H = [Ht; 0]. */
static void pass_upper(const mbsri_body *b, const mbsri_kept *kept, bool deep, const double *y,
                       double *below)
{
    const int d = b->d, dp = b->d_pred, rows = MBSRI_FRAME_ROWS;
    for (int k = 0; k < dp; ++k) {
        const double *H = kept->H + k * d, *Hdot = kept->Hdot + k * d;
        below[k] -= mbsri_dot(rows, H, y);
        below[dp + k] -= mbsri_dot(rows, H, y + d) + mbsri_dot(rows, Hdot, y);
        if (deep) below[2 * dp + k] -= mbsri_dot(rows, H, y + 2 * d);
    }
}

/* y_pi += B y:  -H^T m,  -(H^T sigma + H'^T m),  -H^T mu */
void mbsri_pass_action(const mbsri_body *b, const mbsri_kept *kept, bool deep, const double *y,
                       double *below)
{
    const int d = b->d, dp = b->d_pred;
    if (d > MBSRI_FRAME_ROWS && b->modal) {
        pass_upper(b, kept, deep, y, below);
        return;
    }
    mbsri_atx(d, dp, -1.0, kept->H, y, below);
    mbsri_atx(d, dp, -1.0, kept->H, y + d, below + dp);
    mbsri_atx(d, dp, -1.0, kept->Hdot, y, below + dp);
    if (deep) mbsri_atx(d, dp, -1.0, kept->H, y + 2 * d, below + 2 * dp);
}

void mbsri_kept_rows(const mbsri_kept *kept, const mbsri_node *node, int n, const double *a,
                     const double *balance, double *out)
{
    if (!node->deep) {
        mbsri_copy((size_t)n, a, out);
        return;
    }
    for (int r = 0; r < n; ++r) {
        const double *X = kept->X + r * n;
        double along = 0.0, across = 0.0;
        for (int l = 0; l < n; ++l) {
            along += X[l] * kept->s[l] * a[l];
            across += X[l] * kept->s[l] * balance[l];
        }
        if (r < node->rank) out[r] = along;
        out[node->rank + r] = across;
    }
}

void mbsri_kept_rates(const mbsri_kept *kept, const mbsri_node *node, int n, const double *own,
                      double *u, double *a)
{
    if (!node->deep) {
        mbsri_copy((size_t)n, own, u);
        return;
    }
    mbsri_zero((size_t)n, u);
    mbsri_zero((size_t)n, a);
    for (int r = 0; r < n; ++r) {
        const double *X = kept->X + r * n;
        for (int l = 0; l < n; ++l) {
            u[l] += kept->s[l] * X[l] * own[r];
            if (r < node->rank) a[l] += *kept->unit * kept->s[l] * X[l] * own[n + r];
        }
    }
}
