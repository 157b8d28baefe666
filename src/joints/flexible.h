/* Which joints are those of flexible bodies.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_JOINTS_FLEXIBLE_H
#define MBSRI_JOINTS_FLEXIBLE_H

#include "flexible/marker.h"

#include <mbsrank/flex.h>
#include <mbsrank/joint.h>

#include <stdbool.h>

/* The data of a joint that is a marker, or a mount; NULL: it is none. user: of the joint. */
const mbsr_flex *mbsri_marker_of(const mbsr_joint_table *table, const void *user);
const mbsr_flex *mbsri_mount_of(const mbsr_joint_table *table, const void *user);

/* Whether the marker keeps its place in the body's frame, whatever its modes do. */
bool mbsri_mount_rests(const mbsr_flex *flex, int marker);

/* What `tangent` and `rate_tangent` of a marker say of dp, dH and of dkII, dH' along several
 * changes of one state, which is looked at once, with its velocities. */
void mbsri_marker_see(const mbsr_joint_args *args, mbsri_flex_view *view);
void mbsri_marker_change(const mbsr_joint_args *args, const mbsr_joint_change *by,
                         mbsri_flex_view *view, double *dp, double *dH);
void mbsri_marker_rate_change(const mbsr_joint_args *args, const mbsr_joint_change *by,
                              mbsri_flex_view *view, double *dkII, double *dHdot);

#endif
