/* A reference integrator: Radau IIA of order 5 with fixed step, for any form of the equations.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The stage derivatives K_i satisfy
 *
 *   F(t + c_i h, y + h sum_j a_ij K_j, K_i) = 0,      i = 1, 2, 3
 *
 * solved by Newton steps with a new matrix in each: for index 2, an old one, or that of one stage
 * for all, does not converge. */
#include "radau.h"

#include "bench.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { STAGES = 3, HALVINGS = 10, ITERATIONS = 10 };

typedef struct radau {
    const mbsr_model *m;
    mbsr_data *d;
    mbsr_dae_form form;
    int n, size; /* of y; of K */
    double c[STAGES], a[STAGES][STAGES];
    double t, h, *y;            /* at the beginning of the step */
    double *K, *F, *Y, *change; /* size, size, n, n */
    double *Fy, *Fyp, *LU;      /* n x n, n x n, size x size, by rows */
    int *pivot;
} radau;

static void set_coefficients(radau *r)
{
    const double s = sqrt(6.0);
    const double c[STAGES] = {(4.0 - s) / 10.0, (4.0 + s) / 10.0, 1.0};
    const double a[STAGES][STAGES] = {
        {(88.0 - 7.0 * s) / 360.0, (296.0 - 169.0 * s) / 1800.0, (-2.0 + 3.0 * s) / 225.0},
        {(296.0 + 169.0 * s) / 1800.0, (88.0 + 7.0 * s) / 360.0, (-2.0 - 3.0 * s) / 225.0},
        {(16.0 - s) / 36.0, (16.0 + s) / 36.0, 1.0 / 9.0}};
    memcpy(r->c, c, sizeof c);
    memcpy(r->a, a, sizeof a);
}

static void residual(radau *r, double t, const double *y, const double *yp, double *F)
{
    bench_check(mbsr_dae_residual(r->m, r->d, r->form, t, y, yp, F), "reference residual",
                mbsr_data_error(r->d)->text);
}

/* Y = y + h sum_j a_ij K_j */
static void stage_state(radau *r, int i)
{
    memcpy(r->Y, r->y, (size_t)r->n * sizeof(double));
    for (int k = 0; k < r->size; ++k) r->Y[k % r->n] += r->h * r->a[i][k / r->n] * r->K[k];
}

/* Column k of dF/dY or dF/dK at stage i, by central differences in x[k]; x is Y or K_i. F is linear
 * in y', for which steps may be large. */
static void difference(radau *r, int i, double *x, int k, double *J)
{
    const double relative = x == r->Y ? 1e-5 : 1.0, t = r->t + r->c[i] * r->h;
    const double held = x[k], step = relative * fmax(1.0, fabs(held));
    x[k] = held + step;
    residual(r, t, r->Y, r->K + i * r->n, r->F);
    x[k] = held - step;
    residual(r, t, r->Y, r->K + i * r->n, r->change);
    x[k] = held;
    for (int row = 0; row < r->n; ++row)
        J[row * r->n + k] = (r->F[row] - r->change[row]) / (2.0 * step);
}

/* LU = P A with rows exchanged for the largest pivot. */
static void factor(radau *r)
{
    const int n = r->size;
    for (int k = 0; k < n; ++k) {
        int best = k;
        for (int i = k + 1; i < n; ++i) {
            if (fabs(r->LU[i * n + k]) > fabs(r->LU[best * n + k])) best = i;
        }
        r->pivot[k] = best;
        for (int j = 0; j < n; ++j) {
            const double held = r->LU[k * n + j];
            r->LU[k * n + j] = r->LU[best * n + j];
            r->LU[best * n + j] = held;
        }
        if (r->LU[k * n + k] == 0.0) bench_check(MBSR_NO_CONVERGENCE, "singular matrix", NULL);
        for (int i = k + 1; i < n; ++i) {
            const double l = r->LU[i * n + k] /= r->LU[k * n + k];
            for (int j = k + 1; j < n; ++j) r->LU[i * n + j] -= l * r->LU[k * n + j];
        }
    }
}

static void solve(const radau *r, double *x)
{
    const int n = r->size;
    for (int k = 0; k < n; ++k) {
        const double held = x[k];
        x[k] = x[r->pivot[k]];
        x[r->pivot[k]] = held;
    }
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < i; ++j) x[i] -= r->LU[i * n + j] * x[j];
    }
    for (int i = n - 1; i >= 0; --i) {
        for (int j = i + 1; j < n; ++j) x[i] -= r->LU[i * n + j] * x[j];
        x[i] /= r->LU[i * n + i];
    }
}

/* Block (i, j) = h a_ij dF/dy + delta_ij dF/dy' at stage i. */
static void make_matrix(radau *r)
{
    const int n = r->n;
    for (int i = 0; i < STAGES; ++i) {
        stage_state(r, i);
        for (int k = 0; k < n; ++k) {
            difference(r, i, r->Y, k, r->Fy);
            difference(r, i, r->K + i * n, k, r->Fyp);
        }
        for (int k = 0; k < n * r->size; ++k) {
            const int row = k / r->size, column = k % r->size, j = column / n;
            const int at = row * n + column % n;
            r->LU[i * n * r->size + k] =
                r->h * r->a[i][j] * r->Fy[at] + (i == j ? r->Fyp[at] : 0.0);
        }
    }
    factor(r);
}

/* One Newton step; the largest change of h K. */
static double improve(radau *r)
{
    double largest = 0.0;
    for (int i = 0; i < STAGES; ++i) {
        stage_state(r, i);
        residual(r, r->t + r->c[i] * r->h, r->Y, r->K + i * r->n, r->F + i * r->n);
    }
    solve(r, r->F);
    for (int k = 0; k < r->size; ++k) {
        r->K[k] -= r->F[k];
        largest = fmax(largest, fabs(r->h * r->F[k]));
    }
    return largest;
}

/* A step of length h from y, with K of the step before as first guess. Newton's method gains more
 * than four decimals a step at the end, down to rounding: that of y, divided by h for index 2. */
static void step(radau *r)
{
    const double small = 1e-11, rounding = 1e-8;
    double *last = r->K + (STAGES - 1) * r->n, before = INFINITY, size = INFINITY;
    for (int i = 0; i + 1 < STAGES; ++i)
        memcpy(r->K + i * r->n, last, (size_t)r->n * sizeof(double));
    for (int count = 0; !(size <= small || (size < rounding && size > 0.1 * before)); ++count) {
        if (count == ITERATIONS) bench_check(MBSR_NO_CONVERGENCE, "reference", NULL);
        make_matrix(r);
        before = size;
        size = improve(r);
    }
    for (int k = 0; k < r->size; ++k) r->y[k % r->n] += r->h * r->a[STAGES - 1][k / r->n] * r->K[k];
    r->t += r->h;
}

void radau_integrate(const mbsr_model *model, mbsr_data *data, mbsr_dae_form form, double T,
                     long steps, double *y, double *yp)
{
    const int n = mbsr_dae_size(model, form), size = STAGES * n;
    const size_t doubles = (size_t)(2 * size + 2 * n + 2 * n * n + size * size);
    radau r = {.m = model, .d = data, .form = form, .n = n, .size = size, .y = y};
    set_coefficients(&r);
    r.K = bench_allocate(doubles, sizeof(double));
    r.F = r.K + size;
    r.Y = r.F + size;
    r.change = r.Y + n;
    r.Fy = r.change + n;
    r.Fyp = r.Fy + n * n;
    r.LU = r.Fyp + n * n;
    r.pivot = bench_allocate((size_t)size, sizeof(int));
    double *last = r.K + (STAGES - 1) * n;
    memcpy(last, yp, (size_t)n * sizeof(double));
    for (int k = -HALVINGS; k <= 0; ++k) {
        r.h = ldexp(T / (double)steps, k > -HALVINGS ? k - 1 : -HALVINGS);
        step(&r);
    }
    r.h = T / (double)steps;
    for (long k = 1; k < steps; ++k) {
        r.t = (double)k * r.h;
        step(&r);
    }
    memcpy(yp, last, (size_t)n * sizeof(double));
    free(r.pivot);
    free(r.K);
}
