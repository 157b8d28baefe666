/* Pools of bodies in vector code, past whose joints the sweeps carry what is open
 * (newton/sweeps/fronts.h).
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Their numbers count perturbations as the sweeps do (newton/sweeps/perturbation.h), about the
 * body's point and along the world's axes, in groups of four with an idle one: of Q chi (angular,
 * linear), moment, force, and psi (angular, linear) where the body is below a massless joint; of R
 * rotation, nu (angular, linear), displacement; of kappa moment and force. All else is as in the
 * pools of blocks.
 *
 * From a body to its predecessor, or to where its loops close, nothing moves: the first joint that
 * hands on to a pool leaves it its own, changed. Pools that follow each other so are a strand. It
 * has its lists of names to itself, and right-hand sides; its matrices are a slot that the next
 * strand takes. Memory is laid out in the order of the sweep. */
#ifndef MBSRI_LANE_POOLS_H
#define MBSRI_LANE_POOLS_H

#include "newton/carried/record.h"

/* Numbers of perturbations, forces and kappa of a body in vector code. */
enum { MBSRI_LANE_MOTIONS = 16, MBSRI_LANE_ACTIONS = 24, MBSRI_LANE_FORCES = 8 };

/* Numbers of an unknown, and its row, that the solution needs for each axis of a joint. */
enum { MBSRI_LANE_RECORD = 5 };

/* Numbers come in groups of four. */
static inline int mbsri_lane_span(int count)
{
    return (count + 3) / 4 * 4;
}

/* Numbers of a closing front of `count` unknowns that the solution needs: LU of T, two scales and
 * the right-hand sides, and of each unknown its column of Q and row of W, without idle ones but one
 * behind the last. */
static inline size_t mbsri_closing_size(int count)
{
    const size_t n = (size_t)count, span = (size_t)mbsri_lane_span(count);
    return (n + 3) * span + (MBSRI_LANE_MOTIONS + MBSRI_LANE_ACTIONS) / 4 * 3 * n + 4;
}

/* Places the strands behind `doubles` and `ints`, when the pools of blocks are counted. False:
 * there is no memory for scratch. */
bool mbsri_place_lane_pools(mbsr_newton *w, size_t *doubles, size_t *ints);

#endif
