/* The component linear: no number that is not finite with MBSR_OK.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "finite.h"

#include <mbsrank/linear.h>

enum { T = 1u << FINITE_T, C = 1u << FINITE_C, Q = 1u << FINITE_Q, U = 1u << FINITE_U };

static mbsr_error last;

static const mbsr_error *why(const finite_subject *s)
{
    (void)s;
    return &last;
}

static mbsr_linear *linear;

static int create(finite_subject *s)
{
    static const mbsr_signal first = {.kind = MBSR_SIGNAL_JOINT};
    mbsr_linear_opt opt = mbsr_default_linear_opt();
    opt.inputs = opt.outputs = 1;
    opt.input = opt.output = &first;
    mbsr_linear_destroy(linear);
    return mbsr_linear_create(s->model, s->data, s->in[FINITE_T][0], s->in[FINITE_Q],
                              s->in[FINITE_U], &opt, s->out[0] ? &linear : NULL, &last);
}

static int run_create(finite_subject *s)
{
    linear = NULL;
    const int status = create(s);
    if (status) return status;
    const double *A = mbsr_linear_matrix(linear, MBSR_LINEAR_AR, NULL, NULL);
    for (int k = 0; k < 4; ++k) s->out[0][k] = A[k];
    mbsr_linear_destroy(linear);
    linear = NULL;
    return status;
}

static int run_response(finite_subject *s)
{
    linear = NULL;
    int status = create(s);
    double im;
    if (!status) status = mbsr_linear_response(linear, s->in[FINITE_C][0], s->out[0], &im);
    if (status)
        last = (mbsr_error){status, MBSR_NONE, MBSR_NONE, "mbsr_linear_response: the frequency"};
    mbsr_linear_destroy(linear);
    linear = NULL;
    return status;
}

static int run_equilibrium(finite_subject *s)
{
    return mbsr_equilibrium(s->model, s->data, s->in[FINITE_T][0], s->in[FINITE_Q], NULL, s->out[0],
                            NULL, NULL, &last);
}

static int run_near(finite_subject *s)
{
    mbsr_mode mode[20];
    int found;
    const int status = mbsr_modes_near(s->model, s->data, s->in[FINITE_T][0], s->in[FINITE_Q], NULL,
                                       mode, s->out[0] ? &found : NULL, NULL, NULL, &last);
    if (status == MBSR_OK) s->out[0][0] = mode[0].real;
    return status;
}

static int run_participation(finite_subject *s)
{
    const mbsr_mode mode = {.imaginary = 1.0};
    return mbsr_mode_participation(s->model, s->data, s->in[FINITE_T][0], s->in[FINITE_Q], &mode,
                                   s->in[FINITE_U], NULL, s->out[0], NULL, NULL, &last);
}

static int of_states(const finite_subject *s, int o)
{
    (void)s;
    return o == 0 ? 4 : 0;
}

static int of_one(const finite_subject *s, int o)
{
    (void)s;
    return o == 0;
}

static const finite_row rows[] = {
    {"mbsr_default_equilibrium_opt", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_default_linear_opt", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_default_near_opt", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_default_trim_opt", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_trim", NULL, NULL, 0, 0, 0, NULL}, /* test_trim.c */
    {"mbsr_linear_destroy", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_linear_get_info", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_linear_matrix", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_linear_modes", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_linear_shape", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_signal_find", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_linear_create", run_create, NULL, 0, T | Q | U, 0, of_states},
    {"mbsr_linear_response", run_response, NULL, 0, T | Q | U | C, 0, of_one},
    {"mbsr_modes_near", run_near, NULL, 0, T | Q, FINITE_MODEL | FINITE_DATA, of_one},
    {"mbsr_mode_participation", run_participation, NULL, 0, T | Q | U, FINITE_MODEL | FINITE_DATA,
     of_one},
    {"mbsr_equilibrium", run_equilibrium, NULL, 0, T | Q, FINITE_MODEL | FINITE_DATA, of_one},
};
enum { ROWS = sizeof rows / sizeof rows[0] };

static void an_oscillator(void **unused)
{
    (void)unused;
    mbsr_model *m;
    mbsr_data *d;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    mbsr_body_def b = mbsr_default_body_def();
    b.joint = mbsr_joint_prismatic(NULL, NULL, (const double[3]){1, 0, 0});
    b.inertia = mbsr_inertia_particle(2.0);
    assert_ok(mbsr_model_add_body(m, &b, NULL), NULL);
    const mbsr_force_def spring = mbsr_force_joint_spring(0, 0, 50.0, 1.0, 0.3);
    assert_ok(mbsr_model_add_force(m, &spring, NULL), NULL);
    assert_ok(mbsr_model_finish(m), NULL);
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    finite_subject s = {
        .name = "an oscillator", .model = m, .data = d, .nq = 1, .nu = 1, .error = why};
    finite_give(&s, FINITE_T, 1, (double[]){0.0});
    finite_give(&s, FINITE_C, 1, (double[]){1.5});
    finite_give(&s, FINITE_Q, 1, (double[]){0.3});
    finite_give(&s, FINITE_U, 1, (double[]){0.1});
    for (int k = 0; k < ROWS; ++k) assert_true(finite_try(&s, rows + k) > 0 || !rows[k].run);
    finite_free(&s);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(an_oscillator)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
