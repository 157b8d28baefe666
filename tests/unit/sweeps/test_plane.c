/* Trees in the plane, embedded in space for the vectorised sweeps, against the stages and the
 * elimination by blocks, which take them as they are; for every kind of processor that this machine
 * can run.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"
#include "kernels.h"
#include "plane_tree.h"

#include "assembly/data.h"
#include "recursion/forward.h"
#include "recursion/inverse.h"
#include "model/query.h"
#include "sweeps/build.h"
#include "sweeps/dynamics.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST = 3 * TEST_PLANE_BODIES, SIZE = 3 * MOST, TREES = 300 };

typedef struct tally {
    int served, regular, newton, driven;
    double forward, inverse, residual, solution;
} tally;

static void note(double *worst, double value)
{
    assert_true(isfinite(value));
    *worst = fmax(*worst, value);
}

static void compare_dynamics(test_plane_tree *s, tally *n)
{
    const mbsri_sweep_kernels *list[2];
    double tau[MOST], expected[MOST], out[MOST];
    test_rng rng = test_seed(7);
    test_fill(&rng, s->nu, tau);
    const int status = mbsri_forward_by_stages(s->model, s->data, s->t, s->q, s->u, tau, expected);
    assert_true(status == MBSR_OK || status == MBSR_UNDETERMINED);
    const int rank = s->data->total_rank;
    for (int k = 0; k < test_kernels(list); ++k) {
        test_use_kernels(s->model, list[k]);
        mbsri_data_poison(s->data);
        if (mbsri_sweeps_forward_dynamics(s->model, s->data, s->t, s->q, s->u, tau, out)) continue;
        int sum = 0;
        for (int i = 1; i <= s->model->bodies; ++i) sum += s->data->rank[i];
        assert_int_equal(sum, rank);
        n->regular += status == MBSR_OK;
        if (status == MBSR_OK) note(&n->forward, test_relative_distance(s->nu, out, expected));
    }
    (void)mbsri_forward_by_stages(s->model, s->data, s->t, s->q, s->u, tau, expected);
    mbsri_inverse(s->model, s->data, tau);
    mbsri_scatter(s->model, s->data->out, expected);
    for (int k = 0; k < s->nu; ++k) expected[k] += tau[k]; /* tau was applied, too */
    for (int k = 0; k < test_kernels(list); ++k) {
        test_use_kernels(s->model, list[k]);
        mbsri_data_poison(s->data);
        assert_true(!mbsri_sweeps_inverse_dynamics(s->model, s->data, s->t, s->q, s->u, tau, out));
        note(&n->inverse, test_relative_distance(s->nu, out, expected));
    }
}

static void compare_residuals(test_plane_tree *s, mbsr_dae_form form, tally *n)
{
    const mbsri_sweep_kernels *list[2];
    const int size = mbsr_dae_size(s->model, form);
    double y[SIZE], yp[SIZE], F[SIZE], expected[SIZE];
    test_rng rng = test_seed(11);
    assert_ok(mbsr_dae_pack(s->model, s->data, form, s->t, s->q, s->u, y),
              mbsr_data_error(s->data));
    for (int k = 0; k < s->nu; ++k) y[s->nq + k] += 0.1 * test_uniform(&rng);
    test_fill(&rng, size, yp);
    const test_hidden trees = test_hide_sweeps(s->model);
    assert_ok(mbsr_dae_residual(s->model, s->data, form, s->t, y, yp, expected),
              mbsr_data_error(s->data));
    test_show_sweeps(s->model, trees);
    for (int k = 0; k < test_kernels(list); ++k) {
        test_use_kernels(s->model, list[k]);
        mbsri_data_poison(s->data);
        assert_ok(mbsr_dae_residual(s->model, s->data, form, s->t, y, yp, F),
                  mbsr_data_error(s->data));
        note(&n->residual, test_relative_distance(size, F, expected));
    }
}

/* The Newton system by the sweeps and by blocks at a consistent state. */
static void compare_newton(test_plane_tree *s, tally *n)
{
    const int size = mbsr_dae_size(s->model, MBSR_DAE_MOMENTUM);
    double y[SIZE], yp[SIZE], r[SIZE], x[2][SIZE];
    test_rng rng = test_seed(13);
    test_fill(&rng, size, r);
    assert_ok(mbsr_dae_pack(s->model, s->data, MBSR_DAE_MOMENTUM, s->t, s->q, s->u, y),
              mbsr_data_error(s->data));
    if (mbsr_dae_consistent(s->model, s->data, MBSR_DAE_MOMENTUM, s->t, y, yp, NULL, NULL)) return;
    bool swept = false;
    for (int k = 0; k < 2; ++k) {
        mbsr_newton_opt opt = mbsr_default_newton_opt();
        mbsr_newton_info info;
        mbsr_newton *newton;
        opt.by_blocks = k;
        assert_ok(mbsr_newton_create(s->model, MBSR_DAE_MOMENTUM, &opt, &newton, NULL), NULL);
        assert_ok(mbsr_newton_factor(newton, s->data, s->t, y, yp, 30.0),
                  mbsr_newton_error(newton));
        assert_ok(mbsr_newton_solve(newton, r, x[k]), mbsr_newton_error(newton));
        assert_ok(mbsr_newton_get_info(newton, &info), NULL);
        if (k == 0) swept = info.vector_code != 0;
        mbsr_newton_destroy(newton);
    }
    if (!swept) return;
    ++n->newton;
    note(&n->solution, test_relative_distance(s->nq, x[0], x[1]));
    note(&n->solution, test_relative_distance(s->nu, x[0] + s->nq, x[1] + s->nq));
    note(&n->solution, test_relative_distance(s->nu, x[0] + s->nq + s->nu, x[1] + s->nq + s->nu));
}

static bool is_driven(const test_plane_tree *s)
{
    for (int i = 1; i <= s->model->bodies; ++i) {
        if (s->model->body[i].joint.motion) return true;
    }
    return false;
}

static void trees_in_the_plane_agree_with_the_stages(void **state)
{
    (void)state;
    static test_plane_tree s;
    tally n = {0, 0, 0, 0, 0.0, 0.0, 0.0, 0.0};
    for (int k = 0; k < TREES; ++k) {
        test_plane_make(&s, (test_plane_choice){.seed = 1 + (uint64_t)k,
                                                .bodies = 1 + k % TEST_PLANE_BODIES,
                                                .massless = 0.2 * (k % 4),
                                                .rigid = 1,
                                                .moving = k % 3 == 0,
                                                .damped = 1});
        assert_true(s.model->tree.plain != NULL);
        ++n.served;
        n.driven += is_driven(&s);
        compare_dynamics(&s, &n);
        compare_residuals(&s, MBSR_DAE_INVERSE_DYNAMICS, &n);
        compare_residuals(&s, MBSR_DAE_MOMENTUM, &n);
        compare_newton(&s, &n);
        test_plane_free(&s);
    }
    print_message("%d trees (%d driven): %d regular, accelerations to %.1e, joint forces to %.1e, "
                  "residuals to %.1e; %d Newton systems to %.1e\n",
                  n.served, n.driven, n.regular, n.forward, n.inverse, n.residual, n.newton,
                  n.solution);
    assert_true(n.driven > TREES / 4 && n.regular > TREES / 4 && n.newton > TREES / 4);
    assert_less(n.forward, 1e-9);
    assert_less(n.inverse, 1e-12);
    assert_less(n.residual, 1e-9);
    assert_less(n.solution, 1e-8);
}

/* A POINT on a PLANAR body keeps no axes: what stands on it would turn with that body. */
static void a_point_between_planar_bodies_is_a_block(void **state)
{
    (void)state;
    const mbsr_planar_frame at = {0.3, 0.2, 0.4}, none = {0.0, 0.0, 0.0};
    for (int last = 0; last < 2; ++last) {
        mbsr_model *m;
        assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
        mbsr_body_def body = mbsr_default_body_def();
        body.joint = mbsr_joint_planar_revolute(none, none);
        body.inertia = mbsr_inertia_planar(1.0, (double[2]){0.5, 0.0}, 0.1);
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
        body.parent = 0;
        body.joint = mbsr_joint_point(at, MBSR_X, 0, NULL, NULL);
        body.inertia = mbsr_inertia_particle(1.0);
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
        body.parent = 1;
        body.joint = mbsr_joint_planar_revolute(at, none);
        body.inertia = mbsr_inertia_planar(1.0, (double[2]){0.5, 0.0}, 0.1);
        if (last) assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
        assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
        assert_int_equal(m->tree.plain->blocks, last);
        mbsr_model_destroy(m);
    }
}

/* Long chains have so much inertia about x and y, which no joint takes away, that what turns about
 * z is nothing beside it: it must not count. */
static void long_chains_are_served(void **state)
{
    (void)state;
    enum { HINGES = 2000 };
    const double com[2] = {0.5, 0.0};
    mbsr_model *m;
    mbsr_data *d;
    double *q = calloc(6 * HINGES, sizeof *q), *u = q + HINGES, *tau = u + HINGES,
           *udot = tau + HINGES, *back = udot + HINGES, *bias = back + HINGES;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    for (int i = 0; i < HINGES; ++i) {
        mbsr_body_def body = mbsr_default_body_def();
        body.parent = i == 0 ? MBSR_GROUND : i - 1;
        body.joint = mbsr_joint_planar_revolute((mbsr_planar_frame){i > 0 ? 1.0 : 0.0, 0.0, 0.0},
                                                (mbsr_planar_frame){0.0, 0.0, 0.0});
        body.inertia = mbsr_inertia_planar(1.0, com, 1.0 / 12.0);
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    }
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    for (int k = 0; k < HINGES; ++k) {
        q[k] = 0.3 * sin(k);
        u[k] = 0.1 * cos(3.0 * k);
        tau[k] = sin(2.0 * k);
    }
    assert_ok(mbsri_sweeps_forward_dynamics(m, d, 0.0, q, u, tau, udot), mbsr_data_error(d));
    assert_ok(mbsr_inverse_dynamics(m, d, 0.0, q, u, udot, NULL, back), mbsr_data_error(d));
    mbsr_batch *batch;
    assert_ok(mbsr_batch_create(m, &batch, NULL), NULL);
    assert_ok(mbsr_batch_forward_dynamics(m, batch, 0.0, 1, q, u, tau, bias, NULL),
              mbsr_batch_error(batch));
    assert_int_equal(mbsr_batch_one_by_one(batch), 0);
    mbsr_batch_destroy(batch);
    assert_ok(mbsr_bias_forces(m, d, 0.0, q, u, bias), mbsr_data_error(d));
    for (int k = 0; k < HINGES; ++k)
        assert_close(back[k], tau[k], 1e-9 * (1.0 + fabs(tau[k]) + fabs(bias[k])));
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
    free(q);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(trees_in_the_plane_agree_with_the_stages),
        cmocka_unit_test(a_point_between_planar_bodies_is_a_block),
        cmocka_unit_test(long_chains_are_served),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
