/* Limits and dry friction of joints by the masses and ranges of the model: the numbers of the rule
 * by hand.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "small.h"

#include <math.h>
#include <stdio.h>

/* 2 kg at 0.5 m, whose own moment is 0.4 2 0.1^2; gravity 10. */
#define ROD(joint)                                                                                 \
    "<mujoco><compiler angle='radian'/><option gravity='0 0 -10'>%s</option><worldbody><body>"     \
    "<joint name='j' " joint                                                                       \
    "/><geom size='.1' mass='2' pos='.5 0 0'/></body></worldbody></mujoco>"

static mbsr_file *read_with(const char *text, int limits, int friction)
{
    mbsr_file_opt opt = mbsr_default_file_opt();
    opt.limits = limits;
    opt.friction = friction;
    return read_small(text, &opt);
}

#define WORLD(inside)                                                                              \
    "<mujoco><compiler angle='radian'/><option gravity='0 0 -10'/><worldbody>" inside              \
    "</worldbody></mujoco>"
#define BALL "<geom size='.1' mass='2' pos='.5 0 0'/>"

static void stops_by_mass_and_range(void **state)
{
    static const double M = 2.0 * 0.25 + 0.4 * 2.0 * 0.01;
    static const struct {
        const char *text;
        double stiffness, ratio, mass;
    } cases[] = {
        /* 1 / 0.02^2 / 0.95 */
        {WORLD("<body><joint axis='0 1 0' range='-1 1'/>" BALL "</body>"), 2500.0 / 0.95, 1.0, 1.0},
        {WORLD("<body><joint axis='0 1 0' range='-1 1' armature='.3'/>" BALL "</body>"),
         2500.0 / 0.95, 1.0, 1.6},
        {WORLD("<body><joint axis='0 1 0' range='-1 1' solreflimit='.05 .5' solimplimit='.9 "
               ".8'/>" BALL "</body>"),
         1600.0 / 0.8, 0.5, 1.0},
        {WORLD("<body><joint axis='0 1 0' range='-1 1' solreflimit='-2500 -50'/>" BALL "</body>"),
         2500.0 / 0.95, 0.5, 1.0},
        /* a range of 0.001: 100 times the weight's moment 10 N m by it */
        {WORLD("<body><joint axis='0 1 0' range='0 .001'/>" BALL "</body>"), 0.0, 1.0, 1.0},
    };
    (void)state;
    for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k) {
        mbsr_file *file = read_with(cases[k].text, 1, 0);
        const mbsr_file_joint *j = file->joint;
        const double mass = cases[k].mass > 1.5 ? M + 0.3 : M,
                     K = cases[k].stiffness > 0.0 ? mass * cases[k].stiffness
                                                  : 100.0 * 2.0 * 0.5 * 10.0 / 0.001;
        assert_close(j->stop_stiffness, K, 1e-12 * K);
        assert_close(j->stop_damping, 2.0 * cases[k].ratio * sqrt(K * mass), 1e-12 * K);
        assert_int_equal(file->findings, 0);
        assert_ok(mbsr_model_finish(file->model), mbsr_model_error(file->model));
        assert_int_equal(mbsr_model_forces(file->model), 2);
        mbsr_file_destroy(file);
    }
}

/* A slide carries all behind it; a coordinate without mass counts with the least of the others. */
static void chains_and_joints_without_mass(void **state)
{
    (void)state;
    mbsr_file *file = read_with(
        WORLD("<body><joint type='slide' axis='0 0 1' range='0 1'/><geom size='.1' mass='3'/><body "
              "pos='1 0 0'>"
              "<joint axis='0 0 1' range='-2 2' frictionloss='1'/>" BALL "<body pos='1 0 0'>"
              "<joint axis='1 0 0' range='-1 1' damping='1'/></body></body></body>"),
        1, 1);
    const double M = 2.0 * 0.25 + 0.4 * 2.0 * 0.01, k = 2500.0 / 0.95;
    assert_close(file->joint[0].stop_stiffness, 5.0 * k, 1e-11 * k);
    assert_close(file->joint[1].stop_stiffness, M * k, 1e-12 * k);
    assert_close(file->joint[1].slip, 0.004, 1e-17);
    assert_close(file->joint[2].stop_stiffness, M * k, 1e-12 * k);
    assert_close(file->joint[2].slip, 0.0, 0.0);
    mbsr_file_destroy(file);
}

static void options_and_flags_decide(void **state)
{
    static const char text[] =
        WORLD("<body><joint name='j' range='-1 1' frictionloss='2'/>" BALL "</body>");
    (void)state;
    mbsr_file *file = read_with(text, 0, 0);
    assert_close(file->joint[0].stop_stiffness + file->joint[0].slip, 0.0, 0.0);
    mbsr_file_destroy(file);
    mbsr_file_opt opt = mbsr_default_file_opt();
    opt.limits = opt.friction = 1;
    opt.stop_stiffness = 7.0, opt.stop_damping = 3.0, opt.slip = 0.5;
    file = read_small(text, &opt);
    assert_close(file->joint[0].stop_stiffness, 7.0, 0.0);
    assert_close(file->joint[0].stop_damping, 3.0, 0.0);
    assert_close(file->joint[0].slip, 0.5, 0.0);
    mbsr_file_destroy(file);
    for (int k = 0; k < 2; ++k) {
        char off[700];
        snprintf(off, sizeof off, ROD("range='-1 1' frictionloss='2'"),
                 k ? "<flag limit='disable' frictionloss='disable'/>"
                   : "<flag constraint='disable'/>");
        file = read_with(off, 1, 1);
        assert_close(file->joint[0].stop_stiffness + file->joint[0].slip, 0.0, 0.0);
        mbsr_file_destroy(file);
    }
    file = read_with(WORLD("<body><joint name='b' type='ball' range='0 1'/>" BALL "</body>"), 1, 1);
    assert_found(file, "joint 'b'", "limits and dry friction are left out");
    mbsr_file_destroy(file);
}

/* A pendulum that falls onto its stop stays within a hundredth of the range beyond it. */
static void a_stop_holds_what_it_carries(void **state)
{
    (void)state;
    mbsr_file *file =
        read_with(WORLD("<body><joint axis='0 1 0' range='-1 0'/>" BALL "</body>"), 1, 0);
    mbsr_data *d;
    const double u = 0.0, M = 2.0 * 0.25 + 0.4 * 2.0 * 0.01;
    double acceleration, q = 2.0 * 0.5 * 10.0 / file->joint[0].stop_stiffness;
    assert_ok(mbsr_model_finish(file->model), mbsr_model_error(file->model));
    assert_ok(mbsr_data_create(file->model, &d, NULL), NULL);
    assert_true(q <= 0.01);
    assert_ok(mbsr_forward_dynamics(file->model, d, 0.0, &q, &u, NULL, &acceleration),
              mbsr_data_error(d));
    assert_close(acceleration, 0.0, 10.0 / M * (1.0 - cos(q)) + 1e-12);
    mbsr_data_destroy(d);
    mbsr_file_destroy(file);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(stops_by_mass_and_range),
        cmocka_unit_test(chains_and_joints_without_mass),
        cmocka_unit_test(options_and_flags_decide),
        cmocka_unit_test(a_stop_holds_what_it_carries),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
