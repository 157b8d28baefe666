/* Poses that are displaced a little.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_POSE_H
#define MBSRI_POSE_H

#include <mbsrank/base.h>
#include <mbsrank/joint.h>

#include <stdbool.h>

/* Whether a pose is (R, r) or (R, r, s), with V = (omega, r', s'). */
static inline bool mbsri_turns(mbsr_space space)
{
    return space == MBSR_SPACE_SPATIAL || space == MBSR_SPACE_FLEXIBLE;
}

/* Whether velocity coordinate c of a body is an angular one; so is perturbation c of its pose. */
static inline bool mbsri_is_angle(mbsr_space space, int c)
{
    return mbsri_turns(space) ? c < 3 : space == MBSR_SPACE_PLANAR && c == 2;
}

/* Places of the translations among p, and among V. */
static inline bool mbsri_translations(mbsr_space space, int *at, int *V, int *count)
{
    switch (space) {
    case MBSR_SPACE_SPATIAL: *at = MBSR_POSE_X, *V = 3, *count = 3; return true;
    case MBSR_SPACE_PLANAR:
    case MBSR_SPACE_POINT: *at = *V = 0, *count = 2; return true;
    default: return false;
    }
}

/* dp: change of its np numbers. x: as a perturbation, 6 numbers for SPATIAL, np - 6 for
 * FLEXIBLE, else the np. */
void mbsri_pose_change(mbsr_space space, int np, const double *p, const double *dp, double *x);

/* dp of the unit perturbation k; dp arrives as zero. */
void mbsri_pose_unit(mbsr_space space, int k, const double *p, double *dp);

/* moved = p displaced by h dp; R stays a rotation. */
void mbsri_pose_move(mbsr_space space, int np, const double *p, const double *dp, double h,
                     double *moved);

/* p' of a body that moves with V; GENERAL: np = d, p' = V. */
void mbsri_pose_rate(mbsr_space space, int np, const double *p, const double *V, double *dp);

#endif
