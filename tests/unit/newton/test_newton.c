/* The O(N) Newton solver as an object: what it refuses, its memory, repeated and interleaved use.
 * That it solves the right system: property/test_newton.c. Singular systems:
 * test_newton_singular.c.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "body.h"
#include "counting.h"
#include "expect.h"
#include "newton_scene.h"
#include "rigid_tree.h"
#include "tree.h"
#include "twins.h"
#include "web.h"

#include <mbsrank/driver.h>

#include <stdbool.h>
#include <stdlib.h>

enum { MOST = 128 };

/* A tree of rigid bodies with springs and bushings, its state, and a right-hand side. */
typedef struct scene {
    test_rigid_tree tree;
    test_newton_state s;
    double r[MOST], delta[MOST];
} scene;

static void open_scene(scene *x, test_rigid_choice choice)
{
    if (choice.seed == 0) choice.seed = 8;
    if (choice.bodies == 0) choice.bodies = 6;
    test_newton_scene(&x->tree, &x->s, choice, MOST, x->r);
}

static void close_scene(scene *x)
{
    test_newton_scene_free(&x->tree, &x->s);
}

static mbsr_newton *create(const mbsr_model *model, const mbsr_newton_opt *opt)
{
    mbsr_newton *newton;
    mbsr_error error;
    assert_ok(mbsr_newton_create(model, MBSR_DAE_MOMENTUM, opt, &newton, &error), &error);
    return newton;
}

static int factor(mbsr_newton *newton, const scene *x, double c)
{
    return mbsr_newton_factor(newton, x->s.data, x->s.t, x->s.y, x->s.yp, c);
}

static void solve(mbsr_newton *newton, const double *r, double *delta)
{
    assert_ok(mbsr_newton_solve(newton, r, delta), mbsr_newton_error(newton));
}

static mbsr_newton_info info_of(const mbsr_newton *newton)
{
    mbsr_newton_info info;
    assert_int_equal(mbsr_newton_get_info(newton, &info), MBSR_OK);
    return info;
}

static void assert_same(int n, const double *x, const double *y)
{
    assert_memory_equal(x, y, (size_t)n * sizeof *x);
}

/* ---- creation ---- */

static void refuse_create(const mbsr_model *model, mbsr_dae_form form, const mbsr_newton_opt *opt,
                          int status, int body, const char *words)
{
    mbsr_newton *newton = (mbsr_newton *)&status;
    mbsr_error error = {0};
    assert_refused(mbsr_newton_create(model, form, opt, &newton, &error), &error, status, body,
                   MBSR_NONE, words);
    assert_null(newton);
    assert_int_equal(mbsr_newton_create(model, form, opt, &newton, NULL), status);
}

static void what_is_wrong_is_refused_at_creation(void **state)
{
    (void)state;
    scene x;
    mbsr_newton_opt opt = mbsr_default_newton_opt();
    mbsr_model *empty;
    mbsr_error error;
    open_scene(&x, (test_rigid_choice){.forces = 1});
    const mbsr_model *m = x.s.model;
    refuse_create(NULL, MBSR_DAE_MOMENTUM, NULL, MBSR_ERR_NULL, MBSR_NONE, "model is NULL");
    assert_refused(mbsr_newton_create(m, MBSR_DAE_MOMENTUM, NULL, NULL, &error), &error,
                   MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "newton is NULL");
    static const mbsr_dae_form others[] = {MBSR_DAE_RECURSIVE, MBSR_DAE_INVERSE_DYNAMICS,
                                           MBSR_DAE_INDEX1, (mbsr_dae_form)77};
    for (int k = 0; k < 4; ++k)
        refuse_create(m, others[k], NULL, MBSR_ERR_VALUE, MBSR_NONE, "MBSR_DAE_MOMENTUM|form");
    opt.method = (mbsr_newton_method)4;
    refuse_create(m, MBSR_DAE_MOMENTUM, &opt, MBSR_ERR_VALUE, MBSR_NONE, "method is 4");
    opt.method = (mbsr_newton_method)-1;
    refuse_create(m, MBSR_DAE_MOMENTUM, &opt, MBSR_ERR_VALUE, MBSR_NONE, "method is -1");
    opt.method = MBSR_NEWTON_AUTO;
    opt.max_rank = -1;
    refuse_create(m, MBSR_DAE_MOMENTUM, &opt, MBSR_ERR_VALUE, MBSR_NONE, "max_rank is -1");
    opt.max_rank = 0;
    opt.cookie = 0;
    refuse_create(m, MBSR_DAE_MOMENTUM, &opt, MBSR_ERR_NO_DEFAULT, MBSR_NONE,
                  "mbsr_default_newton_opt");
    assert_ok(mbsr_model_create(NULL, &empty, NULL), NULL);
    refuse_create(empty, MBSR_DAE_MOMENTUM, NULL, MBSR_ERR_UNFINISHED, MBSR_NONE, "not finished");
    mbsr_model_destroy(empty);
    mbsr_newton_destroy(NULL);
    close_scene(&x);
}

/* A general body with a pose of three numbers and two velocities, or a body that follows such a
 * one. */
static int odd_position(const mbsr_joint_args *args, double *p)
{
    for (int k = 0; k < args->np; ++k) p[k] = args->q[k % args->nq];
    return 0;
}

static int odd_jacobians(const mbsr_joint_args *args, double *K, double *H, double *J, double *kI)
{
    (void)K, (void)H, (void)kI;
    for (int k = 0; k < args->n; ++k) J[k * args->d + k] = -1.0;
    return 0;
}

static int odd_bias(const mbsr_joint_args *args, double *kII)
{
    (void)args, (void)kII;
    return 0;
}

static int odd_rates(const mbsr_joint_args *args, double *Kdot, double *Hdot, double *Jdot)
{
    (void)args, (void)Kdot, (void)Hdot, (void)Jdot;
    return 0;
}

static int odd_inertia(void *user, double t, const double *p, const double *V, double *M, double *h)
{
    (void)user, (void)t, (void)p, (void)V, (void)h;
    M[0] = M[3] = 1.0;
    return 0;
}

static const mbsr_joint_table odd_known = {.version = MBSR_JOINT_TABLE_VERSION,
                                           .flags = MBSR_JOINT_UNIT_K,
                                           .name = "odd",
                                           .position = odd_position,
                                           .jacobians = odd_jacobians,
                                           .bias = odd_bias,
                                           .rates = odd_rates},
                              odd_bare = {.version = MBSR_JOINT_TABLE_VERSION,
                                          .flags = MBSR_JOINT_UNIT_K,
                                          .name = "odd",
                                          .position = odd_position,
                                          .jacobians = odd_jacobians,
                                          .bias = odd_bias};

static mbsr_model *odd_model(const mbsr_joint_table *table, bool by_function)
{
    static const double unit[4] = {1.0, 0.0, 0.0, 1.0};
    mbsr_model *m;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    for (int k = 0; k < 2; ++k) {
        mbsr_body_def body = mbsr_default_body_def();
        body.name = k ? "follower" : "leader";
        body.parent = k - 1;
        body.joint = mbsr_joint_custom(k ? table : &odd_known, 2, 2, NULL);
        body.joint.np = k ? 2 : 3;
        body.inertia = by_function && k == 0 ? mbsr_inertia_function(odd_inertia, NULL)
                                             : mbsr_inertia_matrix(2, unit);
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    }
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    return m;
}

static void rates_that_cannot_be_differenced_are_refused(void **state)
{
    (void)state;
    mbsr_model *m = odd_model(&odd_bare, false);
    refuse_create(m, MBSR_DAE_MOMENTUM, NULL, MBSR_ERR_SPACE, 1, "follower|its joint");
    mbsr_model_destroy(m);
    m = odd_model(&odd_known, true);
    refuse_create(m, MBSR_DAE_MOMENTUM, NULL, MBSR_ERR_SPACE, 0, "leader|its inertia");
    mbsr_model_destroy(m);
    m = odd_model(&odd_known, false);
    mbsr_newton_destroy(create(m, NULL));
    mbsr_model_destroy(m);
}

/* ---- factoring and solving ---- */

static void what_is_wrong_is_refused_later(void **state)
{
    (void)state;
    scene x, other;
    open_scene(&x, (test_rigid_choice){.forces = 1});
    open_scene(&other, (test_rigid_choice){.seed = 9});
    mbsr_newton *newton = create(x.s.model, NULL);
    const mbsr_error *error = mbsr_newton_error(newton);
    const test_newton_state *s = &x.s;
    assert_int_equal(error->status, MBSR_OK);
    assert_string_equal(error->text, "");

    /* no object */
    assert_int_equal(mbsr_newton_factor(NULL, s->data, s->t, s->y, s->yp, 1.0), MBSR_ERR_NULL);
    assert_int_equal(mbsr_newton_solve(NULL, x.r, x.delta), MBSR_ERR_NULL);
    assert_int_equal(mbsr_newton_get_info(NULL, &(mbsr_newton_info){0}), MBSR_ERR_NULL);
    assert_int_equal(mbsr_newton_get_info(newton, NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_newton_error(NULL)->status, MBSR_ERR_NULL);
    assert_contains(mbsr_newton_error(NULL)->text, "NULL");

    /* solving comes after factoring */
    assert_refused(mbsr_newton_solve(newton, x.r, x.delta), error, MBSR_ERR_SEQUENCE, MBSR_NONE,
                   MBSR_NONE, "mbsr_newton_solve|no factorisation");

    assert_refused(mbsr_newton_factor(newton, NULL, s->t, s->y, s->yp, 1.0), error, MBSR_ERR_NULL,
                   MBSR_NONE, MBSR_NONE, "mbsr_newton_factor|NULL");
    assert_refused(mbsr_newton_factor(newton, s->data, s->t, NULL, s->yp, 1.0), error,
                   MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "NULL");
    assert_refused(mbsr_newton_factor(newton, s->data, s->t, s->y, NULL, 1.0), error, MBSR_ERR_NULL,
                   MBSR_NONE, MBSR_NONE, "NULL");
    assert_refused(mbsr_newton_factor(newton, other.s.data, s->t, s->y, s->yp, 1.0), error,
                   MBSR_ERR_MISMATCH, MBSR_NONE, MBSR_NONE, "another model");
    static const double wrong[] = {0.0, -0.0, NAN, INFINITY, -INFINITY};
    for (int k = 0; k < 5; ++k) {
        assert_refused(factor(newton, &x, wrong[k]), error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                       "c is");
    }

    /* a failure takes the factorisation away */
    assert_ok(factor(newton, &x, 3.0), error);
    assert_refused(factor(newton, &x, 0.0), error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE, "c is 0");
    assert_refused(mbsr_newton_solve(newton, x.r, x.delta), error, MBSR_ERR_SEQUENCE, MBSR_NONE,
                   MBSR_NONE, "no factorisation");
    assert_ok(factor(newton, &x, 3.0), error);
    assert_refused(mbsr_newton_solve(newton, NULL, x.delta), error, MBSR_ERR_NULL, MBSR_NONE,
                   MBSR_NONE, "mbsr_newton_solve|NULL");
    assert_refused(mbsr_newton_solve(newton, x.r, NULL), error, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE,
                   "NULL");
    solve(newton, x.r, x.delta); /* which takes no factorisation away */
    mbsr_newton_destroy(newton);
    close_scene(&x);
    close_scene(&other);
}

/* By vector code, by blocks, and with a correction. */
static const test_rigid_choice variants[3] = {
    {.seed = 8}, {.seed = 8, .forces = 2}, {.seed = 9, .forces = 1}};

static void what_is_not_finite_is_refused_and_nothing_written(void **state)
{
    (void)state;
    for (int v = 0; v < 3; ++v) {
        scene x;
        open_scene(&x, variants[v]);
        const int n = x.s.n;
        mbsr_newton *newton = create(x.s.model, NULL);
        const mbsr_error *error = mbsr_newton_error(newton);
        double expected[MOST], held[MOST];
        assert_ok(factor(newton, &x, 3.0), error);
        solve(newton, x.r, expected);
        for (int k = 0; k < n; ++k) held[k] = x.delta[k] = 17.0 + k;
        static const double bad[] = {NAN, INFINITY, -INFINITY};
        for (int k = 0; k < n; ++k) {
            const double r = x.r[k];
            x.r[k] = bad[k % 3];
            assert_refused(mbsr_newton_solve(newton, x.r, x.delta), error, MBSR_NOT_FINITE,
                           MBSR_NONE, MBSR_NONE, "r is not finite");
            x.r[k] = r;
        }
        /* an overflow on the way */
        double large[MOST];
        for (int k = 0; k < n; ++k) large[k] = 1e308 * (k % 2 ? -1.0 : 1.0);
        assert_refused(mbsr_newton_solve(newton, large, x.delta), error, MBSR_NOT_FINITE, MBSR_NONE,
                       MBSR_NONE, "solution is not finite");
        assert_same(n, x.delta, held);
        solve(newton, x.r, x.delta);
        assert_same(n, x.delta, expected);

        /* a state that is not finite */
        const int entries[] = {0, x.s.nq + x.s.nu, n - 1};
        for (int k = 0; k < 3; ++k) {
            const double y = x.s.y[entries[k]];
            x.s.y[entries[k]] = bad[k];
            assert_int_equal(factor(newton, &x, 3.0), MBSR_NOT_FINITE);
            assert_int_equal(error->status, MBSR_NOT_FINITE);
            assert_int_equal(mbsr_newton_solve(newton, x.r, x.delta), MBSR_ERR_SEQUENCE);
            x.s.y[entries[k]] = y;
        }
        assert_ok(factor(newton, &x, 3.0), error);
        solve(newton, x.r, x.delta);
        assert_same(n, x.delta, expected);
        mbsr_newton_destroy(newton);
        close_scene(&x);
    }
}

static void r_and_delta_may_be_the_same(void **state)
{
    (void)state;
    for (int v = 0; v < 3; ++v) {
        scene x;
        open_scene(&x, variants[v]);
        mbsr_newton *newton = create(x.s.model, NULL);
        double held[MOST];
        memcpy(held, x.r, sizeof held);
        assert_ok(factor(newton, &x, -40.0), mbsr_newton_error(newton));
        solve(newton, x.r, x.delta);
        assert_same(x.s.n, x.r, held);
        solve(newton, x.r, x.r);
        assert_same(x.s.n, x.r, x.delta);
        mbsr_newton_destroy(newton);
        close_scene(&x);
    }
}

static void factoring_anew_leaves_nothing_behind(void **state)
{
    (void)state;
    for (int v = 0; v < 3; ++v) {
        scene x;
        open_scene(&x, variants[v]);
        const size_t bytes = 2 * (size_t)x.s.n * sizeof(double);
        mbsr_newton *newton = create(x.s.model, NULL), *fresh;
        double expected[MOST], y[2 * MOST];
        memcpy(y, x.s.y, bytes);
        assert_ok(factor(newton, &x, 3.0), mbsr_newton_error(newton));
        solve(newton, x.r, x.delta);
        for (int k = 0; k < x.s.n; ++k) x.s.y[k] += 0.1 * sin(1.0 + k);
        assert_ok(factor(newton, &x, 500.0), mbsr_newton_error(newton));
        solve(newton, x.r, x.delta);
        fresh = create(x.s.model, NULL);
        assert_ok(factor(fresh, &x, 500.0), mbsr_newton_error(fresh));
        /* the data is not needed any more */
        assert_ok(mbsr_stage_positions(x.s.model, x.s.data, 9.0, y), mbsr_data_error(x.s.data));
        solve(fresh, x.r, expected);
        assert_same(x.s.n, x.delta, expected);
        solve(newton, x.r, x.delta);
        assert_same(x.s.n, x.delta, expected);
        mbsr_newton_destroy(newton);
        mbsr_newton_destroy(fresh);
        close_scene(&x);
    }
}

static void two_solvers_share_data(void **state)
{
    (void)state;
    for (int v = 0; v < 3; ++v) {
        scene x;
        open_scene(&x, variants[v]);
        mbsr_newton *one = create(x.s.model, NULL), *two = create(x.s.model, NULL);
        double first[MOST], second[MOST];
        assert_ok(factor(one, &x, 3.0), mbsr_newton_error(one));
        solve(one, x.r, first);
        assert_ok(factor(two, &x, 300.0), mbsr_newton_error(two));
        solve(two, x.r, second);
        solve(one, x.r, x.delta);
        assert_same(x.s.n, x.delta, first);
        mbsr_newton_destroy(one);
        solve(two, x.r, x.delta);
        assert_same(x.s.n, x.delta, second);
        assert_true(test_newton_distance(&x.s, first, second) > 0.1);
        mbsr_newton_destroy(two);
        close_scene(&x);
    }
}

static void the_data_is_left_at_mbsr_backward(void **state)
{
    (void)state;
    for (int v = 0; v < 3; ++v) {
        scene x;
        double pose[12], expected[12];
        mbsr_rank_info rank;
        open_scene(&x, variants[v]);
        const test_newton_state *s = &x.s;
        assert_ok(mbsr_stage_positions(s->model, s->data, s->t, s->y), mbsr_data_error(s->data));
        assert_ok(mbsr_body_pose(s->model, s->data, 3, expected), mbsr_data_error(s->data));
        assert_ok(mbsr_stage_positions(s->model, s->data, 0.0, x.r), mbsr_data_error(s->data));
        mbsr_newton *newton = create(s->model, NULL);
        assert_ok(factor(newton, &x, 3.0), mbsr_newton_error(newton));
        assert_ok(mbsr_body_pose(s->model, s->data, 3, pose), mbsr_data_error(s->data));
        for (int k = 0; k < 12; ++k) assert_close(pose[k], expected[k], 1e-14);
        assert_ok(mbsr_body_rank(s->model, s->data, 3, &rank), mbsr_data_error(s->data));
        assert_true(mbsr_total_rank(s->model, s->data) == s->nu);
        mbsr_newton_destroy(newton);
        close_scene(&x);
    }
}

static void ranks_that_are_watched_stop_it(void **state)
{
    (void)state;
    twins s;
    twins_make(&s, 0.0);
    mbsr_newton *newton = create(s.model, NULL);
    double apart[12] = {0.1, -0.1, 0.3, 0.8}, parallel[12] = {0.1, -0.1, 0.3, 0.3}, yp[12] = {0};
    assert_int_equal(mbsr_dae_size(s.model, MBSR_DAE_MOMENTUM), 12);
    assert_ok(mbsr_newton_factor(newton, s.data, 0.0, apart, yp, 10.0), mbsr_newton_error(newton));
    assert_ok(mbsr_rank_watch(s.model, s.data, 1), mbsr_data_error(s.data));
    assert_ok(mbsr_newton_factor(newton, s.data, 0.0, apart, yp, 10.0), mbsr_newton_error(newton));
    assert_refused(mbsr_newton_factor(newton, s.data, 0.0, parallel, yp, 10.0),
                   mbsr_newton_error(newton), MBSR_RANK_CHANGED, 0, MBSR_NONE, "bead");
    assert_ok(mbsr_rank_watch(s.model, s.data, 0), mbsr_data_error(s.data));
    assert_ok(mbsr_newton_factor(newton, s.data, 0.0, parallel, yp, 10.0),
              mbsr_newton_error(newton));
    mbsr_newton_destroy(newton);
    twins_free(&s);
}

/* ---- memory ---- */

static void every_allocation_may_fail(void **state)
{
    (void)state;
    for (int v = 0; v < 3; ++v) {
        test_counting counting = {0};
        mbsr_model_def def = mbsr_default_model_def();
        test_rigid_choice choice = variants[v];
        scene x;
        def.allocator = test_counting_allocator(&counting);
        choice.def = &def;
        open_scene(&x, choice);
        const long before = counting.live, calls = counting.calls;
        mbsr_newton *newton = create(x.s.model, NULL);
        const long needed = counting.calls - calls;
        mbsr_newton_destroy(newton);
        assert_int_equal(counting.live, before);
        assert_in_range(needed, 2, 40);
        for (long k = 1; k <= needed; ++k) {
            counting.fail_at = counting.calls + k;
            counting.failed = 0;
            mbsr_error error = {0};
            assert_refused(mbsr_newton_create(x.s.model, MBSR_DAE_MOMENTUM, NULL, &newton, &error),
                           &error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE, "no memory|bodies");
            assert_null(newton);
            assert_int_equal(counting.failed, 1);
            assert_int_equal(counting.live, before);
        }
        /* and none is taken later */
        newton = create(x.s.model, NULL);
        const long after = counting.calls;
        assert_ok(factor(newton, &x, 3.0), mbsr_newton_error(newton));
        solve(newton, x.r, x.delta);
        assert_int_equal(counting.calls, after);
        mbsr_newton_destroy(newton);
        close_scene(&x);
        assert_int_equal(counting.live, 0);
    }
}

/* Counts the bytes that are in use. */
static void *measure(void *user, size_t size)
{
    size_t *memory = malloc(size + 64);
    if (!memory) return NULL;
    *memory = size;
    *(size_t *)user += size;
    return memory + 8;
}

static void forget(void *user, void *memory)
{
    size_t *start = (size_t *)memory - 8;
    *(size_t *)user -= *start;
    free(start);
}

static void the_memory_is_what_info_says(void **state)
{
    (void)state;
    for (int v = 0; v < 3; ++v) {
        for (int by_blocks = 0; by_blocks < 2; ++by_blocks) {
            size_t used = 0;
            mbsr_model_def def = mbsr_default_model_def();
            mbsr_newton_opt opt = mbsr_default_newton_opt();
            test_rigid_choice choice = variants[v];
            scene x;
            def.allocator = (mbsr_allocator){measure, forget, &used};
            choice.def = &def;
            opt.by_blocks = by_blocks;
            open_scene(&x, choice);
            const size_t before = used;
            mbsr_newton *newton = create(x.s.model, &opt);
            assert_in_range(used - before, info_of(newton).bytes, info_of(newton).bytes + 256);
            mbsr_newton_destroy(newton);
            assert_true(used == before);
            close_scene(&x);
            assert_true(used == 0);
        }
    }
}

/* ---- what it says of itself ---- */

/* A chain of four revolute joints with a joint spring each, and other elements. */
static mbsr_model *make_arm(int count, const mbsr_force_def *elements)
{
    static const double axis[2][3] = {{0.0, 0.0, 1.0}, {0.3, 1.0, 0.0}}, edges[3] = {0.2, 0.3, 1.0};
    mbsr_model *m;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    for (int k = 0; k < 4; ++k) {
        const mbsr_frame A = mbsr_frame_at(k > 0 ? 1.0 : 0.0, 0.2, 0.0);
        mbsr_body_def body = mbsr_default_body_def();
        body.parent = k - 1;
        body.joint = mbsr_joint_revolute(&A, NULL, axis[k % 2]);
        body.inertia = mbsr_inertia_box(5.0, edges);
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
        const mbsr_force_def spring = mbsr_force_joint_spring(k, 0, 3.0, 0.5, 0.1);
        assert_ok(mbsr_model_add_force(m, &spring, NULL), mbsr_model_error(m));
    }
    for (int k = 0; k < count; ++k)
        assert_ok(mbsr_model_add_force(m, elements + k, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    return m;
}

static mbsr_newton_info info_with(int count, const mbsr_force_def *elements,
                                  const mbsr_newton_opt *opt)
{
    static const double y[12] = {0.1, 0.4, -0.3, 0.7, 0.0, 0.0, 0.0, 0.0, 1.0, -0.5, 0.3, 0.8},
                        yp[12] = {0.0}, r[12] = {1.0};
    double delta[12];
    mbsr_model *m = make_arm(count, elements);
    mbsr_data *d;
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    mbsr_newton *newton = create(m, opt);
    assert_int_equal(info_of(newton).factorisations, 0);
    assert_int_equal(info_of(newton).solves, 0);
    for (int k = 0; k < 3; ++k) {
        assert_ok(mbsr_newton_factor(newton, d, 0.0, y, yp, 10.0), mbsr_newton_error(newton));
        for (int l = 0; l < 2; ++l) solve(newton, r, delta);
    }
    const mbsr_newton_info info = info_of(newton);
    assert_int_equal(info.factorisations, 3);
    assert_int_equal(info.solves, 6);
    mbsr_newton_destroy(newton);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
    return info;
}

#define assert_info(info, method, exact, across, rank)                                             \
    assert_info_at((info), (method), (exact), (across), (rank), __LINE__)

static void assert_info_at(mbsr_newton_info info, mbsr_newton_method method, int exact, int across,
                           int rank, int line)
{
    if (info.method == method && info.exact == exact && info.across == across && info.rank == rank)
        return;
    print_error("method %d, exact %d, across %d, rank %d, expected %d, %d, %d, %d\n", info.method,
                info.exact, info.across, info.rank, method, exact, across, rank);
    _fail(__FILE__, line);
}

static void info_says_what_is_on_the_tree_and_what_across(void **state)
{
    (void)state;
    static const double at[3] = {0.1, 0.2, 0.3};
    mbsr_newton_opt tree = mbsr_default_newton_opt(), corrected = tree, rank = tree;
    tree.method = MBSR_NEWTON_TREE;
    corrected.method = MBSR_NEWTON_CORRECTED;
    rank.max_rank = 13;
    mbsr_newton_info info = info_with(0, NULL, NULL);
    assert_info(info, MBSR_NEWTON_TREE, 1, 0, 0);
    assert_int_equal(info.vector_code, 1);
    rank.by_blocks = 1;
    info = info_with(0, NULL, &rank);
    assert_info(info, MBSR_NEWTON_TREE, 1, 0, 0);
    assert_int_equal(info.vector_code, 0);
    rank.by_blocks = 0;

    /* on neighbours, and to the ground */
    const mbsr_force_def near[] = {mbsr_force_point_spring(1, at, 2, NULL, 5.0, 0.5, 0.3),
                                   mbsr_force_point_spring(3, at, MBSR_GROUND, NULL, 5.0, 0.5, 0.3),
                                   mbsr_force_point_spring(1, at, 0, NULL, 5.0, 0.5, 0.3)};
    assert_info(info_with(3, near, NULL), MBSR_NEWTON_TREE, 1, 0, 0);
    assert_info(info_with(3, near, &corrected), MBSR_NEWTON_TREE, 1, 0, 0);

    const mbsr_force_def far[] = {mbsr_force_point_spring(0, at, 2, NULL, 5.0, 0.5, 0.3),
                                  mbsr_force_point_spring(3, at, 1, NULL, 5.0, 0.5, 0.3)};
    info = info_with(1, far, NULL);
    assert_info(info, MBSR_NEWTON_CORRECTED, 1, 1, info.rank);
    assert_in_range(info.rank, 1, 12);
    assert_info(info_with(1, far, &tree), MBSR_NEWTON_TREE, 0, 1, 0);
    /* its forces count 2 (6 + 1) rows, more than max_rank */
    assert_info(info_with(1, far, &rank), MBSR_NEWTON_ELIMINATED, 1, 1, 0);
    rank.max_rank = 14;
    assert_info(info_with(1, far, &rank), MBSR_NEWTON_CORRECTED, 1, 1, info.rank);
    assert_info(info_with(2, far, &rank), MBSR_NEWTON_ELIMINATED, 1, 2, 0);
    rank.method = MBSR_NEWTON_CORRECTED;
    assert_info(info_with(2, far, &rank), MBSR_NEWTON_CORRECTED, 1, 2, 2 * info.rank);
    assert_int_equal(mbsr_default_newton_opt().max_rank, 120);

    /* A web on neighbours reads more than the tree takes in, unless it is one of bodies alone: tau
     * of the predecessor by the successor, one row, and f and tau of the successor by q and u of
     * the predecessor, two columns. */
    static const int pair[2] = {1, 2};
    const mbsr_force_def webs[] = {test_web(TEST_WEB_ALL, 2, pair, 0.1, 1),
                                   test_web(TEST_WEB_JOINTS, 2, pair, 0.1, 1),
                                   test_web(TEST_WEB_BODIES, 2, pair, 0.1, 1)};
    /* vector code leaves states in which a web reads bodies and joints to the front */
    assert_info(info_with(1, webs, NULL), MBSR_NEWTON_CORRECTED, 1, 1, 0);
    assert_info(info_with(1, webs + 1, NULL), MBSR_NEWTON_CORRECTED, 1, 1, 2);
    assert_info(info_with(1, webs + 2, NULL), MBSR_NEWTON_TREE, 1, 0, 0);
}

/* Two chains of n hinges, and a spring from each body of one to that of the other. */
static mbsr_model *make_ladder(int n)
{
    static const double axis[2][3] = {{0.0, 0.0, 1.0}, {0.3, 1.0, 0.0}}, edges[3] = {0.2, 0.3, 1.0},
                        at[3] = {0.1, 0.05, 0.0};
    mbsr_model *m;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    for (int k = 0; k < 2 * n; ++k) {
        const mbsr_frame A = mbsr_frame_at(k % n > 0 ? 0.3 : 0.0, k == n ? 0.5 : 0.0, 0.0);
        mbsr_body_def body = mbsr_default_body_def();
        body.parent = k % n > 0 ? k - 1 : MBSR_GROUND;
        body.joint = mbsr_joint_revolute(&A, NULL, axis[k % 2]);
        body.inertia = mbsr_inertia_box(1.0, edges);
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    }
    for (int k = 0; k < n; ++k) {
        const mbsr_force_def rung = mbsr_force_point_spring(k, at, k + n, at, 100.0, 1.0, 0.1);
        assert_ok(mbsr_model_add_force(m, &rung, NULL), mbsr_model_error(m));
    }
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    return m;
}

/* Of n rungs: eliminated and corrected solutions agree; the memory of the former. */
static size_t memory_of_ladder(int n)
{
    mbsr_model *m = make_ladder(n);
    mbsr_data *d;
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    const int size = mbsr_dae_size(m, MBSR_DAE_MOMENTUM);
    double *y = calloc(5 * (size_t)size, sizeof *y), *yp = y + size, *r = yp + size, *x = r + size,
           *other = x + size;
    test_rng rng = test_seed(7);
    test_fill(&rng, size, r);
    for (int k = 0; k < 2 * n; ++k) y[k] = 0.01 * r[k];
    assert_ok(mbsr_dae_pack(m, d, MBSR_DAE_MOMENTUM, 0.0, y, y + size - 2 * n, other), NULL);
    mbsr_newton_opt opt = mbsr_default_newton_opt();
    mbsr_newton *eliminated = create(m, &opt);
    opt.method = MBSR_NEWTON_CORRECTED;
    mbsr_newton *corrected = create(m, &opt);
    assert_int_equal(info_of(eliminated).method, MBSR_NEWTON_ELIMINATED);
    assert_int_equal(info_of(eliminated).exact, 1);
    assert_ok(mbsr_newton_factor(eliminated, d, 0.0, other, yp, 100.0),
              mbsr_newton_error(eliminated));
    assert_ok(mbsr_newton_factor(corrected, d, 0.0, other, yp, 100.0),
              mbsr_newton_error(corrected));
    solve(eliminated, r, x);
    solve(corrected, r, y);
    assert_int_equal(info_of(corrected).rank, 6 * n);
    for (int k = 0; k < size; ++k)
        assert_less(fabs(x[k] - y[k]), 1e-9 * (1.0 + test_largest(size, y)));
    const size_t bytes = info_of(eliminated).bytes;
    mbsr_newton_destroy(eliminated);
    mbsr_newton_destroy(corrected);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
    free(y);
    return bytes;
}

/* Its sides are eliminated together, from the far end. */
static void rungs_of_a_ladder_cost_the_same_each(void **state)
{
    (void)state;
    const size_t few = memory_of_ladder(10), many = memory_of_ladder(30);
    assert_less((double)many, 3.2 * (double)few);
}

/* ---- lean ---- */

static mbsr_newton *create_with(const mbsr_model *model, int by_blocks, int lean)
{
    mbsr_newton_opt opt = mbsr_default_newton_opt();
    opt.method = MBSR_NEWTON_CORRECTED; /* as lean solvers do it */
    opt.by_blocks = by_blocks;
    opt.lean = lean;
    return create(model, &opt);
}

static void lean_solvers_and_lean_data_serve_vector_code(void **state)
{
    (void)state;
    for (int v = 0; v < 5; ++v) {
        scene x;
        mbsr_data *spare;
        double expected[MOST];
        /* without and with a correction; with elements on bodies; with bodies of other kinds */
        static const int pair[2] = {1, 4};
        const mbsr_force_def web = test_web(TEST_WEB_JOINTS, 2, pair, 0.3, 1);
        open_scene(&x, (test_rigid_choice){.seed = 9,
                                           .bodies = v < 3 ? 6 : 14,
                                           .element_count = v == 1,
                                           .elements = &web,
                                           .forces = v == 2,
                                           .held = v == 3 ? 0.1 : 0.0,
                                           .added = v == 4 ? 0.3 : 0.0});
        const test_newton_state *s = &x.s;
        assert_ok(mbsr_data_create_lean(s->model, &spare, NULL), NULL);
        mbsr_newton *full = create_with(s->model, 0, 0), *blocks = create_with(s->model, 1, 0),
                    *lean = create_with(s->model, 0, 1);
        assert_ok(factor(full, &x, 7.0), mbsr_newton_error(full));
        solve(full, x.r, expected);
        assert_int_equal(info_of(full).vector_code, 1);
        if (v < 2) assert_int_equal(info_of(full).rank, 2 * v);
        assert_true(info_of(lean).bytes < info_of(full).bytes / (v < 2 ? 2 : 1));
        assert_ok(mbsr_newton_factor(lean, spare, s->t, s->y, s->yp, 7.0), mbsr_newton_error(lean));
        solve(lean, x.r, x.delta);
        assert_same(s->n, x.delta, expected);
        /* the general elimination needs all of the data */
        assert_refused(mbsr_newton_factor(blocks, spare, s->t, s->y, s->yp, 7.0),
                       mbsr_newton_error(blocks), MBSR_ERR_LEAN, MBSR_NONE, MBSR_NONE, "lean");
        assert_ok(factor(blocks, &x, 7.0), mbsr_newton_error(blocks));
        solve(blocks, x.r, x.delta);
        assert_int_equal(info_of(blocks).vector_code, 0);
        assert_less(test_newton_distance(s, x.delta, expected), 1e-11);
        mbsr_newton_destroy(lean);
        mbsr_newton_destroy(full);
        mbsr_newton_destroy(blocks);
        mbsr_data_destroy(spare);
        close_scene(&x);
    }
}

static void lean_solvers_refuse_what_vector_code_does_not_serve(void **state)
{
    (void)state;
    scene x;
    open_scene(&x, (test_rigid_choice){.forces = 2, .massless = 0.8});
    mbsr_newton *lean = create_with(x.s.model, 0, 1);
    assert_refused(factor(lean, &x, 7.0), mbsr_newton_error(lean), MBSR_ERR_LEAN, MBSR_NONE,
                   MBSR_NONE, "lean|this state");
    assert_int_equal(mbsr_newton_solve(lean, x.r, x.delta), MBSR_ERR_SEQUENCE);
    mbsr_newton_destroy(lean);
    close_scene(&x);

    mbsr_model *m = odd_model(&odd_known, false);
    const double y[12] = {0.0}, yp[12] = {0.0};
    mbsr_data *d;
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    lean = create_with(m, 0, 1);
    assert_refused(mbsr_newton_factor(lean, d, 0.0, y, yp, 7.0), mbsr_newton_error(lean),
                   MBSR_ERR_LEAN, MBSR_NONE, MBSR_NONE, "lean|this model");
    mbsr_newton_destroy(lean);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

/* ---- the order of ids ---- */

/* A tree of six bodies, ids in the order `id`: 0 - 1 - 2 - 3, 4 on 1, 5 on 4. The third has no
 * mass. */
static mbsr_model *make_in_order(const int id[6], const double edges[3])
{
    static const int parent[6] = {-1, 0, 1, 2, 1, 4};
    static const double axis[3] = {0.3, 1.0, 0.2}, at[3] = {0.3, 0.1, 0.0};
    int place[6];
    mbsr_model *m;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    for (int k = 0; k < 6; ++k) place[id[k]] = k;
    for (int i = 0; i < 6; ++i) {
        const int k = place[i];
        const mbsr_frame A = mbsr_frame_at(0.1 * k, 0.5, 0.2);
        mbsr_body_def body = mbsr_default_body_def();
        body.parent = k > 0 ? id[parent[k]] : MBSR_GROUND;
        body.joint = k % 2 ? mbsr_joint_spherical(&A, NULL) : mbsr_joint_revolute(&A, NULL, axis);
        body.inertia = k == 3 ? mbsr_inertia_zero() : mbsr_inertia_box(5.0 + k, edges);
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    }
    const mbsr_force_def forces[] = {
        mbsr_force_gravity(0.0, 1.0, -9.81),
        test_web_everywhere(0.2, 1),
        mbsr_force_joint_friction(id[3], 0, 2.0, 0.7),
        mbsr_force_joint_friction(id[3], 1, 2.0, 0.7),
        mbsr_force_joint_friction(id[3], 2, 2.0, 0.7),
        mbsr_force_point_spring(id[3], at, id[5], NULL, 40.0, 2.0, 0.1)};
    for (int k = 0; k < 6; ++k)
        assert_ok(mbsr_model_add_force(m, forces + k, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    return m;
}

/* to = from, in another order of the bodies; back: the other way. */
static void reorder(const mbsr_model *m, const int id[6], bool back, const double *from, double *to)
{
    const int nq = mbsr_model_nq(m), nu = mbsr_model_nu(m);
    int q = 0, u = 0;
    for (int k = 0; k < 6; ++k) {
        int at_q, n_q, at_u, n;
        assert_ok(mbsr_body_coordinates(m, id[k], &at_q, &n_q, &at_u, &n), NULL);
        for (int l = 0; l < n_q; ++l) to[back ? q + l : at_q + l] = from[back ? at_q + l : q + l];
        for (int part = nq; part <= nq + nu; part += nu) {
            for (int l = 0; l < n; ++l)
                to[part + (back ? u + l : at_u + l)] = from[part + (back ? at_u + l : u + l)];
        }
        q += n_q;
        u += n;
    }
}

static void ids_may_come_in_any_order(void **state)
{
    (void)state;
    static const int orders[][6] = {
        {0, 1, 2, 3, 4, 5}, {5, 4, 3, 2, 1, 0}, {2, 5, 0, 3, 1, 4}, {0, 1, 4, 5, 2, 3}};
    static const double edges[3] = {0.2, 0.3, 0.9};
    double y[MOST], yp[MOST] = {0.0}, r[MOST], expected[MOST], delta[MOST], there[MOST];
    test_rng rng = test_seed(4);
    test_fill(&rng, MOST, y);
    test_fill(&rng, MOST, r);
    for (int k = 0; k < 4; ++k) {
        mbsr_model *m = make_in_order(orders[k], edges);
        mbsr_data *d;
        assert_ok(mbsr_data_create(m, &d, NULL), NULL);
        mbsr_newton *newton = create(m, NULL);
        reorder(m, orders[k], false, y, there);
        assert_ok(mbsr_newton_factor(newton, d, 0.3, there, yp, 20.0), mbsr_newton_error(newton));
        assert_true(info_of(newton).across > 0);
        reorder(m, orders[k], false, r, there);
        solve(newton, there, there);
        reorder(m, orders[k], true, there, k == 0 ? expected : delta);
        const int n = mbsr_dae_size(m, MBSR_DAE_MOMENTUM);
        for (int l = 0; l < n && k > 0; ++l)
            assert_close(delta[l], expected[l], 1e-11 * test_largest(n, expected));
        mbsr_newton_destroy(newton);
        mbsr_data_destroy(d);
        mbsr_model_destroy(m);
    }
}

/* A group of which the front has the head, a joint of two axes behind one without inertia, and
 * vector code what follows. */
static void members_of_a_group_may_be_in_vector_code(void **state)
{
    (void)state;
    enum { SIZE = 27 };
    static const double x[3] = {1.0, 0.0, 0.0}, along[3] = {0.0, 1.0, 0.0}, z[3] = {0.0, 0.0, 1.0},
                        com[3] = {0.1, 0.2, -0.1}, tensor[6] = {2.0, 3.0, 4.0},
                        q[9] = {1.0, -0.25, 1.0, 0.5, 0.3, 0.2, 1.0, 0.4, -1.0}, u[9] = {0.0};
    const mbsr_frame first = mbsr_frame_at(1.0, 1.0, 0.5), next = mbsr_frame_at(0.5, 1.0, 0.5);
    const mbsr_inertia none = mbsr_inertia_zero(), rigid = mbsr_inertia_rigid(2.0, com, tensor);
    const mbsr_force_def damper = mbsr_force_joint_spring(0, 1, 0.0, 5.0, 0.0);
    mbsr_model *m;
    mbsr_data *d;
    double y[SIZE], yp[SIZE] = {0.0}, r[SIZE], delta[2][SIZE];
    test_rng rng = test_seed(5);
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    test_add_body(m, MBSR_GROUND, mbsr_joint_cylindrical(NULL, NULL, along), none);
    test_add_body(m, 0, mbsr_joint_in_plane(&first, NULL), rigid);
    test_add_body(m, 1, mbsr_joint_cylindrical(NULL, NULL, z), none);
    test_add_body(m, 2, mbsr_joint_revolute(&next, NULL, along), none);
    test_add_body(m, 3, mbsr_joint_revolute(&next, NULL, x), rigid);
    assert_ok(mbsr_model_add_force(m, &damper, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_int_equal(mbsr_body_group(m, 3), 2);
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    assert_int_equal(mbsr_dae_size(m, MBSR_DAE_MOMENTUM), SIZE);
    assert_ok(mbsr_dae_pack(m, d, MBSR_DAE_MOMENTUM, 0.0, q, u, y), mbsr_data_error(d));
    test_fill(&rng, SIZE, r);
    for (int by_blocks = 0; by_blocks < 2; ++by_blocks) {
        mbsr_newton_opt opt = mbsr_default_newton_opt();
        opt.by_blocks = by_blocks;
        mbsr_newton *newton = create(m, &opt);
        assert_ok(mbsr_newton_factor(newton, d, 0.0, y, yp, 1e3), mbsr_newton_error(newton));
        assert_int_equal(info_of(newton).blocks, by_blocks ? 5 : 3);
        solve(newton, r, delta[by_blocks]);
        mbsr_newton_destroy(newton);
    }
    for (int k = 0; k < SIZE; ++k)
        assert_close(delta[0][k], delta[1][k], 1e-12 * test_largest(SIZE, delta[1]));
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_wrong_is_refused_at_creation),
        cmocka_unit_test(rates_that_cannot_be_differenced_are_refused),
        cmocka_unit_test(what_is_wrong_is_refused_later),
        cmocka_unit_test(what_is_not_finite_is_refused_and_nothing_written),
        cmocka_unit_test(r_and_delta_may_be_the_same),
        cmocka_unit_test(factoring_anew_leaves_nothing_behind),
        cmocka_unit_test(two_solvers_share_data),
        cmocka_unit_test(the_data_is_left_at_mbsr_backward),
        cmocka_unit_test(ranks_that_are_watched_stop_it),
        cmocka_unit_test(every_allocation_may_fail),
        cmocka_unit_test(the_memory_is_what_info_says),
        cmocka_unit_test(info_says_what_is_on_the_tree_and_what_across),
        cmocka_unit_test(rungs_of_a_ladder_cost_the_same_each),
        cmocka_unit_test(lean_solvers_and_lean_data_serve_vector_code),
        cmocka_unit_test(lean_solvers_refuse_what_vector_code_does_not_serve),
        cmocka_unit_test(ids_may_come_in_any_order),
        cmocka_unit_test(members_of_a_group_may_be_in_vector_code),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
