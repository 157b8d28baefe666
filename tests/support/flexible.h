/* Models of reference with flexible bodies.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_FLEXIBLE_H
#define TEST_FLEXIBLE_H

#include "ritz.h"

enum { TEST_FLEXIBLE_NU = 8 };

/* A model, its modal data and a state; ids of bodies that are asked for. */
typedef struct test_flexible {
    mbsr_flex *flex[2];
    mbsr_model *model;
    mbsr_data *data;
    int flexible[2], tip, last;
    double q[TEST_FLEXIBLE_NU], u[TEST_FLEXIBLE_NU];
} test_flexible;

/* A pendulum that turns about z and has a marker at the end, g = 9.81 along -y; and the planar one
 * of two bending modes. */
void test_flexible_swing(test_flexible *w, const test_ritz *beam);
void test_flexible_pendulum(test_flexible *w, double EI, int stiffening);

/* Two beams, the second held at its tip, with a rigid body that slides on its root, in space.
 * `reversed`: ids the other way round, as far as can be, and markers nobody uses. */
void test_flexible_tree(test_flexible *w, int reversed, int stiffening);

/* A pendulum in space with a massless mode, force (1, -2, 0.5) at the tip. */
void test_flexible_massless(test_flexible *w);

void test_flexible_free(test_flexible *w);

#endif
