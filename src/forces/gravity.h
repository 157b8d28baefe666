/* Gravity, which the vectorised sweeps take as an acceleration of the world.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_GRAVITY_H
#define MBSRI_GRAVITY_H

#include <mbsrank/force.h>

#include <stdbool.h>

/* Whether an element is mbsr_force_gravity. */
bool mbsri_is_gravity(const mbsr_force_def *def);

/* Its moment on a body in space with the mass matrix M, along a small rotation of the body, column
 * by column. */
void mbsri_gravity_turn(const mbsr_force_def *def, const double M[36], double moment[9]);

#endif
