/* How a front passes its body.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * With x = X z of the body's motion, z = (x of the predecessor, dq, du), the columns of x go to
 * those of z, and with what the joint makes of y,
 *
 *   q'   c dq - d(G u) - G w (push - J^T kappa)
 *   (a)  c d(J^T m) - d(J'^T m + J^T sigma + tau)
 *   (b)  d(J^T mu - tau)                                                  u' free in the range of D
 *   y_pi += B y + (slopes of B) z,   kappa_pi -= H^T kappa
 *
 * its rows go to equations of the joint and to y of the predecessor (docs/newton.md). N gets the
 * sizes of what is added up, along the unknowns. */
#ifndef MBSRI_FRONT_PASS_H
#define MBSRI_FRONT_PASS_H

#include "newton/front/assemble.h"

/* All that the step knows stands over x. Where the joint, or its group, is complete, its rows and
 * columns become those in the range of D: u' = S X a, and X^T S (a). */
void mbsri_front_pass(mbsri_front_build *b);

#endif
