/* Stock joints of which coordinates are locked, and on other predecessors, as stock joints again.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_LOCKED_JOINTS_H
#define MBSRI_LOCKED_JOINTS_H

#include "joints/chain.h"
#include "model/record.h"

/* Room for the parameters of one. */
enum { MBSRI_LOCKED_PARAMS = MBSR_JOINT_PARAMS };

/* Whether it is a stock joint whose frames are known: a chain of steps, or one in the plane. */
bool mbsri_joint_has_frames(const mbsri_joint *joint);

/* The joint with the coordinates that are not NaN in `locked_at` (joint->n) locked at these
 * values, if that is such a joint; its parameters go to param (room for MBSRI_LOCKED_PARAMS).
 * False: it is none.
 */
bool mbsri_lock_joint(const mbsri_joint *joint, const double *locked_at, double *param,
                      mbsri_joint *left);

/* The joint's frame A, in param, as seen by a body on which its predecessor stands. */
void mbsri_carry_joint(const mbsri_joint *joint, const mbsri_stand *pred, double *param);

/* Of a joint without coordinates, free or driven: where the body stands on its predecessor. False:
 * it has some. */
bool mbsri_rigid_joint(const mbsri_joint *joint, mbsri_stand *stand);

#endif
