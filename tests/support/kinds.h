/* Random trees in which rigid bodies on stock joints, the same on joints of a caller's own, with an
 * added mass or a locked coordinate, and bodies of any dimension stand in any order.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_KINDS_TREE_H
#define TEST_KINDS_TREE_H

#include <mbsrank/mbsrank.h>

#include <stdint.h>

enum { TEST_KINDS_BODIES = 12 };

typedef struct test_kinds_choice {
    uint64_t seed;
    int bodies;
    int plane;       /* bodies in the plane, without those of any dimension */
    double own;      /* share of joints with a caller's table, added masses, locked coordinates */
    double general;  /* share of bodies of any dimension */
    double many;     /* share of joints of several axes */
    double massless; /* share of bodies without inertia; half as many have a deficient one */
    int springs;     /* between bodies, neighbours among them */
} test_kinds_choice;

/* A joint of a body of dimension d in GENERAL space: with the point x = r + R b of a predecessor in
 * space, or x its pose,
 *
 *   p = C x + J0 (q + 0.3 sin q) */
typedef struct test_kinds_joint {
    double b[3], C[12 * 12], J0[12 * 3];
} test_kinds_joint;

/* The structure must stay where it is until it is freed. */
typedef struct test_kinds_tree {
    mbsr_model *model;
    mbsr_data *data;
    int bodies, nq, nu;
    double t, *q, *u; /* a random state */
    int parent[TEST_KINDS_BODIES];
    int own[TEST_KINDS_BODIES]; /* 1: of another kind than rigid on a stock joint; 2: any dimension
                                 */
    mbsr_joint_table table[TEST_KINDS_BODIES];
    test_kinds_joint joint[TEST_KINDS_BODIES];
} test_kinds_tree;

void test_kinds_make(test_kinds_tree *tree, test_kinds_choice choice);
void test_kinds_free(test_kinds_tree *tree);

#endif
