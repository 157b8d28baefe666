/* Frames as parameters of joints and force elements: 12 numbers, origin and axes.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FRAMES_H
#define MBSRI_FRAMES_H

#include <mbsrank/spatial.h>

/* Largest entry of R^T R - 1; infinite where R is not finite or turns right-handed into
 * left-handed. */
double mbsri_frame_defect(const double R[9]);

/* Writes a frame (NULL: the identity) to param; axes that are orthonormal up to 1e-6 are made so to
 * rounding, others are kept for a check to find. */
void mbsri_store_frame(const mbsr_frame *frame, double param[12]);

#endif
