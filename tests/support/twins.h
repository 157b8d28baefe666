/* Two equal pendulums on one bead without mass, which is held by springs and dampers.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Each rod gives the bead its particle's mass along the rod only. Where the rods are parallel the
 * mass at the bead's joint has rank 1, elsewhere rank 2. Started as one the two stay parallel until
 * a torque on the second begins, at `begin` s. Coordinates: bead x, y; angles of the two. */
#ifndef TEST_TWINS_H
#define TEST_TWINS_H

#include "expect.h"

typedef struct twins {
    mbsr_model *model;
    mbsr_data *data;
    double begin; /* s */
} twins;

static inline int twins_torque(void *user, double t, int n, double *value)
{
    const double late = t - ((const twins *)user)->begin;
    for (int k = 0; k < n; ++k) value[k] = late > 0.0 ? 20.0 * late : 0.0;
    return 0;
}

static inline void twins_make(twins *s, double begin)
{
    *s = (twins){.begin = begin};
    assert_ok(mbsr_model_create(NULL, &s->model, NULL), NULL);
    mbsr_body_def body = mbsr_default_body_def();
    body.name = "bead";
    body.joint = mbsr_joint_point_free();
    body.inertia = mbsr_inertia_zero();
    assert_ok(mbsr_model_add_body(s->model, &body, NULL), mbsr_model_error(s->model));
    for (int k = 0; k < 2; ++k) {
        body = mbsr_default_body_def();
        body.name = k ? "second" : "first";
        body.parent = 0;
        body.joint = mbsr_joint_planar_revolute((mbsr_planar_frame){0.0, 0.0, 0.0},
                                                (mbsr_planar_frame){0.0, 1.0, 0.0});
        body.inertia = mbsr_inertia_particle(1.0);
        assert_ok(mbsr_model_add_body(s->model, &body, NULL), mbsr_model_error(s->model));
    }
    const mbsr_force_def force[] = {mbsr_force_axis_spring(0, MBSR_GROUND, 0, 100.0, 5.0, 0.0),
                                    mbsr_force_axis_spring(0, MBSR_GROUND, 1, 100.0, 5.0, 0.0),
                                    mbsr_force_gravity(0.0, -9.81, 0.0),
                                    mbsr_force_joint_applied(2, twins_torque, s)};
    for (int k = 0; k < 4; ++k)
        assert_ok(mbsr_model_add_force(s->model, force + k, NULL), mbsr_model_error(s->model));
    assert_ok(mbsr_model_finish(s->model), mbsr_model_error(s->model));
    assert_ok(mbsr_data_create(s->model, &s->data, NULL), NULL);
}

static inline void twins_free(twins *s)
{
    mbsr_data_destroy(s->data);
    mbsr_model_destroy(s->model);
}

#endif
