/* Blocks of several joints: see group.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "recursion/group.h"

#include "algebra/cholesky.h"
#include "algebra/dense.h"
#include "recursion/modal.h"

/* D_ab and D_ba from F (d x n_b) at member a. */
static void place_blocks(const mbsr_model *m, const mbsr_data *d, const mbsri_group *g, int a,
                         int b, const double *F, double *JY)
{
    const mbsri_body *row = m->body + a, *column = m->body + b;
    const int r = row->group.iu - g->ig, c = column->group.iu - g->ig;
    for (int k = 0; k < row->n; ++k) {
        for (int j = 0; j < column->n; ++j) {
            const double *f = F + (size_t)(j * row->d);
            const double entry = mbsri_rate_of(row, d->J + row->dn, k, f);
            JY[(c + j) * g->n + r + k] = entry;
            if (a != b) JY[(r + k) * g->n + c + j] = entry;
        }
    }
}

/* The off-diagonal part of a joint's own block (n x n of a matrix with `rows` rows) made symmetric.
 */
static void even_out(int n, int rows, double *own)
{
    for (int j = 0; j < n; ++j) {
        for (int l = 0; l < j; ++l) {
            const double mean = 0.5 * (own[j * rows + l] + own[l * rows + j]);
            own[j * rows + l] = own[l * rows + j] = mean;
        }
    }
}

/* Of one joint. */
static void own_products(const mbsr_data *d, const mbsri_body *b, const double *A, double *Y,
                         double *JY)
{
    const double *J = d->J + b->dn;
    for (int j = 0; j < b->n; ++j) {
        double *y = Y + (size_t)(j * b->d);
        mbsri_along_rate(b, A + b->dd, J, j, y);
        for (int k = 0; k < b->n; ++k) JY[j * b->n + k] = mbsri_rate_of(b, J, k, y);
    }
    even_out(b->n, b->n, JY);
}

void mbsri_group_products(const mbsr_model *m, const mbsr_data *d, const mbsri_group *g,
                          const double *A, double *Y, double *JY, double *work)
{
    const int head = g->member[0];
    if (g->members == 1) {
        own_products(d, m->body + head, A, Y, JY);
        return;
    }
    mbsri_zero((size_t)g->n * (size_t)g->n, JY);
    for (int k = g->members - 1; k >= 0; --k) {
        const mbsri_body *b = m->body + g->member[k];
        const size_t room = (size_t)m->most.d * (size_t)b->n;
        double *F = work, *next = F + room;
        /* F = A J */
        for (int j = 0; j < b->n; ++j)
            mbsri_along_rate(b, A + b->dd, d->J + b->dn, j, F + (size_t)(j * b->d));
        for (int a = g->member[k];; a = m->body[a].parent) {
            place_blocks(m, d, g, a, g->member[k], F, JY);
            if (a == head) break;
            /* F <- -H^T F */
            const mbsri_body *at = m->body + a;
            mbsri_zero((size_t)(at->pred.d * b->n), next);
            mbsri_atb(at->d, at->pred.d, b->n, -1.0, d->H + at->dp, F, next);
            double *swap = F;
            F = next, next = swap;
        }
        mbsri_copy((size_t)(m->body[head].d * b->n), F,
                   Y + (size_t)((b->group.iu - g->ig) * m->body[head].d));
    }
    for (int k = 0; k < g->members; ++k) {
        const mbsri_body *b = m->body + g->member[k];
        even_out(b->n, g->n, JY + (size_t)(b->group.iu - g->ig) * (size_t)(g->n + 1));
    }
}

void mbsri_group_add_armature(const mbsr_model *m, const mbsri_group *g, double *D)
{
    for (int k = 0; k < g->members; ++k) {
        const mbsri_body *b = m->body + g->member[k];
        for (int l = 0; l < b->n; ++l)
            D[(b->group.iu - g->ig + l) * (g->n + 1)] += b->mass.armature[l];
    }
}

/* e -= J^T (b - C a) of several joints. */
static void load_members(const mbsr_model *m, const mbsr_data *d, const mbsri_group *g,
                         const double *b, const double *k, double *e, double *work)
{
    double *a[MBSRI_GROUP_MOST];
    for (int i = 0; i < g->members; ++i) {
        const mbsri_body *at = m->body + g->member[i];
        double *rest = work + (size_t)(g->members * m->most.d);
        a[i] = work + (size_t)(i * m->most.d);
        for (int l = 0; l < at->d; ++l) a[i][l] = -k[at->v + (size_t)l];
        for (int j = 0; j < i; ++j) {
            if (g->member[j] == at->parent)
                mbsri_ax(at->d, at->pred.d, -1.0, d->H + at->dp, a[j], a[i]);
        }
        mbsri_copy((size_t)at->d, b + at->v, rest);
        mbsri_ax(at->d, at->d, -1.0, d->Mbar + at->dd, a[i], rest);
        mbsri_atx(at->d, at->n, -1.0, d->J + at->dn, rest, e + at->group.iu - g->ig);
    }
}

void mbsri_group_load(const mbsr_model *m, const mbsr_data *d, int i, const double *b,
                      const double *k, double *e, double *sum, double *work)
{
    if (!mbsri_heads(m, d, i)) return;
    const mbsri_body *head = m->body + i;
    const mbsri_group g = mbsri_group_of(m, d, i);
    if (g.members > 1)
        load_members(m, d, &g, b, k, e, work);
    else
        mbsri_atx_often(head->d, head->n, -1.0, d->J + head->dn, sum, e);
    mbsri_ax_often(head->d, g.n, 1.0, d->G + head->dg, e, sum);
}

void mbsri_group_separate(const mbsr_model *m, const mbsr_data *d, const mbsri_group *g, double *x,
                          double *work)
{
    const size_t all = (size_t)g->n;
    double *A = work, *Y = A + all * all, *y = Y + all * all;
    mbsri_copy(all * all, d->D + m->body[g->member[0]].nn, A);
    for (int i = g->members - 1; i > 0; --i) {
        const mbsri_body *b = m->body + g->member[i];
        const int n = b->n, before = b->group.iu - g->ig;
        double L[MBSRI_GROUP_MOST * MBSRI_GROUP_MOST];
        if (d->rank[g->member[i]] < n) continue;
        for (int j = 0; j < n; ++j) {
            for (int k = 0; k < n; ++k) L[j * n + k] = A[(before + j) * g->n + before + k];
        }
        if (!mbsri_cholesky(n, L)) continue;
        /* Y = A_.j L^-T,  y = L^-1 x_j:  x -= Y y,  A -= Y Y^T */
        for (int j = 0; j < n; ++j) {
            for (int k = 0; k < before; ++k) Y[j * before + k] = A[(before + j) * g->n + k];
            y[j] = x[before + j];
        }
        mbsri_divide_by_cholesky(before, n, L, Y);
        mbsri_divide_by_cholesky(1, n, L, y);
        mbsri_ax(before, n, -1.0, Y, y, x);
        for (int c = 0; c < before; ++c) {
            for (int r = 0; r < before; ++r) {
                for (int k = 0; k < n; ++k)
                    A[c * g->n + r] -= Y[k * before + r] * Y[k * before + c];
            }
        }
    }
}

void mbsri_group_gather(const mbsr_model *m, const mbsri_group *g, const double *caller, double *x)
{
    for (int k = 0; k < g->members; ++k) {
        const mbsri_body *b = m->body + g->member[k];
        mbsri_copy((size_t)b->n, caller + b->u, x + b->group.iu - g->ig);
    }
}

void mbsri_group_scatter(const mbsr_model *m, const mbsri_group *g, const double *x, double *caller)
{
    for (int k = 0; k < g->members; ++k) {
        const mbsri_body *b = m->body + g->member[k];
        mbsri_copy((size_t)b->n, x + b->group.iu - g->ig, caller + b->u);
    }
}
