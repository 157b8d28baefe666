/* Models that a file of MJCF attaches, and composites: the same as what they stand for.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "alike.h"

#include <math.h>
#include <stdio.h>

#define MUJOCO(inside) "<mujoco>\n" inside "</mujoco>\n"

/* A model with options of its own: angles, classes, replicas; its parts refer to each other. */
static const char arm[] = MUJOCO(
    "<compiler angle='radian' eulerseq='zyx'/><option gravity='0 0 0'/>"
    "<default><geom density='300'/><default class='light'><geom density='10'/><joint "
    "armature='.1'/></default></default>"
    "<asset><mesh name='tetra' vertex='0 0 0 1 0 0 0 1 0 0 0 1' face='0 2 1 0 1 3 0 3 2 1 2 "
    "3'/></asset>"
    "<worldbody><frame name='stand' pos='0 0 .1'><body name='upper' euler='.1 .2 .3'>"
    "<joint name='s' axis='0 1 0'/><geom size='.1'/>"
    "<body name='lower' pos='.5 0 0' childclass='light'><joint name='e' axis='0 1 0' "
    "range='-1 1'/><geom type='mesh' mesh='tetra'/><site name='hand' pos='.4 0 0'/></body></body>"
    "</frame><site name='mark' pos='1 1 1'/></worldbody>"
    "<tendon><fixed name='both'><joint joint='s' coef='1'/><joint joint='e' coef='2'/></fixed>"
    "</tendon><actuator><motor name='m' joint='e' gear='3'/><motor name='t' tendon='both'/>"
    "</actuator><keyframe><key name='k' qpos='.1 .2'/></keyframe>");

static int load(void *user, const char *path, const char **text, size_t *size)
{
    *text = user;
    *size = strlen(user);
    return strcmp(path, "parts/arm.xml") != 0;
}

static mbsr_file *read_host(const char *text, const char *model)
{
    mbsr_file_opt opt = mbsr_default_file_opt();
    opt.load = load;
    opt.user = (void *)model;
    return read_small(text, &opt);
}

/* Beside the same written by hand, in the degrees of the host. */
static void a_body_of_another_model(void **state)
{
    (void)state;
    mbsr_file *attached = read_host(
        MUJOCO(
            "<default><geom density='5000'/></default><asset><model name='a' "
            "file='parts/arm.xml'/></asset>"
            "<worldbody><body name='base'><joint name='s'/><geom size='.2'/>"
            "<frame pos='0 1 0' euler='90 0 0'><attach model='a' body='upper' prefix='l_'/></frame>"
            "</body></worldbody><actuator><motor name='m' joint='s'/></actuator>"),
        arm);
    mbsr_file *written = read_small(
        MUJOCO("<default><geom density='5000'/></default><asset><mesh name='tetra' "
               "vertex='0 0 0 1 0 0 0 1 0 0 0 1' face='0 2 1 0 1 3 0 3 2 1 2 3'/></asset>"
               "<compiler angle='radian' eulerseq='zyx'/>"
               "<worldbody><body name='base'><joint name='s'/><geom size='.2'/>"
               "<frame pos='0 1 0' axisangle='1 0 0 1.5707963267948966'><body euler='.1 .2 .3'>"
               "<joint name='ls' axis='0 1 0'/><geom size='.1' density='300'/><body pos='.5 0 0'>"
               "<joint name='le' axis='0 1 0' armature='.1'/><geom type='mesh' mesh='tetra' "
               "density='10'/></body></body></frame></body></worldbody>"
               "<tendon><fixed name='both'><joint joint='ls' coef='1'/><joint joint='le' "
               "coef='2'/></fixed></tendon>"
               "<actuator><motor joint='le' gear='3'/><motor tendon='both'/><motor "
               "joint='s'/></actuator>"),
        NULL);
    assert_int_equal(attached->findings, 2);
    assert_found(attached, "keyframe", "keys");
    assert_found(attached, "option", "options");
    assert_string_equal(attached->joint[2].name, "l_e");
    assert_close(attached->joint[2].range[1], 1.0, 0.0);
    assert_string_equal(attached->body_name[2], "l_lower");
    assert_int_equal(mbsr_file_find_site(attached, "l_hand"), 0);
    assert_int_equal(mbsr_file_find_site(attached, "l_mark"), -1);
    assert_int_equal(mbsr_file_find_actuator(attached, "l_t"), 1);
    assert_alike(attached, written);
    mbsr_file_destroy(attached);
    mbsr_file_destroy(written);
}

/* With a frame, with all of a world, in replicas, and a body of the file itself. */
static void other_ways_to_attach(void **state)
{
    (void)state;
    mbsr_file *file = read_host(
        MUJOCO("<asset><model name='a' file='parts/arm.xml'/></asset><worldbody>"
               "<attach model='a' frame='stand' prefix='f_'/><frame pos='5 0 0'><attach model='a' "
               "prefix='w_'/></frame>"
               "<replicate count='2' offset='1 0 0' sep='-'><attach model='a' body='upper' "
               "prefix='r_'/></replicate>"
               "<body name='own'><joint name='own_j'/><geom size='.1'/></body>"
               "<attach body='own' prefix='second_'/></worldbody>"),
        arm);
    assert_int_equal(file->bodies, 10);
    assert_string_equal(file->body_name[0], "f_upper");
    assert_string_equal(file->body_name[7], "r_lower-1");
    assert_string_equal(file->body_name[9], "second_own");
    assert_int_equal(mbsr_file_find_joint(file, "second_own_j"), 9);
    assert_int_equal(file->actuators, 8);
    assert_true(mbsr_file_find_actuator(file, "r_m-1") >= 0);
    const int mark = mbsr_file_find_site(file, "w_mark");
    assert_true(mark >= 0);
    assert_close(file->site[mark].frame.x[0], 6.0, 1e-15);
    mbsr_file_destroy(file);
}

static void assert_host_refused(const char *text, const char *model, const char *words)
{
    mbsr_file_opt opt = mbsr_default_file_opt();
    opt.load = load;
    opt.user = (void *)model;
    assert_file_refused(text, &opt, words);
}

static void attachments_that_are_refused(void **state)
{
    static const char head[] = "<asset><model name='a' file='parts/arm.xml'/></asset><worldbody>";
    static const char *const cases[][2] = {
        {"<attach model='a' body='upper'/>", "prefix"},
        {"<attach model='b' prefix='x'/>", "'b' is no model"},
        {"<attach model='a' body='none' prefix='x'/>", "no body 'none'"},
        {"<attach prefix='x'/>", "neither model nor body"},
        {"<attach model='a' prefix='x'/><attach model='a' prefix='x'/>", "two of that name"},
    };
    char text[1000];
    (void)state;
    for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k) {
        snprintf(text, sizeof text, "<mujoco>%s%s</worldbody></mujoco>", head, cases[k][0]);
        assert_host_refused(text, arm, cases[k][1]);
    }
    assert_host_refused(MUJOCO("<asset><model file='parts/arm.xml'/></asset>"), "<robot/>",
                        "no <mujoco>");
    assert_host_refused(MUJOCO("<asset><model file='other.xml'/></asset>"), arm,
                        "there is no file other.xml");
    /* a model that attaches itself */
    static char circle[] = MUJOCO("<asset><model name='a' file='arm.xml'/></asset>");
    assert_host_refused(MUJOCO("<asset><model name='a' file='parts/arm.xml'/></asset>"), circle,
                        "too deeply");
}

/* ---- composites ---- */

/* Bodies and ends of a cable; places are those of MuJoCo 3.14. */
static void a_cable(void **state)
{
    (void)state;
    mbsr_file *file = read_small(
        MUJOCO("<default><geom density='77'/><joint damping='9'/></default><worldbody>"
               "<composite prefix='k' type='cable' curve='s sin(s) 0' count='5 1 1' size='1 .2 2' "
               "initial='none' offset='0 0 1'><joint kind='main' damping='.1'/><geom "
               "type='capsule' size='.01'/></composite></worldbody>"),
        NULL);
    mbsr_data *d;
    double pose[MBSR_POSE_SIZE], mass;
    assert_int_equal(file->findings, 0);
    assert_int_equal(file->bodies, 4);
    assert_string_equal(file->body_name[0], "kB_first");
    assert_string_equal(file->body_name[2], "kB_2");
    assert_string_equal(file->joint[2].name, "kJ_last");
    assert_int_equal(file->joints, 3);
    assert_ok(mbsr_model_finish(file->model), mbsr_model_error(file->model));
    assert_ok(mbsr_data_create(file->model, &d, NULL), NULL);
    assert_ok(mbsr_stage_positions(file->model, d, 0.0, file->q0), mbsr_data_error(d));
    /* the points of the sine, and its end */
    for (int k = 0; k < 4; ++k) {
        assert_ok(mbsr_body_pose(file->model, d, k, pose), mbsr_data_error(d));
        assert_close(pose[MBSR_POSE_X], 0.25 * k, 1e-7);
        assert_close(pose[MBSR_POSE_X + 1], 0.2 * sin(1.5707963267948966 * k), 1e-7);
        assert_close(pose[MBSR_POSE_X + 2], 1.0, 1e-15);
    }
    const int end = mbsr_file_find_site(file, "kS_last");
    double point[3];
    assert_true(end >= 0);
    assert_ok(mbsr_body_point(file->model, d, 3, file->site[end].frame.x, point, NULL, NULL),
              mbsr_data_error(d));
    assert_close(point[0], 1.0, 1e-7);
    assert_close(point[1], 0.0, 1e-7);
    /* capsules of water, whatever the class says */
    const double length = sqrt(0.25 * 0.25 + 0.2 * 0.2), pi = 3.14159265358979;
    mbsr_body_def def = mbsr_default_body_def();
    mbsr_body_definition(file->model, 1, &def);
    mass = 1000.0 * (pi * 1e-4 * length + 4.0 / 3.0 * pi * 1e-6);
    assert_close(def.inertia.mass, mass, 1e-7);
    mbsr_data_destroy(d);
    mbsr_file_destroy(file);
}

static void composites_that_are_refused(void **state)
{
    static const char *const cases[][2] = {
        {"type='rope'", "type 'rope'"},
        {"type='cable' count='1'", "count"},
        {"type='cable' count='3 2 1'", "count"},
        {"type='cable' vertex='0 0 0 1'", "vertex"},
        {"type='cable' vertex='0 0 x'", "vertex"},
        {"type='cable' count='3' curve='tan(s)'", "curve"},
    };
    char text[400];
    (void)state;
    for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k) {
        snprintf(text, sizeof text,
                 "<mujoco><worldbody><composite %s><geom type='box' size='1 1 "
                 "1'/></composite></worldbody></mujoco>",
                 cases[k][0]);
        assert_file_refused(text, NULL, cases[k][1]);
    }
    assert_file_refused(MUJOCO("<worldbody><composite type='cable' count='3'/></worldbody>"), NULL,
                        "its geom is no capsule");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_body_of_another_model),      cmocka_unit_test(other_ways_to_attach),
        cmocka_unit_test(attachments_that_are_refused), cmocka_unit_test(a_cable),
        cmocka_unit_test(composites_that_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
