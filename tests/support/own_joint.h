/* The smallest joint of a caller's own: a body of one dimension with p = q, in GENERAL space.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_OWN_JOINT_H
#define TEST_OWN_JOINT_H

#include <mbsrank/mbsrank.h>

static int test_own_position(const mbsr_joint_args *args, double *p)
{
    p[0] = args->q[0];
    return 0;
}

static int test_own_jacobians(const mbsr_joint_args *args, double *K, double *H, double *J,
                              double *kI)
{
    (void)args, (void)K, (void)H, (void)kI;
    J[0] = -1.0;
    return 0;
}

static int test_own_bias(const mbsr_joint_args *args, double *kII)
{
    (void)args, (void)kII;
    return 0;
}

/* For mbsr_joint_custom with d = n = 1. */
static const mbsr_joint_table test_own_table = {.version = MBSR_JOINT_TABLE_VERSION,
                                                .flags = MBSR_JOINT_UNIT_K,
                                                .name = "own",
                                                .position = test_own_position,
                                                .jacobians = test_own_jacobians,
                                                .bias = test_own_bias};

#endif
