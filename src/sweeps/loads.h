/* Force elements that act on bodies, in the sweeps.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_LOADS_H
#define MBSRI_LOADS_H

#include "sweeps/tree.h"

/* After kinematics with velocities: the loads of force elements, and their joint forces on top of
 * the data's tau. Returns what an element returned. */
int mbsri_sweeps_loads(const mbsri_sweep_run *run);

/* C^T eta of the run into the data's closure_w, in the order of the sweeps; after the loads, and
 * anything that needs them. */
void mbsri_sweeps_push(const mbsri_sweep_run *run);

#endif
