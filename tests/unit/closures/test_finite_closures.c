/* Closures: no number that is not finite with MBSR_OK.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "finite.h"
#include "loops.h"

#include <mbsrank/driver.h>
#include <mbsrank/verify.h>

enum { T = 1u << FINITE_T, Q = 1u << FINITE_Q, U = 1u << FINITE_U, R = 1u << FINITE_R };
enum { UDOT = 1u << FINITE_UDOT, BOTH = FINITE_MODEL | FINITE_DATA };

static int positions(finite_subject *s)
{
    return mbsr_stage_positions(s->model, s->data, s->in[FINITE_T][0], s->in[FINITE_Q]);
}

static int velocities(finite_subject *s)
{
    const int status = positions(s);
    return status ? status : mbsr_stage_velocities(s->model, s->data, s->in[FINITE_U]);
}

static int run_gap(finite_subject *s)
{
    return mbsr_closures_gap(s->model, s->data, s->out[0]);
}

static int run_rate(finite_subject *s)
{
    return mbsr_closures_rate(s->model, s->data, s->out[0]);
}

static int run_bias(finite_subject *s)
{
    return mbsr_closures_bias(s->model, s->data, s->out[0]);
}

static int run_apply(finite_subject *s)
{
    return mbsr_closures_apply(s->model, s->data, s->in[FINITE_UDOT], s->out[0]);
}

static int run_transpose(finite_subject *s)
{
    return mbsr_closures_transpose(s->model, s->data, s->in[FINITE_R], s->out[0]);
}

static int run_verify(finite_subject *s)
{
    mbsr_closure_errors e;
    const int status = mbsr_closure_verify(s->model, s->data, 0, s->out[0] ? &e : NULL);
    if (!status && s->out[0]) s->out[0][0] = e.jacobian + e.drift + e.bias;
    return status;
}

static int run_assemble(finite_subject *s)
{
    return mbsr_assemble(s->model, s->data, s->in[FINITE_T][0], s->in[FINITE_Q], NULL, s->out[0],
                         NULL);
}

static int run_report(finite_subject *s)
{
    mbsr_closure_report r;
    const int status = mbsr_closures_report(s->model, s->data, s->in[FINITE_T][0], s->in[FINITE_Q],
                                            s->out[0] ? &r : NULL, NULL, NULL);
    if (!status && s->out[0])
        s->out[0][0] = r.smallest_kept + r.largest_dropped + r.gap + r.weakest_pivot;
    return status;
}

static int run_load(finite_subject *s)
{
    int status = mbsr_closures_set_lambda(s->model, s->data, s->in[FINITE_R]);
    if (!status) status = mbsr_stage_forces(s->model, s->data, NULL);
    return status ? status : mbsr_closures_lambda(s->model, s->data, s->out[0]);
}

static int forces(finite_subject *s)
{
    const int status = velocities(s);
    return status ? status : mbsr_stage_forces(s->model, s->data, NULL);
}

static int run_force(finite_subject *s)
{
    return mbsr_closures_lambda(s->model, s->data, s->out[0]);
}

/* The distance is the second closure. */
static int run_reaction(finite_subject *s)
{
    return mbsr_closure_reaction(s->model, s->data, 1, 0, s->out[0], NULL);
}

static int run_point(finite_subject *s)
{
    return mbsr_closure_point(s->model, s->data, 1, s->out[0]);
}

static int run_inverse(finite_subject *s)
{
    int all[LOOPS_MOST];
    for (int k = 0; k < s->nu; ++k) all[k] = k;
    return loops_inverse_dynamics(s->model, s->data, s->in[FINITE_T][0], s->in[FINITE_Q],
                                  s->in[FINITE_U], s->in[FINITE_UDOT], s->nu, all, s->out[0],
                                  s->out[1]);
}

static int run_mobility(finite_subject *s)
{
    return mbsr_closures_mobility(s->model, s->data, s->out[0]);
}

static int run_kind(finite_subject *s)
{
    return mbsr_closure_row_kind(s->model, s->data, 1, NULL, s->out[0]);
}

static int of_inverse(const finite_subject *s, int o)
{
    return o == 0 ? s->nu : o == 1 ? mbsr_model_rows(s->model) : 0;
}

static int of_q(const finite_subject *s, int o)
{
    return o == 0 ? s->nq : 0;
}

static int of_held(const finite_subject *s, int o)
{
    return o == 0 ? mbsr_model_position_rows(s->model) : 0;
}

static int of_rows(const finite_subject *s, int o)
{
    return o == 0 ? mbsr_model_rows(s->model) : 0;
}

static int of_joints(const finite_subject *s, int o)
{
    return o == 0 ? s->nu : 0;
}

static int of_one(const finite_subject *s, int o)
{
    (void)s;
    return o == 0;
}

static int of_plane(const finite_subject *s, int o)
{
    (void)s;
    return o == 0 ? 3 : 0;
}

static const finite_row rows[] = {
    {"mbsr_default_closure_def", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_closure_weld", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_closure_ball", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_closure_rows", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_closure_body_rows", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_closure_distance", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_closure_coupling", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_closure_rolling_ball", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_closure_rolling_disc", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_closure_custom", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_model_add_closure", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_model_add_loop_joint", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_model_closures", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_model_rows", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_model_position_rows", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_closures_weight", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_model_find_closure", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_closure_indices", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_closure_name", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_closure_definition", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_closure_stiffness", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_force_closure", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_closure_mixture", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_default_assembly_opt", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_closure_of_row", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_closures_redundant", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_closures_set_redundant", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_assemble", run_assemble, NULL, 0, T | Q, BOTH, of_q},
    {"mbsr_closures_report", run_report, NULL, 0, T | Q, BOTH, of_one},
    {"mbsr_closures_mobility", run_mobility, positions, T | Q, 0, BOTH, of_joints},
    {"mbsr_closure_row_kind", run_kind, positions, T | Q, 0, BOTH, of_one},
    {"mbsr_closures_set_lambda", run_load, velocities, T | Q | U, R, BOTH, of_rows},
    {"mbsr_closures_lambda", run_force, forces, T | Q | U, 0, BOTH, of_rows},
    {"mbsr_closure_reaction", run_reaction, forces, T | Q | U, 0, BOTH, of_plane},
    {"mbsr_closure_point", run_point, positions, T | Q, 0, BOTH, of_plane},
    {"mbsr_inverse_dynamics", run_inverse, NULL, 0, T | Q | U | UDOT, BOTH, of_inverse},
    {"mbsr_closures_gap", run_gap, positions, T | Q, 0, BOTH, of_held},
    {"mbsr_closures_rate", run_rate, velocities, T | Q | U, 0, BOTH, of_rows},
    {"mbsr_closures_bias", run_bias, velocities, T | Q | U, 0, BOTH, of_rows},
    {"mbsr_closures_apply", run_apply, positions, T | Q, UDOT, BOTH, of_rows},
    {"mbsr_closure_verify", run_verify, velocities, T | Q | U, 0, BOTH, of_one},
    {"mbsr_closures_transpose", run_transpose, positions, T | Q, R, BOTH, of_joints},
};

/* Rods and a wheel in the plane, a pin, a distance, a coupling, and rolling on the ground. */
static void make(loops *s)
{
    const double up[3] = {0.0, 1.0, 0.0}, at[3] = {0.5, 0.0, 0.0};
    const mbsr_frame plane = mbsr_frame_along(NULL, up);
    loops_begin(s, NULL);
    const int a = loops_rod(s, "a", MBSR_GROUND, 0.0, 0.0, 1.0, 1.0);
    int b = loops_rod(s, "b", a, 1.0, 0.0, 1.0, 1.0);
    for (int k = 0; k < 6; ++k) b = loops_rod(s, "more", b, 1.0, 0.0, 1.0, 1.0);
    loops_pin(s, "pin", b, 1.0, 0.0, MBSR_GROUND, 0.5, 0.5);
    const mbsr_closure_def more[] = {
        mbsr_closure_distance(3, at, MBSR_GROUND, NULL, 1.0),
        mbsr_closure_coupling(2, (int[2]){a, b}, (int[2]){0, 0}, (double[2]){1.0, 2.0}, 0.1),
        mbsr_closure_rolling_ball(b, at, 0.2, MBSR_GROUND, &plane)};
    for (int k = 0; k < 3; ++k)
        assert_ok(mbsr_model_add_closure(s->m, more + k, NULL), mbsr_model_error(s->m));
    loops_finish(s);
}

static void rows_of_closures(void **state)
{
    (void)state;
    loops l;
    make(&l);
    double x[LOOPS_MOST];
    test_rng rng = test_seed(5);
    finite_subject s = {.name = "closures",
                        .model = l.m,
                        .data = l.d,
                        .nq = l.nq,
                        .nu = l.nu,
                        .form = MBSR_DAE_MOMENTUM};
    finite_give(&s, FINITE_T, 1, (double[]){0.3});
    const finite_input input[] = {FINITE_Q, FINITE_U, FINITE_UDOT, FINITE_R};
    const int n[] = {l.nq, l.nu, l.nu, l.rows};
    for (int k = 0; k < 4; ++k) {
        test_fill(&rng, n[k], x);
        finite_give(&s, input[k], n[k], x);
    }
    int served = 0, run = 0;
    for (size_t k = 0; k < sizeof rows / sizeof rows[0]; ++k) {
        served += finite_try(&s, rows + k);
        run += rows[k].run != NULL;
    }
    assert_int_equal(served, run);
    finite_free(&s);
    loops_free(&l);
}

/* Every number of a definition is looked at when it is added. */
static void numbers_of_definitions(void **state)
{
    (void)state;
    const double bad[] = {NAN, INFINITY, -INFINITY}, x[3] = {1.0, 0.0, 0.0};
    const mbsr_closure_def good[] = {mbsr_closure_weld(0, NULL, 1, NULL),
                                     mbsr_closure_ball(0, NULL, 1, NULL),
                                     mbsr_closure_rows(0, NULL, 1, NULL, 1, x),
                                     mbsr_closure_distance(0, NULL, 1, NULL, 1.0),
                                     mbsr_closure_coupling(1, (int[1]){0}, (int[1]){0}, x, 0.1),
                                     mbsr_closure_rolling_ball(0, NULL, 0.2, 1, NULL),
                                     mbsr_closure_rolling_disc(0, NULL, 0.2, 1, NULL)};
    loops s;
    loops_begin(&s, NULL);
    for (size_t k = 0; k < sizeof good / sizeof good[0]; ++k) {
        assert_ok(mbsr_model_add_closure(s.m, good + k, NULL), mbsr_model_error(s.m));
        for (int l = 0; l < 3; ++l) {
            mbsr_closure_def def;
            for (int i = 0; i < MBSR_CLOSURE_PARAMS; ++i) {
                def = good[k];
                def.param[i] = bad[l];
                assert_true(mbsr_model_add_closure(s.m, &def, NULL) != MBSR_OK);
            }
            for (int i = 0; i < MBSR_CLOSURE_ROWS; ++i) {
                def = good[k];
                def.stiffness[i] = bad[l];
                assert_refused(mbsr_model_add_closure(s.m, &def, NULL), mbsr_model_error(s.m),
                               MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE, "closure|stiffness");
                def.stiffness[i] = 1.0;
                def.damping[i] = bad[l];
                assert_refused(mbsr_model_add_closure(s.m, &def, NULL), mbsr_model_error(s.m),
                               MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE, "closure|damping");
            }
        }
    }
    loops_free(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(rows_of_closures),
                                       cmocka_unit_test(numbers_of_definitions)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
