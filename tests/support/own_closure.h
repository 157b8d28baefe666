/* A closure of a caller's own between two bodies in space.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_OWN_CLOSURE_H
#define TEST_OWN_CLOSURE_H

#include <mbsrank/mbsrank.h>

/* g = r_a . r_b - constant, without and with its derivatives */
static int test_own_gap(const mbsr_closure_args *args, double *g)
{
    const double *a = args->body[0].p + MBSR_POSE_X, *b = args->body[1].p + MBSR_POSE_X;
    g[0] = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] - args->closure->param[0];
    return 0;
}

static int test_own_gap_jacobian(const mbsr_closure_args *args, const mbsr_closure_jacobian *out)
{
    for (int k = 0; k < 3; ++k) {
        out->matrix[out->column[0] + 3 + k] = args->body[1].p[MBSR_POSE_X + k];
        out->matrix[out->column[1] + 3 + k] = args->body[0].p[MBSR_POSE_X + k];
    }
    return 0;
}

static const mbsr_closure_table test_own_closure[] = {
    {.version = MBSR_CLOSURE_TABLE_VERSION, .name = "bare", .position = test_own_gap},
    {.version = MBSR_CLOSURE_TABLE_VERSION,
     .name = "own",
     .position = test_own_gap,
     .jacobian = test_own_gap_jacobian}};

#endif
