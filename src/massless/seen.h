/* Which directions springs and dampers see: ranks of the rows of element_rows.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * With a row of B for what a damper sees, and of A for a spring,
 *
 *   rank B           damped directions; y_k of the reduction of B^T is one that damper k sees and
 *       of the
 *                    others only those that follow from the ones with pivots
 *   B Z = 0          the others
 *   rank A Z         elastic directions among these, in the same way
 *   A Z x = 0        Z x is undetermined
 *
 * where rows tell everything about these directions (mbsri_rows_serve). */
#ifndef MBSRI_SEEN_H
#define MBSRI_SEEN_H

#include "massless/null_space.h"

/* Reduces B^T (count x rows) into w->element.reduced; MBSR_OK, or no memory. */
int mbsri_seen_by_dampers(mbsri_null_space *w, int count, const int *direction);

/* Reduces (A Z)^T (e x rows) into w->element.reduced; Z (count x e) and what it may be wrong by. */
int mbsri_seen_by_springs(mbsri_null_space *w, int count, const int *direction, int e,
                          const double *Z, const double *Z_error);

/* out (count) = Z weights, Z: count x e, without what rounding leaves where terms cancel. */
void mbsri_seen_through(int count, int e, const double *Z, const double *weights, double *out);

#endif
