/* Random trees of points and rigid bodies in the plane, with axis springs and inertias of every
 * sort, also by function.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_PLANE_TREE_H
#define TEST_PLANE_TREE_H

#include <mbsrank/mbsrank.h>

#include <stdint.h>

enum { TEST_PLANE_BODIES = 16 };

typedef struct test_plane_choice {
    uint64_t seed;
    int bodies;
    double massless; /* share of bodies without inertia */
    int functions;   /* some inertias by function */
    int rigid;       /* no inertia by matrix, no point among the predecessors of a body */
    int moving;      /* the root moves */
    int damped;      /* spring and damper from every body to the ground */
} test_plane_choice;

/* The structure must stay where it is until it is freed. */
typedef struct test_plane_tree {
    mbsr_model *model;
    mbsr_data *data;
    int nq, nu;
    double t, q[3 * TEST_PLANE_BODIES], u[3 * TEST_PLANE_BODIES];     /* a random state */
    double shape[TEST_PLANE_BODIES][9], matrix[TEST_PLANE_BODIES][9]; /* of inertias */
} test_plane_tree;

void test_plane_make(test_plane_tree *tree, test_plane_choice choice);
void test_plane_free(test_plane_tree *tree);

/* M = S S^T (1.5 + sin(w . p + t)) with S = user[0 .. d*d), and some h quadratic in V: an inertia
 * by function for bodies whose pose is d numbers at least. */
int test_inertia_2(void *user, double t, const double *p, const double *V, double *M, double *h);
int test_inertia_3(void *user, double t, const double *p, const double *V, double *M, double *h);
int test_inertia_6(void *user, double t, const double *p, const double *V, double *M, double *h);

#endif
