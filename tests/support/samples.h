/* The stock joints in space as sequences of elementary motions, told without the library, and a
 * root that moves in space.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_SAMPLES_H
#define TEST_SAMPLES_H

#include "space.h"
#include "transform.h"

#include <stdbool.h>

/* One elementary motion: exp of s (w, v), with s = q[coordinate] or a prescribed wave; a quaternion
 * takes q[0 .. 3]. */
typedef struct elementary {
    double w[3], v[3];
    int coordinate;
    bool driven, quaternion;
} elementary;

typedef struct sample {
    mbsr_joint joint;
    mbsr_frame A, B;
    int steps;
    elementary step[6];
} sample;

/* Number k < SAMPLE_JOINTS: weld, revolute, prismatic, screw, cylindrical, universal, in-plane,
 * translational, spherical, free, and a compound joint of five axes, two of them driven; random
 * frames and axes. */
enum { SAMPLE_JOINTS = 11 };
sample sample_make(int k, test_rng *rng);

/* The body in the predecessor: A, the steps, and back along B. */
transform sample_pose(const sample *s, const double *q, double t);

/* A smooth function of t and its derivatives; prescribed coordinate k follows number
 * SAMPLE_DRIVEN + k. */
enum { SAMPLE_DRIVEN = 7 };
double sample_wave(int k, double t, int derivative);

/* An mbsr_root_fn for a SPATIAL root that turns about two axes and moves in all directions. */
int sample_root(void *user, double t, double *p, double *V, double *A);

#endif
