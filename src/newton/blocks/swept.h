/* Pools of bodies in vector code, past whose joints the sweeps carry what is open (newton/sweeps/fronts.h).
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Their numbers count perturbations as the sweeps do (newton/sweeps/perturbation.h), about the body's point
 * and along the world's axes, in groups of four with an idle one: of Q chi (angular, linear), moment,
 * force, and psi (angular, linear) where the body is deep; of R rotation, nu (angular, linear),
 * displacement; of kappa moment and force. All else is as in the pools of blocks. */
#ifndef MBSRI_SWEPT_H
#define MBSRI_SWEPT_H

#include "newton/blocks/carried.h"

/* Where a body is, as the sweeps know it: from its point to the origin of its own frame, the angular
 * velocity, the velocity of that origin. */
typedef struct mbsri_swept_place {
    const double *arm, *omega, *v;
} mbsri_swept_place;

/* Adds to the pools of body i what closures are at it, after mbsri_carried_open, which leaves it out. */
void mbsri_swept_take_ends(mbsr_newton *w, const mbsr_data *d, int i, const mbsri_swept_place *at);

#endif
