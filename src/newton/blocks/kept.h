/* What is kept of a joint between factoring and solving.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_KEPT_H
#define MBSRI_KEPT_H

#include "newton/blocks/record.h"

/* Places what is kept of joint i in memory (NULL: none); returns how many doubles it takes at
 * most. */
size_t mbsri_keep(const mbsr_newton *w, int i, double *memory, mbsri_kept *kept);

/* y_pi += B y, the part of the predecessor's forces that does not come from the joint itself. */
void mbsri_pass_action(const mbsri_body *b, const mbsri_kept *kept, bool deep, const double *y,
                       double *below);

/* Unknowns and rows of a front (front.h) of n rates stand in the basis S X of D where it is deep:
 * rows from (a) and (b) over the rates; du and, where deep, du' from the unknowns. */
void mbsri_kept_rows(const mbsri_kept *kept, const mbsri_node *node, int n, const double *a,
                     const double *balance, double *out);
void mbsri_kept_rates(const mbsri_kept *kept, const mbsri_node *node, int n, const double *own,
                      double *u, double *a);

/* y = (1 - P) x and x = P x for momenta of a joint: P = S^-1 X_N X_N^T S as mbsri_null_force. */
void mbsri_kept_split(const mbsri_kept *kept, int n, int rank, double *x, double *y);

#endif
