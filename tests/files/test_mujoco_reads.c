/* Files that MuJoCo reads and that need care: joints that repeat each other, equalities of what
 * does not move, laws of several numbers, keys; and what nobody follows.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "small.h"

#include <math.h>
#include <stdio.h>

#define MUJOCO(inside) "<mujoco>\n" inside "</mujoco>\n"
#define WORLD(inside) MUJOCO("<worldbody>" inside "</worldbody>\n")

static mbsr_data *finish(mbsr_file *file)
{
    mbsr_data *d;
    assert_ok(mbsr_model_finish(file->model), mbsr_model_error(file->model));
    assert_ok(mbsr_data_create(file->model, &d, NULL), NULL);
    return d;
}

/* With armature all of them move; the sum of the forces on parallel ones is that on each. */
static void joints_that_repeat_each_other(void **state)
{
    static const struct {
        const char *text;
        int joints, bodies;
    } cases[] = {
        {WORLD("<body name='b'><joint armature='1'/><joint armature='1'/><geom size='.1' pos='1 0 "
               "0'/></body>"),
         2, 2},
        {WORLD("<body name='b'><joint armature='1'/><joint armature='1' axis='1 0 0'/><joint "
               "armature='1'/>"
               "<geom size='.1' pos='1 0 0'/></body>"),
         3, 2},
        {WORLD("<body name='b'><joint type='slide' armature='1'/><joint type='slide' armature='1' "
               "axis='1 0 0'/>"
               "<joint type='slide' armature='1' axis='0 1 0'/><joint type='slide' armature='1' "
               "axis='1 1 1'/>"
               "<geom size='.1'/></body>"),
         4, 2},
        {WORLD("<body name='b'><joint type='slide' axis='1 0 0'/><joint axis='1 0 0'/><geom "
               "size='.1'/></body>"),
         2, 1},
    };
    (void)state;
    for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k) {
        mbsr_file *file = read_small(cases[k].text, NULL);
        mbsr_data *d = finish(file);
        double udot[4], u[4] = {0.3, 0.2, 0.1, 0.4}, tau[4];
        assert_int_equal(file->findings, 0);
        assert_int_equal(file->joints, cases[k].joints);
        assert_int_equal(file->bodies, cases[k].bodies);
        assert_ok(mbsr_forward_dynamics(file->model, d, 0.0, file->q0, u, NULL, udot),
                  mbsr_data_error(d));
        assert_ok(mbsr_inverse_dynamics(file->model, d, 0.0, file->q0, u, udot, NULL, tau),
                  mbsr_data_error(d));
        for (int l = 0; l < cases[k].joints; ++l) assert_close(tau[l], 0.0, 1e-12 * 42.0);
        if (k == 0) assert_close(udot[0], udot[1], 1e-14);
        mbsr_data_destroy(d);
        mbsr_file_destroy(file);
    }
}

static void equalities_of_what_does_not_move(void **state)
{
    (void)state;
    mbsr_file *file = read_small(
        MUJOCO("<worldbody><body name='still'/><body name='arm'><joint name='j'/><geom size='1'/>"
               "<body name='hand'/></body></worldbody><equality><weld name='a' body1='still'/>"
               "<connect name='b' body1='arm' body2='hand' anchor='0 0 0'/>"
               "<weld name='c' body1='hand' body2='still'/></equality>"),
        NULL);
    assert_found(file, "weld 'a'", "nothing moves");
    assert_found(file, "connect 'b'", "nothing moves");
    assert_int_equal(file->findings, 2);
    mbsr_data *d = finish(file);
    assert_int_equal(mbsr_model_closures(file->model), 1);
    mbsr_data_destroy(d);
    mbsr_file_destroy(file);
}

/* tau = -(k x + b x^3) - d x' */
static void springs_of_several_numbers(void **state)
{
    (void)state;
    mbsr_file *file = read_small(MUJOCO("<option gravity='0 0 0'/><worldbody><body name='b'><joint "
                                        "name='a' stiffness='2 0 5' damping='3 0 0'/>"
                                        "<joint name='c' axis='0 1 0' stiffness='2 1 0' damping='3 "
                                        "4'/><geom size='1'/></body></worldbody>"),
                                 NULL);
    mbsr_data *d = finish(file);
    const double q[2] = {0.5, 0.0}, u[2] = {0.0}, udot[2] = {0.0};
    double tau[2];
    assert_found(file, "joint 'c'", "of its stiffness the first");
    assert_int_equal(file->findings, 2);
    assert_ok(mbsr_inverse_dynamics(file->model, d, 0.0, q, u, udot, NULL, tau),
              mbsr_data_error(d));
    assert_close(tau[0], 2.0 * 0.5 + 5.0 * 0.125, 1e-14);
    mbsr_data_destroy(d);
    mbsr_file_destroy(file);
}

static void keys_that_are_short_or_zero(void **state)
{
    (void)state;
    mbsr_file *file = read_small(
        MUJOCO(
            "<worldbody><body pos='1 2 3'><freejoint/><geom size='1'/></body></worldbody><keyframe>"
            "<key name='zero' qpos='4 5 6 0 0 0 0'/><key name='short' qvel='1 2'/></keyframe>"),
        NULL);
    assert_int_equal(file->findings, 1);
    assert_found(file, "key 'short'", "2 numbers of 6");
    assert_close(file->key[0].q[0], 1.0, 0.0);
    assert_close(file->key[0].q[6], 6.0, 0.0);
    assert_close(file->key[1].u[4], 2.0, 0.0);
    mbsr_file_destroy(file);
}

static void masses_are_scaled_to_their_total(void **state)
{
    (void)state;
    mbsr_file *file = read_small(
        MUJOCO(
            "<compiler settotalmass='12'/><worldbody><body><joint/><geom size='.1' mass='1' pos='1 "
            "0 0'/><body>"
            "<inertial pos='0 0 2' mass='3' diaginertia='.1 .2 .25'/></body></body></worldbody>"),
        NULL);
    mbsr_body_def def;
    assert_int_equal(file->findings, 0);
    assert_ok(mbsr_model_finish(file->model), mbsr_model_error(file->model));
    assert_ok(mbsr_body_definition(file->model, 1, &def), NULL);
    assert_close(def.inertia.mass, 9.0, 1e-14);
    assert_close(def.inertia.com[2], 2.0, 1e-14);
    assert_ok(mbsr_body_definition(file->model, 0, &def), NULL);
    assert_close(def.inertia.mass, 3.0, 1e-14);
    mbsr_file_destroy(file);
    assert_file_refused(MUJOCO("<compiler settotalmass='12'/><worldbody><body/></worldbody>"), NULL,
                        "no mass that settotalmass");
}

/* Free bodies whose frames are put along their principal axes: positions as drawn and sites as
 * MuJoCo 3.14 has them. */
static void free_bodies_are_aligned(void **state)
{
    static const double drawn[5][7] = {
        {1.090016549054047, 2.170065629827372, 3.320896716168644, 0.2943368939055793,
         0.6987425776300933, -0.3590049795638360, 0.5442793655295421},
        {0.1, 0.2, 1.3, 0.9396926207859084, 0.0, 0.0, 0.3420201433256687},
        {0.3200686327170523, 0.0, 0.007488013797839199, 0.7055445120728535, 0.04697809578814161,
         0.04697809578814161, 0.7055445120728535},
        {0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0},
        {0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0}};
    static const double site[3] = {-0.26746913067587824, 0.14151173607680398, -0.13577441838586327};
    (void)state;
    mbsr_file *file = read_small(
        MUJOCO("<compiler alignfree='true' angle='degree'/><worldbody><body name='a' pos='1 2 3' "
               "euler='10 20 30'><freejoint/><inertial pos='.1 .2 .3' mass='2' fullinertia='.5 .3 "
               ".6 .01 -.02 .03'/><geom name='g' size='.1' pos='.2 0 0'/><site name='s' pos='0 .3 "
               "0' euler='30 0 0'/></body><body name='b' pos='0 0 1'><freejoint/><geom type='box' "
               "size='.1 .2 .3' pos='.1 .2 .3' euler='0 0 40'/></body><body name='c' euler='0 50 "
               "0'><freejoint/><geom type='box' size='.3 .2 .1' pos='.4 0 0' mass='1'/><geom "
               "size='.1' pos='0 0 .5' mass='1'/></body><body name='d'><freejoint align='false'/>"
               "<geom size='.1' pos='1 0 0'/></body><body name='e'><freejoint/><geom size='.1' "
               "pos='1 0 0'/><body><geom size='.1'/></body></body></worldbody>"),
        NULL);
    assert_int_equal(file->findings, 0);
    mbsr_data *d = finish(file);
    double p[35];
    assert_ok(mbsr_file_mujoco_state(file, 1, file->q0, NULL, p, NULL), NULL);
    for (int b = 0; b < 5; ++b) {
        const double side = p[7 * b + 3] * drawn[b][3] < 0.0 ? -1.0 : 1.0;
        for (int k = 0; k < 7; ++k)
            assert_close((k < 3 ? 1.0 : side) * p[7 * b + k], drawn[b][k], 1e-14);
    }
    for (int k = 0; k < 3; ++k) assert_close(file->site[0].frame.x[k], site[k], 1e-14);
    for (int b = 0; b < 3; ++b) { /* its centre, no products of inertia */
        mbsr_body_def def;
        assert_ok(mbsr_body_definition(file->model, b, &def), NULL);
        for (int k = 0; k < 3; ++k) assert_close(def.inertia.com[k], 0.0, 1e-15);
        for (int k = 3; k < 6; ++k) assert_close(def.inertia.tensor[k], 0.0, 1e-15);
    }
    mbsr_data_destroy(d);
    mbsr_file_destroy(file);
}

static void what_nobody_follows(void **state)
{
    (void)state;
    mbsr_file *file = read_small(
        MUJOCO("<option actuatorgroupdisable='2 3'><flag "
               "clampctrl='enable'/></option><default><joint margin='1'/>"
               "<default class='c'><geom glow='1'/></default></default><worldbody><body "
               "name='b' colour='red'>"
               "<joint name='j' user='1' springyness='3'/><geom name='g' size='1' friction='1' "
               "smell='2'/><site name='s' noise='1'/>"
               "</body><body name='f'><freejoint name='r'/><geom "
               "size='1'/></body></worldbody>"
               "<tendon><fixed name='t'><joint joint='j' coef='1' bogus='2'/></fixed>"
               "<fixed name='ball'><joint joint='r' coef='1'/></fixed></tendon>"
               "<equality><joint name='q' joint1='j' rank='2'/></equality>"
               "<actuator><motor name='m' joint='j' delay='1' armature='2' damping='3' "
               "group='2'/></actuator>"),
        NULL);
    static const char *const elements[][2] = {
        {"body 'b'", "colour"}, {"joint 'j'", "springyness"},     {"geom 'g'", "smell"},
        {"site 's'", "noise"},  {"fixed 'ball'", "not one axis"}, {"joint 'q'", "rank"}};
    for (size_t k = 0; k < sizeof elements / sizeof *elements; ++k)
        assert_found(file, elements[k][0], elements[k][1]);
    assert_found(file, "motor 'm'", "delay");
    assert_int_equal(file->findings, 12);
    assert_int_equal(file->actuator[0].force, MBSR_NONE);
    mbsr_file_destroy(file);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(joints_that_repeat_each_other),
        cmocka_unit_test(equalities_of_what_does_not_move),
        cmocka_unit_test(springs_of_several_numbers),
        cmocka_unit_test(keys_that_are_short_or_zero),
        cmocka_unit_test(masses_are_scaled_to_their_total),
        cmocka_unit_test(free_bodies_are_aligned),
        cmocka_unit_test(what_nobody_follows),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
