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

/* Uniform gravity on bodies in space, as a force element of the tests. */
static inline int test_gravity_evaluate(const mbsr_force_args *args)
{
    const mbsr_force_body *body = args->body;
    for (int k = 0; k < 6; ++k) {
        for (int c = 0; c < 3; ++c) body->f[k] += body->M[6 * (3 + c) + k] * args->force->param[c];
    }
    return MBSR_OK;
}

static inline int test_gravity_energy(const mbsr_force_args *args, double *energy)
{
    const mbsr_force_body *body = args->body;
    const double *M = body->M, *g = args->force->param;
    const double first[3] = {M[26], M[30], M[19]};
    for (int c = 0; c < 3; ++c) *energy -= g[c] * (M[21] * body->p[MBSR_POSE_X + c] + first[c]);
    return MBSR_OK;
}

static const mbsr_force_table test_gravity_table = {
    .version = MBSR_FORCE_TABLE_VERSION,
    .flags = MBSR_FORCE_EVERY_BODY,
    .name = "test gravity",
    .evaluate = test_gravity_evaluate,
    .energy = test_gravity_energy,
};

static inline mbsr_force_def test_gravity(double gx, double gy, double gz)
{
    mbsr_force_def def = mbsr_force_custom(&test_gravity_table, 0, NULL, NULL);
    def.param[0] = gx;
    def.param[1] = gy;
    def.param[2] = gz;
    return def;
}

#endif
