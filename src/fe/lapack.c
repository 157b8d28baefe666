/* BLAS and LAPACK behind C signatures: see lapack.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fe/lapack.h"

#include "algebra/fortran.h"

#include <limits.h>

void mbsri_fe_ab(int r, int k, int c, double s, const double *A, const double *B, double t,
                 double *C)
{
    const int ldb = k > 0 ? k : 1;
    if (r > 0 && c > 0) dgemm_("N", "N", &r, &c, &k, &s, A, &r, B, &ldb, &t, C, &r, 1, 1);
}

void mbsri_fe_atb(int k, int r, int c, const double *A, const double *B, double *C)
{
    const double one = 1.0, zero = 0.0;
    const int ld = k > 0 ? k : 1;
    if (r > 0 && c > 0) dgemm_("T", "N", &r, &c, &k, &one, A, &ld, B, &ld, &zero, C, &r, 1, 1);
}

int mbsri_fe_cholesky(int n, double *A)
{
    int info = 0;
    if (n > 0) dpotrf_("L", &n, A, &n, &info, 1);
    return info - 1;
}

void mbsri_fe_cholesky_solve(int n, const double *L, int c, double *X)
{
    int info = 0;
    if (n > 0 && c > 0) dpotrs_("L", &n, &c, L, &n, X, &n, &info, 1);
}

size_t mbsri_fe_eigen_work(int n)
{
    return 3 * (size_t)n + (size_t)n * (size_t)n;
}

int mbsri_fe_eigen(int n, double *A, double *w, double *work)
{
    const size_t size = mbsri_fe_eigen_work(n);
    const int lwork = size > INT_MAX ? INT_MAX : (int)size;
    int info = 0;
    if (n > 0) dsyev_("V", "L", &n, A, &n, w, work, &lwork, &info, 1, 1);
    return info;
}
