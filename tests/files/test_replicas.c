/* Replicas of MJCF, and closures between sites and tendons. Poses are those of MuJoCo 3.14.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "small.h"

#include <math.h>
#include <stdio.h>

#define MUJOCO(inside) "<mujoco>\n" inside "</mujoco>\n"

static void assert_site(const mbsr_file *file, const char *name, const double x[3])
{
    const int at = mbsr_file_find_site(file, name);
    if (at < 0) print_error("there is no site %s\n", name);
    assert_true(at >= 0);
    for (int k = 0; k < 3; ++k) assert_close(file->site[at].frame.x[k], x[k], 1e-14);
}

/* The example of MuJoCo's documentation, with sites. */
static void replicas_in_replicas(void **state)
{
    (void)state;
    mbsr_file *file = read_small(
        MUJOCO("<worldbody><replicate count='2' offset='0 1 0' euler='90 0 0'>"
               "<replicate count='2' sep='-' offset='1 0 0' euler='0 90 0'><site name='Alice' "
               "pos='.1 .2 .3'/>"
               "</replicate></replicate><replicate count='10' offset='1 0 0' euler='0 0 90'>"
               "<body name='b'><joint name='j'/><geom size='.1'/></body></replicate></worldbody>"
               "<tendon><fixed name='t'><joint joint='j' coef='2'/></fixed><fixed "
               "name='alone'/></tendon>"
               "<actuator><motor name='m' tendon='t'/></actuator>"),
        NULL);
    assert_int_equal(file->findings, 0);
    assert_int_equal(file->sites, 4);
    assert_site(file, "Alice-00", (const double[3]){0.1, 0.2, 0.3});
    assert_site(file, "Alice-10", (const double[3]){1.3, 0.2, -0.1});
    assert_site(file, "Alice-01", (const double[3]){0.1, 0.7, 0.2});
    assert_site(file, "Alice-11", (const double[3]){1.3, 1.1, 0.2});
    assert_int_equal(file->bodies, 10);
    assert_string_equal(file->body_name[9], "b09");
    assert_string_equal(file->joint[3].name, "j03");
    assert_int_equal(file->actuators, 10);
    assert_string_equal(file->actuator[4].name, "m04");
    /* a square: 1 along x, then y, then -x, then -y, and again */
    mbsr_data *d;
    double pose[MBSR_POSE_SIZE];
    assert_ok(mbsr_model_finish(file->model), mbsr_model_error(file->model));
    assert_ok(mbsr_data_create(file->model, &d, NULL), NULL);
    assert_ok(mbsr_stage_positions(file->model, d, 0.0, file->q0), mbsr_data_error(d));
    assert_ok(mbsr_body_pose(file->model, d, 7, pose), mbsr_data_error(d));
    assert_close(pose[MBSR_POSE_X], 0.0, 1e-14);
    assert_close(pose[MBSR_POSE_X + 1], 1.0, 1e-14);
    mbsr_data_destroy(d);
    mbsr_file_destroy(file);
}

static void refused_replicas(void **state)
{
    (void)state;
    assert_file_refused(MUJOCO("<worldbody><replicate><site/></replicate></worldbody>"), NULL,
                        "replicate|count");
    assert_file_refused(MUJOCO("<worldbody><replicate count='0'/></worldbody>"), NULL, "count");
    assert_file_refused(MUJOCO("<worldbody><replicate count='2' offset='1'/></worldbody>"), NULL,
                        "offset");
    assert_file_refused(
        MUJOCO("<worldbody><replicate count='9999'><replicate count='9999'><site/></replicate>"
               "</replicate></worldbody>"),
        NULL, "too many copies");
    assert_file_refused(
        MUJOCO("<worldbody><replicate count='2'><body name='a'/></replicate><body name='a0'/>"
               "</worldbody>"),
        NULL, "body 'a0'|two of that name");
}

/* Gaps at a state: how far sites are apart, and what relations of tendons miss. */
static void equalities_of_sites_and_tendons(void **state)
{
    static const double q[3] = {0.4, 0.7, -0.2};
    (void)state;
    mbsr_file *file[2] = {
        read_small(MUJOCO("<compiler angle='radian'/><worldbody><site name='w' pos='.3 .2 .1' "
                          "euler='.1 .2 .3'/><body name='a'>"
                          "<joint name='i' axis='0 1 0' ref='.2'/><geom size='.1' pos='.5 0 "
                          ".2'/><site name='s' pos='.1 .2 .3' "
                          "euler='.3 .1 .2'/><body name='b' pos='0 0 1'><joint name='j' axis='1 0 "
                          "0'/><joint name='k' type='slide' "
                          "axis='0 0 1' ref='.1'/><geom size='.1'/><site name='t' pos='.2 0 .1' "
                          "euler='0 .1 .2'/></body></body>"
                          "</worldbody><tendon><fixed name='u'><joint joint='i' coef='2'/><joint "
                          "joint='j' coef='-1'/></fixed>"
                          "<fixed name='v'><joint joint='k' coef='3'/><joint joint='j' "
                          "coef='1'/></fixed></tendon><equality>"
                          "<connect site1='t' site2='w'/><weld site1='s' site2='w'/>"
                          "<tendon tendon1='u' tendon2='v' polycoef='.3 .5 0 0 0'/><tendon "
                          "tendon1='v' polycoef='.2'/></equality>"),
                   NULL)};
    mbsr_written *written;
    for (int k = 0; k < 2; ++k) {
        double gap[11], square[2] = {0.0, 0.0};
        mbsr_data *d;
        assert_int_equal(file[k]->findings, 0);
        assert_ok(mbsr_model_finish(file[k]->model), mbsr_model_error(file[k]->model));
        assert_ok(mbsr_data_create(file[k]->model, &d, NULL), NULL);
        assert_ok(mbsr_stage_positions(file[k]->model, d, 0.0, q), mbsr_data_error(d));
        assert_int_equal(mbsr_model_position_rows(file[k]->model), 11);
        assert_ok(mbsr_closures_gap(file[k]->model, d, gap), mbsr_data_error(d));
        const double *sums = gap + 9;
        assert_close(fabs(sums[0]), 0.5, 1e-14);
        assert_close(fabs(sums[1]), k == 0 ? 0.4 : 0.4 / 3.0, 1e-14); /* of one joint then */
        for (int l = 0; l < 3; ++l) square[0] += gap[l] * gap[l];
        assert_close(square[0],
                     0.0642925092609816 * 0.0642925092609816 +
                         0.0711564625524618 * 0.0711564625524618 +
                         0.690413458666126 * 0.690413458666126,
                     1e-14);
        if (k == 0) {
            assert_ok(mbsr_file_write_mjcf(file[0]->model, file[0], NULL, &written, NULL), NULL);
            assert_int_equal(written->findings, 0);
            file[1] = read_small(written->text, NULL);
            mbsr_written_destroy(written);
        }
        mbsr_data_destroy(d);
    }
    for (int k = 0; k < 2; ++k) mbsr_file_destroy(file[k]);
    file[0] = read_small(MUJOCO("<worldbody><body><joint name='i'/><geom "
                                "size='1'/></body></worldbody><tendon><fixed name='u'>"
                                "<joint joint='i' coef='2'/></fixed></tendon><equality><tendon "
                                "name='e' tendon1='u' polycoef='0 0 1'/>"
                                "</equality>"),
                         NULL);
    assert_found(file[0], "tendon 'e'", "linear relation");
    mbsr_file_destroy(file[0]);
    assert_file_refused(MUJOCO("<equality><tendon tendon1='x'/></equality>"), NULL,
                        "'x' is no tendon");
    assert_file_refused(MUJOCO("<equality><weld site1='x' site2='y'/></equality>"), NULL,
                        "'x' is no site");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(replicas_in_replicas),
        cmocka_unit_test(refused_replicas),
        cmocka_unit_test(equalities_of_sites_and_tendons),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
