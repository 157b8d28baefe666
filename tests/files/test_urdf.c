/* What URDF says, feature by feature, and what is refused.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "alike.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define ROBOT(inside) "<robot name='r'>\n" inside "</robot>\n"
#define MASS "<inertial><mass value='2'/><inertia ixx='1' iyy='1' izz='1'/></inertial>"

static mbsr_data *finish(const mbsr_file *file)
{
    mbsr_data *data;
    assert_ok(mbsr_model_finish(file->model), mbsr_model_error(file->model));
    assert_ok(mbsr_data_create(file->model, &data, NULL), NULL);
    return data;
}

static void joints_of_every_type(void **state)
{
    (void)state;
    mbsr_file_opt opt = mbsr_default_file_opt();
    opt.floating = 1;
    mbsr_file *file = read_small(
        ROBOT("<link name='a'>" MASS "</link><link name='b'>" MASS "</link><link name='c'>" MASS
              "</link><link name='d'>" MASS "</link>\n"
              "<joint name='plane' type='planar'><parent link='a'/><child link='b'/>"
              "<axis xyz='0 0 2'/></joint>\n"
              "<joint name='loose' type='floating'><parent link='b'/><child link='c'/>"
              "<origin xyz='1 2 3'/></joint>\n"
              "<joint name='stiff' type='fixed'><parent link='c'/><child link='d'/></joint>"),
        &opt);
    assert_int_equal(file->format, MBSR_FILE_URDF);
    assert_string_equal(file->name, "r");
    assert_int_equal(file->joints, 5);
    assert_int_equal(file->nq, 7 + 3 + 7);
    assert_int_equal(file->nu, 6 + 3 + 6);
    assert_int_equal(file->findings, 0);
    mbsr_data *data = finish(file);
    double pose[MBSR_POSE_SIZE], u[15] = {0.0};
    assert_int_equal(mbsr_model_nu(file->model), file->nu);
    assert_ok(mbsr_stage_positions(file->model, data, 0.0, file->q0), mbsr_data_error(data));
    assert_ok(mbsr_body_pose(file->model, data, mbsr_model_find_body(file->model, "d"), pose),
              mbsr_data_error(data));
    for (int k = 0; k < 3; ++k) assert_close(pose[MBSR_POSE_X + k], 1.0 + k, 1e-15);
    /* the third coordinate of the planar joint turns about its axis */
    u[8] = 1.0;
    assert_ok(mbsr_stage_velocities(file->model, data, u), mbsr_data_error(data));
    double twist[6];
    assert_ok(mbsr_body_twist(file->model, data, mbsr_model_find_body(file->model, "b"), twist),
              mbsr_data_error(data));
    assert_close(twist[2], 1.0, 1e-15);
    mbsr_data_destroy(data);
    mbsr_file_destroy(file);
}

/* Balls of other readers of URDF, by both of their names. */
static void balls_beside_mjcf(void **state)
{
    static const char *const types[] = {"ball", "spherical"};
    static const char other[] =
        "<mujoco><compiler angle='radian' eulerseq='XYZ'/><worldbody>"
        "<body pos='1 2 3' euler='.1 .2 .3'><joint type='ball' damping='.5'/>"
        "<inertial pos='.3 .2 .1' mass='2' diaginertia='1 1.5 2'/></body></worldbody></mujoco>";
    (void)state;
    for (int k = 0; k < 2; ++k) {
        char text[600];
        snprintf(text, sizeof text,
                 ROBOT("<link name='a'/><link name='b'><inertial><origin xyz='.3 .2 .1'/>"
                       "<mass value='2'/><inertia ixx='1' iyy='1.5' izz='2'/></inertial></link>"
                       "<joint name='j' type='%s'><parent link='a'/><child link='b'/>"
                       "<origin xyz='1 2 3' rpy='.1 .2 .3'/><dynamics damping='.5'/></joint>"),
                 types[k]);
        mbsr_file *file = read_small(text, NULL), *same = read_small(other, NULL);
        assert_int_equal(file->findings, 1); /* the base has no mass */
        assert_alike(file, same);
        mbsr_file_destroy(file);
        mbsr_file_destroy(same);
    }
}

static void meshes_of_packages_are_where_the_caller_says(void **state)
{
    (void)state;
    static const char text[] = ROBOT(
        "<link name='a'>" MASS
        "<visual><geometry><mesh filename='package://arm/m/x.stl'/></geometry></visual>"
        "<visual><geometry><mesh filename='package://army/y.stl'/></geometry></visual></link>");
    const mbsr_file_package given[] = {{"ar", "no"}, {"arm", "/data/arm"}};
    mbsr_file_opt opt = mbsr_default_file_opt();
    mbsr_file *file;
    mbsr_error error;
    opt.packages = 2;
    opt.package = given;
    file = read_small(text, &opt);
    assert_string_equal(file->shape[0].mesh, "/data/arm/m/x.stl");
    assert_string_equal(file->shape[1].mesh, "package://army/y.stl");
    mbsr_file_destroy(file);
    opt.package = NULL;
    assert_int_equal(mbsr_file_read(text, strlen(text), NULL, &opt, &file, &error), MBSR_ERR_NULL);
    opt.package = &(mbsr_file_package){"arm", NULL};
    opt.packages = 1;
    assert_int_equal(mbsr_file_read(text, strlen(text), NULL, &opt, &file, &error), MBSR_ERR_NULL);
    opt.packages = -1;
    assert_int_equal(mbsr_file_read(text, strlen(text), NULL, &opt, &file, &error), MBSR_ERR_VALUE);
}

static void what_a_model_has_no_room_for_is_kept(void **state)
{
    (void)state;
    mbsr_file *file = read_small(
        ROBOT(
            "<link name='a'><visual name='hull'><origin xyz='0 0 1'/><geometry><box size='2 4 6'/>"
            "</geometry><material name='red'><color rgba='1 0 0 1'/></material></visual>"
            "<collision><geometry><mesh filename='package://p/m.stl' scale='2 2 2'/></geometry>"
            "</collision></link><link name='b'>" MASS "</link>"
            "<joint name='j' type='revolute'><parent link='a'/><child link='b'/>"
            "<limit lower='-1' upper='2'/><dynamics damping='0.5' friction='0.25'/></joint>"),
        NULL);
    assert_int_equal(file->shapes, 2);
    assert_int_equal(file->shape[0].kind, MBSR_SHAPE_BOX);
    assert_true(file->shape[0].size[2] == 3.0 && file->shape[0].frame.x[2] == 1.0);
    assert_true(file->shape[0].visual && !file->shape[1].visual);
    assert_string_equal(file->shape[0].name, "hull");
    assert_string_equal(file->shape[1].mesh, "package://p/m.stl");
    assert_true(file->joint[0].limited && file->joint[0].range[1] == 2.0);
    assert_true(file->joint[0].friction == 0.25);
    assert_int_equal(file->findings, 1);
    assert_found(file, "link 'a'", "no <inertial>|zero mass");
    assert_int_equal(file->finding[0].line, 2);
    assert_int_equal(mbsr_file_find_joint(file, "j"), 0);
    assert_int_equal(mbsr_file_find_joint(file, "k"), -1);
    mbsr_model *model = mbsr_file_take_model(file);
    assert_non_null(model);
    assert_null(mbsr_file_take_model(file));
    assert_int_equal(mbsr_model_add_body(model, NULL, NULL), MBSR_ERR_NULL); /* not finished */
    assert_ok(mbsr_model_finish(model), mbsr_model_error(model));
    mbsr_file_destroy(file);
    mbsr_model_destroy(model);
}

/* What is left out, as findings say. */
static void what_is_left_out(void **state)
{
    (void)state;
    mbsr_file *file = read_small(
        ROBOT("<link name='a'><visual><geometry><cone/></geometry></visual>" MASS "</link>"
              "<link name='b'>" MASS "</link><link name='c'>" MASS "</link>"
              "<joint name='j' type='fixed'><parent link='a'/><child link='b'/></joint>"
              "<joint name='k' type='continuous'><parent link='b'/><child link='c'/>"
              "<mimic joint='j'/></joint>"),
        NULL);
    assert_found(file, "cone", "not drawn");
    assert_found(file, "joint 'k'", "mimicking is left out");
    assert_int_equal(file->shapes, 0);
    mbsr_file_destroy(file);
}

/* Damping, and on request stops and dry friction. */
static void forces_of_joints(void **state)
{
    static const char text[] =
        ROBOT("<link name='a'/><link name='b'>" MASS "</link>"
              "<joint name='j' type='prismatic'><parent link='a'/><child link='b'/>"
              "<limit lower='-1' upper='1'/><dynamics damping='0.5' friction='4'/></joint>");
    (void)state;
    const double q = 1.5, u = 2.0, udot = 0.0;
    double tau;
    for (int with = 0; with < 2; ++with) {
        mbsr_file_opt opt = mbsr_default_file_opt();
        if (with) opt.stop_stiffness = 100.0, opt.slip = 1e-6;
        mbsr_file *file = read_small(text, &opt);
        mbsr_data *data = finish(file);
        assert_ok(mbsr_inverse_dynamics(file->model, data, 0.0, &q, &u, &udot, NULL, &tau),
                  mbsr_data_error(data));
        assert_close(tau, with ? 1.0 + 50.0 + 4.0 : 1.0, 1e-9);
        mbsr_data_destroy(data);
        mbsr_file_destroy(file);
    }
}

/* No constructor takes a negative principal moment; the file's is kept all the same. */
static void moments_that_no_body_has(void **state)
{
    (void)state;
    mbsr_file_opt opt = mbsr_default_file_opt();
    mbsr_file *file = read_small(
        ROBOT("<link name='a'/><link name='b'><inertial><origin xyz='0 2 0'/><mass value='3'/>"
              "<inertia ixx='-1' iyy='5' izz='1'/></inertial></link>"
              "<joint name='j' type='continuous'><parent link='a'/><child link='b'/></joint>"),
        &opt);
    mbsr_data *data = finish(file);
    double M;
    const double q = 0.3, u = 0.0;
    assert_found(file, "link 'b'", "negative");
    assert_ok(mbsr_stage_positions(file->model, data, 0.0, &q), mbsr_data_error(data));
    assert_ok(mbsr_stage_velocities(file->model, data, &u), mbsr_data_error(data));
    assert_ok(mbsr_mass_matrix(file->model, data, &M), mbsr_data_error(data));
    assert_close(M, -1.0 + 3.0 * 4.0, 1e-12);
    mbsr_data_destroy(data);
    mbsr_file_destroy(file);
    opt.strict = 1;
    assert_file_refused(ROBOT("<link name='a'/>"), &opt, "small.xml:2|link 'a'|zero mass|strict");
}

static void refused_files(void **state)
{
    static const struct {
        const char *text, *words;
    } cases[] = {
        {"", "not XML"},
        {"<robot name='r'><link name='a'></robot>", "small.xml:1|not XML|mismatched"},
        {"<html/>", "no <robot> of URDF"},
        {ROBOT(""), "robot 'r'|no links"},
        {ROBOT("<link/>"), "small.xml:2|link|no name"},
        {ROBOT("<link name='a'/>\n<link name='a'/>"), "small.xml:3|link 'a'|two links"},
        {ROBOT("<link name='a'/>\n<link name='b'/>"), "small.xml:3|second root"},
        {ROBOT("<link name='a'/><joint name='j' type='fixed'><parent link='a'/><child link='x'/>"
               "</joint>"),
         "joint 'j'|child 'x' is no link"},
        {ROBOT("<link name='a'/><joint name='j' type='fixed'><parent link='a'/></joint>"),
         "joint 'j'|no <child link>"},
        {ROBOT("<link name='a'/><link name='b'/><joint name='j' type='bendy'><parent link='a'/>"
               "<child link='b'/></joint>"),
         "joint 'j'|no type 'bendy'"},
        {ROBOT("<link name='a'/><link name='b'/><joint name='j' type='revolute'><axis xyz='0 0 0'/>"
               "<parent link='a'/><child link='b'/></joint>"),
         "joint 'j'|axis"},
        {ROBOT("<link name='a'/><link name='b'/><joint name='j' type='fixed'><parent link='a'/>"
               "<child link='b'/></joint><joint name='k' type='fixed'><parent link='b'/>"
               "<child link='a'/></joint>"),
         "cycle"},
        {ROBOT("<link name='r'/><link name='a'/><link name='b'/><joint name='j' type='fixed'>"
               "<parent link='a'/><child link='b'/></joint><joint name='k' type='fixed'>"
               "<parent link='b'/><child link='a'/></joint>"),
         "link 'a'|cycle"},
        {ROBOT("<link name='r'/><link name='a'/><link name='b'/><joint name='j' type='fixed'>"
               "<parent link='r'/><child link='b'/></joint><joint name='k' type='fixed'>"
               "<parent link='a'/><child link='b'/></joint>"),
         "joint 'k'|hangs on another joint, too"},
        {ROBOT("<link name='a'/><link name='b'/><joint name='j' type='planar'><axis xyz='0 0 0'/>"
               "<parent link='a'/><child link='b'/></joint>"),
         "joint 'j'|axis has no direction"},
        {ROBOT("<link name='a'/><link name='b'/><joint name='j' type='continuous'>"
               "<mimic joint='x'/><parent link='a'/><child link='b'/></joint>"),
         "joint 'j'|mimics 'x', which is no joint"},
        {ROBOT("<link name='a'/><link name='b'/><joint name='j' type='continuous'>"
               "<mimic joint='j'/><parent link='a'/><child link='b'/></joint>"),
         "joint 'j'|mimics itself"},
        {ROBOT("<link name='a'/><link name='b'/><joint name='j' type='continuous'>"
               "<mimic/><parent link='a'/><child link='b'/></joint>"),
         "joint 'j'|no attribute joint"},
        {ROBOT("<link name='a'><visual><geometry><mesh filename='m' scale='1 2'/></geometry>"
               "</visual></link>"),
         "scale is not 3 numbers"},
        {ROBOT("<link name='a'><inertial><mass value='heavy'/></inertial></link>"),
         "link 'a'|heavy"},
        {ROBOT("<link name='a'><inertial><mass value='-1'/></inertial></link>"), "mass is -1"},
        {ROBOT("<link name='a'><inertial><mass value='nan'/></inertial></link>"), "nan"},
        {ROBOT("<link name='a'><inertial><mass value='1e999'/></inertial></link>"), "1e999"},
        {ROBOT("<link name='a'><inertial><origin xyz='1 2'/></inertial></link>"), "3 numbers"},
        {ROBOT("<link name='${n}'/>"), "xacro"},
        {ROBOT("<xacro:macro name='m'/><link name='a'/>"), "xacro"},
        {"<!DOCTYPE r [<!ENTITY a 'b'>]><robot name='&a;'/>", "entities"},
    };
    (void)state;
    for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k)
        assert_file_refused(cases[k].text, NULL, cases[k].words);
}

/* 100 000 elements in each other. */
static void deep_files(void **state)
{
    enum { DEPTH = 100000 };
    (void)state;
    char *text = malloc(3 * DEPTH + 1);
    for (int k = 0; k < DEPTH; ++k) memcpy(text + 3 * k, "<a>", 3);
    text[3 * DEPTH] = '\0';
    assert_file_refused(text, NULL, "too deep");
    free(text);
}

#define LINKS "<link name='a'>" MASS "</link><link name='b'>" MASS "</link>"
#define HUNG(type, more)                                                                           \
    "<joint name='j' type='" type "'><parent link='a'/><child link='b'/>" more "</joint>"

/* A free joint counts from its origin; MuJoCo has it in the world. */
static void states_of_floating_links(void **state)
{
    static const double p[7] = {1.5, -2.0, 0.7, 0.3, -0.4, 0.5, 0.7}, v[6] = {1, 2, 3, -1, 0.5, 2};
    (void)state;
    mbsr_file *file =
        read_small(ROBOT("<link name='ground'/><link name='a'/><link name='b'>" MASS "</link>"
                         "<joint name='i' type='fixed'><parent link='ground'/><child link='a'/>"
                         "<origin xyz='0 0 1' rpy='.3 .2 .1'/></joint>" HUNG(
                             "floating", "<origin xyz='1 2 3' rpy='.4 -.5 "
                                         ".6'/>")),
                   NULL);
    mbsr_data *d = finish(file);
    double q[7], u[6], back[7], rates[6], pose[MBSR_POSE_SIZE], twist[6], R[9];
    const int b = mbsr_model_find_body(file->model, "b");
    assert_ok(mbsr_file_mujoco_state(file, 0, p, v, q, u), NULL);
    assert_ok(mbsr_stage_positions(file->model, d, 0.0, q), mbsr_data_error(d));
    assert_ok(mbsr_stage_velocities(file->model, d, u), mbsr_data_error(d));
    assert_ok(mbsr_body_pose(file->model, d, b, pose), mbsr_data_error(d));
    assert_ok(mbsr_body_twist(file->model, d, b, twist), mbsr_data_error(d));
    mbsr_quaternion_rotation(p + 3, R);
    for (int k = 0; k < 9; ++k) assert_close(pose[MBSR_POSE_R + k], R[k], 1e-14);
    for (int k = 0; k < 3; ++k) {
        const double turning = R[k] * v[3] + R[3 + k] * v[4] + R[6 + k] * v[5];
        assert_close(pose[MBSR_POSE_X + k], p[k], 1e-14);
        assert_close(twist[k], turning, 1e-14);
        assert_close(twist[3 + k], v[k], 1e-14);
    }
    assert_ok(mbsr_file_mujoco_state(file, 1, q, u, back, rates), NULL);
    for (int k = 0; k < 3; ++k) assert_close(back[k], p[k], 1e-14);
    for (int k = 0; k < 6; ++k) assert_close(rates[k], v[k], 1e-14);
    assert_ok(mbsr_stage_positions(file->model, d, 0.0, file->q0), mbsr_data_error(d));
    assert_ok(mbsr_file_mujoco_state(file, 1, file->q0, NULL, back, NULL), NULL);
    assert_ok(mbsr_body_pose(file->model, d, b, pose), mbsr_data_error(d));
    for (int k = 0; k < 3; ++k) assert_close(back[k], pose[MBSR_POSE_X + k], 1e-14);
    mbsr_data_destroy(d);
    mbsr_file_destroy(file);
}

static void what_others_read_in_their_way(void **state)
{
    (void)state;
    mbsr_file *file =
        read_small(ROBOT(LINKS HUNG("revolute", "<limit lower='1' upper='-1'/>")), NULL);
    assert_found(file, "joint 'j'", "lower is above upper");
    assert_int_equal(file->joint[0].limited, 0);
    mbsr_file_destroy(file);
    file = read_small(ROBOT(LINKS HUNG("fixed", "") "<link name='c'>" MASS
                                                    "</link><joint name='j' type='fixed'>"
                                                    "<parent link='a'/><child link='c'/></joint>"),
                      NULL);
    assert_found(file, "joint 'j'", "another joint has this name");
    mbsr_file_destroy(file);
    file = read_small(ROBOT(LINKS HUNG("fixed", "<drake:wheel/>") "<spring name='l'/><gazebo/>"),
                      NULL);
    assert_int_equal(file->findings, 2);
    assert_found(file, "spring 'l'", "left out");
    assert_found(file, "drake:wheel", "left out");
    mbsr_file_destroy(file);
    file = read_small(
        ROBOT("<link name='b'>" MASS
              "<visual><geometry><mesh filename='m.stl' scale='2'/></geometry>"
              "</visual></link><joint name='j' type='fixed'><parent link='world'/><child link='b'/>"
              "<origin xyz='1 0 0'/></joint>"),
        NULL);
    assert_int_equal(file->findings, 0);
    assert_string_equal(file->body_name[0], "world");
    assert_close(file->shape[0].size[2], 2.0, 0.0);
    mbsr_file_destroy(file);
}

/* A pulley of two wheels and a loop that is open by (0.1, 0, 0). */
static void loops_and_couplings(void **state)
{
#define TURNS(name, child, y)                                                                      \
    "<link name='" child "'>" MASS "</link><joint name='" name "' type='continuous'><parent "      \
    "link='a'/><child link='" child "'/><origin xyz='0 " y " 0'/><axis xyz='0 0 1'/></joint>"
    (void)state;
    mbsr_file *file = read_small(
        ROBOT("<link name='a'>" MASS "</link>" TURNS("i", "b", "0") TURNS(
            "j", "c",
            "1") "<coupling name='belt'><predecessor link='b'/><successor link='c'/><ratio "
                 "value='3'/></coupling>"
                 "<loop name='pin' type='revolute'><predecessor link='b'><origin xyz='1 0 "
                 "0'/></predecessor>"
                 "<successor link='c'><origin xyz='.9 -1 0'/></successor></loop>"
                 "<loop_joint name='weld' type='fixed'><link1 link='b' xyz='0 0 0'/><link2 "
                 "link='c'/></loop_joint>"
                 "<coupling name='none'><predecessor link='a'/><successor link='a'/></coupling>"),
        NULL);
    double gap[4];
    const double q[2] = {0.2, 0.1};
    mbsr_data *d = finish(file);
    assert_int_equal(file->findings, 2);
    assert_found(file, "loop_joint 'weld'", "type 'fixed'");
    assert_found(file, "coupling 'none'", "not 1 to");
    assert_int_equal(mbsr_model_position_rows(file->model), 4);
    assert_ok(mbsr_stage_positions(file->model, d, 0.0, file->q0), mbsr_data_error(d));
    assert_ok(mbsr_closures_gap(file->model, d, gap), mbsr_data_error(d));
    const int belt = mbsr_model_find_closure(file->model, "belt") == 0 ? 0 : 3,
              pin = belt == 0 ? 1 : 0;
    assert_close(fabs(gap[pin]), 0.1, 1e-15);
    assert_close(gap[pin + 1], 0.0, 1e-15);
    assert_ok(mbsr_stage_positions(file->model, d, 0.0, q), mbsr_data_error(d));
    assert_ok(mbsr_closures_gap(file->model, d, gap), mbsr_data_error(d));
    assert_close(fabs(gap[belt]), 3.0 * 0.2 - 0.1, 1e-15);
    mbsr_data_destroy(d);
    mbsr_file_destroy(file);
    assert_file_refused(ROBOT("<link name='a'/><loop name='l'><predecessor link='x'/></loop>"),
                        NULL, "loop 'l'|predecessor 'x'");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(joints_of_every_type),
        cmocka_unit_test(balls_beside_mjcf),
        cmocka_unit_test(meshes_of_packages_are_where_the_caller_says),
        cmocka_unit_test(what_a_model_has_no_room_for_is_kept),
        cmocka_unit_test(what_is_left_out),
        cmocka_unit_test(forces_of_joints),
        cmocka_unit_test(moments_that_no_body_has),
        cmocka_unit_test(states_of_floating_links),
        cmocka_unit_test(what_others_read_in_their_way),
        cmocka_unit_test(loops_and_couplings),
        cmocka_unit_test(refused_files),
        cmocka_unit_test(deep_files),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
