/* Closures in the momentum form.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_LOOPS_H
#define MBSRI_LOOPS_H

#include "recursion/data.h"

/* How many numbers they add to y: m + h, m velocity rows and h position rows. */
static inline int mbsri_loops_size(const mbsr_model *m)
{
    return m->rows + m->held;
}

/* Their part x = (Lambda, Eta) of y at the positions. */
int mbsri_loops_pack(const mbsr_model *m, mbsr_data *d, double *x);

/* Loop forces from x and x', which mbsri_forces then adds; at the velocities. */
int mbsri_loops_load(const mbsr_model *m, mbsr_data *d, const double *x, const double *xp);

/* Their rows F_x, and q' = G (u + w C^T Eta') in qdot; after mbsri_loops_load. */
int mbsri_loops_residual(const mbsr_model *m, mbsr_data *d, const double *x, const double *xp,
                         double *qdot, double *F);

#endif
