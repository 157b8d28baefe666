/* Where bodies of the sweeps are and how they move, as the stages tell it.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_SHOW_H
#define MBSRI_SHOW_H

#include "sweeps/tree.h"

/* The origin of body i, whose predecessor's is known; that of the root. */
void mbsri_sweeps_place(const mbsri_sweep_run *run, int i);
void mbsri_sweeps_place_root(const mbsri_sweep_run *run);

/* Pose and velocity of body i's own frame, to the arrays of the stages, and its arm. */
void mbsri_sweeps_show(const mbsri_sweep_run *run, int i);

#endif
