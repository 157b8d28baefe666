/* Oscillations about a state, without LAPACK.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Newton's derivatives A and E of the equations F(y, y') = 0 make the pencil A + s E. S = (A +
 * shift E)^-1 E, of which the columns of q and p count, has the eigenvalues 1 / (shift - s).
 * Infinite s are zeros of S, which rounding makes large s: with another shift they are others, and
 * so they are known. */
#include "modes.h"

#include <mbsrank/driver.h>
#include <mbsrank/newton.h>

#include <complex.h>
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST = 400 }; /* coordinates and momenta */

typedef double complex number;

/* To Hessenberg's form (columns of n), by elimination with pivots. */
static void reduce(int n, double *A)
{
    for (int m = 1; m < n - 1; ++m) {
        double *column = A + (m - 1) * n, *own = A + m * n;
        int pivot = m;
        for (int i = m + 1; i < n; ++i)
            if (fabs(column[i]) > fabs(column[pivot])) pivot = i;
        if (column[pivot] == 0.0) continue;
        for (int j = m - 1; j < n && pivot != m; ++j) {
            const double x = A[j * n + pivot];
            A[j * n + pivot] = A[j * n + m];
            A[j * n + m] = x;
        }
        for (int i = 0; i < n && pivot != m; ++i) {
            const double x = A[pivot * n + i];
            A[pivot * n + i] = own[i];
            own[i] = x;
        }
        for (int i = m + 1; i < n; ++i) {
            const double factor = column[i] / column[m];
            column[i] = 0.0;
            if (factor == 0.0) continue;
            for (int j = m; j < n; ++j) A[j * n + i] -= factor * A[j * n + m];
            for (int k = 0; k < n; ++k) own[k] += factor * A[i * n + k];
        }
    }
}

/* A step of the QR iteration in rows and columns first .. last. turn: two numbers a row. */
static void step(int n, number *H, int first, int last, number shift, number (*turn)[2])
{
    for (int k = first; k <= last; ++k) H[k * n + k] -= shift;
    for (int k = first; k < last; ++k) {
        const number a = H[k * n + k], b = H[k * n + k + 1];
        const double size = hypot(cabs(a), cabs(b));
        const number c = size > 0.0 ? a / size : 1.0, s = size > 0.0 ? b / size : 0.0;
        turn[k][0] = c;
        turn[k][1] = s;
        for (int j = k; j <= last; ++j) {
            number *x = H + j * n + k;
            const number top = conj(c) * x[0] + conj(s) * x[1];
            x[1] = c * x[1] - s * x[0];
            x[0] = top;
        }
    }
    for (int k = first; k < last; ++k) {
        const number c = turn[k][0], s = turn[k][1];
        number *x = H + k * n, *y = x + n;
        for (int i = first; i <= k + 1; ++i) {
            const number left = x[i] * c + y[i] * s;
            y[i] = y[i] * conj(c) - x[i] * conj(s);
            x[i] = left;
        }
    }
    for (int k = first; k <= last; ++k) H[k * n + k] += shift;
}

/* The eigenvalue of the last two rows that is next to the last entry. */
static number shift_of(const number *H, int n, int last)
{
    const number d = H[last * n + last], a = H[(last - 1) * n + last - 1],
                 product = H[last * n + last - 1] * H[(last - 1) * n + last], half = 0.5 * (a - d),
                 root = csqrt(half * half + product);
    const number one = half + root, other = half - root;
    const number away = cabs(one) > cabs(other) ? one : other;
    return away == 0.0 ? d : d - product / away;
}

/* Eigenvalues of a matrix of Hessenberg's form, which is lost; 0: they were not found. */
static int find_eigenvalues(int n, number *H, number *value, number (*turn)[2])
{
    enum { TIMES = 100 };
    for (int last = n - 1, times = 0; last >= 0;) {
        int first = last;
        for (; first > 0; --first) {
            const double beside = cabs(H[first * n + first]) + cabs(H[(first - 1) * n + first - 1]);
            if (cabs(H[(first - 1) * n + first]) <= DBL_EPSILON * beside) break;
        }
        if (first > 0) H[(first - 1) * n + first] = 0.0;
        if (first == last) {
            value[last] = H[last * n + last];
            --last;
            times = 0;
            continue;
        }
        if (++times > TIMES) return 0;
        number shift = shift_of(H, n, last);
        if (times % 12 == 0) shift = H[last * n + last] + cabs(H[(last - 1) * n + last]);
        step(n, H, first, last, shift, turn);
    }
    return 1;
}

typedef struct work {
    const mbsr_model *model;
    mbsr_data *data;
    mbsr_newton *newton;
    double t;
    int nq, nu, n, size;
    double *y, *yp, *x, *r, *mass, *S; /* size each; nu; n * n */
    number *H, *value;                 /* n * n; n */
    number (*turn)[2];
    mbsr_error *error;
} work;

static int fail(const work *w, const mbsr_error *why)
{
    *w->error = *why;
    return w->error->status;
}

static int refuse(const work *w, int status, const char *text)
{
    *w->error = (mbsr_error){status, MBSR_NONE, MBSR_NONE, ""};
    snprintf(w->error->text, sizeof w->error->text, "modes: %s", text);
    return status;
}

/* s of all eigenvalues of S, in `to`. */
static int find_rates(work *w, double shift, number *to)
{
    const int n = w->n;
    int status = mbsr_newton_linearise(w->newton, w->data, w->t, w->y, w->yp, shift);
    if (!status) status = mbsr_newton_factor(w->newton, w->data, w->t, w->y, w->yp, shift);
    for (int k = 0; k < n && !status; ++k) {
        double *column = w->S + k * n;
        const double unit = k < w->nq ? 1.0 : shift * w->mass[k - w->nq];
        memset(w->x, 0, (size_t)w->size * sizeof *w->x);
        w->x[k] = unit;
        status = mbsr_newton_multiply_rate(w->newton, w->x, w->r);
        if (!status) status = mbsr_newton_solve(w->newton, w->r, w->x);
        memcpy(column, w->x, (size_t)n * sizeof *column);
        for (int i = w->nq; i < n; ++i) column[i] /= shift * w->mass[i - w->nq];
    }
    if (status) return fail(w, mbsr_newton_error(w->newton));
    reduce(n, w->S);
    for (int k = 0; k < n * n; ++k) w->H[k] = w->S[k];
    if (!find_eigenvalues(n, w->H, to, w->turn))
        return refuse(w, MBSR_NO_CONVERGENCE, "eigenvalues are not found");
    for (int k = 0; k < n; ++k) to[k] = cabs(to[k]) > 0.0 ? shift - 1.0 / to[k] : HUGE_VAL;
    return MBSR_OK;
}

/* Those that swing and are the same at both shifts, slowest first. */
static int take(int n, const number *one, const number *other, double *to)
{
    int count = 0;
    for (int k = 0; k < n; ++k) {
        const double size = cabs(one[k]);
        double nearest = HUGE_VAL;
        if (!(cimag(one[k]) > 1e-5 * size) || !(size < HUGE_VAL)) continue;
        for (int i = 0; i < n; ++i) nearest = fmin(nearest, cabs(one[k] - other[i]));
        if (!(nearest <= 1e-5 * size)) continue;
        int at = count++;
        for (; at > 0 && hypot(to[2 * at - 2], to[2 * at - 1]) > size; --at)
            memcpy(to + 2 * at, to + 2 * at - 2, 2 * sizeof *to);
        to[2 * at] = creal(one[k]);
        to[2 * at + 1] = cimag(one[k]);
    }
    return count;
}

static int start(work *w, const double *q, const double *u)
{
    const mbsr_dae_form form = MBSR_DAE_MOMENTUM;
    int status = mbsr_dae_pack(w->model, w->data, form, w->t, q, u, w->y);
    if (!status)
        status = mbsr_dae_consistent(w->model, w->data, form, w->t, w->y, w->yp, NULL, NULL);
    if (!status) status = mbsr_dae_residual(w->model, w->data, form, w->t, w->y, w->yp, w->r);
    if (!status) status = mbsr_stage_backward(w->model, w->data);
    if (!status) status = mbsr_momentum_scales(w->model, w->data, w->mass);
    return status ? fail(w, mbsr_data_error(w->data)) : MBSR_OK;
}

int web_find_modes(const mbsr_model *model, mbsr_data *data, double t, const double *q,
                   const double *u, double **found, int *count, mbsr_error *error)
{
    static const double shift = 10.0; /* 1/s */
    work w = {.model = model, .data = data, .t = t, .error = error};
    mbsr_newton_opt opt = mbsr_default_newton_opt();
    w.nq = mbsr_model_nq(model);
    w.nu = mbsr_model_nu(model);
    w.n = w.nq + w.nu;
    w.size = mbsr_dae_size(model, MBSR_DAE_MOMENTUM);
    *found = NULL;
    *count = 0;
    if (w.n > MOST) return refuse(&w, MBSR_ERR_VALUE, "more than 400 coordinates and momenta");
    if (w.n == 0) return MBSR_OK;
    const size_t n = (size_t)w.n, size = (size_t)w.size;
    double *numbers = calloc(4 * size + n + n * n, sizeof *numbers);
    number *complex_numbers = calloc(n * n + 4 * n, sizeof *complex_numbers);
    *found = calloc(2 * n, sizeof **found);
    int status = numbers && complex_numbers && *found ? MBSR_OK
                                                      : refuse(&w, MBSR_ERR_NO_MEMORY, "no memory");
    if (!status) {
        w.y = numbers;
        w.yp = w.y + size;
        w.x = w.yp + size;
        w.r = w.x + size;
        w.mass = w.r + size;
        w.S = w.mass + n;
        w.H = complex_numbers;
        w.value = w.H + n * n;
        w.turn = (number(*)[2])(w.value + 2 * n);
        status = start(&w, q, u);
    }
    opt.products = 1;
    if (!status) status = mbsr_newton_create(model, MBSR_DAE_MOMENTUM, &opt, &w.newton, error);
    if (!status) status = find_rates(&w, shift, w.value);
    if (!status) status = find_rates(&w, 3.0 * shift, w.value + n);
    if (!status) *count = take(w.n, w.value, w.value + n, *found);
    mbsr_newton_destroy(w.newton);
    free(numbers);
    free(complex_numbers);
    if (status) {
        free(*found);
        *found = NULL;
    }
    return status;
}
