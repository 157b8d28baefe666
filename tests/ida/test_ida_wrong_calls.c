/* What simulations and the driver refuse before they run, and what they say of SUNDIALS's failures.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "ida/error.h"
#include "ida/record.h"

#include "expect.h"

#include <mbsrank/sensitivity.h>
#include <mbsrank/simulation.h>

#include <ida/ida.h>

#include <string.h>

static mbsr_simulation slider(void)
{
    static const double along[3] = {1.0, 0.0, 0.0};
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    mbsr_simulation_add_body(&s, "slider", MBSR_GROUND, mbsr_joint_prismatic(NULL, NULL, along),
                             mbsr_inertia_particle(2.0));
    mbsr_simulation_add_force(&s, mbsr_force_joint_spring(0, 0, 30.0, 0.5, 0.0));
    return s;
}

static void no_simulation(void **state)
{
    (void)state;
    const double x[3] = {0.0, 1.0, 2.0};
    mbsr_ida_stats stats = {.steps = 7};
    mbsr_small_masses_report report;
    assert_int_equal(mbsr_simulation_add_body(NULL, "a", MBSR_GROUND, mbsr_joint_weld(NULL, NULL),
                                              mbsr_inertia_zero()),
                     MBSR_NONE);
    assert_int_equal(mbsr_simulation_add_force(NULL, mbsr_force_gravity(0, 0, 0)), MBSR_NONE);
    assert_int_equal(mbsr_simulation_add_closure(NULL, mbsr_closure_ball(0, x, 1, x)), MBSR_NONE);
    assert_null(mbsr_simulation_add_table(NULL, MBSR_TABLE_LINEAR, 2, x, x));
    assert_null(mbsr_simulation_add_data(NULL));
    assert_int_equal(mbsr_simulation_start(NULL, NULL, 0.0, x, x), MBSR_ERR_NULL);
    assert_int_equal(mbsr_simulation_get_stats(NULL, &stats), MBSR_ERR_NULL);
    assert_int_equal(stats.steps, 0);
    assert_int_equal(mbsr_sensitivity_error(NULL)->status, MBSR_ERR_NULL);
    assert_int_equal(mbsr_simulation_set_position(NULL, 0, 0, 1.0), MBSR_ERR_NULL);
    assert_int_equal(mbsr_simulation_set_rate(NULL, 0, 0, 1.0), MBSR_ERR_NULL);
    assert_int_equal(mbsr_simulation_set_none(NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_simulation_accelerations(NULL, NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_simulation_reactions(NULL, NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_simulation_check(NULL, 0), MBSR_ERR_NULL);
    assert_int_equal(mbsr_simulation_get_stats(NULL, NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_simulation_get_stats(NULL, &stats), MBSR_ERR_NULL);
    assert_int_equal(stats.steps, 0);
    assert_int_equal(mbsr_simulation_watch_masses(NULL, NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_simulation_get_masses(NULL, &report), MBSR_ERR_NULL);
    mbsr_simulation_forgive(NULL);
}

static void too_early_or_too_late(void **state)
{
    (void)state;
    mbsr_simulation s = slider();
    mbsr_ida_stats stats = {.steps = 7};
    mbsr_small_masses_report report;
    double udot[1];
    assert_ok(mbsr_simulation_get_stats(&s, &stats), NULL);
    assert_int_equal(stats.steps, 0);
    assert_int_equal(mbsr_simulation_watch_masses(&s, NULL), MBSR_ERR_SEQUENCE);
    assert_contains(s.error.text, "mbsr_simulation_watch_masses: call mbsr_simulation_start first");
    mbsr_simulation_forgive(&s);
    assert_int_equal(mbsr_simulation_get_masses(&s, &report), MBSR_ERR_SEQUENCE);
    /* what comes behind the first failure is that one's */
    assert_int_equal(mbsr_simulation_watch_masses(&s, NULL), MBSR_ERR_SEQUENCE);
    assert_int_equal(mbsr_simulation_set_rate(&s, 0, 0, 1.0), MBSR_ERR_SEQUENCE);
    assert_int_equal(mbsr_simulation_check(&s, MBSR_ERR_ID), MBSR_ERR_SEQUENCE);
    assert_contains(s.error.text, "mbsr_simulation_get_masses: call mbsr_simulation_watch_masses");
    assert_int_equal(mbsr_simulation_add_closure(&s, mbsr_closure_ball(0, NULL, 1, NULL)),
                     MBSR_NONE);
    mbsr_simulation_forgive(&s);
    assert_int_equal(mbsr_simulation_accelerations(&s, udot), MBSR_ERR_SEQUENCE);
    mbsr_simulation_forgive(&s);
    assert_int_equal(mbsr_simulation_accelerations(&s, NULL), MBSR_ERR_NULL);
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.form = MBSR_DAE_INDEX1;
    mbsr_simulation_start(&s, &opt, 0.0, NULL, NULL);
    assert_ok(s.status, &s.error);
    assert_int_equal(mbsr_simulation_watch_masses(&s, NULL), MBSR_ERR_VALUE);
    assert_contains(s.error.text, "only the momentum form");
    mbsr_simulation_end(&s);
}

static void sensitivities_of_nothing(void **state)
{
    (void)state;
    mbsr_simulation s = slider();
    mbsr_simulation_start(&s, NULL, 0.0, NULL, NULL);
    assert_ok(s.status, &s.error);
    mbsr_sensitivity_opt opt = mbsr_default_sensitivity_opt();
    mbsr_sensitivity *none = NULL;
    mbsr_error error;
    const int which = 0;
    opt.parameters = 1, opt.which = &which;
    assert_int_equal(mbsr_sensitivity_create(s.model, &opt, &none, &error), MBSR_ERR_NULL);
    assert_contains(error.text, "list is NULL");
    assert_ok(mbsr_parameters_create(s.model, (mbsr_parameters **)&opt.list, &error), &error);
    opt.which = NULL;
    assert_int_equal(mbsr_sensitivity_create(s.model, &opt, &none, &error), MBSR_ERR_NULL);
    assert_contains(error.text, "which is NULL");
    assert_null(none);
    assert_int_equal(mbsr_small_masses_run(NULL, NULL, 1.0, NULL, &error), MBSR_ERR_NULL);
    mbsr_parameters_destroy((mbsr_parameters *)opt.list);
    mbsr_simulation_end(&s);
}

static void flags_in_words(void **state)
{
    static const struct {
        int flag, status;
        const char *words;
    } flags[] = {
        {IDA_TOO_MUCH_WORK, MBSR_ERR_SOLVER, "call again, or allow more"},
        {IDA_TOO_MUCH_ACC, MBSR_ERR_SOLVER, "larger rtol or atol"},
        {IDA_ERR_FAIL, MBSR_ERR_SOLVER, "no step is short enough"},
        {IDA_CONV_FAIL, MBSR_ERR_SOLVER, "Newton's method fails"},
        {IDA_LSETUP_FAIL, MBSR_ERR_SOLVER, "has no factors"},
        {IDA_LSOLVE_FAIL, MBSR_ERR_SOLVER, "cannot be solved"},
        {IDA_RES_FAIL, MBSR_ERR_SOLVER, "the residual cannot be evaluated"},
        {IDA_FIRST_RES_FAIL, MBSR_ERR_SOLVER, "the residual cannot be evaluated"},
        {IDA_REP_RES_ERR, MBSR_ERR_SOLVER, "near the state reached"},
        {IDA_RTFUNC_FAIL, MBSR_ERR_SOLVER, "an event function failed"},
        {IDA_BAD_EWT, MBSR_ERR_SOLVER, "atol must be positive"},
        {IDA_MEM_FAIL, MBSR_ERR_NO_MEMORY, "no memory"},
        {IDA_ILL_INPUT, MBSR_ERR_SOLVER, "f: "},
        {12345, MBSR_ERR_SOLVER, "f: "},
    };
    (void)state;
    mbsr_simulation s = slider();
    mbsr_simulation_start(&s, NULL, 0.0, NULL, NULL);
    assert_ok(s.status, &s.error);
    for (size_t k = 0; k < sizeof flags / sizeof *flags; ++k) {
        mbsr_error error;
        assert_int_equal(mbsri_ida_solver_failed(s.ida, &error, flags[k].flag, "f"),
                         flags[k].status);
        assert_int_equal(error.status, flags[k].status);
        assert_contains(error.text, flags[k].words);
        assert_null(strstr(error.text, "; ")); /* SUNDIALS has said nothing */
    }
    mbsr_simulation_end(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_simulation),
        cmocka_unit_test(too_early_or_too_late),
        cmocka_unit_test(sensitivities_of_nothing),
        cmocka_unit_test(flags_in_words),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
