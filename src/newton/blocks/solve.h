/* Solving with the elimination of factor.c.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_SOLVE_H
#define MBSRI_SOLVE_H

#include "newton/blocks/record.h"

/* Places what is kept of joint i in memory (NULL: none); returns how many doubles it takes at
 * most. */
size_t mbsri_keep(const mbsr_newton *w, int i, double *memory, mbsri_kept *kept);

/* y_pi += B y, the part of the predecessor's forces that does not come from the joint itself. */
void mbsri_pass_action(const mbsri_body *b, const mbsri_kept *kept, bool deep, const double *y,
                       double *below);

/* delta from r (NULL: zero; may be delta), and from a change of the forces f (size_v) and tau (nu)
 * at `load` (NULL: none). Leaves the bodies' perturbations in w->x. */
void mbsri_tree_solve(mbsr_newton *w, const double *r, const double *load, double *delta);

#endif
