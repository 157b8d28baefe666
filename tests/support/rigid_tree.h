/* Random trees of rigid bodies in space under gravity.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_RIGID_TREE_H
#define TEST_RIGID_TREE_H

#include <mbsrank/mbsrank.h>

#include <stdint.h>

/* A model with data, a random state, and room for results. */
typedef struct test_rigid_tree {
    mbsr_model *model;
    mbsr_data *data;
    int nq, nu;
    double t;
    double *q, *u, *tau, *udot, *expected;
    mbsr_joint_table *table; /* of the joints without derivatives */
} test_rigid_tree;

typedef struct test_rigid_choice {
    uint64_t seed;
    int bodies;
    double massless;  /* share of bodies without inertia */
    double light;     /* share of bodies 1e-6 to 1e-16 times as heavy as the others */
    double points;    /* share of particles and rods */
    double many;      /* share of joints with several axes or quaternions */
    double branching; /* 0: a chain */
    int floating;     /* what stands on the root floats, along the root's axes */
    double length;    /* of links */
    int forces;       /* springs, bushings, drag on every body, joint springs and friction */
    int moving;       /* the root moves */
    int shuffle;      /* ids against the order of the tree */
    double held;      /* share of joint coordinates that are locked */
    double added;     /* share of bodies with something added to their mass matrix */
    double armature;  /* share of joints with armature */
    int tables;       /* joints with derivatives (newton.h), without, and without rates in turn */
    const mbsr_model_def *def;      /* NULL: default; `moving` changes its root */
    const mbsr_force_def *elements; /* more force elements */
    int element_count;
} test_rigid_choice;

void test_rigid_tree_make(test_rigid_tree *tree, test_rigid_choice choice);
void test_rigid_tree_free(test_rigid_tree *tree);

#endif
