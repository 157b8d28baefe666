/* Linear equations, modes and trim: what is missing or out of range is refused by its status.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "build.h"

#include <mbsrank/linear.h>

enum { NODES = 3 };

static void results_without_a_place(void **state)
{
    (void)state;
    static const double q[NODES] = {0.0};
    mbsr_model *m = empty();
    add_string(m, NODES, 0.7, 120.0);
    mbsr_data *d = finish(m);
    mbsr_error error;
    mbsr_linear *l;
    mbsr_linear_info info;
    mbsr_mode mode[2 * NODES];
    double re[4 * NODES], im[4 * NODES];
    int rows = 7, columns = 7, count = 0;
    assert_ok(mbsr_linear_create(m, d, 0.0, q, NULL, NULL, &l, &error), &error);
    assert_int_equal(mbsr_linear_get_info(NULL, &info), MBSR_ERR_NULL);
    assert_int_equal(mbsr_linear_get_info(l, NULL), MBSR_ERR_NULL);
    assert_null(mbsr_linear_matrix(NULL, MBSR_LINEAR_E, &rows, &columns));
    assert_null(mbsr_linear_matrix(l, (mbsr_linear_part)-1, &rows, &columns));
    assert_null(mbsr_linear_matrix(l, MBSR_LINEAR_PARTS, &rows, &columns));
    assert_int_equal(mbsr_linear_modes(NULL, mode, &count), MBSR_ERR_NULL);
    assert_int_equal(mbsr_linear_modes(l, mode, NULL), MBSR_ERR_NULL);
    assert_ok(mbsr_linear_modes(l, NULL, &count), &error);
    assert_int_equal(count, 1); /* one particle between nodes without mass */
    assert_int_equal(mbsr_linear_shape(NULL, 0, re, im), MBSR_ERR_NULL);
    assert_int_equal(mbsr_linear_shape(l, 0, NULL, im), MBSR_ERR_NULL);
    assert_int_equal(mbsr_linear_shape(l, -1, re, im), MBSR_ERR_VALUE);
    assert_int_equal(mbsr_linear_shape(l, count, re, im), MBSR_ERR_VALUE);
    assert_ok(mbsr_linear_shape(l, 0, im, NULL), &error);
    assert_ok(mbsr_linear_shape(l, 0, re, im), &error);
    assert_int_equal(mbsr_linear_response(NULL, 1.0, re, im), MBSR_ERR_NULL);
    assert_int_equal(mbsr_linear_response(l, 1.0, NULL, im), MBSR_ERR_NULL);
    assert_int_equal(mbsr_linear_response(l, 1.0, re, NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_linear_response(l, INFINITY, re, im), MBSR_NOT_FINITE);
    mbsr_linear_destroy(l);
    free_both(m, d);
}

static void rates_that_are_not_there(void **state)
{
    (void)state;
    static const double q[NODES] = {0.0};
    static const int beyond[1] = {NODES}, before[1] = {-1};
    mbsr_model *m = empty();
    add_string(m, NODES, 0.7, 120.0);
    mbsr_data *d = finish(m);
    mbsr_error error;
    mbsr_parameters *list;
    double rest[NODES], value;
    mbsr_trim_opt opt = mbsr_default_trim_opt();
    const int *const holds[3] = {NULL, beyond, before};
    assert_ok(mbsr_parameters_create(m, &list, &error), &error);
    for (int k = 0; k < 3; ++k) {
        opt.held = 1, opt.hold = holds[k];
        assert_int_equal(mbsr_trim(list, 0.0, q, 0, NULL, &opt, rest, &value, NULL, &error),
                         MBSR_ERR_VALUE);
        assert_contains(error.text, "hold");
    }
    mbsr_equilibrium_opt at_rest = mbsr_default_equilibrium_opt();
    at_rest.max_iterations = 0;
    assert_int_equal(mbsr_equilibrium(m, d, 0.0, q, &at_rest, rest, NULL, NULL, &error),
                     MBSR_ERR_VALUE);
    at_rest = mbsr_default_equilibrium_opt();
    at_rest.tolerance = NAN;
    assert_int_equal(mbsr_equilibrium(m, d, 0.0, q, &at_rest, rest, NULL, NULL, &error),
                     MBSR_ERR_VALUE);
    mbsr_parameters_destroy(list);
    free_both(m, d);
}

/* Names of signals that end too early, or go on. */
static void signals_of_no_name(void **state)
{
    (void)state;
    static const char *const names[] = {"",
                                        "bodies",
                                        "bodies.",
                                        "bodies.body9.q",
                                        "bodies.body0",
                                        "bodies.body0.",
                                        "bodies.body0.w",
                                        "bodies.body0.xy",
                                        "bodies.body0.q[2]",
                                        "bodies.body0.q[0]",
                                        "bodies.body0.q[",
                                        "bodies.body0.q[1",
                                        "bodies.body0.q[1]x",
                                        "bodies.'body0.q",
                                        "bodies.'bo\\",
                                        "bodies.body0.motion",
                                        "closures.a.motion",
                                        "closures.closure0.motion",
                                        "forces.force0",
                                        "forces.force9.f",
                                        "forces.force0.f[9]",
                                        "forces.force0.tau[2]"};
    mbsr_model *m = empty();
    add_string(m, NODES, 0.7, 120.0);
    mbsr_data *d = finish(m);
    mbsr_signal signal = {.id = 7};
    for (size_t k = 0; k < sizeof names / sizeof *names; ++k) {
        mbsr_error error = {.text = ""};
        const int status = mbsr_signal_find(m, NULL, names[k], &signal, &error);
        if (status != MBSR_ERR_VALUE || !error.text[0] || signal.id != 7)
            fail_msg("'%s': %s: %s", names[k], mbsr_status_name(status), error.text);
    }
    assert_ok(mbsr_signal_find(m, NULL, "bodies.'body0'.q[1]", &signal, NULL), NULL);
    assert_int_equal(signal.kind, MBSR_SIGNAL_JOINT);
    assert_int_equal(signal.id, 0);
    free_both(m, d);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(results_without_a_place),
        cmocka_unit_test(rates_that_are_not_there),
        cmocka_unit_test(signals_of_no_name),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
