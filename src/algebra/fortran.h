/* BLAS and LAPACK by their Fortran interface: integers are int, characters carry hidden lengths at
 * the end. With MBSR_OWN_LAPACK these are the routines of own_lapack.c, by names that meet no other
 * library's.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FORTRAN_H
#define MBSRI_FORTRAN_H

#include <stddef.h>

#ifdef MBSR_OWN_LAPACK
#define dgelsy_ mbsri_own_dgelsy
#define dgemm_ mbsri_own_dgemm
#define dgesvd_ mbsri_own_dgesvd
#define dgetrf_ mbsri_own_dgetrf
#define dgetri_ mbsri_own_dgetri
#define dlange_ mbsri_own_dlange
#define dpotrf_ mbsri_own_dpotrf
#define dpotrs_ mbsri_own_dpotrs
#define dsyev_ mbsri_own_dsyev
#endif

void dgelsy_(const int *m, const int *n, const int *nrhs, double *a, const int *lda, double *b,
             const int *ldb, int *jpvt, const double *rcond, int *rank, double *work,
             const int *lwork, int *info);
void dgemm_(const char *transa, const char *transb, const int *m, const int *n, const int *k,
            const double *alpha, const double *a, const int *lda, const double *b, const int *ldb,
            const double *beta, double *c, const int *ldc, size_t transa_length,
            size_t transb_length);
void dgesvd_(const char *jobu, const char *jobvt, const int *m, const int *n, double *a,
             const int *lda, double *s, double *u, const int *ldu, double *vt, const int *ldvt,
             double *work, const int *lwork, int *info, size_t jobu_length, size_t jobvt_length);
void dgetrf_(const int *m, const int *n, double *a, const int *lda, int *ipiv, int *info);
void dgetri_(const int *n, double *a, const int *lda, const int *ipiv, double *work,
             const int *lwork, int *info);
double dlange_(const char *norm, const int *m, const int *n, const double *a, const int *lda,
               double *work, size_t norm_length);
void dpotrf_(const char *uplo, const int *n, double *a, const int *lda, int *info,
             size_t uplo_length);
void dpotrs_(const char *uplo, const int *n, const int *nrhs, const double *a, const int *lda,
             double *b, const int *ldb, int *info, size_t uplo_length);
void dsyev_(const char *jobz, const char *uplo, const int *n, double *a, const int *lda, double *w,
            double *work, const int *lwork, int *info, size_t jobz_length, size_t uplo_length);

#endif
