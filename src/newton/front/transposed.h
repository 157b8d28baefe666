/* Solutions with the transposed matrix.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FRONT_TRANSPOSED_H
#define MBSRI_FRONT_TRANSPOSED_H

#include "newton/front/front.h"

/* x with A^T x = v, A as in mbsri_front_solve; not the same. */
void mbsri_front_solve_transposed(mbsri_front *f, const double *v, double *x);

#endif
