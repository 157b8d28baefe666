/* Models for the tests of this folder, piece by piece.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_LINEAR_BUILD_H
#define TEST_LINEAR_BUILD_H

#include "expect.h"

#include <mbsrank/mbsrank.h>

static inline mbsr_model *empty(void)
{
    mbsr_model *m;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    return m;
}

static inline void add_body(mbsr_model *m, int parent, const char *name, mbsr_joint joint,
                            mbsr_inertia inertia)
{
    mbsr_body_def b = mbsr_default_body_def();
    b.parent = parent;
    b.name = name;
    b.joint = joint;
    b.inertia = inertia;
    assert_ok(mbsr_model_add_body(m, &b, NULL), mbsr_model_error(m));
}

static inline void add_force(mbsr_model *m, mbsr_force_def force)
{
    assert_ok(mbsr_model_add_force(m, &force, NULL), mbsr_model_error(m));
}

/* Nodes without mass and particles, by turns and as many as `bodies` (odd), in a row between walls,
 * with springs of twice the stiffness between neighbours. */
static inline void add_string(mbsr_model *m, int bodies, double mass, double stiffness)
{
    const double along[3] = {1, 0, 0}, wall[3] = {9, 0, 0};
    for (int k = 0; k < bodies; ++k) {
        add_body(m, k > 0 ? k - 1 : MBSR_GROUND, NULL, mbsr_joint_prismatic(NULL, NULL, along),
                 k % 2 ? mbsr_inertia_particle(mass) : mbsr_inertia_zero());
        add_force(m, mbsr_force_joint_spring(k, 0, 2.0 * stiffness, 0.0, 0.0));
    }
    add_force(
        m, mbsr_force_point_spring(bodies - 1, NULL, MBSR_GROUND, wall, 2.0 * stiffness, 0.0, 9.0));
}

static inline mbsr_data *finish(mbsr_model *m)
{
    mbsr_data *d;
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    return d;
}

static inline void free_both(mbsr_model *m, mbsr_data *d)
{
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

#endif
