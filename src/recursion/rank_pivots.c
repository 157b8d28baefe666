/* The rank of a joint block by Cholesky's pivots: see rank_pivots.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * With the largest pivots first, A = S D S has after so many of them
 *
 *   P^T A P = [ L ; L' ] [ L ; L' ]^T + [ 0 0 ; 0 R ]
 *
 * and between its eigenvalues and those of parts of it (Cauchy's interlacing)
 *
 *   lambda_kept >= lambda_min(L L^T) >= 1 / ||(L L^T)^-1||,     |lambda_dropped| <= ||R||
 *
 * So where the former is beyond what is known to nine digits and the latter is nothing, or as small
 * as it has to be beside the usual rank (rank_rule.h), the eigenvalues would say the same, at ten
 * times the work. The null space is spanned by the columns of N = W P [ -L^-T L'^T ; 1 ], and with
 * orthonormal X_dropped that span S^-1 N, S the one that counts (rank.c),
 *
 *   D^- = W P [ (L L^T)^-1 0 ; 0 0 ] P^T W,   D^+ = S Q S^-1 D^- S^-1 Q S,
 *       Q = 1 - X_dropped X_dropped^T
 *
 * where W is the S with which was judged. */
#include "recursion/rank_pivots.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "recursion/errors.h"
#include "recursion/rank.h"

#include <math.h>

/* In the scratch of the data: A (n x n) by the order of the pivots, L (n x n), Y (n x n) with the
 * row l of L^-1 as its column l, N (n x n); vectors of n. */
typedef struct pivots {
    int n, rank;
    int *order;
    double *A, *L, *Y, *N, *diagonal, *size;
} pivots;

static pivots pivots_in_scratch(mbsr_data *d, int n)
{
    const size_t nn = (size_t)n * (size_t)n;
    pivots p = {.n = n, .order = d->pivots, .A = d->scratch};
    p.L = p.A + nn, p.Y = p.L + nn, p.N = p.Y + nn, p.diagonal = p.N + nn, p.size = p.diagonal + n;
    return p;
}

static void exchange_numbers(double *a, double *b)
{
    const double kept = *a;
    *a = *b;
    *b = kept;
}

/* Pivot k changes places with pivot l > k. */
static void exchange_pivots(pivots *p, int k, int l)
{
    const int n = p->n, kept = p->order[k];
    p->order[k] = p->order[l];
    p->order[l] = kept;
    exchange_numbers(p->diagonal + k, p->diagonal + l);
    for (int j = 0; j < n; ++j) exchange_numbers(p->A + k * n + j, p->A + l * n + j);
    for (int j = 0; j < n; ++j) exchange_numbers(p->A + j * n + k, p->A + j * n + l);
    for (int j = 0; j < k; ++j) exchange_numbers(p->L + j * n + k, p->L + j * n + l);
}

/* y (rows) -= the first c columns of L, from a row on, times the entries of that row */
static void subtract_columns(const pivots *p, int row, int c, double *y)
{
    const int n = p->n, rows = n - row;
    const double *a = p->L + row;
    int l = 0;
    for (; l < c - 1; l += 2)
        mbsri_add_two_long(rows, a + l * n, -a[l * n], a + (l + 1) * n, -a[(l + 1) * n], y);
    if (l < c) mbsri_ax(rows, 1, -a[l * n], a + l * n, &(double){1.0}, y);
}

/* L and the order of the pivots, as long as they are above `least`. */
static void factorise_by_pivots(pivots *p, double least)
{
    const int n = p->n;
    for (int k = 0; k < n; ++k) p->order[k] = k, p->diagonal[k] = p->A[k * (n + 1)];
    for (p->rank = 0; p->rank < n; ++p->rank) {
        const int k = p->rank;
        int best = k;
        for (int l = k + 1; l < n; ++l) best = p->diagonal[l] > p->diagonal[best] ? l : best;
        if (!(p->diagonal[best] > least)) return;
        if (best != k) exchange_pivots(p, k, best);
        double *column = p->L + k * n;
        mbsri_zero((size_t)k, column);
        mbsri_copy((size_t)(n - k), p->A + k * n + k, column + k);
        subtract_columns(p, k, k, column + k);
        if (!(column[k] > least)) return;
        const double pivot = sqrt(column[k]);
        for (int l = k; l < n; ++l) column[l] /= pivot;
        for (int l = k + 1; l < n; ++l) p->diagonal[l] -= column[l] * column[l];
    }
}

/* ||R||; the columns of A that are left are overwritten. */
static double norm_of_remainder(const pivots *p)
{
    const int n = p->n;
    double squares = 0.0;
    for (int k = p->rank; k < n; ++k) {
        double *column = p->A + k * n + k;
        subtract_columns(p, k, p->rank, column);
        for (int l = 0; l < n - k; ++l) squares += (l > 0 ? 2.0 : 1.0) * column[l] * column[l];
    }
    return sqrt(squares);
}

/* Y */
static void invert_pivots(const pivots *p)
{
    const int n = p->n;
    for (int l = 0; l < p->rank; ++l) {
        double *row = p->Y + l * n;
        mbsri_zero((size_t)n, row);
        row[l] = 1.0;
        int j = 0;
        for (; j < l - 1; j += 2)
            mbsri_add_two_long(j + 2, p->Y + j * n, -p->L[j * n + l], p->Y + (j + 1) * n,
                               -p->L[(j + 1) * n + l], row);
        if (j < l) mbsri_ax(j + 1, 1, -p->L[j * n + l], p->Y + j * n, &(double){1.0}, row);
        for (int k = 0; k <= l; ++k) row[k] /= p->L[l * (n + 1)];
    }
}

/* The lower triangle of (L L^T)^-1 into that of A, whose columns of pivots are done with. */
static void multiply_inverse(const pivots *p)
{
    const int n = p->n;
    for (int j = 0; j < p->rank; ++j) mbsri_zero((size_t)(p->rank - j), p->A + j * (n + 1));
    for (int l = 0; l < p->rank; l += 2) {
        const double *y = p->Y + l * n, *z = l + 1 < p->rank ? y + n : y;
        const double share = z == y ? 0.0 : 1.0;
        const int last = z == y ? l : l + 1;
        for (int j = 0; j <= last; ++j)
            mbsri_add_two_long(last - j + 1, y + j, y[j], z + j, share * z[j], p->A + j * (n + 1));
    }
}

/* Whether what is kept is known, also where turned tensors count as errors (rank.c). */
static bool known(const mbsr_model *m, const mbsr_data *d, const mbsri_group *g, const pivots *p,
                  double least)
{
    const mbsri_body *b = m->body + g->member[0];
    double squares = 0.0, strict = 0.0, turned = 0.0, *share = p->size;
    for (int k = 0; k < p->n; ++k) {
        const double s = d->s[b->group.iu + p->order[k]],
                     part = mbsri_rotated_along(d, b, p->order[k]) * s * s;
        turned = fmax(turned, part);
        share[k] = 1.0 + part;
    }
    for (int j = 0; j < p->rank; ++j) {
        for (int k = j; k < p->rank; ++k) {
            const double entry = p->A[j * p->n + k], square = (k > j ? 2.0 : 1.0) * entry * entry;
            squares += square;
            strict += share[j] * square * share[k];
        }
    }
    return least * sqrt(squares) < 1.0 && (turned <= 9.0 || 0.1 * least * sqrt(strict) < 1.0);
}

/* Whether it is nothing, or small beside the usual rank. */
static bool negligible(const mbsr_model *m, const mbsri_group *g, const pivots *p, double noise)
{
    const mbsri_rank_rule rule = mbsri_rank_rule_of(m->rank_tolerance);
    const double left = norm_of_remainder(p);
    if (left == 0.0) return true;
    return m->body[g->member[0]].survey.rank == p->rank + 1 && left <= rule.tolerance * noise;
}

/* Null vectors by the order of the joint's rates into N (n x what is dropped), with s of W. */
static void null_vectors_of_pivots(const pivots *p, const double *s, double *N)
{
    const int n = p->n;
    for (int k = p->rank; k < n; ++k) {
        double *x = p->diagonal, *column = N + (k - p->rank) * n;
        mbsri_zero((size_t)n, x);
        for (int l = 0; l < p->rank; ++l)
            mbsri_ax(l + 1, 1, -p->L[l * n + k], p->Y + l * n, &(double){1.0}, x);
        x[k] = 1.0;
        for (int l = 0; l < n; ++l) column[p->order[l]] = s[p->order[l]] * x[l];
    }
}

/* X of what is kept, by the s that counts, w being s of W; size: the bound of the eigenvalues. */
static void keep_pivots(const pivots *p, const double *w, const double *s, double size, double *X)
{
    const int n = p->n;
    for (int l = 0; l < p->rank; ++l) {
        double *x = X + l * n;
        mbsri_zero((size_t)n, x);
        for (int k = 0; k <= l; ++k) {
            const int at = p->order[k];
            x[at] = p->Y[l * n + k] * sqrt(size) * w[at] / s[at];
        }
    }
}

/* Dinv = D^- */
static void invert_block(const pivots *p, const double *w, double *Dinv)
{
    const int n = p->n;
    for (int j = 0; j < n; ++j) {
        const int column = p->order[j];
        for (int k = j; k < n; ++k) {
            const int row = p->order[k];
            const double entry = k < p->rank ? w[row] * p->A[j * n + k] * w[column] : 0.0;
            Dinv[column * n + row] = Dinv[row * n + column] = entry;
        }
    }
}

/* Dinv <- (1 - a c^T) Dinv (1 - c a^T) with a = S x, c = S^-1 x;  a, c, v: n of work. */
static void project_inverse(int n, const double *s, const double *x, double *Dinv, double *a,
                            double *c, double *v)
{
    for (int k = 0; k < n; ++k) a[k] = s[k] * x[k], c[k] = x[k] / s[k];
    for (int k = 0; k < n; ++k) {
        const double part = mbsri_dot(n, c, Dinv + k * n);
        mbsri_ax(n, 1, -part, a, &(double){1.0}, Dinv + k * n);
    }
    mbsri_zero((size_t)n, v);
    mbsri_ax(n, n, 1.0, Dinv, c, v);
    for (int k = 0; k < n; ++k) mbsri_ax(n, 1, -a[k], v, &(double){1.0}, Dinv + k * n);
}

/* ||S D S|| */
static double size_of_scaled(int n, const double *s, const double *D)
{
    double squares = 0.0;
    for (int j = 0; j < n; ++j) {
        for (int k = 0; k < n; ++k) {
            const double entry = s[j] * D[j * n + k] * s[k];
            squares += entry * entry;
        }
    }
    return sqrt(squares);
}

bool mbsri_rank_by_pivots(const mbsr_model *m, mbsr_data *d, const mbsri_group *g)
{
    const int i = g->member[0], n = g->n;
    const mbsri_body *b = m->body + i;
    if (n < 2 || g->members > 1) return false;
    const mbsri_rank_rule rule = mbsri_rank_rule_of(m->rank_tolerance);
    double *s = d->s + b->group.iu, *X = d->X + b->nn, *D = d->D + b->nn, *Dinv = d->Dinv + b->nn,
           noise;
    const double scale = mbsri_equilibrate(m, d, g, &noise);
    if (!isfinite(scale)) return false;
    pivots p = pivots_in_scratch(d, n);
    for (int j = 0; j < n; ++j) {
        for (int k = 0; k < n; ++k) p.A[j * n + k] = s[j] * D[j * n + k] * s[k];
    }
    factorise_by_pivots(&p, rule.known * noise);
    invert_pivots(&p);
    multiply_inverse(&p);
    if (!known(m, d, g, &p, rule.known * noise)) return false;
    if (p.rank < n && !negligible(m, g, &p, noise)) return false;
    double *w = p.size;
    mbsri_copy((size_t)n, s, w);
    if (p.rank < n) {
        null_vectors_of_pivots(&p, w, p.N);
        if (p.rank > 0 && m->typical.inertia && !mbsri_given_scale(m, d, g))
            mbsri_copy((size_t)n, m->typical.inertia + g->ig, s);
        mbsri_null_columns(n, n - p.rank, s, p.N, X + p.rank * n);
    }
    const double size = size_of_scaled(n, s, D);
    keep_pivots(&p, w, s, size, X);
    for (int k = 0; k < n; ++k) d->lambda[b->group.iu + k] = k < p.rank ? size : 0.0;
    invert_block(&p, w, Dinv);
    for (int l = p.rank; l < n; ++l)
        project_inverse(n, s, X + l * n, Dinv, p.L, p.L + n, p.L + 2 * n);
    d->scale[b->scalar_offset] = scale;
    d->rank[i] = p.rank;
    return true;
}
