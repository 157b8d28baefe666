/* What the driver refuses, how failures of callbacks and of IDA come out, silence.
 * SPDX-License-Identifier: BSD-3-Clause */
#define _POSIX_C_SOURCE 200809L

#include "problems.h"

#include <stdio.h>
#include <unistd.h>

/* ---- creation ---- */

static void refuse(const problem *p, const mbsr_ida_opt *opt, int status, const char *words)
{
    mbsr_ida *ida = (mbsr_ida *)p->model; /* anything but NULL */
    mbsr_error error = {0};
    assert_refused(mbsr_ida_create(p->model, p->data, opt, &ida, &error), &error, status, MBSR_NONE,
                   MBSR_NONE, words);
    assert_null(ida);
    assert_int_equal(mbsr_ida_create(p->model, p->data, opt, &ida, NULL), status);
}

static int no_event(void *user, double t, const double *y, const double *yp, double *value)
{
    (void)user;
    (void)t;
    (void)y;
    (void)yp;
    *value = 1.0;
    return 0;
}

#define REFUSE_FIELD(p, field, value, status, words)                                               \
    do {                                                                                           \
        mbsr_ida_opt opt_ = problem_opt();                                                         \
        opt_.field = (value);                                                                      \
        refuse((p), &opt_, (status), (words));                                                     \
    } while (0)

static void options_that_make_no_sense_are_refused(void **state)
{
    (void)state;
    problem p;
    problem_oscillator(&p, NULL);
    const double no[] = {NAN, INFINITY, -INFINITY, -0.25};
    const char *const text[] = {"is nan|mbsr_ida_create", "is inf", "is -inf", "is -0.25"};
    for (int k = 0; k < 4; ++k) {
        REFUSE_FIELD(&p, rtol, no[k], MBSR_ERR_VALUE, "rtol|must be finite and positive");
        REFUSE_FIELD(&p, atol, no[k], MBSR_ERR_VALUE, "must be finite and not negative| atol ");
        REFUSE_FIELD(&p, initial_step, no[k], MBSR_ERR_VALUE,
                     "initial_step|finite and not negative");
        REFUSE_FIELD(&p, max_step, no[k], MBSR_ERR_VALUE, "max_step |finite and not negative");
        REFUSE_FIELD(&p, rtol, no[k], MBSR_ERR_VALUE, text[k]);
        REFUSE_FIELD(&p, atol, no[k], MBSR_ERR_VALUE, text[k]);
        REFUSE_FIELD(&p, initial_step, no[k], MBSR_ERR_VALUE, text[k]);
        REFUSE_FIELD(&p, max_step, no[k], MBSR_ERR_VALUE, text[k]);
        double each[4] = {1.0, 0.0, 1.0, no[k]};
        REFUSE_FIELD(&p, atol_each, each, MBSR_ERR_VALUE, "atol_each[3]");
        REFUSE_FIELD(&p, atol_each, each, MBSR_ERR_VALUE, text[k]);
    }
    REFUSE_FIELD(&p, rtol, 0.0, MBSR_ERR_VALUE, "rtol is 0");
    REFUSE_FIELD(&p, max_order, 0, MBSR_ERR_VALUE, "max_order is 0|1 .. 5");
    REFUSE_FIELD(&p, max_order, 6, MBSR_ERR_VALUE, "max_order is 6|1 .. 5");
    REFUSE_FIELD(&p, max_steps, 0, MBSR_ERR_VALUE, "max_steps is 0|positive");
    REFUSE_FIELD(&p, max_steps, -3, MBSR_ERR_VALUE, "max_steps is -3");
    REFUSE_FIELD(&p, events, -1, MBSR_ERR_VALUE, "events is -1");
    REFUSE_FIELD(&p, events, 2, MBSR_ERR_NULL, "events is 2 but event is NULL");
    REFUSE_FIELD(&p, event, no_event, MBSR_ERR_VALUE, "events is 0 but event is given");
    REFUSE_FIELD(&p, form, (mbsr_dae_form)77, MBSR_ERR_VALUE, "form is 77");
    REFUSE_FIELD(&p, cookie, 0, MBSR_ERR_NO_DEFAULT, "mbsr_default_ida_opt");
    const mbsr_ida_opt blank = {0};
    refuse(&p, &blank, MBSR_ERR_NO_DEFAULT, "mbsr_default_ida_opt");
    problem_free(&p);
}

static void models_that_cannot_be_integrated_are_refused(void **state)
{
    (void)state;
    problem p, other, raw, still;
    problem_oscillator(&p, NULL);
    problem_oscillator(&other, NULL);
    mbsr_ida *ida = NULL;
    mbsr_error error = {0};
    assert_refused(mbsr_ida_create(NULL, p.data, NULL, &ida, &error), &error, MBSR_ERR_NULL,
                   MBSR_NONE, MBSR_NONE, "model is NULL");
    assert_refused(mbsr_ida_create(p.model, NULL, NULL, &ida, &error), &error, MBSR_ERR_NULL,
                   MBSR_NONE, MBSR_NONE, "data is NULL");
    assert_refused(mbsr_ida_create(p.model, p.data, NULL, NULL, &error), &error, MBSR_ERR_NULL,
                   MBSR_NONE, MBSR_NONE, "ida is NULL");
    assert_refused(mbsr_ida_create(p.model, other.data, NULL, &ida, &error), &error,
                   MBSR_ERR_MISMATCH, MBSR_NONE, MBSR_NONE, "data belongs to another model");
    assert_null(ida);
    problem_point(&raw, MBSR_X, 1.0);
    raw.data = p.data;
    refuse(&raw, NULL, MBSR_ERR_UNFINISHED, "not finished");
    raw.data = NULL;
    problem_point(&still, 0, 1.0);
    assert_ok(mbsr_model_finish(still.model), mbsr_model_error(still.model));
    assert_ok(mbsr_data_create(still.model, &still.data, NULL), NULL);
    refuse(&still, NULL, MBSR_ERR_VALUE, "no joint coordinates");
    problem_free(&still);
    problem_free(&raw);
    problem_free(&other);
    problem_free(&p);
}

static void null_is_refused_or_harmless(void **state)
{
    (void)state;
    mbsr_ida_destroy(NULL);
    double x[4] = {0.0};
    int direction = 0;
    mbsr_ida_stats stats;
    assert_int_equal(mbsr_ida_start(NULL, 0.0, x, x), MBSR_ERR_NULL);
    assert_int_equal(mbsr_ida_advance(NULL, 1.0, NULL, NULL, NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_ida_event_info(NULL, &direction), MBSR_ERR_NULL);
    assert_int_equal(mbsr_ida_dense(NULL, 0.0, 0, x), MBSR_ERR_NULL);
    assert_int_equal(mbsr_ida_get_stats(NULL, &stats), MBSR_ERR_NULL);
    mbsr_ida_drift drift;
    mbsr_error error;
    assert_int_equal(mbsr_ida_get_drift(NULL, &drift), MBSR_ERR_NULL);
    assert_int_equal(mbsr_ida_motion(NULL, x, x, x, x), MBSR_ERR_NULL);
    assert_int_equal(mbsr_small_masses_run(NULL, NULL, 1.0, NULL, &error), MBSR_ERR_NULL);
    assert_int_equal(mbsr_ida_error(NULL)->status, MBSR_ERR_NULL);
    assert_null(mbsr_ida_memory(NULL));
    problem p;
    problem_oscillator(&p, NULL);
    mbsr_ida *ida = problem_start(&p, NULL);
    assert_int_equal(mbsr_ida_error(ida)->status, MBSR_OK);
    assert_string_equal(mbsr_ida_error(ida)->text, "");
    assert_int_equal(mbsr_ida_event_info(ida, NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_ida_get_stats(ida, NULL), MBSR_ERR_NULL);
    assert_refused(mbsr_ida_dense(ida, 0.0, 0, NULL), mbsr_ida_error(ida), MBSR_ERR_NULL, MBSR_NONE,
                   MBSR_NONE, "dky is NULL");
    assert_refused(mbsr_ida_get_drift(ida, NULL), mbsr_ida_error(ida), MBSR_ERR_NULL, MBSR_NONE,
                   MBSR_NONE, "drift is NULL");
    assert_refused(mbsr_ida_start(ida, 0.0, NULL, x), mbsr_ida_error(ida), MBSR_ERR_NULL, MBSR_NONE,
                   MBSR_NONE, "mbsr_ida_start: y is NULL");
    assert_refused(mbsr_ida_start(ida, 0.0, x, NULL), mbsr_ida_error(ida), MBSR_ERR_NULL, MBSR_NONE,
                   MBSR_NONE, "mbsr_ida_start: yp is NULL");
    assert_ok(mbsr_ida_advance(ida, 0.1, NULL, NULL, NULL), mbsr_ida_error(ida));
    mbsr_ida_destroy(ida);
    problem_free(&p);
}

static void what_a_start_has_to_come_before(void **state)
{
    (void)state;
    problem p;
    mbsr_ida *ida;
    mbsr_ida_drift drift;
    double x[4];
    problem_oscillator(&p, NULL);
    assert_ok(mbsr_ida_create(p.model, p.data, NULL, &ida, NULL), NULL);
    assert_refused(mbsr_ida_motion(ida, x, x, x, x), mbsr_ida_error(ida), MBSR_ERR_SEQUENCE,
                   MBSR_NONE, MBSR_NONE, "mbsr_ida_start first");
    assert_refused(mbsr_ida_get_drift(ida, &drift), mbsr_ida_error(ida), MBSR_ERR_SEQUENCE,
                   MBSR_NONE, MBSR_NONE, "mbsr_ida_start first");
    mbsr_ida_destroy(ida);
    problem_free(&p);
}

/* ---- use ---- */

static void wrong_times_and_starts_are_refused(void **state)
{
    (void)state;
    const mbsr_ida_opt direct = problem_opt();
    problem p;
    problem_oscillator(&p, NULL);
    mbsr_ida *ida = NULL;
    assert_ok(mbsr_ida_create(p.model, p.data, &direct, &ida, NULL), NULL);
    const mbsr_error *error = mbsr_ida_error(ida);
    double t = 5.0, dky[4];
    assert_refused(mbsr_ida_advance(ida, 1.0, &t, NULL, NULL), error, MBSR_ERR_SEQUENCE, MBSR_NONE,
                   MBSR_NONE, "mbsr_ida_start first");
    assert_refused(mbsr_ida_start(ida, NAN, p.y, p.yp), error, MBSR_NOT_FINITE, MBSR_NONE,
                   MBSR_NONE, "mbsr_ida_start|t is nan");
    double bad[4] = {0.0, 0.0, INFINITY, 0.0};
    assert_refused(mbsr_ida_start(ida, 0.0, bad, p.yp), error, MBSR_NOT_FINITE, MBSR_NONE,
                   MBSR_NONE, ": y[2] is inf");
    assert_refused(mbsr_ida_start(ida, 0.0, p.y, bad), error, MBSR_NOT_FINITE, MBSR_NONE, MBSR_NONE,
                   ": yp[2] is inf");
    assert_int_equal(mbsr_ida_advance(ida, 1.0, &t, NULL, NULL), MBSR_ERR_SEQUENCE);
    assert_ok(mbsr_ida_start(ida, 3.0, p.y, p.yp), error);
    assert_refused(mbsr_ida_advance(ida, NAN, &t, NULL, NULL), error, MBSR_ERR_VALUE, MBSR_NONE,
                   MBSR_NONE, "t_end is nan");
    assert_refused(mbsr_ida_advance(ida, -INFINITY, &t, NULL, NULL), error, MBSR_ERR_VALUE,
                   MBSR_NONE, MBSR_NONE, "t_end is -inf");
    assert_refused(mbsr_ida_dense(ida, 3.0, 0, dky), error, MBSR_ERR_SEQUENCE, MBSR_NONE, MBSR_NONE,
                   "no step");
    assert_true(t == 5.0);
    assert_ok(mbsr_ida_advance(ida, 4.0, &t, NULL, NULL), error);
    assert_refused(mbsr_ida_advance(ida, 3.9, &t, NULL, NULL), error, MBSR_ERR_VALUE, MBSR_NONE,
                   MBSR_NONE, "t_end is 3.8999999999999999|behind the present time 4");
    /* a refused start leaves the run as it was */
    assert_int_equal(mbsr_ida_start(ida, 0.0, bad, p.yp), MBSR_NOT_FINITE);
    assert_ok(mbsr_ida_advance(ida, 4.5, &t, NULL, NULL), error);
    assert_true(t == 4.5);
    assert_refused(mbsr_ida_dense(ida, 4.5, -1, dky), error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                   "k is -1, must be 0 .. ");
    assert_refused(mbsr_ida_dense(ida, 4.5, 6, dky), error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                   "k is 6");
    assert_refused(mbsr_ida_dense(ida, NAN, 0, dky), error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                   "t is nan, not within the last step");
    assert_refused(mbsr_ida_dense(ida, 3.0, 0, dky), error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                   "t is 3, not within the last step|Illegal value for t");
    mbsr_ida_destroy(ida);
    problem_free(&p);
}

/* ---- callbacks that fail ---- */

/* After a failure: outputs untouched, nothing but a start is taken, and then the driver works. */
static void assert_usable_again(mbsr_ida *ida, const problem *p, probe *observer)
{
    double t = 5.0, y[4] = {5.0, 5.0, 5.0, 5.0};
    if (observer) *observer = probe_passive();
    assert_int_equal(mbsr_ida_advance(ida, 2.0, &t, y, y), MBSR_ERR_SEQUENCE);
    assert_true(t == 5.0 && y[0] == 5.0 && y[3] == 5.0);
    assert_ok(mbsr_ida_start(ida, 0.0, p->y, p->yp), mbsr_ida_error(ida));
    assert_ok(mbsr_ida_advance(ida, 1.0, &t, y, NULL), mbsr_ida_error(ida));
    double exact[4];
    oscillator_solution(t, exact);
    for (int k = 0; k < 4; ++k) assert_close(y[k], exact[k], 1e-3);
}

static void the_status_of_a_failed_residual_comes_out_unchanged(void **state)
{
    (void)state;
    problem p;
    probe observer = probe_passive();
    problem_oscillator(&p, &observer);
    mbsr_ida *ida = problem_start(&p, NULL);
    const int codes[] = {7, -7, 1, -1, 2000000000, -2000000000, MBSR_NOT_FINITE, MBSR_ERR_SOLVER};
    const int force = mbsr_model_forces(p.model) - 1;
    for (int k = 0; k < 8; ++k) {
        for (int late = 0; late < 2; ++late) {
            double t = 5.0, y[4] = {5.0, 5.0, 5.0, 5.0};
            assert_ok(mbsr_ida_start(ida, 0.0, p.y, p.yp), mbsr_ida_error(ida));
            observer = probe_passive();
            observer.code = codes[k];
            observer.fail_from = late ? 0.5 : 0.0;
            assert_refused(mbsr_ida_advance(ida, 1.0, &t, y, y), mbsr_ida_error(ida), codes[k],
                           MBSR_NONE, force,
                           late ? "mbsr_ida_advance: residual at t = 0.5" : "residual at t = ");
            assert_contains(mbsr_ida_error(ida)->text, mbsr_data_error(p.data)->text);
            assert_true(t == 5.0 && y[0] == 5.0 && y[3] == 5.0);
            assert_true(observer.calls > (codes[k] > 0 ? 5 : 0));
            assert_in_range(observer.calls, 1,
                            3000); /* it does not creep to the end of max_steps */
            assert_usable_again(ida, &p, &observer);
        }
    }
    mbsr_ida_destroy(ida);
    problem_free(&p);
}

/* A start evaluates the residual once; when that fails there is no state to go on from, not even
 * the one before. */
static void a_start_whose_residual_fails_is_refused(void **state)
{
    (void)state;
    problem p;
    probe observer = probe_passive();
    problem_oscillator(&p, &observer);
    const int codes[] = {7, -7, MBSR_NOT_FINITE}, force = mbsr_model_forces(p.model) - 1;
    const mbsr_dae_form forms[] = {MBSR_DAE_MOMENTUM, MBSR_DAE_RECURSIVE};
    for (int f = 0; f < 2; ++f) {
        mbsr_ida_opt opt = problem_opt();
        opt.form = forms[f];
        double y[6], yp[6];
        problem_in_form(&p, opt.form, y, yp);
        mbsr_ida *ida = NULL;
        assert_ok(mbsr_ida_create(p.model, p.data, &opt, &ida, NULL), NULL);
        for (int k = 0; k < 3; ++k) {
            assert_ok(mbsr_ida_start(ida, 0.0, y, yp), mbsr_ida_error(ida));
            assert_ok(mbsr_ida_advance(ida, 0.1, NULL, NULL, NULL), mbsr_ida_error(ida));
            observer = probe_passive();
            observer.code = codes[k];
            observer.fail_from = 0.0;
            assert_refused(mbsr_ida_start(ida, 0.25, y, yp), mbsr_ida_error(ida), codes[k],
                           MBSR_NONE, force, "mbsr_ida_start: residual at t = 0.25: force");
            assert_contains(mbsr_ida_error(ida)->text, mbsr_data_error(p.data)->text);
            assert_int_equal(observer.calls, 1);
            observer = probe_passive();
            assert_int_equal(mbsr_ida_advance(ida, 0.2, NULL, NULL, NULL), MBSR_ERR_SEQUENCE);
        }
        mbsr_ida_destroy(ida);
    }
    problem_free(&p);
}

/* The first evaluation at a time succeeds, those of the difference quotients fail. */
static void a_failure_in_a_difference_quotient_comes_out_unchanged(void **state)
{
    (void)state;
    problem p;
    probe observer = probe_passive();
    problem_oscillator(&p, &observer);
    mbsr_ida *ida = problem_start(&p, NULL);
    for (int code = -9; code <= 9; code += 18) {
        observer.fail_from = 0.0;
        observer.second_at_one_time = 1;
        observer.code = code;
        assert_refused(mbsr_ida_advance(ida, 1.0, NULL, NULL, NULL), mbsr_ida_error(ida), code,
                       MBSR_NONE, mbsr_model_forces(p.model) - 1, "residual at t = ");
        assert_usable_again(ida, &p, &observer);
        assert_ok(mbsr_ida_start(ida, 0.0, p.y, p.yp), mbsr_ida_error(ida));
    }
    mbsr_ida_destroy(ida);
    problem_free(&p);
}

static void a_recoverable_failure_that_passes_is_overcome(void **state)
{
    (void)state;
    problem p;
    probe observer = probe_passive();
    problem_oscillator(&p, &observer);
    mbsr_ida_opt opt = problem_opt();
    opt.max_steps = 40;
    mbsr_ida *ida = problem_start(&p, &opt);
    observer.fail_first = 3;
    observer.code = 5;
    /* the end is that of max_steps, not that of the callback */
    assert_refused(mbsr_ida_advance(ida, 100.0, NULL, NULL, NULL), mbsr_ida_error(ida),
                   MBSR_ERR_SOLVER, MBSR_NONE, MBSR_NONE, "IDA_TOO_MUCH_WORK");
    assert_true(observer.calls > 40);
    assert_int_equal(problem_stats(ida).steps, 40);
    mbsr_ida_destroy(ida);
    problem_free(&p);
}

/* That the residual failed again and again at one time is forgotten by a new start. */
static void a_start_forgets_earlier_failures(void **state)
{
    (void)state;
    problem p;
    probe observer = probe_passive();
    problem_oscillator(&p, &observer);
    mbsr_ida_opt opt = problem_opt();
    opt.atol = 0.0;
    opt.initial_step = 1e-14;
    for (int k = 0; k < 4; ++k) p.y[k] = 1.0;
    mbsr_ida *ida = problem_start(&p, &opt);
    observer.fail_from = 0.5;
    observer.code = 5;
    assert_int_equal(mbsr_ida_advance(ida, 1.0, NULL, NULL, NULL), 5);
    assert_true(observer.calls > 100);
    observer = probe_passive();
    assert_ok(mbsr_ida_start(ida, 0.5, p.y, p.yp), mbsr_ida_error(ida));
    observer = probe_passive();
    observer.fail_first = 1;
    observer.code = 5;
    assert_ok(mbsr_ida_advance(ida, 0.6, NULL, NULL, NULL), mbsr_ida_error(ida));
    assert_true(observer.calls > 1);
    /* nor is an old failure the reason for one that comes before any evaluation */
    assert_ok(mbsr_ida_start(ida, 0.5, p.y, p.yp), mbsr_ida_error(ida));
    observer.fail_from = 0.0;
    assert_int_equal(mbsr_ida_advance(ida, 1.0, NULL, NULL, NULL), 5);
    observer = probe_passive();
    p.y[2] = 0.0;
    assert_ok(mbsr_ida_start(ida, 0.5, p.y, p.yp), mbsr_ida_error(ida));
    assert_refused(mbsr_ida_advance(ida, 1.0, NULL, NULL, NULL), mbsr_ida_error(ida),
                   MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE, "y[2] is 0|tolerance");
    mbsr_ida_destroy(ida);
    problem_free(&p);
}

typedef struct failing_event {
    double from, value;
    int code;
} failing_event;

static int event_function(void *user, double t, const double *y, const double *yp, double *value)
{
    const failing_event *e = user;
    (void)y;
    (void)yp;
    value[0] = 1.0;
    value[1] = t >= e->from ? e->value : 2.0;
    return t >= e->from ? e->code : 0;
}

static void a_failed_event_function_comes_out_unchanged(void **state)
{
    (void)state;
    problem p;
    problem_oscillator(&p, NULL);
    failing_event e = {0.0, 2.0, 0};
    mbsr_ida_opt opt = problem_opt();
    opt.events = 2;
    opt.event = event_function;
    opt.event_user = &e;
    mbsr_ida *ida = problem_start(&p, &opt);
    const int codes[] = {42, -42};
    const double from[] = {0.0, 0.5};
    for (int k = 0; k < 4; ++k) {
        e = (failing_event){from[k / 2], 2.0, codes[k % 2]};
        assert_ok(mbsr_ida_start(ida, 0.0, p.y, p.yp), mbsr_ida_error(ida));
        assert_refused(mbsr_ida_advance(ida, 1.0, NULL, NULL, NULL), mbsr_ida_error(ida),
                       codes[k % 2], MBSR_NONE, MBSR_NONE,
                       k < 2 ? "event function at t = 0 returned" : "event function at t = 0.5");
        e.code = 0;
        assert_usable_again(ida, &p, NULL);
    }
    for (int k = 0; k < 2; ++k) {
        e = (failing_event){0.5, k ? INFINITY : NAN, 0};
        assert_ok(mbsr_ida_start(ida, 0.0, p.y, p.yp), mbsr_ida_error(ida));
        assert_refused(mbsr_ida_advance(ida, 1.0, NULL, NULL, NULL), mbsr_ida_error(ida),
                       MBSR_NOT_FINITE, MBSR_NONE, MBSR_NONE,
                       k ? "event function 1|is inf" : "event function 1|is nan");
        e.value = 2.0;
        assert_usable_again(ida, &p, NULL);
    }
    mbsr_ida_destroy(ida);
    problem_free(&p);
}

/* ---- failures of IDA ---- */

/* A spring on a point without mass, with its stiffness gone from a time on. */
typedef struct fading {
    double until;
    long calls;
} fading;

static int fade(const mbsr_force_args *args)
{
    fading *f = args->force->user;
    const mbsr_force_body *body = args->body;
    ++f->calls;
    if (args->t < f->until) body->tau[0] -= 6.0 * body->q[0] + 2.0 * body->u[0];
    return 0;
}

static const mbsr_force_table fading_table = {.version = MBSR_FORCE_TABLE_VERSION,
                                              .flags = MBSR_FORCE_JOINT_ONLY,
                                              .name = "fading",
                                              .evaluate = fade};

static void a_singular_problem_is_a_failure_of_the_solver(void **state)
{
    (void)state;
    problem p;
    fading f = {INFINITY, 0};
    const int body = 0;
    problem_point(&p, MBSR_X, 0.0);
    const mbsr_force_def force = mbsr_force_custom(&fading_table, 1, &body, &f);
    assert_ok(mbsr_model_add_force(p.model, &force, NULL), mbsr_model_error(p.model));
    p.y[0] = 1.0;
    problem_finish(&p, NULL);
    mbsr_ida *ida = problem_start(&p, NULL);
    for (int k = 0; k < 2; ++k) {
        f = (fading){0.0, 0};
        assert_refused(mbsr_ida_advance(ida, 1.0, NULL, NULL, NULL), mbsr_ida_error(ida),
                       MBSR_ERR_SOLVER, MBSR_NONE, MBSR_NONE, "mbsr_ida_advance: IDA_|At t = 0");
        assert_true(f.calls > 1);
        f.until = INFINITY;
        assert_ok(mbsr_ida_start(ida, 0.0, p.y, p.yp), mbsr_ida_error(ida));
    }
    mbsr_ida_destroy(ida);
    problem_free(&p);
}

static void tolerances_that_cannot_be_met_are_a_failure_of_the_solver(void **state)
{
    (void)state;
    problem p;
    problem_oscillator(&p, NULL);
    mbsr_ida_opt opt = problem_opt();
    opt.rtol = 1e-18;
    opt.atol = 1e-30;
    mbsr_ida *ida = problem_start(&p, &opt);
    assert_refused(mbsr_ida_advance(ida, 1.0, NULL, NULL, NULL), mbsr_ida_error(ida),
                   MBSR_ERR_SOLVER, MBSR_NONE, MBSR_NONE,
                   "IDA_TOO_MUCH_ACC|larger rtol or atol|too much accuracy");
    mbsr_ida_destroy(ida);
    opt.rtol = 1e-6;
    opt.atol = 0.0; /* allowed, but the velocities are zero */
    ida = problem_start(&p, &opt);
    assert_refused(mbsr_ida_advance(ida, 1.0, NULL, NULL, NULL), mbsr_ida_error(ida),
                   MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE, "y[2] is 0|tolerance");
    mbsr_ida_destroy(ida);
    problem_free(&p);
}

/* Starts with an event function that is zero and stays so, which IDA would warn of. */
static int zero_event(void *user, double t, const double *y, const double *yp, double *value)
{
    (void)user;
    (void)t;
    (void)y;
    (void)yp;
    *value = 0.0;
    return 0;
}

static void fail_in_many_ways(void)
{
    void (*const failing[])(void **) = {
        options_that_make_no_sense_are_refused,
        models_that_cannot_be_integrated_are_refused,
        wrong_times_and_starts_are_refused,
        the_status_of_a_failed_residual_comes_out_unchanged,
        a_failure_in_a_difference_quotient_comes_out_unchanged,
        a_failed_event_function_comes_out_unchanged,
        a_singular_problem_is_a_failure_of_the_solver,
        tolerances_that_cannot_be_met_are_a_failure_of_the_solver,
    };
    for (size_t k = 0; k < sizeof failing / sizeof failing[0]; ++k) failing[k](NULL);
    problem p;
    problem_oscillator(&p, NULL);
    mbsr_ida_opt opt = problem_opt();
    opt.events = 1;
    opt.event = zero_event;
    mbsr_ida *ida = problem_start(&p, &opt);
    assert_ok(mbsr_ida_advance(ida, 1.0, NULL, NULL, NULL), mbsr_ida_error(ida));
    mbsr_ida_destroy(ida);
    problem_free(&p);
}

/* Where standard output and standard error went before, and the file that stands in for them. */
typedef struct capture {
    int out, err;
    FILE *file;
} capture;

static int start_capture(void **state)
{
    static capture c;
    *state = &c;
    fflush(stdout);
    fflush(stderr);
    c.file = tmpfile();
    c.out = dup(STDOUT_FILENO);
    c.err = dup(STDERR_FILENO);
    return c.file && c.out >= 0 && c.err >= 0 ? 0 : -1;
}

static int end_capture(void **state)
{
    capture *c = *state;
    fflush(stdout);
    fflush(stderr);
    const int restored = dup2(c->out, STDOUT_FILENO) >= 0 && dup2(c->err, STDERR_FILENO) >= 0;
    close(c->out);
    close(c->err);
    fclose(c->file);
    return restored ? 0 : -1;
}

static void nothing_is_printed(void **state)
{
    const capture *c = *state;
    assert_true(dup2(fileno(c->file), STDOUT_FILENO) >= 0);
    assert_true(dup2(fileno(c->file), STDERR_FILENO) >= 0);
    fail_in_many_ways();
    fflush(stdout);
    fflush(stderr);
    assert_int_equal(fseek(c->file, 0, SEEK_END), 0);
    assert_int_equal(ftell(c->file), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(options_that_make_no_sense_are_refused),
        cmocka_unit_test(models_that_cannot_be_integrated_are_refused),
        cmocka_unit_test(null_is_refused_or_harmless),
        cmocka_unit_test(what_a_start_has_to_come_before),
        cmocka_unit_test(wrong_times_and_starts_are_refused),
        cmocka_unit_test(the_status_of_a_failed_residual_comes_out_unchanged),
        cmocka_unit_test(a_start_whose_residual_fails_is_refused),
        cmocka_unit_test(a_failure_in_a_difference_quotient_comes_out_unchanged),
        cmocka_unit_test(a_recoverable_failure_that_passes_is_overcome),
        cmocka_unit_test(a_start_forgets_earlier_failures),
        cmocka_unit_test(a_failed_event_function_comes_out_unchanged),
        cmocka_unit_test(a_singular_problem_is_a_failure_of_the_solver),
        cmocka_unit_test(tolerances_that_cannot_be_met_are_a_failure_of_the_solver),
        cmocka_unit_test_setup_teardown(nothing_is_printed, start_capture, end_capture),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
