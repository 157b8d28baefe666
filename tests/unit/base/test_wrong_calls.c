/* Pointers that are missing, ids that do not exist, calls that come too early: each is refused by
 * its status, and nothing else happens.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"

#include <mbsrank/driver.h>
#include <mbsrank/mbsrank.h>

#include <string.h>

static mbsr_model *chain(int finished)
{
    static const double along[3] = {1, 0, 0};
    mbsr_model *m;
    mbsr_body_def b = mbsr_default_body_def();
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    b.name = "it's \\ \"\t\x7f";
    b.joint = mbsr_joint_prismatic(NULL, NULL, along);
    b.inertia = mbsr_inertia_particle(2.0);
    assert_ok(mbsr_model_add_body(m, &b, NULL), mbsr_model_error(m));
    b.name = "_Az9", b.parent = 0;
    assert_ok(mbsr_model_add_body(m, &b, NULL), mbsr_model_error(m));
    const mbsr_force_def spring = mbsr_force_joint_spring(1, 0, 3.0, 0.2, 0.0);
    const mbsr_closure_def gear = mbsr_closure_coupling(2, (const int[]){0, 1}, (const int[]){0, 0},
                                                        (const double[]){1.0, -0.5}, 0.0);
    assert_ok(mbsr_model_add_force(m, &spring, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_add_closure(m, &gear, NULL), mbsr_model_error(m));
    if (finished) assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    return m;
}

static void models_that_are_not_finished_have_no_rows(void **state)
{
    (void)state;
    mbsr_model *m = chain(0), *none = NULL;
    double w[4], T[4];
    int row;
    mbsr_parameters *list;
    mbsr_small_masses *small;
    mbsr_error error;
    mbsr_small_masses_opt opt = mbsr_default_small_masses_opt();
    assert_int_equal(mbsr_closure_indices(m, 0, &row, NULL, NULL, NULL), MBSR_ERR_UNFINISHED);
    assert_int_equal(mbsr_closure_mixture(m, 0, T), MBSR_ERR_UNFINISHED);
    assert_int_equal(mbsr_closures_weight(m, w), MBSR_ERR_UNFINISHED);
    assert_int_equal(mbsr_closure_of_row(m, 0, &row, NULL, NULL), MBSR_ERR_UNFINISHED);
    assert_int_equal(mbsr_parameters_create(m, &list, &error), MBSR_ERR_UNFINISHED);
    assert_null(list);
    assert_int_equal(mbsr_small_masses_create(m, &opt, &small, NULL), MBSR_ERR_UNFINISHED);
    assert_null(small);
    assert_int_equal(mbsr_model_add_marker(m, 2, 0, NULL, NULL), MBSR_ERR_ID);
    assert_int_equal(mbsr_model_add_marker(m, -1, 0, NULL, NULL), MBSR_ERR_ID);
    assert_int_equal(mbsr_model_add_marker(m, 0, 0, NULL, NULL), MBSR_ERR_SPACE);
    assert_contains(mbsr_model_error(m)->text, "not flexible");
    assert_int_equal(mbsr_model_add_marker(none, 0, 0, NULL, NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_model_armature(m, 0, 1, NULL), MBSR_ERR_NULL);
    mbsr_model_destroy(m);

    assert_int_equal(mbsr_closure_indices(none, 0, &row, NULL, NULL, NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_closure_mixture(none, 0, T), MBSR_ERR_NULL);
    assert_int_equal(mbsr_closures_weight(none, w), MBSR_ERR_NULL);
    assert_int_equal(mbsr_closure_of_row(none, 0, &row, NULL, NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_parameters_create(none, &list, &error), MBSR_ERR_NULL);
    assert_contains(error.text, "model is NULL");
    assert_int_equal(mbsr_small_masses_create(none, &opt, &small, NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_model_rows(none), -1);
    assert_int_equal(mbsr_model_position_rows(none), -1);
    assert_true(mbsr_closure_stiffness(none, 0, 0) == -1.0);
}

static void places_that_do_not_exist(void **state)
{
    (void)state;
    mbsr_model *m = chain(1);
    double T[4];
    int row = 7, rows = 7, held = 7, position = 7;
    assert_int_equal(mbsr_closure_indices(m, 1, &row, &rows, &held, &position), MBSR_ERR_ID);
    assert_int_equal(row, 7);
    assert_ok(mbsr_closure_indices(m, 0, NULL, NULL, NULL, NULL), NULL);
    assert_ok(mbsr_closure_indices(m, 0, &row, &rows, &held, &position), NULL);
    assert_true(row == 0 && rows == 1 && held == 0 && position == 1);
    assert_int_equal(mbsr_closure_mixture(m, -1, T), MBSR_ERR_ID);
    assert_int_equal(mbsr_closure_mixture(m, 0, NULL), MBSR_ERR_NULL);
    assert_ok(mbsr_closure_mixture(m, 0, T), NULL);
    assert_true(T[0] == 1.0);
    assert_int_equal(mbsr_closure_of_row(m, -1, &row, NULL, NULL), MBSR_ERR_ID);
    assert_int_equal(mbsr_closure_of_row(m, 1, &row, NULL, NULL), MBSR_ERR_ID);
    assert_int_equal(mbsr_closures_weight(m, NULL), MBSR_ERR_NULL);
    assert_true(mbsr_closure_stiffness(m, 0, 1) == -1.0 &&
                mbsr_closure_stiffness(m, 0, -1) == -1.0);
    assert_true(mbsr_closure_stiffness(m, 1, 0) == -1.0 && mbsr_closure_stiffness(m, 0, 0) == 0.0);
    assert_int_equal(mbsr_model_add_marker(m, 0, 0, NULL, NULL), MBSR_ERR_FINISHED);
    mbsr_model_destroy(m);
}

static void parameters_that_are_not_given(void **state)
{
    (void)state;
    mbsr_model *m = chain(1), *made = m;
    mbsr_parameters *list;
    mbsr_parameter p;
    mbsr_data *data;
    mbsr_error error;
    const int which = 0, beyond = 1000, before = -1;
    const double value = 1.0, wrong = NAN;
    assert_int_equal(mbsr_parameters_create(m, NULL, &error), MBSR_ERR_NULL);
    assert_contains(error.text, "list is NULL");
    assert_ok(mbsr_parameters_create(m, &list, &error), &error);
    assert_ok(mbsr_parameter_get(list, 0, &p), NULL);
    assert_contains(p.name, "bodies.'it\\'s \\\\ ?\?\?'.mass");
    assert_in_range(mbsr_parameters_find(list, "bodies._Az9.mass"), 0, 1000);
    assert_int_equal(mbsr_parameters_model(list, 1, &which, &value, NULL, &error), MBSR_ERR_NULL);
    assert_int_equal(mbsr_parameters_model(list, 1, NULL, &value, &made, &error), MBSR_ERR_NULL);
    assert_contains(error.text, "which is NULL");
    assert_null(made);
    assert_int_equal(mbsr_parameters_model(list, 1, &which, NULL, &made, &error), MBSR_ERR_NULL);
    assert_contains(error.text, "value is NULL");
    assert_int_equal(mbsr_parameters_model(NULL, 0, NULL, NULL, &made, &error), MBSR_ERR_NULL);
    assert_contains(error.text, "list is NULL");
    assert_int_equal(mbsr_parameters_model(list, -1, NULL, NULL, &made, &error), MBSR_ERR_VALUE);
    assert_int_equal(mbsr_parameters_model(list, 1, &beyond, &value, &made, &error), MBSR_ERR_ID);
    assert_int_equal(mbsr_parameters_model(list, 1, &before, &value, &made, &error), MBSR_ERR_ID);
    assert_int_equal(mbsr_parameters_data(list, 1, &which, &wrong, &data, &error), MBSR_NOT_FINITE);
    assert_contains(error.text, "is nan");

    mbsr_derivatives *by;
    assert_ok(mbsr_derivatives_create(m, &by, &error), &error);
    assert_int_equal(mbsr_derivatives_parameters(NULL, list, 1, &which), MBSR_ERR_NULL);
    assert_int_equal(mbsr_derivatives_parameters(by, list, -1, &which), MBSR_ERR_VALUE);
    assert_int_equal(mbsr_derivatives_parameters(by, NULL, 1, &which), MBSR_ERR_NULL);
    assert_int_equal(mbsr_derivatives_parameters(by, list, 1, NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_derivatives_parameters(by, list, 1, &beyond), MBSR_ERR_ID);
    assert_int_equal(mbsr_derivatives_parameters(by, list, 1, &before), MBSR_ERR_ID);
    assert_null(mbsr_derivatives_data(NULL));
    assert_non_null(mbsr_derivatives_data(by));
    mbsr_derivatives_destroy(by);
    mbsr_parameters_destroy(list);
    mbsr_model_destroy(m);
}

static void results_that_are_not_wanted(void **state)
{
    (void)state;
    mbsr_model *m = chain(1);
    mbsr_data *d;
    mbsr_stepper *stepper;
    mbsr_stepper_opt steps = mbsr_default_stepper_opt();
    mbsr_small_masses *small = NULL;
    mbsr_small_masses_opt opt = mbsr_default_small_masses_opt();
    mbsr_error error;
    const double q[2] = {0.0}, u[2] = {0.0};
    long numbers = 7;
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    assert_int_equal(mbsr_ode_create(m, d, 0.0, q, u, NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_ode_stats(NULL, &numbers, NULL), MBSR_ERR_NULL);
    assert_int_equal(numbers, 7);
    assert_int_equal(mbsr_ode_size(NULL), -1);
    steps.h = 1e-3;
    assert_ok(mbsr_stepper_create(m, d, &steps, &stepper, &error), &error);
    assert_int_equal(mbsr_stepper_jump(stepper), MBSR_ERR_SEQUENCE);
    assert_int_equal(mbsr_stepper_jump(NULL), MBSR_ERR_NULL);
    mbsr_stepper_destroy(stepper);
    opt.duration = 1.0;
    assert_int_equal(mbsr_small_masses_create(m, NULL, &small, &error), MBSR_ERR_NULL);
    assert_int_equal(mbsr_small_masses_create(m, &opt, NULL, &error), MBSR_ERR_NULL);
    opt.outputs = -1;
    assert_int_equal(mbsr_small_masses_create(m, &opt, &small, &error), MBSR_ERR_VALUE);
    assert_contains(error.text, "outputs");
    opt.outputs = 1; /* without a function */
    assert_int_equal(mbsr_small_masses_create(m, &opt, &small, NULL), MBSR_ERR_VALUE);
    assert_int_equal(mbsr_small_masses_get_report(NULL, NULL), MBSR_ERR_NULL);
    assert_null(small);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

static void *give(void *user, size_t size)
{
    (void)user, (void)size;
    return NULL;
}

/* Half an allocator is none. */
static void halves_of_allocators(void **state)
{
    (void)state;
    static const double x[2] = {0.0, 1.0}, value[2] = {0.0, 1.0};
    mbsr_table_def def = mbsr_default_table_def();
    mbsr_table *table;
    mbsr_error error;
    def.points = 2, def.x = x, def.value = value;
    def.allocator.allocate = give;
    assert_int_equal(mbsr_table_create(&def, &table, &error), MBSR_ERR_NULL);
    assert_contains(error.text, "one of its two functions");
    mbsr_model_def model = mbsr_default_model_def();
    mbsr_model *m = NULL;
    model.allocator.allocate = give;
    assert_true(mbsr_model_create(&model, &m, &error) < 0);
    assert_null(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(models_that_are_not_finished_have_no_rows),
        cmocka_unit_test(places_that_do_not_exist),
        cmocka_unit_test(parameters_that_are_not_given),
        cmocka_unit_test(results_that_are_not_wanted),
        cmocka_unit_test(halves_of_allocators),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
