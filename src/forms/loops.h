/* Closures in the momentum form.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_LOOPS_H
#define MBSRI_LOOPS_H

#include "recursion/data.h"

/* How many numbers they add to y: m + h, m velocity rows and h position rows. */
static inline int mbsri_loops_size(const mbsr_model *m)
{
    return m->rows + m->position_rows;
}

/* Their part x = (Lambda, Eta) of y at the positions. */
int mbsri_loops_pack(const mbsr_model *m, mbsr_data *d, double *x);

/* Loop forces and Eta' from x and x', into loop_lambda and loop_eta. */
void mbsri_loops_take(const mbsr_model *m, mbsr_data *d, const double *x, const double *xp);

/* q' = G (u + w C^T Eta'), by the stages; at the velocities, after the derivatives of the closures.
 * The data's u is changed in between. */
int mbsri_loops_coordinate_rates(const mbsr_model *m, mbsr_data *d, double *qdot);

/* Their rows F_x; where bodies on which closures act are in the arrays of the stages, as the
 * closures' derivatives are. */
int mbsri_loops_residual(const mbsr_model *m, mbsr_data *d, const double *x, const double *xp,
                         double *F);

#endif
