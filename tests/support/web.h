/* Force elements that read all they may of their bodies and act on all of it.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_WEB_H
#define TEST_WEB_H

#include <mbsrank/mbsrank.h>

typedef enum test_web_kind {
    TEST_WEB_ALL,    /* f and tau by the pose, V, q and u */
    TEST_WEB_JOINTS, /* tau by q and u: MBSR_FORCE_JOINT_ONLY */
    TEST_WEB_BODIES, /* f by the pose and V: MBSR_FORCE_NO_JOINT */
    TEST_WEB_KINDS
} test_web_kind;

/* Forces of two smooth functions of sums over all that is read, of about this size; with or without
 * derivatives of its own. */
mbsr_force_def test_web(test_web_kind kind, int bodies, const int *body, double size,
                        int derivatives);

/* The same on every body, each by itself. */
mbsr_force_def test_web_everywhere(double size, int derivatives);

#endif
