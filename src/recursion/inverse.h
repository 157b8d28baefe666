/* Inverse dynamics (recursive Newton-Euler): (9) root to leaves, (11) leaves to root.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_INVERSE_H
#define MBSRI_INVERSE_H

#include "recursion/data.h"

/* At the state of mbsri_forces; udot in the caller's order. Writes A, mu and, in the order of the
 * sweeps, the joint forces that are missing, J^T mu - tau, to `out` of the data. */
void mbsri_inverse(const mbsr_model *m, mbsr_data *d, const double *udot);

/* The steps for one body: A and mu from those of its predecessor and u' (n); then, with what the
 * successors added to mu, J^T mu - tau (n) and -H^T mu to the predecessor. */
void mbsri_accelerate(const mbsr_model *m, mbsr_data *d, int i, const double *udot);
void mbsri_open_reaction(const mbsr_model *m, mbsr_data *d, int i); /* mu alone, at A */
void mbsri_react(const mbsr_model *m, mbsr_data *d, int i, double *out);

#endif
