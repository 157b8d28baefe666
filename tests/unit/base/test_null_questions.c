/* Each pointer of calls that ask an object for something is missing in turn: the status says so, or
 * the answer is that there is none.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "acts.h"
#include "expect.h"

#include <mbsrank/driver.h>

#define IS_NULL(call) assert_int_equal((call), MBSR_ERR_NULL)

static test_acts_scene scene;

static void definitions(void **state)
{
    (void)state;
    mbsr_model_def model;
    mbsr_body_def body;
    mbsr_force_def force;
    mbsr_closure_def closure;
    mbsr_flex_def flex;
    mbsr_table_def table;
    const mbsr_model *m = scene.model;
    IS_NULL(mbsr_model_definition(NULL, &model));
    IS_NULL(mbsr_model_definition(m, NULL));
    IS_NULL(mbsr_body_definition(NULL, 0, &body));
    IS_NULL(mbsr_body_definition(m, 0, NULL));
    IS_NULL(mbsr_force_definition(NULL, 0, &force));
    IS_NULL(mbsr_force_definition(m, 0, NULL));
    IS_NULL(mbsr_closure_definition(NULL, 0, &closure));
    IS_NULL(mbsr_closure_definition(m, 0, NULL));
    IS_NULL(mbsr_flex_definition(NULL, &flex));
    IS_NULL(mbsr_table_definition(NULL, &table));
    static const double x[2] = {0.0, 1.0};
    mbsr_table *made;
    mbsr_table_def def = mbsr_default_table_def();
    def.points = 2, def.x = def.value = x;
    assert_ok(mbsr_table_create(&def, &made, NULL), NULL);
    IS_NULL(mbsr_table_definition(made, NULL));
    mbsr_table_destroy(made);
}

/* Of no model, and of one that is not finished. */
static void questions(void **state)
{
    (void)state;
    mbsr_model *unfinished;
    assert_ok(mbsr_model_copy(scene.model, &unfinished, NULL), NULL);
    const mbsr_model *const models[] = {NULL, unfinished};
    for (int k = 0; k < 2; ++k) {
        assert_null(mbsr_body_armature(models[k], 0));
        assert_null(mbsr_body_regularisation(models[k], 0));
        assert_int_equal(mbsr_body_locks(models[k], 0), -1);
        assert_null(mbsr_body_locked(models[k], 0));
        assert_int_equal(mbsr_body_neglected(models[k], 0), -1);
        assert_int_equal(mbsr_force_closure(models[k], 0), MBSR_NONE);
    }
    IS_NULL(mbsr_model_armature(unfinished, 0, 1, NULL));
    mbsr_model_destroy(unfinished);
    for (int body = -1; body < 100; body += 100) {
        assert_null(mbsr_body_armature(scene.model, body));
        assert_int_equal(mbsr_body_locks(scene.model, body), -1);
        assert_int_equal(mbsr_body_neglected(scene.model, body), -1);
    }
}

static void objects(void **state)
{
    (void)state;
    mbsr_parameters *list;
    mbsr_parameter parameter;
    mbsr_completion *completion;
    mbsr_completion_info info;
    mbsr_completion_times times = {.from = 0.0, .to = 1.0, .scale = 1.0};
    mbsr_stepper *stepper;
    mbsr_stepper_info stepped;
    const mbsr_stepper_opt opt = mbsr_default_stepper_opt();
    assert_ok(mbsr_parameters_create(scene.model, &list, NULL), NULL);
    IS_NULL(mbsr_parameter_get(NULL, 0, &parameter));
    IS_NULL(mbsr_parameter_get(list, 0, NULL));
    mbsr_parameters_destroy(list);
    assert_ok(mbsr_completion_create(scene.model, NULL, &completion, NULL), NULL);
    IS_NULL(mbsr_completion_set_times(NULL, &times));
    IS_NULL(mbsr_completion_set_times(completion, NULL));
    const mbsr_completion_times wrong[] = {{.scale = -1.0, .to = 1.0},
                                           {.scale = NAN, .to = 1.0},
                                           {.scale = INFINITY, .to = 1.0},
                                           {.scale = 1.0}};
    for (size_t k = 0; k < sizeof wrong / sizeof *wrong; ++k)
        assert_int_equal(mbsr_completion_set_times(completion, wrong + k), MBSR_ERR_VALUE);
    IS_NULL(mbsr_completion_get_info(NULL, &info));
    IS_NULL(mbsr_completion_get_info(completion, NULL));
    IS_NULL(mbsr_completion_motion(NULL, scene.data, scene.out, scene.out, NULL, NULL));
    IS_NULL(mbsr_completion_motion(completion, NULL, scene.out, scene.out, NULL, NULL));
    mbsr_completion_destroy(completion);
    assert_ok(mbsr_stepper_create(scene.model, scene.data, &opt, &stepper, NULL), NULL);
    IS_NULL(mbsr_stepper_get_info(NULL, &stepped));
    IS_NULL(mbsr_stepper_get_info(stepper, NULL));
    mbsr_stepper_destroy(stepper);
    assert_int_equal(mbsr_small_masses_error(NULL)->status, MBSR_ERR_NULL);
}

static void numbers_of_an_equation(void **state)
{
    (void)state;
    mbsr_ode *ode;
    long steps = -1, evaluations = -1;
    assert_ok(mbsr_ode_create(scene.model, scene.data, scene.t, scene.q, scene.u, &ode),
              mbsr_data_error(scene.data));
    IS_NULL(mbsr_ode_stats(NULL, &steps, &evaluations));
    assert_ok(mbsr_ode_stats(ode, NULL, &evaluations), NULL);
    assert_ok(mbsr_ode_stats(ode, &steps, NULL), NULL);
    assert_true(steps >= 0 && evaluations >= 0);
    mbsr_ode_destroy(ode);
}

static int make(void **state)
{
    (void)state;
    test_acts_make(&scene, false, TEST_MASSLESS);
    return 0;
}

static int end(void **state)
{
    (void)state;
    mbsr_data_destroy(scene.data);
    mbsr_model_destroy(scene.model);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(definitions), cmocka_unit_test(questions),
                                       cmocka_unit_test(objects),
                                       cmocka_unit_test(numbers_of_an_equation)};
    return cmocka_run_group_tests(tests, make, end);
}
