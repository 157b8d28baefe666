/* Random trees of general bodies: smooth non-linear joints, masses of any rank, force elements.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_TREE_H
#define TEST_TREE_H

#include "close.h"

#include <mbsrank/mbsrank.h>

/* A joint with every term of (7)-(9):
 *
 *   k = K0 p + a sin(p) + H0 p_pi + a h sin(w . p_pi) + J0 q + a g sin(v . q) + c sin(t)
 *
 * entry by entry in sin(p); position is found by Newton's method. */
enum { TEST_MAX_D = 12 };

typedef struct test_joint {
    int d, d_pred, n;
    double a;
    double K0[TEST_MAX_D * TEST_MAX_D], H0[TEST_MAX_D * TEST_MAX_D], J0[TEST_MAX_D * TEST_MAX_D];
    double h[TEST_MAX_D], w[TEST_MAX_D], g[TEST_MAX_D], v[TEST_MAX_D], c[TEST_MAX_D];
} test_joint;

extern const mbsr_joint_table test_joint_table;

/* The same joint with its derivatives (newton.h), and without its rates. */
extern const mbsr_joint_table test_joint_tangents, test_joint_bare;

typedef struct test_tree_opt {
    uint64_t seed;
    int bodies;
    int max_d;        /* d in 1 .. max_d */
    int welds;        /* n from 0 (1: from 0, 0: from 1) */
    double deficient; /* share of bodies with a rank-deficient mass matrix, ranks 0 .. d-1 */
    double bend;      /* a: size of the non-linear terms */
    int forces;       /* spring-dampers between random bodies, and on every joint coordinate */
    int moving_root;  /* general root of d = 2 that moves */
    int shuffle;      /* ids in random order, predecessors possibly later */
    int tables;       /* joints with derivatives, without, and without rates in turn */
    int units;        /* every joint coordinate by a unit of its own, from 1e-6 to 1e6 */
} test_tree_opt;

/* A finished model and what it was made of; joint, parent, mass indexed by id. */
typedef struct test_tree {
    test_tree_opt opt;
    mbsr_model *model;
    mbsr_data *data;
    int N, nu;
    int *parent; /* ids */
    int *label;  /* id -> place in the original order (parents first) */
    test_joint *joint;
    double **mass;
    int root_d;
} test_tree;

void test_tree_make(test_tree *tree, test_tree_opt opt);
void test_tree_free(test_tree *tree);

#endif
