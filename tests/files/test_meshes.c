/* Meshes of MJCF: what they weigh by each rule, shapes that are fitted to them, where they are
 * drawn. Numbers that are not by formula are those of MuJoCo 3.14.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "small.h"

#include <math.h>
#include <stdio.h>

/* A prism over an L of area 2.25, height 1, which is not star-shaped. */
#define ELL                                                                                        \
    "vertex='0 0 0 2 0 0 2 .5 0 .5 .5 0 .5 3 0 0 3 0 0 0 1 2 0 1 2 .5 1 .5 .5 1 .5 3 1 0 3 1' "    \
    "face='0 2 1 6 7 8 0 3 2 6 8 9 0 4 3 6 9 10 0 5 4 6 10 11 0 1 7 0 7 6 1 2 8 1 8 7 2 3 9 2 9 "  \
    "8 3 4 10 3 10 9 4 5 11 4 11 10 5 0 6 5 6 11'"
#define CUBE                                                                                       \
    "vertex='0 0 0 1 0 0 1 1 0 0 1 0 0 0 1 1 0 1 1 1 1 0 1 1' "                                    \
    "face='0 2 1 0 3 2 4 5 6 4 6 7 0 1 5 0 5 4 1 2 6 1 6 5 2 3 7 2 7 6 3 0 4 3 4 7'"

static mbsr_file *read_body(const char *compiler, const char *mesh, const char *geom)
{
    char text[14000];
    snprintf(text, sizeof text,
             "<mujoco><compiler %s/><asset><mesh name='m' %s/><material name='red' rgba='1 0 0 1'/>"
             "</asset><worldbody><body name='b'><freejoint/><geom mesh='m' density='2' pos='1 2 3' "
             "%s/></body></worldbody></mujoco>",
             compiler, mesh, geom);
    return read_small(text, NULL);
}

/* Mass, and moments about the axes of the body. */
static void weigh(const char *mesh, double weight[4])
{
    double M[36];
    mbsr_data *d;
    mbsr_file *file = read_body("", mesh, "type='mesh'");
    assert_int_equal(file->findings, 0);
    assert_ok(mbsr_model_finish(file->model), mbsr_model_error(file->model));
    assert_ok(mbsr_data_create(file->model, &d, NULL), NULL);
    assert_ok(mbsr_stage_positions(file->model, d, 0.0, file->q0), mbsr_data_error(d));
    assert_ok(mbsr_mass_matrix(file->model, d, M), mbsr_data_error(d));
    weight[0] = M[35];
    for (int k = 0; k < 3; ++k) weight[1 + k] = M[7 * k];
    mbsr_data_destroy(d);
    mbsr_file_destroy(file);
}

static void rules_of_inertia(void **state)
{
    static const struct {
        const char *mesh;
        double weight[4];
    } cases[] = {
        {ELL " scale='1 -1 2' refpos='.1 .2 .3' refquat='1 2 3 4'",
         {12.320659690508421, 372.666736616, 347.626391187, 78.9756038654}},
        {ELL " inertia='exact' scale='1 -1 2' refpos='.1 .2 .3' refquat='1 2 3 4'",
         {9.0, 268.710133332, 252.272400001, 62.2710666665}},
        {ELL " inertia='shell' scale='1 -1 2' refpos='.1 .2 .3' refquat='1 2 3 4'",
         {49.48215096775555, 1527.29125052, 1437.69516810, 350.748609859}},
        /* a cube about its centre: m / 6, of its surface 5 m / 18; at (1.5, 2.5, 3.5) */
        {CUBE, {2.0, 2.0 / 6.0 + 37.0, 2.0 / 6.0 + 29.0, 2.0 / 6.0 + 17.0}},
        {CUBE " inertia='convex'", {2.0, 2.0 / 6.0 + 37.0, 2.0 / 6.0 + 29.0, 2.0 / 6.0 + 17.0}},
        {CUBE " inertia='shell'",
         {12.0, 20.0 / 6.0 + 222.0, 20.0 / 6.0 + 174.0, 20.0 / 6.0 + 102.0}},
    };
    (void)state;
    for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k) {
        double weight[4];
        weigh(cases[k].mesh, weight);
        for (int l = 0; l < 4; ++l)
            assert_close(weight[l], cases[k].weight[l], 1e-10 * cases[k].weight[l]);
    }
}

static void hulls_of_points_and_surfaces(void **state)
{
    char lattice[2000] = "vertex='", ball[12000] = "vertex='";
    double weight[4];
    (void)state;
    /* a prism over the hull of the L: its area is 4.125 */
    weigh(ELL " inertia='convex'", weight);
    assert_close(weight[0], 8.25, 1e-14);
    /* 4 x 4 x 4 points of a cube, of which 8 are corners */
    for (int k = 0; k < 64; ++k)
        snprintf(lattice + strlen(lattice), 40, "%d %d %d ", k % 4, k / 4 % 4, k / 16);
    strcat(lattice, "' scale='.5 .5 .5'");
    weigh(lattice, weight);
    assert_close(weight[0], 2.0 * 1.5 * 1.5 * 1.5, 1e-14);
    /* 6 of 200 points stand out of all the others */
    for (int k = 0; k < 200; ++k) {
        const double z = 0.9 * cos(0.7 * k), r = 0.3 + 0.5 * sin(k), a = 2.4 * k;
        const double out[3] = {k % 3 == 0, k % 3 == 1, k % 3 == 2}, far = k % 2 ? 2.0 : -2.0;
        const int corner = k < 6;
        snprintf(ball + strlen(ball), 60, "%.6g %.6g %.6g ",
                 corner ? far * out[0] : 0.3 * r * cos(a), corner ? far * out[1] : 0.3 * r * sin(a),
                 corner ? far * out[2] : 0.3 * z);
    }
    strcat(ball, "'");
    weigh(ball, weight); /* an octahedron: 4 / 3 a^3 */
    assert_close(weight[0], 2.0 * 32.0 / 3.0, 1e-14);
    mbsr_file *file = read_body("", "vertex='0 0 0 1 0 0 0 1 0 1 1 0'", "type='mesh'");
    assert_found(file, "geom", "lie in a plane");
    mbsr_file_destroy(file);
    assert_file_refused("<mujoco><asset><mesh name='m' inertia='soft'/></asset></mujoco>", NULL,
                        "mesh 'm'|'soft'");
    file = read_body("", "builtin='sphere' params='2'", "type='mesh'");
    assert_found(file, "geom", "MuJoCo builds");
    mbsr_file_destroy(file);
}

/* Shapes of such a mesh have its triangles, which are written and read again. */
static void meshes_by_numbers_are_drawn(void **state)
{
    mbsr_written *written;
    (void)state;
    mbsr_file *file = read_body("", CUBE " scale='1 2 3'", "type='mesh'");
    assert_int_equal(file->shape[0].triangles, 12);
    assert_null(file->shape[0].mesh);
    assert_close(file->shape[0].triangle[4], 2.0, 0.0);
    assert_close(file->shape[0].size[2], 1.0, 0.0);
    assert_ok(mbsr_model_finish(file->model), mbsr_model_error(file->model));
    assert_ok(mbsr_file_write_mjcf(file->model, file, NULL, &written, NULL), NULL);
    assert_int_equal(written->findings, 0);
    mbsr_file *again = read_small(written->text, NULL);
    assert_int_equal(again->shape[0].triangles, 12);
    for (int k = 0; k < 9 * 12; ++k)
        assert_close(again->shape[0].triangle[k], file->shape[0].triangle[k], 0.0);
    mbsr_written_destroy(written);
    mbsr_file_destroy(file);
    mbsr_file_destroy(again);
}

/* What the compiler says holds for meshes that do not say. */
static void the_compiler_may_want_solids(void **state)
{
    (void)state;
    for (int k = 0; k < 2; ++k) {
        mbsr_file *file =
            read_body("exactmeshinertia='true'", k ? ELL " inertia='legacy'" : ELL, "type='mesh'");
        mbsr_body_def def;
        assert_int_equal(file->findings, 0);
        assert_ok(mbsr_model_finish(file->model), mbsr_model_error(file->model));
        assert_ok(mbsr_body_definition(file->model, 0, &def), NULL);
        if (k == 0)
            assert_close(def.inertia.mass, 4.5, 1e-14);
        else
            assert_true(def.inertia.mass > 5.0);
        mbsr_file_destroy(file);
    }
}

static void shapes_are_fitted(void **state)
{
    static const struct {
        const char *compiler, *geom;
        double size[3], x[3];
        int sizes;
    } cases[] = {
        {"", "type='sphere'", {0.982417679867}, {1.58333333333, 3.08333333333, 3.5}, 1},
        {"",
         "type='capsule'",
         {0.621030781974, 1.39467608467},
         {1.58333333333, 3.08333333333, 3.5},
         2},
        {"",
         "type='cylinder' fitscale='2'",
         {1.242061563948, 3.4103829513},
         {1.58333333333, 3.08333333333, 3.5},
         2},
        {"",
         "type='box'",
         {0.5, 0.742061563948, 1.70519147565},
         {1.58333333333, 3.08333333333, 3.5},
         3},
        {"fitaabb='true'",
         "type='sphere'",
         {1.76850273113},
         {1.55805826176, 3.31694173824, 3.5},
         1},
        {"fitaabb='true'",
         "type='capsule'",
         {1.01955039060, 0.748952340529},
         {1.55805826176, 3.31694173824, 3.5},
         2},
        {"fitaabb='true'",
         "type='ellipsoid'",
         {0.5, 1.01955039060, 1.76850273113},
         {1.55805826176, 3.31694173824, 3.5},
         3},
    };
    (void)state;
    for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k) {
        mbsr_file *file = read_body(cases[k].compiler, ELL " inertia='exact'", cases[k].geom);
        assert_int_equal(file->findings, 0);
        for (int l = 0; l < cases[k].sizes; ++l)
            assert_close(file->shape[0].size[l], cases[k].size[l], 1e-10);
        for (int l = 0; l < 3; ++l) assert_close(file->shape[0].frame.x[l], cases[k].x[l], 1e-10);
        assert_null(file->shape[0].mesh);
        mbsr_file_destroy(file);
    }
    mbsr_file *file = read_body("", "file='none.stl'", "type='box'");
    assert_found(file, "geom", "fitted to mesh 'm'|no such file");
    assert_int_equal(file->shapes, 0);
    mbsr_file_destroy(file);
}

static void shapes_have_scale_place_and_colour(void **state)
{
    (void)state;
    mbsr_file *file = read_body("meshdir='d'", "file='a.stl' scale='1 2 3' refpos='1 1 1'",
                                "type='mesh' mass='0' material='red'");
    const mbsr_file_shape *s = file->shape;
    assert_int_equal(file->findings, 0);
    assert_string_equal(s->mesh, "d/a.stl");
    for (int k = 0; k < 3; ++k) {
        assert_close(s->size[k], 1.0 + k, 0.0);
        assert_close(s->frame.x[k], 0.0, 0.0); /* (1, 2, 3) less the scaled origin */
    }
    assert_close(s->colour[0], 1.0, 0.0);
    assert_close(s->colour[1], 0.0, 0.0);
    mbsr_file_destroy(file);
    file = read_body("", "file='a.stl' scale='1 2 3' refquat='1 1 0 0'",
                     "type='mesh' mass='0' rgba=''");
    assert_found(file, "geom", "without the refquat");
    assert_close(file->shape[0].colour[0], 0.5, 0.0);
    mbsr_file_destroy(file);
}

/* MSH: four counts, then points, normals, places in textures, triangles. */
static int load_msh(void *user, const char *path, const char **text, size_t *size)
{
    static union {
        int count[4];
        char bytes[16 + 12 * 4 + 12 + 8 + 12 * 4];
    } file;
    static const float x[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    static const int faces[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
    const int *cut = user;
    if (strcmp(path, "shapes/parts/a.msh") != 0) return 1;
    file.count[0] = 4, file.count[1] = file.count[2] = 1, file.count[3] = 4;
    memcpy(file.bytes + 16, x, sizeof x);
    memcpy(file.bytes + 16 + 48 + 20, faces, sizeof faces);
    *text = file.bytes;
    *size = sizeof file.bytes - (size_t)*cut;
    return 0;
}

/* A mesh without a name has that of its file. */
static void meshes_of_mujoco(void **state)
{
    static const char text[] =
        "<mujoco><compiler meshdir='shapes'/><asset><mesh file='parts/a.msh'/></asset><worldbody>"
        "<body name='b'><freejoint/><geom type='mesh' mesh='a'/></body></worldbody></mujoco>";
    (void)state;
    for (int cut = 0; cut < 2; ++cut) {
        mbsr_file_opt opt = mbsr_default_file_opt();
        opt.load = load_msh;
        opt.user = &cut;
        mbsr_file *file = read_small(text, &opt);
        mbsr_body_def def;
        assert_ok(mbsr_model_finish(file->model), mbsr_model_error(file->model));
        assert_ok(mbsr_body_definition(file->model, 0, &def), NULL);
        assert_int_equal(file->findings, cut);
        if (cut)
            assert_found(file, "geom", "its size is not what its head says");
        else
            assert_close(def.inertia.mass, 1000.0 / 6.0, 1e-12);
        mbsr_file_destroy(file);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rules_of_inertia),
        cmocka_unit_test(hulls_of_points_and_surfaces),
        cmocka_unit_test(meshes_by_numbers_are_drawn),
        cmocka_unit_test(the_compiler_may_want_solids),
        cmocka_unit_test(shapes_are_fitted),
        cmocka_unit_test(shapes_have_scale_place_and_colour),
        cmocka_unit_test(meshes_of_mujoco),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
