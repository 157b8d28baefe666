/* Poses that are displaced a little.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_POSE_H
#define MBSRI_POSE_H

#include <mbsrank/base.h>
#include <mbsrank/joint.h>

/* dp: change of its np numbers. x: as a perturbation, 6 numbers for SPATIAL, else the np. */
void mbsri_pose_change(mbsr_space space, int np, const double *p, const double *dp, double *x);

/* dp of the unit perturbation k; dp arrives as zero. */
void mbsri_pose_unit(mbsr_space space, int k, const double *p, double *dp);

/* moved = p displaced by h dp; a SPATIAL R stays a rotation. */
void mbsri_pose_move(mbsr_space space, int np, const double *p, const double *dp, double h,
                     double *moved);

/* p' of a body that moves with V; GENERAL: np = d, p' = V. */
void mbsri_pose_rate(mbsr_space space, int np, const double *p, const double *V, double *dp);

#endif
