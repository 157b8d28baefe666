/* Bodies in space on joints of a user's own, in the vectorised sweeps: the joint's functions say
 * how it moves, and the rest is as for a stock joint of several axes (multi_axis.h).
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * With K = 1, (8) and (9) read V = X V_pred + S u + drive with X = -H, S = -J, drive = -kI, and X
 * has to be a translation: the body's V is along the world's axes about its own origin, and what it
 * does with its predecessor's is that of a rigid body. Most joints between bodies in space are of
 * this kind; whether one is, is looked up when the model is finished and checked in each
 * evaluation. */
#ifndef MBSRI_USERS_JOINT_H
#define MBSRI_USERS_JOINT_H

#include "sweeps/tree.h"

/* Where body i, whose predecessor is done, is and how it moves; a status. MBSRI_NOT_SERVED: its H
 * is no translation here. */
int mbsri_users_move(const mbsri_sweep_run *run, int i);

/* The rates of S of all such bodies; a status. */
int mbsri_users_rates(const mbsri_sweep_run *run);

#endif
