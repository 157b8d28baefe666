/* What the library knows of the stock joints in the plane.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_PLANAR_H
#define MBSRI_PLANAR_H

#include <mbsrank/joint.h>

#include <stdbool.h>

/* Whether a joint of this table and these options is one; its free coordinates (MBSR_X and so
 * on). */
bool mbsri_planar_coordinates(const mbsr_joint_table *table, const int *option, int *free);

#endif
