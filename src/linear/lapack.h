/* LAPACK's routines that this component uses.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_LINEAR_LAPACK_H
#define MBSRI_LINEAR_LAPACK_H

#include <stddef.h>

void dgeev_(const char *jobvl, const char *jobvr, const int *n, double *a, const int *lda,
            double *wr, double *wi, double *vl, const int *ldvl, double *vr, const int *ldvr,
            double *work, const int *lwork, int *info, size_t jobvl_length, size_t jobvr_length);
void dgesvd_(const char *jobu, const char *jobvt, const int *m, const int *n, double *a,
             const int *lda, double *s, double *u, const int *ldu, double *vt, const int *ldvt,
             double *work, const int *lwork, int *info, size_t jobu_length, size_t jobvt_length);
void dgetrf_(const int *m, const int *n, double *a, const int *lda, int *ipiv, int *info);
void dgetrs_(const char *trans, const int *n, const int *nrhs, const double *a, const int *lda,
             const int *ipiv, double *b, const int *ldb, int *info, size_t trans_length);
void dgecon_(const char *norm, const int *n, const double *a, const int *lda, const double *anorm,
             double *rcond, double *work, int *iwork, int *info, size_t norm_length);
void dgemm_(const char *transa, const char *transb, const int *m, const int *n, const int *k,
            const double *alpha, const double *a, const int *lda, const double *b, const int *ldb,
            const double *beta, double *c, const int *ldc, size_t transa_length,
            size_t transb_length);
void dgemv_(const char *trans, const int *m, const int *n, const double *alpha, const double *a,
            const int *lda, const double *x, const int *incx, const double *beta, double *y,
            const int *incy, size_t trans_length);
void dgees_(const char *jobvs, const char *sort, const void *select, const int *n, double *a,
            const int *lda, int *sdim, double *wr, double *wi, double *vs, const int *ldvs,
            double *work, const int *lwork, int *bwork, int *info, size_t jobvs_length,
            size_t sort_length);
void dtrexc_(const char *compq, const int *n, double *t, const int *ldt, double *q, const int *ldq,
             int *ifst, int *ilst, double *work, int *info, size_t compq_length);
void dtrevc_(const char *side, const char *howmny, const int *select, const int *n, const double *t,
             const int *ldt, double *vl, const int *ldvl, double *vr, const int *ldvr,
             const int *mm, int *m, double *work, int *info, size_t side_length,
             size_t howmny_length);
void zgesv_(const int *n, const int *nrhs, double *a, const int *lda, int *ipiv, double *b,
            const int *ldb, int *info);

#endif
