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

/* Before a factorisation: empties them. */
void mbsri_swept_clear(mbsr_newton *w);

/* Where a body is, as the sweeps know it: from its point to the origin of its own frame, the angular
 * velocity, the velocity of that origin. */
typedef struct mbsri_swept_place {
    const double *arm, *omega, *v;
} mbsri_swept_place;

/* Adds to pool k what closures are at its body, which mbsri_carried_open has put into the pool of the
 * same number by the body's own coordinates. */
void mbsri_swept_take_ends(mbsr_newton *w, int k, const mbsri_swept_place *at);

#endif
