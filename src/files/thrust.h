/* Forces of files that act at a point of one body.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FILES_THRUST_H
#define MBSRI_FILES_THRUST_H

#include "files/elements.h"

/* The force F = gain w + bias[0] + bias[2] l' within a range along gear: gear[0..2] in N,
 * gear[3..5] in N m, along the axes of a frame on the body, at its origin; l' = gear . (velocity,
 * angular velocity) along these. bias[1] counts for nothing: l is 0. */
typedef struct mbsri_thrust {
    int body;
    mbsr_frame frame;
    double gear[6];
    mbsri_file_law law;
} mbsri_thrust;

mbsr_force_def mbsri_force_thrust(const mbsri_thrust *t);

/* One read back; false: it is another element. */
bool mbsri_thrust_of(const mbsr_force_def *def, mbsri_thrust *t);

/* What a constant force F (N, along the world's axes) at a point of a body does, such as against
 * its weight. */
mbsr_force_def mbsri_force_lift(int body, const double point[3], const double force[3]);
bool mbsri_lift_of(const mbsr_force_def *def, double force[3]);

#endif
