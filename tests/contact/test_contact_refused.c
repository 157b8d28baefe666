/* Shapes and laws with a number that is out of range are refused, by its name, and not added.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "shapes.h"

#include <mbsrank/files.h>

#include <stddef.h>

/* The shape is refused with these words, and no shape is there; it is taken without the change. */
static void refused(const mbsr_shape *wrong, int status, const char *words)
{
    mbsr_contacts *c;
    mbsr_force_def force;
    mbsr_contacts_def def;
    mbsr_error error = {.text = ""};
    assert_int_equal(mbsr_contacts_create(&c, &error), MBSR_OK);
    assert_int_equal(mbsr_contacts_add(c, wrong, NULL, &error), status);
    assert_int_equal(error.status, status);
    assert_contains(error.text, words);
    assert_int_equal(mbsr_contacts_force(c, 0, &force, &error), MBSR_OK);
    assert_int_equal(mbsr_contacts_definition(c, &def), MBSR_OK);
    assert_int_equal(def.shapes, 0);
    mbsr_contacts_destroy(c);
}

static void numbers_of_laws(void **state)
{
    static const struct {
        const char *name;
        size_t at;
        double least; /* that is allowed, or not */
        int endless;  /* INFINITY is */
    } parts[] = {
        {"stiffness", offsetof(mbsr_contact_law, stiffness), 0.0, 1},
        {"exponent", offsetof(mbsr_contact_law, exponent), 0.99, 0},
        {"damping", offsetof(mbsr_contact_law, damping), -1e-9, 0},
        {"friction", offsetof(mbsr_contact_law, friction), -1e-9, 0},
        {"slip", offsetof(mbsr_contact_law, slip), 0.0, 0},
        {"torsional", offsetof(mbsr_contact_law, torsional), -1e-9, 0},
        {"rolling", offsetof(mbsr_contact_law, rolling), -1e-9, 0},
        {"spin", offsetof(mbsr_contact_law, spin), 0.0, 0},
        {"margin", offsetof(mbsr_contact_law, margin), -1e-9, 0},
    };
    (void)state;
    for (size_t k = 0; k < sizeof parts / sizeof *parts; ++k) {
        const double wrong[3] = {parts[k].least, NAN, INFINITY};
        for (int l = 0; l < 3 - parts[k].endless; ++l) {
            mbsr_shape s = sample_shape(MBSR_SHAPE_SPHERE, 0);
            memcpy((char *)&s.law + parts[k].at, wrong + l, sizeof *wrong);
            refused(&s, MBSR_ERR_VALUE, parts[k].name);
        }
    }
}

static void numbers_of_shapes(void **state)
{
    static const int wrong_faces[3][3] = {{-1, 2, 4}, {6, 2, 4}, {0, 0, 4}};
    (void)state;
    for (int k = 0; k < 3; ++k) {
        mbsr_shape s = sample_shape(MBSR_SHAPE_BOX, 0);
        s.size[k] = k == 0 ? 0.0 : k == 1 ? INFINITY : NAN;
        refused(&s, MBSR_ERR_VALUE, "size[");
        s = sample_shape(MBSR_SHAPE_BOX, 0);
        s.rounding = k == 0 ? -1e-3 : k == 1 ? INFINITY : NAN;
        refused(&s, MBSR_ERR_VALUE, "rounding");
        s = sample_shape(MBSR_SHAPE_BOX, 0);
        s.frame.x[k] = NAN;
        refused(&s, MBSR_ERR_VALUE, "frame");
        s = sample_shape(MBSR_SHAPE_BOX, 0);
        s.frame.R[4 * k] = k == 0 ? NAN : k == 1 ? -1.0 : 2.0;
        refused(&s, MBSR_ERR_VALUE, "frame");
        int faces[24];
        memcpy(faces, octahedron_faces, sizeof faces);
        memcpy(faces, wrong_faces[k], sizeof wrong_faces[k]);
        s = sample_shape(MBSR_SHAPE_MESH, 0);
        s.triangle = faces;
        refused(&s, MBSR_ERR_VALUE, k < 2 ? "triangle has the vertex" : "a triangle has no area");
    }
    mbsr_shape s = sample_shape(MBSR_SHAPE_MESH, 0);
    s.vertex = NULL;
    refused(&s, MBSR_ERR_NULL, "vertex or triangle is NULL");
    s = sample_shape(MBSR_SHAPE_MESH, 0);
    s.triangle = NULL;
    refused(&s, MBSR_ERR_NULL, "vertex or triangle is NULL");
    static const int counts[4][2] = {{3, 8}, {6, 3}, {1 << 17, 8}, {6, 1 << 17}};
    for (int k = 0; k < 4; ++k) {
        s = sample_shape(MBSR_SHAPE_MESH, 0);
        s.vertices = counts[k][0], s.triangles = counts[k][1];
        refused(&s, MBSR_ERR_VALUE, "between 4 and 65536");
    }
    double corners[18];
    memcpy(corners, octahedron, sizeof corners);
    corners[7] = INFINITY;
    s = sample_shape(MBSR_SHAPE_MESH, 0);
    s.vertex = corners;
    refused(&s, MBSR_ERR_VALUE, "vertex has the number inf");
}

static void calls_without_an_object(void **state)
{
    (void)state;
    mbsr_contacts *c;
    mbsr_force_def force;
    mbsr_error error;
    const mbsr_shape ball = sample_shape(MBSR_SHAPE_SPHERE, 0);
    mbsr_contact_law law = ball.law;
    assert_int_equal(mbsr_contacts_add(NULL, &ball, NULL, &error), MBSR_ERR_NULL);
    assert_contains(error.text, "contacts is NULL");
    assert_int_equal(mbsr_contacts_exclude(NULL, 0, 1, &error), MBSR_ERR_NULL);
    assert_int_equal(mbsr_contacts_pair(NULL, 0, 1, &law, &error), MBSR_ERR_NULL);
    assert_int_equal(mbsr_contacts_create(&c, NULL), MBSR_OK);
    assert_int_equal(mbsr_contacts_add(c, &ball, NULL, &error), MBSR_OK);
    assert_int_equal(mbsr_contacts_add(c, &ball, NULL, &error), MBSR_OK);
    assert_int_equal(mbsr_contacts_exclude(c, -7, 1, &error), MBSR_ERR_ID);
    assert_contains(error.text, "body_a is -7");
    assert_int_equal(mbsr_contacts_exclude(c, 0, -7, &error), MBSR_ERR_ID);
    assert_contains(error.text, "body_b is -7");
    static const int pairs[5][2] = {{-1, 0}, {0, -1}, {2, 0}, {0, 2}, {1, 1}};
    for (int k = 0; k < 5; ++k)
        assert_int_equal(mbsr_contacts_pair(c, pairs[k][0], pairs[k][1], &law, &error),
                         MBSR_ERR_ID);
    law.exponent = 0.5;
    assert_int_equal(mbsr_contacts_pair(c, 0, 1, &law, &error), MBSR_ERR_VALUE);
    assert_contains(error.text, "exponent");
    assert_int_equal(mbsr_contacts_force(c, -1, &force, &error), MBSR_ERR_VALUE);
    assert_int_equal(mbsr_contacts_force(c, (1 << 24) + 1, &force, &error), MBSR_ERR_VALUE);
    assert_int_equal(mbsr_contacts_force(c, 0, NULL, &error), MBSR_ERR_NULL);
    assert_contains(error.text, "force is NULL");
    assert_int_equal(mbsr_contacts_force(NULL, 0, &force, &error), MBSR_ERR_NULL);
    assert_contains(error.text, "contacts is NULL");
    mbsr_contacts_destroy(c);
}

/* Each pointer is missing in turn, and named. */
static void attached_to_nothing(void **state)
{
    static const char *const missing[] = {"file", "model", "q", "made"};
    static const char text[] = "<robot name='r'><link name='a'/></robot>";
    (void)state;
    mbsr_file *file;
    mbsr_touching made;
    mbsr_error error;
    const double q[1] = {0.0};
    assert_ok(mbsr_file_read(text, sizeof text - 1, "r.urdf", NULL, &file, &error), &error);
    for (int k = 0; k < 4; ++k) {
        assert_int_equal(mbsr_contacts_attach(k == 0 ? NULL : file, NULL,
                                              k == 1 ? NULL : file->model, k == 2 ? NULL : q, 0.0,
                                              k == 3 ? NULL : &made, &error),
                         MBSR_ERR_NULL);
        assert_contains(error.text, missing[k]);
        if (k < 3) assert_true(made.force == MBSR_NONE && !made.contacts && !made.model);
    }
    mbsr_file_destroy(file);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(numbers_of_laws),
        cmocka_unit_test(numbers_of_shapes),
        cmocka_unit_test(calls_without_an_object),
        cmocka_unit_test(attached_to_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
