/* The vectorised sweeps of rigid bodies in space against the stages, which know nothing of them,
 * for every kind of processor that this machine can run.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"
#include "sweeps/build.h"
#include "kernels.h"
#include "rigid_tree.h"
#include "assembly/data.h"
#include "model/query.h"
#include "recursion/forward.h"
#include "recursion/inverse.h"
#include "sweeps/dynamics.h"

#include <mbsrank/driver.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

static double largest(int n, const double *x)
{
    double most = 0.0;
    for (int k = 0; k < n; ++k) most = fmax(most, fabs(x[k]));
    return most;
}

static double distance(int n, const double *a, const double *b)
{
    double most = 0.0;
    for (int k = 0; k < n; ++k) most = fmax(most, fabs(a[k] - b[k]));
    return most;
}

#if defined(TEST_SAME_BITS)
static uint64_t bits; /* of all accelerations, one after the other */

/* From all kernels the same bits; the first of them leave theirs in `first`. */
static void compare_bits(int kernel, int n, const double *udot, double *first)
{
    if (kernel > 0) {
        assert_memory_equal(udot, first, (size_t)n * sizeof *udot);
        return;
    }
    memcpy(first, udot, (size_t)n * sizeof *udot);
    for (int k = 0; k < n; ++k) {
        uint64_t one;
        memcpy(&one, udot + k, sizeof one);
        bits = (bits ^ one) * 1099511628211u;
    }
}
#endif

/* Forward dynamics by the sweeps and by the stages; returns whether the sweeps served. */
static bool compare(test_rigid_tree *s, double tolerance)
{
    const mbsri_sweep_kernels *list[2];
    bool fast = false;
    const int status =
        mbsri_forward_by_stages(s->model, s->data, s->t, s->q, s->u, s->tau, s->expected);
    assert_true(status == MBSR_OK || status == MBSR_UNDETERMINED);
    int *rank = malloc(((size_t)mbsr_model_bodies(s->model) + 1) * sizeof *rank);
    for (int i = 1; i <= s->model->bodies; ++i) rank[i] = s->data->rank[i];
    for (int k = 0; k < test_kernels(list); ++k) {
        test_use_kernels(s->model, list[k]);
        mbsri_data_poison(s->data);
        fast = !mbsri_sweeps_forward_dynamics(s->model, s->data, s->t, s->q, s->u, s->tau, s->udot);
        if (!fast) break;
        assert_true(distance(s->nu, s->udot, s->expected) <=
                    tolerance * (1.0 + largest(s->nu, s->expected)));
        for (int i = 1; i <= s->model->bodies; ++i) assert_int_equal(s->data->rank[i], rank[i]);
#if defined(TEST_SAME_BITS)
        compare_bits(k, s->nu, s->udot, s->expected);
#endif
    }
    free(rank);
    return fast;
}

static void regular_trees_agree_with_the_stages(void **state)
{
    (void)state;
    int served = 0;
    for (int k = 0; k < 200; ++k) {
        test_rigid_tree s;
        test_rigid_tree_make(&s, (test_rigid_choice){.seed = 100 + (uint64_t)k,
                                                     .bodies = 1 + k % 23,
                                                     .many = k % 2 ? 0.3 : 0.0,
                                                     .branching = 0.25 * (k % 4),
                                                     .armature = 0.3 * (k % 3),
                                                     .length = k % 3 ? 1.0 : 1000.0});
        const bool fast = compare(&s, 1e-9);
        served += fast;
        test_rigid_tree_free(&s);
    }
    print_message("%d of 200 trees served\n", served);
#if defined(TEST_SAME_BITS)
    print_message("bits %016llx\n", (unsigned long long)bits);
#endif
    assert_int_equal(served, 200);
}

static void trees_with_massless_bodies_agree_where_they_are_served(void **state)
{
    (void)state;
    int served = 0, trees = 400;
    for (int k = 0; k < trees; ++k) {
        test_rigid_tree s;
        test_rigid_tree_make(&s, (test_rigid_choice){.seed = 1000 + (uint64_t)k,
                                                     .bodies = 2 + k % 15,
                                                     .armature = k % 7 == 6 ? 0.4 : 0.0,
                                                     .massless = 0.4 * (k % 3),
                                                     .points = 0.3 * (k % 2),
                                                     .many = k % 5 ? 0.0 : 0.2,
                                                     .branching = 0.3 * (k % 4),
                                                     .length = 1.0});
        served += compare(&s, 1e-7);
        test_rigid_tree_free(&s);
    }
    print_message("%d of %d trees served\n", served, trees);
    assert_true(served > trees / 2);
}

static void compare_inverse(test_rigid_tree *s)
{
    const mbsri_sweep_kernels *list[2];
    const int count = test_kernels(list);
    assert_ok(mbsr_stage_positions(s->model, s->data, s->t, s->q), mbsr_data_error(s->data));
    assert_ok(mbsr_stage_velocities(s->model, s->data, s->u), mbsr_data_error(s->data));
    assert_ok(mbsr_stage_forces(s->model, s->data, NULL), mbsr_data_error(s->data));
    mbsri_inverse(s->model, s->data, s->tau);
    mbsri_scatter(s->model, s->data->out, s->expected);
    for (int l = 0; l < count; ++l) {
        test_use_kernels(s->model, list[l]);
        mbsri_data_poison(s->data);
        assert_true(
            !mbsri_sweeps_inverse_dynamics(s->model, s->data, s->t, s->q, s->u, s->tau, s->udot));
        assert_true(distance(s->nu, s->udot, s->expected) <=
                    1e-12 * (1.0 + largest(s->nu, s->expected)));
    }
}

/* The residual of a form at random y, y', with and without the sweeps. */
static void compare_residuals(test_rigid_tree *s, mbsr_dae_form form, uint64_t seed, int *served)
{
    const mbsri_sweep_kernels *list[2];
    const int size = mbsr_dae_size(s->model, form), nq = s->nq, nu = s->nu;
    double *y = malloc(4 * (size_t)size * sizeof *y), *yp = y + size, *F = yp + size,
           *expected = F + size;
    test_rng rng = test_seed(seed);
    assert_ok(mbsr_dae_pack(s->model, s->data, form, s->t, s->q, s->u, y),
              mbsr_data_error(s->data));
    for (int k = 0; k < nu; ++k) y[nq + k] += test_uniform(&rng);
    test_fill(&rng, size, yp);
    const test_hidden trees = test_hide_sweeps(s->model);
    assert_ok(mbsr_dae_residual(s->model, s->data, form, s->t, y, yp, expected),
              mbsr_data_error(s->data));
    test_show_sweeps(s->model, trees);
    for (int k = 0; k < test_kernels(list); ++k) {
        test_use_kernels(s->model, list[k]);
        mbsri_data_poison(s->data);
        if ((form == MBSR_DAE_MOMENTUM
                 ? mbsri_sweeps_momentum_residual
                 : mbsri_sweeps_inverse_residual)(s->model, s->data, s->t, y, yp, F))
            break;
        *served += k == 0;
        for (int l = 0; l < (size - nq) / (nu > 0 ? nu : 1) + 1; ++l) {
            const int first = l == 0 ? 0 : nq + (l - 1) * nu, n = l == 0 ? nq : nu;
            assert_true(distance(n, F + first, expected + first) <=
                        1e-10 * (1.0 + largest(n, expected + first)));
        }
    }
    free(y);
}

/* Any element on any body, a root that moves, ids in another order. */
static void forces_roots_and_orders_agree(void **state)
{
    (void)state;
    int served = 0, momentum = 0, inverse = 0;
    for (int k = 0; k < 200; ++k) {
        test_rigid_tree s;
        test_rigid_tree_make(&s, (test_rigid_choice){.seed = 7000 + (uint64_t)k,
                                                     .bodies = 1 + k % 17,
                                                     .armature = k % 4 < 2 ? 0.5 : 0.0,
                                                     .massless = k % 4 ? 0.0 : 0.2,
                                                     .many = k % 2 ? 0.2 : 0.0,
                                                     .branching = 0.25 * (k % 4),
                                                     .length = 1.0,
                                                     .forces = k % 3,
                                                     .moving = k % 5 == 0,
                                                     .shuffle = k % 7 < 3});
        served += compare(&s, 1e-8);
        compare_residuals(&s, MBSR_DAE_MOMENTUM, (uint64_t)k, &momentum);
        compare_residuals(&s, MBSR_DAE_INVERSE_DYNAMICS, (uint64_t)k, &inverse);
        compare_inverse(&s);
        test_rigid_tree_free(&s);
    }
    print_message("%d of 200 trees served\n", served);
    assert_true(served > 180 && momentum > 180 && inverse == 200);
}

/* Bodies that float along the axes of the root; with a root that moves, and beside elements. */
static void floating_bodies_agree(void **state)
{
    (void)state;
    int served = 0, momentum = 0, inverse = 0;
    for (int k = 0; k < 120; ++k) {
        test_rigid_tree s;
        test_rigid_tree_make(&s, (test_rigid_choice){.seed = 11000 + (uint64_t)k,
                                                     .bodies = 1 + k % 11,
                                                     .armature = 0.4 * (k % 3),
                                                     .massless = k % 4 ? 0.0 : 0.2,
                                                     .points = k % 6 ? 0.0 : 0.3,
                                                     .many = k % 2 ? 0.2 : 0.0,
                                                     .branching = 0.25 * (k % 4),
                                                     .floating = 1,
                                                     .length = k % 5 ? 1.0 : 100.0,
                                                     .forces = k % 3,
                                                     .moving = k % 10 == 9,
                                                     .shuffle = k % 7 < 3});
        const mbsri_sweep_body *first = s.model->tree.plain->body + 1;
        if (first->flags & MBSRI_MULTI)
            assert_int_equal((first->flags & MBSRI_FREE) != 0, k % 10 != 9);
        served += compare(&s, 1e-8);
        compare_residuals(&s, MBSR_DAE_MOMENTUM, (uint64_t)k, &momentum);
        compare_residuals(&s, MBSR_DAE_INVERSE_DYNAMICS, (uint64_t)k, &inverse);
        compare_inverse(&s);
        test_rigid_tree_free(&s);
    }
    print_message("%d, %d and %d of 120 trees served\n", served, momentum, inverse);
    assert_true(served > 100 && momentum > 100 && inverse == 120);
}

static void inverse_dynamics_agrees(void **state)
{
    (void)state;
    for (int k = 0; k < 200; ++k) {
        test_rigid_tree s;
        test_rigid_tree_make(&s, (test_rigid_choice){.seed = 5000 + (uint64_t)k,
                                                     .bodies = 1 + k % 23,
                                                     .armature = 0.4 * (k % 3),
                                                     .massless = 0.2 * (k % 3),
                                                     .points = 0.2,
                                                     .many = k % 2 ? 0.3 : 0.0,
                                                     .branching = 0.25 * (k % 4),
                                                     .length = 1.0});
        compare_inverse(&s);
        test_rigid_tree_free(&s);
    }
}

static void the_momentum_form_agrees(void **state)
{
    (void)state;
    int served = 0;
    for (int k = 0; k < 300; ++k) {
        test_rigid_tree s;
        test_rigid_tree_make(&s, (test_rigid_choice){.seed = 9000 + (uint64_t)k,
                                                     .bodies = 1 + k % 19,
                                                     .armature = k % 5 == 4 ? 0.5 : 0.0,
                                                     .massless = 0.2 * (k % 4),
                                                     .points = 0.2 * (k % 2),
                                                     .many = k % 3 ? 0.0 : 0.3,
                                                     .branching = 0.25 * (k % 4),
                                                     .length = 1.0});
        compare_residuals(&s, MBSR_DAE_MOMENTUM, (uint64_t)k, &served);
        test_rigid_tree_free(&s);
    }
    print_message("%d of 300 trees served\n", served);
    assert_true(served > 250);
}

/* Lean data gives the same numbers to the last digit, and says what it cannot do. */
static void lean_data_serves_the_same(void **state)
{
    (void)state;
    test_rigid_tree s;
    test_rigid_tree_make(
        &s, (test_rigid_choice){.seed = 77, .bodies = 40, .branching = 0.3, .length = 1.0});
    mbsr_data *lean;
    assert_ok(mbsr_data_create_lean(s.model, &lean, NULL), NULL);
    mbsri_data_poison(lean);
    assert_true(mbsr_data_size_lean(s.model) * 5 < mbsr_data_size(s.model));
    assert_ok(mbsr_forward_dynamics(s.model, s.data, s.t, s.q, s.u, s.tau, s.expected),
              mbsr_data_error(s.data));
    assert_ok(mbsr_forward_dynamics(s.model, lean, s.t, s.q, s.u, s.tau, s.udot),
              mbsr_data_error(lean));
    assert_true(distance(s.nu, s.udot, s.expected) == 0.0);
    assert_ok(mbsr_inverse_dynamics(s.model, lean, s.t, s.q, s.u, s.expected, NULL, s.udot),
              mbsr_data_error(lean));
    assert_true(distance(s.nu, s.udot, s.tau) < 1e-10);
    assert_ok(mbsr_bias_forces(s.model, lean, s.t, s.q, s.u, s.udot), mbsr_data_error(lean));
    double pose[MBSR_POSE_SIZE];
    assert_refused(mbsr_body_pose(s.model, lean, 0, pose), mbsr_data_error(lean), MBSR_ERR_LEAN,
                   MBSR_NONE, MBSR_NONE, "full data");
    assert_refused(mbsr_stage_positions(s.model, lean, s.t, s.q), mbsr_data_error(lean),
                   MBSR_ERR_LEAN, MBSR_NONE, MBSR_NONE, "mbsr_data_create_lean");
    s.q[0] = NAN;
    assert_int_equal(mbsr_forward_dynamics(s.model, lean, s.t, s.q, s.u, s.tau, s.udot),
                     MBSR_NOT_FINITE);
    mbsr_data_destroy(lean);
    test_rigid_tree_free(&s);
}

static int no_number(void *user, double t, double *s, double *sdot, double *sddot)
{
    (void)user, (void)t;
    s[0] = sdot[0] = 0.0;
    sddot[0] = NAN;
    return 0;
}

/* Also where the motion that is not a number moves nothing that counts. */
static void a_prescribed_motion_that_is_no_number_is_refused(void **state)
{
    (void)state;
    mbsr_model *m;
    mbsr_data *d;
    const double axis[3] = {0.0, 1.0, 0.0};
    const mbsr_axis driven = {
        .kind = MBSR_AXIS_ROTATION, .direction = {1.0, 0.0, 0.0}, .driven = 1};
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    mbsr_body_def body = mbsr_default_body_def();
    body.joint = mbsr_joint_revolute(NULL, NULL, axis);
    body.inertia = mbsr_inertia_point_mass(1.0, (double[3]){1.0, 0.0, 0.0});
    assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    body = mbsr_default_body_def();
    body.parent = 0;
    body.joint = mbsr_joint_compound(NULL, NULL, 1, &driven, no_number, NULL);
    assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    const double zero[1] = {0.0};
    double out[1];
    assert_int_equal(mbsr_inverse_dynamics(m, d, 0.0, zero, zero, zero, NULL, out),
                     MBSR_NOT_FINITE);
    assert_int_equal(mbsr_forward_dynamics(m, d, 0.0, zero, zero, NULL, out), MBSR_NOT_FINITE);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

/* What the stages hold after a call that did not run them. */
static void results_can_be_asked_for_after_every_call(void **state)
{
    (void)state;
    test_rigid_tree s;
    double pose[2][MBSR_POSE_SIZE], A[2][6];
    mbsr_rank_info info;
    test_rigid_tree_make(
        &s, (test_rigid_choice){
                .seed = 78, .bodies = 12, .many = 0.3, .branching = 0.3, .length = 1.0});
    assert_ok(mbsr_forward_dynamics(s.model, s.data, s.t, s.q, s.u, s.tau, s.udot),
              mbsr_data_error(s.data));
    assert_int_equal(mbsr_total_rank(s.model, s.data), s.nu);
    assert_ok(mbsr_body_rank(s.model, s.data, 5, &info), mbsr_data_error(s.data));
    assert_int_equal(info.rank, info.n);
    assert_ok(mbsr_forward_dynamics(s.model, s.data, s.t, s.q, s.u, s.tau, s.udot),
              mbsr_data_error(s.data));
    assert_ok(mbsr_body_pose(s.model, s.data, 7, pose[0]), mbsr_data_error(s.data));
    assert_int_equal(mbsr_body_acceleration(s.model, s.data, 7, A[0]), MBSR_ERR_SEQUENCE);
    assert_ok(mbsr_inverse_dynamics(s.model, s.data, s.t, s.q, s.u, s.udot, NULL, s.expected),
              mbsr_data_error(s.data));
    assert_ok(mbsr_body_acceleration(s.model, s.data, 7, A[0]), mbsr_data_error(s.data));
    assert_ok(mbsr_stage_positions(s.model, s.data, s.t, s.q), mbsr_data_error(s.data));
    assert_ok(mbsr_body_pose(s.model, s.data, 7, pose[1]), mbsr_data_error(s.data));
    assert_true(distance(MBSR_POSE_SIZE, pose[0], pose[1]) == 0.0);
    assert_ok(mbsr_stage_velocities(s.model, s.data, s.u), mbsr_data_error(s.data));
    assert_ok(mbsr_stage_forces(s.model, s.data, NULL), mbsr_data_error(s.data));
    assert_ok(mbsr_stage_accelerations(s.model, s.data, s.udot), mbsr_data_error(s.data));
    assert_ok(mbsr_body_acceleration(s.model, s.data, 7, A[1]), mbsr_data_error(s.data));
    assert_true(distance(6, A[0], A[1]) == 0.0);
    test_rigid_tree_free(&s);
}

/* Joint by joint relative to the sum of the joint force and the bias force, which in a chain of
 * this length is 1e12 times larger. No recursion on the call stack. */
static void a_hundred_thousand_bodies_lose_no_digits(void **state)
{
    (void)state;
    test_rigid_tree s;
    mbsr_data *lean;
    test_rigid_tree_make(&s, (test_rigid_choice){.seed = 6, .bodies = 100000, .length = 0.3});
    assert_ok(mbsr_data_create_lean(s.model, &lean, NULL), NULL);
    double *bias = malloc((size_t)s.nu * sizeof *bias);
    assert_ok(mbsr_forward_dynamics(s.model, lean, s.t, s.q, s.u, s.tau, s.udot),
              mbsr_data_error(lean));
    assert_ok(mbsr_inverse_dynamics(s.model, lean, s.t, s.q, s.u, s.udot, NULL, s.expected),
              mbsr_data_error(lean));
    assert_ok(mbsr_bias_forces(s.model, lean, s.t, s.q, s.u, bias), mbsr_data_error(lean));
    double worst = 0.0;
    for (int k = 0; k < s.nu; ++k) {
        worst = fmax(worst, fabs(s.expected[k] - s.tau[k]) / (fabs(s.tau[k]) + fabs(bias[k])));
    }
    print_message("%.1e\n", worst);
    assert_less(worst, 1e-10);
    free(bias);
    mbsr_data_destroy(lean);
    test_rigid_tree_free(&s);
}

static void sines_and_cosines_are_those_of_the_c_library(void **state)
{
    (void)state;
    const mbsri_sweep_kernels *list[2];
    test_rng rng = test_seed(3);
    for (int l = 0; l < test_kernels(list); ++l) {
        for (int k = 0; k < 20000; ++k) {
            double x[5], sincos[10];
            const double size = pow(10.0, 7.0 * test_uniform(&rng));
            for (int i = 0; i < 5; ++i) x[i] = size * test_uniform(&rng);
            list[l]->trigonometry(5, x, sincos);
            for (int i = 0; i < 5; ++i) {
                assert_close(sincos[2 * i], cos(x[i]), 3e-16);
                assert_close(sincos[2 * i + 1], sin(x[i]), 3e-16);
            }
        }
    }
}

static int damp_every_joint(const mbsr_force_args *args)
{
    const mbsr_force_body *b = args->body;
    assert_int_equal(args->bodies, 1);
    for (int k = 0; k < b->n; ++k) b->tau[k] -= (1.0 + b->id) * b->u[k];
    return 0;
}

static void elements_on_every_joint_are_called_for_each(void **state)
{
    (void)state;
    static const mbsr_force_table table = {.version = MBSR_FORCE_TABLE_VERSION,
                                           .flags = MBSR_FORCE_EVERY_BODY | MBSR_FORCE_JOINT_ONLY,
                                           .name = "damping",
                                           .evaluate = damp_every_joint};
    static const double q[3] = {0.3, -0.5, 0.8}, u[3] = {1.0, -2.0, 0.7}, com[3] = {0.5, 0.1, 0.2},
                        tensor[6] = {1, 1.1, 1.2, 0, 0, 0}, axis[3] = {0.0, 1.0, 0.0};
    double expected[3], udot[3], damped[3], none[3] = {0.0};
    mbsr_model *model;
    mbsr_data *data;
    assert_ok(mbsr_model_create(NULL, &model, NULL), NULL);
    for (int id = 0; id < 3; ++id) {
        mbsr_body_def def = mbsr_default_body_def();
        def.parent = id ? id - 1 : MBSR_GROUND;
        def.joint = mbsr_joint_revolute(NULL, NULL, axis);
        def.inertia = mbsr_inertia_rigid(1.0, com, tensor);
        assert_ok(mbsr_model_add_body(model, &def, NULL), mbsr_model_error(model));
    }
    const mbsr_force_def damping = mbsr_force_custom(&table, 0, NULL, NULL);
    assert_ok(mbsr_model_add_force(model, &damping, NULL), mbsr_model_error(model));
    assert_ok(mbsr_model_finish(model), mbsr_model_error(model));
    assert_ok(mbsr_data_create(model, &data, NULL), NULL);
    assert_ok(mbsri_forward_by_stages(model, data, 0.0, q, u, none, expected),
              mbsr_data_error(data));
    assert_true(!mbsri_sweeps_forward_dynamics(model, data, 0.0, q, u, none, udot));
    assert_close(distance(3, udot, expected), 0.0, 1e-12);
    /* inverse dynamics of these accelerations needs no joint forces beside the damping */
    assert_ok(mbsr_inverse_dynamics(model, data, 0.0, q, u, udot, NULL, damped),
              mbsr_data_error(data));
    assert_close(largest(3, damped), 0.0, 1e-12);
    mbsr_data_destroy(data);
    mbsr_model_destroy(model);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sines_and_cosines_are_those_of_the_c_library),
        cmocka_unit_test(regular_trees_agree_with_the_stages),
        cmocka_unit_test(trees_with_massless_bodies_agree_where_they_are_served),
        cmocka_unit_test(inverse_dynamics_agrees),
        cmocka_unit_test(the_momentum_form_agrees),
        cmocka_unit_test(forces_roots_and_orders_agree),
        cmocka_unit_test(floating_bodies_agree),
        cmocka_unit_test(a_hundred_thousand_bodies_lose_no_digits),
        cmocka_unit_test(elements_on_every_joint_are_called_for_each),
        cmocka_unit_test(lean_data_serves_the_same),
        cmocka_unit_test(a_prescribed_motion_that_is_no_number_is_refused),
        cmocka_unit_test(results_can_be_asked_for_after_every_call),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
