/* Energy of a body.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_RESULTS_ENERGY_H
#define MBSRI_RESULTS_ENERGY_H

#include "model/record.h"

/* 1/2 V^T M V of body i, and of the armature of its joint, at the state of mbsri_velocities. */
double mbsri_kinetic_energy_of(const mbsr_model *m, mbsr_data *d, int i);

#endif
