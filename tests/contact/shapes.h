/* Shapes on bodies for the tests of contact.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_SHAPES_H
#define TEST_SHAPES_H

#include "expect.h"

#include <mbsrank/contact.h>
#include <mbsrank/verify.h>
#include <mbsrank/mbsrank.h>

#include <stdint.h>
#include <string.h>

/* -1 .. 1, the same numbers everywhere. */
static inline double draw(uint64_t *state)
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (double)(*state >> 11) / 4503599627370496.0 - 1.0;
}

static const double octahedron[18] = {0.3, 0,    0, -0.3, 0, 0,    0, 0.2, 0,
                                      0,   -0.2, 0, 0,    0, 0.25, 0, 0,   -0.25};
static const int octahedron_faces[24] = {0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4,
                                         2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5};

/* A shape of about 0.2 m with every part of a law. */
static inline mbsr_shape sample_shape(mbsr_shape_kind kind, int body)
{
    mbsr_shape s = mbsr_default_shape();
    s.kind = kind;
    s.body = body;
    s.size[0] = kind == MBSR_SHAPE_CAPSULE ? 0.1 : 0.2;
    s.size[1] = 0.25;
    s.size[2] = 0.15;
    s.vertices = 6, s.triangles = 8;
    s.vertex = octahedron, s.triangle = octahedron_faces;
    s.law = (mbsr_contact_law){2e4, 1.5, 0.3, 0.6, 0.1, 0.02, 0.03, 0.2, 0.0};
    return s;
}

/* Free bodies, one with each shape of a list, planes on the ground. */
typedef struct scene {
    mbsr_contacts *contacts;
    mbsr_model *model;
    mbsr_data *data;
    int force, bodies;
} scene;

static inline scene scene_with(int count, const mbsr_shape *shapes, int max_pairs)
{
    scene s = {0};
    mbsr_error error;
    const mbsr_model_def def = mbsr_default_model_def();
    assert_int_equal(mbsr_model_create(&def, &s.model, &error), MBSR_OK);
    assert_int_equal(mbsr_contacts_create(&s.contacts, &error), MBSR_OK);
    for (int k = 0; k < count; ++k) {
        mbsr_shape shape = shapes[k];
        if (shape.kind != MBSR_SHAPE_PLANE && shape.body != MBSR_GROUND) {
            const double tensor[6] = {0.02, 0.03, 0.04, 0, 0, 0}, at[3] = {0, 0, 0};
            mbsr_body_def body = mbsr_default_body_def();
            body.joint = mbsr_joint_free(NULL, NULL);
            body.inertia = mbsr_inertia_rigid(1.0, at, tensor);
            assert_int_equal(mbsr_model_add_body(s.model, &body, &shape.body), MBSR_OK);
            ++s.bodies;
        }
        const int status = mbsr_contacts_add(s.contacts, &shape, NULL, &error);
        if (status) fail_msg("%s", error.text);
    }
    mbsr_force_def force;
    if (mbsr_contacts_force(s.contacts, max_pairs, &force, &error)) fail_msg("%s", error.text);
    assert_int_equal(mbsr_model_add_force(s.model, &force, &s.force), MBSR_OK);
    if (mbsr_model_finish(s.model)) fail_msg("%s", mbsr_model_error(s.model)->text);
    assert_int_equal(mbsr_data_create(s.model, &s.data, &error), MBSR_OK);
    return s;
}

static inline scene scene_of(int count, const mbsr_shape *shapes)
{
    return scene_with(count, shapes, 0);
}

static inline void end_scene(scene *s)
{
    mbsr_data_destroy(s->data);
    mbsr_model_destroy(s->model);
    mbsr_contacts_destroy(s->contacts);
}

/* The points at a state. */
static inline int points_at(scene *s, const double *q, const double *u, int most,
                            mbsr_contact_point *points)
{
    int count;
    assert_int_equal(mbsr_stage_positions(s->model, s->data, 0.0, q), MBSR_OK);
    assert_int_equal(mbsr_stage_velocities(s->model, s->data, u), MBSR_OK);
    if (mbsr_contact_report(s->model, s->data, s->force, most, points, &count))
        fail_msg("%s", mbsr_data_error(s->data)->text);
    return count;
}

#endif
