/* Dense equations of motion of mechanisms of everything at once: see medley_equations.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "medley_equations.h"

#include "algebra/lapack.h"
#include "expect.h"

#include <mbsrank/driver.h>

#include <stdlib.h>
#include <string.h>

/* Which rows are rigid, and the rounding of gaps as a force. */
static void sort_rows(const medley *s, medley_equations *e)
{
    double most = 0.0;
    for (int c = 0; c < mbsr_model_closures(s->m); ++c) {
        int row, rows;
        assert_ok(mbsr_closure_indices(s->m, c, &row, &rows, NULL, NULL), NULL);
        for (int k = 0; k < rows; ++k) {
            const double stiffness = mbsr_closure_stiffness(s->m, c, k);
            e->rigid[row + k] = !(stiffness > 0.0);
            e->m += e->rigid[row + k];
            most = fmax(most, stiffness);
        }
    }
    e->noise = 1e-15 * most * (1.0 + test_largest(s->nq, s->q));
}

/* Of all rows (rows x n) the rigid ones. */
static void take_rows(const medley *s, const double *all, const double *bias, medley_equations *e)
{
    for (int k = 0, to = 0; k < s->rows; ++k) {
        if (!e->rigid[k]) continue;
        e->bias[to] = bias[k];
        for (int j = 0; j < e->n; ++j) {
            const double entry = all[j * s->rows + k];
            e->C[j * e->m + to] = fabs(entry) > 1e-14 ? entry : 0.0;
        }
        ++to;
    }
}

void medley_find_equations(const medley *s, medley_equations *e)
{
    const size_t n = (size_t)s->nu, r = (size_t)s->rows;
    double *zero = calloc(n + r + n * r + 1, sizeof *zero), *bias = zero + n, *all = bias + r;
    *e = (medley_equations){.n = s->nu};
    e->M = calloc(n * n + n * r + 2 * (n + r) + 1, sizeof *e->M);
    e->C = e->M + n * n;
    e->g = e->C + n * r;
    e->bias = e->g + n;
    e->x = e->bias + r;
    e->rigid = calloc(r + 1, sizeof *e->rigid);
    const mbsr_error *error = mbsr_data_error(s->d);
    assert_ok(mbsr_inverse_dynamics(s->m, s->d, s->t, s->q, s->u, zero, NULL, e->g), error);
    for (size_t k = 0; k < n; ++k) e->g[k] = -e->g[k];
    for (size_t k = 0; k < n; ++k) {
        zero[k] = 1.0;
        assert_ok(mbsr_closures_apply(s->m, s->d, zero, all + k * r), error);
        zero[k] = 0.0;
    }
    assert_ok(mbsr_closures_bias(s->m, s->d, bias), error);
    assert_ok(mbsr_mass_matrix(s->m, s->d, e->M), error);
    sort_rows(s, e);
    take_rows(s, all, bias, e);
    e->N = e->n + e->m;
    free(zero);
}

void medley_free_equations(medley_equations *e)
{
    free(e->M);
    free(e->rigid);
}

/* x from K = U sigma V^T. */
static void divide(medley_equations *e, const double *U, const double *sigma, const double *V,
                   const double *right)
{
    const int N = e->N;
    memset(e->x, 0, (size_t)N * sizeof *e->x);
    e->clear = true;
    e->moves = false;
    e->left = 0.0;
    e->worst = 1.0;
    for (int l = 0; l < N; ++l) {
        const double *u = U + l * N, *v = V + l * N;
        double part = 0.0;
        for (int k = 0; k < N; ++k) part += u[k] * right[k];
        if (sigma[l] > 1e-4) {
            e->worst = sigma[l] / sigma[0];
            for (int k = 0; k < N; ++k) e->x[k] += part / sigma[l] * v[k];
            continue;
        }
        e->clear = e->clear && sigma[l] < 1e-13 * sigma[0];
        e->left = fmax(e->left, fabs(part));
        e->moves = e->moves || test_largest(e->n, v) > 1e-6;
    }
}

void medley_solve(medley_equations *e, const double *P, const double *g, const double *b)
{
    const int N = e->N, n = e->n, lwork = mbsri_lapack_svd_work(N);
    const size_t NN = (size_t)N * (size_t)N;
    double *K = calloc(3 * NN + 2 * (size_t)N + (size_t)lwork + 1, sizeof *K), *U = K + NN,
           *V = U + NN, *sigma = V + NN, *right = sigma + N, *work = right + N;
    for (int j = 0; j < n; ++j) {
        for (int i = 0; i < n; ++i) K[j * N + i] = P[j * n + i];
        for (int k = 0; k < e->m; ++k) {
            K[j * N + n + k] = e->C[j * e->m + k];
            K[(n + k) * N + j] = -e->C[j * e->m + k];
        }
    }
    for (int k = 0; k < n; ++k) right[k] = g[k];
    for (int k = 0; k < e->m; ++k) right[n + k] = b ? b[k] : 0.0;
    assert_int_equal(mbsri_lapack_svd(N, K, sigma, U, V, work, lwork), 0);
    divide(e, U, sigma, V, right);
    free(K);
}

double medley_forces_off(const medley *s, const medley_equations *e, const double *lambda,
                         double sign)
{
    double *rigid = calloc((size_t)(s->rows + s->nu) + 1, sizeof *rigid), *both = rigid + s->rows,
           off = 0.0;
    for (int k = 0; k < s->rows; ++k) rigid[k] = e->rigid[k] ? lambda[k] : 0.0;
    assert_ok(mbsr_closures_transpose(s->m, s->d, rigid, both), mbsr_data_error(s->d));
    for (int j = 0; j < e->n; ++j) {
        double sum = 0.0;
        for (int k = 0; k < e->m; ++k) sum += sign * e->C[j * e->m + k] * e->x[e->n + k];
        off = fmax(off, fabs(both[j] - sum));
    }
    free(rigid);
    return off;
}
