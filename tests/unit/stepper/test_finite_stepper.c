/* The stepper: no number that is not finite with MBSR_OK.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "finite.h"
#include "loops.h"
#include "mixed.h"

enum { T = 1u << FINITE_T, Q = 1u << FINITE_Q, U = 1u << FINITE_U };
enum { Y = 1u << FINITE_Y, YP = 1u << FINITE_YP, MOST = 128 };

static const mbsr_error *stepper_error(const finite_subject *s)
{
    return mbsr_stepper_error(s->object);
}

static int get(finite_subject *s)
{
    double *out = s->out[0];
    return out ? mbsr_stepper_motion(s->object, out, out + 1, out + 1 + s->nq)
               : mbsr_stepper_motion(s->object, NULL, NULL, NULL);
}

static int start(finite_subject *s)
{
    return mbsr_stepper_start(s->object, s->in[FINITE_T][0], s->in[FINITE_Q], s->in[FINITE_U]);
}

static int run_start(finite_subject *s)
{
    const int status = start(s);
    return status ? status : get(s);
}

static int run_state(finite_subject *s)
{
    return mbsr_stepper_state(s->object, s->out[0], s->out[1], s->out[2]);
}

static int run_step(finite_subject *s)
{
    const int status = mbsr_stepper_step(s->object);
    return status ? status : get(s);
}

/* From 0 to t. */
static int run_to(finite_subject *s)
{
    int status = mbsr_stepper_start(s->object, 0.0, s->in[FINITE_Q], s->in[FINITE_U]);
    if (!status) status = mbsr_stepper_to(s->object, s->in[FINITE_T][0]);
    return status ? status : get(s);
}

/* And a step from there. */
static int run_resume(finite_subject *s)
{
    const int status =
        mbsr_stepper_resume(s->object, s->in[FINITE_T][0], s->in[FINITE_Y], s->in[FINITE_YP]);
    return status ? status : run_step(s);
}

static int run_jump(finite_subject *s)
{
    const int status = mbsr_stepper_jump(s->object);
    return status ? status : get(s);
}

static int of_get(const finite_subject *s, int o)
{
    return o == 0 ? 1 + s->nq + s->nu : 0;
}

static int of_state(const finite_subject *s, int o)
{
    return o == 0 ? 1 : mbsr_dae_size(s->model, MBSR_DAE_MOMENTUM);
}

static const finite_row rows[] = {
    {"mbsr_default_stepper_opt", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_stepper_create", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_stepper_destroy", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_stepper_get_info", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_stepper_error", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_stepper_start", run_start, NULL, 0, T | Q | U, FINITE_OBJECT, of_get},
    {"mbsr_stepper_motion", get, start, T | Q | U, 0, FINITE_OBJECT, of_get},
    {"mbsr_stepper_state", run_state, start, T | Q | U, 0, FINITE_OBJECT, of_state},
    {"mbsr_stepper_step", run_step, start, T | Q | U, 0, FINITE_OBJECT, of_get},
    {"mbsr_stepper_to", run_to, NULL, 0, T | Q | U, FINITE_OBJECT, of_get},
    {"mbsr_stepper_resume", run_resume, start, T | Q | U, Y | YP, FINITE_OBJECT, of_get},
    {"mbsr_stepper_jump", run_jump, start, T | Q | U, 0, FINITE_OBJECT, of_get},
};
enum { ROWS = sizeof rows / sizeof rows[0] };

static void try_all(const char *name, mbsr_model *model, mbsr_data *data, const double *q,
                    const double *u)
{
    finite_subject s = {.name = name, .model = model, .data = data, .error = stepper_error};
    mbsr_stepper *stepper;
    mbsr_stepper_opt opt = mbsr_default_stepper_opt();
    double y[MOST], yp[MOST];
    const int size = mbsr_dae_size(model, MBSR_DAE_MOMENTUM);
    assert_true(size <= MOST);
    opt.halvings = 1;
    s.nq = mbsr_model_nq(model);
    s.nu = mbsr_model_nu(model);
    assert_ok(mbsr_stepper_create(model, data, &opt, &stepper, NULL), NULL);
    assert_ok(mbsr_stepper_start(stepper, 0.3, q, u), mbsr_stepper_error(stepper));
    assert_ok(mbsr_stepper_state(stepper, NULL, y, yp), mbsr_stepper_error(stepper));
    s.object = stepper;
    finite_give(&s, FINITE_T, 1, (double[]){0.3});
    finite_give(&s, FINITE_Q, s.nq, q);
    finite_give(&s, FINITE_U, s.nu, u);
    finite_give(&s, FINITE_Y, size, y);
    finite_give(&s, FINITE_YP, size, yp);
    for (int k = 0; k < ROWS; ++k) {
        const int served = finite_try(&s, rows + k);
        if (rows[k].run) assert_int_equal(served, 1);
    }
    mbsr_stepper_destroy(stepper);
    finite_free(&s);
}

static void an_arm(void **unused)
{
    (void)unused;
    mixed s;
    double q[MIXED_NQ], u[MIXED_NU];
    test_rng rng = test_seed(73);
    mixed_make(&s, MIXED_ARM);
    test_fill(&rng, s.nq, q);
    test_fill(&rng, s.nu, u);
    try_all("an arm", s.model, s.data, q, u);
    mixed_free(&s);
}

static void a_four_bar(void **unused)
{
    (void)unused;
    loops s;
    loops_begin(&s, NULL);
    const int a = loops_rod(&s, "crank", MBSR_GROUND, 0.0, 0.0, 1.0, 1.0),
              b = loops_rod(&s, "coupler", a, 1.0, 0.0, 0.0, 2.5),
              c = loops_rod(&s, "rocker", MBSR_GROUND, 2.0, 0.0, 2.0, 2.0);
    loops_pin(&s, "pin", b, 2.5, 0.0, c, 2.0, 0.0);
    loops_finish(&s);
    s.q[0] = 1.2, s.q[1] = -0.9, s.q[2] = 1.3;
    try_all("a four-bar", s.m, s.d, s.q, s.u);
    loops_free(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(an_arm), cmocka_unit_test(a_four_bar)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
