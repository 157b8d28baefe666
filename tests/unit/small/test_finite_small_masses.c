/* Reports on small masses: refusals with names, no number that is not finite, verdicts, memory.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "counting.h"
#include "expect.h"
#include "finite.h"

#include <math.h>
#include <stdlib.h>

enum {
    T = 1u << FINITE_T,
    Q = 1u << FINITE_Q,
    U = 1u << FINITE_U,
    Y = 1u << FINITE_Y,
    YP = 1u << FINITE_YP,
    CARTS = 3
};

/* Carts on the ground in a row, the first small: 1 (100 N/m, 3 N s/m) 2 (4 N/m) 3. */
static mbsr_model *carts(const mbsr_allocator *allocator, double small, double spring)
{
    mbsr_model_def def = mbsr_default_model_def();
    mbsr_model *m = NULL;
    if (allocator) def.allocator = *allocator;
    assert_ok(mbsr_model_create(&def, &m, NULL), NULL);
    mbsr_body_def body = mbsr_default_body_def();
    body.joint = mbsr_joint_point((mbsr_planar_frame){0}, MBSR_X, 0, NULL, NULL);
    static const char *const name[CARTS] = {"doubtful", "middle", "last"};
    for (int k = 0; k < CARTS; ++k) {
        body.name = name[k];
        body.inertia = mbsr_inertia_particle(k == 0 ? small : 1.0 + k);
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    }
    const mbsr_force_def force[] = {mbsr_force_axis_spring(0, 1, 0, spring, 0.03 * spring, 0.0),
                                    mbsr_force_axis_spring(1, 2, 0, 4.0, 0.0, 0.0),
                                    mbsr_force_axis_spring(2, MBSR_GROUND, 0, 9.0, 0.0, 0.0)};
    for (int k = 0; k < 3; ++k)
        assert_ok(mbsr_model_add_force(m, force + k, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    return m;
}

static mbsr_small_masses_opt options(void)
{
    mbsr_small_masses_opt opt = mbsr_default_small_masses_opt();
    opt.duration = 5.0;
    return opt;
}

static const double q0[CARTS] = {0.1, 0.1, 0.05}, u0[CARTS] = {0.0, 0.2, 0.0};

/* ---- numbers that are not finite ---- */

static const mbsr_error *small_error(const finite_subject *s)
{
    return mbsr_small_masses_error(s->object);
}

static int begin(finite_subject *s)
{
    return mbsr_small_masses_start(s->object, 0.0, q0, u0);
}

static int run_start(finite_subject *s)
{
    mbsr_small_masses_report report;
    int status =
        mbsr_small_masses_start(s->object, s->in[FINITE_T][0], s->in[FINITE_Q], s->in[FINITE_U]);
    if (!status) status = mbsr_small_masses_get_report(s->object, &report);
    if (!status && s->out[0]) s->out[0][0] = report.error + report.steps + report.share;
    return status;
}

static int run_step(finite_subject *s)
{
    mbsr_small_masses_report report;
    int status =
        mbsr_small_masses_step(s->object, s->in[FINITE_T][0], s->in[FINITE_Y], s->in[FINITE_YP]);
    if (!status) status = mbsr_small_masses_get_report(s->object, &report);
    if (!status && s->out[0])
        s->out[0][0] = report.error + report.share + report.steps + report.mass[0].amplitude;
    return status;
}

static int run_state(finite_subject *s)
{
    return mbsr_small_masses_state(s->object, s->out[0], s->out[1], s->out[2]);
}

static int run_smooth(finite_subject *s)
{
    return mbsr_small_masses_smooth(s->object, 2, s->out[0], s->out[1]);
}

static int of_one(const finite_subject *s, int o)
{
    (void)s;
    return o == 0 ? 1 : 0;
}

static int of_state(const finite_subject *s, int o)
{
    (void)s;
    return o == 0 ? 1 : 3 * CARTS;
}

static int of_smooth(const finite_subject *s, int o)
{
    (void)s;
    return o < 2 ? CARTS : 0;
}

static const finite_row rows[] = {
    {"mbsr_small_masses_start", run_start, NULL, 0, T | Q | U, FINITE_OBJECT, of_one},
    {"mbsr_small_masses_step", run_step, begin, 0, T | Y | YP, FINITE_OBJECT, of_one},
    {"mbsr_small_masses_state", run_state, begin, 0, 0, FINITE_OBJECT, of_state},
    {"mbsr_small_masses_smooth", run_smooth, begin, 0, 0, FINITE_OBJECT, of_smooth},
};
enum { ROWS = sizeof rows / sizeof rows[0] };

/* These write structures and texts, looked at below and in test_ida_small_masses.c. */
static const char *const others[] = {
    "mbsr_default_small_masses_opt", "mbsr_small_verdict_text",   "mbsr_small_masses_create",
    "mbsr_small_masses_destroy",     "mbsr_small_masses_reduced", "mbsr_small_masses_get_report",
    "mbsr_small_masses_error",       "mbsr_small_masses_run",     "mbsr_simulation_watch_masses",
    "mbsr_simulation_get_masses",
};

static void every_function(void **unused)
{
    (void)unused;
    const mbsr_small_masses_opt opt = options();
    mbsr_model *m = carts(NULL, 1e-3, 100.0);
    mbsr_small_masses *small;
    double y[3 * CARTS], yp[3 * CARTS], t;
    assert_ok(mbsr_small_masses_create(m, &opt, &small, NULL), NULL);
    assert_ok(mbsr_small_masses_start(small, 0.0, q0, u0), mbsr_small_masses_error(small));
    assert_ok(mbsr_small_masses_state(small, &t, y, yp), NULL);
    for (int k = 0; k < ROWS; ++k) {
        finite_subject s = {.name = "carts", .object = small, .error = small_error};
        finite_give(&s, FINITE_T, 1, (double[]){0.1});
        finite_give(&s, FINITE_Q, CARTS, q0);
        finite_give(&s, FINITE_U, CARTS, u0);
        finite_give(&s, FINITE_Y, 3 * CARTS, y);
        finite_give(&s, FINITE_YP, 3 * CARTS, yp);
        assert_int_equal(finite_try(&s, rows + k), 1);
        finite_free(&s);
    }
    for (size_t k = 0; k < sizeof others / sizeof others[0]; ++k)
        assert_int_equal(strncmp(others[k], "mbsr_", 5), 0);
    mbsr_small_masses_destroy(small);
    mbsr_model_destroy(m);
}

/* ---- refusals ---- */

static void refused(const mbsr_model *m, const mbsr_small_masses_opt *opt, int status, int body,
                    const char *words)
{
    mbsr_small_masses *small = (mbsr_small_masses *)&small;
    mbsr_error error = {0};
    assert_refused(mbsr_small_masses_create(m, opt, &small, &error), &error, status, body,
                   MBSR_NONE, words);
    assert_null(small);
}

static void refusals_name_the_field(void **unused)
{
    (void)unused;
    mbsr_model *m = carts(NULL, 1e-3, 100.0), *copy;
    mbsr_small_masses_opt opt = mbsr_default_small_masses_opt();
    refused(m, &opt, MBSR_ERR_VALUE, MBSR_NONE, "duration is 0");
    opt = options();
    opt.cookie = 0;
    refused(m, &opt, MBSR_ERR_NO_DEFAULT, MBSR_NONE, "mbsr_default_small_masses_opt");
    opt = options();
    opt.tolerance = -1.0;
    refused(m, &opt, MBSR_ERR_VALUE, MBSR_NONE, "tolerance is -1");
    opt = options();
    opt.atol = NAN;
    refused(m, &opt, MBSR_ERR_VALUE, MBSR_NONE, "atol is nan");
    opt = options();
    opt.outputs = 2;
    refused(m, &opt, MBSR_ERR_VALUE, MBSR_NONE, "outputs is 2");
    opt = options();
    opt.tolerance_each = (const double[CARTS]){1.0, 0.0, 1.0};
    refused(m, &opt, MBSR_ERR_VALUE, MBSR_NONE, "tolerance of outputs is 0");
    opt = options();
    opt.parts = 1;
    refused(m, &opt, MBSR_ERR_VALUE, MBSR_NONE, "parts is 1");
    opt.part = &(mbsr_small_part){7, MBSR_MASS};
    refused(m, &opt, MBSR_ERR_ID, MBSR_NONE, "part[0].body is 7");
    opt.part = &(mbsr_small_part){0, MBSR_MOMENT};
    refused(m, &opt, MBSR_ERR_VALUE, 0, "'doubtful'|part[0].parts is 2");
    opt = options();
    refused(NULL, &opt, MBSR_ERR_NULL, MBSR_NONE, "NULL");
    refused(m, NULL, MBSR_ERR_NULL, MBSR_NONE, "NULL");
    assert_ok(mbsr_model_copy(m, &copy, NULL), NULL);
    refused(copy, &opt, MBSR_ERR_UNFINISHED, MBSR_NONE, "not finished");
    mbsr_model_destroy(copy);
    mbsr_model_destroy(m);
}

static void what_needs_a_start_says_so(void **unused)
{
    (void)unused;
    const mbsr_small_masses_opt opt = options();
    mbsr_model *m = carts(NULL, 1e-3, 100.0);
    mbsr_small_masses *small;
    mbsr_small_masses_report report;
    double y[3 * CARTS] = {0.0}, q[CARTS], u[CARTS], t;
    assert_ok(mbsr_small_masses_create(m, &opt, &small, NULL), NULL);
    const mbsr_error *e = mbsr_small_masses_error(small);
    assert_refused(mbsr_small_masses_get_report(small, &report), e, MBSR_ERR_SEQUENCE, -2, -2,
                   "mbsr_small_masses_start first");
    assert_refused(mbsr_small_masses_step(small, 1.0, y, y), e, MBSR_ERR_SEQUENCE, -2, -2, "start");
    assert_refused(mbsr_small_masses_smooth(small, 1, q, u), e, MBSR_ERR_SEQUENCE, -2, -2, "start");
    assert_int_equal(mbsr_small_masses_state(small, &t, y, y), MBSR_ERR_SEQUENCE);
    assert_null(mbsr_small_masses_reduced(small));
    assert_null(mbsr_small_masses_reduced(NULL));
    assert_ok(mbsr_small_masses_start(small, 0.0, q0, u0), e);
    assert_refused(mbsr_small_masses_smooth(small, 3, q, u), e, MBSR_ERR_VALUE, -2, -2,
                   "order is 3");
    assert_refused(mbsr_small_masses_step(small, 0.0, y, y), e, MBSR_ERR_VALUE, -2, -2,
                   "t is 0, not later");
    mbsr_small_masses_destroy(small);
    mbsr_model_destroy(m);
}

/* ---- verdicts ---- */

/* The report on carts with a first mass and spring. */
static mbsr_small_verdict verdict(double small_mass, double spring, const char *words)
{
    mbsr_small_masses_opt opt = options();
    opt.part = &(mbsr_small_part){0, MBSR_MASS};
    opt.parts = 1;
    mbsr_model *m = carts(NULL, small_mass, spring);
    mbsr_small_masses *small;
    mbsr_small_masses_report report;
    assert_ok(mbsr_small_masses_create(m, &opt, &small, NULL), NULL);
    assert_ok(mbsr_small_masses_start(small, 0.0, q0, u0), mbsr_small_masses_error(small));
    assert_ok(mbsr_small_masses_get_report(small, &report), mbsr_small_masses_error(small));
    assert_int_equal(report.masses, 1);
    assert_contains(report.text, "doubtful|mass");
    assert_contains(report.text, words);
    const mbsr_small_verdict result = report.mass[0].verdict;
    mbsr_small_masses_destroy(small);
    mbsr_model_destroy(m);
    return result;
}

static void verdicts(void **unused)
{
    (void)unused;
    assert_int_equal(verdict(1e-4, 100.0, "may be zero"), MBSR_SMALL_MAY_BE_ZERO);
    assert_int_equal(verdict(1.0, 100.0, "may not be zero"), MBSR_SMALL_MAY_NOT_BE_ZERO);
    assert_int_equal(verdict(1e-4, 0.0, "would be undetermined"), MBSR_SMALL_UNDETERMINED);
}

static int gap(void *user, double t, const double *q, const double *u, double *value)
{
    (void)user, (void)t, (void)u;
    value[0] = 1000.0 * (q[1] - q[0]); /* mm */
    return MBSR_OK;
}

/* m z'' / k of the gap in mm: the cart follows the next one, whose acceleration is known. */
static void outputs_have_their_own_unit(void **unused)
{
    (void)unused;
    mbsr_small_masses_opt opt = options();
    opt.outputs = 1;
    opt.output = gap;
    mbsr_model *m = carts(NULL, 1e-3, 100.0);
    mbsr_small_masses *small;
    mbsr_small_masses_report report;
    assert_ok(mbsr_small_masses_create(m, &opt, &small, NULL), NULL);
    assert_ok(mbsr_small_masses_start(small, 0.0, q0, u0), mbsr_small_masses_error(small));
    assert_ok(mbsr_small_masses_get_report(small, &report), mbsr_small_masses_error(small));
    assert_int_equal(report.masses, 1);
    assert_int_equal(report.mass[0].body, 0);
    assert_close(report.mass[0].ratio, 1e-3 / 2.0, 1e-15);
    assert_int_equal(report.direction[0].body, 0);
    assert_close(report.direction[0].inertia, 1e-3, 1e-9);
    /* the damper takes the next cart of 2 kg along: k + c d - (c d)^2 / (M c^2) */
    assert_close(report.direction[0].stiffness, 100.0 - 3.0 * 3.0 / 2.0, 0.3);
    assert_close(report.direction[0].damping, 3.0, 0.01);
    assert_true(report.factorisations <= 5);
    assert_int_equal(report.output, 0);
    mbsr_small_masses_destroy(small);
    mbsr_model_destroy(m);
}

static void the_memory_of_a_report_is_the_model_s(void **unused)
{
    (void)unused;
    test_counting counting = {0};
    const mbsr_allocator allocator = test_counting_allocator(&counting);
    const mbsr_small_masses_opt opt = options();
    mbsr_model *m = carts(&allocator, 1e-3, 100.0);
    const long live = counting.live;
    mbsr_small_masses *small = NULL;
    mbsr_error error;
    int failures = 0;
    for (long k = 1; !small; ++k) {
        counting.fail_at = counting.calls + k;
        const int status = mbsr_small_masses_create(m, &opt, &small, &error);
        assert_true((status == MBSR_ERR_NO_MEMORY) == (small == NULL));
        if (status) assert_int_equal(counting.live, live);
        failures += status != 0;
    }
    counting.fail_at = 0;
    assert_in_range(failures, 10, 300);
    assert_ok(mbsr_small_masses_start(small, 0.0, q0, u0), mbsr_small_masses_error(small));
    mbsr_small_masses_destroy(small);
    assert_int_equal(counting.live, live);
    mbsr_model_destroy(m);
    assert_int_equal(counting.live, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_function),
        cmocka_unit_test(refusals_name_the_field),
        cmocka_unit_test(what_needs_a_start_says_so),
        cmocka_unit_test(verdicts),
        cmocka_unit_test(outputs_have_their_own_unit),
        cmocka_unit_test(the_memory_of_a_report_is_the_model_s),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
