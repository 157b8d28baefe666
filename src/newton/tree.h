/* The elimination on the tree, whichever serves: the vectorised sweeps or the blocks.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_NEWTON_TREE_H
#define MBSRI_NEWTON_TREE_H

#include "newton/blocks/record.h"

/* By the vectorised sweeps where they serve, else by blocks; y is that of the momentum form. */
int mbsri_newton_tree_factor(mbsr_newton *w, mbsr_data *d, double t, const double *y,
                             const double *yp, double c);

/* delta from r (NULL: zero; may be delta), and from a change of the forces f (size_v) and tau (nu) at `load` (NULL: none),
 * by whichever elimination was last; and the perturbations of a body's pose and V
 * that it left. */
void mbsri_newton_tree_solve(mbsr_newton *w, const double *r, const double *load, double *delta);
const double *mbsri_newton_motion(const mbsr_newton *w, int i);

#endif
