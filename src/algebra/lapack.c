/* LAPACK behind C signatures: see lapack.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "algebra/lapack.h"

#include "algebra/fortran.h"
#include "algebra/numbers.h"

#include <math.h>

int mbsri_lapack_syev(int n, double *A, double *w, double *work, int lwork)
{
    int info = 0;
    dsyev_("V", "L", &n, A, &n, w, work, &lwork, &info, 1, 1);
    return info;
}

int mbsri_lapack_syev_work(int n)
{
    double a = 0.0, w = 0.0, work = 0.0;
    const int query = -1, lda = n > 0 ? n : 1;
    int info = 0;
    dsyev_("V", "L", &n, &a, &lda, &w, &work, &query, &info, 1, 1);
    const int least = 3 * lda;
    return info == 0 && work > least ? (int)work : least;
}

double mbsri_lapack_inverse(int n, double *A, int *pivots, double *work)
{
    int info = 0;
    const double norm = dlange_("1", &n, &n, A, &n, work, 1);
    dgetrf_(&n, &n, A, &n, pivots, &info);
    if (info != 0) return 0.0;
    const int lwork = 4 * n;
    dgetri_(&n, A, &n, pivots, work, &lwork, &info);
    if (info != 0) return 0.0;
    const double inverse_norm = dlange_("1", &n, &n, A, &n, work, 1);
    const double product = norm * inverse_norm;
    return isfinite(product) && product > 0.0 ? 1.0 / product : 0.0;
}

int mbsri_lapack_gelsy(int r, int c, double *A, double *b, double rcond, int *pivots, int *rank,
                       double *work, int lwork)
{
    const int one = 1, ldb = r > c ? r : c;
    int info = 0;
    for (int k = 0; k < c; ++k) pivots[k] = 0;
    dgelsy_(&r, &c, &one, A, &r, b, &ldb, pivots, &rcond, rank, work, &lwork, &info);
    return info;
}

int mbsri_lapack_gelsy_work(int r, int c)
{
    double a = 0.0, b = 0.0, work = 0.0;
    const double rcond = 0.0;
    const int one = 1, query = -1, ldb = r > c ? r : c;
    int info = 0, rank = 0, pivots = 0;
    dgelsy_(&r, &c, &one, &a, &r, &b, &ldb, &pivots, &rcond, &rank, &work, &query, &info);
    const int small = r < c ? r : c,
              least = small + 3 * c + 1 > 2 * small + 1 ? small + 3 * c + 1 : 2 * small + 1;
    return info == 0 && work > least ? (int)work : least;
}

int mbsri_lapack_svd(int n, double *A, double *s, double *U, double *V, double *work, int lwork)
{
    int info = 0;
    if (!mbsri_finite((size_t)n * (size_t)n, A)) return n + 1;
    dgesvd_("A", "A", &n, &n, A, &n, s, U, &n, V, &n, work, &lwork, &info, 1, 1);
    /* LAPACK gives V^T */
    for (int j = 0; j < n; ++j) {
        for (int k = 0; k < j; ++k) {
            const double held = V[j * n + k];
            V[j * n + k] = V[k * n + j];
            V[k * n + j] = held;
        }
    }
    return info;
}

int mbsri_lapack_singular_values(int n, double *A, double *s, double *work, int lwork)
{
    const int one = 1;
    int info = 0;
    if (!mbsri_finite((size_t)n * (size_t)n, A)) return n + 1;
    dgesvd_("N", "N", &n, &n, A, &n, s, NULL, &one, NULL, &one, work, &lwork, &info, 1, 1);
    return info;
}

int mbsri_lapack_svd_work(int n)
{
    const int svd = 5 * n + 1, gelsy = mbsri_lapack_gelsy_work(n, n);
    return svd > gelsy ? svd : gelsy;
}
