/* The size of rounding errors on its way through the backward recursion (backward.c).
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_ERRORS_H
#define MBSRI_ERRORS_H

#include "recursion/group.h"

/* E (rows x rows, d or the upper ones of modal.h) = share (Diag(Mbar) + Diag(G Diag(J^T Diag(Mbar)
 * J) G^T)) + P^T W P, the errors behind a group, at its head; W: one d x d block a body. Q: d x n,
 * JQ: n x n, work: as mbsri_group_products. */
void mbsri_carry_errors(const mbsr_model *m, const mbsr_data *d, const mbsri_group *g,
                        const double *W, double share, int rows, double *E, double *Q, double *JQ,
                        double *work);

/* size[l] = J_l^T Diag(Mbar) J_l + a_l of the joint rates of a group: what was added up to D here.
 */
void mbsri_diagonal_sizes(const mbsr_model *m, const mbsr_data *d, const mbsri_group *g,
                          double *size);

/* E (n x n) += share Diag(A) */
static inline void mbsri_add_diagonal(int n, double share, const double *A, double *E)
{
    for (int k = 0; k < n; ++k) E[k * (n + 1)] += share * A[k * (n + 1)];
}

/* What turning the tensor of a body in space into the world's axes may be wrong by, in units of the
 * machine precision: its trace, kg m^2. Starts `turned` of the body. */
double mbsri_own_rotated(const mbsri_body *b, const double *M);

/* What of all that makes moments about rate l of the joint of b wrong, times the square of its
 * turning: `turned`, and the arms within a joint of several rates, whose axes a body slides along,
 * m |r|^2. */
double mbsri_rotated_along(const mbsr_data *d, const mbsri_body *b, int l);

/* What lever arms of H (d x d_pred) between bodies in space may make moments wrong by, likewise: of
 * a mass that stands on an axis nothing is left but their rounding. What a body slides along, or
 * its frame, may take an arm back to nothing but the rounding of what is fixed on its predecessor,
 * which counts as well. A (d x d) is carried; m |r|^2. */
double mbsri_trace_of_arms(const mbsri_body *b, const double *H, const double *A);

#endif
