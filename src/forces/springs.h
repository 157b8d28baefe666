/* The linear springs among the stock force elements, read back from their definitions.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_SPRINGS_H
#define MBSRI_SPRINGS_H

#include <mbsrank/force.h>

#include <stdbool.h>

typedef enum mbsri_spring_kind {
    MBSRI_POINT_SPRING,
    MBSRI_AXIS_SPRING,
    MBSRI_BUSHING,
    MBSRI_PLANAR_BUSHING,
    MBSRI_JOINT_SPRING,
    MBSRI_GEAR
} mbsri_spring_kind;

typedef struct mbsri_spring {
    mbsri_spring_kind kind;
    /* points (point springs), frames (12 numbers, or x, y, angle) of both bodies */
    double a[12], b[12];
    double stiffness[9], damping[9]; /* one, six, or two matrices (planar bushings) */
    double rest, ratio;
    int coordinate[2];  /* the axis, or the joint coordinates */
    const char *beyond; /* what of it is not linear; NULL: nothing */
} mbsri_spring;

/* Each returns whether it is such an element; *spring arrives as zero. */
bool mbsri_read_point_spring(const mbsr_force_def *def, mbsri_spring *spring);
bool mbsri_read_axis_spring(const mbsr_force_def *def, mbsri_spring *spring);
bool mbsri_read_bushing(const mbsr_force_def *def, mbsri_spring *spring);
bool mbsri_read_planar_bushing(const mbsr_force_def *def, mbsri_spring *spring);
bool mbsri_read_joint_spring(const mbsr_force_def *def, mbsri_spring *spring);
bool mbsri_read_gear(const mbsr_force_def *def, mbsri_spring *spring);

/* Tells a point spring with a law by function what rates are usual in its model, m/s; 0: not known.
 */
void mbsri_spring_set_rate(mbsr_force_def *def, double rate);

#endif
