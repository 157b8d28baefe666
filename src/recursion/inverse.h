/* Inverse dynamics (recursive Newton-Euler): (9) root to leaves, (11) leaves to root.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_INVERSE_H
#define MBSRI_INVERSE_H

#include "recursion/data.h"

/* At the state of mbsri_forces; udot in the caller's order. Writes A, mu and, in the order of the
 * sweeps, the joint forces that are missing, J^T mu - tau, to `out` of the data. */
void mbsri_inverse(const mbsr_model *m, mbsr_data *d, const double *udot);

#endif
