/* Pieces of models in space that several tests use.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_SPACE_H
#define TEST_SPACE_H

#include "close.h"

#include <mbsrank/mbsrank.h>

/* A random rotation, and a frame with origin within `reach` in every direction. */
static inline mbsr_frame test_frame(test_rng *rng, double reach)
{
    double quaternion[4], x[3];
    test_fill(rng, 4, quaternion);
    test_fill(rng, 3, x);
    for (int k = 0; k < 3; ++k) x[k] *= reach;
    return mbsr_frame_quaternion(x, quaternion);
}

/* tau = -(damping u + stiffness sin q) on every coordinate of a joint; on a quaternion for angle
 * theta about the unit vector a: -(damping omega + stiffness sin(theta) a). */
mbsr_force_def test_joint_law(int body, double stiffness, double damping);

/* Joints of every stock kind in space, with random frames and axes; lengths in `unit`. A driven
 * axis of the compound joint follows test_motion. */
enum {
    TEST_WELD,
    TEST_REVOLUTE,
    TEST_PRISMATIC,
    TEST_SCREW,
    TEST_CYLINDRICAL,
    TEST_UNIVERSAL,
    TEST_IN_PLANE,
    TEST_TRANSLATIONAL,
    TEST_COMPOUND,
    TEST_SPHERICAL,
    TEST_FREE,
    TEST_DRIVEN,
    TEST_KINDS
};
mbsr_joint test_joint_in_space(test_rng *rng, int kind, double unit);

/* 0.3 sin(2 t + 0.4), for one driven axis. */
int test_motion(void *user, double t, double *s, double *sdot, double *sddot);

/* A random tree of bodies that are a few mass points each: none is no mass, one has rank 3, two
 * have rank 5. */
enum { TEST_MAX_POINTS = 4 };

typedef struct test_points {
    int count;
    double mass[TEST_MAX_POINTS], at[TEST_MAX_POINTS][3];
} test_points;

typedef struct test_space_opt {
    uint64_t seed;
    int bodies;
    double deficient;    /* share of bodies with 0, 1 or 2 points; the others have 4 */
    int driven;          /* driven axes and a moving root among the joints */
    int laws;            /* test_joint_law on every joint */
    double gravity;      /* m/s^2, in an oblique direction */
    double length, mass; /* how many units of the model make 1 m and 1 kg; 0: 1 */
} test_space_opt;

typedef struct test_space_tree {
    mbsr_model *model;
    mbsr_data *data;
    int N, nq, nu, rows; /* rows: 3 for each mass point of the tree */
    double unit;         /* 1 m */
    double g[3];
    int *parent;
    test_points *points;
    double *q, *u; /* a random state */
} test_space_tree;

void test_space_make(test_space_tree *tree, test_space_opt opt);
void test_space_free(test_space_tree *tree);

/* Positions or, at mbsr_stage_velocities, velocities of all mass points times sqrt(mass): rows
 * numbers. The data must be at that stage. */
void test_space_positions(const test_space_tree *tree, double *x);
void test_space_velocities(const test_space_tree *tree, double *v);

/* dv/du of these velocities: rows x nu, column-major. The mass matrix is its square. Needs
 * mbsr_stage_positions. */
void test_space_jacobian(const test_space_tree *tree, double *P);

/* Rank of the columns `use` (count of them) of A (rows x any), scaled to unit length; columns
 * shorter than 1e-11 of the longest count as zero. Singular values above 1e-7 count; kept and
 * dropped get the smallest counted and the largest other, if they are beyond what is there. */
int test_column_rank(int rows, const double *A, int count, const int *use, double *kept,
                     double *dropped);

#endif
