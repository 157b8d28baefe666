/* The Newton solver, batches and the test of force elements: no number that is not finite with
 * MBSR_OK.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "duration.h"
#include "finite.h"
#include "mixed.h"
#include "rigid_tree.h"
#include "twins.h"

#include <mbsrank/driver.h>
#include <mbsrank/verify.h>

enum { T = 1u << FINITE_T, C = 1u << FINITE_C, Q = 1u << FINITE_Q, U = 1u << FINITE_U };
enum { TAU = 1u << FINITE_TAU, UDOT = 1u << FINITE_UDOT, Y = 1u << FINITE_Y };
enum { YP = 1u << FINITE_YP, R = 1u << FINITE_R, MOST = 128, STATES = 5 };

static double time_of(const finite_subject *s)
{
    return s->in[FINITE_T][0];
}

static const mbsr_error *newton_error(const finite_subject *s)
{
    return mbsr_newton_error(s->object);
}

static const mbsr_error *batch_error(const finite_subject *s)
{
    return mbsr_batch_error(s->object);
}

/* ---- calls ---- */

static int factor(finite_subject *s)
{
    return mbsr_newton_factor(s->object, s->data, time_of(s), s->in[FINITE_Y], s->in[FINITE_YP],
                              s->in[FINITE_C][0]);
}

static int run_solve(finite_subject *s)
{
    return mbsr_newton_solve(s->object, s->in[FINITE_R], s->out[0]);
}

/* yp need not be read: a factorisation is judged by what it solves. */
static int run_factor_and_solve(finite_subject *s)
{
    const int status = factor(s);
    return status ? status : run_solve(s);
}

static int linearise(finite_subject *s)
{
    return mbsr_newton_linearise(s->object, s->data, time_of(s), s->in[FINITE_Y], s->in[FINITE_YP],
                                 s->in[FINITE_C][0]);
}

static int run_multiply(finite_subject *s)
{
    return mbsr_newton_multiply(s->object, s->in[FINITE_R], s->out[0]);
}

static int run_solve_transposed(finite_subject *s)
{
    return mbsr_newton_solve_transposed(s->object, s->in[FINITE_R], s->out[0]);
}

static int run_multiply_transposed(finite_subject *s)
{
    return mbsr_newton_multiply_transposed(s->object, s->in[FINITE_R], s->out[0]);
}

static int run_multiply_torque(finite_subject *s)
{
    return mbsr_newton_multiply_torque(s->object, s->in[FINITE_TAU], s->out[0]);
}

static int run_multiply_rate(finite_subject *s)
{
    return mbsr_newton_multiply_rate(s->object, s->in[FINITE_R], s->out[0]);
}

static int run_solve_sensitivity(finite_subject *s)
{
    return mbsr_newton_solve_sensitivity(s->object, s->in[FINITE_TAU], s->in[FINITE_R], s->out[0]);
}

static int run_solve_adjoint(finite_subject *s)
{
    return mbsr_newton_solve_adjoint(s->object, s->in[FINITE_R], s->out[1], s->out[0]);
}

static int run_linearise_and_multiply(finite_subject *s)
{
    const int status = linearise(s);
    return status ? status : run_multiply(s);
}

static int run_batch_forward(finite_subject *s)
{
    int status[STATES];
    return mbsr_batch_forward_dynamics(s->model, s->object, time_of(s), STATES, s->in[FINITE_Q],
                                       s->in[FINITE_U], s->in[FINITE_TAU], s->out[0], status);
}

static int run_batch_inverse(finite_subject *s)
{
    return mbsr_batch_inverse_dynamics(s->model, s->object, time_of(s), STATES, s->in[FINITE_Q],
                                       s->in[FINITE_U], s->in[FINITE_UDOT], s->out[0], NULL);
}

static int velocities(finite_subject *s)
{
    const int status = mbsr_stage_positions(s->model, s->data, time_of(s), s->in[FINITE_Q]);
    return status ? status : mbsr_stage_velocities(s->model, s->data, s->in[FINITE_U]);
}

static const mbsr_error *completion_error(const finite_subject *s)
{
    return mbsr_completion_error(s->object);
}

/* y and y' are completed where they stand. */
static int run_complete(finite_subject *s)
{
    double y[MOST], yp[MOST];
    const size_t size = (size_t)(s->nq + 2 * s->nu) * sizeof *y;
    const bool there = s->in[FINITE_Y] && s->out[0];
    if (there) memcpy(y, s->in[FINITE_Y], size);
    const int status = mbsr_completion_solve(s->object, s->data, MBSR_DAE_MOMENTUM, time_of(s),
                                             there ? y : NULL, yp);
    if (!status) memcpy(s->out[0], y, size);
    return status;
}

static int run_complete_dynamics(finite_subject *s)
{
    return mbsr_completion_dynamics(s->object, s->data, time_of(s), s->in[FINITE_Q],
                                    s->in[FINITE_U], s->in[FINITE_TAU], s->out[0], NULL);
}

static int of_rates(const finite_subject *s, int o)
{
    return o == 0 ? s->nu : 0;
}

static int run_force_verify(finite_subject *s)
{
    mbsr_force_errors errors;
    const int status = mbsr_force_verify(s->model, s->data, 0, s->out[0] ? &errors : NULL);
    if (!status && s->out[0]) s->out[0][0] = errors.largest;
    return status;
}

static int of_y(const finite_subject *s, int o)
{
    return o == 0 ? s->nq + 2 * s->nu : 0;
}

static int of_y_and_u(const finite_subject *s, int o)
{
    return o == 0 ? s->nq + 2 * s->nu : o == 1 ? s->nu : 0;
}

static int of_states(const finite_subject *s, int o)
{
    return o == 0 ? STATES * s->nu : 0;
}

static int of_one(const finite_subject *s, int o)
{
    (void)s;
    return o == 0;
}

static const finite_row newton_rows[] = {
    {"mbsr_default_newton_opt", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_newton_create", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_newton_destroy", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_newton_get_info", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_newton_error", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_newton_factor", run_factor_and_solve, NULL, 0, T | C | Y | YP,
     FINITE_OBJECT | FINITE_DATA, of_y},
    {"mbsr_newton_solve", run_solve, factor, T | C | Y, R, FINITE_OBJECT, of_y},
    {"mbsr_newton_linearise", run_linearise_and_multiply, NULL, 0, T | C | Y | YP,
     FINITE_OBJECT | FINITE_DATA, of_y},
    {"mbsr_newton_multiply_torque", run_multiply_torque, linearise, T | C | Y, TAU, FINITE_OBJECT,
     of_y},
    {"mbsr_newton_multiply_rate", run_multiply_rate, linearise, T | C | Y, R, FINITE_OBJECT, of_y},
    {"mbsr_newton_solve_sensitivity", run_solve_sensitivity, factor, T | C | Y, TAU | R,
     FINITE_OBJECT, of_y},
    {"mbsr_newton_solve_adjoint", run_solve_adjoint, factor, T | C | Y, R, FINITE_OBJECT,
     of_y_and_u},
    {"mbsr_newton_multiply", run_multiply, linearise, T | C | Y, R, FINITE_OBJECT, of_y},
    {"mbsr_newton_multiply_transposed", run_multiply_transposed, linearise, T | C | Y, R,
     FINITE_OBJECT, of_y},
    {"mbsr_newton_solve_transposed", run_solve_transposed, factor, T | C | Y, R, FINITE_OBJECT,
     of_y},
};

static const finite_row completion_rows[] = {
    {"mbsr_completion_create", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_completion_destroy", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_completion_set_times", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_completion_motion", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_completion_relax", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_completion_get_info", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_completion_error", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_completion_solve", run_complete, NULL, 0, T | Y, FINITE_OBJECT | FINITE_DATA, of_y},
    {"mbsr_completion_dynamics", run_complete_dynamics, NULL, 0, T | Q | U | TAU,
     FINITE_OBJECT | FINITE_DATA, of_rates},
};

static const finite_row batch_rows[] = {
    {"mbsr_batch_create", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_batch_create_parallel", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_batch_destroy", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_threads_create", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_threads_destroy", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_threads_parallel", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_split_create", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_split_destroy", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_split_tasks", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_data_use_split", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_batch_lanes", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_batch_failed", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_batch_one_by_one", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_batch_error", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_batch_forward_dynamics", run_batch_forward, NULL, 0, T | Q | U | TAU,
     FINITE_OBJECT | FINITE_MODEL, of_states},
    {"mbsr_batch_inverse_dynamics", run_batch_inverse, NULL, 0, T | Q | U | UDOT,
     FINITE_OBJECT | FINITE_MODEL, of_states},
};

static const finite_row verify_rows[] = {
    {"mbsr_force_verify", run_force_verify, velocities, T | Q | U, 0, FINITE_MODEL | FINITE_DATA,
     of_one},
};

enum {
    NEWTON_ROWS = sizeof newton_rows / sizeof newton_rows[0],
    TREE_ROWS = NEWTON_ROWS - 1, /* all but transposed solutions, for which it is not created */
    COMPLETION_ROWS = sizeof completion_rows / sizeof completion_rows[0],
    BATCH_ROWS = sizeof batch_rows / sizeof batch_rows[0]
};

static int newton_served[NEWTON_ROWS], completion_served[COMPLETION_ROWS], batch_served[BATCH_ROWS],
    verified;

static finite_subject subject(const char *name, mbsr_model *model, mbsr_data *data, int states,
                              const double *q)
{
    finite_subject s = {.name = name, .model = model, .data = data, .form = MBSR_DAE_MOMENTUM};
    double x[STATES * MOST];
    s.nq = mbsr_model_nq(model);
    s.nu = mbsr_model_nu(model);
    const int size = s.nq + 2 * s.nu;
    assert_true(size <= MOST);
    test_rng rng = test_seed(73);
    finite_give(&s, FINITE_T, 1, (double[]){0.3});
    finite_give(&s, FINITE_C, 1, (double[]){40.0});
    const int n[] = {states * s.nq, states * s.nu, states * s.nu, states * s.nu, size, size, size};
    for (int k = FINITE_Q; k <= FINITE_R; ++k) {
        test_fill(&rng, n[k - FINITE_Q], x);
        for (int l = 0; l < s.nq && q && (k == FINITE_Q || k == FINITE_Y); ++l) {
            for (int state = 0; state < (k == FINITE_Q ? states : 1); ++state)
                x[state * s.nq + l] = q[l];
        }
        finite_give(&s, (finite_input)k, n[k - FINITE_Q], x);
    }
    return s;
}

static void try_all(const char *name, mbsr_model *model, mbsr_data *data, const double *q)
{
    finite_subject s = subject(name, model, data, STATES, q);
    mbsr_newton *newton;
    mbsr_batch *batch;
    for (int by_blocks = 0; by_blocks < 2; ++by_blocks) {
        mbsr_newton_opt opt = mbsr_default_newton_opt();
        opt.transposes = by_blocks; /* which go by blocks */
        opt.products = 1;
        assert_ok(mbsr_newton_create(model, MBSR_DAE_MOMENTUM, &opt, &newton, NULL), NULL);
        s.object = newton;
        s.error = newton_error;
        for (int k = 0; k < (by_blocks ? NEWTON_ROWS : TREE_ROWS); ++k)
            newton_served[k] += finite_try(&s, newton_rows + k);
        mbsr_newton_destroy(newton);
    }
    mbsr_completion *completion;
    assert_ok(mbsr_completion_create(model, NULL, &completion, NULL), NULL);
    s.object = completion;
    s.error = completion_error;
    for (int k = 0; k < COMPLETION_ROWS; ++k)
        completion_served[k] += finite_try(&s, completion_rows + k);
    mbsr_completion_destroy(completion);
    assert_ok(mbsr_batch_create(model, &batch, NULL), NULL);
    s.object = batch;
    s.error = batch_error;
    for (int k = 0; k < BATCH_ROWS; ++k) batch_served[k] += finite_try(&s, batch_rows + k);
    mbsr_batch_destroy(batch);
    s.error = NULL;
    verified += finite_try(&s, verify_rows);
    finite_free(&s);
}

static void mixed_trees(void **unused)
{
    (void)unused;
    for (int k = 0; k < MIXED_SCENES; ++k) {
        mixed s;
        mixed_make(&s, (mixed_scene)k);
        try_all("mixed", s.model, s.data, NULL);
        mixed_free(&s);
    }
}

static void trees_of_rigid_bodies(void **unused)
{
    (void)unused;
    for (int k = test_long() ? 0 : 3; k < 4; ++k) { /* the last has everything */
        const test_rigid_choice choice = {.seed = 21 + (uint64_t)k,
                                          .bodies = 4 + k,
                                          .massless = k < 2 ? 0.0 : 0.3,
                                          .many = 0.3,
                                          .branching = 0.5,
                                          .length = 1.0,
                                          .forces = k % 2,
                                          .moving = k == 3,
                                          .shuffle = k % 2};
        test_rigid_tree tree;
        test_rigid_tree_make(&tree, choice);
        try_all("a tree of rigid bodies", tree.model, tree.data, tree.q);
        test_rigid_tree_free(&tree);
    }
}

static void a_massless_bead(void **unused)
{
    (void)unused;
    twins s;
    twins_make(&s, 1.0);
    try_all("two pendulums on a bead", s.model, s.data, NULL);
    twins_free(&s);
}

static void each_function_served(void **unused)
{
    (void)unused;
    for (int k = 0; k < NEWTON_ROWS; ++k) {
        if (newton_rows[k].run && newton_served[k] == 0)
            fail_msg("%s was never MBSR_OK", newton_rows[k].function);
    }
    for (int k = 0; k < COMPLETION_ROWS; ++k) {
        if (completion_rows[k].run && completion_served[k] == 0)
            fail_msg("%s was never MBSR_OK", completion_rows[k].function);
    }
    for (int k = 0; k < BATCH_ROWS; ++k) {
        if (batch_rows[k].run && batch_served[k] == 0)
            fail_msg("%s was never MBSR_OK", batch_rows[k].function);
    }
    assert_true(verified > 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(mixed_trees),
        cmocka_unit_test(trees_of_rigid_bodies),
        cmocka_unit_test(a_massless_bead),
        cmocka_unit_test(each_function_served),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
