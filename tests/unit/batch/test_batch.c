/* Many states in one call against one call for each, for every kind of processor that this machine
 * can run.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "counting.h"
#include "duration.h"
#include "expect.h"
#include "batch/build.h"
#include "mixed.h"
#include "plane_tree.h"
#include "rigid_tree.h"
#include "space.h"
#include "recursion/forward.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST = 19 }; /* states in a call */

static int kernels(const mbsri_batch_kernels *list[3])
{
    int count = 0;
    list[count++] = &mbsri_batch_base;
#if defined(MBSR_WITH_V3)
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
        list[count++] = &mbsri_batch_v3;
#endif
#if defined(MBSR_WITH_V4)
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
        __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("fma"))
        list[count++] = &mbsri_batch_v4;
#endif
    return count;
}

/* Memory that is full of NaN before it is used. */
static void *allocate_nan(void *user, size_t size)
{
    void *memory = malloc(size);
    (void)user;
    if (memory) memset(memory, 0xff, size);
    return memory;
}

static void release_nan(void *user, void *memory)
{
    (void)user;
    free(memory);
}

/* ---- a tree and several of its states ---- */

typedef struct ensemble {
    test_rigid_tree tree;
    double *q, *u, *tau, *out; /* MOST states */
    double *expected;          /* u', or tau, of each */
    int expected_status[MOST], status[MOST];
} ensemble;

static double *room(int n)
{
    double *x = malloc(((size_t)n * MOST + 1) * sizeof *x);
    assert_non_null(x);
    return x;
}

static void make(ensemble *s, test_rigid_choice choice)
{
    mbsr_model_def def = choice.def ? *choice.def : mbsr_default_model_def();
    if (!def.allocator.allocate) def.allocator = (mbsr_allocator){allocate_nan, release_nan, NULL};
    choice.def = &def;
    test_rigid_tree_make(&s->tree, choice);
    test_rng rng = test_seed(choice.seed + 77);
    s->q = room(s->tree.nq);
    s->u = room(s->tree.nu);
    s->tau = room(s->tree.nu);
    s->out = room(s->tree.nu);
    s->expected = room(s->tree.nu);
    test_fill(&rng, MOST * s->tree.nq, s->q);
    test_fill(&rng, MOST * s->tree.nu, s->u);
    test_fill(&rng, MOST * s->tree.nu, s->tau);
}

static void drop(ensemble *s)
{
    free(s->q);
    free(s->u);
    free(s->tau);
    free(s->out);
    free(s->expected);
    test_rigid_tree_free(&s->tree);
}

/* One call for each state; tau may be NULL. */
static void expect(ensemble *s, bool inverse, const double *tau, double t)
{
    const test_rigid_tree *tree = &s->tree;
    for (int k = 0; k < MOST; ++k) {
        const double *q = s->q + k * tree->nq, *u = s->u + k * tree->nu;
        const double *load = tau ? tau + k * tree->nu : NULL;
        double *out = s->expected + k * tree->nu;
        s->expected_status[k] =
            inverse ? mbsr_inverse_dynamics(tree->model, tree->data, t, q, u, load, NULL, out)
                    : mbsr_forward_dynamics(tree->model, tree->data, t, q, u, load, out);
    }
}

static int evaluate(ensemble *s, mbsr_batch *batch, bool inverse, int states, const double *tau,
                    double t)
{
    const test_rigid_tree *tree = &s->tree;
    for (int k = 0; k < MOST * tree->nu; ++k) s->out[k] = 1e77;
    for (int k = 0; k < MOST; ++k) s->status[k] = 12345;
    return inverse ? mbsr_batch_inverse_dynamics(tree->model, batch, t, states, s->q, s->u, tau,
                                                 s->out, s->status)
                   : mbsr_batch_forward_dynamics(tree->model, batch, t, states, s->q, s->u, tau,
                                                 s->out, s->status);
}

static double scale_of(int n, const double *x)
{
    return 1.0 + test_largest(n, x);
}

/* The first `states` states against what is expected, and nothing written behind them. */
static void assert_expected(const ensemble *s, int states, double tolerance)
{
    const int n = s->tree.nu;
    for (int k = 0; k < states; ++k) {
        const double *out = s->out + k * n, *expected = s->expected + k * n;
        assert_int_equal(s->status[k], s->expected_status[k]);
        if (s->status[k] != MBSR_OK && s->status[k] != MBSR_UNDETERMINED) {
            for (int l = 0; l < n; ++l) assert_true(isnan(out[l]));
            continue;
        }
        for (int l = 0; l < n; ++l)
            assert_close(out[l], expected[l], tolerance * scale_of(n, expected));
    }
    for (int l = states * n; l < MOST * n; ++l) assert_true(s->out[l] == 1e77);
    for (int k = states; k < MOST; ++k) assert_int_equal(s->status[k], 12345);
}

/* Forward and inverse dynamics with all kernels and numbers of states; returns how many states went
 * one by one. */
static int compare(ensemble *s, double tolerance, double t)
{
    const mbsri_batch_kernels *list[3];
    int single = 0;
    for (int way = 0; way < 3; ++way) {
        const bool inverse = way == 2;
        const double *load = way == 1 ? NULL : s->tau;
        expect(s, inverse, load, t);
        for (int k = 0; k < kernels(list); ++k) {
            mbsr_batch *batch;
            assert_ok(mbsri_batch_make(s->tree.model, list[k], &batch, NULL), NULL);
            for (int states = 1; states <= MOST; states += states < 9 ? 1 : 5) {
                const int result = evaluate(s, batch, inverse, states, load, t);
                const int failed = mbsr_batch_failed(batch);
                assert_expected(s, states, tolerance);
                assert_int_equal(result, failed < 0 ? MBSR_OK : s->status[failed]);
                for (int i = 0; i < states && (failed < 0 || i < failed); ++i)
                    assert_int_equal(s->status[i], MBSR_OK);
                assert_true(mbsr_batch_one_by_one(batch) <= (inverse ? 0 : states));
                single += mbsr_batch_one_by_one(batch);
            }
            mbsr_batch_destroy(batch);
        }
    }
    return single;
}

/* ---- tests ---- */

static void every_state_is_what_a_call_of_its_own_gives(void **state)
{
    (void)state;
    int in_order = 0, branched = 0;
    for (int k = 0; k < 40; ++k) {
        ensemble s;
        make(&s, (test_rigid_choice){.seed = 300 + (uint64_t)k,
                                     .bodies = 1 + k % 19,
                                     .armature = 0.4 * (k % 3),
                                     .points = k % 5 ? 0.0 : 0.1,
                                     .branching = 0.3 * (k % 4),
                                     .length = k % 3 ? 1.0 : 1000.0});
        assert_int_equal(compare(&s, 1e-11, 0.0), 0);
        in_order += s.tree.model->order.as_given;
        branched += s.tree.model->tree.plain->depth > 1;
        drop(&s);
    }
    assert_true(in_order > 5 && in_order < 35 && branched > 5);
}

static void joints_of_several_axes_are_taken_apart(void **state)
{
    (void)state;
    int single = 0, calls = 0;
    const int step = test_seeds(5, 1);
    for (int k = 0; k < 60; k += step) {
        ensemble s;
        make(&s, (test_rigid_choice){.seed = 900 + (uint64_t)k,
                                     .bodies = 1 + k % 11,
                                     .armature = 0.4 * (k % 3),
                                     .many = k % 3 ? 0.4 : 1.0,
                                     .branching = 0.3 * (k % 4),
                                     .length = 1.0,
                                     .moving = k % 4 == 3,
                                     .shuffle = k % 5 == 0});
        single += compare(&s, 1e-10, 0.3);
        calls += 1;
        drop(&s);
    }
    print_message("%d states one by one in %d trees\n", single, calls);
    const int all = calls * 3 * 3 * (45 + 14 + 19); /* at most */
    assert_true(single < all / 20);
}

/* Locked coordinates (which make no other kind), added masses, joints by tables of a user's, and
 * elements on bodies: only states that lack rank, or where its bound does not tell, leave the
 * lanes. */
static void bodies_of_other_kinds_take_part(void **state)
{
    (void)state;
    int with_blocks = 0, loaded = 0, doubtful = 0;
    for (int k = 0; k < 64; ++k) {
        ensemble s;
        make(&s, (test_rigid_choice){.seed = 5000 + (uint64_t)k,
                                     .bodies = 2 + k % 13,
                                     .armature = 0.4 * (k % 3),
                                     .many = k % 3 ? 0.3 : 0.0,
                                     .branching = 0.3 * (k % 4),
                                     .length = 1.0,
                                     .forces = k % 4 == 3 ? 1 + k % 2 : 0,
                                     .moving = k % 5 == 4,
                                     .shuffle = k % 6 == 0,
                                     .held = k % 4 == 0 ? 0.2 : 0.0,
                                     .added = k % 4 == 1 || k % 8 == 0 ? 0.3 : 0.0,
                                     .tables = k % 4 == 2});
        const mbsri_sweeps *tree = s.tree.model->tree.plain;
        with_blocks += tree && tree->blocks > 0 && tree->blocks < tree->bodies;
        loaded += tree && tree->blocks == 0 && tree->body_forces;
        doubtful += compare(&s, 1e-10, 0.3) > 0;
        drop(&s);
    }
    print_message("%d trees with bodies of other kinds, %d with elements on bodies, %d in doubt\n",
                  with_blocks, loaded, doubtful);
    assert_true(with_blocks > 20 && loaded > 10 && doubtful < 4);
}

static void states_without_full_rank_go_one_by_one(void **state)
{
    (void)state;
    int single = 0, undetermined = 0;
    for (int k = 0; k < 60; ++k) {
        ensemble s;
        make(&s, (test_rigid_choice){.seed = 2000 + (uint64_t)k,
                                     .bodies = 2 + k % 9,
                                     .massless = 0.25 * (k % 3),
                                     .points = 0.2 * (k % 2),
                                     .many = k % 5 ? 0.0 : 0.2,
                                     .branching = 0.3 * (k % 4),
                                     .length = 1.0});
        single += compare(&s, 1e-7, 0.0);
        expect(&s, false, s.tau, 0.0);
        undetermined += s.expected_status[0] == MBSR_UNDETERMINED;
        drop(&s);
    }
    print_message("%d states one by one, %d trees undetermined\n", single, undetermined);
    assert_true(undetermined > 10 && undetermined < 50);
}

/* The certificate against the verdict of rank.c, which knows the rounding errors exactly: with
 * masses of all sizes there are many joints between clearly regular and singular. */
static void no_rank_in_doubt_passes_for_full(void **state)
{
    (void)state;
    const mbsri_batch_kernels *list[3];
    int served = 0, deficient = 0, doubtful = 0;
    const int trees = test_long() ? 4000 : test_seeds_short(50, 150);
    for (int k = 0; k < trees; ++k) {
        ensemble s;
        mbsr_batch *batch;
        make(&s, (test_rigid_choice){.seed = 7000 + (uint64_t)k,
                                     .bodies = 4 + k % 20,
                                     .armature = k % 7 == 6 ? 0.2 : 0.0,
                                     .massless = 0.1 * (k % 3),
                                     .light = 0.2,
                                     .points = 0.3,
                                     .many = k % 2 ? 0.1 : 0.0,
                                     .branching = 0.2 * (k % 3),
                                     .length = k % 5 == 1   ? 100.0
                                               : k % 5 == 2 ? 0.01
                                                            : 1.0});
        const mbsr_model *m = s.tree.model;
        assert_ok(mbsri_batch_make(m, list[k % kernels(list)], &batch, NULL), NULL);
        (void)evaluate(&s, batch, false, 1, s.tau, 0.0);
        const int alone = mbsr_batch_one_by_one(batch);
        const int status =
            mbsri_forward_by_stages(m, s.tree.data, 0.0, s.q, s.u, s.tau, s.tree.udot);
        deficient += status == MBSR_UNDETERMINED;
        doubtful += status == MBSR_OK && alone;
        served += !alone;
        if (!alone) assert_ok(status, mbsr_data_error(s.tree.data));
        mbsr_batch_destroy(batch);
        drop(&s);
    }
    print_message("%d served, %d deficient, %d doubtful\n", served, deficient, doubtful);
    assert_true(served > trees / 13 && deficient > trees / 13 && doubtful > trees / 130);
}

/* A rod along its joint's axis, in all positions: D is rounding, above zero as often as below. */
static void rods_along_their_axes_have_no_rank(void **state)
{
    (void)state;
    const mbsri_batch_kernels *list[3];
    for (int k = 0; k < 30; ++k) {
        test_rng rng = test_seed(60 + (uint64_t)k);
        mbsr_body_def body = mbsr_default_body_def();
        double axis[3], end[3], q[2 * MOST], u[2 * MOST], udot[2 * MOST];
        const double from[3] = {0.0, 0.0, 0.0};
        int status[MOST];
        mbsr_model *m;
        mbsr_batch *batch;
        test_fill(&rng, 3, axis);
        for (int l = 0; l < 3; ++l) end[l] = 2.0 * axis[l];
        test_fill(&rng, 2 * MOST, q);
        test_fill(&rng, 2 * MOST, u);
        const mbsr_frame A = test_frame(&rng, 1.0);
        assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
        body.joint = mbsr_joint_revolute(NULL, NULL, (double[3]){0.3, 1.0, 0.4});
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
        body.parent = 0;
        body.joint = mbsr_joint_revolute(&A, NULL, axis);
        body.inertia = mbsr_inertia_rod(1.0, from, end);
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
        assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
        assert_ok(mbsri_batch_make(m, list[k % kernels(list)], &batch, NULL), NULL);
        assert_int_equal(mbsr_batch_forward_dynamics(m, batch, 0.0, MOST, q, u, NULL, udot, status),
                         MBSR_UNDETERMINED);
        assert_int_equal(mbsr_batch_one_by_one(batch), MOST);
        mbsr_batch_destroy(batch);
        mbsr_model_destroy(m);
    }
}

/* A joint that turns a light mass, and a heavy body which no force from there can move since its
 * own joint is free: rounding in what is left of its inertia outweighs the light mass. The heavy
 * body comes before or after the light one, at some distance: that of its joint, with (1) or
 * without (0) a weld to a third, light body between, or that of a weld to a massless one (2).
 * `size` is that of all bodies. */
typedef struct shadow {
    int heavy_first, weld;
    double light, size, distance;
} shadow;

static mbsr_model *cast_shadow(const shadow *c)
{
    const double z[3] = {0.0, 0.0, 1.0}, at[3] = {c->size, 0.0, 0.0},
                 edge[3] = {c->size, c->size, c->size};
    const mbsr_frame far = mbsr_frame_at(0.0, c->distance * c->size, 0.0),
                     step = mbsr_frame_at(c->size, 0.0, 0.0);
    const mbsr_inertia box = mbsr_inertia_box(1.0 / pow(c->size, 3.0), edge);
    mbsr_model *m;
    mbsr_body_def body = mbsr_default_body_def();
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    body.joint = mbsr_joint_revolute(NULL, NULL, z);
    assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    for (int k = 0; k < 2; ++k) {
        body.parent = 0;
        body.joint = mbsr_joint_weld(NULL, NULL);
        if (k == c->heavy_first) {
            body.inertia = mbsr_inertia_point_mass(c->light, at);
            assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
            continue;
        }
        body.inertia = c->weld == 2 ? mbsr_inertia_zero()
                                    : mbsr_inertia_box(c->light / pow(c->size, 3.0), edge);
        if (c->weld == 2) body.joint = mbsr_joint_weld(&far, NULL);
        if (c->weld) assert_ok(mbsr_model_add_body(m, &body, &body.parent), mbsr_model_error(m));
        body.joint = mbsr_joint_free(c->weld == 2 ? NULL : &far, NULL);
        body.inertia = box;
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    }
    /* links elsewhere, so that the mean length is `size` */
    body.parent = MBSR_GROUND;
    body.joint = mbsr_joint_revolute(&step, NULL, z);
    body.inertia = box;
    for (int k = 0; k < 100; ++k)
        assert_ok(mbsr_model_add_body(m, &body, &body.parent), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    return m;
}

/* Whether one state of the model, which is destroyed, is served, by all of the kernels or by none.
 * The verdict must be that of the stages, in the lanes or not. */
static bool is_served(mbsr_model *m)
{
    const mbsri_batch_kernels *list[3];
    mbsr_data *data;
    double q[320], u[320] = {0.0}, udot[320];
    int alone = 0;
    for (int k = 0; k < 320; ++k) q[k] = 0.1;
    assert_ok(mbsr_data_create(m, &data, NULL), NULL);
    const int status = mbsri_forward_by_stages(m, data, 0.0, q, u, NULL, udot);
    assert_int_equal(mbsr_forward_dynamics(m, data, 0.0, q, u, NULL, udot), status);
    for (int k = 0; k < kernels(list); ++k) {
        mbsr_batch *batch;
        assert_ok(mbsri_batch_make(m, list[k], &batch, NULL), NULL);
        assert_int_equal(mbsr_batch_forward_dynamics(m, batch, 0.0, 1, q, u, NULL, udot, NULL),
                         status);
        alone += mbsr_batch_one_by_one(batch);
        mbsr_batch_destroy(batch);
    }
    mbsr_data_destroy(data);
    mbsr_model_destroy(m);
    assert_true(alone == 0 || alone == kernels(list));
    return alone == 0;
}

static void heavy_bodies_cast_doubt_on_light_ones(void **state)
{
    (void)state;
    const int step = 17 - test_seeds(12, 16); /* 5 or 1: from 1e-16 to 1e-1 */
    const double farther = test_seeds_short(961, 31);
    int served = 0, models = 0;
    for (int k = 0; k < 12; ++k) {
        shadow c = {.heavy_first = k & 1, .weld = k >> 2, .size = k & 2 ? 1e5 : 1.0};
        for (int exponent = -16; exponent < 0; exponent += step) {
            c.light = pow(10.0, exponent);
            for (c.distance = 0.1; c.distance < 1e5; c.distance *= farther, ++models)
                served += is_served(cast_shadow(&c));
        }
    }
    print_message("%d served of %d\n", served, models);
    assert_true(served > models / 6);
}

/* A slider along y with a light mass, on it an arm about z with 1 kg at a short lever, and there a
 * heavy body whose joint is free. The rounding errors that it leaves in the moment of inertia of
 * the arm, over the square of the lever, are in the mass that the slider moves. */
static mbsr_model *make_lever(double light, double lever)
{
    const double y[3] = {0.0, 1.0, 0.0}, z[3] = {0.0, 0.0, 1.0}, here[3] = {0.0, 0.0, 0.0},
                 at[3] = {lever, 0.0, 0.0}, edge[3] = {1.0, 1.0, 1.0};
    const mbsr_frame far = mbsr_frame_at(0.3, 1.0, 0.2);
    mbsr_model *m;
    mbsr_body_def body = mbsr_default_body_def();
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    body.joint = mbsr_joint_prismatic(NULL, NULL, y);
    body.inertia = mbsr_inertia_point_mass(light, here);
    assert_ok(mbsr_model_add_body(m, &body, &body.parent), mbsr_model_error(m));
    body.joint = mbsr_joint_revolute(NULL, NULL, z);
    body.inertia = mbsr_inertia_point_mass(1.0, at);
    assert_ok(mbsr_model_add_body(m, &body, &body.parent), mbsr_model_error(m));
    body.joint = mbsr_joint_free(&far, NULL);
    body.inertia = mbsr_inertia_box(1.0, edge);
    assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    return m;
}

static void errors_grow_with_the_inverse_of_a_lever(void **state)
{
    (void)state;
    int served = 0, models = 0;
    for (int k = 0; k < 10; k += test_seeds(3, 1)) {
        for (int l = 0; l < 14; ++l, ++models)
            served += is_served(make_lever(pow(10.0, -l), pow(10.0, -0.5 * k)));
    }
    print_message("%d served of %d\n", served, models);
    assert_true(served > models / 7);
}

/* One joint turns an arm that points along its axis in state 3 only: no mass moves there. */
static void a_rank_that_drops_in_one_state_is_that_state_s_own(void **state)
{
    (void)state;
    const mbsri_batch_kernels *list[3];
    const double x[3] = {1.0, 0.0, 0.0}, z[3] = {0.0, 0.0, 1.0}, at[3] = {0.0, 0.0, 1.0};
    mbsr_model *m;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    mbsr_body_def body = mbsr_default_body_def();
    body.name = "post";
    body.joint = mbsr_joint_revolute(NULL, NULL, z);
    assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    body.name = "arm";
    body.parent = 0;
    body.joint = mbsr_joint_revolute(NULL, NULL, x);
    body.inertia = mbsr_inertia_point_mass(2.0, at);
    assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    for (int k = 0; k < kernels(list); ++k) {
        mbsr_batch *batch;
        double q[10] = {0.1, 0.5, 0.2, 0.6, 0.3, 0.7, 0.4, 0.0, 0.5, 0.8}, u[10] = {0.0};
        const double tau[10] = {1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 4.0, 1.0, 0.0};
        double udot[10];
        int status[5];
        assert_ok(mbsri_batch_make(m, list[k], &batch, NULL), NULL);
        assert_refused(mbsr_batch_forward_dynamics(m, batch, 0.0, 5, q, u, tau, udot, status),
                       mbsr_batch_error(batch), MBSR_UNDETERMINED, 0, MBSR_NONE,
                       "state 3: |body 0 'post'|not determined");
        assert_int_equal(mbsr_batch_failed(batch), 3);
        assert_int_equal(mbsr_batch_one_by_one(batch), 1);
        for (int i = 0; i < 5; ++i) {
            const double sine = sin(q[2 * i + 1]);
            assert_int_equal(status[i], i == 3 ? MBSR_UNDETERMINED : MBSR_OK);
            /* m l^2 sin^2(q) u' = tau about the post; tau / m l^2 about the arm's axis */
            if (i != 3) assert_close(udot[2 * i], tau[2 * i] / (2.0 * sine * sine), 1e-13);
            assert_close(udot[2 * i + 1], tau[2 * i + 1] / 2.0, 1e-14);
        }
        mbsr_batch_destroy(batch);
    }
    mbsr_model_destroy(m);
}

static void no_result_depends_on_the_states_beside_it(void **state)
{
    (void)state;
    const mbsri_batch_kernels *list[3];
    ensemble s;
    make(&s, (test_rigid_choice){
                 .seed = 5, .bodies = 14, .many = 0.2, .branching = 0.3, .length = 1.0});
    const int nq = s.tree.nq, nu = s.tree.nu;
    double *one = room(nu);
    for (int k = 0; k < kernels(list); ++k) {
        mbsr_batch *batch;
        assert_ok(mbsri_batch_make(s.tree.model, list[k], &batch, NULL), NULL);
        for (int inverse = 0; inverse < 2; ++inverse) {
            assert_ok(evaluate(&s, batch, inverse != 0, MOST, s.tau, 0.0), mbsr_batch_error(batch));
            for (int i = 0; i < MOST; ++i) {
                const double *q = s.q + i * nq, *u = s.u + i * nu, *tau = s.tau + i * nu;
                const int count = i + 3 <= MOST ? 3 : 1;
                assert_ok(inverse ? mbsr_batch_inverse_dynamics(s.tree.model, batch, 0.0, count, q,
                                                                u, tau, one, NULL)
                                  : mbsr_batch_forward_dynamics(s.tree.model, batch, 0.0, count, q,
                                                                u, tau, one, NULL),
                          mbsr_batch_error(batch));
                assert_memory_equal(one, s.out + i * nu, (size_t)(count * nu) * sizeof *one);
            }
        }
        mbsr_batch_destroy(batch);
    }
    free(one);
    drop(&s);
}

/* The first body with a quaternion. */
static const mbsri_body *find_quaternion(const mbsr_model *m)
{
    for (int i = 1; i <= m->bodies; ++i) {
        if (m->body[i].nq > m->body[i].n) return m->body + i;
    }
    fail();
    return NULL;
}

static void states_that_fail_do_not_touch_the_others(void **state)
{
    (void)state;
    const mbsri_batch_kernels *list[3];
    ensemble s;
    make(&s, (test_rigid_choice){
                 .seed = 9, .bodies = 12, .many = 0.3, .branching = 0.2, .length = 1.0});
    const int nq = s.tree.nq, nu = s.tree.nu;
    const mbsri_body *turning = find_quaternion(s.tree.model);
    double *good = room(nu);
    for (int k = 0; k < kernels(list); ++k) {
        for (int inverse = 0; inverse < 2; ++inverse) {
            ensemble bad = s;
            mbsr_batch *batch;
            assert_ok(mbsri_batch_make(s.tree.model, list[k], &batch, NULL), NULL);
            assert_ok(evaluate(&s, batch, inverse != 0, MOST, s.tau, 0.0), NULL);
            assert_int_equal(mbsr_batch_failed(batch), -1);
            assert_int_equal(mbsr_batch_one_by_one(batch), 0);
            memcpy(good, s.out, (size_t)(MOST * nu) * sizeof *good);
            bad.q = room(nq), bad.u = room(nu), bad.tau = room(nu);
            memcpy(bad.q, s.q, (size_t)(MOST * nq) * sizeof *good);
            memcpy(bad.u, s.u, (size_t)(MOST * nu) * sizeof *good);
            memcpy(bad.tau, s.tau, (size_t)(MOST * nu) * sizeof *good);
            for (int l = 0; l < 4; ++l) bad.q[2 * nq + turning->q + l] = 0.0;
            bad.q[4 * nq + 1] = NAN;
            bad.u[5 * nu] = INFINITY;
            bad.u[9 * nu + 2] = -1e200; /* overflows on the way */
            bad.tau[10 * nu] = NAN;
            expect(&bad, inverse != 0, bad.tau, 0.0);
            assert_int_equal(bad.expected_status[2], MBSR_ZERO_QUATERNION);
            assert_int_equal(bad.expected_status[9], MBSR_NOT_FINITE);
            assert_refused(evaluate(&bad, batch, inverse != 0, MOST, bad.tau, 0.0),
                           mbsr_batch_error(batch), MBSR_ZERO_QUATERNION, turning->id, MBSR_NONE,
                           "state 2: body");
            assert_int_equal(mbsr_batch_failed(batch), 2);
            assert_expected(&bad, MOST, 1e-10);
            int failures = 0;
            for (int i = 0; i < MOST; ++i) {
                failures += bad.status[i] != MBSR_OK;
                if (bad.status[i] == MBSR_OK)
                    assert_memory_equal(bad.out + i * nu, good + i * nu, (size_t)nu * sizeof *good);
            }
            assert_int_equal(failures, 5);
            assert_int_equal(mbsr_batch_one_by_one(batch), 5);
            /* forgotten by the next call */
            assert_ok(evaluate(&s, batch, inverse != 0, 1, s.tau, 0.0), NULL);
            assert_int_equal(mbsr_batch_failed(batch), -1);
            assert_int_equal(mbsr_batch_one_by_one(batch), 0);
            /* a time that is none */
            assert_int_equal(evaluate(&s, batch, inverse != 0, 3, s.tau, NAN), MBSR_NOT_FINITE);
            assert_int_equal(s.status[2], MBSR_NOT_FINITE);
            mbsr_batch_destroy(batch);
            free(bad.q), free(bad.u), free(bad.tau);
        }
    }
    free(good);
    drop(&s);
}

static void angles_far_from_zero_go_one_by_one(void **state)
{
    (void)state;
    const mbsri_batch_kernels *list[3];
    ensemble s;
    make(&s, (test_rigid_choice){.seed = 21, .bodies = 6, .length = 1.0});
    for (int i = 1; i <= s.tree.model->tree.plain->bodies; ++i) { /* welded ones are behind */
        const mbsri_body *b = s.tree.model->body + i;
        if (!(s.tree.model->tree.plain->body[i].flags & MBSRI_TURNS)) continue;
        if (s.tree.model->tree.plain->body[i].flags & MBSRI_SLIDES) continue;
        s.q[1 * s.tree.nq + b->q] = 99999.0 + i * 1e-3;
        s.q[4 * s.tree.nq + b->q] = -1e7 - i;
        s.q[6 * s.tree.nq + b->q] = 1e5 + i;
    }
    expect(&s, false, s.tau, 0.0);
    for (int k = 0; k < kernels(list); ++k) {
        mbsr_batch *batch;
        assert_ok(mbsri_batch_make(s.tree.model, list[k], &batch, NULL), NULL);
        assert_ok(evaluate(&s, batch, false, 8, s.tau, 0.0), mbsr_batch_error(batch));
        assert_expected(&s, 8, 1e-11);
        assert_int_equal(mbsr_batch_one_by_one(batch), 2);
        mbsr_batch_destroy(batch);
    }
    drop(&s);
}

/* A leaf without mass, whose motion no other number shows. */
static void what_moves_no_mass_is_checked_too(void **state)
{
    (void)state;
    const mbsri_batch_kernels *list[3];
    const double x[3] = {1.0, 0.0, 0.0}, at[3] = {0.0, 0.2, 1.0};
    mbsr_model *m;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    mbsr_body_def body = mbsr_default_body_def();
    body.joint = mbsr_joint_revolute(NULL, NULL, x);
    body.inertia = mbsr_inertia_point_mass(2.0, at);
    assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    body.parent = 0;
    body.inertia = mbsr_inertia_zero();
    body.joint = mbsr_joint_prismatic(NULL, NULL, x);
    assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    body.joint = mbsr_joint_spherical(NULL, NULL);
    assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    for (int k = 0; k < kernels(list); ++k) {
        mbsr_batch *batch;
        double q[5 * 6], u[5 * 5], udot[5 * 5], tau[5 * 5];
        int status[5];
        for (int l = 0; l < 30; ++l) q[l] = 0.1 * l;
        for (int l = 0; l < 25; ++l) u[l] = udot[l] = 0.2 * l;
        q[1 * 6 + 1] = NAN;
        u[2 * 5 + 1] = INFINITY;
        udot[3 * 5 + 1] = NAN;
        for (int l = 0; l < 4; ++l) q[4 * 6 + 2 + l] = 0.0;
        assert_ok(mbsri_batch_make(m, list[k], &batch, NULL), NULL);
        assert_int_equal(mbsr_batch_error(batch)->status, MBSR_OK);
        assert_int_equal(mbsr_batch_failed(batch), -1);
        assert_int_equal(mbsr_batch_one_by_one(batch), 0);
        assert_int_equal(mbsr_batch_inverse_dynamics(m, batch, 0.0, 5, q, u, udot, tau, status),
                         MBSR_NOT_FINITE);
        assert_int_equal(status[0], MBSR_OK);
        for (int l = 1; l < 4; ++l) assert_int_equal(status[l], MBSR_NOT_FINITE);
        assert_int_equal(status[4], MBSR_ZERO_QUATERNION);
        mbsr_batch_destroy(batch);
    }
    mbsr_model_destroy(m);
}

/* ---- force elements of joints ---- */

/* tau = -p0 sin(q) - p1 u^3 on every joint that it is given; fails where |u| > 100. */
static int stiffen(const mbsr_force_args *args)
{
    for (int b = 0; b < args->bodies; ++b) {
        const mbsr_force_body *body = args->body + b;
        for (int k = 0; k < body->n; ++k) {
            if (fabs(body->u[k]) > 100.0) return 23;
            body->tau[k] -= args->force->param[0] * sin(body->q[k]) +
                            args->force->param[1] * pow(body->u[k], 3.0);
        }
    }
    return 0;
}

static const mbsr_force_table stiffener = {.version = MBSR_FORCE_TABLE_VERSION,
                                           .flags = MBSR_FORCE_JOINT_ONLY,
                                           .name = "stiffener",
                                           .evaluate = stiffen};

static void force_elements_of_joints_act_in_every_state(void **state)
{
    (void)state;
    const mbsri_batch_kernels *list[3];
    const int both[2] = {1, 4}, all[3] = {0, 2, 3};
    mbsr_force_def forces[2] = {mbsr_force_custom(&stiffener, 2, both, NULL),
                                mbsr_force_custom(&stiffener, 3, all, NULL)};
    int failures = 0;
    forces[0].param[0] = 20.0, forces[0].param[1] = 3.0, forces[1].param[1] = 5.0;
    for (int k = 0; k < 8; ++k) {
        ensemble s;
        make(&s, (test_rigid_choice){.seed = 40 + (uint64_t)k,
                                     .bodies = 7,
                                     .many = k % 2 ? 0.2 : 0.0,
                                     .branching = 0.5,
                                     .length = 1.0,
                                     .moving = k % 3 == 0,
                                     .shuffle = k % 4 == 1,
                                     .elements = forces,
                                     .element_count = 2});
        assert_int_equal(compare(&s, 1e-11, 0.7), 0);
        const mbsri_body *first = s.tree.model->body + s.tree.model->index[0];
        double *fast = s.u + 2 * s.tree.nu + first->u, held = *fast;
        for (int l = 0; l < kernels(list) && first->n > 0; ++l) {
            mbsr_batch *batch;
            assert_ok(mbsri_batch_make(s.tree.model, list[l], &batch, NULL), NULL);
            *fast = 101.0; /* the element on body 0 fails for one state */
            assert_refused(evaluate(&s, batch, l == 1, 4, s.tau, 0.7), mbsr_batch_error(batch), 23,
                           MBSR_NONE, 2, "state 2: force 2 (stiffener)");
            *fast = held;
            assert_int_equal(mbsr_batch_one_by_one(batch), 1);
            assert_int_equal(s.status[3], MBSR_OK);
            mbsr_batch_destroy(batch);
            ++failures;
        }
        drop(&s);
    }
    assert_true(failures > 6);
}

/* ---- prescribed motion ---- */

/* sin(t); what it makes of its user's wish: fails, or a number that is none. */
static int drive(void *user, double t, double *s, double *sdot, double *sddot)
{
    const int *wish = user;
    if (*wish == 1) return 31;
    *s = sin(t), *sdot = cos(t), *sddot = *wish == 2 ? NAN : -sin(t);
    return 0;
}

static int shake(void *user, double t, double *p, double *V, double *A)
{
    const int *wish = user;
    if (*wish == 3) return 17;
    p[MBSR_POSE_R] = p[MBSR_POSE_R + 4] = p[MBSR_POSE_R + 8] = 1.0;
    p[MBSR_POSE_X] = t * t, V[3] = 2.0 * t, A[3] = 2.0;
    return 0;
}

/* A massless slider that is driven along x and carries a pendulum about y, on a root that moves
 * along x. With the slider's x = sin(t) and the root's t^2,
 *   m l^2 q'' = tau - m g l sin(q) - m l cos(q) (2 - sin(t)) */
static void motions_are_prescribed_to_all_states(void **state)
{
    (void)state;
    const mbsri_batch_kernels *list[3];
    const double y[3] = {0.0, -1.0, 0.0}, at[3] = {0.0, 0.0, -0.5};
    const mbsr_axis along = {
        .kind = MBSR_AXIS_TRANSLATION, .direction = {1.0, 0.0, 0.0}, .driven = 1};
    static const int expected[] = {MBSR_OK, 31, MBSR_NOT_FINITE, 17};
    int wish = 0;
    mbsr_model *m;
    mbsr_model_def def = mbsr_default_model_def();
    def.root = mbsr_root_moving(MBSR_SPACE_SPATIAL, 6, MBSR_POSE_SIZE, shake, &wish);
    assert_ok(mbsr_model_create(&def, &m, NULL), NULL);
    mbsr_body_def body = mbsr_default_body_def();
    body.joint = mbsr_joint_compound(NULL, NULL, 1, &along, drive, &wish);
    assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    body.parent = 0;
    body.joint = mbsr_joint_revolute(NULL, NULL, y);
    body.inertia = mbsr_inertia_point_mass(2.0, at);
    assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    const mbsr_force_def gravity = mbsr_force_gravity(0.0, 0.0, -9.81);
    assert_ok(mbsr_model_add_force(m, &gravity, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    for (int k = 0; k < kernels(list); ++k) {
        const double q[3] = {0.1, 0.7, -2.0}, u[3] = {1.0, 0.0, 5.0}, tau[3] = {0.0, 1.0, 2.0},
                     t = 0.6;
        double udot[3];
        int status[3];
        mbsr_batch *batch;
        assert_ok(mbsri_batch_make(m, list[k], &batch, NULL), NULL);
        for (wish = 0; wish < 4; ++wish) {
            assert_int_equal(mbsr_batch_forward_dynamics(m, batch, t, 3, q, u, tau, udot, status),
                             expected[wish]);
            assert_int_equal(mbsr_batch_one_by_one(batch), wish == 0 ? 0 : 3);
            for (int l = 0; l < 3; ++l) {
                assert_int_equal(status[l], expected[wish]);
                const double force = tau[l] - 9.81 * sin(q[l]) - cos(q[l]) * (2.0 - sin(t));
                if (wish == 0) assert_close(udot[l], force / 0.5, 1e-13);
            }
        }
        mbsr_batch_destroy(batch);
    }
    mbsr_model_destroy(m);
}

/* ---- bodies in the plane ---- */

enum { PLANAR_BODIES = 12, PLANAR_STATES = 10, PLANAR_MOST = 3 * PLANAR_BODIES };

/* A tree of hinges; every other joint is one (0), a slide (1), or free (2). */
static mbsr_model *planar_tree(int other)
{
    const mbsr_planar_frame end = {1.0, 0.0, 0.3}, at = {0.0, 0.1, 0.0};
    const double com[2] = {0.5, 0.1};
    const mbsr_joint joint[3] = {mbsr_joint_planar_revolute(end, at),
                                 mbsr_joint_planar_prismatic(end, at),
                                 mbsr_joint_planar_free(end, at)};
    const mbsr_force_def gravity = mbsr_force_gravity(1.0, -9.81, 0.0);
    mbsr_model *m;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    for (int i = 0; i < PLANAR_BODIES; ++i) {
        mbsr_body_def body = mbsr_default_body_def();
        body.parent = i == 0 ? MBSR_GROUND : i % 3 == 2 ? i - 2 : i - 1;
        body.joint = joint[i % 2 ? other : 0];
        body.inertia = mbsr_inertia_planar(1.0 + i, com, 0.1);
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    }
    assert_ok(mbsr_model_add_force(m, &gravity, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    return m;
}

static void trees_in_the_plane(void **state)
{
    (void)state;
    for (int other = 0; other < 3; ++other) {
        mbsr_model *m = planar_tree(other);
        mbsr_batch *batch;
        mbsr_data *data;
        double q[PLANAR_STATES * PLANAR_MOST], u[PLANAR_STATES * PLANAR_MOST],
            udot[PLANAR_STATES * PLANAR_MOST], expected[PLANAR_MOST];
        const int nu = mbsr_model_nu(m);
        for (int k = 0; k < PLANAR_STATES * nu; ++k) {
            q[k] = sin(k);
            u[k] = cos(3.0 * k);
        }
        assert_ok(mbsr_data_create(m, &data, NULL), NULL);
        assert_ok(mbsr_batch_create(m, &batch, NULL), NULL);
        assert_ok(mbsr_batch_forward_dynamics(m, batch, 0.0, PLANAR_STATES, q, u, NULL, udot, NULL),
                  mbsr_batch_error(batch));
        assert_int_equal(mbsr_batch_one_by_one(batch), 0);
        for (int k = 0; k < PLANAR_STATES; ++k) {
            assert_ok(mbsr_forward_dynamics(m, data, 0.0, q + k * nu, u + k * nu, NULL, expected),
                      mbsr_data_error(data));
            for (int l = 0; l < nu; ++l)
                assert_close(udot[k * nu + l], expected[l], 1e-11 * (1.0 + fabs(expected[l])));
        }
        mbsr_batch_destroy(batch);
        mbsr_data_destroy(data);
        mbsr_model_destroy(m);
    }
}

/* Several states of any model; returns how many went one by one. */
static int compare_states(const mbsr_model *m, mbsr_data *data, double t, double tolerance)
{
    enum { STATES = 5 };
    const int nq = mbsr_model_nq(m), nu = mbsr_model_nu(m);
    const mbsri_batch_kernels *list[3];
    double *q = malloc((size_t)(STATES * (nq + 3 * nu) + nu + 1) * sizeof *q), *u = q + STATES * nq,
           *load = u + STATES * nu, *out = load + STATES * nu, *expected = out + STATES * nu;
    int single = 0, status[STATES];
    test_rng rng = test_seed(21);
    test_fill(&rng, STATES * (nq + 2 * nu), q);
    for (int way = 0; way < 2 * kernels(list); ++way) {
        mbsr_batch *batch;
        assert_ok(mbsri_batch_make(m, list[way / 2], &batch, NULL), NULL);
        if (way % 2)
            (void)mbsr_batch_inverse_dynamics(m, batch, t, STATES, q, u, load, out, status);
        else
            (void)mbsr_batch_forward_dynamics(m, batch, t, STATES, q, u, load, out, status);
        for (int k = 0; k < STATES; ++k) {
            const double *a = q + k * nq, *b = u + k * nu, *c = load + k * nu;
            const int one = way % 2 ? mbsr_inverse_dynamics(m, data, t, a, b, c, NULL, expected)
                                    : mbsr_forward_dynamics(m, data, t, a, b, c, expected);
            assert_int_equal(status[k], one);
            for (int l = 0; l < nu; ++l)
                assert_close(out[k * nu + l], expected[l], tolerance * scale_of(nu, expected));
        }
        single += mbsr_batch_one_by_one(batch);
        mbsr_batch_destroy(batch);
    }
    free(q);
    return single;
}

/* Points, bodies in the plane with inertias by function, on moving roots, and GENERAL bodies. */
static void trees_of_all_kinds(void **state)
{
    (void)state;
    static test_plane_tree plane;
    static mixed any;
    int served = 0, trees = 0;
    for (int k = 0; k < 60; ++k, ++trees) {
        test_plane_make(&plane, (test_plane_choice){.seed = 900 + (uint64_t)k,
                                                    .bodies = 2 + k % (TEST_PLANE_BODIES - 1),
                                                    .functions = k % 2,
                                                    .moving = k % 4 == 0,
                                                    .damped = k % 3 > 0});
        served += compare_states(plane.model, plane.data, plane.t, 1e-10) == 0;
        test_plane_free(&plane);
    }
    for (int k = 0; k < 4 * MIXED_ALL; ++k, ++trees) {
        mixed_make(&any, (mixed_scene)(k % MIXED_ALL));
        served += compare_states(any.model, any.data, 0.1 * k, 1e-10) == 0;
        mixed_free(&any);
    }
    print_message("%d of %d trees served in lanes alone\n", served, trees);
    assert_true(served > trees / 2);
}

/* ---- models that the lanes do not serve ---- */

/* Of nothing but bodies with inertias of their own. */
static mbsr_model *unserved(void)
{
    static const double anisotropic[9] = {1.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 0.3};
    mbsr_model *m;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    mbsr_body_def body = mbsr_default_body_def();
    body.joint = mbsr_joint_planar_revolute((mbsr_planar_frame){0.0, 0.0, 0.0},
                                            (mbsr_planar_frame){0.5, 0.0, 0.0});
    body.inertia = mbsr_inertia_matrix(3, anisotropic);
    for (int i = 0; i < 2; ++i) {
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
        body.parent = i;
    }
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    return m;
}

static void other_models_go_one_by_one(void **state)
{
    (void)state;
    mbsr_model *m = unserved();
    mbsr_data *data;
    mbsr_batch *batch;
    const double q[6] = {0.1, 0.4, -0.2, 0.9, 1.5, -2.0}, u[6] = {1.0, 2.0, 0.5, 0.0, -1.0, 1.0},
                 tau[6] = {0.3, -0.3, 0.2, 0.1, 0.0, 2.0};
    double out[6], expected[2];
    assert_int_equal(mbsr_model_nu(m), 2);
    assert_ok(mbsr_data_create(m, &data, NULL), NULL);
    assert_ok(mbsr_batch_create(m, &batch, NULL), NULL);
    assert_int_equal(mbsr_batch_lanes(batch), 1);
    for (int inverse = 0; inverse < 2; ++inverse) {
        assert_ok(inverse ? mbsr_batch_inverse_dynamics(m, batch, 0.3, 3, q, u, tau, out, NULL)
                          : mbsr_batch_forward_dynamics(m, batch, 0.3, 3, q, u, tau, out, NULL),
                  mbsr_batch_error(batch));
        assert_int_equal(mbsr_batch_one_by_one(batch), 3);
        for (int k = 0; k < 3; ++k) {
            const double *a = q + 2 * k, *b = u + 2 * k, *c = tau + 2 * k;
            assert_ok(inverse ? mbsr_inverse_dynamics(m, data, 0.3, a, b, c, NULL, expected)
                              : mbsr_forward_dynamics(m, data, 0.3, a, b, c, expected),
                      mbsr_data_error(data));
            assert_memory_equal(out + 2 * k, expected, sizeof expected);
        }
    }
    mbsr_batch_destroy(batch);
    mbsr_data_destroy(data);
    mbsr_model_destroy(m);
}

/* ---- the object ---- */

static void memory_is_taken_once_and_given_back(void **state)
{
    (void)state;
    test_counting counting = {0};
    mbsr_model_def def = mbsr_default_model_def();
    mbsr_error error;
    mbsr_batch *batch;
    def.allocator = test_counting_allocator(&counting);
    ensemble s;
    make(&s, (test_rigid_choice){.seed = 4,
                                 .bodies = 9,
                                 .many = 0.3,
                                 .massless = 0.2,
                                 .branching = 0.4,
                                 .length = 1.0,
                                 .def = &def});
    const long live = counting.live;
    counting.fail_at = counting.calls + 1;
    assert_refused(mbsr_batch_create(s.tree.model, &batch, &error), &error, MBSR_ERR_NO_MEMORY,
                   MBSR_NONE, MBSR_NONE, "mbsr_batch_create: no memory for ");
    assert_null(batch);
    counting.fail_at = 0;
    assert_ok(mbsr_batch_create(s.tree.model, &batch, &error), &error);
    assert_int_equal(counting.live, live + 1);
    const long calls = counting.calls;
    s.q[3 * s.tree.nq] = NAN;
    for (int inverse = 0; inverse < 2; ++inverse)
        assert_int_not_equal(evaluate(&s, batch, inverse != 0, MOST, s.tau, 0.0), MBSR_OK);
    assert_int_equal(counting.calls, calls);
    mbsr_batch_destroy(batch);
    assert_int_equal(counting.live, live);
    mbsr_batch_destroy(NULL);
    drop(&s);
    assert_int_equal(counting.live, 0);
}

static void the_widest_kernels_are_chosen(void **state)
{
    (void)state;
    const mbsri_batch_kernels *list[3];
    const int count = kernels(list);
    ensemble s;
    mbsr_batch *batch;
    make(&s, (test_rigid_choice){.seed = 4, .bodies = 2, .length = 1.0});
    assert_ok(mbsr_batch_create(s.tree.model, &batch, NULL), NULL);
    assert_int_equal(mbsr_batch_lanes(batch), list[count - 1]->lanes);
    assert_string_equal(batch->kernels->name, list[count - 1]->name);
    mbsr_batch_destroy(batch);
    drop(&s);
}

static void wrong_calls_are_refused(void **state)
{
    (void)state;
    ensemble s, other;
    mbsr_error error;
    mbsr_batch *batch;
    mbsr_model *raw;
    make(&s, (test_rigid_choice){.seed = 4, .bodies = 2, .length = 1.0});
    make(&other, (test_rigid_choice){.seed = 5, .bodies = 2, .length = 1.0});
    const mbsr_model *m = s.tree.model;
    assert_ok(mbsr_model_create(NULL, &raw, NULL), NULL);
    assert_refused(mbsr_batch_create(raw, &batch, &error), &error, MBSR_ERR_UNFINISHED, MBSR_NONE,
                   MBSR_NONE, "mbsr_batch_create|not finished");
    assert_null(batch);
    assert_refused(mbsr_batch_create(NULL, &batch, &error), &error, MBSR_ERR_NULL, MBSR_NONE,
                   MBSR_NONE, "model is NULL");
    assert_refused(mbsr_batch_create(m, NULL, &error), &error, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE,
                   "batch is NULL");
    assert_ok(mbsr_batch_create(m, &batch, &error), &error);
    const mbsr_error *last = mbsr_batch_error(batch);
    assert_int_equal(mbsr_batch_forward_dynamics(m, NULL, 0.0, 1, s.q, s.u, NULL, s.out, s.status),
                     MBSR_ERR_NULL);
    assert_refused(mbsr_batch_forward_dynamics(NULL, batch, 0.0, 1, s.q, s.u, NULL, s.out, NULL),
                   last, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "mbsr_batch_forward_dynamics|NULL");
    assert_refused(mbsr_batch_forward_dynamics(m, batch, 0.0, 1, s.q, s.u, NULL, NULL, NULL), last,
                   MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "mbsr_batch_forward_dynamics|NULL");
    assert_refused(mbsr_batch_inverse_dynamics(m, batch, 0.0, 1, s.q, s.u, NULL, s.out, NULL), last,
                   MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "mbsr_batch_inverse_dynamics|NULL");
    assert_refused(
        mbsr_batch_forward_dynamics(other.tree.model, batch, 0.0, 1, s.q, s.u, NULL, s.out, NULL),
        last, MBSR_ERR_MISMATCH, MBSR_NONE, MBSR_NONE, "another model");
    assert_refused(mbsr_batch_inverse_dynamics(m, batch, 0.0, 0, s.q, s.u, s.tau, s.out, NULL),
                   last, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE, "states is 0");
    assert_int_equal(mbsr_batch_lanes(NULL), 0);
    assert_int_equal(mbsr_batch_failed(NULL), -1);
    assert_int_equal(mbsr_batch_one_by_one(NULL), 0);
    assert_int_equal(mbsr_batch_error(NULL)->status, MBSR_ERR_NULL);
    mbsr_batch_destroy(batch);
    mbsr_model_destroy(raw);
    drop(&other);
    drop(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_state_is_what_a_call_of_its_own_gives),
        cmocka_unit_test(joints_of_several_axes_are_taken_apart),
        cmocka_unit_test(bodies_of_other_kinds_take_part),
        cmocka_unit_test(states_without_full_rank_go_one_by_one),
        cmocka_unit_test(no_rank_in_doubt_passes_for_full),
        cmocka_unit_test(rods_along_their_axes_have_no_rank),
        cmocka_unit_test(heavy_bodies_cast_doubt_on_light_ones),
        cmocka_unit_test(errors_grow_with_the_inverse_of_a_lever),
        cmocka_unit_test(a_rank_that_drops_in_one_state_is_that_state_s_own),
        cmocka_unit_test(no_result_depends_on_the_states_beside_it),
        cmocka_unit_test(states_that_fail_do_not_touch_the_others),
        cmocka_unit_test(what_moves_no_mass_is_checked_too),
        cmocka_unit_test(angles_far_from_zero_go_one_by_one),
        cmocka_unit_test(force_elements_of_joints_act_in_every_state),
        cmocka_unit_test(motions_are_prescribed_to_all_states),
        cmocka_unit_test(trees_in_the_plane),
        cmocka_unit_test(trees_of_all_kinds),
        cmocka_unit_test(other_models_go_one_by_one),
        cmocka_unit_test(memory_is_taken_once_and_given_back),
        cmocka_unit_test(the_widest_kernels_are_chosen),
        cmocka_unit_test(wrong_calls_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
