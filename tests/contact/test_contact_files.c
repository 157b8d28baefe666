/* Shapes of files that touch: what is added, what never touches, what stands.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "scarce.h"
#include "shapes.h"

#include <mbsrank/files.h>
#include <mbsrank/simulation.h>

#include <stdbool.h>
#include <stdio.h>

static mbsr_file *read(const char *text)
{
    mbsr_file *file;
    mbsr_error error;
    mbsr_file_opt opt = mbsr_default_file_opt();
    opt.hull_corners = 12;
    if (mbsr_file_read(text, strlen(text), "small.xml", &opt, &file, &error))
        fail_msg("%s", error.text);
    assert_int_equal(mbsr_model_finish(file->model), MBSR_OK);
    return file;
}

/* The model of a file with the element. */
static mbsr_model *touching_model(const mbsr_file *file, mbsr_contacts **contacts, int *force,
                                  mbsr_contacts_of_file *told)
{
    mbsr_error error;
    mbsr_force_def def;
    mbsr_model *m;
    assert_int_equal(mbsr_contacts_create(contacts, &error), MBSR_OK);
    if (mbsr_contacts_add_file(*contacts, file, file->model, 0.0, told, &error))
        fail_msg("%s", error.text);
    if (mbsr_contacts_force(*contacts, 0, &def, &error)) fail_msg("%s", error.text);
    assert_int_equal(mbsr_model_copy(file->model, &m, &error), MBSR_OK);
    assert_int_equal(mbsr_model_add_force(m, &def, force), MBSR_OK);
    if (mbsr_model_finish(m)) fail_msg("%s", mbsr_model_error(m)->text);
    return m;
}

/* A quadruped with spheres for feet stands: the floor carries its weight. */
static const char stands[] =
    "<mujoco><option gravity='0 0 -9.81'/><worldbody><geom type='plane' size='0 0 1'/>"
    "<body name='trunk' pos='0 0 0.4'><freejoint/><geom type='box' size='.3 .15 .05' mass='8'/>"
    "<body name='a' pos='.25 .15 0'><joint type='hinge' axis='0 1 0' stiffness='200' damping='5'/>"
    "<geom type='capsule' fromto='0 0 -.1 0 0 -.3' size='.02' mass='.5'/>"
    "<geom type='sphere' pos='0 0 -.37' size='.03' mass='.1'/></body>"
    "<body name='b' pos='.25 -.15 0'><joint type='hinge' axis='0 1 0' stiffness='200' damping='5'/>"
    "<geom type='capsule' fromto='0 0 -.1 0 0 -.3' size='.02' mass='.5'/>"
    "<geom type='sphere' pos='0 0 -.37' size='.03' mass='.1'/></body>"
    "<body name='c' pos='-.25 .15 0'><joint type='hinge' axis='0 1 0' stiffness='200' damping='5'/>"
    "<geom type='capsule' fromto='0 0 -.1 0 0 -.3' size='.02' mass='.5'/>"
    "<geom type='sphere' pos='0 0 -.37' size='.03' mass='.1'/></body>"
    "<body name='d' pos='-.25 -.15 0'><joint type='hinge' axis='0 1 0' stiffness='200' "
    "damping='5'/>"
    "<geom type='capsule' fromto='0 0 -.1 0 0 -.3' size='.02' mass='.5'/>"
    "<geom type='sphere' pos='0 0 -.37' size='.03' mass='.1'/></body>"
    "</body></worldbody></mujoco>";

static void quadruped(void **unused)
{
    (void)unused;
    mbsr_file *file = read(stands);
    mbsr_contacts *contacts;
    mbsr_contacts_of_file told;
    int force, count;
    mbsr_model *m = touching_model(file, &contacts, &force, &told);
    assert_int_equal(told.shapes, 10);
    assert_int_equal(told.left_out, 0);
    mbsr_simulation s = mbsr_simulation_of(m);
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.rtol = opt.atol = 1e-5;
    double u[10] = {0};
    if (mbsr_simulation_start(&s, &opt, 0.0, file->q0, u)) fail_msg("%s", s.error.text);
    if (mbsr_simulation_to(&s, 3.0)) fail_msg("%s", s.error.text);
    mbsr_contact_point point[32];
    if (mbsr_contact_report(s.model, s.data, force, 32, point, &count))
        fail_msg("%s", mbsr_data_error(s.data)->text);
    double weight = 0.0;
    for (int k = 0; k < count; ++k) weight += point[k].normal_force;
    assert_int_equal(count, 4);
    assert_close(weight, (8.0 + 4 * 0.6) * 9.81, 1e-2);
    assert_true(mbsr_simulation_q(&s)[6] > 0.38 && mbsr_simulation_q(&s)[6] < 0.401);
    mbsr_simulation_end(&s);
    mbsr_contacts_destroy(contacts);
    mbsr_file_destroy(file);
}

/* A plane on a body that is welded to the ground is the ground's; a body that is excluded falls
 * through it, and one beside it by a law of their own does not. */
static const char ramps[] =
    "<mujoco><worldbody><body name='frame' pos='0 0 1'><body name='ramp' euler='0 30 0'>"
    "<geom name='slope' type='plane' size='0 0 1' friction='0'/></body></body>"
    "<body name='ball' pos='.045 0 1.0779422863405996'><freejoint/><geom size='.1' "
    "mass='1'/></body>"
    "<body name='ghost' pos='.045 1 1.0779422863405996'><freejoint/><geom size='.1' "
    "mass='1'/></body>"
    "<body name='twin' pos='.045 2 1.0779422863405996'><freejoint/>"
    "<geom name='own' size='.1' mass='1'/></body></worldbody><contact>"
    "<exclude body1='ghost' body2='ramp'/><exclude body1='ramp' body2='twin'/>"
    "<pair geom1='slope' geom2='own'/></contact></mujoco>";

static void welded_planes(void **unused)
{
    (void)unused;
    const double u[18] = {0}, n[3] = {0.5, 0.0, sqrt(0.75)};
    mbsr_file *file = read(ramps);
    mbsr_contacts *contacts;
    mbsr_contacts_of_file told;
    mbsr_contact_point point[4];
    mbsr_data *d;
    int force, count;
    mbsr_model *m = touching_model(file, &contacts, &force, &told);
    assert_int_equal(told.shapes, 4);
    assert_int_equal(told.left_out, 0);
    assert_int_equal(mbsr_data_create(m, &d, NULL), MBSR_OK);
    assert_int_equal(mbsr_stage_positions(m, d, 0.0, file->q0), MBSR_OK);
    assert_int_equal(mbsr_stage_velocities(m, d, u), MBSR_OK);
    assert_int_equal(mbsr_contact_report(m, d, force, 4, point, &count), MBSR_OK);
    assert_int_equal(count, 2);
    for (int k = 0; k < 2; ++k) {
        const bool first = point[k].body_a == MBSR_GROUND;
        assert_int_equal(first ? point[k].body_b : point[k].body_a, k == 0 ? 2 : 4);
        assert_int_equal(first ? point[k].body_a : point[k].body_b, MBSR_GROUND);
        assert_close(point[k].depth, 0.01, 1e-12);
        for (int l = 0; l < 3; ++l) assert_close(point[k].normal[l], first ? -n[l] : n[l], 1e-12);
    }
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
    mbsr_contacts_destroy(contacts);
    mbsr_file_destroy(file);
}

/* Two boxes and a slider in a tube of the ground are drawn into each other, however light they are;
 * a ball on the floor is not. */
static const char drawn[] =
    "<mujoco><worldbody><geom type='plane' size='0 0 1' pos='0 0 -1'/>"
    "<geom type='box' size='.1 .1 .1' pos='3 0 0'/>"
    "<body name='a'><freejoint/><geom type='box' size='.1 .1 .1' mass='1e-5'/></body>"
    "<body name='b' pos='.15 0 0'><freejoint/><geom type='box' size='.1 .1 .1' mass='1e-5'/></body>"
    "<body name='rod' pos='3 0 0'><joint type='slide' axis='1 0 0'/>"
    "<geom type='box' size='.09 .05 .05' mass='1e-5'/></body>"
    "<body name='ball' pos='0 0 -.9001'><freejoint/><geom size='.1' mass='1e-5'/></body>"
    "</worldbody></mujoco>";

static void what_is_drawn_into_each_other(void **unused)
{
    (void)unused;
    const double u[19] = {0};
    mbsr_file *file = read(drawn);
    mbsr_touching t;
    mbsr_error error;
    mbsr_contact_point point;
    mbsr_data *d;
    int count;
    if (mbsr_contacts_attach(file, NULL, file->model, file->q0, 0.0, &t, &error))
        fail_msg("%s", error.text);
    assert_int_equal(t.told.shapes, 6);
    assert_int_equal(t.bodies, 1);
    assert_int_equal(t.shapes, 1);
    assert_int_equal(mbsr_data_create(t.model, &d, NULL), MBSR_OK);
    assert_int_equal(mbsr_stage_positions(t.model, d, 0.0, file->q0), MBSR_OK);
    assert_int_equal(mbsr_stage_velocities(t.model, d, u), MBSR_OK);
    assert_int_equal(mbsr_contact_report(t.model, d, t.force, 1, &point, &count), MBSR_OK);
    assert_int_equal(count, 1);
    assert_close(point.depth, 1e-4, 1e-12);
    mbsr_data_destroy(d);
    mbsr_model_destroy(t.model);
    mbsr_contacts_destroy(t.contacts);
    assert_int_equal(mbsr_contacts_attach(file, NULL, file->model, NULL, 0.0, &t, &error),
                     MBSR_ERR_NULL);
    assert_contains(error.text, "q is NULL");
    assert_int_equal(mbsr_contacts_attach(file, NULL, file->model, file->q0, -1.0, &t, &error),
                     MBSR_ERR_VALUE);
    assert_null(t.model);
    mbsr_file_destroy(file);
}

/* Excluded bodies, groups. */
static const char parts[] =
    "<mujoco><worldbody>"
    "<body name='a'><freejoint/><geom name='x' type='sphere' size='.1' mass='1' contype='2' "
    "conaffinity='0' friction='.7' condim='3'/></body>"
    "<body name='b' pos='.15 0 0'><freejoint/><geom name='y' type='sphere' size='.1' mass='1' "
    "contype='0' conaffinity='2'/></body>"
    "<body name='c' pos='0 .15 0'><freejoint/><geom name='z' type='ellipsoid' size='.1 .1 .2' "
    "mass='1' contype='0' conaffinity='2'/></body>"
    "<body name='d' pos='0 0 .15'><freejoint/><geom type='sphere' size='.1' mass='1' "
    "contype='0' conaffinity='2'/></body>"
    "</worldbody><contact><exclude body1='a' body2='d'/></contact></mujoco>";

static void groups(void **unused)
{
    (void)unused;
    mbsr_file *file = read(parts);
    mbsr_contacts *contacts;
    mbsr_contacts_of_file told;
    mbsr_error error;
    int force, count;
    mbsr_model *m = touching_model(file, &contacts, &force, &told);
    assert_int_equal(told.shapes, 4);
    mbsr_data *d;
    assert_int_equal(mbsr_data_create(m, &d, &error), MBSR_OK);
    assert_int_equal(mbsr_stage_positions(m, d, 0.0, file->q0), MBSR_OK);
    assert_int_equal(mbsr_stage_velocities(m, d, (double[24]){0.0, 0.0, 0.0, 0.01}), MBSR_OK);
    mbsr_contact_point point[4];
    assert_int_equal(mbsr_contact_report(m, d, force, 4, point, &count), MBSR_OK);
    assert_int_equal(count, 2); /* not d, which is excluded, nor y with z and d by their groups */
    assert_int_equal(point[1].shape_b, 2);
    assert_close(point[1].depth, 0.05, 1e-12);
    assert_close(point[0].depth, 0.05, 1e-12);
    assert_true(fabs(point[0].friction[0]) < 1e-12 && point[0].normal_force > 0.0);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
    mbsr_contacts_destroy(contacts);
    mbsr_file_destroy(file);
}

/* ---- meshes, by their hulls ---- */

/* The points of a model's contacts as it is drawn. */
static int points_drawn(const char *text, int most, mbsr_contact_point *point,
                        mbsr_contacts_of_file *told)
{
    mbsr_file *file = read(text);
    mbsr_contacts *contacts;
    mbsr_error error;
    mbsr_data *d;
    int force, count;
    mbsr_model *m = touching_model(file, &contacts, &force, told);
    const double u[24] = {0.0};
    assert_int_equal(mbsr_data_create(m, &d, &error), MBSR_OK);
    assert_int_equal(mbsr_stage_positions(m, d, 0.0, file->q0), MBSR_OK);
    assert_int_equal(mbsr_stage_velocities(m, d, u), MBSR_OK);
    assert_int_equal(mbsr_contact_report(m, d, force, most, point, &count), MBSR_OK);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
    mbsr_contacts_destroy(contacts);
    mbsr_file_destroy(file);
    return count;
}

/* A cube of 0.2 m with a point within and one on an edge, neither of them in the hull; turned over
 * and scaled. */
#define CUBE                                                                                       \
    "<asset><mesh name='c' scale='.1 .1 -.1' vertex='1 1 1 -1 1 1 1 -1 1 -1 -1 1 1 1 -1 -1 1 -1 "  \
    "1 -1 -1 -1 -1 -1 .1 .2 .3 1 1 .3'/><mesh name='flat' vertex='0 0 0 1 0 0 0 1 0 1 1 0' "       \
    "face='0 1 2 1 3 2'/></asset>"

static void mesh_hulls(void **unused)
{
    (void)unused;
    mbsr_contact_point point[16];
    mbsr_contacts_of_file told;
    const char *const text =
        "<mujoco>" CUBE "<worldbody><geom type='plane' size='1 1 .1'/>"
        "<body pos='0 0 .099'><freejoint/><inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/>"
        "<geom type='mesh' mesh='c'/><geom name='f' type='mesh' mesh='flat'/></body>"
        "</worldbody></mujoco>";
    mbsr_file *file = read(text);
    assert_int_equal(file->shape[1].hull_corners, 8);
    assert_int_equal(file->shape[1].hull_sides, 12);
    assert_int_equal(file->shape[2].hull_corners, 0);
    bool named = false;
    for (int k = 0; k < file->findings; ++k)
        named = named || (strcmp(file->finding[k].element, "geom 'f'") == 0 &&
                          strstr(file->finding[k].text, "its points lie in a plane"));
    assert_true(named);
    mbsr_file_destroy(file);
    assert_int_equal(points_drawn(text, 16, point, &told), 4);
    assert_int_equal(told.left_out, 1);
    /* corners of the core are 0.099 from the middle in each direction, and round */
    const double radius = 0.01 * sqrt(0.03);
    for (int k = 0; k < 4; ++k) {
        assert_close(point[k].depth, radius, 1e-6);
        assert_close(point[k].normal[2], -1.0, 1e-12);
    }
}

/* The cube drawn 3 m from the origin of its mesh: corners are rounded by the cube's size. */
static void a_hull_far_from_its_origin(void **unused)
{
    (void)unused;
    mbsr_contact_point point[16];
    mbsr_contacts_of_file told;
    const char *const text =
        "<mujoco><asset><mesh name='c' scale='.1 .1 .1' vertex='31 1 1 29 1 1 31 -1 1 31 1 -1 "
        "29 -1 1 29 1 -1 31 -1 -1 29 -1 -1'/></asset><worldbody><geom type='plane' size='1 1 .1'/>"
        "<body pos='-3 0 .099'><freejoint/><inertial pos='3 0 0' mass='1' diaginertia='1 1 1'/>"
        "<geom type='mesh' mesh='c'/></body></worldbody></mujoco>";
    assert_int_equal(points_drawn(text, 16, point, &told), 4);
    for (int k = 0; k < 4; ++k) assert_close(point[k].depth, 0.01 * sqrt(0.03), 1e-6);
}

/* "cube.stl", a cube of 2 m, and no other file. */
static int load_cube(void *user, const char *path, const char **text, size_t *size)
{
    static const int side[12][3] = {{0, 1, 3}, {0, 3, 2}, {4, 7, 5}, {4, 6, 7},
                                    {0, 5, 1}, {0, 4, 5}, {2, 3, 7}, {2, 7, 6},
                                    {0, 2, 6}, {0, 6, 4}, {1, 5, 7}, {1, 7, 3}};
    static char stl[4000];
    int used = snprintf(stl, sizeof stl, "solid cube\n");
    (void)user;
    if (strcmp(path, "cube.stl") != 0) return 1;
    for (int k = 0; k < 12; ++k) {
        used += snprintf(stl + used, sizeof stl - (size_t)used, "facet normal 0 0 0 outer loop\n");
        for (int l = 0; l < 3; ++l)
            used +=
                snprintf(stl + used, sizeof stl - (size_t)used, "vertex %d %d %d\n",
                         side[k][l] & 1 ? 1 : -1, side[k][l] & 2 ? 1 : -1, side[k][l] & 4 ? 1 : -1);
        used += snprintf(stl + used, sizeof stl - (size_t)used, "endloop endfacet\n");
    }
    used += snprintf(stl + used, sizeof stl - (size_t)used, "endsolid\n");
    *text = stl;
    *size = (size_t)used;
    return 0;
}

/* Of files, looked for beside the model and as they are named; one for both links, one is not
 * there. */
static void hulls_of_files(void **unused)
{
    (void)unused;
#define LINK(name, mesh)                                                                           \
    "<link name='" name "'><collision><geometry><mesh filename='" mesh "' scale='.1 .1 .1'/>"      \
    "</geometry></collision></link>"
#define HINGE(name, child)                                                                         \
    "<joint name='" name "' type='revolute'><parent link='a'/><child link='" child "'/></joint>"
    static const char text[] = "<robot name='r'>" LINK("a", "cube.stl") LINK("b", "cube.stl")
        LINK("c", "none.stl") HINGE("one", "b") HINGE("two", "c") "</robot>";
    mbsr_file *file;
    mbsr_error error;
    mbsr_file_opt opt = mbsr_default_file_opt();
    opt.hull_corners = 12;
    opt.load = load_cube;
    if (mbsr_file_read(text, strlen(text), "robots/r.urdf", &opt, &file, &error))
        fail_msg("%s", error.text);
    assert_int_equal(file->shapes, 3);
    for (int k = 0; k < 2; ++k) {
        assert_int_equal(file->shape[k].hull_corners, 8);
        assert_int_equal(file->shape[k].hull_sides, 12);
        assert_ptr_equal(file->shape[k].hull_corner, file->shape[0].hull_corner);
    }
    for (int l = 0; l < 24; ++l) assert_close(fabs(file->shape[0].hull_corner[l]), 0.1, 1e-15);
    assert_int_equal(file->shape[2].hull_corners, 0);
    bool named = false;
    for (int k = 0; k < file->findings; ++k)
        named = named || strstr(file->finding[k].text, "'none.stl': there is no such file");
    assert_true(named);
    mbsr_file_destroy(file);
}

/* A box without thickness is left out, the ball beside it is not. */
static void shapes_without_a_size(void **state)
{
    mbsr_contact_point point[16];
    mbsr_contacts_of_file told;
    (void)state;
    assert_int_equal(
        points_drawn("<robot name='r'><link name='a'><inertial><mass value='1'/>"
                     "<inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial>"
                     "<collision><geometry><box size='1 1 0'/></geometry></collision>"
                     "<collision><geometry><sphere radius='1'/></geometry></collision>"
                     "</link></robot>",
                     16, point, &told),
        0);
    assert_int_equal(told.shapes, 1);
    assert_int_equal(told.left_out, 1);
}

/* Of a ball of 400 points a hull of 12 corners, all of them points of the ball. */
static void hulls_are_small(void **unused)
{
    (void)unused;
    static char text[32000];
    int used = snprintf(text, sizeof text, "<mujoco><asset><mesh name='c' vertex='");
    for (int k = 0; k < 400; ++k) {
        const double z = -1.0 + (2.0 * k + 1.0) / 400.0, r = sqrt(1.0 - z * z), a = 2.4 * k;
        used += snprintf(text + used, sizeof text - (size_t)used, "%.6f %.6f %.6f ", r * cos(a),
                         r * sin(a), z);
    }
    (void)snprintf(text + used, sizeof text - (size_t)used,
                   "'/></asset><worldbody><body><freejoint/><geom type='mesh' mesh='c'/></body>"
                   "<body pos='3 0 0'><freejoint/><geom type='mesh' mesh='c'/></body>"
                   "</worldbody></mujoco>");
    mbsr_file *file = read(text);
    const mbsr_file_shape *s = file->shape;
    assert_int_equal(s[0].hull_corners, 12);
    assert_int_equal(s[0].hull_sides, 20);
    assert_ptr_equal(s[0].hull_corner, s[1].hull_corner);
    for (int k = 0; k < 12; ++k) {
        const double *x = s[0].hull_corner + 3 * (ptrdiff_t)k;
        assert_close(x[0] * x[0] + x[1] * x[1] + x[2] * x[2], 1.0, 1e-5);
    }
    for (int k = 0; k < 20; ++k) { /* all sides look outwards, not nearer than half the radius */
        const double *x[3], *c = s[0].hull_corner;
        for (int l = 0; l < 3; ++l) x[l] = c + 3 * (ptrdiff_t)s[0].hull_side[3 * k + l];
        const double a[3] = {x[1][0] - x[0][0], x[1][1] - x[0][1], x[1][2] - x[0][2]},
                     b[3] = {x[2][0] - x[0][0], x[2][1] - x[0][1], x[2][2] - x[0][2]},
                     n[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                             a[0] * b[1] - a[1] * b[0]};
        const double size = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        assert_true(n[0] * x[0][0] + n[1] * x[0][1] + n[2] * x[0][2] > 0.5 * size);
    }
    mbsr_file_destroy(file);
}

/* ---- pairs and margins ---- */

/* A pair has its own numbers and needs no groups; margins of shapes add up. MuJoCo 3.14 gives the
 * first two contacts at the same distances the numbers below. */
static void pairs_and_margins(void **unused)
{
    (void)unused;
    mbsr_contact_point point[16];
    mbsr_contacts_of_file told;
    const int count = points_drawn(
        "<mujoco><default><geom friction='.3 .02 .01' margin='.02' gap='.005'/></default>"
        "<worldbody><geom name='p' type='plane' size='1 1 .1' margin='.03'/>"
        "<body pos='0 0 .14'><freejoint/><geom name='a' size='.1' mass='1'/></body>"
        "<body pos='1 0 .14'><freejoint/><geom name='b' size='.1' mass='1'/></body>"
        "<body pos='2 0 .14'><freejoint/><geom name='c' size='.1' mass='1' contype='0' "
        "conaffinity='0'/></body></worldbody><contact><pair geom1='p' geom2='b'/>"
        "<pair geom1='c' geom2='p' friction='.5' margin='.1'/></contact></mujoco>",
        16, point, &told);
    assert_int_equal(count, 2);
    assert_int_equal(told.shapes, 4);
    assert_int_equal(point[0].shape_b, 1);
    assert_close(point[0].depth, 0.01, 1e-9);
    assert_int_equal(point[1].shape_b, 3);
    assert_close(point[1].depth, 0.06, 1e-9);
    assert_close(point[1].normal_force, 0.06 * 3.0 / (0.02 * 0.02), 1e-9);
}

/* ---- parts of zero mass between contacts ---- */

typedef struct touching {
    mbsr_file *file;
    mbsr_contacts *contacts;
    mbsr_simulation s;
    int force;
    double stiffness; /* of a pair */
} touching;

static void begin_touching(touching *t, const char *text, const double *q, const double *u)
{
    mbsr_contacts_of_file told;
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    t->file = read(text);
    t->s = mbsr_simulation_of(touching_model(t->file, &t->contacts, &t->force, &told));
    t->stiffness = 0.5 * told.stiffness;
    opt.rtol = opt.atol = 1e-7;
    if (mbsr_simulation_start(&t->s, &opt, 0.0, q ? q : t->file->q0, u))
        fail_msg("%s", t->s.error.text);
}

static void end_touching(touching *t)
{
    mbsr_simulation_end(&t->s);
    mbsr_contacts_destroy(t->contacts);
    mbsr_file_destroy(t->file);
}

/* All of 23 kg in trees of which the heaviest has 3 kg, but 30 of 43. */
static void mass_that_rests(void **unused)
{
    (void)unused;
    for (int more = 0; more < 2; ++more) {
        char text[8192] = "<mujoco><worldbody>";
        for (int k = 0; k < (more ? 40 : 20); ++k)
            strcat(text, "<body><freejoint/><geom type='sphere' size='.1' mass='1'/></body>");
        strcat(text, "<body><freejoint/><geom type='sphere' size='.1' mass='1'/>"
                     "<body><joint/><geom type='sphere' size='.1' mass='2'/></body></body>"
                     "</worldbody></mujoco>");
        mbsr_file *file = read(text);
        mbsr_contacts *contacts;
        mbsr_contacts_of_file told;
        mbsr_error error;
        mbsr_model *m = mbsr_file_take_model(file);
        assert_int_equal(mbsr_contacts_create(&contacts, &error), MBSR_OK);
        assert_int_equal(mbsr_contacts_add_file(contacts, file, m, 0.0, &told, &error), MBSR_OK);
        assert_close(told.stiffness, 2.0 * (more ? 30.0 : 23.0) / (0.02 * 0.02), 1e-6);
        mbsr_contacts_destroy(contacts);
        mbsr_model_destroy(m);
        mbsr_file_destroy(file);
    }
}

/* A time constant counts as two steps of the file at least, as in MuJoCo, unless refsafe is off;
 * two negative numbers are stiffness and damping of 1 kg. Grams have a thousandth of the stiffness.
 */
static void time_constants(void **unused)
{
    (void)unused;
    static const struct {
        const char *option, *law, *mass;
        double stiffness, damping;
    } world[] = {{"", "", "1", 2.0 / 4e-4, 2.0 / 0.02},
                 {"", "", ".001", 2e-3 / 4e-4, 2.0 / 0.02},
                 {"", "solref='.001 .5'", "1", 2.0 / 4e-6, 1.0 / 0.004},
                 {"<option timestep='.0001'/>", "solref='.001 .5'", "1", 2.0 / 2.5e-7, 1.0 / 0.001},
                 {"<option><flag refsafe='disable'/></option>", "solref='.001 .5'", "1",
                  2.0 / 2.5e-7, 1.0 / 0.001},
                 {"", "solref='-900 -30'", "1", 2.0 * 900.0, 30.0},
                 {"", "solref='0 1'", "1", 2.0 / 4e-4, 2.0 / 0.02}};
    for (size_t k = 0; k < sizeof world / sizeof world[0]; ++k) {
        char text[800];
        (void)snprintf(
            text, sizeof text,
            "<mujoco>%s<worldbody><geom type='plane' size='1 1 1' %s/><body pos='0 0 "
            ".099'><joint type='slide' axis='0 0 1'/><geom size='.1' mass='%s' %s/></body>"
            "</worldbody></mujoco>",
            world[k].option, world[k].law, world[k].mass, world[k].law);
        mbsr_file *file = read(text);
        mbsr_contacts *contacts;
        mbsr_contacts_of_file told;
        mbsr_contact_point point;
        mbsr_data *d;
        mbsr_error error;
        int force, count;
        mbsr_model *m = touching_model(file, &contacts, &force, &told);
        assert_close(told.stiffness, world[k].stiffness, 1e-9 * world[k].stiffness);
        assert_int_equal(mbsr_data_create(m, &d, &error), MBSR_OK);
        assert_int_equal(mbsr_stage_positions(m, d, 0.0, file->q0), MBSR_OK);
        assert_int_equal(mbsr_stage_velocities(m, d, (double[1]){-0.01}), MBSR_OK);
        assert_int_equal(mbsr_contact_report(m, d, force, 1, &point, &count), MBSR_OK);
        assert_int_equal(count, 1); /* two shapes yield one after the other */
        assert_close(point.normal_force,
                     0.5e-3 * world[k].stiffness * (1.0 + 0.01 * world[k].damping / 9.81),
                     1e-9 * point.normal_force);
        mbsr_data_destroy(d);
        mbsr_model_destroy(m);
        mbsr_contacts_destroy(contacts);
        mbsr_file_destroy(file);
    }
}

/* ---- much that stands still ---- */

static void *count_bytes(void *user, size_t size)
{
    size_t *taken = user;
    taken[0] += size;
    if (size < (size_t)1 << 28) taken[1] += size; /* others are room that is set aside */
    return malloc(size);
}

static void give_back(void *user, void *memory)
{
    (void)user;
    free(memory);
}

/* A ball of 1 kg in a row of blocks, welded to the ground as bodies of their own, that overlap.
 * What a Newton solver takes, in bytes. */
static size_t among_blocks(int blocks)
{
    char *text = malloc(200 * (size_t)blocks + 400), *end = text;
    assert_non_null(text);
    end += sprintf(end, "<mujoco><worldbody>");
    for (int k = 0; k < blocks; ++k)
        end +=
            sprintf(end, "<body pos='%g 0 0'><geom type='box' size='.6 1 1'/></body>", (double)k);
    (void)sprintf(end, "<body pos='.5 0 1.09'><freejoint/><geom type='sphere' size='.1' mass='1'/>"
                       "</body></worldbody></mujoco>");
    size_t taken[2] = {0};
    mbsr_error error;
    mbsr_file *file;
    mbsr_file_opt opt = mbsr_default_file_opt();
    opt.model.allocator = (mbsr_allocator){count_bytes, give_back, taken};
    if (mbsr_file_read(text, strlen(text), "blocks.xml", &opt, &file, &error))
        fail_msg("%s", error.text);
    assert_int_equal(mbsr_model_finish(file->model), MBSR_OK);
    mbsr_contacts *contacts;
    mbsr_contacts_of_file told;
    mbsr_data *d;
    mbsr_newton *newton;
    int force, count;
    mbsr_model *m = touching_model(file, &contacts, &force, &told);
    assert_close(told.stiffness, 2.0 / (0.02 * 0.02), 1e-9);
    assert_int_equal(mbsr_data_create(m, &d, &error), MBSR_OK);
    assert_int_equal(mbsr_stage_positions(m, d, 0.0, file->q0), MBSR_OK);
    assert_int_equal(mbsr_stage_velocities(m, d, (double[6]){0.0}), MBSR_OK);
    mbsr_contact_point point[4];
    assert_int_equal(mbsr_contact_report(m, d, force, 4, point, &count), MBSR_OK);
    assert_int_equal(count, 2);
    taken[1] = 0;
    if (mbsr_newton_create(m, MBSR_DAE_MOMENTUM, NULL, &newton, &error)) fail_msg("%s", error.text);
    mbsr_newton_destroy(newton);
    mbsr_index_report *report;
    size_t bytes = taken[1];
    taken[0] = 0;
    if (mbsr_index_report_create(m, d, 0.0, file->q0, (double[6]){0.0}, &report))
        fail_msg("%s", mbsr_data_error(d)->text);
    assert_int_equal(report->dynamic, 6);
    bytes += taken[0];
    mbsr_index_report_destroy(m, report);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
    mbsr_contacts_destroy(contacts);
    mbsr_file_destroy(file);
    free(text);
    return bytes;
}

static void blocks(void **unused)
{
    (void)unused;
    const size_t few = among_blocks(1000), many = among_blocks(3000);
    if (!((double)many < 3.3 * (double)few))
        fail_msg("%zu bytes of 1000 blocks, %zu of 3000", few, many);
}

/* A roller without mass between the floor and a plate: both of its contacts carry the plate. At the
 * start they are 1 and 2 parts deep, and its rate makes their forces equal. */
static const char roller[] =
    "<mujoco><worldbody><geom type='plane' size='1 1 .1'/>"
    "<body pos='0 0 .0999'><joint type='slide' axis='0 0 1'/><geom type='sphere' size='.1' "
    "density='0'/></body>"
    "<body pos='0 0 .2497'><joint type='slide' axis='0 0 1'/><geom type='box' size='.2 .2 .05' "
    "mass='2'/></body></worldbody></mujoco>";

static void between(void **unused)
{
    (void)unused;
    touching t;
    begin_touching(&t, roller, NULL, (const double[2]){0.0, 0.0});
    const double depth = 2.0 * 9.81 / t.stiffness, damping = 2.0 / (9.81 * 0.02);
    assert_close(mbsr_simulation_u(&t.s)[0], -1.0 / (3.0 * damping), 1e-6);
    if (mbsr_simulation_to(&t.s, 2.0)) fail_msg("%s", t.s.error.text);
    assert_close(mbsr_simulation_q(&t.s)[0], 1e-4 - depth, 1e-5);
    assert_close(mbsr_simulation_q(&t.s)[1], 3e-4 - 2.0 * depth, 1e-5);
    end_touching(&t);
}

/* Two fingers without mass hold a box by 20 N each: it creeps down so fast that friction carries
 * it, v / root(v^2 + slip^2) = m g / (2 mu F). */
static const char gripper[] =
    "<mujoco><worldbody>"
    "<body pos='-.0795 0 .2'><joint name='l' type='slide' axis='1 0 0' damping='20'/>"
    "<geom type='box' size='.03 .02 .06' density='0'/></body>"
    "<body pos='.0795 0 .2'><joint name='r' type='slide' axis='-1 0 0' damping='20'/>"
    "<geom type='box' size='.03 .02 .06' density='0'/></body>"
    "<body pos='0 0 .2'><freejoint/><geom type='box' size='.05 .05 .05' mass='.5'/></body>"
    "</worldbody><actuator><motor joint='l'/><motor joint='r'/></actuator></mujoco>";

static void fingers(void **unused)
{
    (void)unused;
    touching t = {.file = NULL};
    mbsr_contact_point point[64];
    int count;
    mbsr_contacts_of_file told;
    t.file = read(gripper);
    t.file->control[0] = t.file->control[1] = 20.0;
    t.s = mbsr_simulation_of(touching_model(t.file, &t.contacts, &t.force, &told));
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.rtol = opt.atol = 1e-8;
    if (mbsr_simulation_start(&t.s, &opt, 0.0, t.file->q0, (const double[8]){0.0}))
        fail_msg("%s", t.s.error.text);
    if (mbsr_simulation_to(&t.s, 1.0)) fail_msg("%s", t.s.error.text);
    const double part = 0.5 * 9.81 / 40.0, creep = 1e-3 * part / sqrt(1.0 - part * part);
    assert_close(mbsr_simulation_u(&t.s)[7], -creep, 1e-3);
    if (mbsr_contact_report(t.s.model, t.s.data, t.force, 64, point, &count))
        fail_msg("%s", mbsr_data_error(t.s.data)->text);
    double pressed = 0.0, carried = 0.0;
    for (int k = 0; k < count; ++k) {
        pressed += point[k].normal_force;
        carried -= point[k].friction[2]; /* on the finger, which is first */
    }
    assert_close(pressed, 40.0, 1e-6);
    assert_close(carried, 0.5 * 9.81, 1e-4);
    end_touching(&t);
}

/* ---- height fields ---- */

/* A ball slides down a slope without friction as on a plane: 45 degrees, its rows along y. */
static const char slope[] =
    "<mujoco><asset><hfield name='s' size='9 9 18 1' nrow='3' ncol='2' elevation='1 1 .5 .5 0 0'/>"
    "</asset><worldbody><geom type='hfield' hfield='s' condim='1'/><body pos='0 0 9'><freejoint/>"
    "<geom type='sphere' size='.1' mass='2' condim='1'/></body></worldbody></mujoco>";

static void sliding_down(void **unused)
{
    (void)unused;
    touching t;
    const double root = sqrt(0.5), k = 2.0 / (0.02 * 0.02), off = 0.1 - 2.0 * 9.81 * root / k,
                 q[7] = {1, 0, 0, 0, 0, -root * off, 9.0 + root * off};
    begin_touching(&t, slope, q, (const double[6]){0});
    if (mbsr_simulation_to(&t.s, 0.5)) fail_msg("%s", t.s.error.text);
    assert_close(mbsr_simulation_u(&t.s)[4], -0.25 * 9.81, 1e-4);
    assert_close(mbsr_simulation_u(&t.s)[5], -0.25 * 9.81, 1e-4);
    end_touching(&t);
}

/* ---- a ball between plates ---- */

/* A plate slides onto a ball on the floor: at the end the ball rolls on both, with the arms a above
 * and b below, which are its radius less half the depth. M (V - V0) is the impulse of the upper
 * friction, w (I + m b^2) / (a + b), and V = w (a + b). */
static const char plates[] =
    "<mujoco><worldbody><geom type='plane' size='9 9 .1'/>"
    "<body pos='0 0 .1'><freejoint/><geom type='sphere' size='.1' mass='1'/></body>"
    "<body pos='0 0 .25'><joint type='slide' axis='1 0 0'/><joint type='slide' axis='0 0 1'/>"
    "<geom type='box' size='4 4 .05' mass='2'/></body></worldbody></mujoco>";

static void rolling_between(void **unused)
{
    (void)unused;
    touching t;
    const double k = 3.0 / (0.02 * 0.02), deep[2] = {2.0 * 9.81 / k, 3.0 * 9.81 / k},
                 q[9] = {1, 0, 0, 0, 0, 0, 0.1 - deep[1], 0, -deep[0] - deep[1]};
    begin_touching(&t, plates, q, (const double[8]){0, 0, 0, 0, 0, 0, 1.0, 0.0});
    assert_close(t.stiffness, k, 1e-12);
    const double above = 0.1 - 0.5 * deep[0], below = 0.1 - 0.5 * deep[1], both = above + below,
                 w = 2.0 / both / (2.0 + (0.4 * 0.01 + below * below) / (both * both));
    if (mbsr_simulation_to(&t.s, 1.0)) fail_msg("%s", t.s.error.text);
    assert_close(mbsr_simulation_u(&t.s)[6], w * both, 1e-5);
    assert_close(mbsr_simulation_u(&t.s)[3], w * below, 1e-5);
    assert_close(mbsr_simulation_u(&t.s)[1], w, 1e-5);
    end_touching(&t);
}

static void refusals(void **unused)
{
    (void)unused;
    mbsr_file *file = read(parts);
    mbsr_contacts *c;
    mbsr_error error;
    assert_int_equal(mbsr_contacts_create(&c, &error), MBSR_OK);
    assert_int_equal(mbsr_contacts_add_file(NULL, file, file->model, 0.0, NULL, &error),
                     MBSR_ERR_NULL);
    assert_int_equal(mbsr_contacts_add_file(c, NULL, file->model, 0.0, NULL, &error),
                     MBSR_ERR_NULL);
    assert_int_equal(mbsr_contacts_add_file(c, file, NULL, 0.0, NULL, &error), MBSR_ERR_NULL);
    assert_int_equal(mbsr_contacts_add_file(c, file, file->model, -1.0, NULL, &error),
                     MBSR_ERR_VALUE);
    assert_int_equal(mbsr_contacts_add_file(c, file, file->model, NAN, NULL, &error),
                     MBSR_ERR_VALUE);
    assert_non_null(strstr(error.text, "stiffness is nan"));
    mbsr_contacts_destroy(c);
    mbsr_file_destroy(file);
}

/* ---- memory ---- */

static int touches(void *user)
{
    const mbsr_file *file = user;
    mbsr_touching t;
    mbsr_data *d = NULL;
    int status = mbsr_contacts_attach(file, NULL, file->model, file->q0, 0.0, &t, NULL);
    if (!status) status = mbsr_data_create(t.model, &d, NULL);
    mbsr_data_destroy(d);
    mbsr_model_destroy(t.model);
    mbsr_contacts_destroy(t.contacts);
    return status;
}

static void each_allocation_fails(void **unused)
{
    (void)unused;
    static const char *const texts[] = {stands, ramps, drawn};
    for (int k = 0; k < 3; ++k) {
        mbsr_file *file = read(texts[k]);
        const long count = test_scarce_each(touches, file, MBSR_ERR_NO_MEMORY, 1);
        if (count == -2)
            fail_msg("allocation %ld: %ld are left", test_memory.fail_at, test_memory.live);
        assert_true(count == -1 || count > 20);
        mbsr_file_destroy(file);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(welded_planes),
                                       cmocka_unit_test(what_is_drawn_into_each_other),
                                       cmocka_unit_test(quadruped),
                                       cmocka_unit_test(shapes_without_a_size),
                                       cmocka_unit_test(each_allocation_fails),
                                       cmocka_unit_test(groups),
                                       cmocka_unit_test(mass_that_rests),
                                       cmocka_unit_test(time_constants),
                                       cmocka_unit_test(blocks),
                                       cmocka_unit_test(between),
                                       cmocka_unit_test(fingers),
                                       cmocka_unit_test(rolling_between),
                                       cmocka_unit_test(refusals),
                                       cmocka_unit_test(mesh_hulls),
                                       cmocka_unit_test(a_hull_far_from_its_origin),
                                       cmocka_unit_test(hulls_of_files),
                                       cmocka_unit_test(hulls_are_small),
                                       cmocka_unit_test(pairs_and_margins),
                                       cmocka_unit_test(sliding_down)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
