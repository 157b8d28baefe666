/* What MJCF says, feature by feature.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "small.h"

#include <mbsrank/verify.h>

#include <errno.h>
#include <math.h>
#include <stdio.h>

#define MUJOCO(inside) "<mujoco model='m'>\n" inside "</mujoco>\n"
#define WORLD(inside) MUJOCO("<worldbody>" inside "</worldbody>\n")

typedef struct scene {
    mbsr_file *file;
    mbsr_model *model;
    mbsr_data *data;
} scene;

static scene open_text(const char *text, const mbsr_file_opt *opt)
{
    scene s = {.file = read_small(text, opt)};
    s.model = s.file->model;
    assert_ok(mbsr_model_finish(s.model), mbsr_model_error(s.model));
    assert_ok(mbsr_data_create(s.model, &s.data, NULL), NULL);
    assert_int_equal(mbsr_model_nq(s.model), s.file->nq);
    assert_int_equal(mbsr_model_nu(s.model), s.file->nu);
    return s;
}

static void close_scene(scene *s)
{
    mbsr_data_destroy(s->data);
    mbsr_file_destroy(s->file);
}

/* The pose of a body at q; NULL: as drawn. */
static void pose_of(const scene *s, const char *name, const double *q, double pose[MBSR_POSE_SIZE])
{
    const int id = mbsr_model_find_body(s->model, name);
    assert_true(id >= 0);
    assert_ok(mbsr_stage_positions(s->model, s->data, 0.0, q ? q : s->file->q0),
              mbsr_data_error(s->data));
    assert_ok(mbsr_body_pose(s->model, s->data, id, pose), mbsr_data_error(s->data));
}

/* Every spelling of a turn by 90 degrees about z. */
static void orientations(void **state)
{
    static const char *const spellings[] = {"quat='2 0 0 2'", "axisangle='0 0 3 90'",
                                            "xyaxes='0 2 0 -1 5 0'", "euler='0 0 90'",
                                            "pos='0 0 0' axisangle='0 0 1 90'"};
    (void)state;
    for (size_t k = 0; k < sizeof spellings / sizeof *spellings; ++k) {
        char text[400];
        double pose[MBSR_POSE_SIZE];
        snprintf(text, sizeof text, WORLD("<body name='b' %s><freejoint/></body>"), spellings[k]);
        scene s = open_text(text, NULL);
        pose_of(&s, "b", NULL, pose);
        const double R[9] = {0.0, 1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 1.0};
        for (int l = 0; l < 9; ++l) assert_close(pose[l], R[l], 1e-15);
        close_scene(&s);
    }
    /* z along x: the shortest turn, about y */
    double pose[MBSR_POSE_SIZE];
    scene s = open_text(WORLD("<body name='b' zaxis='3 0 0'/>"), NULL);
    pose_of(&s, "b", NULL, pose);
    assert_close(pose[6], 1.0, 1e-15);
    assert_close(pose[4], 1.0, 1e-15);
    close_scene(&s);
    /* fixed axes: x first, then z; and radians */
    s = open_text(
        MUJOCO("<compiler angle='radian' eulerseq='XYZ'/><worldbody>"
               "<body name='b' euler='1.5707963267948966 0 1.5707963267948966'/></worldbody>"),
        NULL);
    pose_of(&s, "b", NULL, pose);
    assert_close(pose[7], 0.0, 1e-15);
    assert_close(pose[6], 1.0, 1e-15); /* z: by x to -y, by z to x */
    close_scene(&s);
}

static double composed(const double q[3], int k)
{
    /* turn about z by q0 at (1, 0, 0), slide along y, turn about z at (2, 0, 0): the origin */
    const double c = cos(q[0]), s = sin(q[0]), x = 2.0 - 2.0 * cos(q[2]),
                 y = q[1] - 2.0 * sin(q[2]);
    return k == 0 ? 1.0 + c * (x - 1.0) - s * y : s * (x - 1.0) + c * y;
}

/* With references and anchors of their own, one after the other. */
static void several_joints_on_a_body(void **state)
{
    (void)state;
    scene s =
        open_text(MUJOCO("<compiler angle='radian'/><worldbody><body name='b'>"
                         "<joint name='one' pos='1 0 0' ref='0.3'/>"
                         "<joint name='two' type='slide' axis='0 5 0' ref='-2'/>"
                         "<joint name='three' pos='2 0 0' ref='0.1'/>"
                         "<inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/></body></worldbody>"),
                  NULL);
    double pose[MBSR_POSE_SIZE];
    const double q[3] = {0.9, -1.5, 0.8}, moved[3] = {0.6, 0.5, 0.7};
    assert_int_equal(s.file->joints, 3);
    assert_true(s.file->q0[0] == 0.3 && s.file->q0[1] == -2.0 && s.file->q0[2] == 0.1);
    pose_of(&s, "b", NULL, pose);
    for (int k = 0; k < 3; ++k) assert_close(pose[MBSR_POSE_X + k], 0.0, 1e-15);
    assert_close(pose[0], 1.0, 1e-15);
    pose_of(&s, "b", q, pose);
    for (int k = 0; k < 2; ++k) assert_close(pose[MBSR_POSE_X + k], composed(moved, k), 1e-15);
    close_scene(&s);
    /* one anchor: one body */
    s = open_text(WORLD("<body name='b'><joint type='slide' axis='1 0 0' ref='4'/><joint/>"
                        "<joint axis='1 0 0'/><joint axis='0 1 0'/></body>"),
                  NULL);
    assert_int_equal(mbsr_model_bodies(s.model), 1);
    pose_of(&s, "b", NULL, pose);
    assert_close(pose[MBSR_POSE_X], 0.0, 1e-15);
    close_scene(&s);
}

static void classes_and_frames(void **state)
{
    (void)state;
    scene s = open_text(
        MUJOCO("<default><joint damping='1'/><default class='a'><joint armature='2' axis='1 0 0'/>"
               "<default class='b'><joint damping='3'/></default></default></default>"
               "<worldbody><frame pos='0 0 1'><body name='p' childclass='a'><joint name='j'/>"
               "<frame pos='0 2 0' axisangle='0 0 1 90'><joint name='k' class='b' pos='1 0 0'/>"
               "<body name='c'/></frame></body></frame></worldbody>"),
        NULL);
    double pose[MBSR_POSE_SIZE], tau[2];
    const double q[2] = {0.0, 0.0}, u[2] = {1.0, 1.0}, udot[2] = {0.0, 0.0};
    pose_of(&s, "c", q, pose);
    assert_close(pose[MBSR_POSE_X + 1], 2.0, 1e-15);
    assert_close(pose[MBSR_POSE_X + 2], 1.0, 1e-15);
    assert_close(pose[1], 1.0, 1e-15);
    assert_int_equal(mbsr_model_find_body(s.model, "p"), 1); /* behind a body between its anchors */
    assert_true(mbsr_body_armature(s.model, 0)[0] == 2.0);
    assert_ok(mbsr_inverse_dynamics(s.model, s.data, 0.0, q, u, udot, NULL, tau),
              mbsr_data_error(s.data));
    assert_close(tau[0], 1.0, 1e-15);
    assert_close(tau[1], 3.0, 1e-15);
    close_scene(&s);
}

static double mass_of(const char *text, double centre[3])
{
    scene s = open_text(text, NULL);
    double mass, u[6] = {0.0};
    assert_ok(mbsr_stage_positions(s.model, s.data, 0.0, s.file->q0), mbsr_data_error(s.data));
    assert_ok(mbsr_stage_velocities(s.model, s.data, u), mbsr_data_error(s.data));
    assert_ok(mbsr_tree_momentum(s.model, s.data, NULL, &mass, centre, NULL),
              mbsr_data_error(s.data));
    close_scene(&s);
    return mass;
}

static void inertias_of_shapes(void **state)
{
    static const double pi = 3.14159265358979323846;
    double centre[3];
    (void)state;
    assert_close(
        mass_of(WORLD("<body><freejoint/><geom type='box' size='1 2 3' density='2'/></body>"),
                centre),
        96.0, 1e-12);
    assert_close(mass_of(WORLD("<body><freejoint/><geom size='.5' pos='0 0 1'/><geom size='.5' "
                               "mass='0'/></body>"),
                         centre),
                 1000.0 * pi / 6.0, 1e-10);
    assert_close(centre[2], 1.0, 1e-15);
    /* only without <inertial>, unless the compiler says so; only of some groups */
    assert_close(mass_of(WORLD("<body><freejoint/><inertial pos='0 0 0' mass='3' "
                               "diaginertia='1 1 1'/><geom size='1' mass='5'/></body>"),
                         centre),
                 3.0, 0.0);
    assert_close(mass_of(MUJOCO("<compiler inertiafromgeom='true' inertiagrouprange='1 2'/>"
                                "<worldbody><body><freejoint/><inertial pos='0 0 0' mass='3' "
                                "diaginertia='1 1 1'/><geom size='1' mass='5' group='1'/>"
                                "<geom size='1' mass='7' group='3'/></body></worldbody>"),
                         centre),
                 5.0, 0.0);
    /* what is given, where none counts */
    assert_close(mass_of(MUJOCO("<compiler inertiafromgeom='true' inertiagrouprange='1 2'/>"
                                "<worldbody><body><freejoint/><inertial pos='0 0 0' mass='3' "
                                "diaginertia='1 1 1'/><geom size='1' mass='7' group='3'/></body>"
                                "</worldbody>"),
                         centre),
                 3.0, 0.0);
}

/* w, position and velocity through the gear, on a joint and on a tendon; springs of tendons. */
static void actuators_and_tendons(void **state)
{
    (void)state;
    scene s = open_text(
        MUJOCO("<option gravity='0 0 0'/><worldbody>"
               "<body><joint name='a'/><inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/></body>"
               "<body><joint name='b'/><inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/></body>"
               "</worldbody><tendon><fixed name='t' stiffness='10' damping='2' springlength='1 2'>"
               "<joint joint='a' coef='2'/><joint joint='b' coef='-1'/></fixed></tendon>"
               "<actuator><motor name='m' joint='a' gear='3'/><position joint='b' kp='5'/>"
               "<velocity tendon='t' kv='7'/>"
               "<general joint='a' gainprm='2' biastype='affine' biasprm='1 2 3' gear='-1'/>"
               "</actuator><keyframe><key name='k' qpos='1 0' ctrl='1 2 3 4'/></keyframe>"),
        NULL);
    const double q[2] = {1.5, 0.25}, u[2] = {0.5, -1.0}, udot[2] = {0.0, 0.0};
    double tau[2];
    assert_int_equal(s.file->actuators, 4);
    assert_int_equal(mbsr_file_find_actuator(s.file, "m"), 0);
    assert_int_equal(mbsr_file_find_key(s.file, "k"), 0);
    for (int k = 0; k < 4; ++k) s.file->control[k] = s.file->key[0].control[k];
    assert_ok(mbsr_inverse_dynamics(s.model, s.data, 0.0, q, u, udot, NULL, tau),
              mbsr_data_error(s.data));
    const double l = 2.0 * q[0] - q[1], rate = 2.0 * u[0] - u[1],
                 spring = -10.0 * (l - 2.0) - 2.0 * rate, drive = 7.0 * 3.0 - 7.0 * rate,
                 general = 2.0 * 4.0 + 1.0 - 2.0 * q[0] - 3.0 * u[0];
    assert_close(-tau[0], 3.0 * 1.0 + 2.0 * (spring + drive) - general, 1e-13);
    assert_close(-tau[1], 5.0 * (2.0 - q[1]) - (spring + drive), 1e-13);
    /* slopes against differences */
    assert_ok(mbsr_stage_positions(s.model, s.data, 0.0, q), mbsr_data_error(s.data));
    assert_ok(mbsr_stage_velocities(s.model, s.data, u), mbsr_data_error(s.data));
    for (int force = 0; force < mbsr_model_forces(s.model); ++force) {
        mbsr_force_errors errors;
        assert_ok(mbsr_force_verify(s.model, s.data, force, &errors), mbsr_data_error(s.data));
        assert_less(errors.largest, 1e-7);
    }
    /* the tendon alone stores and dissipates */
    double energy, power;
    assert_ok(mbsr_energy(s.model, s.data, NULL, &energy), mbsr_data_error(s.data));
    assert_ok(mbsr_dissipation(s.model, s.data, &power), mbsr_data_error(s.data));
    assert_close(energy, 0.5 * 10.0 * (l - 2.0) * (l - 2.0), 1e-13);
    assert_close(power, 2.0 * rate * rate, 1e-13);
    close_scene(&s);
}

static double path_length(const double q[2])
{
    const double x = 2.0 * sin(q[0]), z = 2.0 * cos(q[0]), y = 4.0 + q[1];
    return sqrt(x * x + (3.0 - z) * (3.0 - z)) + sqrt(x * x + y * y + (2.0 - z) * (2.0 - z));
}

/* Along three sites: at rest as drawn; slack between two lengths; energy and power. */
static void paths(void **state)
{
    (void)state;
    scene s = open_text(
        MUJOCO(
            "<worldbody><site name='o' pos='0 0 3'/><body name='a' pos='0 0 0'><joint axis='0 1 "
            "0'/>"
            "<geom size='.1'/><site name='p' pos='0 0 2'/></body><body name='b' pos='0 4 0'>"
            "<joint type='slide' axis='0 1 0'/><geom size='.1'/><site name='q' pos='0 0 2'/></body>"
            "</worldbody><tendon><spatial stiffness='10' damping='2'><site site='o'/><site "
            "site='p'/>"
            "<site site='q'/></spatial><spatial stiffness='10' springlength='4.5 5.5'>"
            "<site site='o'/><site site='p'/><site site='q'/></spatial></tendon>"),
        NULL);
    double q[2] = {0.0, 0.0}, u[2] = {0.0, 0.0}, energy, power;
    const double stretch[] = {0.0, 0.3, 0.8, -0.9}, more[] = {0.0, 0.0, 0.3, -0.4};
    for (int k = 0; k < 4; ++k) { /* lengths are 1 + 4 + q */
        q[1] = stretch[k];
        assert_ok(mbsr_stage_positions(s.model, s.data, 0.0, q), mbsr_data_error(s.data));
        assert_ok(mbsr_stage_velocities(s.model, s.data, u), mbsr_data_error(s.data));
        assert_ok(mbsr_force_power(s.model, s.data, 1, &energy, NULL), mbsr_data_error(s.data));
        assert_close(energy, 5.0 * stretch[k] * stretch[k], 1e-14);
        assert_ok(mbsr_force_power(s.model, s.data, 2, &energy, NULL), mbsr_data_error(s.data));
        assert_close(energy, 5.0 * more[k] * more[k], 1e-14);
    }
    q[0] = 0.4, u[0] = 0.7, u[1] = -0.3;
    const double h = 1e-6, before[2] = {q[0] - h * u[0], q[1] - h * u[1]},
                 behind[2] = {q[0] + h * u[0], q[1] + h * u[1]};
    const double rate = (path_length(behind) - path_length(before)) / (2.0 * h);
    assert_ok(mbsr_stage_positions(s.model, s.data, 0.0, q), mbsr_data_error(s.data));
    assert_ok(mbsr_stage_velocities(s.model, s.data, u), mbsr_data_error(s.data));
    assert_ok(mbsr_force_power(s.model, s.data, 1, &energy, &power), mbsr_data_error(s.data));
    assert_close(energy, 5.0 * (path_length(q) - 5.0) * (path_length(q) - 5.0), 1e-13);
    assert_close(power, 2.0 * rate * rate, 1e-9);
    close_scene(&s);
}

static void equalities(void **state)
{
    (void)state;
    scene s = open_text(
        MUJOCO("<worldbody><body name='a' pos='1 0 0'><joint name='i' ref='0'/>"
               "<inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/></body>"
               "<body name='b' pos='0 3 0'><joint name='j'/><joint name='k' type='slide'/>"
               "<inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/></body></worldbody>"
               "<equality><connect body1='a' body2='b' anchor='1 1 1'/><weld body1='b'/>"
               "<joint joint1='i' joint2='k' polycoef='0 0 3'/><joint joint1='j' joint2='k'/>"
               "<connect body1='a' anchor='0 0 0' active='false'/></equality>"),
        NULL);
    double g[20], q[3] = {0.0, 0.0, 0.0}, u[3] = {1.0, 2.0, 3.0};
    assert_int_equal(mbsr_model_closures(s.model), 4);
    assert_int_equal(mbsr_model_rows(s.model), 3 + 6 + 1 + 1);
    assert_found(s.file, "connect", "not active");
    assert_ok(mbsr_stage_positions(s.model, s.data, 0.0, q), mbsr_data_error(s.data));
    assert_ok(mbsr_closures_gap(s.model, s.data, g), mbsr_data_error(s.data));
    for (int k = 0; k < 11; ++k) assert_close(g[k], 0.0, 1e-15);
    q[0] = 0.3, q[2] = 0.5;
    assert_ok(mbsr_stage_positions(s.model, s.data, 0.0, q), mbsr_data_error(s.data));
    assert_ok(mbsr_stage_velocities(s.model, s.data, u), mbsr_data_error(s.data));
    assert_ok(mbsr_closures_gap(s.model, s.data, g), mbsr_data_error(s.data));
    assert_close(g[9], 0.3 - 3.0 * 0.25, 1e-15);
    for (int k = 0; k < 4; ++k) {
        mbsr_closure_errors errors;
        assert_ok(mbsr_closure_verify(s.model, s.data, k, &errors), mbsr_data_error(s.data));
        assert_less(errors.jacobian + errors.drift + errors.bias, 1e-6);
    }
    close_scene(&s);
}

/* Derivatives of forces and rates of a polynomial between joints, against differences of its rows:
 * on two bodies, and on one. */
static void slopes_of_polynomials(void **state)
{
    static const char *const texts[] = {
        MUJOCO("<worldbody><body name='a'><joint name='i' ref='10'/><geom size='1'/></body>"
               "<body name='b'><joint name='j' ref='20'/><geom size='1'/></body></worldbody>"
               "<equality><joint joint1='i' joint2='j' polycoef='.1 .2 .3 .4 .5'/></equality>"),
        MUJOCO("<worldbody><body name='a'><joint name='i'/><joint name='j' axis='1 0 0'/>"
               "<geom size='1'/></body></worldbody>"
               "<equality><joint joint1='i' joint2='j' polycoef='.1 .2 .3 .4 .5'/></equality>")};
    (void)state;
    for (int both = 1; both >= 0; --both) {
        scene s = open_text(texts[1 - both], NULL);
        mbsr_closure_def def;
        assert_ok(mbsr_closure_definition(s.model, 0, &def), NULL);
        const double h = 1e-6, lambda = 1.7;
        double q[2] = {0.3, -0.4}, u[2] = {1.1, 0.7}, C[2][14] = {{0.0}}, force[14 * 14] = {0.0},
               rate[14] = {0.0};
        const int columns = both ? 14 : 8, column[2] = {0, 7};
        const int own[2] = {6, both ? 13 : 7}; /* of the coordinates */
        mbsr_force_body body[2] = {{.d = 6, .n = both ? 1 : 2, .q = q, .u = u},
                                   {.d = 6, .n = 1, .q = q + 1, .u = u + 1}};
        const mbsr_closure_args args = {.closure = &def, .bodies = 1 + both, .body = body};
        const mbsr_closure_tangent out = {force, rate, 1, columns, column};
        assert_int_equal(def.table->tangent(&args, &lambda, &out), 0);
        for (int k = 0; k < 2; ++k) {
            const double at = q[k];
            memset(C, 0, sizeof C);
            for (int side = 0; side < 2; ++side) {
                const mbsr_closure_jacobian rows = {C[side], 1, columns, column};
                q[k] = at + (side ? h : -h);
                assert_int_equal(def.table->jacobian(&args, &rows), 0);
            }
            q[k] = at;
            double change = 0.0;
            for (int l = 0; l < columns; ++l) {
                const double slope = (C[1][l] - C[0][l]) / (2.0 * h);
                assert_close(force[own[k] * columns + l], lambda * slope, 1e-8);
                for (int j = 0; j < 2; ++j) change += l == own[j] ? slope * u[j] : 0.0;
            }
            assert_close(rate[own[k]], change, 1e-8);
        }
        assert_true(fabs(rate[own[1]]) > 0.1);
        close_scene(&s);
    }
}

/* ---- meshes ---- */

static char stl[84 + 12 * 50];

static void put_float(char *to, double value)
{
    const float x = (float)value;
    memcpy(to, &x, sizeof x);
}

/* A box from (0, 0, 0) to (1, 2, 3), twelve triangles with normals outwards. */
static void make_box(void)
{
    static const int faces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                    {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    stl[80] = 12;
    for (int k = 0; k < 12; ++k) {
        for (int l = 0; l < 3; ++l) {
            const int corner = faces[k / 2][l == 0 ? 0 : l + k % 2];
            for (int r = 0; r < 3; ++r)
                put_float(stl + 84 + 50 * k + 12 + 12 * l + 4 * r, corner >> r & 1 ? 1.0 + r : 0.0);
        }
    }
}

static int load_mesh(void *user, const char *path, const char **text, size_t *size)
{
    static const char obj[] = "# a tetrahedron, inside out\nv 0 0 0\nv 2 0 0\nv 0 2 0\nv 0 0 2\n"
                              "f 1 2 3\nf 1//1 4//1 2//1\nf 1 3 4\nf -3 -1 -2\n",
                      ascii[] = "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n"
                                "vertex 1 0 x\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n";
    (void)user;
    *text = strcmp(path, "d/m/box.stl") == 0     ? stl
            : strcmp(path, "d/m/tetra.obj") == 0 ? obj
            : strcmp(path, "d/m/bad.stl") == 0   ? ascii
                                                 : NULL;
    *size = *text == stl ? sizeof stl : *text ? strlen(*text) : 0;
    return *text == NULL;
}

static mbsr_file *read_mesh(const char *file, const char *more)
{
    char text[600];
    mbsr_file_opt opt = mbsr_default_file_opt();
    mbsr_file *read;
    mbsr_error error;
    opt.load = load_mesh;
    snprintf(
        text, sizeof text,
        MUJOCO("<compiler meshdir='m'/><asset><mesh name='a' file='%s' %s/></asset><worldbody>"
               "<body name='b'><freejoint/><geom type='mesh' mesh='a' pos='0 0 5' density='1'/>"
               "</body></worldbody>"),
        file, more);
    assert_ok(mbsr_file_read(text, strlen(text), "d/f.xml", &opt, &read, &error), &error);
    return read;
}

/* Those of the same solids by formula. */
static void inertias_of_meshes(void **state)
{
    (void)state;
    make_box();
    for (int k = 0; k < 2; ++k) {
        mbsr_file *file = read_mesh("box.stl", k ? "scale='2 -2 2'" : "");
        mbsr_data *d;
        const double f = k ? 2.0 : 1.0, mass = 6.0 * f * f * f, u[6] = {0.0};
        double M[36], m, centre[3];
        assert_int_equal(file->findings, 0);
        assert_string_equal(file->shape[0].mesh, "m/box.stl");
        assert_ok(mbsr_model_finish(file->model), mbsr_model_error(file->model));
        assert_ok(mbsr_data_create(file->model, &d, NULL), NULL);
        assert_ok(mbsr_stage_positions(file->model, d, 0.0, file->q0), mbsr_data_error(d));
        assert_ok(mbsr_stage_velocities(file->model, d, u), mbsr_data_error(d));
        assert_ok(mbsr_tree_momentum(file->model, d, NULL, &m, centre, NULL), mbsr_data_error(d));
        assert_close(m, mass, 1e-13 * mass);
        assert_close(centre[1], k ? -2.0 : 1.0, 1e-14);
        assert_close(centre[2], 5.0 + 1.5 * f, 1e-14);
        assert_ok(mbsr_mass_matrix(file->model, d, M), mbsr_data_error(d));
        const double about_x = mass * (4.0 + 9.0) * f * f / 12.0 +
                               mass * (centre[1] * centre[1] + centre[2] * centre[2]);
        assert_close(M[0], about_x, 1e-12 * about_x);
        mbsr_data_destroy(d);
        mbsr_file_destroy(file);
    }
    mbsr_file *file = read_mesh("tetra.obj", "");
    assert_int_equal(file->findings, 0);
    mbsr_file_destroy(file);
    file = read_mesh("none.stl", "");
    assert_found(file, "geom", "mesh 'a'|no <inertial>|no such file");
    mbsr_file_destroy(file);
    file = read_mesh("bad.stl", "");
    assert_found(file, "geom", "a vertex is not 3 numbers");
    mbsr_file_destroy(file);
}

/* Where the body has an <inertial>, meshes are there to be drawn: nobody asks for their files. */
static void meshes_beside_an_inertial(void **state)
{
    (void)state;
    mbsr_file_opt opt = mbsr_default_file_opt();
    opt.strict = 1;
    mbsr_file *file = read_small(
        MUJOCO("<asset><mesh name='a' file='none.stl'/></asset><worldbody><body name='b'>"
               "<joint name='j'/><geom type='mesh' mesh='a'/><geom size='1'/>"
               "<inertial pos='0 0 1' mass='3' diaginertia='1 1 1'/></body></worldbody>"),
        &opt);
    mbsr_body_def def;
    assert_ok(mbsr_model_finish(file->model), mbsr_model_error(file->model));
    assert_ok(mbsr_body_definition(file->model, 0, &def), NULL);
    assert_true(def.inertia.mass == 3.0);
    assert_int_equal(file->shapes, 2);
    mbsr_file_destroy(file);
}

/* ---- includes ---- */

static int load(void *user, const char *path, const char **text, size_t *size)
{
    static const char *const part =
                                 "<mujocoinclude><body name='in'><joint/></body></mujocoinclude>",
                             *const loop = "<mujoco><include file='loop.xml'/></mujoco>";
    (void)user;
    *text = strcmp(path, "dir/part.xml") == 0   ? part
            : strcmp(path, "dir/loop.xml") == 0 ? loop
                                                : NULL;
    *size = *text ? strlen(*text) : 0;
    return *text == NULL;
}

static int load_nothing(void *user, const char *path, const char **text, size_t *size)
{
    (void)user, (void)path, (void)text, (void)size;
    return EACCES;
}

static void a_reason_to_load_nothing_is_told(void **state)
{
    static const char text[] = WORLD("<include file='none.xml'/>");
    (void)state;
    mbsr_file_opt opt = mbsr_default_file_opt();
    mbsr_file *file;
    mbsr_error error;
    opt.load = load_nothing;
    assert_int_equal(mbsr_file_read(text, strlen(text), "main.xml", &opt, &file, &error),
                     MBSR_ERR_FILE);
    assert_contains(error.text, "none.xml|Permission denied");
}

/* ---- locked joints ---- */

/* Motors and a tendon on three hinges, the second of which is locked or is held by u = u' = 0. */
static void actuators_of_locked_joints_hold(void **state)
{
    static const char text[] = MUJOCO(
        "<worldbody><body name='a'><joint name='ja' axis='0 1 0'/><geom size='.1' mass='1' "
        "pos='1 0 0'/><body name='b' pos='1 0 0'><joint name='jb' axis='0 1 0'/><geom size='.1' "
        "mass='1' pos='1 0 0'/><body name='c' pos='1 0 0'><joint name='jc' axis='1 1 0'/><geom "
        "size='.1' mass='1' pos='1 0 0'/></body></body></body></worldbody>\n"
        "<tendon><fixed name='t'><joint joint='jb' coef='2'/><joint joint='jc' coef='1'/></fixed>"
        "</tendon>\n<actuator><motor joint='jb' gear='3'/><position tendon='t' "
        "kp='7'/></actuator>\n");
    const double q[3] = {0.3, 0.4, -0.2}, u[3] = {0.5, 0.0, 0.1}, x[3] = {0.2, 0.0, 0.7},
                 left_q[2] = {q[0], q[2]}, left_u[2] = {u[0], u[2]}, left_x[2] = {x[0], x[2]};
    double tau[2][3];
    (void)state;
    for (int locked = 0; locked < 2; ++locked) {
        mbsr_file *file = read_small(text, NULL);
        mbsr_data *d = NULL;
        file->control[0] = 5.0;
        file->control[1] = 0.6;
        if (locked)
            assert_ok(mbsr_model_lock(file->model, 1, 0, q[1]), mbsr_model_error(file->model));
        assert_ok(mbsr_model_finish(file->model), mbsr_model_error(file->model));
        assert_ok(mbsr_data_create(file->model, &d, NULL), NULL);
        assert_ok(mbsr_inverse_dynamics(file->model, d, 0.0, locked ? left_q : q,
                                        locked ? left_u : u, locked ? left_x : x, NULL,
                                        tau[locked]),
                  mbsr_data_error(d));
        for (int k = 0; locked && k < mbsr_model_forces(file->model); ++k) {
            mbsr_force_errors errors;
            assert_ok(mbsr_force_verify(file->model, d, k, &errors), mbsr_data_error(d));
            assert_true(errors.largest < 1e-6);
        }
        mbsr_data_destroy(d);
        mbsr_file_destroy(file);
    }
    assert_close(tau[1][0], tau[0][0], 1e-12);
    assert_close(tau[1][1], tau[0][2], 1e-12);
}

static void other_files(void **state)
{
    static const char good[] = WORLD("<include file='part.xml'/><body name='out'/>"),
                      bad[] = WORLD("<include file='none.xml'/>"),
                      endless[] = WORLD("<include file='loop.xml'/>");
    (void)state;
    mbsr_file_opt opt = mbsr_default_file_opt();
    mbsr_file *file;
    mbsr_error error;
    assert_file_refused(good, &opt, "include|part.xml");
    opt.load = load;
    assert_ok(mbsr_file_read(good, strlen(good), "dir/main.xml", &opt, &file, &error), &error);
    assert_int_equal(file->bodies, 2);
    assert_string_equal(file->body_name[0], "in");
    mbsr_file_destroy(file);
    assert_int_equal(mbsr_file_read(bad, strlen(bad), "dir/main.xml", &opt, &file, &error),
                     MBSR_ERR_FILE);
    assert_contains(error.text, "dir/main.xml:2|none.xml");
    assert_int_equal(mbsr_file_read(endless, strlen(endless), "dir/main.xml", &opt, &file, &error),
                     MBSR_ERR_FILE);
    assert_contains(error.text, "loop.xml|twice");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(orientations),
        cmocka_unit_test(several_joints_on_a_body),
        cmocka_unit_test(classes_and_frames),
        cmocka_unit_test(inertias_of_shapes),
        cmocka_unit_test(actuators_and_tendons),
        cmocka_unit_test(paths),
        cmocka_unit_test(equalities),
        cmocka_unit_test(slopes_of_polynomials),
        cmocka_unit_test(inertias_of_meshes),
        cmocka_unit_test(meshes_beside_an_inertial),
        cmocka_unit_test(other_files),
        cmocka_unit_test(a_reason_to_load_nothing_is_told),
        cmocka_unit_test(actuators_of_locked_joints_hold),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
