/* Where bodies of the sweeps are and how they move, as the stages tell it.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_SHOW_H
#define MBSRI_SHOW_H

#include "sweeps/tree.h"

/* The origin of the root; the angle of a body in the plane which is no coordinate, where its
 * predecessor's is known. */
void mbsri_sweeps_place_root(const mbsri_sweep_run *run);
double mbsri_sweeps_angle(const mbsri_sweep_run *run, int i, double pred);

/* Pose and velocity of body i's own frame, to the arrays of the stages, and its arm. */
void mbsri_sweeps_show(const mbsri_sweep_run *run, int i);

#endif
