/* The routines of fortran.h in plain C, for builds without BLAS, LAPACK and Fortran. Each does what
 * this library asks of it, with the arguments that are named, leading dimensions as given:
 *
 *   dgemm   C = alpha op(A) B + beta C, A as it is or transposed
 *   dgetrf  L U with row pivots, square;  dgetri  the inverse from it;  dlange  the 1-norm
 *   dpotrf  L L^T, lower triangle;        dpotrs  solutions from it
 *   dsyev   eigenvalues and vectors, lower triangle: Householder's reduction and QL with implicit
 *       shifts
 *   dgesvd  square, all vectors ("A", "A") or none ("N", "N"): one-sided Jacobi rotations
 *       (Hestenes)
 *   dgelsy  one right side, by singular values: the rank is that of sigma_k > rcond sigma_1
 *
 * Golub and Van Loan, Matrix Computations.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSR_OWN_LAPACK
#define MBSR_OWN_LAPACK
#endif
#include "algebra/fortran.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>

/* Column j of a matrix with leading dimension ld. */
static double *column_at(double *a, int ld, int j)
{
    return a + (size_t)j * (size_t)ld;
}

static const double *read_column(const double *a, int ld, int j)
{
    return a + (size_t)j * (size_t)ld;
}

/* ---- products and norms ---- */

void dgemm_(const char *transa, const char *transb, const int *m, const int *n, const int *k,
            const double *alpha, const double *a, const int *lda, const double *b, const int *ldb,
            const double *beta, double *c, const int *ldc, size_t transa_length,
            size_t transb_length)
{
    (void)transb, (void)transa_length, (void)transb_length;
    const bool transposed = *transa == 'T';
    for (int j = 0; j < *n; ++j) {
        double *y = column_at(c, *ldc, j);
        const double *x = read_column(b, *ldb, j);
        for (int i = 0; i < *m; ++i) y[i] = *beta == 0.0 ? 0.0 : *beta * y[i];
        for (int i = 0; i < *m && transposed; ++i) {
            const double *own = read_column(a, *lda, i);
            double sum = 0.0;
            for (int l = 0; l < *k; ++l) sum += own[l] * x[l];
            y[i] += *alpha * sum;
        }
        for (int l = 0; l < *k && !transposed; ++l) {
            const double *own = read_column(a, *lda, l), factor = *alpha * x[l];
            for (int i = 0; i < *m; ++i) y[i] += factor * own[i];
        }
    }
}

double dlange_(const char *norm, const int *m, const int *n, const double *a, const int *lda,
               double *work, size_t norm_length)
{
    (void)norm, (void)work, (void)norm_length;
    double largest = 0.0;
    for (int j = 0; j < *n; ++j) {
        double sum = 0.0;
        for (int i = 0; i < *m; ++i) sum += fabs(read_column(a, *lda, j)[i]);
        if (!(sum <= largest)) largest = sum; /* NaN as well */
    }
    return largest;
}

static double product_of_vectors(int n, const double *x, const double *y)
{
    double sum = 0.0;
    for (int k = 0; k < n; ++k) sum += x[k] * y[k];
    return sum;
}

static void add_multiple(int n, double factor, const double *x, double *y)
{
    for (int k = 0; k < n; ++k) y[k] += factor * x[k];
}

static void exchange_vectors(int n, double *x, int step_x, double *y, int step_y)
{
    for (int k = 0; k < n; ++k) {
        const double was = x[(size_t)k * (size_t)step_x];
        x[(size_t)k * (size_t)step_x] = y[(size_t)k * (size_t)step_y];
        y[(size_t)k * (size_t)step_y] = was;
    }
}

/* A power of two near the largest entry, by which products neither overflow nor vanish; 1 for zero.
 */
static double power_of_two_near(int m, int n, const double *a, int lda)
{
    double largest = 0.0;
    for (int j = 0; j < n; ++j) {
        for (int i = 0; i < m; ++i) largest = fmax(largest, fabs(read_column(a, lda, j)[i]));
    }
    return largest > 0.0 && largest <= DBL_MAX ? ldexp(1.0, ilogb(largest)) : 1.0;
}

static void scale_matrix(int m, int n, double factor, double *a, int lda)
{
    for (int j = 0; j < n; ++j) {
        for (int i = 0; i < m; ++i) column_at(a, lda, j)[i] *= factor;
    }
}

/* ---- triangular factors ---- */

void dgetrf_(const int *m, const int *n, double *a, const int *lda, int *ipiv, int *info)
{
    (void)m;
    const int size = *n, ld = *lda;
    *info = 0;
    for (int k = 0; k < size; ++k) {
        double *own = column_at(a, ld, k);
        int largest = k;
        for (int i = k + 1; i < size; ++i)
            largest = fabs(own[i]) > fabs(own[largest]) ? i : largest;
        ipiv[k] = largest + 1;
        if (own[largest] == 0.0) {
            *info = *info ? *info : k + 1;
            continue;
        }
        if (largest != k) exchange_vectors(size, a + k, ld, a + largest, ld);
        for (int i = k + 1; i < size; ++i) own[i] /= own[k];
        for (int j = k + 1; j < size; ++j) {
            double *other = column_at(a, ld, j);
            add_multiple(size - k - 1, -other[k], own + k + 1, other + k + 1);
        }
    }
}

/* U^-1 in its place; then X L = U^-1 from the last column to the first; then columns by the pivots.
 */
void dgetri_(const int *n, double *a, const int *lda, const int *ipiv, double *work,
             const int *lwork, int *info)
{
    (void)lwork;
    const int size = *n, ld = *lda;
    *info = 0;
    for (int j = 0; j < size; ++j) {
        double *own = column_at(a, ld, j);
        own[j] = 1.0 / own[j];
        for (int i = 0; i < j; ++i) {
            double sum = 0.0; /* entries of U^-1 in row i, of U in column j */
            for (int l = i; l < j; ++l) sum += column_at(a, ld, l)[i] * own[l];
            work[i] = -sum * own[j];
        }
        for (int i = 0; i < j; ++i) own[i] = work[i];
    }
    for (int j = size - 2; j >= 0; --j) {
        double *own = column_at(a, ld, j);
        for (int i = j + 1; i < size; ++i) {
            work[i] = own[i];
            own[i] = 0.0;
        }
        for (int i = j + 1; i < size; ++i) add_multiple(size, -work[i], column_at(a, ld, i), own);
    }
    for (int j = size - 2; j >= 0; --j) {
        const int k = ipiv[j] - 1;
        if (k != j) exchange_vectors(size, column_at(a, ld, j), 1, column_at(a, ld, k), 1);
    }
}

void dpotrf_(const char *uplo, const int *n, double *a, const int *lda, int *info,
             size_t uplo_length)
{
    (void)uplo, (void)uplo_length;
    const int size = *n, ld = *lda;
    *info = 0;
    for (int k = 0; k < size; ++k) {
        double *own = column_at(a, ld, k);
        for (int j = 0; j < k; ++j) {
            const double *before = column_at(a, ld, j);
            add_multiple(size - k, -before[k], before + k, own + k);
        }
        if (!(own[k] > 0.0)) {
            *info = k + 1;
            return;
        }
        const double root = sqrt(own[k]);
        for (int i = k; i < size; ++i) own[i] /= root;
    }
}

void dpotrs_(const char *uplo, const int *n, const int *nrhs, const double *a, const int *lda,
             double *b, const int *ldb, int *info, size_t uplo_length)
{
    (void)uplo, (void)uplo_length;
    const int size = *n, ld = *lda;
    *info = 0;
    for (int j = 0; j < *nrhs; ++j) {
        double *x = column_at(b, *ldb, j);
        for (int k = 0; k < size; ++k) {
            const double *own = read_column(a, ld, k);
            x[k] /= own[k];
            add_multiple(size - k - 1, -x[k], own + k + 1, x + k + 1);
        }
        for (int k = size - 1; k >= 0; --k) {
            const double *own = read_column(a, ld, k);
            x[k] = (x[k] - product_of_vectors(size - k - 1, own + k + 1, x + k + 1)) / own[k];
        }
    }
}

/* ---- eigenvalues of symmetric matrices ---- */

/* Householder's vector v (n, v[0] = 1) of x, which it overwrites, with (1 - beta v v^T) x =
 * (*first, 0); beta. */
static double reflector(int n, double *x, double *first)
{
    const double rest = product_of_vectors(n - 1, x + 1, x + 1), alpha = x[0];
    *first = alpha;
    x[0] = 1.0;
    if (rest == 0.0) return 0.0;
    *first = -copysign(sqrt(alpha * alpha + rest), alpha);
    const double v = alpha - *first;
    for (int k = 1; k < n; ++k) x[k] /= v;
    return (*first - alpha) / *first;
}

/* A (lower triangle) to tridiagonal form T = Q^T A Q, by columns from the first: diagonal d, what
 * is below it e (n - 1); A becomes Q. p: n numbers. */
static void tridiagonalise(int n, double *A, int lda, double *d, double *e, double *p)
{
    for (int k = 0; k + 1 < n; ++k) {
        const int rest = n - k - 1;
        double *v = column_at(A, lda, k) + k + 1, *B = column_at(A, lda, k + 1) + k + 1;
        const double beta = reflector(rest, v, e + k);
        d[k] = column_at(A, lda, k)[k];
        for (int i = 0; i < rest; ++i) p[i] = 0.0;
        for (int j = 0; j < rest; ++j) { /* p = B v, of which the lower triangle is there */
            const double *own = column_at(B, lda, j);
            p[j] += own[j] * v[j] + product_of_vectors(rest - j - 1, own + j + 1, v + j + 1);
            add_multiple(rest - j - 1, v[j], own + j + 1, p + j + 1);
        }
        const double half = 0.5 * beta * beta * product_of_vectors(rest, p, v);
        for (int i = 0; i < rest; ++i) p[i] = beta * p[i] - half * v[i];
        for (int j = 0; j < rest; ++j) {
            add_multiple(rest - j, -v[j], p + j, column_at(B, lda, j) + j);
            add_multiple(rest - j, -p[j], v + j, column_at(B, lda, j) + j);
        }
        column_at(A, lda, k)[k] = beta;
    }
    d[n - 1] = column_at(A, lda, n - 1)[n - 1];
    column_at(A, lda, n - 1)[n - 1] = 1.0;
    for (int k = n - 2; k >= 0; --k) { /* Q from the last reflection to the first */
        const int rest = n - k - 1;
        double *v = column_at(A, lda, k) + k + 1;
        const double beta = column_at(A, lda, k)[k];
        for (int j = k + 1; j < n; ++j) {
            double *own = column_at(A, lda, j) + k + 1;
            add_multiple(rest, -beta * product_of_vectors(rest, v, own), v, own);
            column_at(A, lda, j)[k] = 0.0;
        }
        column_at(A, lda, k)[k] = 1.0;
        for (int i = 0; i < rest; ++i) v[i] = 0.0;
    }
}

/* Rotation of two columns (n): x, y <- c x - s y, s x + c y. */
static void rotate_columns(int n, double c, double s, double *x, double *y)
{
    for (int k = 0; k < n; ++k) {
        const double was = x[k];
        x[k] = c * was - s * y[k];
        y[k] = s * was + c * y[k];
    }
}

/* One QL step with an implicit shift on l .. m of a tridiagonal matrix, no e of which is zero
 * there. Nor is r: where f is, s of the step before is next to nothing, and g is one of these. */
static void chase(int n, int l, int m, double *d, double *e, double *Q, int lda)
{
    const double half = 0.5 * (d[l + 1] - d[l]);
    double g = d[m] - d[l] + e[l] * (e[l] / (half + copysign(hypot(half, e[l]), half)));
    double s = 1.0, c = 1.0, shifted = 0.0;
    for (int i = m - 1; i >= l; --i) {
        const double f = s * e[i], b = c * e[i], r = hypot(f, g);
        if (i + 1 < m) e[i + 1] = r;
        s = f / r;
        c = g / r;
        g = d[i + 1] - shifted;
        const double t = (d[i] - g) * s + 2.0 * c * b;
        shifted = s * t;
        d[i + 1] = g + shifted;
        g = c * t - b;
        rotate_columns(n, c, s, column_at(Q, lda, i), column_at(Q, lda, i + 1));
    }
    d[l] -= shifted;
    e[l] = g;
}

void dsyev_(const char *jobz, const char *uplo, const int *n, double *a, const int *lda, double *w,
            double *work, const int *lwork, int *info, size_t jobz_length, size_t uplo_length)
{
    (void)jobz, (void)uplo, (void)jobz_length, (void)uplo_length;
    enum { MOST = 60 };
    const int size = *n;
    *info = 0;
    if (*lwork < 0) {
        work[0] = 2.0 * size;
        return;
    }
    if (size == 0) return;
    double *e = work, unit = power_of_two_near(size, size, a, *lda);
    scale_matrix(size, size, 1.0 / unit, a, *lda);
    tridiagonalise(size, a, *lda, w, e, work + size);
    e[size - 1] = 0.0;
    double norm = 0.0;
    for (int k = 0; k < size; ++k) norm = fmax(norm, fabs(w[k]) + fabs(e[k]));
    for (int l = 0; l < size; ++l) {
        for (int step = 0;; ++step) {
            int m = l;
            while (m + 1 < size && fabs(e[m]) > DBL_EPSILON * norm) ++m;
            if (m == l) break;
            if (step == MOST) {
                *info = l + 1;
                return;
            }
            chase(size, l, m, w, e, a, *lda);
            if (m + 1 < size) e[m] = 0.0;
        }
    }
    for (int k = 0; k < size; ++k) {
        int least = k;
        for (int l = k + 1; l < size; ++l) least = w[l] < w[least] ? l : least;
        if (least != k) {
            exchange_vectors(1, w + k, 1, w + least, 1);
            exchange_vectors(size, column_at(a, *lda, k), 1, column_at(a, *lda, least), 1);
        }
        w[k] *= unit;
    }
}

/* ---- singular values ---- */

/* Columns x, y (m) of A made orthogonal, and those of V (n) turned with them; false where they are
 * orthogonal, or the shorter is no longer than `least`. */
static bool part(int m, double least, double *x, double *y, int n, double *v, double *w)
{
    const double a = product_of_vectors(m, x, x), b = product_of_vectors(m, y, y),
                 product = product_of_vectors(m, x, y);
    if (!(fabs(product) > 4.0 * DBL_EPSILON * sqrt(a) * sqrt(b)) || sqrt(fmin(a, b)) <= least)
        return false;
    const double theta = (b - a) / (2.0 * product),
                 t = copysign(1.0 / (fabs(theta) + hypot(theta, 1.0)), theta),
                 c = 1.0 / sqrt(1.0 + t * t);
    rotate_columns(m, c, c * t, x, y);
    if (v) rotate_columns(n, c, c * t, v, w);
    return true;
}

/* What is rounding in lengths of n columns, of which this is the longest. */
static double rounding(int n, double longest)
{
    return n * DBL_EPSILON * longest;
}

/* A (m x n, m >= n) <- A V with orthogonal columns, longest first, their lengths in s; V (n x n,
 * ldv), may be NULL. Whether it ended. */
static bool orthogonalise(int m, int n, double *A, int lda, double *s, double *V, int ldv)
{
    enum { SWEEPS = 60 };
    for (int j = 0; j < n && V; ++j) {
        for (int i = 0; i < n; ++i) column_at(V, ldv, j)[i] = i == j;
    }
    double least = 0.0;
    bool moving = n > 1;
    for (int sweep = 0; sweep < SWEEPS && moving; ++sweep) {
        moving = false;
        for (int p = 0; p < n; ++p) {
            int longest = p;
            for (int j = p; j < n; ++j) {
                s[j] = product_of_vectors(m, column_at(A, lda, j), column_at(A, lda, j));
                longest = s[j] > s[longest] ? j : longest;
            }
            if (p == 0) least = rounding(m, sqrt(s[longest]));
            if (longest != p) {
                exchange_vectors(m, column_at(A, lda, p), 1, column_at(A, lda, longest), 1);
                if (V) exchange_vectors(n, column_at(V, ldv, p), 1, column_at(V, ldv, longest), 1);
                moving = true;
            }
            for (int q = p + 1; q < n; ++q) {
                const bool turned =
                    part(m, least, column_at(A, lda, p), column_at(A, lda, q), n,
                         V ? column_at(V, ldv, p) : NULL, V ? column_at(V, ldv, q) : NULL);
                moving = moving || turned;
            }
        }
    }
    for (int j = 0; j < n; ++j)
        s[j] = sqrt(product_of_vectors(m, column_at(A, lda, j), column_at(A, lda, j)));
    return !moving;
}

/* Column k of U (n x n) becomes a unit vector orthogonal to those before it. */
static void complete(int n, double *U, int ldu, int k)
{
    double *x = column_at(U, ldu, k), length = 0.0;
    for (int axis = 0; axis < n && length < 0.5 / n; ++axis) {
        for (int i = 0; i < n; ++i) x[i] = i == axis;
        for (int again = 0; again < 2; ++again) {
            for (int j = 0; j < k; ++j) {
                const double *before = column_at(U, ldu, j);
                add_multiple(n, -product_of_vectors(n, before, x), before, x);
            }
        }
        length = product_of_vectors(n, x, x);
    }
    for (int i = 0; i < n; ++i) x[i] /= sqrt(length);
}

void dgesvd_(const char *jobu, const char *jobvt, const int *m, const int *n, double *a,
             const int *lda, double *s, double *u, const int *ldu, double *vt, const int *ldvt,
             double *work, const int *lwork, int *info, size_t jobu_length, size_t jobvt_length)
{
    (void)m, (void)jobvt, (void)jobu_length, (void)jobvt_length, (void)work, (void)lwork;
    const int size = *n;
    const bool vectors = *jobu == 'A';
    const double unit = power_of_two_near(size, size, a, *lda);
    scale_matrix(size, size, 1.0 / unit, a, *lda);
    *info = !orthogonalise(size, size, a, *lda, s, vectors ? vt : NULL, *ldvt);
    for (int k = 0; k < size && vectors; ++k) {
        double *own = column_at(u, *ldu, k);
        for (int i = 0; i < size; ++i) own[i] = read_column(a, *lda, k)[i] / s[k];
        if (!(s[k] > rounding(size, s[0]))) complete(size, u, *ldu, k);
    }
    for (int k = 0; k < size; ++k) {
        s[k] *= unit;
        if (vectors) exchange_vectors(k, column_at(vt, *ldvt, k), 1, vt + k, *ldvt); /* to V^T */
    }
}

/* x = V S^-1 U^T b, of A = U S V^T where there are not more columns than rows, else of A^T. */
void dgelsy_(const int *m, const int *n, const int *nrhs, double *a, const int *lda, double *b,
             const int *ldb, int *jpvt, const double *rcond, int *rank, double *work,
             const int *lwork, int *info)
{
    (void)nrhs, (void)jpvt, (void)ldb;
    const bool tall = *m >= *n;
    const int longer = tall ? *m : *n, shorter = tall ? *n : *m;
    const size_t entries = (size_t)longer * (size_t)shorter;
    *info = *rank = 0;
    if (*lwork < 0) {
        work[0] = (double)entries + (double)shorter * (shorter + 2.0);
        return;
    }
    double *A = work, *V = A + entries, *s = column_at(V, shorter, shorter), *w = s + shorter;
    for (int j = 0; j < shorter; ++j) {
        for (int i = 0; i < longer; ++i)
            column_at(A, longer, j)[i] =
                tall ? read_column(a, *lda, j)[i] : read_column(a, *lda, i)[j];
    }
    const double unit = power_of_two_near(longer, shorter, A, longer);
    scale_matrix(longer, shorter, 1.0 / unit, A, longer);
    *info = !orthogonalise(longer, shorter, A, longer, s, V, shorter);
    while (*rank < shorter && s[*rank] > *rcond * s[0]) ++*rank;
    const double *from = tall ? A : V, *to = tall ? V : A;
    const int rows = tall ? longer : shorter, columns = tall ? shorter : longer;
    for (int k = 0; k < *rank; ++k) /* the columns of A have the lengths s */
        w[k] = product_of_vectors(rows, from + (size_t)k * (size_t)rows, b) / (s[k] * s[k] * unit);
    for (int i = 0; i < columns; ++i) b[i] = 0.0;
    for (int k = 0; k < *rank; ++k)
        add_multiple(columns, w[k], to + (size_t)k * (size_t)columns, b);
}
