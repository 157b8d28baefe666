/* Uniform gravity on bodies in the plane: f = M (gx, gy, 0), energy -g . (m r + first moment).
 * SPDX-License-Identifier: BSD-3-Clause */
#include "stock.h"

static bool applies(const mbsr_force_body *body)
{
    return body->space == MBSR_SPACE_POINT || body->space == MBSR_SPACE_PLANAR;
}

static int evaluate(const mbsr_force_args *args)
{
    const mbsr_force_body *body = args->body;
    const double *g = args->force->param;
    if (!applies(body)) return MBSR_OK;
    for (int k = 0; k < body->d; ++k) body->f[k] += body->M[k] * g[0] + body->M[body->d + k] * g[1];
    return MBSR_OK;
}

/* A constant M pulls with the same force everywhere: -g . (M p). A rigid body's first moment
 * turns. */
static int energy(const mbsr_force_args *args, double *energy_out)
{
    const mbsr_force_body *body = args->body;
    const double *g = args->force->param, *M = body->M;
    if (!applies(body)) return MBSR_OK;
    const int d = body->d;
    const bool constant = body->inertia->kind == MBSR_INERTIA_MATRIX;
    for (int j = 0; j < (constant ? d : 2); ++j) {
        for (int k = 0; k < 2; ++k) *energy_out -= g[k] * M[j * d + k] * body->p[j];
    }
    if (d == 3 && !constant) *energy_out -= g[0] * M[7] - g[1] * M[6];
    return MBSR_OK;
}

static const mbsr_force_table gravity_table = {
    .version = MBSR_FORCE_TABLE_VERSION,
    .flags = MBSR_FORCE_EVERY_BODY,
    .name = "gravity",
    .evaluate = evaluate,
    .energy = energy,
};

mbsr_force_def mbsr_force_gravity(double gx, double gy)
{
    mbsr_force_def def = mbsri_stock_force(&gravity_table, 0, MBSR_GROUND, MBSR_GROUND);
    def.param[0] = gx;
    def.param[1] = gy;
    return def;
}
