/* Flexible beams in closed form: along x from the root, modes Phi = e_dir (x / L)^power.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_RITZ_H
#define TEST_RITZ_H

#include <mbsrank/mbsrank.h>

enum { TEST_RITZ_MODES = 6, TEST_RITZ_SHORTENINGS = 10, TEST_RITZ_MARKERS = 3 };

typedef struct test_ritz {
    double length, density, tip; /* m, kg/m, a point mass at the end in kg */
    int modes, dir[TEST_RITZ_MODES], massless[TEST_RITZ_MODES];
    double power[TEST_RITZ_MODES];
    double K[TEST_RITZ_MODES * TEST_RITZ_MODES], D[TEST_RITZ_MODES * TEST_RITZ_MODES];
    int markers;
    double at[TEST_RITZ_MARKERS];       /* x of the markers */
    mbsr_frame turn[TEST_RITZ_MARKERS]; /* their axes; zeros: those of the body */
    int stiffening; /* with the shortening along x that bending brings, in second order */
} test_ritz;

/* To be destroyed. */
mbsr_flex *test_ritz_make(const test_ritz *beam);

/* Bends along y by (x / L)^2, (x / L)^3, ..; markers at both ends. */
test_ritz test_ritz_bending(int modes, double length, double EI, double density);

/* The beams of three reference problems: a planar pendulum with bending stiffness EI, the two of a
 * spatial tree, and one with a massless mode. */
test_ritz test_ritz_pendulum(double EI);
test_ritz test_ritz_first(void);
test_ritz test_ritz_second(void);
test_ritz test_ritz_massless(void);

#endif
