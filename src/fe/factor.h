/* Cholesky factors: dense by LAPACK, sparse by CHOLMOD.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FE_FACTOR_H
#define MBSRI_FE_FACTOR_H

#include "fe/sparse.h"

typedef struct mbsri_factor mbsri_factor;

/* Which one `wanted` means for n dofs; MBSR_FE_AUTO: none, without CHOLMOD. */
mbsr_fe_solver mbsri_factor_choose(mbsr_fe_solver wanted, int n);

/* Factor of A with shift (n) added to its diagonal. MBSR_ERR_VALUE: not positive definite, with
 * *column where the pivot is not positive or lost in rounding; MBSR_ERR_NO_MEMORY. On failure
 * *factor is NULL. */
int mbsri_factor_make(const mbsr_allocator *allocator, mbsr_fe_solver solver, const mbsri_sparse *A,
                      const double *shift, mbsri_factor **factor, int *column);
void mbsri_factor_destroy(mbsri_factor *factor); /* NULL is allowed */

/* X (n x c) <- A^-1 X; false: no memory. */
bool mbsri_factor_solve(mbsri_factor *factor, int c, double *X);

/* Entries of the factor. */
double mbsri_factor_entries(const mbsri_factor *factor);

#endif
