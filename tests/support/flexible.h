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

/* A planar pendulum with two bending modes, g = 9.81 along -y. */
void test_flexible_pendulum(test_flexible *w, double EI);

/* Two beams, the second held at its tip, with a rigid body that slides on its root, in space. `reversed`:
 * ids the other way round, as far as can be, and markers nobody uses. */
void test_flexible_tree(test_flexible *w, int reversed);

/* A pendulum in space with a massless mode, force (1, -2, 0.5) at the tip. */
void test_flexible_massless(test_flexible *w);

void test_flexible_free(test_flexible *w);

#endif
