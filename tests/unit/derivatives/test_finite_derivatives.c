/* Derivatives of the dynamics: no number that is not finite with MBSR_OK.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "duration.h"
#include "finite.h"
#include "rigid_tree.h"

#include <string.h>

enum { T = 1u << FINITE_T, Q = 1u << FINITE_Q, U = 1u << FINITE_U, TAU = 1u << FINITE_TAU };
enum { Y = 1u << FINITE_Y, YP = 1u << FINITE_YP };
enum { UDOT = 1u << FINITE_UDOT, R = 1u << FINITE_R, OTHER = 1u << FINITE_OTHER, MOST = 64 };

/* Of the last call of a batch, which ends with the call; else the object has it. */
static mbsr_error of_batch;

static const mbsr_error *why(const finite_subject *s)
{
    return of_batch.status ? &of_batch : mbsr_derivatives_error(s->object);
}

static int run_forward(finite_subject *s)
{
    of_batch.status = MBSR_OK;
    return mbsr_derivatives_forward(s->object, s->in[FINITE_T][0], s->in[FINITE_Q], s->in[FINITE_U],
                                    s->in[FINITE_TAU], s->out[0], NULL);
}

static int run_inverse(finite_subject *s)
{
    of_batch.status = MBSR_OK;
    return mbsr_derivatives_inverse(s->object, s->in[FINITE_T][0], s->in[FINITE_Q], s->in[FINITE_U],
                                    s->in[FINITE_UDOT], s->out[0]);
}

static int run_tangent(finite_subject *s)
{
    return mbsr_derivatives_tangent(s->object, s->in[FINITE_R], s->in[FINITE_R],
                                    s->in[FINITE_OTHER], s->out[0], NULL);
}

static int run_adjoint(finite_subject *s)
{
    return mbsr_derivatives_adjoint(s->object, s->in[FINITE_R], NULL, s->out[0], s->out[1],
                                    s->out[2]);
}

static int run_matrices(finite_subject *s)
{
    return mbsr_derivatives_matrices(s->object, s->out[0], s->out[1], s->out[2]);
}

/* ---- batches of one state ---- */

static mbsr_derivatives_batch *open_batch(const finite_subject *s)
{
    mbsr_derivatives_batch *batch = NULL;
    of_batch.status = MBSR_OK;
    if (s->object)
        assert_int_equal(mbsr_derivatives_batch_create(s->model, NULL, &batch, NULL), MBSR_OK);
    return batch;
}

static int close_batch(mbsr_derivatives_batch *batch, int status)
{
    if (batch && status) of_batch = *mbsr_derivatives_batch_error(batch);
    mbsr_derivatives_batch_destroy(batch);
    return status;
}

static int run_batch_tangent(finite_subject *s)
{
    mbsr_derivatives_batch *b = open_batch(s);
    double **in = s->in;
    return close_batch(b, mbsr_derivatives_batch_tangent(
                              b, in[FINITE_T][0], 1, in[FINITE_Q], in[FINITE_U], in[FINITE_TAU],
                              in[FINITE_R], in[FINITE_R], in[FINITE_OTHER], NULL, s->out[0], NULL));
}

static int run_batch_adjoint(finite_subject *s)
{
    mbsr_derivatives_batch *b = open_batch(s);
    double **in = s->in;
    return close_batch(b, mbsr_derivatives_batch_adjoint(
                              b, in[FINITE_T][0], 1, in[FINITE_Q], in[FINITE_U], in[FINITE_TAU],
                              in[FINITE_R], NULL, s->out[0], s->out[1], s->out[2], NULL));
}

static int run_batch_matrices(finite_subject *s)
{
    mbsr_derivatives_batch *b = open_batch(s);
    double **in = s->in;
    return close_batch(b, mbsr_derivatives_batch_matrices(b, in[FINITE_T][0], 1, in[FINITE_Q],
                                                          in[FINITE_U], in[FINITE_TAU], NULL,
                                                          s->out[0], s->out[1], s->out[2], NULL));
}

/* As many parameters as the model has rates are chosen before. */
static int run_parameter_tangent(finite_subject *s)
{
    return mbsr_derivatives_parameter_tangent(s->object, s->in[FINITE_R], s->out[0], NULL);
}

static int run_parameter_adjoint(finite_subject *s)
{
    return mbsr_derivatives_parameter_adjoint(s->object, s->in[FINITE_R], NULL, s->out[0]);
}

static int choose_and_run_forward(finite_subject *s)
{
    mbsr_parameters *list;
    int which[MOST], status = mbsr_parameters_create(s->model, &list, NULL);
    for (int k = 0; k < s->nu; ++k) which[k] = 3 * k;
    if (!status) status = mbsr_derivatives_parameters(s->object, list, s->nu, which);
    mbsr_parameters_destroy(list);
    return status ? status : run_forward(s);
}

static int size_of_y(const finite_subject *s)
{
    return mbsr_dae_size(s->model, MBSR_DAE_MOMENTUM);
}

static int run_residual(finite_subject *s)
{
    of_batch.status = MBSR_OK;
    return mbsr_derivatives_residual(s->object, s->in[FINITE_T][0], s->in[FINITE_Y],
                                     s->in[FINITE_YP], s->out[0]);
}

static int choose_and_run_residual(finite_subject *s)
{
    const int status = choose_and_run_forward(s);
    return status ? status : run_residual(s);
}

static int run_residual_tangent(finite_subject *s)
{
    double **in = s->in;
    return mbsr_derivatives_residual_tangent(s->object, in[FINITE_R], in[FINITE_R],
                                             in[FINITE_OTHER], s->out[0]);
}

static int run_residual_adjoint(finite_subject *s)
{
    return mbsr_derivatives_residual_adjoint(s->object, s->in[FINITE_R], s->out[0], s->out[1],
                                             s->out[2]);
}

static int of_y(const finite_subject *s, int o)
{
    return o == 0 ? size_of_y(s) : 0;
}

static int of_y_and_parameters(const finite_subject *s, int o)
{
    return o < 2 ? size_of_y(s) : s->nu;
}

static int of_matrices(const finite_subject *s, int o)
{
    (void)o;
    return s->nu * s->nu;
}

static int of_rates(const finite_subject *s, int o)
{
    return o == 0 ? s->nu : 0;
}

static int of_all(const finite_subject *s, int o)
{
    (void)o;
    return s->nu;
}

static const finite_row rows[] = {
    {"mbsr_derivatives_create", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_derivatives_destroy", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_derivatives_data", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_derivatives_error", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_derivatives_forward", run_forward, NULL, 0, T | Q | U | TAU, FINITE_OBJECT, of_rates},
    {"mbsr_derivatives_inverse", run_inverse, NULL, 0, T | Q | U | UDOT, FINITE_OBJECT, of_rates},
    {"mbsr_derivatives_tangent", run_tangent, run_forward, T | Q | U | TAU, R | OTHER,
     FINITE_OBJECT, of_rates},
    {"mbsr_derivatives_adjoint", run_adjoint, run_forward, T | Q | U | TAU, R, FINITE_OBJECT,
     of_all},
    {"mbsr_derivatives_matrices", run_matrices, run_forward, T | Q | U | TAU, 0, FINITE_OBJECT,
     of_matrices},
    {"mbsr_derivatives_batch_create", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_derivatives_batch_destroy", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_derivatives_batch_failed", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_derivatives_batch_error", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_derivatives_batch_tangent", run_batch_tangent, NULL, 0, T | Q | U | TAU | R | OTHER, 0,
     of_rates},
    {"mbsr_derivatives_batch_adjoint", run_batch_adjoint, NULL, 0, T | Q | U | TAU | R, 0, of_all},
    {"mbsr_derivatives_batch_matrices", run_batch_matrices, NULL, 0, T | Q | U | TAU, 0,
     of_matrices},
    {"mbsr_derivatives_parameters", NULL, NULL, 0, 0, 0, NULL},
    {"mbsr_derivatives_parameter_tangent", run_parameter_tangent, choose_and_run_forward,
     T | Q | U | TAU, R, FINITE_OBJECT, of_rates},
    {"mbsr_derivatives_parameter_adjoint", run_parameter_adjoint, choose_and_run_forward,
     T | Q | U | TAU, R, FINITE_OBJECT, of_rates},
    {"mbsr_derivatives_residual", run_residual, NULL, 0, T | Y | YP, FINITE_OBJECT, of_y},
    {"mbsr_derivatives_residual_tangent", run_residual_tangent, choose_and_run_residual,
     T | Q | U | TAU | Y | YP, R | OTHER, FINITE_OBJECT, of_y},
    {"mbsr_derivatives_residual_adjoint", run_residual_adjoint, choose_and_run_residual,
     T | Q | U | TAU | Y | YP, R, FINITE_OBJECT, of_y_and_parameters},
};
enum { ROWS = sizeof rows / sizeof rows[0] };

static void trees_of_rigid_bodies(void **unused)
{
    (void)unused;
    int served[ROWS] = {0};
    for (int k = 0; k < 2; ++k) {
        const test_rigid_choice choice = {.seed = 31 + (uint64_t)k,
                                          .bodies = test_seeds(4, 5),
                                          .many = 0.3,
                                          .branching = 0.5,
                                          .length = 1.0,
                                          .forces = k % 2,
                                          .moving = k == 1};
        test_rigid_tree tree;
        test_rigid_tree_make(&tree, choice);
        finite_subject s = {.name = "a tree", .model = tree.model, .data = tree.data, .error = why};
        mbsr_derivatives *derivatives;
        double x[MOST];
        test_rng rng = test_seed(7);
        s.nq = mbsr_model_nq(tree.model);
        s.nu = mbsr_model_nu(tree.model);
        assert_ok(mbsr_derivatives_create(tree.model, &derivatives, NULL), NULL);
        s.object = derivatives;
        finite_give(&s, FINITE_T, 1, (double[]){0.3});
        finite_give(&s, FINITE_Q, s.nq, tree.q);
        const finite_input of_nu[] = {FINITE_U, FINITE_TAU, FINITE_UDOT, FINITE_R, FINITE_OTHER};
        for (int l = 0; l < 5; ++l) {
            const int n = of_nu[l] == FINITE_R ? size_of_y(&s) : s.nu;
            test_fill(&rng, n, x);
            finite_give(&s, of_nu[l], n, x);
        }
        test_fill(&rng, size_of_y(&s), x);
        finite_give(&s, FINITE_YP, size_of_y(&s), x);
        memcpy(x, tree.q, (size_t)s.nq * sizeof *x);
        finite_give(&s, FINITE_Y, size_of_y(&s), x);
        for (int l = 0; l < ROWS; ++l) served[l] += finite_try(&s, rows + l);
        mbsr_derivatives_destroy(derivatives);
        finite_free(&s);
        test_rigid_tree_free(&tree);
    }
    for (int l = 0; l < ROWS; ++l) assert_true(!rows[l].run || served[l] > 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(trees_of_rigid_bodies)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
