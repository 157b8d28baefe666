/* Trees in which bodies of any kind stand among those of the vectorised sweeps, against the stages,
 * which take all bodies as they are: callers' joints, locked coordinates, added masses, inertias by
 * matrix and by function, points between planar bodies, GENERAL bodies; in space and in the plane,
 * for every kind of processor that this machine can run. Lean data give the same to the last digit.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"
#include "kernels.h"
#include "mixed.h"
#include "own_joint.h"
#include "plane_tree.h"
#include "rigid_tree.h"
#include "tree.h"

#include "assembly/data.h"
#include "model/query.h"
#include "recursion/forward.h"
#include "recursion/inverse.h"
#include "sweeps/build.h"
#include "sweeps/dynamics.h"

#include <mbsrank/driver.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* What a group of trees has come to: bodies of the one and of the other sort, trees with both,
 * evaluations served, largest distances. */
typedef struct tally {
    int trees, blocks, others, both, deficient;
    int forward, inverse, momentum;
    double forward_off, inverse_off, residual_off;
} tally;

typedef struct state {
    mbsr_model *model;
    mbsr_data *data, *lean;
    double t;
    const double *q, *u;
    double *tau, *out, *expected, *y, *yp, *F;
} state;

static void note(double *worst, double value)
{
    assert_true(isfinite(value));
    *worst = fmax(*worst, value);
}

/* The entries of x that the same evaluation finds in lean data. */
static void assert_same(size_t count, const double *lean, const double *x)
{
    assert_memory_equal(lean, x, count * sizeof *x);
}

static void compare_forward(const state *s, tally *n)
{
    const mbsri_sweep_kernels *list[2];
    const int nu = s->model->nu;
    const int status =
        mbsri_forward_by_stages(s->model, s->data, s->t, s->q, s->u, s->tau, s->expected);
    assert_true(status == MBSR_OK || status == MBSR_UNDETERMINED);
    n->deficient += status == MBSR_UNDETERMINED;
    int *rank = malloc(((size_t)s->model->bodies + 1) * sizeof *rank);
    memcpy(rank, s->data->rank, ((size_t)s->model->bodies + 1) * sizeof *rank);
    for (int k = 0; k < test_kernels(list); ++k) {
        test_use_kernels(s->model, list[k]);
        mbsri_data_poison(s->data);
        mbsri_data_poison(s->lean);
        const int served =
            mbsri_sweeps_forward_dynamics(s->model, s->data, s->t, s->q, s->u, s->tau, s->out);
        assert_int_equal(
            mbsri_sweeps_forward_dynamics(s->model, s->lean, s->t, s->q, s->u, s->tau, s->F),
            served);
        if (served) continue;
        ++n->forward;
        assert_same((size_t)nu, s->F, s->out);
        for (int i = 1; i <= s->model->bodies; ++i) assert_int_equal(s->data->rank[i], rank[i]);
        if (!status) note(&n->forward_off, test_relative_distance(nu, s->out, s->expected));
    }
    free(rank);
}

static void compare_inverse(const state *s, tally *n)
{
    const mbsri_sweep_kernels *list[2];
    const test_hidden trees = test_hide_sweeps(s->model);
    assert_ok(mbsr_inverse_dynamics(s->model, s->data, s->t, s->q, s->u, s->tau, NULL, s->expected),
              mbsr_data_error(s->data));
    test_show_sweeps(s->model, trees);
    for (int k = 0; k < test_kernels(list); ++k) {
        test_use_kernels(s->model, list[k]);
        mbsri_data_poison(s->data);
        assert_false(
            mbsri_sweeps_inverse_dynamics(s->model, s->data, s->t, s->q, s->u, s->tau, s->out));
        mbsri_data_poison(s->lean);
        assert_false(
            mbsri_sweeps_inverse_dynamics(s->model, s->lean, s->t, s->q, s->u, s->tau, s->F));
        assert_same((size_t)s->model->nu, s->F, s->out);
        ++n->inverse;
        note(&n->inverse_off, test_relative_distance(s->model->nu, s->out, s->expected));
    }
}

/* Each kind of equation against the largest of its kind. */
static void compare_residual(const state *s, mbsr_dae_form form, test_rng *rng, tally *n)
{
    const mbsri_sweep_kernels *list[2];
    const mbsr_model *m = s->model;
    const int size = mbsr_dae_size(m, form), nq = m->nq, nu = m->nu;
    const bool momentum = form == MBSR_DAE_MOMENTUM;
    assert_ok(mbsr_dae_pack(m, s->data, form, s->t, s->q, s->u, s->y), mbsr_data_error(s->data));
    for (int k = 0; k < nu; ++k) s->y[nq + k] += 0.1 * test_uniform(rng);
    test_fill(rng, size, s->yp);
    const test_hidden trees = test_hide_sweeps(s->model);
    assert_ok(mbsr_dae_residual(m, s->data, form, s->t, s->y, s->yp, s->expected),
              mbsr_data_error(s->data));
    test_show_sweeps(s->model, trees);
    for (int k = 0; k < test_kernels(list); ++k) {
        test_use_kernels(s->model, list[k]);
        mbsri_data_poison(s->data);
        mbsri_data_poison(s->lean);
        int (*const residual)(const mbsr_model *, mbsr_data *, double, const double *,
                              const double *, double *) =
            momentum ? mbsri_sweeps_momentum_residual : mbsri_sweeps_inverse_residual;
        const int served = residual(m, s->data, s->t, s->y, s->yp, s->F);
        assert_int_equal(residual(m, s->lean, s->t, s->y, s->yp, s->out), served);
        if (served) continue;
        assert_same((size_t)size, s->out, s->F);
        n->momentum += momentum;
        note(&n->residual_off, test_relative_distance(nq, s->F, s->expected));
        for (int at = nq; at < size; at += nu)
            note(&n->residual_off, test_relative_distance(nu, s->F + at, s->expected + at));
    }
}

static void compare(mbsr_model *model, mbsr_data *data, double t, const double *q, const double *u,
                    tally *n)
{
    if (!model->tree.plain) return;
    const size_t size = (size_t)(model->nq + 2 * model->nu) + 1;
    double *memory = malloc(6 * size * sizeof *memory);
    mbsr_data *lean;
    assert_ok(mbsr_data_create_lean(model, &lean, NULL), NULL);
    const state s = {model,
                     data,
                     lean,
                     t,
                     q,
                     u,
                     memory,
                     memory + size,
                     memory + 2 * size,
                     memory + 3 * size,
                     memory + 4 * size,
                     memory + 5 * size};
    const int blocks = model->tree.plain->blocks;
    test_rng rng = test_seed(5);
    test_fill(&rng, model->nu, s.tau);
    ++n->trees;
    n->blocks += blocks;
    n->others += model->bodies - blocks;
    n->both += blocks > 0 && blocks < model->bodies;
    compare_forward(&s, n);
    compare_inverse(&s, n);
    compare_residual(&s, MBSR_DAE_INVERSE_DYNAMICS, &rng, n);
    compare_residual(&s, MBSR_DAE_MOMENTUM, &rng, n);
    mbsr_data_destroy(lean);
    free(memory);
}

/* Kernel levels of this processor, each of which is compared. */
static int levels(void)
{
    const mbsri_sweep_kernels *kernels[2];
    return test_kernels(kernels);
}

static void conclude(const char *name, const tally *n)
{
    print_message("%s: %d trees, %d with both (%d blocks, %d others), %d deficient; %d evaluations "
                  "forward to %.1e, %d inverse to %.1e, %d residuals to %.1e\n",
                  name, n->trees, n->both, n->blocks, n->others, n->deficient, n->forward,
                  n->forward_off, n->inverse, n->inverse_off, n->momentum, n->residual_off);
    assert_less(n->forward_off, 1e-8);
    assert_less(n->inverse_off, 1e-12);
    assert_less(n->residual_off, 1e-8);
}

static void trees_in_space(void **unused)
{
    (void)unused;
    tally n = {0};
    for (int k = 0; k < 300; ++k) {
        test_rigid_tree s;
        test_rigid_tree_make(&s, (test_rigid_choice){.seed = 7000 + (uint64_t)k,
                                                     .bodies = 2 + k % 20,
                                                     .armature = k % 5 < 2 ? 0.4 : 0.0,
                                                     .massless = 0.2 * (k % 3),
                                                     .points = 0.3 * (k % 2),
                                                     .many = 0.2 * (k % 4),
                                                     .branching = 0.3 * (k % 3),
                                                     .length = 1.0,
                                                     .forces = k % 2,
                                                     .moving = k % 7 == 0,
                                                     .shuffle = k % 3 == 0,
                                                     .held = k % 4 == 1 ? 0.2 : 0.0,
                                                     .added = k % 4 == 2 ? 0.2 : 0.0,
                                                     .tables = k % 4 == 3});
        compare(s.model, s.data, s.t, s.q, s.u, &n);
        test_rigid_tree_free(&s);
    }
    conclude("space", &n);
    assert_true(n.both > 100 && n.blocks > 200 && n.others > 1000);
    assert_true(n.forward > 100 * levels() && n.momentum > 50 * levels() && n.deficient > 50);
}

/* Few of many bodies are seen in lean data, and the root's acceleration stands behind numbers of
 * theirs. */
static void chains_on_moving_roots(void **unused)
{
    (void)unused;
    tally n = {0};
    for (int k = 0; k < 100; ++k) {
        test_rigid_tree s;
        test_rigid_tree_make(&s, (test_rigid_choice){.seed = 60000 + (uint64_t)k,
                                                     .bodies = 10 + k % 10,
                                                     .many = 0.2 * (k % 3),
                                                     .length = 1.0,
                                                     .moving = 1,
                                                     .added = 0.2});
        compare(s.model, s.data, s.t, s.q, s.u, &n);
        test_rigid_tree_free(&s);
    }
    conclude("moving", &n);
    assert_true(n.both > 80 && n.forward > 75 * levels());
}

static void trees_in_the_plane(void **unused)
{
    (void)unused;
    static test_plane_tree s;
    tally n = {0};
    for (int k = 0; k < 300; ++k) {
        test_plane_make(&s, (test_plane_choice){.seed = 500 + (uint64_t)k,
                                                .bodies = 2 + k % (TEST_PLANE_BODIES - 1),
                                                .massless = 0.2 * (k % 3),
                                                .functions = k % 2,
                                                .moving = k % 4 == 0,
                                                .damped = 1});
        compare(s.model, s.data, s.t, s.q, s.u, &n);
        test_plane_free(&s);
    }
    conclude("plane", &n);
    assert_true(n.both > 150 && n.deficient > 50);
    assert_true(n.forward > 50 * levels() && n.momentum > 25 * levels());
}

/* Every kind of body beside every other, a GENERAL one among them. */
static void trees_of_all_kinds(void **unused)
{
    (void)unused;
    tally n = {0};
    test_rng rng = test_seed(3);
    double q[MIXED_NQ], u[MIXED_NU];
    static mixed s;
    for (int k = 0; k < 20 * MIXED_ALL; ++k) {
        mixed_make(&s, (mixed_scene)(k % MIXED_ALL));
        test_fill(&rng, s.nq, q);
        test_fill(&rng, s.nu, u);
        compare(s.model, s.data, 0.1 * k, q, u, &n);
        mixed_free(&s);
    }
    conclude("mixed", &n);
    assert_true(n.both > 50);
}

/* Bodies of any dimension and nothing else. */
static void general_bodies_alone(void **unused)
{
    (void)unused;
    tally n = {0};
    test_rng rng = test_seed(4);
    double q[40], u[40];
    for (int k = 0; k < 100; ++k) {
        test_tree s;
        test_tree_make(&s, (test_tree_opt){.seed = 900 + (uint64_t)k,
                                           .bodies = 1 + k % 10,
                                           .max_d = 1 + k % 5,
                                           .welds = k % 2,
                                           .deficient = 0.2 * (k % 4),
                                           .bend = 0.1,
                                           .forces = k % 3 == 0,
                                           .moving_root = k % 5 == 0,
                                           .shuffle = k % 2});
        if (s.nu <= 40) {
            test_fill(&rng, s.nu, q);
            test_fill(&rng, s.nu, u);
            compare(s.model, s.data, 0.3, q, u, &n);
        }
        test_tree_free(&s);
    }
    conclude("general", &n);
    assert_int_equal(n.others, 0);
    assert_true(n.trees > 90 && n.deficient > 15);
    assert_true(n.forward > 75 * levels() && n.momentum > 75 * levels());
}

/* ---- a slide on a slide, the lower one GENERAL ---- */

/* These write only what differs from the preset. */
static int rider_position(const mbsr_joint_args *args, double *p)
{
    p[0] = p[4] = p[8] = 1.0;
    p[9] = args->p_pred[0], p[10] = args->q[0];
    return 0;
}

static int rider_jacobians(const mbsr_joint_args *args, double *K, double *H, double *J, double *kI)
{
    (void)args, (void)K, (void)kI;
    H[3] = -1.0, J[4] = -1.0;
    return 0;
}

static const mbsr_joint_table rider_table = {.version = MBSR_JOINT_TABLE_VERSION,
                                             .flags = MBSR_JOINT_UNIT_K,
                                             .name = "rider",
                                             .position = rider_position,
                                             .jacobians = rider_jacobians,
                                             .bias = test_own_bias};

static mbsr_joint rider(void)
{
    mbsr_joint joint = mbsr_joint_custom(&rider_table, 6, 1, NULL);
    joint.space = MBSR_SPACE_SPATIAL;
    joint.np = MBSR_POSE_SIZE;
    return joint;
}

/* With three hinges above, of which one is on another; or all of it by stock joints. */
static mbsr_model *slides(bool own)
{
    static const double mass = 1.0, at[3] = {0.0}, axis[3] = {0.2, -0.3, 1.0},
                        x[3] = {1.0, 0.0, 0.0}, y[3] = {0.0, 1.0, 0.0}, c[3] = {0.3, 0.1, -0.2},
                        J[6] = {0.3, 0.4, 0.5, 0.01, 0.02, 0.0};
    static const int parent[] = {0, 1, 2, 2, 4};
    mbsr_model *m;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    for (int k = 0; k < 5; ++k) {
        const mbsr_frame A = mbsr_frame_at(0.2, 0.1 * k, 0.3);
        mbsr_body_def body = mbsr_default_body_def();
        body.parent = k ? parent[k] - 1 : MBSR_GROUND;
        body.joint = k > 1 ? mbsr_joint_revolute(&A, NULL, k % 2 ? x : axis)
                     : own ? k ? rider() : mbsr_joint_custom(&test_own_table, 1, 1, NULL)
                           : mbsr_joint_prismatic(NULL, NULL, k ? y : x);
        body.inertia = k     ? mbsr_inertia_rigid(1.0 + k, c, J)
                       : own ? mbsr_inertia_matrix(1, &mass)
                             : mbsr_inertia_point_mass(mass, at);
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    }
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    return m;
}

static void rigid_bodies_on_a_general_one(void **unused)
{
    (void)unused;
    static const double q[5] = {0.3, -0.2, 0.7, -1.1, 0.5}, u[5] = {1.0, -0.4, 0.8, 0.3, -0.9};
    double rate[2][5], tau[2][5];
    tally n = {0};
    for (int own = 0; own < 2; ++own) {
        mbsr_model *m = slides(own);
        mbsr_data *d;
        assert_ok(mbsr_data_create(m, &d, NULL), mbsr_model_error(m));
        compare(m, d, 0.0, q, u, &n);
        assert_ok(mbsr_forward_dynamics(m, d, 0.0, q, u, NULL, rate[own]), mbsr_data_error(d));
        assert_ok(mbsr_inverse_dynamics(m, d, 0.0, q, u, u, NULL, tau[own]), mbsr_data_error(d));
        mbsr_data_destroy(d);
        mbsr_model_destroy(m);
    }
    assert_less(test_relative_distance(5, rate[1], rate[0]), 1e-13);
    assert_less(test_relative_distance(5, tau[1], tau[0]), 1e-13);
    conclude("on a slide", &n);
    assert_int_equal(n.both, 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(trees_in_space),       cmocka_unit_test(chains_on_moving_roots),
        cmocka_unit_test(trees_in_the_plane),   cmocka_unit_test(trees_of_all_kinds),
        cmocka_unit_test(general_bodies_alone), cmocka_unit_test(rigid_bodies_on_a_general_one)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
