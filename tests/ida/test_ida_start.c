/* The state of the driver at its start and after failures.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "locale_comma.h"
#include "problems.h"

static mbsr_ida *driver(const problem *p)
{
    const mbsr_ida_opt opt = problem_opt();
    mbsr_ida *ida = NULL;
    assert_ok(mbsr_ida_create(p->model, p->data, &opt, &ida, NULL), NULL);
    return ida;
}

/* A loop over output times that begins with the start. */
static void the_first_output_time_may_be_the_start(void **state)
{
    (void)state;
    problem p;
    problem_oscillator(&p, NULL);
    double solution[4];
    for (int way = 1; way >= -1; way -= 2) {
        double t, y[4], yp[4];
        mbsr_ida *ida = driver(&p);
        assert_ok(mbsr_ida_start(ida, 0.0, p.y, p.yp), mbsr_ida_error(ida));
        for (int i = 0; i <= 10; ++i) {
            t = 7.0;
            assert_ok(mbsr_ida_advance(ida, way * 0.1 * i, &t, y, yp), mbsr_ida_error(ida));
            assert_true(t == way * 0.1 * i);
            oscillator_solution(t, solution);
            for (int k = 0; k < 4; ++k) assert_close(y[k], solution[k], i == 0 ? 0.0 : 1e-4);
            if (i == 0) assert_memory_equal(yp, p.yp, sizeof yp);
        }
        mbsr_ida_destroy(ida);
    }
    /* a start at 3, and a time that differs by rounding: the state is that of the start */
    mbsr_ida *ida = driver(&p);
    double t, y[4];
    assert_ok(mbsr_ida_start(ida, 3.0, p.y, p.yp), mbsr_ida_error(ida));
    for (int k = 0; k < 2; ++k) {
        assert_ok(mbsr_ida_advance(ida, nextafter(3.0, 2.0 + 2 * k), &t, y, NULL),
                  mbsr_ida_error(ida));
        assert_true(t == 3.0);
        assert_memory_equal(y, p.y, sizeof y);
    }
    assert_ok(mbsr_ida_advance(ida, 2.5, &t, y, NULL), mbsr_ida_error(ida));
    oscillator_solution(-0.5, solution);
    for (int k = 0; k < 4; ++k) assert_close(y[k], solution[k], 1e-4);
    mbsr_ida_destroy(ida);
    problem_free(&p);
}

/* The residual fails for good from 0.7 s on: the state is that of the last step before. */
static void the_last_good_state_is_kept_after_a_failure(void **state)
{
    (void)state;
    problem p;
    probe observer = probe_passive();
    problem_oscillator(&p, &observer);
    const int codes[] = {-8, 8, MBSR_ERR_VALUE};
    for (int k = 0; k < 3; ++k) {
        double t = 5.0, y[4], yp[4], solution[4];
        observer = probe_passive();
        mbsr_ida *ida = driver(&p);
        assert_ok(mbsr_ida_start(ida, 0.0, p.y, p.yp), mbsr_ida_error(ida));
        assert_ok(mbsr_ida_advance(ida, 0.2, NULL, NULL, NULL), mbsr_ida_error(ida));
        observer.fail_from = 0.7;
        observer.fail_to = INFINITY;
        observer.code = codes[k];
        assert_int_equal(mbsr_ida_advance(ida, 3.0, &t, y, yp), codes[k]);
        assert_true(t == 5.0);
        assert_ok(mbsr_ida_state(ida, &t, y, yp), mbsr_ida_error(ida));
        assert_true(t > 0.2 && t < 0.7);
        assert_true(codes[k] < 0 || t > 0.69); /* shorter steps came closer */
        oscillator_solution(t, solution);
        for (int l = 0; l < 4; ++l) assert_close(y[l], solution[l], 1e-4);
        for (int l = 0; l < 2; ++l) assert_close(yp[l], solution[2 + l], 1e-2);
        /* nothing else is taken, and a new start goes on from there */
        assert_int_equal(mbsr_ida_advance(ida, 3.0, NULL, NULL, NULL), MBSR_ERR_SEQUENCE);
        observer = probe_passive();
        assert_ok(mbsr_dae_consistent(p.model, p.data, MBSR_DAE_RECURSIVE, t, y, yp, NULL, NULL),
                  mbsr_data_error(p.data));
        assert_ok(mbsr_ida_start(ida, t, y, yp), mbsr_ida_error(ida));
        assert_ok(mbsr_ida_advance(ida, 1.0, &t, y, NULL), mbsr_ida_error(ida));
        oscillator_solution(1.0, solution);
        for (int l = 0; l < 4; ++l) assert_close(y[l], solution[l], 1e-4);
        mbsr_ida_destroy(ida);
    }
    problem_free(&p);
}

/* No step succeeds: the state is the start, to the last bit. */
static void the_start_is_kept_when_the_first_step_fails(void **state)
{
    (void)state;
    problem p;
    probe observer = probe_passive();
    problem_oscillator(&p, &observer);
    mbsr_ida *ida = driver(&p);
    double t, y[4], yp[4];
    assert_int_equal(mbsr_ida_state(ida, &t, y, yp), MBSR_ERR_SEQUENCE);
    assert_ok(mbsr_ida_start(ida, 0.0, p.y, p.yp), mbsr_ida_error(ida));
    observer.fail_from = 0.0;
    observer.fail_to = INFINITY;
    observer.code = -8;
    assert_int_equal(mbsr_ida_advance(ida, 3.0, NULL, NULL, NULL), -8);
    assert_ok(mbsr_ida_state(ida, &t, y, yp), mbsr_ida_error(ida));
    assert_true(t == 0.0);
    assert_memory_equal(y, p.y, sizeof y);
    assert_memory_equal(yp, p.yp, sizeof yp);
    /* a start that fails leaves none */
    assert_int_equal(mbsr_ida_start(ida, 0.0, p.y, p.yp), -8);
    assert_int_equal(mbsr_ida_state(ida, &t, y, yp), MBSR_ERR_SEQUENCE);
    mbsr_ida_destroy(ida);
    problem_free(&p);
}

/* Ranks are deficient, and every direction is determined: no reason to refuse. */
static void massless_directions_with_a_force_may_start(void **state)
{
    (void)state;
    problem p;
    problem_massless(&p, NULL);
    const mbsr_dae_form forms[] = {MBSR_DAE_MOMENTUM, MBSR_DAE_RECURSIVE, MBSR_DAE_INDEX1,
                                   MBSR_DAE_INVERSE_DYNAMICS};
    for (int f = 0; f < 4; ++f) {
        mbsr_ida_opt opt = problem_opt();
        double y[4], yp[4], t;
        mbsr_ida *ida = NULL;
        opt.form = forms[f];
        assert_ok(mbsr_dae_pack(p.model, p.data, forms[f], 0.0, p.y, p.y + 1, y), NULL);
        assert_ok(mbsr_dae_consistent(p.model, p.data, forms[f], 0.0, y, yp, NULL, NULL),
                  mbsr_data_error(p.data));
        assert_ok(mbsr_ida_create(p.model, p.data, &opt, &ida, NULL), NULL);
        assert_ok(mbsr_ida_start(ida, 0.0, y, yp), mbsr_ida_error(ida));
        assert_ok(mbsr_ida_advance(ida, 0.5, &t, y, NULL), mbsr_ida_error(ida));
        assert_close(y[0], exp(-1.5), 1e-4);
        mbsr_ida_destroy(ida);
    }
    problem_free(&p);
}

/* IDA writes its messages itself. */
static void texts_in_a_locale_with_a_comma(void **state)
{
    (void)state;
    if (!test_locale_comma()) skip();
    problem p;
    problem_oscillator(&p, NULL);
    mbsr_ida_opt opt = problem_opt();
    opt.rtol = 1e-18;
    opt.atol = 1e-30;
    mbsr_ida *ida = NULL;
    assert_ok(mbsr_ida_create(p.model, p.data, &opt, &ida, NULL), NULL);
    assert_ok(mbsr_ida_start(ida, 1.5, p.y, p.yp), mbsr_ida_error(ida));
    assert_refused(mbsr_ida_advance(ida, 2.0, NULL, NULL, NULL), mbsr_ida_error(ida),
                   MBSR_ERR_SOLVER, MBSR_NONE, MBSR_NONE, "At t = 1.5");
    mbsr_ida_destroy(ida);
    problem_free(&p);
    test_locale_back();
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_first_output_time_may_be_the_start),
        cmocka_unit_test(the_last_good_state_is_kept_after_a_failure),
        cmocka_unit_test(the_start_is_kept_when_the_first_step_fails),
        cmocka_unit_test(massless_directions_with_a_force_may_start),
        cmocka_unit_test(texts_in_a_locale_with_a_comma),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
