/* Output by callback, the word between two steps, stopping and going on.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "problems.h"

#include <ida/ida.h>
#include <time.h>

enum { TIMES = 41, MOST_STEPS = 4000 };

/* The oscillator in a form, with an event where x falls or rises through 0.3 m. */
typedef struct setting {
    problem p;
    mbsr_dae_form form;
    int size;
    double y[6], yp[6];
} setting;

static setting make_setting(mbsr_dae_form form)
{
    setting s = {.form = form};
    problem_oscillator(&s.p, NULL);
    s.size = mbsr_dae_size(s.p.model, form);
    problem_in_form(&s.p, form, s.y, s.yp);
    return s;
}

static mbsr_ida *begin(const setting *s, mbsr_ida_opt opt)
{
    mbsr_ida *ida = NULL;
    mbsr_error error = {0};
    opt.form = s->form;
    assert_ok(mbsr_ida_create(s->p.model, s->p.data, &opt, &ida, &error), &error);
    assert_ok(mbsr_ida_start(ida, 0.0, s->y, s->yp), mbsr_ida_error(ida));
    return ida;
}

static int crossing(void *user, double t, const double *y, const double *yp, double *value)
{
    (void)user;
    (void)t;
    (void)yp;
    value[0] = y[0] - 0.3;
    return 0;
}

static mbsr_ida_opt with_event(void)
{
    mbsr_ida_opt opt = problem_opt();
    opt.events = 1;
    opt.event = crossing;
    return opt;
}

/* ---- output ---- */

typedef struct record {
    int size, count, stop_at; /* output `stop_at` returns 77; -1: none */
    double t[TIMES], y[TIMES][6], yp[TIMES][6];
} record;

static int keep(void *user, int index, double t, const double *y, const double *yp)
{
    record *r = user;
    assert_int_equal(index, r->count);
    assert_in_range(r->count, 0, TIMES - 1);
    r->t[r->count] = t;
    memcpy(r->y[r->count], y, (size_t)r->size * sizeof *y);
    memcpy(r->yp[r->count], yp, (size_t)r->size * sizeof *yp);
    return r->count++ == r->stop_at ? 77 : 0;
}

static void output_times(double direction, double *times)
{
    for (int k = 0; k < TIMES; ++k) times[k] = direction * 0.05 * k;
    times[7] = times[6]; /* twice the same */
}

/* What mbsr_ida_advance gives at the same times. */
static mbsr_ida_stats reference(const setting *s, const double *times, record *r)
{
    mbsr_ida *ida = begin(s, problem_opt());
    *r = (record){.size = s->size, .count = TIMES};
    memcpy(r->y[0], s->y, sizeof r->y[0]);
    memcpy(r->yp[0], s->yp, sizeof r->yp[0]);
    for (int k = 1; k < TIMES; ++k) {
        assert_ok(mbsr_ida_advance(ida, times[k], &r->t[k], r->y[k], r->yp[k]),
                  mbsr_ida_error(ida));
    }
    const mbsr_ida_stats stats = problem_stats(ida);
    mbsr_ida_destroy(ida);
    return stats;
}

static void assert_same_record(const record *a, const record *b)
{
    assert_int_equal(a->count, b->count);
    for (int k = 0; k < a->count; ++k) {
        assert_true(a->t[k] == b->t[k]);
        assert_memory_equal(a->y[k], b->y[k], (size_t)a->size * sizeof(double));
        assert_memory_equal(a->yp[k], b->yp[k], (size_t)a->size * sizeof(double));
    }
}

static void output_comes_at_its_times(void **state)
{
    (void)state;
    static record expected, found;
    const mbsr_dae_form forms[] = {MBSR_DAE_MOMENTUM, MBSR_DAE_RECURSIVE};
    for (int f = 0; f < 4; ++f) {
        double times[TIMES];
        int next = 0;
        setting s = make_setting(forms[f % 2]);
        output_times(f < 2 ? 1.0 : -1.0, times);
        const mbsr_ida_stats stats = reference(&s, times, &expected);
        mbsr_ida *ida = begin(&s, problem_opt());
        found = (record){.size = s.size, .stop_at = -1};
        assert_ok(mbsr_ida_run(ida, TIMES, times, &next, keep, &found), mbsr_ida_error(ida));
        assert_int_equal(next, TIMES);
        assert_string_equal(mbsr_ida_error(ida)->text, "");
        assert_same_record(&found, &expected);
        assert_same_stats(problem_stats(ida), stats);
        /* no time left: nothing happens */
        assert_ok(mbsr_ida_run(ida, TIMES, NULL, &next, keep, &found), mbsr_ida_error(ida));
        assert_int_equal(found.count, TIMES);
        mbsr_ida_destroy(ida);
        problem_free(&s.p);
    }
}

static void output_may_stop_the_run(void **state)
{
    (void)state;
    static record expected, found;
    double times[TIMES];
    setting s = make_setting(MBSR_DAE_MOMENTUM);
    output_times(1.0, times);
    const mbsr_ida_stats stats = reference(&s, times, &expected);
    mbsr_ida *ida = begin(&s, problem_opt());
    int next = 0;
    found = (record){.size = s.size};
    for (int k = 0; k < TIMES; ++k) {
        found.stop_at = k;
        assert_refused(mbsr_ida_run(ida, TIMES, times, &next, keep, &found), mbsr_ida_error(ida),
                       77, MBSR_NONE, MBSR_NONE, "mbsr_ida_run: the output function|returned 77");
        assert_int_equal(next, k + 1);
        double t = NAN, y[6];
        assert_ok(mbsr_ida_state(ida, &t, y, NULL), mbsr_ida_error(ida));
        assert_true(t == times[k]);
        assert_memory_equal(y, found.y[k], (size_t)s.size * sizeof *y);
    }
    assert_ok(mbsr_ida_run(ida, TIMES, times, &next, keep, &found), mbsr_ida_error(ida));
    assert_same_record(&found, &expected);
    assert_same_stats(problem_stats(ida), stats);
    mbsr_ida_destroy(ida);
    problem_free(&s.p);
}

static void events_end_a_run_that_goes_on(void **state)
{
    (void)state;
    static record expected, found;
    double times[TIMES];
    setting s = make_setting(MBSR_DAE_MOMENTUM);
    output_times(1.0, times);
    const mbsr_ida_stats stats = reference(&s, times, &expected);
    mbsr_ida *ida = begin(&s, with_event());
    found = (record){.size = s.size, .stop_at = -1};
    int next = 0, events = 0, status = MBSR_EVENT;
    while ((status = mbsr_ida_run(ida, TIMES, times, &next, keep, &found)) == MBSR_EVENT) {
        int direction = 0;
        double t = NAN, y[6];
        assert_ok(mbsr_ida_state(ida, &t, y, NULL), mbsr_ida_error(ida));
        assert_ok(mbsr_ida_event_info(ida, &direction), mbsr_ida_error(ida));
        assert_int_equal(direction, -1);
        assert_close(t, 0.5 * acos(0.3), 1e-4);
        assert_close(y[0], 0.3, 1e-9);
        assert_true(t >= times[next - 1] && t <= times[next]);
        assert_int_equal(++events, 1);
    }
    assert_ok(status, mbsr_ida_error(ida));
    assert_int_equal(events, 1);
    assert_same_record(&found, &expected);
    assert_int_equal(problem_stats(ida).steps, stats.steps);
    mbsr_ida_destroy(ida);
    problem_free(&s.p);
}

static void wrong_output_times_are_refused(void **state)
{
    (void)state;
    static record found;
    setting s = make_setting(MBSR_DAE_RECURSIVE);
    mbsr_ida *ida = NULL;
    const mbsr_ida_opt opt = problem_opt();
    assert_ok(mbsr_ida_create(s.p.model, s.p.data, &opt, &ida, NULL), NULL);
    const mbsr_error *error = mbsr_ida_error(ida);
    double times[4] = {0.0, 0.1, 0.2, 0.3}, t = 5.0;
    int next = 0;
    found = (record){.size = s.size, .stop_at = -1};
    assert_int_equal(mbsr_ida_run(NULL, 1, times, &next, keep, &found), MBSR_ERR_NULL);
    assert_int_equal(mbsr_ida_state(NULL, &t, NULL, NULL), MBSR_ERR_NULL);
    assert_refused(mbsr_ida_run(ida, 4, times, NULL, keep, &found), error, MBSR_ERR_NULL, MBSR_NONE,
                   MBSR_NONE, "next is NULL");
    assert_refused(mbsr_ida_run(ida, 4, times, &next, NULL, &found), error, MBSR_ERR_NULL,
                   MBSR_NONE, MBSR_NONE, "output is NULL");
    assert_refused(mbsr_ida_run(ida, 4, times, &next, keep, &found), error, MBSR_ERR_SEQUENCE,
                   MBSR_NONE, MBSR_NONE, "mbsr_ida_run: call mbsr_ida_start first");
    assert_refused(mbsr_ida_state(ida, &t, NULL, NULL), error, MBSR_ERR_SEQUENCE, MBSR_NONE,
                   MBSR_NONE, "mbsr_ida_state: call mbsr_ida_start first");
    assert_ok(mbsr_ida_start(ida, 0.0, s.y, s.yp), error);
    assert_refused(mbsr_ida_run(ida, 4, NULL, &next, keep, &found), error, MBSR_ERR_NULL, MBSR_NONE,
                   MBSR_NONE, "times is NULL");
    const int wrong[] = {-1, 5};
    for (int k = 0; k < 2; ++k) {
        next = wrong[k];
        assert_refused(mbsr_ida_run(ida, 4, times, &next, keep, &found), error, MBSR_ERR_VALUE,
                       MBSR_NONE, MBSR_NONE, k ? "next is 5 of 4" : "next is -1 of 4");
    }
    next = 0;
    assert_refused(mbsr_ida_run(ida, -1, times, &next, keep, &found), error, MBSR_ERR_VALUE,
                   MBSR_NONE, MBSR_NONE, "next is 0 of -1");
    times[2] = 0.05;
    assert_refused(mbsr_ida_run(ida, 4, times, &next, keep, &found), error, MBSR_ERR_VALUE,
                   MBSR_NONE, MBSR_NONE, "times[2] is 0.05|behind the time before");
    times[2] = NAN;
    assert_refused(mbsr_ida_run(ida, 4, times, &next, keep, &found), error, MBSR_ERR_VALUE,
                   MBSR_NONE, MBSR_NONE, "times[2] is nan, not finite");
    assert_int_equal(found.count, 0);
    assert_int_equal(problem_stats(ida).steps, 0);
    /* the direction of time is that of the run */
    assert_ok(mbsr_ida_advance(ida, 0.25, NULL, NULL, NULL), error);
    times[2] = 0.2;
    assert_refused(mbsr_ida_run(ida, 4, times, &next, keep, &found), error, MBSR_ERR_VALUE,
                   MBSR_NONE, MBSR_NONE, "times[0] is 0, behind");
    next = found.count = 3;
    assert_ok(mbsr_ida_run(ida, 4, times, &next, keep, &found), error);
    assert_true(found.t[3] == 0.3);
    mbsr_ida_destroy(ida);
    problem_free(&s.p);
}

/* ---- between two steps ---- */

typedef struct watcher {
    const mbsr_ida *ida;
    long calls, every; /* every: steps between two calls that are expected */
    long stop_every;   /* returns `code` in each such call; 0: never */
    int code;
    mbsr_ida_progress last;
} watcher;

static int watch(void *user, const mbsr_ida_progress *now)
{
    watcher *w = user;
    ++w->calls;
    assert_int_equal(now->steps, w->last.steps + w->every);
    assert_true(now->step > 0.0 ? now->t > w->last.t : now->t < w->last.t);
    if (w->every == 1) assert_close(now->t - w->last.t, now->step, 1e-14);
    assert_in_range(now->order, 1, 5);
    w->last = *now;
    if (w->ida) {
        const mbsr_ida_stats stats = problem_stats(w->ida);
        assert_int_equal(stats.steps, now->steps);
        assert_int_equal(stats.last_order, now->order);
        assert_true(stats.last_step == now->step);
    }
    return w->stop_every > 0 && w->calls % w->stop_every == 0 ? w->code : 0;
}

static mbsr_ida_opt watched(watcher *w, mbsr_ida_opt opt)
{
    opt.progress = watch;
    opt.progress_user = w;
    opt.progress_steps = w->every;
    return opt;
}

static void progress_is_reported_between_steps(void **state)
{
    (void)state;
    const long every[] = {1, 3, 10};
    for (int f = 0; f < 4; ++f) {
        setting s = make_setting((mbsr_dae_form)f);
        double y[6], whole[6];
        mbsr_ida *ida = begin(&s, problem_opt());
        assert_ok(mbsr_ida_advance(ida, 2.0, NULL, whole, NULL), mbsr_ida_error(ida));
        const mbsr_ida_stats stats = problem_stats(ida);
        mbsr_ida_destroy(ida);
        for (int k = 0; k < 6; ++k) {
            watcher w = {.every = every[k % 3]};
            ida = begin(&s, watched(&w, problem_opt()));
            w.ida = ida;
            /* where output is asked for does not change the reports */
            for (int j = 1; k > 2 && j <= 100; ++j) {
                assert_ok(mbsr_ida_advance(ida, 0.02 * j, NULL, y, NULL), mbsr_ida_error(ida));
            }
            assert_ok(mbsr_ida_advance(ida, 2.0, NULL, y, NULL), mbsr_ida_error(ida));
            assert_memory_equal(y, whole, (size_t)s.size * sizeof *y);
            mbsr_ida_stats found = problem_stats(ida);
            /* the index-1 form looks for turned references up to each output time */
            if (s.form == MBSR_DAE_INDEX1) found.events = stats.events;
            assert_same_stats(found, stats);
            /* none after the last step */
            assert_int_equal(w.calls, (stats.steps - 1) / w.every);
            /* a new run counts anew */
            w.last = (mbsr_ida_progress){0};
            assert_ok(mbsr_ida_start(ida, 0.0, s.y, s.yp), mbsr_ida_error(ida));
            assert_ok(mbsr_ida_advance(ida, -1.0, NULL, NULL, NULL), mbsr_ida_error(ida));
            assert_int_equal(w.last.steps / w.every, (problem_stats(ida).steps - 1) / w.every);
            mbsr_ida_destroy(ida);
        }
        problem_free(&s.p);
    }
}

/* Stops every so many calls; the run goes on from there without a trace, events included. */
static void a_stopped_run_goes_on(void **state)
{
    (void)state;
    const int codes[] = {5, -5, MBSR_EVENT, MBSR_ERR_SOLVER};
    for (int run = 0; run < 8; ++run) {
        setting s = make_setting(run % 2 ? MBSR_DAE_MOMENTUM : MBSR_DAE_RECURSIVE);
        double t = NAN, y[6], yp[6], dky[6], whole[6];
        long stops = 0;
        int events = 0, whole_events = 0, status = MBSR_OK;
        mbsr_ida *ida = begin(&s, with_event());
        while (mbsr_ida_advance(ida, 3.0, NULL, whole, NULL) == MBSR_EVENT) ++whole_events;
        const mbsr_ida_stats stats = problem_stats(ida);
        mbsr_ida_destroy(ida);

        watcher w = {.every = 2, .stop_every = 1 + run % 3, .code = codes[run / 2]};
        ida = begin(&s, watched(&w, with_event()));
        while ((status = mbsr_ida_advance(ida, 3.0, &t, y, yp)) != MBSR_OK) {
            int direction = 0;
            if (mbsr_ida_event_info(ida, &direction) == MBSR_OK) {
                assert_int_equal(status, MBSR_EVENT);
                ++events;
                continue;
            }
            assert_refused(status, mbsr_ida_error(ida), w.code, MBSR_NONE, MBSR_NONE,
                           "mbsr_ida_advance: the progress function at t = ");
            assert_int_equal(++stops, w.calls / w.stop_every);
            assert_true(t == w.last.t);
            assert_ok(mbsr_ida_dense(ida, t, 0, dky), mbsr_ida_error(ida));
            assert_close(y[0], dky[0], 1e-15);
            double again[6];
            assert_ok(mbsr_ida_state(ida, &t, again, NULL), mbsr_ida_error(ida));
            assert_memory_equal(again, y, (size_t)s.size * sizeof *y);
            assert_in_range(stops, 1, MOST_STEPS);
        }
        assert_true(t == 3.0);
        assert_int_equal(stops, w.calls / w.stop_every);
        assert_int_equal(w.calls, (stats.steps - 1) / 2);
        assert_int_equal(events, whole_events);
        assert_true(events == 2);
        assert_memory_equal(y, whole, (size_t)s.size * sizeof *y);
        assert_same_stats(problem_stats(ida), stats);
        mbsr_ida_destroy(ida);
        problem_free(&s.p);
    }
}

/* What follows a stop is not one: a failure is for good. */
static void after_a_stop_failures_are_failures(void **state)
{
    (void)state;
    problem p;
    probe observer = probe_passive();
    problem_oscillator(&p, &observer);
    watcher w = {.every = 5, .stop_every = 1, .code = 3};
    const mbsr_ida_opt opt = watched(&w, problem_opt());
    mbsr_ida *ida = problem_start(&p, &opt);
    double t = 7.0;
    assert_int_equal(mbsr_ida_advance(ida, 3.0, &t, NULL, NULL), 3);
    assert_true(t > 0.0 && t < 3.0);
    observer.fail_from = 0.0;
    observer.code = -8;
    t = 7.0;
    assert_refused(mbsr_ida_advance(ida, 3.0, &t, NULL, NULL), mbsr_ida_error(ida), -8, MBSR_NONE,
                   mbsr_model_forces(p.model) - 1, "mbsr_ida_advance: residual at t = ");
    assert_true(t == 7.0);
    assert_int_equal(mbsr_ida_advance(ida, 3.0, &t, NULL, NULL), MBSR_ERR_SEQUENCE);
    assert_ok(mbsr_ida_state(ida, &t, NULL, NULL), mbsr_ida_error(ida)); /* the last good one */
    assert_true(t > 0.0 && t < 3.0);
    mbsr_ida_destroy(ida);
    problem_free(&p);
}

static void a_run_over_output_times_is_stopped_and_goes_on(void **state)
{
    (void)state;
    static record expected, found;
    double times[TIMES];
    setting s = make_setting(MBSR_DAE_MOMENTUM);
    output_times(1.0, times);
    const mbsr_ida_stats stats = reference(&s, times, &expected);
    watcher w = {.every = 1, .stop_every = 1, .code = 9};
    mbsr_ida *ida = begin(&s, watched(&w, problem_opt()));
    found = (record){.size = s.size, .stop_at = -1};
    int next = 0, status = MBSR_OK;
    long stops = 0;
    while ((status = mbsr_ida_run(ida, TIMES, times, &next, keep, &found)) == 9) {
        double t = NAN;
        assert_ok(mbsr_ida_state(ida, &t, NULL, NULL), mbsr_ida_error(ida));
        assert_true(t == w.last.t && t < times[next]);
        assert_int_equal(next, found.count);
        assert_in_range(++stops, 1, MOST_STEPS);
    }
    assert_ok(status, mbsr_ida_error(ida));
    assert_int_equal(stops, stats.steps - 1);
    assert_same_record(&found, &expected);
    assert_same_stats(problem_stats(ida), stats);
    mbsr_ida_destroy(ida);
    problem_free(&s.p);
}

static int count_calls(void *user, const mbsr_ida_progress *now)
{
    (void)now;
    ++*(long *)user;
    return 0;
}

static void progress_may_be_limited_in_real_time(void **state)
{
    (void)state;
    const double interval[] = {1e6, 1e-12};
    setting s = make_setting(MBSR_DAE_RECURSIVE);
    for (int k = 0; k < 2; ++k) {
        long calls = 0;
        mbsr_ida_opt opt = problem_opt();
        opt.progress = count_calls;
        opt.progress_user = &calls;
        opt.progress_interval = interval[k];
        mbsr_ida *ida = begin(&s, opt);
        assert_ok(mbsr_ida_advance(ida, 2.0, NULL, NULL, NULL), mbsr_ida_error(ida));
        /* a picosecond passes between two steps, eleven days do not */
        assert_int_equal(calls, k ? problem_stats(ida).steps - 1 : 0);
        mbsr_ida_destroy(ida);
    }
    problem_free(&s.p);
}

static int rises(void *user, const mbsr_ida_progress *now)
{
    mbsr_ida_progress *last = user;
    assert_in_range(now->steps - last->steps, 1, 2);
    assert_true(now->step > 0.0 && now->t > last->t);
    assert_in_range(now->order, 1, 5);
    *last = *now;
    return 0;
}

/* A particle 10 m from the origin of a body without other inertia, which turns about it: in the
 * index-1 form IDA starts anew where the massless direction has turned away from its reference. */
static void steps_are_counted_on_where_ida_starts_anew(void **state)
{
    (void)state;
    problem p = {0};
    const mbsr_planar_frame zero = {0.0, 0.0, 0.0};
    const double q[3] = {0.0, 0.0, 0.0}, u[3] = {0.0, 0.0, 0.0};
    double y[6], yp[6];
    assert_ok(mbsr_model_create(NULL, &p.model, NULL), NULL);
    mbsr_body_def body = mbsr_default_body_def();
    body.joint = mbsr_joint_planar_free(zero, zero);
    body.inertia = mbsr_inertia_planar(1.0, (double[2]){10.0, 0.0}, 0.0);
    assert_ok(mbsr_model_add_body(p.model, &body, NULL), mbsr_model_error(p.model));
    const mbsr_force_def spring = mbsr_force_joint_spring(0, 2, 1.0, 1.0, 3.0);
    assert_ok(mbsr_model_add_force(p.model, &spring, NULL), mbsr_model_error(p.model));
    assert_ok(mbsr_model_finish(p.model), mbsr_model_error(p.model));
    assert_ok(mbsr_data_create(p.model, &p.data, NULL), NULL);
    mbsr_ida_progress last = {0};
    mbsr_ida_opt opt = problem_opt();
    opt.progress = rises;
    opt.progress_user = &last;
    opt.form = MBSR_DAE_INDEX1;
    mbsr_ida *ida = NULL;
    long since = 0;
    assert_ok(mbsr_dae_pack(p.model, p.data, opt.form, 0.0, q, u, y), mbsr_data_error(p.data));
    assert_ok(mbsr_dae_consistent(p.model, p.data, opt.form, 0.0, y, yp, NULL, NULL),
              mbsr_data_error(p.data));
    assert_ok(mbsr_ida_create(p.model, p.data, &opt, &ida, NULL), NULL);
    assert_ok(mbsr_ida_start(ida, 0.0, y, yp), mbsr_ida_error(ida));
    assert_ok(mbsr_ida_advance(ida, 4.0, NULL, y, NULL), mbsr_ida_error(ida));
    assert_close(y[2], 3.0 * (1.0 - exp(-4.0)), 1e-4);
    const long steps = problem_stats(ida).steps;
    assert_int_equal(IDAGetNumSteps(mbsr_ida_memory(ida), &since), IDA_SUCCESS);
    assert_true(since < steps);
    assert_int_equal(last.steps, steps - 1);
    mbsr_ida_destroy(ida);
    problem_free(&p);
}

static double seconds(void)
{
    struct timespec time = {0};
    timespec_get(&time, TIME_UTC);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

/* An event function that is slow: some 0.3 ms a step. */
static int slow(void *user, double t, const double *y, const double *yp, double *value)
{
    const double begun = seconds();
    (void)user;
    (void)t;
    (void)y;
    (void)yp;
    value[0] = 1.0;
    while (seconds() - begun < 3e-4) continue;
    return 0;
}

static void between_two_calls_passes_the_real_time_asked_for(void **state)
{
    (void)state;
    long calls = 0;
    setting s = make_setting(MBSR_DAE_RECURSIVE);
    mbsr_ida_opt opt = problem_opt();
    opt.progress = count_calls;
    opt.progress_user = &calls;
    opt.progress_interval = 5e-3;
    opt.events = 1;
    opt.event = slow;
    mbsr_ida *ida = begin(&s, opt);
    const double begun = seconds();
    assert_ok(mbsr_ida_advance(ida, 2.0, NULL, NULL, NULL), mbsr_ida_error(ida));
    const double passed = seconds() - begun;
    assert_less(3.0 * opt.progress_interval, passed);
    assert_true(calls >= 1);
    assert_true((double)calls <= passed / opt.progress_interval);
    mbsr_ida_destroy(ida);
    problem_free(&s.p);
}

static void wrong_options_are_refused(void **state)
{
    (void)state;
    setting s = make_setting(MBSR_DAE_RECURSIVE);
    const double no[] = {NAN, INFINITY, -1.0};
    mbsr_ida *ida = NULL;
    mbsr_error error = {0};
    mbsr_ida_opt opt = problem_opt();
    assert_true(opt.progress == NULL && opt.progress_steps == 1 && opt.progress_interval == 0.0);
    opt.progress_steps = 0;
    assert_refused(mbsr_ida_create(s.p.model, s.p.data, &opt, &ida, &error), &error, MBSR_ERR_VALUE,
                   MBSR_NONE, MBSR_NONE, "progress_steps is 0, must be positive");
    for (int k = 0; k < 3; ++k) {
        opt = problem_opt();
        opt.progress_interval = no[k];
        assert_refused(mbsr_ida_create(s.p.model, s.p.data, &opt, &ida, &error), &error,
                       MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE, "progress_interval is |not negative");
    }
    problem_free(&s.p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(output_comes_at_its_times),
        cmocka_unit_test(output_may_stop_the_run),
        cmocka_unit_test(events_end_a_run_that_goes_on),
        cmocka_unit_test(wrong_output_times_are_refused),
        cmocka_unit_test(progress_is_reported_between_steps),
        cmocka_unit_test(a_stopped_run_goes_on),
        cmocka_unit_test(after_a_stop_failures_are_failures),
        cmocka_unit_test(a_run_over_output_times_is_stopped_and_goes_on),
        cmocka_unit_test(steps_are_counted_on_where_ida_starts_anew),
        cmocka_unit_test(progress_may_be_limited_in_real_time),
        cmocka_unit_test(between_two_calls_passes_the_real_time_asked_for),
        cmocka_unit_test(wrong_options_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
