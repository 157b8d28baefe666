/* The Newton matrix of a DAE form by differences: see newton_system.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "newton_system.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

void dgesv_(const int *n, const int *nrhs, double *a, const int *lda, int *ipiv, double *b,
            const int *ldb, int *info);
void dgetrs_(const char *trans, const int *n, const int *nrhs, const double *a, const int *lda,
             const int *ipiv, double *b, const int *ldb, int *info, size_t trans_length);

int test_newton_start(test_newton_state *s, const mbsr_model *model, mbsr_data *data, double t,
                      const double *q, const double *u, mbsr_consistent_info *info)
{
    *s = (test_newton_state){.model = model,
                             .data = data,
                             .form = MBSR_DAE_MOMENTUM,
                             .t = t,
                             .nq = mbsr_model_nq(model),
                             .nu = mbsr_model_nu(model),
                             .n = mbsr_dae_size(model, MBSR_DAE_MOMENTUM)};
    const size_t n = (size_t)s->n;
    s->y = calloc(2 * n + 3 * n * n + 1, sizeof(double));
    s->yp = s->y + n;
    s->A = s->yp + n;
    s->B = s->A + n * n;
    s->D = s->B + n * n;
    const int status = mbsr_dae_pack(model, data, s->form, t, q, u, s->y);
    if (status) return status;
    return mbsr_dae_consistent(model, data, s->form, t, s->y, s->yp, NULL, info);
}

void test_newton_free(test_newton_state *s)
{
    free(s->y);
}

/* ---- the matrices ---- */

/* A model of the same equations, at which the residual is taken. */
typedef struct subject {
    const test_newton_state *s;
    const mbsr_model *model;
    mbsr_data *data;
} subject;

/* Derivative with respect to *x, a number of y or y', over steps of h: central differences of
 * eighth order. Their error of truncation is of the order of h^8, so that h may be long and the
 * residual's rounding errors, divided by h, stay small. */
static int column(const subject *at, const double *y, const double *yp, double *x, double h,
                  double *F, double *out)
{
    static const double weight[] = {4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0};
    const test_newton_state *s = at->s;
    const double held = *x;
    int status = MBSR_OK;
    memset(out, 0, (size_t)s->n * sizeof *out);
    for (int l = 0; l < 8 && !status; ++l) {
        const double side = l % 2 ? -1.0 : 1.0;
        *x = held + side * (l / 2 + 1) * h;
        status = mbsr_dae_residual(at->model, at->data, s->form, s->t, y, yp, F);
        for (int j = 0; j < s->n; ++j) out[j] += side * weight[l / 2] * F[j] / h;
    }
    *x = held;
    return status;
}

enum { LENGTHS = 4 };

static const double lengths[LENGTHS] = {1.6e-2, 4e-3, 1e-3, 2.5e-4};

static double length_of(const test_newton_state *s, int k, int l)
{
    return lengths[l] * (k < s->nq ? 1.0 : fmax(1.0, fabs(s->y[k])));
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Of the residual's number j, the size of its rounding errors: what the two shortest differences
 * disagree by, times the length, is that in most columns. The median; spare: n numbers. */
static double noise(const test_newton_state *s, double *const by[LENGTHS], int j, double *spare)
{
    int count = 0;
    for (int k = 0; k < s->n; ++k) {
        const int at = k * s->n + j;
        const double off = fabs(by[LENGTHS - 1][at] - by[LENGTHS - 2][at]);
        if (off > 0.0) spare[count++] = off * length_of(s, k, LENGTHS - 1);
    }
    if (count == 0) return 0.0;
    qsort(spare, (size_t)count, sizeof *spare, ascending);
    return spare[count / 2];
}

/* Column k from the length that agrees best with the next longer one, row by row in the size of the
 * row. What two lengths disagree by may be small by chance: rounding errors are added, but not to
 * entries that do not change at all. */
static void choose(test_newton_state *s, double *const by[LENGTHS], int k, const double *row,
                   const double *rounding)
{
    const int first = k * s->n;
    double least = INFINITY;
    int best = 1;
    for (int l = 1; l < LENGTHS; ++l) {
        double off = 0.0;
        for (int j = 0; j < s->n; ++j)
            off = fmax(off, fabs(by[l][first + j] - by[l - 1][first + j]) / row[j]);
        if (off < least) least = off, best = l;
    }
    s->roughness = fmax(s->roughness, least);
    for (int j = 0; j < s->n; ++j) {
        const double off = fabs(by[best][first + j] - by[best - 1][first + j]);
        s->A[first + j] = by[best][first + j];
        s->D[first + j] = off > 0.0 ? off + 2.0 * rounding[j] / length_of(s, k, best) : 0.0;
    }
}

static void choose_all(test_newton_state *s, double *const by[LENGTHS])
{
    const int n = s->n;
    double *row = calloc(3 * (size_t)n + 1, sizeof *row), *rounding = row + n,
           *spare = rounding + n;
    for (int j = 0; j < n; ++j) {
        for (int at = j; at < n * n; at += n) row[j] += fabs(by[1][at]) + fabs(s->B[at]);
        rounding[j] = noise(s, by, j, spare);
    }
    for (int k = 0; k < n; ++k) choose(s, by, k, row, rounding);
    free(row);
}

int test_newton_matrices(test_newton_state *s, const mbsr_model *model, mbsr_data *data)
{
    const subject at = {s, model, data};
    const size_t n = (size_t)s->n;
    double *y = calloc(3 * n + LENGTHS * n * n + 1, sizeof *y), *yp = y + n, *F = yp + n,
           *by[LENGTHS];
    int status = MBSR_OK;
    for (size_t l = 0; l < LENGTHS; ++l) by[l] = F + n + l * n * n;
    memcpy(y, s->y, n * sizeof *y);
    memcpy(yp, s->yp, n * sizeof *yp);
    for (size_t k = 0; k < n && !status; ++k) {
        for (int l = 0; l < LENGTHS && !status; ++l)
            status = column(&at, y, yp, y + k, length_of(s, (int)k, l), F, by[l] + k * n);
        /* F is linear in y' */
        if (!status) status = column(&at, y, yp, yp + k, fmax(1.0, fabs(yp[k])), F, s->B + k * n);
    }
    if (!status) choose_all(s, by);
    free(y);
    return status;
}

/* ---- errors ---- */

/* The dense system, its inverse and its solution; sums of what is added up in its rows, and what D
 * makes of x in them. */
typedef struct dense {
    int n;
    bool regular;
    double *matrix, *inverse, *expected, *sum, *doubt;
    int *pivots;
} dense;

/* Corrects the solution by its factors until nothing but rounding of its entries is left: rows and
 * columns of very different sizes, as a large c makes them, cost the plain one digits. */
static void refine(const test_newton_state *s, double c, const double *r, dense *e)
{
    enum { ROUNDS = 4 };
    const int n = e->n, one = 1;
    double *left = calloc((size_t)n + 1, sizeof *left);
    int info;
    for (int round = 0; round < ROUNDS && e->regular; ++round) {
        for (int j = 0; j < n; ++j) {
            long double sum = r[j];
            for (int k = 0; k < n; ++k)
                sum -= ((long double)s->A[k * n + j] + (long double)c * s->B[k * n + j]) *
                       e->expected[k];
            left[j] = (double)sum;
        }
        dgetrs_("N", &n, &one, e->matrix, &n, e->pivots, left, &n, &info, 1);
        for (int k = 0; k < n; ++k) e->expected[k] += left[k];
    }
    free(left);
}

static dense make_dense(const test_newton_state *s, double c, const double *r, const double *x)
{
    const int n = s->n, columns = n + 1;
    const size_t size = (size_t)n;
    dense e = {.n = n, .matrix = calloc(2 * size * size + 3 * size + 1, sizeof(double))};
    int info;
    e.inverse = e.matrix + size * size;
    e.expected = e.inverse + size * size; /* the last right-hand side */
    e.sum = e.expected + size;
    e.doubt = e.sum + size;
    e.pivots = calloc(size + 1, sizeof *e.pivots);
    for (int j = 0; j < n; ++j) {
        e.inverse[j * (n + 1)] = 1.0;
        e.expected[j] = r[j];
        e.sum[j] = fabs(r[j]);
        for (int k = 0; k < n; ++k) {
            const int at = k * n + j;
            e.matrix[at] = s->A[at] + c * s->B[at];
            e.sum[j] += (fabs(s->A[at]) + fabs(c * s->B[at])) * fabs(x[k]);
            e.doubt[j] += s->D[at] * fabs(x[k]);
        }
    }
    dgesv_(&n, &columns, e.matrix, &n, e.pivots, e.inverse, &n, &info);
    e.regular = info == 0;
    refine(s, c, r, &e);
    return e;
}

/* x solves (A + dA + c (B + dB)) x = r + dr exactly for changes of relative size `row` at most
 * (Oettli and Prager); such changes of size e move the solution by e |A^-1| (|A| |x| + |r|). */
static void rows(const test_newton_state *s, const dense *e, double c, const double *r,
                 const double *x, test_newton_errors *errors)
{
    for (int j = 0; j < e->n; ++j) {
        double defect = -r[j];
        for (int k = 0; k < e->n; ++k) {
            const int at = k * e->n + j;
            defect += (s->A[at] + c * s->B[at]) * x[k];
        }
        errors->row = fmax(errors->row, fabs(defect) / e->sum[j]);
        errors->net_row = fmax(errors->net_row, (fabs(defect) - e->doubt[j]) / e->sum[j]);
    }
}

/* Where q, p, u, Lambda and Eta begin. */
enum { KINDS = 5 };

static void find_kinds(const test_newton_state *s, int first[KINDS + 1])
{
    const int u = s->nq + s->nu, Lambda = u + s->nu, Eta = Lambda + mbsr_model_rows(s->model);
    const int all[] = {0, s->nq, u, Lambda, Eta, s->n};
    memcpy(first, all, sizeof all);
}

static void entries(const test_newton_state *s, const dense *e, const double *x,
                    test_newton_errors *errors)
{
    const int n = e->n, first[] = {0, s->nq, s->nq + s->nu, n};
    for (int kind = 0; kind < 3; ++kind) {
        double largest = 0.0, error = 0.0, net = 0.0, moved = 0.0;
        for (int k = first[kind]; k < first[kind + 1]; ++k) {
            const double off = fabs(x[k] - e->expected[k]);
            double doubt = 0.0, moves = 0.0;
            for (int j = 0; j < n; ++j) {
                doubt += fabs(e->inverse[j * n + k]) * e->doubt[j];
                moves += fabs(e->inverse[j * n + k]) * e->sum[j];
            }
            largest = fmax(largest, fabs(e->expected[k]));
            error = fmax(error, off);
            net = fmax(net, off - doubt);
            moved = fmax(moved, moves);
        }
        if (largest <= 0.0) continue;
        errors->delta = fmax(errors->delta, error / largest);
        errors->net_delta = fmax(errors->net_delta, net / largest);
        errors->amplification = fmax(errors->amplification, moved / largest);
    }
}

test_newton_errors test_newton_compare(const test_newton_state *s, double c, const double *r,
                                       const double *x)
{
    test_newton_errors errors = {0};
    dense e = make_dense(s, c, r, x);
    bool finite = e.regular;
    for (int k = 0; k < s->n; ++k) finite = finite && isfinite(x[k]);
    rows(s, &e, c, r, x, &errors);
    entries(s, &e, x, &errors);
    if (!finite) errors = (test_newton_errors){NAN, NAN, NAN, NAN, NAN};
    free(e.matrix);
    free(e.pivots);
    return errors;
}

double test_newton_product_error(const test_newton_state *s, double c, const double *x,
                                 const double *p, const double *r)
{
    double largest = 0.0;
    for (int j = 0; j < s->n; ++j) {
        double sum = 0.0, size = 0.0, doubt = 0.0;
        for (int k = 0; k < s->n; ++k) {
            const int at = k * s->n + j;
            sum += (s->A[at] + c * s->B[at]) * x[k];
            size += (fabs(s->A[at]) + fabs(c * s->B[at])) * fabs(x[k]);
            doubt += s->D[at] * fabs(x[k]);
        }
        const double off = r ? fabs(p[j] - r[j]) : fabs(p[j] - sum) - doubt;
        if (!isfinite(p[j])) return NAN;
        if (off > 0.0) largest = fmax(largest, off / (size + (r ? fabs(r[j]) : 0.0)));
    }
    return largest;
}

double test_newton_distance(const test_newton_state *s, const double *x, const double *y)
{
    int first[KINDS + 1];
    double distance = 0.0;
    find_kinds(s, first);
    for (int kind = 0; kind < KINDS; ++kind) {
        double largest = 0.0, off = 0.0;
        for (int k = first[kind]; k < first[kind + 1]; ++k) {
            if (!isfinite(x[k]) || !isfinite(y[k])) return NAN;
            largest = fmax(largest, fabs(x[k]));
            off = fmax(off, fabs(x[k] - y[k]));
        }
        if (off > 0.0) distance = fmax(distance, off / largest);
    }
    return distance;
}
