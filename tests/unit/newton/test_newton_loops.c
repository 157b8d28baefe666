/* The O(N) Newton solver on mechanisms with closed loops: massless bodies that loops hold,
 * redundant rows, singular loops, many loops, groups of joints inside a loop.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "loops.h"
#include "newton_ways.h"

#include <mbsrank/driver.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Solutions at a consistent state near that of s against the dense matrix, to `tolerance` of the
 * largest entry of each kind beyond what differences leave open. */
static void compare_for(loops *s, double tolerance, int by_blocks, int count, const double *factors)
{
    test_newton_state at;
    mbsr_newton *newton = newton_solver(s->m, by_blocks);
    test_rng rng = test_seed(7);
    assert_ok(test_newton_start(&at, s->m, s->d, 0.0, s->q, s->u, NULL), mbsr_data_error(s->d));
    assert_ok(test_newton_matrices(&at, s->m, s->d), NULL);
    double *r = calloc(2 * (size_t)at.n, sizeof *r), *x = r + at.n;
    for (int k = 0; k < count; ++k) {
        test_fill(&rng, at.n, r);
        assert_ok(mbsr_newton_factor(newton, s->d, 0.0, at.y, at.yp, factors[k]),
                  mbsr_newton_error(newton));
        assert_ok(mbsr_newton_solve(newton, r, x), mbsr_newton_error(newton));
        const test_newton_errors e = test_newton_compare(&at, factors[k], r, x);
        assert_less(e.net_row, tolerance);
        assert_less(e.net_delta, tolerance);
        assert_less(e.delta, 1e-8);
    }
    free(r);
    mbsr_newton_destroy(newton);
    test_newton_free(&at);
}

/* In vector code as far as that serves, and without it. */
static void compare(loops *s, double tolerance)
{
    static const double factors[] = {1.0, 50.0, 1e5, -30.0};
    compare_for(s, tolerance, 0, 4, factors);
    compare_for(s, tolerance, 1, 4, factors);
}

static void set(loops *s, const double *q, const double *u)
{
    memcpy(s->q, q, (size_t)s->nq * sizeof *q);
    memcpy(s->u, u, (size_t)s->nu * sizeof *u);
}

/* ---- mechanisms ---- */

static void fourbar(loops *s, double coupler)
{
    static const double q[] = {1.2, -0.9, 1.3}, u[] = {3.0, 0.0, 1.0};
    loops_begin(s, NULL);
    const int a = loops_rod(s, "crank", MBSR_GROUND, 0.0, 0.0, 1.0, 1.0),
              b = loops_rod(s, "coupler", a, 1.0, 0.0, coupler, 2.5),
              c = loops_rod(s, "rocker", MBSR_GROUND, 2.0, 0.0, 2.0, 2.0);
    loops_pin(s, "pin", b, 2.5, 0.0, c, 2.0, 0.0);
    loops_finish(s);
    set(s, q, u);
}

static void fourbars(void **state)
{
    (void)state;
    static const double coupler[] = {2.5, 1e-6, 0.0};
    for (int k = 0; k < 3; ++k) {
        loops s;
        fourbar(&s, coupler[k]);
        compare(&s, 1e-10);
        loops_free(&s);
    }
}

/* Steps so short that what moves a joint by the multipliers of position rows is all but lost beside
 * what its rate does. */
static void short_steps(void **state)
{
    (void)state;
    static const double factors[] = {1e6, 1e8, 1e9};
    for (int massless = 0; massless < 2; ++massless) {
        loops s;
        fourbar(&s, massless ? 0.0 : 2.5);
        compare_for(&s, 1e-10, 0, 3, factors);
        loops_free(&s);
    }
}

/* A massless coupler without any load: its loop force is zero, or small, and with it all that would
 * be a pivot of its joint. */
static void locked_joints_without_load(void **state)
{
    (void)state;
    static const double speed[] = {0.0, 1e-6, 1e-2, 1.0};
    static const double q[] = {1.2, -0.9, 1.3};
    for (int k = 0; k < 4; ++k) {
        loops s;
        const double u[] = {speed[k], 0.0, 0.0};
        memset(&s, 0, sizeof s);
        assert_ok(mbsr_model_create(NULL, &s.m, NULL), NULL); /* no gravity */
        const int a = loops_rod(&s, "crank", MBSR_GROUND, 0.0, 0.0, 1.0, 1.0),
                  b = loops_rod(&s, "coupler", a, 1.0, 0.0, 0.0, 2.5),
                  c = loops_rod(&s, "rocker", MBSR_GROUND, 2.0, 0.0, 2.0, 2.0);
        loops_pin(&s, "pin", b, 2.5, 0.0, c, 2.0, 0.0);
        loops_finish(&s);
        set(&s, q, u);
        compare(&s, 1e-10);
        loops_free(&s);
    }
}

/* A loop inside another, the joints of which they share massless in turn: one that the outer loop
 * alone holds, too. */
static void nested(void **state)
{
    (void)state;
    static const double q[] = {1.5, -1.0, -1.0, -0.2, 0.5}, u[] = {0.5, -0.3, 0.2, 0.1, 0.4};
    for (int k = 0; k < 8; ++k) {
        loops s;
        loops_begin(&s, NULL);
        const int a = loops_rod(&s, "a", MBSR_GROUND, 0.0, 0.0, 1.0, 1.0),
                  b = loops_rod(&s, "b", a, 1.0, 0.0, k & 1 ? 0.0 : 0.7, 1.0),
                  c = loops_rod(&s, "c", b, 1.0, 0.0, k & 4 ? 0.0 : 0.5, 1.0),
                  d = loops_rod(&s, "d", a, 0.5, 0.0, k & 2 ? 0.0 : 0.6, 1.2),
                  e = loops_rod(&s, "e", b, 0.5, 0.0, 0.3, 0.8);
        loops_pin(&s, "inner", d, 1.2, 0.0, e, 0.8, 0.0);
        loops_pin(&s, "outer", c, 1.0, 0.0, MBSR_GROUND, 1.5, 0.3);
        loops_finish(&s);
        set(&s, q, u);
        compare(&s, 1e-10);
        loops_free(&s);
    }
}

static void ladder(loops *s, int windows)
{
    double q[LOOPS_MOST], u[LOOPS_MOST];
    loops_begin(s, NULL);
    const int a = loops_rod(s, "leg 0", MBSR_GROUND, 0.0, 0.0, 1.0, 1.0),
              b = loops_rod(s, "beam", a, 1.0, 0.0, windows, windows);
    q[0] = 2.0, q[1] = -2.0, u[0] = 1.0, u[1] = -1.0;
    for (int i = 1; i <= windows; ++i) {
        const int leg = loops_rod(s, "leg", MBSR_GROUND, i, 0.0, 1.0, 1.0);
        loops_pin(s, i == windows ? "last" : "pin", b, i, 0.0, leg, 1.0, 0.0);
        q[i + 1] = 2.0, u[i + 1] = 1.0;
    }
    loops_finish(s);
    set(s, q, u);
}

/* The start leaves out what is redundant. Where nobody did, the solver says so, and serves on. */
static void redundant_rows(void **state)
{
    (void)state;
    loops s;
    double y[256], yp[256] = {0.0}, r[256], delta[256];
    int none[LOOPS_MOST] = {0}, dropped[LOOPS_MOST];
    ladder(&s, 4);
    compare(&s, 1e-10);
    assert_ok(mbsr_dae_pack(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, s.q, s.u, y), NULL);
    assert_ok(mbsr_closures_redundant(s.m, s.d, dropped), NULL);
    assert_ok(mbsr_closures_set_redundant(s.m, s.d, none), NULL);
    mbsr_newton *newton = newton_solver(s.m, 0);
    assert_refused(mbsr_newton_factor(newton, s.d, 0.0, y, yp, 50.0), mbsr_newton_error(newton),
                   MBSR_LOOP_SINGULAR, MBSR_NONE, MBSR_NONE, "closure|row|mbsr_closures_report");
    assert_int_equal(mbsr_newton_solve(newton, r, delta), MBSR_ERR_SEQUENCE);
    assert_ok(mbsr_closures_set_redundant(s.m, s.d, dropped), NULL);
    for (int k = 0; k < s.size; ++k) r[k] = cos(k);
    assert_ok(mbsr_newton_factor(newton, s.d, 0.0, y, yp, 50.0), mbsr_newton_error(newton));
    assert_ok(mbsr_newton_solve(newton, r, delta), mbsr_newton_error(newton));
    for (int k = 0, first = s.nq + 2 * s.nu; k < s.rows; ++k) { /* 0 = Lambda of such rows */
        if (dropped[k]) assert_close(delta[first + k], r[first + k], 0.0);
    }
    mbsr_newton_destroy(newton);
    loops_free(&s);
}

/* A massless rod on the coupler that no loop holds. */
static void nothing_holds(void **state)
{
    (void)state;
    loops s;
    double y[64], yp[64] = {0.0};
    loops_begin(&s, NULL);
    const int a = loops_rod(&s, "crank", MBSR_GROUND, 0.0, 0.0, 1.0, 1.0),
              b = loops_rod(&s, "first", a, 1.0, 0.0, 0.0, 1.0),
              c = loops_rod(&s, "second", b, 1.0, 0.0, 0.0, 1.0),
              d = loops_rod(&s, "third", c, 1.0, 0.0, 0.0, 1.0);
    loops_pin(&s, "pin", d, 1.0, 0.0, MBSR_GROUND, 2.0, 0.0);
    loops_finish(&s);
    assert_ok(
        mbsr_dae_pack(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, (double[]){1.0, -0.4, -0.9, -0.6}, s.u, y),
        NULL);
    mbsr_newton *newton = newton_solver(s.m, 0);
    const int status = mbsr_newton_factor(newton, s.d, 0.0, y, yp, 50.0);
    assert_int_equal(status, MBSR_SINGULAR_BLOCK);
    assert_contains(mbsr_newton_error(newton)->text, "joint|holds|damper");
    mbsr_newton_destroy(newton);
    loops_free(&s);
}

/* ---- groups: joints of dummy bodies, eliminated as one, inside a loop ---- */

static void groups(void **state)
{
    (void)state;
    static const double q[] = {0.2, -0.3, 0.4, 0.5}, u[] = {0.3, 0.2, -0.4, 1.0};
    static const mbsr_planar_frame at = {0.0, 0.0, 0.0}, along_y = {0.0, 0.0, 1.5707963267948966};
    for (int k = 0; k < 2; ++k) {
        loops s;
        int id;
        loops_begin(&s, NULL);
        mbsr_body_def dummy = mbsr_default_body_def();
        dummy.joint = mbsr_joint_planar_prismatic(at, at);
        assert_ok(mbsr_model_add_body(s.m, &dummy, &id), mbsr_model_error(s.m));
        dummy.parent = id;
        dummy.joint = mbsr_joint_planar_prismatic(along_y, along_y);
        assert_ok(mbsr_model_add_body(s.m, &dummy, &id), mbsr_model_error(s.m));
        const int rod = loops_rod(&s, "rod", id, 0.0, 0.0, 1.0, 1.0);
        if (k == 0) {
            loops_rod(&s, "tail", rod, 1.0, 0.0, 0.5, 0.5);
            loops_pin(&s, "pin", rod, 0.7, 0.1, MBSR_GROUND, 0.6, 0.5);
        } else {
            /* closed between the dummy body and the tail */
            const int tail = loops_rod(&s, "tail", rod, 1.0, 0.0, 0.0, 0.5);
            const mbsr_closure_def rope =
                mbsr_closure_distance(id, (double[3]){0.3, 0.0, 0.0}, tail, NULL, 1.1);
            assert_ok(mbsr_model_add_closure(s.m, &rope, NULL), mbsr_model_error(s.m));
            const mbsr_force_def damper = mbsr_force_joint_spring(tail, 0, 1.0, 0.4, 0.0);
            assert_ok(mbsr_model_add_force(s.m, &damper, NULL), mbsr_model_error(s.m));
        }
        loops_finish(&s);
        set(&s, q, u);
        compare(&s, 1e-9);
        loops_free(&s);
    }
}

/* Dummy bodies whose three rates move the rods behind them in two directions; a damper holds the
 * third. Loops close on the last of them, between the rods, or by its coordinate. */
static void loops_within_groups(void **state)
{
    (void)state;
    static const double q[] = {0.4, 0.2, -0.3, 0.4, 1.1, 1.3},
                        u[] = {0.5, 0.3, 0.2, -0.4, 1.0, 0.6};
    static const mbsr_planar_frame at = {0.0, 0.0, 0.0}, arm = {0.5, 0.0, 0.0};
    for (int k = 0; k < 3; ++k) {
        loops s;
        int id[3];
        loops_begin(&s, NULL);
        for (int l = 0; l < 3; ++l) {
            mbsr_body_def dummy = mbsr_default_body_def();
            dummy.parent = l > 0 ? id[l - 1] : MBSR_GROUND;
            dummy.joint =
                l == 1 ? mbsr_joint_planar_prismatic(arm, at) : mbsr_joint_planar_revolute(arm, at);
            assert_ok(mbsr_model_add_body(s.m, &dummy, id + l), mbsr_model_error(s.m));
        }
        const int a = loops_rod(&s, "a", id[2], 0.7, 0.0, 1.0, 1.0),
                  b = loops_rod(&s, "b", a, 1.0, 0.0, 0.7, 1.2),
                  c = loops_rod(&s, "c", id[2], 0.7, 0.0, 0.5, 0.8);
        const mbsr_force_def damper = mbsr_force_joint_spring(id[2], 0, 1.0, 0.4, 0.0);
        assert_ok(mbsr_model_add_force(s.m, &damper, NULL), mbsr_model_error(s.m));
        const mbsr_closure_def gear =
            mbsr_closure_coupling(2, (int[]){id[2], a}, (int[]){0, 0}, (double[]){1.0, 2.0}, 0.5);
        if (k < 2) loops_pin(&s, "pin", b, 1.2, 0.0, c, 0.8, 0.0);
        if (k > 0) assert_ok(mbsr_model_add_closure(s.m, &gear, NULL), mbsr_model_error(s.m));
        loops_finish(&s);
        assert_int_equal(mbsr_body_group(s.m, id[2]), id[0]);
        set(&s, q, u);
        compare(&s, 1e-9);
        loops_free(&s);
    }
}

/* ---- a body in between that hands on no rotation ---- */

static void a_point_within_a_loop(void **state)
{
    (void)state;
    static const double q[] = {0.4, 0.6, 0.2, -0.5, 0.3}, u[] = {0.5, -0.3, 0.4, 0.2, -0.6};
    static const mbsr_planar_frame at = {0.5, 0.2, 0.3};
    for (int k = 0; k < 2; ++k) { /* k: the loop on the ground's rod, or on one behind it */
        loops s;
        int point;
        loops_begin(&s, NULL);
        const int ground =
                      k ? loops_rod(&s, "ground", MBSR_GROUND, 0.0, 0.0, 1.0, 1.0) : MBSR_GROUND,
                  base = loops_rod(&s, "base", ground, 0.3, 0.0, 1.0, 1.0);
        mbsr_body_def ball = mbsr_default_body_def();
        ball.parent = base;
        ball.joint = mbsr_joint_point(at, MBSR_X | MBSR_Y, 0, NULL, NULL);
        ball.inertia = mbsr_inertia_particle(1.0);
        assert_ok(mbsr_model_add_body(s.m, &ball, &point), mbsr_model_error(s.m));
        const int rod = loops_rod(&s, "rod", point, 0.0, 0.0, 1.0, 0.8);
        loops_pin(&s, "pin", rod, 0.8, 0.1, base, 0.9, 0.3);
        loops_finish(&s);
        set(&s, q, u);
        compare(&s, 1e-9);
        loops_free(&s);
    }
}

/* ---- many loops ---- */

/* Four-bars, each on the ground or on the bar that the one before it hangs on. */
static void chain(loops *s, int count, int hub)
{
    int last = MBSR_GROUND;
    loops_begin(s, NULL);
    for (int k = 0; k < count; ++k) {
        const int spine = hub ? MBSR_GROUND : loops_rod(s, NULL, last, 0.5, 0.0, 1.5, 0.5);
        const int a = loops_rod(s, NULL, spine, 0.0, 0.1, 0.4, 0.3),
                  b = loops_rod(s, NULL, a, 0.3, 0.0, 0.0, 0.5),
                  c = loops_rod(s, NULL, spine, 0.45, 0.1, 0.3, 0.35);
        loops_pin(s, NULL, b, 0.5, 0.0, c, 0.35, 0.0);
        last = spine;
    }
    assert_ok(mbsr_model_finish(s->m), mbsr_model_error(s->m));
}

/* Memory is in proportion to the bodies, however the loops stand. */
static void memory(void **state)
{
    (void)state;
    for (int hub = 0; hub < 2; ++hub) {
        double bytes[2];
        for (int k = 0; k < 2; ++k) {
            loops s;
            mbsr_newton_info info;
            chain(&s, k ? 1000 : 30, hub);
            mbsr_newton *newton = newton_solver(s.m, 0);
            assert_ok(mbsr_newton_get_info(newton, &info), NULL);
            bytes[k] = (double)info.bytes / (double)mbsr_model_bodies(s.m);
            mbsr_newton_destroy(newton);
            mbsr_model_destroy(s.m);
        }
        assert_close(bytes[1] / bytes[0], 1.0, 0.1);
    }
}

/* ---- what is refused ---- */

static int position(const mbsr_closure_args *args, double *g)
{
    g[0] = args->body[0].q[0];
    return 0;
}

static int jacobian(const mbsr_closure_args *args, const mbsr_closure_jacobian *out)
{
    (void)args;
    out->matrix[out->column[0] + 6] = 1.0;
    return 0;
}

static int bias(const mbsr_closure_args *args, double *out)
{
    (void)args, (void)out;
    return 0;
}

static void coordinates_with_other_rates(void **state)
{
    (void)state;
    static const mbsr_closure_table table = {.version = MBSR_CLOSURE_TABLE_VERSION,
                                             .flags = MBSR_CLOSURE_JOINTS,
                                             .name = "own",
                                             .position = position,
                                             .jacobian = jacobian,
                                             .bias = bias};
    loops s;
    mbsr_newton *newton;
    mbsr_error error;
    loops_begin(&s, NULL);
    mbsr_body_def body = mbsr_default_body_def();
    body.joint = mbsr_joint_spherical(NULL, NULL);
    assert_ok(mbsr_model_add_body(s.m, &body, NULL), NULL);
    const mbsr_closure_def def = mbsr_closure_custom(&table, 1, (int[1]){0}, 1, 1, NULL);
    assert_ok(mbsr_model_add_closure(s.m, &def, NULL), mbsr_model_error(s.m));
    loops_finish(&s);
    assert_int_equal(mbsr_newton_create(s.m, MBSR_DAE_MOMENTUM, NULL, &newton, &error),
                     MBSR_ERR_SPACE);
    assert_contains(error.text, "mbsr_newton_create|closure 0|own|rates|dense");
    assert_null(newton);
    loops_free(&s);
}

static void *allocate_little(void *user, size_t size)
{
    (void)user;
    return size < (size_t)1 << 20 ? malloc(size) : NULL;
}

static void release(void *user, void *memory)
{
    (void)user;
    free(memory);
}

/* Two chains, tied at each link by rods: all of these meet at the ground. */
static void add_ladder(loops *s, int rungs)
{
    int left = MBSR_GROUND, right = MBSR_GROUND;
    for (int k = 0; k < rungs; ++k) {
        const double end[3] = {1.0, 0.0, 0.0};
        left = loops_rod(s, NULL, left, k > 0 ? 1.0 : 0.0, 0.0, 1.0, 1.0);
        right = loops_rod(s, NULL, right, k > 0 ? 1.0 : 0.0, k > 0 ? 0.0 : 1.0, 1.0, 1.0);
        mbsr_closure_def rung = mbsr_closure_distance(left, end, right, end, 1.0);
        rung.stiffness[0] = 1e6;
        assert_ok(mbsr_model_add_closure(s->m, &rung, NULL), mbsr_model_error(s->m));
    }
}

static void no_memory_is_told(void **state)
{
    (void)state;
    mbsr_model_def def = mbsr_default_model_def();
    mbsr_newton *newton;
    mbsr_error error;
    loops s = {0};
    def.allocator = (mbsr_allocator){allocate_little, release, NULL};
    assert_ok(mbsr_model_create(&def, &s.m, NULL), NULL);
    add_ladder(&s, 150);
    loops_build(&s);
    assert_int_equal(mbsr_newton_create(s.m, MBSR_DAE_MOMENTUM, NULL, &newton, &error),
                     MBSR_ERR_NO_MEMORY);
    assert_null(newton);
    assert_contains(error.text, "no memory for 300 bodies|150 closures");
    loops_free(&s);
}

/* Chains of pairs of rods, each of which is pinned to the ground. */
static void add_pinned_chain(loops *s, int pairs)
{
    int last = MBSR_GROUND;
    for (int k = 0; k < pairs; ++k) {
        const int a = loops_rod(s, NULL, last, k > 0 ? 1.0 : 0.0, 0.0, 1.0, 1.0);
        last = loops_rod(s, NULL, a, 1.0, 0.0, 1.0, 1.0);
        loops_pin(s, NULL, last, 1.0, 0.0, MBSR_GROUND, 0.3 + k, 0.3);
    }
}

/* A x = r, in all rows, where A x is a product. */
static void check_products(mbsr_newton *newton, loops *s, double bend)
{
    const int n = mbsr_dae_size(s->m, MBSR_DAE_MOMENTUM);
    double *y = calloc(6 * (size_t)n, sizeof *y), *yp = y + n, *r = yp + n, *x = r + n, *q = x + n,
           *u = q + n;
    test_rng rng = test_seed(3);
    test_fill(&rng, n, r);
    test_fill(&rng, mbsr_model_nu(s->m), u);
    for (int k = 0; k < mbsr_model_nq(s->m); ++k) q[k] = k % 2 ? -bend : bend;
    assert_ok(mbsr_dae_pack(s->m, s->d, MBSR_DAE_MOMENTUM, 0.0, q, u, y), mbsr_data_error(s->d));
    assert_ok(mbsr_newton_factor(newton, s->d, 0.0, y, yp, 300.0), mbsr_newton_error(newton));
    assert_ok(mbsr_newton_solve(newton, r, x), mbsr_newton_error(newton));
    assert_ok(mbsr_newton_linearise(newton, s->d, 0.0, y, yp, 300.0), mbsr_newton_error(newton));
    assert_ok(mbsr_newton_multiply(newton, x, y), mbsr_newton_error(newton));
    for (int k = 0; k < n; ++k) assert_close(y[k], r[k], 1e-6);
    free(y);
}

/* Loops too many to be carried at once go by the front, at a cost in proportion to the bodies, and
 * elements across with them. */
static void many_loops(void **state)
{
    (void)state;
    double bytes[2][2];
    for (int k = 0; k < 4; ++k) {
        loops s;
        mbsr_newton *newton;
        mbsr_newton_info info;
        mbsr_newton_opt opt = mbsr_default_newton_opt();
        mbsr_error error;
        opt.products = 1;
        loops_begin(&s, NULL);
        if (k < 2)
            add_pinned_chain(&s, 60 << k);
        else
            add_ladder(&s, 150 << (k - 2));
        const mbsr_force_def spring = mbsr_force_point_spring(4, NULL, 11, NULL, 50.0, 2.0, 0.5);
        if (k > 1) assert_ok(mbsr_model_add_force(s.m, &spring, NULL), mbsr_model_error(s.m));
        loops_build(&s);
        assert_ok(mbsr_newton_create(s.m, MBSR_DAE_MOMENTUM, &opt, &newton, &error), &error);
        check_products(newton, &s, k < 2 ? 1.0 : 0.0);
        assert_ok(mbsr_newton_get_info(newton, &info), NULL);
        assert_true(info.exact && !info.vector_code && info.blocks == mbsr_model_bodies(s.m));
        assert_int_equal(info.method, k > 1 ? MBSR_NEWTON_ELIMINATED : MBSR_NEWTON_TREE);
        bytes[k / 2][k % 2] = (double)info.bytes / info.blocks;
        mbsr_newton_destroy(newton);
        loops_free(&s);
    }
    for (int k = 0; k < 2; ++k) assert_less(bytes[k][1], 1.1 * bytes[k][0]);
}

/* Parallelograms on one carrier, some of them light, or legs that carry the end of the first. */
static void add_crowd(loops *s, int count, bool legs)
{
    const int base = legs ? MBSR_GROUND : loops_rod(s, NULL, MBSR_GROUND, 0.0, 0.0, 10.0, 1.0);
    int carrier = base;
    for (int k = 0; k < count; ++k) {
        const double at = 10.0 * k / count, mass = k % 5 == 3 ? 1e-9 : 1.0;
        const int a = loops_rod(s, NULL, base, at, 0.0, mass, 1.0),
                  b = loops_rod(s, NULL, a, 1.0, 0.0, mass, 1.0),
                  c = legs ? carrier : loops_rod(s, NULL, base, at + 1.0, 0.0, mass, 1.0);
        if (!legs || k > 0) loops_pin(s, NULL, b, 1.0, 0.0, c, legs ? 0.1 : 1.0, legs ? at : 0.0);
        if (legs && k == 0) carrier = b;
    }
}

/* Many fronts that wait for one body have room for so many unknowns together: memory grows with the
 * bodies, and no faster. */
static void crowds(void **state)
{
    (void)state;
    for (int legs = 0; legs < 2; ++legs) {
        double bytes[2];
        for (int k = 0; k < 2; ++k) {
            loops s;
            mbsr_newton *newton;
            mbsr_newton_info info;
            mbsr_newton_opt opt = mbsr_default_newton_opt();
            opt.products = opt.by_blocks = 1;
            loops_begin(&s, NULL);
            add_crowd(&s, k ? 400 : 100, legs);
            loops_build(&s);
            assert_ok(mbsr_newton_create(s.m, MBSR_DAE_MOMENTUM, &opt, &newton, NULL), NULL);
            check_products(newton, &s, 1.0);
            assert_ok(mbsr_newton_get_info(newton, &info), NULL);
            bytes[k] = (double)info.bytes / (double)mbsr_model_bodies(s.m);
            mbsr_newton_destroy(newton);
            loops_free(&s);
        }
        assert_less(bytes[1], 1.05 * bytes[0]);
    }
}

/* A blade under the origin of a body does not slip along y of it: one velocity row, and no
 * position.
 */
static int blade(const mbsr_closure_args *args, const mbsr_closure_jacobian *out)
{
    memcpy(out->matrix + out->column[0] + 3, args->body[0].p + MBSR_POSE_R + 3, 3 * sizeof(double));
    return 0;
}

static const mbsr_closure_table blade_table = {
    .version = MBSR_CLOSURE_TABLE_VERSION, .name = "blade", .jacobian = blade};

/* Chaplygin's sleigh on a slope, its mass at a in front of the blade, runs by v' = a w^2 - g sin,
 * w' = -m a (v w + g cos) / (I + m a^2); with a blade on a fork without mass in front, too. */
static void blades(void **state)
{
    (void)state;
    const double mass = 2.0, a = 0.3, inertia = 0.5, com[3] = {a, 0.0, 0.0},
                 tensor[6] = {0.3, 0.4, inertia}, z[3] = {0.0, 0.0, 1.0};
    const mbsr_frame front = mbsr_frame_at(1.0, 0.0, 0.0);
    for (int forked = 0; forked < 2; ++forked) {
        loops s;
        loops_begin(&s, NULL);
        for (int k = 0; k <= forked; ++k) {
            mbsr_body_def body = mbsr_default_body_def();
            body.parent = k - 1;
            body.joint = k ? mbsr_joint_revolute(&front, NULL, z) : mbsr_joint_in_plane(NULL, NULL);
            body.inertia = k ? mbsr_inertia_zero() : mbsr_inertia_rigid(mass, com, tensor);
            assert_ok(mbsr_model_add_body(s.m, &body, NULL), mbsr_model_error(s.m));
            const mbsr_closure_def def = mbsr_closure_custom(&blade_table, 1, &k, 1, 0, NULL);
            assert_ok(mbsr_model_add_closure(s.m, &def, NULL), mbsr_model_error(s.m));
        }
        const mbsr_force_def steering = mbsr_force_joint_spring(1, 0, 4.0, 0.5, 0.2);
        if (forked) assert_ok(mbsr_model_add_force(s.m, &steering, NULL), mbsr_model_error(s.m));
        loops_finish(&s);
        const double along = 1.2, turn = 0.9, angle = 0.4, c = cos(angle), sine = sin(angle);
        set(&s, (const double[4]){0.1, -0.2, angle, 0.15},
            (const double[4]){c * along, sine * along, turn, 0.3});
        if (!forked) {
            const double faster = a * turn * turn - 9.81 * sine, sideways = along * turn,
                         turning = -mass * a * (sideways + 9.81 * c) / (inertia + mass * a * a);
            assert_ok(mbsr_forward_dynamics(s.m, s.d, 0.0, s.q, s.u, NULL, s.udot),
                      mbsr_data_error(s.d));
            assert_close(s.udot[0], c * faster - sine * sideways, 1e-11);
            assert_close(s.udot[1], sine * faster + c * sideways, 1e-11);
            assert_close(s.udot[2], turning, 1e-11);
        }
        compare(&s, 1e-9);
        loops_free(&s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(fourbars),
                                       cmocka_unit_test(short_steps),
                                       cmocka_unit_test(locked_joints_without_load),
                                       cmocka_unit_test(nested),
                                       cmocka_unit_test(redundant_rows),
                                       cmocka_unit_test(nothing_holds),
                                       cmocka_unit_test(groups),
                                       cmocka_unit_test(loops_within_groups),
                                       cmocka_unit_test(a_point_within_a_loop),
                                       cmocka_unit_test(memory),
                                       cmocka_unit_test(no_memory_is_told),
                                       cmocka_unit_test(many_loops),
                                       cmocka_unit_test(crowds),
                                       cmocka_unit_test(blades),
                                       cmocka_unit_test(coordinates_with_other_rates)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
