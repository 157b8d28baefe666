/* What is shown of a file: colours of shapes, what they are for, triangles of meshes.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "small.h"

#include <stdint.h>

static void assert_numbers(int n, const double *x, const double *should)
{
    for (int k = 0; k < n; ++k) assert_close(x[k], should[k], 1e-15);
}

static void assert_colour(const mbsr_file *file, int shape, const double rgba[4], int coloured)
{
    assert_int_equal(file->shape[shape].coloured, coloured);
    assert_numbers(4, file->shape[shape].colour, rgba);
}

/* ---- colours ---- */

static void urdf_colours_are_named_before_and_after(void **unused)
{
    (void)unused;
#define BOX(material) "<visual><geometry><box size='1 1 1'/></geometry>" material "</visual>"
    mbsr_file *file =
        read_small("<robot name='r'><material name='blue'><color rgba='0 0 1 0.5'/></material>"
                   "<link name='a'>" BOX("<material name='blue'/>") BOX("<material name='red'/>")
                       BOX("<material name='red'><color rgba='1 0 0 1'/></material>")
                           BOX("<material name='blue'><color rgba='0 1 0 1'/></material>")
                               BOX("<material name='unknown'/>") BOX("") "</link></robot>",
                   NULL);
#undef BOX
    assert_colour(file, 0, (const double[]){0.0, 0.0, 1.0, 0.5}, 1);
    assert_colour(file, 1, (const double[]){1.0, 0.0, 0.0, 1.0}, 1);
    assert_colour(file, 2, (const double[]){1.0, 0.0, 0.0, 1.0}, 1);
    assert_colour(file, 3, (const double[]){0.0, 1.0, 0.0, 1.0}, 1); /* its own goes before */
    for (int k = 4; k < 6; ++k) assert_int_equal(file->shape[k].coloured, 0);
    mbsr_file_destroy(file);
}

static const char painted[] =
    "<mujoco><default><geom material='steel'/><material rgba='0.2 0.4 0.6 1'/>"
    "<default class='bare'><geom rgba='0 1 0 1'/></default></default>"
    "<asset><texture name='skin' type='2d' builtin='flat' rgb1='0.5 0.25 1' width='8' height='8'/>"
    "<texture name='photo' type='2d' file='photo.png'/>"
    "<material name='steel'/><material name='skin' texture='skin' rgba='1 0.8 1 0.5'/>"
    "<material name='photo' texture='photo' rgba='1 1 0 1'/></asset>"
    "<worldbody><body><geom size='1'/><geom size='1' material='skin'/>"
    "<geom size='1' material='photo'/><geom size='1' material='skin' rgba='1 0 0 1'/>"
    "<geom size='1' class='bare'/></body></worldbody></mujoco>";

static void mjcf_colours_of_materials_classes_and_textures(void **unused)
{
    (void)unused;
    mbsr_file *file = read_small(painted, NULL);
    assert_colour(file, 0, (const double[]){0.2, 0.4, 0.6, 1.0}, 1);
    assert_colour(file, 1, (const double[]){0.5, 0.2, 1.0, 0.5}, 1);
    assert_colour(file, 2, (const double[]){1.0, 1.0, 0.0, 1.0}, 1);
    assert_colour(file, 3, (const double[]){1.0, 0.0, 0.0, 1.0}, 1);
    assert_colour(file, 4, (const double[]){0.0, 1.0, 0.0, 1.0}, 1);
    mbsr_file_destroy(file);
    file = read_small("<mujoco><worldbody><body><geom size='1' material='none'/></body></worldbody>"
                      "</mujoco>",
                      NULL);
    assert_colour(file, 0, (const double[]){0.5, 0.5, 0.5, 1.0}, 0);
    mbsr_file_destroy(file);
    assert_file_refused("<mujoco><asset><material name='m' rgba='1 x'/></asset><worldbody><body>"
                        "<geom size='1' material='m'/></body></worldbody></mujoco>",
                        NULL, "rgba");
}

/* ---- what shapes are for ---- */

static void shapes_for_showing_for_contact_and_for_both(void **unused)
{
    (void)unused;
    static const int visual[] = {1, 1, 0, 1, 0}, contact[] = {1, 0, 1, 1, 0};
    mbsr_file *file = read_small(
        "<mujoco><worldbody><body><geom size='1'/>"
        "<geom size='1' contype='0' conaffinity='0' group='2'/><geom size='1' group='3'/>"
        "<geom size='1' contype='0' group='1'/>"
        "<geom size='1' contype='0' conaffinity='0' group='4'/></body></worldbody></mujoco>",
        NULL);
    for (int k = 0; k < 5; ++k) {
        assert_int_equal(file->shape[k].visual, visual[k]);
        assert_int_equal(file->shape[k].contact, contact[k]);
    }
    mbsr_file_destroy(file);
}

/* ---- triangles ---- */

typedef struct corners {
    double x[64];
    int count;
} corners;

static void take(void *user, const double corner[9])
{
    corners *c = user;
    for (int k = 0; k < 9 && c->count < 64; ++k) c->x[c->count++] = corner[k];
}

static void faces_become_fans_of_triangles(void **unused)
{
    (void)unused;
    static const char obj[] = "# a square and a triangle\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0.5\n"
                              "vn 0 0 1\nf 1//1 2//1 3//1 4//1\nf -1 -2 -3\n",
                      stl[] =
                          "solid\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n"
                          "   vertex 1e0 0 0\n   vertex 1 1 0\n  endloop\n endfacet\nendsolid\n";
    static const double fan[] = {0, 0, 0, 1,   0, 0, 1,   1, 0, 0, 0, 0, 1, 1,
                                 0, 0, 1, 0.5, 0, 1, 0.5, 1, 1, 0, 1, 0, 0};
    corners c = {.count = 0};
    mbsr_error error;
    assert_ok(mbsr_mesh_triangles(obj, sizeof obj - 1, "a.obj", take, &c, &error), &error);
    assert_int_equal(c.count, 27);
    assert_numbers(27, c.x, fan);
    c.count = 0;
    assert_ok(mbsr_mesh_triangles(stl, sizeof stl - 1, NULL, take, &c, &error), &error);
    assert_int_equal(c.count, 9);
    assert_numbers(9, c.x, fan);
}

/* MSH of MuJoCo: told by its name. */
static void triangles_of_msh(void **unused)
{
    (void)unused;
    static const struct {
        int32_t head[4];
        float point[4][3];
        int32_t face[2][3];
    } msh = {{4, 0, 0, 2}, {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0.5}}, {{0, 1, 2}, {0, 2, 3}}};
    static const double corner[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 0, 0, 1, 1, 0, 0, 1, 0.5};
    corners c = {.count = 0};
    mbsr_error error;
    const char *text = (const char *)&msh;
    assert_ok(mbsr_mesh_triangles(text, sizeof msh, "a.msh", take, &c, &error), &error);
    assert_int_equal(c.count, 18);
    assert_numbers(18, c.x, corner);
    assert_int_equal(mbsr_mesh_triangles(text, sizeof msh - 1, "a.msh", take, &c, &error),
                     MBSR_ERR_FILE);
    assert_contains(error.text, "mesh 'a.msh': its size is not what its head says");
    assert_int_equal(mbsr_mesh_triangles(text, sizeof msh, NULL, take, &c, NULL), MBSR_ERR_FILE);
    assert_int_equal(c.count, 18);
}

static void meshes_that_cannot_be_read_say_why(void **unused)
{
    (void)unused;
    corners c = {.count = 0};
    mbsr_error error;
    static const char *const cases[][2] = {{"v 0 0\n", "3 numbers"},
                                           {"v 0 0 0\nf 1 1\n", "less than 3 corners"},
                                           {"v 0 0 0\nf 1 1 2\n", "corner that is none"},
                                           {"solid x\nvertex 1 2\n", "3 numbers"},
                                           {"v 0 0 0\nf 1 1 1\nf 1 1 2\n", "corner that is none"},
                                           {"<COLLADA/>", "no triangles"}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k) {
        const char *text = cases[k][0];
        assert_int_equal(mbsr_mesh_triangles(text, strlen(text), "b.obj", take, &c, &error),
                         MBSR_ERR_FILE);
        assert_contains(error.text, cases[k][1]);
        assert_contains(error.text, "mesh 'b.obj': ");
        assert_int_equal(c.count, 0); /* not even those before */
    }
    char stl[84 + 50] = {[80] = 1, [84 + 12 + 3] = 0x7f, [84 + 12 + 2] = (char)0xc0}; /* a NaN */
    assert_int_equal(mbsr_mesh_triangles(stl, sizeof stl, "c.stl", take, &c, &error),
                     MBSR_ERR_FILE);
    assert_contains(error.text, "not finite");
    assert_int_equal(c.count, 0);
    assert_int_equal(mbsr_mesh_triangles(NULL, 0, NULL, take, &c, &error), MBSR_ERR_NULL);
    assert_int_equal(mbsr_mesh_triangles("", 0, NULL, NULL, &c, NULL), MBSR_ERR_NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(urdf_colours_are_named_before_and_after),
        cmocka_unit_test(mjcf_colours_of_materials_classes_and_textures),
        cmocka_unit_test(shapes_for_showing_for_contact_and_for_both),
        cmocka_unit_test(faces_become_fans_of_triangles),
        cmocka_unit_test(triangles_of_msh),
        cmocka_unit_test(meshes_that_cannot_be_read_say_why),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
