/* Kinematics (7)-(9), root to leaves. The entry points that check are in dynamics/stages.c.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_KINEMATICS_H
#define MBSRI_KINEMATICS_H

#include "recursion/data.h"

/* Stages; q, u, qdot in the caller's order. MBSR_ERR_LEAN for lean data, MBSR_NOT_FINITE, statuses
 * of the joints' functions. */
int mbsri_positions(const mbsr_model *m, mbsr_data *d, double t, const double *q);
int mbsri_velocities(const mbsr_model *m, mbsr_data *d, const double *u);

/* The same for one body, whose predecessor is done, from q and u of the data. */
int mbsri_position_of(const mbsr_model *m, mbsr_data *d, int i);
int mbsri_velocity_of(const mbsr_model *m, mbsr_data *d, int i);

/* Of these what the joint does: pose, H, J, kI; V and kII. */
int mbsri_place_joint(const mbsr_model *m, mbsr_data *d, int i);
int mbsri_move_joint(const mbsr_model *m, mbsr_data *d, int i);

/* q' = G u at the state of mbsri_velocities. */
int mbsri_coordinate_rates(const mbsr_model *m, mbsr_data *d, double *qdot);
int mbsri_coordinate_rates_of(const mbsr_model *m, mbsr_data *d, int i, double *qdot);

/* Brings q to its normal form (quaternions of length 1). */
int mbsri_normalise(const mbsr_model *m, mbsr_data *d, double *q);

/* Pose, velocity and acceleration of the root at the data's time. */
int mbsri_move_root(const mbsr_model *m, mbsr_data *d);

/* The arguments of body i's joint functions; `velocities`: V, V_pred and u are there. */
mbsr_joint_args mbsri_joint_args(const mbsr_model *m, const mbsr_data *d, int i, bool velocities);

/* Reports a callback's status for body i's joint. */
int mbsri_joint_failed(const mbsr_model *m, mbsr_data *d, int i, int status, const char *function);

#endif
