/* Combinations of gaps in which springs and dampers given by matrices act apart.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Two symmetric positive semi-definite matrices are diagonal together in suitable coordinates: with
 * the energy g^T K g / 2 and the power g'^T D g' there are rows T, each of length 1, so that with
 * z = T g
 *
 *   g^T K g = sum of k z^2        g'^T D g' = sum of d z'^2
 *
 * (Golub and Van Loan, Matrix Computations, 8.7). */
#ifndef MBSRI_PRINCIPAL_H
#define MBSRI_PRINCIPAL_H

enum { MBSRI_PRINCIPAL_MOST = 12 };

typedef enum mbsri_principal_fault {
    MBSRI_PRINCIPAL_GOOD,
    MBSRI_PRINCIPAL_INDEFINITE, /* the first matrix */
    MBSRI_PRINCIPAL_DAMPING,    /* the second */
    MBSRI_PRINCIPAL_LOOSE,      /* D acts where K is zero */
    MBSRI_PRINCIPAL_SKEW        /* rows so near to each other that rounding takes over */
} mbsri_principal_fault;

typedef struct mbsri_principal {
    int rows;
    double T[MBSRI_PRINCIPAL_MOST * MBSRI_PRINCIPAL_MOST]; /* row by row, rows x n */
    double stiffness[MBSRI_PRINCIPAL_MOST], damping[MBSRI_PRINCIPAL_MOST];
} mbsri_principal;

/* K and D (n x n, symmetric; D may be NULL); rows = rank of K. */
mbsri_principal_fault mbsri_principal_stiffness(int n, const double *K, const double *D,
                                                mbsri_principal *out);

/* K is the inverse of the compliance A (n x n); rows = n, of which those without compliance are
 * rigid, stiffness 0, and what D does along them is dropped. */
mbsri_principal_fault mbsri_principal_compliance(int n, const double *A, const double *D,
                                                 mbsri_principal *out);

#endif
