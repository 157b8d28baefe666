/* Actuators of MJCF: ratios of damping, ranges, sites; weight that is carried; and all of it
 * written and read again. Numbers are those of MuJoCo 3.14.
 * SPDX-License-Identifier: BSD-3-Clause
 */
#include "small.h"

#include <mbsrank/verify.h>

#include <math.h>

#define MUJOCO(inside) "<mujoco>\n" inside "</mujoco>\n"

static const char arm[] = MUJOCO(
    "<compiler angle='radian'/><option gravity='0 0 -9'/><worldbody>"
    "<body name='a'><joint name='i' axis='0 1 0' range='-1 2' actuatorfrcrange='-3 4' "
    "armature='.1'/>"
    "<geom size='.1' pos='.5 0 .2'/><body name='b' pos='0 0 1' gravcomp='.5'><joint name='j' "
    "axis='1 0 0'/>"
    "<joint name='k' type='slide' axis='0 0 1'/><geom type='box' size='.1 .2 .3' pos='.1 0 .2'/>"
    "</body></body><body name='c' pos='2 0 0'><freejoint/><geom type='box' size='.1 .2 .3'/>"
    "<site name='s' pos='.1 .2 .3' euler='.3 .2 .1'/></body></worldbody>"
    "<tendon><fixed name='t' actuatorfrcrange='-2 2'><joint joint='j' coef='2'/><joint joint='k' "
    "coef='-1'/></fixed>"
    "</tendon><actuator><position name='p' joint='i' kp='50' dampratio='.7' inheritrange='.5' "
    "gear='2'/>"
    "<position name='q' tendon='t' kp='20' dampratio='1' ctrlrange='-.3 .3'/>"
    "<motor name='m' site='s' gear='1 2 3 .1 .2 .3' forcerange='-.5 .6'/>"
    "<general name='g' site='s' gear='0 0 1' biastype='affine' biasprm='.1 .2 -.3' "
    "gainprm='2'/></actuator>");

static const double p[10] = {0.1, 0.2, 0.3, 2, 0.1, 0.2, 0.5, 0.5, -0.5, 0.5},
                    v[9] = {0.3, -0.2, 0.5, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6},
                    acceleration[9] = {0.312422752012862,   2.08428265434601,    -4.24788376496356,
                                       -0.0164034766604881, -0.0353687558486637, -8.98398934696777,
                                       0.204740136543506,   -0.109973820114648,  0.271956923302415};

static mbsr_data *finish(mbsr_file *file)
{
    mbsr_data *d;
    assert_ok(mbsr_model_finish(file->model), mbsr_model_error(file->model));
    assert_ok(mbsr_data_create(file->model, &d, NULL), NULL);
    return d;
}

static void assert_moves_alike(mbsr_file *file)
{
    static const double control[4] = {1.5, 0.4, 0.9, -0.2};
    double q[10], u[9], udot[9];
    mbsr_data *d = finish(file);
    assert_int_equal(file->actuators, 4);
    for (int k = 0; k < 4; ++k) file->control[k] = control[k];
    assert_ok(mbsr_file_mujoco_state(file, 0, p, v, q, u), NULL);
    assert_ok(mbsr_forward_dynamics(file->model, d, 0.0, q, u, NULL, udot), mbsr_data_error(d));
    double still[10], rates[9]; /* accelerations turn as velocities do */
    assert_ok(mbsr_file_mujoco_state(file, 1, q, udot, still, rates), NULL);
    for (int k = 0; k < 9; ++k) assert_close(rates[k], acceleration[k], 1e-12);
    assert_ok(mbsr_stage_positions(file->model, d, 0.0, q), mbsr_data_error(d));
    assert_ok(mbsr_stage_velocities(file->model, d, u), mbsr_data_error(d));
    for (int k = 0; k < mbsr_model_forces(file->model); ++k) {
        mbsr_force_errors errors;
        if (mbsr_force_verify(file->model, d, k, &errors) == MBSR_ERR_VALUE)
            continue; /* differenced */
        assert_true(errors.largest < 1e-7);
    }
    mbsr_data_destroy(d);
}

static void actuators_as_in_mujoco(void **state)
{
    (void)state;
    mbsr_file *file = read_small(arm, NULL);
    assert_int_equal(file->findings, 0);
    assert_moves_alike(file);
    assert_close(file->actuator[0].bias[2], -42.1547370510726, 1e-12);
    assert_close(file->actuator[1].bias[2], -62.6099033699941, 1e-12);
    assert_close(file->actuator[0].range[0], -0.25, 1e-15);
    assert_close(file->actuator[0].range[1], 1.25, 1e-15);
    assert_close(file->actuator[0].force_range[0], -1.5, 1e-15); /* -3 / gear */
    mbsr_file_destroy(file);
}

static void they_come_back(void **state)
{
    (void)state;
    mbsr_written *written;
    mbsr_error error;
    mbsr_file *file = read_small(arm, NULL);
    mbsr_data *d = finish(file);
    assert_ok(mbsr_file_write_mjcf(file->model, file, NULL, &written, &error), &error);
    assert_int_equal(written->findings, 0);
    mbsr_file *again = read_small(written->text, NULL);
    assert_int_equal(again->findings, 0);
    assert_moves_alike(again);
    mbsr_data_destroy(d);
    mbsr_written_destroy(written);
    mbsr_file_destroy(file);
    mbsr_file_destroy(again);
}

static void springs_of_free_joints_come_back(void **state)
{
    (void)state;
    double udot[2][6];
    const double u[6] = {0.1, 0.2, 0.3, 0.4, 0.5, 0.6};
    mbsr_written *written;
    mbsr_file *file[2] = {
        read_small(MUJOCO("<worldbody><body pos='1 2 3' quat='1 2 3 4'><joint type='free' "
                          "damping='2' stiffness='3'/>"
                          "<geom type='box' size='.1 .2 .3' density='9'/></body></worldbody>"),
                   NULL)};
    for (int k = 0; k < 2; ++k) {
        mbsr_data *d = finish(file[k]);
        double q[7];
        memcpy(q, file[k]->q0, sizeof q);
        q[4] += 0.1;
        assert_int_equal(file[k]->findings, 0);
        assert_ok(mbsr_forward_dynamics(file[k]->model, d, 0.0, q, u, NULL, udot[k]),
                  mbsr_data_error(d));
        if (k == 0) {
            assert_ok(mbsr_file_write_mjcf(file[0]->model, file[0], NULL, &written, NULL), NULL);
            assert_int_equal(written->findings, 0);
            file[1] = read_small(written->text, NULL);
            mbsr_written_destroy(written);
        }
        mbsr_data_destroy(d);
    }
    const double mass = 8.0 * 0.006 * 9.0;
    assert_close(udot[0][3], -(3.0 * 0.1 + 2.0 * 0.4) / mass, 1e-13 / mass);
    for (int k = 0; k < 6; ++k) assert_close(udot[0][k], udot[1][k], 1e-12 * fabs(udot[0][k]));
    for (int k = 0; k < 2; ++k) mbsr_file_destroy(file[k]);
}

static void what_is_left_out_is_said(void **state)
{
    (void)state;
    mbsr_file *file = read_small(
        MUJOCO(
            "<option><flag clampctrl='disable'/></option><worldbody><site name='g'/><body name='a'>"
            "<joint name='i' actuatorfrcrange='-1 1'/><geom size='1'/><site "
            "name='s'/></body><body><joint name='h' actuatorfrcrange='-1 1'/><geom size='1'/>"
            "<site name='u'/></body></worldbody><actuator><motor joint='h'/><motor "
            "site='u'/><motor name='m' joint='i' ctrlrange='-1 1'/><motor name='n' joint='i'/>"
            "<position name='slow' joint='i' timeconst='1'/><general name='state' joint='i' "
            "dyntype='integrator'/>"
            "<general name='gain' joint='i' gaintype='affine'/><motor name='pair' site='s' "
            "refsite='g'/>"
            "<motor name='ground' site='g'/><muscle name='muscle' joint='i'/></actuator>"),
        NULL);
    assert_found(file, "joint 'i'", "not limited in sum");
    assert_found(file, "joint 'h'", "not limited in sum");
    assert_found(file, "position 'slow'", "timeconst");
    assert_found(file, "general 'state'", "state of its own");
    assert_found(file, "general 'gain'", "gain is not fixed");
    assert_found(file, "motor 'pair'", "nor a site");
    assert_found(file, "motor 'ground'", "on the ground");
    assert_found(file, "muscle 'muscle'", "no actuator of its kind");
    assert_int_equal(file->findings, 8);
    assert_int_equal(file->actuator[2].limited, 0);
    assert_int_equal(file->actuator[2].force_limited, 0);
    mbsr_file_destroy(file);
    assert_file_refused(
        MUJOCO("<worldbody><body><joint name='i'/></body></worldbody>"
               "<actuator><position name='p' joint='i' kv='1' dampratio='1'/></actuator>"),
        NULL, "position 'p'|both kv and dampratio");
    assert_file_refused(
        MUJOCO("<worldbody><body><joint name='i'/></body></worldbody>"
               "<actuator><position name='p' joint='i' inheritrange='1'/></actuator>"),
        NULL, "position 'p'|no range");
    assert_file_refused(MUJOCO("<worldbody><body><joint name='i'/></body></worldbody>"
                               "<actuator><motor name='p' joint='i' forcerange='2 1'/></actuator>"),
                        NULL, "motor 'p'|forcerange is no range");
}

/* However the body lies and turns. */
static void weight_that_is_carried_has_no_energy(void **state)
{
    static const double q[2][7] = {{1, 0, 0, 0, 0, 0, 0}, {0.1, 0.7, -0.1, 0.7, 1, -2, 3}},
                        u[6] = {0.0};
    (void)state;
    mbsr_file *file = read_small(
        MUJOCO("<option gravity='1 0 -9'/><worldbody><body name='b' gravcomp='1'><freejoint/>"
               "<geom type='box' size='.1 .2 .3' pos='.1 0 .2'/></body></worldbody>"),
        NULL);
    mbsr_data *d = finish(file);
    double potential[2];
    for (int k = 0; k < 2; ++k) {
        assert_ok(mbsr_stage_positions(file->model, d, 0.0, q[k]), mbsr_data_error(d));
        assert_ok(mbsr_stage_velocities(file->model, d, u), mbsr_data_error(d));
        assert_ok(mbsr_energy(file->model, d, NULL, potential + k), mbsr_data_error(d));
    }
    assert_close(potential[1], potential[0], 1e-9);
    mbsr_data_destroy(d);
    mbsr_file_destroy(file);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(actuators_as_in_mujoco),
        cmocka_unit_test(they_come_back),
        cmocka_unit_test(weight_that_is_carried_has_no_energy),
        cmocka_unit_test(springs_of_free_joints_come_back),
        cmocka_unit_test(what_is_left_out_is_said),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
