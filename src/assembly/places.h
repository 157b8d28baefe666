/* Where the numbers of each body stand in the arrays of the data.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_PLACES_H
#define MBSRI_PLACES_H

#include "model/record.h"

/* Sets the offsets of all bodies and the lengths of the arrays: bodies in the sweeps first, others
 * behind them, both by their indices. What counts rates of groups is left to groups.h. */
void mbsri_places_set(mbsr_model *m, int bodies);

/* Sets which bodies are in the sweeps, once the trees of the sweeps are there: the root, the bodies
 * that the sweeps leave to the steps of recursion/ and their predecessors, and those on which
 * elements act. Lean data have room for no others. */
void mbsri_places_see(mbsr_model *m);

#endif
