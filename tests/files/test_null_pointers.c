/* Each pointer of calls that ask a file that was read for something is missing in turn, and names
 * that nothing has.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "small.h"

static const char text[] =
    "<mujoco><worldbody><body name='a'><joint name='h'/><geom size='1'/><site name='s'/>"
    "</body><body><joint/><geom size='1'/></body></worldbody>"
    "<actuator><motor name='m' joint='h'/><motor joint='h'/></actuator>"
    "<sensor><jointpos name='p' joint='h'/><jointvel joint='h'/></sensor>"
    "<keyframe><key name='k' qpos='0 0'/><key qpos='0 0'/></keyframe></mujoco>";

static void names(void **state)
{
    static int (*const find[])(const mbsr_file *file, const char *name) = {
        mbsr_file_find_joint, mbsr_file_find_site, mbsr_file_find_actuator, mbsr_file_find_sensor,
        mbsr_file_find_key};
    static const char *const first[] = {"h", "s", "m", "p", "k"};
    (void)state;
    mbsr_file *file = read_small(text, NULL);
    for (int k = 0; k < 5; ++k) {
        assert_int_equal(find[k](file, first[k]), 0);
        assert_int_equal(find[k](file, "nobody"), -1);
        assert_int_equal(find[k](file, ""), -1); /* without a name */
        assert_int_equal(find[k](file, NULL), -1);
        assert_int_equal(find[k](NULL, first[k]), -1);
    }
    assert_null(mbsr_file_take_model(NULL));
    mbsr_file_destroy(NULL);
    mbsr_file_destroy(file);
}

static void sensors(void **state)
{
    (void)state;
    const double q[2] = {0.1, 0.2}, u[2] = {0.0};
    double value[4];
    mbsr_data *d;
    mbsr_file *file = read_small(text, NULL);
    mbsr_model *m = file->model;
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    assert_int_equal(mbsr_file_sense(file, 0, m, d, 0.0, q, u, value), MBSR_OK);
    assert_true(value[0] == 0.1);
    assert_int_equal(mbsr_file_sense(NULL, 0, m, d, 0.0, q, u, value), MBSR_ERR_NULL);
    assert_int_equal(mbsr_file_sense(file, 0, NULL, d, 0.0, q, u, value), MBSR_ERR_NULL);
    assert_int_equal(mbsr_file_sense(file, 0, m, NULL, 0.0, q, u, value), MBSR_ERR_NULL);
    assert_int_equal(mbsr_file_sense(file, 0, m, d, 0.0, NULL, u, value), MBSR_ERR_NULL);
    assert_int_equal(mbsr_file_sense(file, 0, m, d, 0.0, q, NULL, value), MBSR_ERR_NULL);
    assert_int_equal(mbsr_file_sense(file, 0, m, d, 0.0, q, u, NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_file_sense(file, -1, m, d, 0.0, q, u, value), MBSR_ERR_ID);
    assert_int_equal(mbsr_file_sense(file, 2, m, d, 0.0, q, u, value), MBSR_ERR_ID);
    mbsr_data_destroy(d);
    mbsr_file_destroy(file);
}

static void states_of_mujoco(void **state)
{
    (void)state;
    const double x[2] = {0.1, 0.2};
    double q[2], u[2];
    mbsr_file *file = read_small(text, NULL);
    assert_int_equal(mbsr_file_mujoco_state(NULL, 0, x, x, q, u), MBSR_ERR_NULL);
    assert_int_equal(mbsr_file_mujoco_state(file, 0, NULL, x, q, u), MBSR_ERR_NULL);
    assert_int_equal(mbsr_file_mujoco_state(file, 0, x, x, NULL, u), MBSR_ERR_NULL);
    assert_int_equal(mbsr_file_mujoco_state(file, 0, x, x, q, NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_file_mujoco_state(file, 0, x, NULL, q, NULL), MBSR_OK);
    mbsr_file_destroy(file);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(names), cmocka_unit_test(sensors),
                                       cmocka_unit_test(states_of_mujoco)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
