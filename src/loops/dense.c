/* Dense matrices of a model with closures, and solutions with them.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * K = [M -C^T; C 0] is equilibrated symmetrically, S K S with the largest entry of each row about
 * 1, so that units do not matter (what is nothing but rounding is zero before: rounding.h), and
 * decomposed by singular values. Its kernel is ker M and ker C in u, and ker C^T in lambda: from M
 * x = C^T y, C x = 0 follows x^T M x = 0. */
#include "loops/dense.h"

#include "algebra/dense.h"
#include "algebra/lapack.h"
#include "algebra/numbers.h"
#include "base/error.h"
#include "base/memory.h"
#include "loops/row_fronts.h"
#include "recursion/rounding.h"
#include "recursion/closures.h"
#include "recursion/mass_matrix.h"
#include "recursion/spans.h"

#include <math.h>

/* Singular values below this times the largest are zero. */
static const double SMALL = 1e-11;

static void find_spans(mbsri_dense *w)
{
    const mbsri_spans spans = mbsri_spans_of(w->m, NULL);
    for (int i = 1; i <= w->m->bodies; ++i) {
        const mbsri_body *b = w->m->body + i;
        for (int k = 0; k < b->n; ++k)
            w->span[b->u + k] = mbsri_coordinate_span(&spans, w->m, b, true, k);
    }
}

static int work_size(const mbsri_dense *w, int most)
{
    const int N = w->N > 0 ? w->N : 1, svd = mbsri_lapack_svd_work(N),
              gelsy = mbsri_lapack_gelsy_work(most > 0 ? most : 1, N);
    return svd > gelsy ? svd : gelsy;
}

static int no_memory_for_dense(const mbsri_dense *w)
{
    return mbsri_fail(&w->d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                      "%s: no memory for matrices of %d joint rates and %d rows of closures",
                      w->function, w->n, w->rows);
}

/* What so many arrays hold, one after the other, from `next` on; returns what is behind them. */
static double *place_arrays(int count, double **const *array, const size_t *length, double *next)
{
    for (int k = 0; k < count; ++k) {
        *array[k] = next;
        next += length[k];
    }
    return next;
}

static size_t sum_of(int count, const size_t *length)
{
    size_t total = 0;
    for (int k = 0; k < count; ++k) total += length[k];
    return total;
}

/* M has the memory of all of them. */
static int open_matrices(mbsri_dense *w)
{
    const size_t n = (size_t)w->n, rows = (size_t)w->rows, N = n + rows;
    const size_t most = (size_t)w->position_rows + n;
    const int lwork = work_size(w, (int)(most + rows));
    double **const array[] = {&w->M,        &w->C, &w->factor.K, &w->factor.U,
                              &w->factor.V, &w->A, &w->work};
    const size_t length[] = {n * n, rows * n, N * N, N * N, N * N, most * n, (size_t)lwork};
    const int count = (int)(sizeof length / sizeof length[0]);
    double *memory = mbsri_allocate(&w->m->allocator, sum_of(count, length) * sizeof(double));
    if (!memory) return no_memory_for_dense(w);
    (void)place_arrays(count, array, length, memory);
    w->lwork = lwork;
    return MBSR_OK;
}

static int open_arrays(mbsri_dense *w, const mbsr_model *m, mbsr_data *d, const char *function)
{
    *w = (mbsri_dense){.m = m,
                       .d = d,
                       .function = function,
                       .n = m->nu,
                       .rows = m->rows,
                       .position_rows = m->position_rows,
                       .N = m->nu + m->rows};
    const size_t n = (size_t)w->n, rows = (size_t)w->rows, N = n + rows, nq = (size_t)m->nq;
    const size_t gaps = (size_t)w->position_rows;
    double **const array[] = {&w->factor.scale,
                              &w->factor.sigma,
                              &w->factor.right,
                              &w->g,
                              &w->x,
                              &w->y,
                              &w->q,
                              &w->q_beside,
                              &w->free,
                              &w->b,
                              &w->out,
                              &w->span};
    const size_t length[] = {N, N, N, N, N, N, nq, nq, 3 * n, gaps + n + n, N, n};
    const int count = (int)(sizeof length / sizeof length[0]);
    w->memory = mbsri_allocate(&m->allocator, sum_of(count, length) * sizeof(double) +
                                                  (N + 1) * sizeof(int) + 4 * rows * sizeof(bool));
    if (!w->memory) return no_memory_for_dense(w);
    w->factor.pivots = (int *)(void *)place_arrays(count, array, length, w->memory);
    w->other = (bool *)(w->factor.pivots + N + 1);
    w->left_out = w->other + rows;
    w->beside = w->left_out + rows;
    find_spans(w);
    return mbsri_closer_open(&w->closer, m, d, function);
}

int mbsri_dense_open(mbsri_dense *w, const mbsr_model *m, mbsr_data *d, const char *function)
{
    const int status = open_arrays(w, m, d, function);
    return status ? status : open_matrices(w);
}

int mbsri_dense_open_ranks(mbsri_dense *w, const mbsr_model *m, mbsr_data *d, bool rigid,
                           const char *function)
{
    if (!rigid && mbsri_any_stiff(m)) return mbsri_dense_open(w, m, d, function);
    const int status = open_arrays(w, m, d, function);
    return status ? status : mbsri_row_fronts_open(m, d, w->span, function, &w->fronts);
}

static void close_fronts(mbsri_dense *w)
{
    if (w->fronts) mbsri_row_fronts_close(w->fronts);
    w->fronts = NULL;
}

int mbsri_dense_leave_fronts(mbsri_dense *w)
{
    const int status = open_matrices(w);
    if (!status) close_fronts(w);
    return status;
}

void mbsri_dense_close(mbsri_dense *w)
{
    close_fronts(w);
    mbsri_closer_close(&w->closer);
    mbsri_release(&w->m->allocator, w->M);
    mbsri_release(&w->m->allocator, w->memory);
    w->memory = w->M = NULL;
}

int mbsri_dense_rows(mbsri_dense *w)
{
    const mbsri_closure *first = mbsri_all_closures(w->m);
    const int status = mbsri_closure_jacobians(w->m, w->d);
    if (status || w->fronts) return status;
    const double lever = mbsri_longest_lever(w->m, w->d);
    mbsri_zero((size_t)w->rows, w->g);
    for (const mbsri_closure *c = first; c < first + w->m->closures.count; ++c) {
        for (int k = 0; k < c->rows; ++k) {
            const size_t row = (size_t)(c->row + k);
            w->g[row] = 1.0;
            mbsri_closure_transpose(w->m, w->d, w->g, w->y);
            w->g[row] = 0.0;
            mbsri_clear_row(w->m, w->d, c, k, lever, w->factor.right, w->y);
            for (int j = 0; j < w->n; ++j) w->C[(size_t)j * (size_t)w->rows + row] = w->y[j];
        }
    }
    return MBSR_OK;
}

/* Coordinates that stay have an inertia of their own and a part in nothing else. */
static void keep(mbsri_dense *w, const int *stays)
{
    const size_t n = (size_t)w->n, N = (size_t)w->N;
    for (size_t j = 0; j < n && stays; ++j) {
        if (!stays[j]) continue;
        const double inertia = w->factor.K[j * (N + 1)];
        for (size_t k = 0; k < N; ++k) w->factor.K[j * N + k] = w->factor.K[k * N + j] = 0.0;
        w->factor.K[j * (N + 1)] = inertia > 0.0 ? inertia : 1.0;
    }
}

static void fill_rows(mbsri_dense *w, const bool *dropped)
{
    const size_t n = (size_t)w->n, rows = (size_t)w->rows, N = n + rows;
    mbsri_zero(N * N, w->factor.K);
    for (size_t j = 0; j < n; ++j) {
        mbsri_copy(n, w->M + j * n, w->factor.K + j * N);
        for (size_t k = 0; k < rows; ++k) {
            if (dropped && dropped[k]) continue;
            const double c = w->C[j * rows + k];
            w->factor.K[j * N + n + k] = c;
            w->factor.K[(n + k) * N + j] = -c;
        }
    }
    for (size_t k = 0; k < rows; ++k) {
        if (dropped && dropped[k]) w->factor.K[(n + k) * N + n + k] = 1.0;
    }
}

/* Scales to begin with, in which no units are left: joint rates over their spans, the largest
 * inertia 1, the largest entry of each row 1. */
static void begin_scales(mbsri_dense *w)
{
    const size_t N = (size_t)w->N, n = (size_t)w->n;
    double inertia = 0.0;
    for (size_t j = 0; j < n; ++j)
        inertia = fmax(inertia, w->factor.K[j * (N + 1)] * w->span[j] * w->span[j]);
    const double unit = inertia > 0.0 ? sqrt(inertia) : 1.0;
    for (size_t j = 0; j < n; ++j) w->factor.scale[j] = w->span[j] / unit;
    for (size_t k = n; k < N; ++k) {
        double largest = fabs(w->factor.K[k * (N + 1)]); /* 1 for a row that is left out */
        for (size_t j = 0; j < n; ++j)
            largest = fmax(largest, fabs(w->factor.K[j * N + k]) * w->factor.scale[j]);
        w->factor.scale[k] = largest > 0.0 ? 1.0 / largest : 1.0;
    }
}

/* S K S, a few sweeps; rows of zeros keep their spans. */
static void equilibrate(mbsri_dense *w)
{
    const size_t N = (size_t)w->N;
    begin_scales(w);
    for (size_t j = 0; j < N; ++j) {
        for (size_t k = 0; k < N; ++k)
            w->factor.K[j * N + k] *= w->factor.scale[j] * w->factor.scale[k];
    }
    for (int sweep = 0; sweep < 5; ++sweep) {
        for (size_t k = 0; k < N; ++k) {
            double largest = 0.0;
            for (size_t j = 0; j < N; ++j) largest = fmax(largest, fabs(w->factor.K[j * N + k]));
            w->factor.right[k] = largest > 0.0 ? 1.0 / sqrt(largest) : 1.0;
        }
        for (size_t j = 0; j < N; ++j) {
            for (size_t k = 0; k < N; ++k)
                w->factor.K[j * N + k] *= w->factor.right[j] * w->factor.right[k];
            w->factor.scale[j] *= w->factor.right[j];
        }
    }
}

/* Vectors of the kernel, from the last column of V on: those of its part in u, orthonormal, then
 * those of its part in lambda. The kernel is the sum of both, so that its vectors have parts in u
 * with singular values 1 and 0. */
static void split_kernel(mbsri_dense *w)
{
    const int n = w->n, N = w->N;
    for (w->factor.moving = 0; w->factor.moving < w->factor.nulls; ++w->factor.moving) {
        double *next = w->factor.V + (size_t)(N - 1 - w->factor.moving) * (size_t)N, *best = next,
               largest = 0.0;
        for (int l = w->factor.moving; l < w->factor.nulls; ++l) {
            double *v = w->factor.V + (size_t)(N - 1 - l) * (size_t)N;
            const double square = mbsri_dot(n, v, v);
            if (square > largest) largest = square, best = v;
        }
        if (!(largest > 1e-6)) return;
        for (int k = 0; k < N; ++k) {
            const double entry = best[k];
            best[k] = next[k];
            next[k] = k < n ? entry / sqrt(largest) : 0.0;
        }
        for (int l = w->factor.moving + 1; l < w->factor.nulls; ++l) {
            double *v = w->factor.V + (size_t)(N - 1 - l) * (size_t)N;
            const double part = mbsri_dot(n, next, v);
            for (int k = 0; k < n; ++k) v[k] -= part * next[k];
        }
    }
}

int mbsri_dense_factor(mbsri_dense *w, const bool *dropped, const int *stays)
{
    const int status = mbsri_dense_rows(w);
    if (status) return status;
    mbsri_mass_matrix(w->m, w->d, w->M);
    mbsri_clear_masses(w->m, w->d, w->M);
    fill_rows(w, dropped);
    keep(w, stays);
    equilibrate(w);
    w->factor.nulls = w->factor.moving = 0;
    if (w->N == 0) return MBSR_OK;
    for (int k = 0; k < w->N; ++k) {
        if (!(w->factor.scale[k] > 0.0 && isfinite(w->factor.scale[k])))
            return mbsri_fail(&w->d->error, MBSR_NOT_FINITE, MBSR_NONE, MBSR_NONE,
                              "%s: squares of lengths or masses of %s are beyond all numbers",
                              w->function, k < w->n ? "joint rates" : "rows of closures");
    }
    if (mbsri_lapack_svd(w->N, w->factor.K, w->factor.sigma, w->factor.U, w->factor.V, w->work,
                         w->lwork))
        return mbsri_fail(&w->d->error, MBSR_EIGEN_FAILED, MBSR_NONE, MBSR_NONE,
                          "%s: no singular values of the equations of the loops", w->function);
    while (w->factor.nulls < w->N &&
           !(w->factor.sigma[w->N - 1 - w->factor.nulls] > SMALL * w->factor.sigma[0]))
        ++w->factor.nulls;
    split_kernel(w);
    return MBSR_OK;
}

void mbsri_dense_solve(const mbsri_dense *w, const double *right, double *x)
{
    const size_t N = (size_t)w->N;
    double *scaled = w->factor.right;
    for (size_t k = 0; k < N; ++k) scaled[k] = w->factor.scale[k] * right[k];
    mbsri_zero(N, x);
    for (int l = 0; l < w->N - w->factor.nulls; ++l) {
        const double *u = w->factor.U + (size_t)l * N, *v = w->factor.V + (size_t)l * N;
        const double part = mbsri_dot(w->N, u, scaled) / w->factor.sigma[l];
        for (size_t k = 0; k < N; ++k) x[k] += part * v[k];
    }
    for (size_t k = 0; k < N; ++k) x[k] *= w->factor.scale[k];
}

void mbsri_dense_null(const mbsri_dense *w, int l, double *x)
{
    const double *v = w->factor.V + (size_t)(w->N - 1 - l) * (size_t)w->N;
    double largest = 0.0;
    for (int k = 0; k < w->n; ++k) {
        x[k] = w->factor.scale[k] * v[k];
        largest = fmax(largest, fabs(x[k]) / w->span[k]);
    }
    for (int k = 0; k < w->n && largest > 0.0; ++k) x[k] /= largest;
}

void mbsri_dense_idle(const mbsri_dense *w, int l, double *x)
{
    const size_t n = (size_t)w->n;
    const double *v = w->factor.V + (size_t)(w->N - 1 - w->factor.moving - l) * (size_t)w->N + n;
    for (int k = 0; k < w->rows; ++k) x[k] = w->factor.scale[n + (size_t)k] * v[k];
}
