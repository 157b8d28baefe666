/* Bodies made by hand, for force elements whose tables are called without a model.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_PARTS_H
#define TEST_PARTS_H

#include "expect.h"

typedef struct test_part {
    mbsr_space space;
    int d, np;
    double p[12], V[6], f[6], M[36];
    double q[3], u[3], tau[3]; /* of a joint with n = nq = 3 */
} test_part;

/* A part at rest at the origin. */
static inline test_part test_part_make(mbsr_space space)
{
    static const int d[] = {0, 0, 2, 3, 6}, np[] = {0, 0, 2, 3, 12};
    test_part part = {.space = space, .d = d[space], .np = np[space]};
    for (int k = 0; space == MBSR_SPACE_SPATIAL && k < 3; ++k) part.p[4 * k] = 1.0;
    return part;
}

/* One in a random pose, with random velocities. */
static inline test_part test_part_random(mbsr_space space, test_rng *rng)
{
    test_part part = test_part_make(space);
    double quaternion[4];
    test_fill(rng, part.np, part.p);
    test_fill(rng, part.d, part.V);
    test_fill(rng, 4, quaternion);
    test_fill(rng, 3, part.q);
    test_fill(rng, 3, part.u);
    if (space == MBSR_SPACE_SPATIAL) mbsr_quaternion_rotation(quaternion, part.p);
    return part;
}

/* The part after it has moved on with constant V for a time h; R <- exp(h omega) R. */
static inline test_part test_part_moved(const test_part *part, double h)
{
    test_part moved = *part;
    for (int k = 0; k < 3; ++k) moved.q[k] += h * part->u[k];
    if (part->space != MBSR_SPACE_SPATIAL) {
        for (int k = 0; k < part->np; ++k) moved.p[k] += h * part->V[k];
        return moved;
    }
    const double *w = part->V;
    const double size = sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
    mbsr_frame at = mbsr_frame_identity();
    memcpy(at.R, part->p, sizeof at.R);
    const mbsr_frame turn =
        size > 0.0 ? mbsr_frame_rotated(NULL, w, h * size) : mbsr_frame_identity();
    at = mbsr_frame_product(&turn, &at);
    memcpy(moved.p, at.R, sizeof at.R);
    for (int k = 0; k < 3; ++k) moved.p[9 + k] += h * part->V[3 + k];
    return moved;
}

typedef enum test_question { TEST_FORCES, TEST_ENERGY, TEST_DISSIPATION } test_question;

/* Asks an element about parts (two, or one): forces go to f and tau, replacing what is there;
 * energy and dissipation to *value. Returns the element's status. */
static inline int test_ask(const mbsr_force_def *def, test_part *parts, int count,
                           test_question ask, double *value)
{
    mbsr_force_body body[2];
    for (int k = 0; k < count; ++k) {
        test_part *part = parts + k;
        const int ground = def->body[k] == MBSR_GROUND && def->bodies > 0;
        body[k] = (mbsr_force_body){.id = def->body[k],
                                    .space = part->space,
                                    .d = part->d,
                                    .np = part->np,
                                    .n = ground ? 0 : 3,
                                    .nq = ground ? 0 : 3,
                                    .p = part->p,
                                    .V = ask == TEST_ENERGY ? NULL : part->V,
                                    .f = ask == TEST_FORCES ? part->f : NULL};
        if (!ground) {
            static const mbsr_inertia by_function = {.kind = MBSR_INERTIA_FUNCTION};
            body[k].M = part->M;
            body[k].inertia = &by_function;
            body[k].q = part->q;
            body[k].u = ask == TEST_ENERGY ? NULL : part->u;
            body[k].tau = ask == TEST_FORCES ? part->tau : NULL;
        }
        if (ask == TEST_FORCES) {
            memset(part->f, 0, sizeof part->f);
            memset(part->tau, 0, sizeof part->tau);
        }
    }
    const mbsr_force_args args = {.force = def, .t = 0.5, .bodies = count, .body = body};
    if (ask == TEST_FORCES) return def->table->evaluate(&args);
    *value = 0.0;
    if (ask == TEST_ENERGY) return def->table->energy ? def->table->energy(&args, value) : 0;
    return def->table->dissipation ? def->table->dissipation(&args, value) : 0;
}

static inline double test_value(const mbsr_force_def *def, test_part *parts, int count,
                                test_question ask)
{
    double value = NAN;
    assert_int_equal(test_ask(def, parts, count, ask, &value), 0);
    return value;
}

/* Power of the forces that are in f and tau. */
static inline double test_power(const test_part *parts, int count)
{
    double power = 0.0;
    for (int k = 0; k < count; ++k) {
        for (int c = 0; c < parts[k].d; ++c) power += parts[k].f[c] * parts[k].V[c];
        for (int c = 0; c < 3; ++c) power += parts[k].tau[c] * parts[k].u[c];
    }
    return power;
}

/* Rate of an element's energy along V and u, by a central difference. */
static inline double test_energy_rate(const mbsr_force_def *def, const test_part *parts, int count)
{
    const double h = 1e-5;
    double E[2];
    for (int side = 0; side < 2; ++side) {
        test_part moved[2];
        for (int k = 0; k < count; ++k) moved[k] = test_part_moved(parts + k, side ? h : -h);
        E[side] = test_value(def, moved, count, TEST_ENERGY);
    }
    return (E[1] - E[0]) / (2.0 * h);
}

/* Fails unless the power of the forces is -dE/dt - dissipation and the latter is not negative;
 * returns the dissipation. */
static inline double test_balance(const mbsr_force_def *def, test_part *parts, int count)
{
    assert_int_equal(test_ask(def, parts, count, TEST_FORCES, NULL), 0);
    const double power = test_power(parts, count), rate = test_energy_rate(def, parts, count),
                 loss = test_value(def, parts, count, TEST_DISSIPATION);
    assert_close(power, -rate - loss, 1e-7 * (1.0 + fabs(rate) + fabs(loss)));
    assert_less(-1e-12 * (1.0 + fabs(rate)), loss);
    return loss;
}

#endif
