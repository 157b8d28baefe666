/* Which joints are those of flexible bodies.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_JOINTS_FLEXIBLE_H
#define MBSRI_JOINTS_FLEXIBLE_H

#include <mbsrank/flex.h>

#include <stdbool.h>

/* The data of a joint that is a marker, or a mount; NULL: it is none. user: of the joint. */
const mbsr_flex *mbsri_marker_of(const mbsr_joint_table *table, const void *user);
const mbsr_flex *mbsri_mount_of(const mbsr_joint_table *table, const void *user);

/* Whether the marker keeps its place in the body's frame, whatever its modes do. */
bool mbsri_mount_rests(const mbsr_flex *flex, int marker);

#endif
