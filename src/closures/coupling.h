/* What the library knows of couplings.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_COUPLING_H
#define MBSRI_COUPLING_H

#include <mbsrank/closure.h>

#include <stdbool.h>

/* Whether a closure is one of mbsr_closure_coupling: its coordinates are option[k] of body[k]. */
bool mbsri_is_linear_coupling(const mbsr_closure_def *def);

/* Takes out term k, whose coordinate stands still at a value. Returns the size of what it adds to
 * g. */
double mbsri_coupling_hold(mbsr_closure_def *def, int k, double value);

/* g of a coupling without terms, and whether it changes with time. */
double mbsri_coupling_rest(const mbsr_closure_def *def);
bool mbsri_coupling_moves(const mbsr_closure_def *def);

#endif
