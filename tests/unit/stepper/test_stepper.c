/* The stepper as an object: what it refuses, its memory, single steps beside the methods'
 * formula, refused steps, the same bits again. Orders: test_stepper_order.c; contacts, stiff
 * parts, energy: test_stepper_real_time.c.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "body.h"
#include "counting.h"
#include "loops.h"

#include <mbsrank/driver.h>

#include <string.h>

enum { MOST = 64 };

/* What the element of a scene does at its next calls. */
typedef struct element {
    double torque; /* N m, held */
    int status;    /* that it returns from `failing` s on, before `healthy` s */
    double failing, healthy, value;
} element;

/* Two rods on hinges in the plane with a torque on the first: a model with data, a stepper that
 * is started. */
typedef struct scene {
    loops s;
    element e;
    mbsr_stepper *stepper;
    int force; /* id of the torque */
} scene;

static int torque(void *user, double t, int n, double *value)
{
    const element *e = user;
    assert_int_equal(n, 1);
    value[0] = e->torque;
    if (t <= e->failing || t >= e->healthy) return MBSR_OK;
    value[0] = e->value;
    return e->status;
}

static void build(scene *x, const mbsr_allocator *allocator)
{
    memset(x, 0, sizeof *x);
    x->e.failing = INFINITY;
    mbsr_model_def def = mbsr_default_model_def();
    if (allocator) def.allocator = *allocator;
    assert_ok(mbsr_model_create(&def, &x->s.m, NULL), NULL);
    const mbsr_force_def gravity = mbsr_force_gravity(0.0, -9.81, 0.0);
    assert_ok(mbsr_model_add_force(x->s.m, &gravity, NULL), mbsr_model_error(x->s.m));
    const int a = loops_rod(&x->s, "a", MBSR_GROUND, 0.0, 0.0, 1.0, 1.0);
    loops_rod(&x->s, "b", a, 1.0, 0.0, 2.0, 1.0);
    mbsr_force_def motor = mbsr_force_joint_applied(a, torque, &x->e);
    motor.name = "motor";
    assert_ok(mbsr_model_add_force(x->s.m, &motor, &x->force), mbsr_model_error(x->s.m));
    loops_finish(&x->s);
    x->s.q[0] = 0.3, x->s.q[1] = -0.5, x->s.u[0] = 1.0, x->s.u[1] = 2.0;
}

static void create(scene *x, const mbsr_stepper_opt *opt)
{
    mbsr_error error;
    assert_ok(mbsr_stepper_create(x->s.m, x->s.d, opt, &x->stepper, &error), &error);
}

static void start(scene *x)
{
    assert_ok(mbsr_stepper_start(x->stepper, 0.0, x->s.q, x->s.u), mbsr_stepper_error(x->stepper));
}

static void open_scene(scene *x)
{
    build(x, NULL);
    create(x, NULL);
    start(x);
}

static void close_scene(scene *x)
{
    mbsr_stepper_destroy(x->stepper);
    loops_free(&x->s);
}

static void go(scene *x, int steps)
{
    for (int k = 0; k < steps; ++k)
        assert_ok(mbsr_stepper_step(x->stepper), mbsr_stepper_error(x->stepper));
}

/* t, y and y'; returns their number. */
static int look(mbsr_stepper *stepper, int size, double *numbers)
{
    assert_int_equal(mbsr_stepper_state(stepper, numbers, numbers + 1, numbers + 1 + size),
                     MBSR_OK);
    return 1 + 2 * size;
}

static mbsr_stepper_info info_of(const scene *x)
{
    mbsr_stepper_info info;
    assert_int_equal(mbsr_stepper_get_info(x->stepper, &info), MBSR_OK);
    return info;
}

/* ---- refusals ---- */

static void options_out_of_range_are_refused_by_name(void **state)
{
    (void)state;
    const mbsr_stepper_opt good = mbsr_default_stepper_opt();
    struct {
        mbsr_stepper_opt opt;
        int status;
        const char *words;
    } cases[13];
    for (int k = 0; k < 13; ++k) cases[k].opt = good, cases[k].status = MBSR_ERR_VALUE;
    cases[0].opt.cookie = 0, cases[0].status = MBSR_ERR_NO_DEFAULT, cases[0].words = "default";
    cases[1].opt.h = 0.0, cases[1].words = "h must|is 0";
    cases[2].opt.h = -1e-3, cases[2].words = "h must|-0.001";
    cases[3].opt.h = NAN, cases[3].words = "h must|nan";
    cases[4].opt.h = INFINITY, cases[4].words = "h must|inf";
    cases[5].opt.order = 3, cases[5].words = "order must|is 3";
    cases[6].opt.halvings = -1, cases[6].words = "halvings must|is -1";
    cases[7].opt.halvings = 11, cases[7].words = "halvings must|is 11";
    cases[8].opt.corrections = 1, cases[8].words = "corrections must|is 1";
    cases[9].opt.tolerance = 0.0, cases[9].words = "tolerance must|is 0";
    cases[10].opt.tolerance = 0.1, cases[10].words = "tolerance must|is 0.1";
    cases[11].opt.newton.method = (mbsr_newton_method)7, cases[11].words = "method is 7";
    cases[12].opt.matrix_steps = 0, cases[12].words = "matrix_steps must|is 0";
    scene x;
    build(&x, NULL);
    for (int k = 0; k < 13; ++k) {
        mbsr_error error;
        const int status = mbsr_stepper_create(x.s.m, x.s.d, &cases[k].opt, &x.stepper, &error);
        assert_refused(status, &error, cases[k].status, MBSR_NONE, MBSR_NONE, cases[k].words);
        assert_null(x.stepper);
    }
    close_scene(&x);
}

static void models_and_data_that_do_not_fit_are_refused(void **state)
{
    (void)state;
    scene x, other;
    mbsr_error error;
    mbsr_stepper *stepper;
    mbsr_model *unfinished;
    mbsr_data *lean;
    build(&x, NULL);
    build(&other, NULL);
    assert_int_equal(mbsr_stepper_create(NULL, x.s.d, NULL, &stepper, &error), MBSR_ERR_NULL);
    assert_contains(error.text, "model is NULL");
    assert_int_equal(mbsr_stepper_create(x.s.m, NULL, NULL, &stepper, &error), MBSR_ERR_NULL);
    assert_contains(error.text, "data is NULL");
    assert_int_equal(mbsr_stepper_create(x.s.m, x.s.d, NULL, NULL, NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_stepper_create(x.s.m, other.s.d, NULL, &stepper, &error),
                     MBSR_ERR_MISMATCH);
    assert_contains(error.text, "mbsr_stepper_create|another model");
    assert_ok(mbsr_model_create(NULL, &unfinished, NULL), NULL);
    assert_int_equal(mbsr_stepper_create(unfinished, x.s.d, NULL, &stepper, &error),
                     MBSR_ERR_UNFINISHED);
    mbsr_model_destroy(unfinished);
    assert_ok(mbsr_data_create_lean(x.s.m, &lean, &error), &error);
    assert_int_equal(mbsr_stepper_create(x.s.m, lean, NULL, &stepper, &error), MBSR_ERR_LEAN);
    assert_null(stepper);
    mbsr_data_destroy(lean);
    close_scene(&other);
    close_scene(&x);
}

/* A spring from ground to the second rod is an element across nothing; one from the first to the
 * third is. */
static void a_newton_solver_that_leaves_elements_out_is_refused(void **state)
{
    (void)state;
    loops s;
    mbsr_stepper *stepper;
    mbsr_error error;
    const double end[3] = {1.0, 0.0, 0.0};
    loops_begin(&s, NULL);
    const int a = loops_rod(&s, "a", MBSR_GROUND, 0.0, 0.0, 1.0, 1.0);
    const int b = loops_rod(&s, "b", a, 1.0, 0.0, 1.0, 1.0);
    const int c = loops_rod(&s, "c", b, 1.0, 0.0, 1.0, 1.0);
    const mbsr_force_def across = mbsr_force_point_spring(a, end, c, end, 1e3, 1.0, 0.5);
    assert_ok(mbsr_model_add_force(s.m, &across, NULL), mbsr_model_error(s.m));
    loops_finish(&s);
    mbsr_stepper_opt opt = mbsr_default_stepper_opt();
    opt.newton.method = MBSR_NEWTON_TREE;
    const int status = mbsr_stepper_create(s.m, s.d, &opt, &stepper, &error);
    assert_refused(status, &error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                   "1 force elements lie across the tree|newton");
    assert_null(stepper);
    assert_ok(mbsr_stepper_create(s.m, s.d, NULL, &stepper, &error), &error);
    mbsr_stepper_destroy(stepper);
    loops_free(&s);
}

static void calls_before_the_start_and_wrong_times_are_refused(void **state)
{
    (void)state;
    scene x;
    double number;
    build(&x, NULL);
    create(&x, NULL);
    mbsr_stepper *s = x.stepper;
    assert_refused(mbsr_stepper_step(s), mbsr_stepper_error(s), MBSR_ERR_SEQUENCE, MBSR_NONE,
                   MBSR_NONE, "mbsr_stepper_start");
    assert_int_equal(mbsr_stepper_to(s, 1.0), MBSR_ERR_SEQUENCE);
    assert_int_equal(mbsr_stepper_motion(s, &number, NULL, NULL), MBSR_ERR_SEQUENCE);
    assert_int_equal(mbsr_stepper_state(s, &number, NULL, NULL), MBSR_ERR_SEQUENCE);
    assert_int_equal(mbsr_stepper_start(s, 0.0, NULL, x.s.u), MBSR_ERR_NULL);
    assert_int_equal(mbsr_stepper_start(s, NAN, x.s.q, x.s.u), MBSR_NOT_FINITE);
    start(&x);
    const double times[] = {0.0, -1.0, NAN, INFINITY};
    for (size_t k = 0; k < sizeof times / sizeof times[0]; ++k)
        assert_refused(mbsr_stepper_to(s, times[k]), mbsr_stepper_error(s), MBSR_ERR_VALUE,
                       MBSR_NONE, MBSR_NONE, "mbsr_stepper_to: t_end is|later than t = 0");
    assert_ok(mbsr_stepper_start(s, 1e20, x.s.q, x.s.u), mbsr_stepper_error(s));
    assert_refused(mbsr_stepper_step(s), mbsr_stepper_error(s), MBSR_ERR_VALUE, MBSR_NONE,
                   MBSR_NONE, "0.001 s does not change t = 1e+20");
    assert_int_equal(mbsr_stepper_resume(s, 0.0, NULL, NULL), MBSR_ERR_NULL);
    number = NAN;
    assert_int_equal(mbsr_stepper_step(NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_stepper_to(NULL, 1.0), MBSR_ERR_NULL);
    assert_int_equal(mbsr_stepper_get_info(s, NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_stepper_error(NULL)->status, MBSR_ERR_NULL);
    mbsr_stepper_destroy(NULL);
    close_scene(&x);
}

static void memory_that_fails_leaves_nothing(void **state)
{
    (void)state;
    for (int at = 1;; ++at) {
        test_counting counting = {0};
        const mbsr_allocator allocator = test_counting_allocator(&counting);
        scene x;
        mbsr_error error;
        build(&x, &allocator);
        const long live = counting.live;
        counting.fail_at = counting.calls + at;
        const int status = mbsr_stepper_create(x.s.m, x.s.d, NULL, &x.stepper, &error);
        if (counting.failed) {
            assert_int_equal(status, MBSR_ERR_NO_MEMORY);
            assert_null(x.stepper);
            assert_int_equal(counting.live, live);
        }
        counting.fail_at = 0;
        close_scene(&x);
        assert_int_equal(counting.live, 0);
        if (counting.failed) continue;
        assert_int_equal(status, MBSR_OK);
        assert_true(at > 3);
        return;
    }
}

/* ---- single steps ---- */

/* Mass 1 kg on a spring with damper: one step multiplies (x, v) by R(h A), and R is known. */
static void a_step_of_an_oscillator_is_that_of_the_method(void **state)
{
    (void)state;
    const double k = 30.0, d = 0.7, h = 0.1, g = 1.0 - sqrt(0.5);
    for (int order = 1; order <= 2; ++order) {
        loops s;
        mbsr_stepper *stepper;
        mbsr_error error;
        mbsr_stepper_opt opt = mbsr_default_stepper_opt();
        opt.h = h, opt.order = order, opt.tolerance = 1e-14;
        loops_begin(&s, NULL);
        const int mass = test_add_body(s.m, MBSR_GROUND,
                                       mbsr_joint_point((mbsr_planar_frame){0}, 1, 0, NULL, NULL),
                                       mbsr_inertia_particle(1.0));
        const mbsr_force_def spring = mbsr_force_joint_spring(mass, 0, k, d, 0.0);
        assert_ok(mbsr_model_add_force(s.m, &spring, NULL), mbsr_model_error(s.m));
        loops_finish(&s);
        s.q[0] = 0.4, s.u[0] = -1.5;
        assert_ok(mbsr_stepper_create(s.m, s.d, &opt, &stepper, &error), &error);
        assert_ok(mbsr_stepper_start(stepper, 0.0, s.q, s.u), mbsr_stepper_error(stepper));
        assert_ok(mbsr_stepper_step(stepper), mbsr_stepper_error(stepper));
        /* order 1: (1 - h A)^-1; order 2: (1 - g h A)^-2 (1 + (1 - 2 g) h A); A = (0, 1; -k, -d) */
        double x = s.q[0], v = s.u[0];
        const double c = order == 1 ? 1.0 : g;
        if (order == 2) {
            const double w = (1.0 - 2.0 * g) * h, now = x;
            x += w * v;
            v += w * (-k * now - d * v);
        }
        for (int stage = 0; stage < order; ++stage) {
            const double a = c * h;
            v = (v - a * k * x) / (1.0 + a * d + a * a * k);
            x += a * v;
        }
        double q, u;
        assert_int_equal(mbsr_stepper_motion(stepper, NULL, &q, &u), MBSR_OK);
        assert_close(q, x, 1e-14);
        assert_close(u, v, 1e-13);
        mbsr_stepper_destroy(stepper);
        loops_free(&s);
    }
}

static void times_are_multiples_of_h(void **state)
{
    (void)state;
    scene x;
    double t;
    open_scene(&x);
    go(&x, 1000);
    mbsr_stepper_motion(x.stepper, &t, NULL, NULL);
    assert_true(t == 1000 * 1e-3);
    assert_ok(mbsr_stepper_to(x.stepper, 1.0003), mbsr_stepper_error(x.stepper));
    go(&x, 7);
    mbsr_stepper_motion(x.stepper, &t, NULL, NULL);
    assert_true(t == 1.0003 + 7 * 1e-3);
    assert_int_equal(info_of(&x).steps, 1008);
    close_scene(&x);
}

static void the_data_is_at_velocities_of_the_new_state(void **state)
{
    (void)state;
    scene x;
    double q[2], u[2], pose[3], V[3], expected[3], kinetic, again, p[2];
    open_scene(&x);
    go(&x, 20);
    mbsr_stepper_motion(x.stepper, NULL, q, u);
    assert_ok(mbsr_body_pose(x.s.m, x.s.d, 1, pose), mbsr_data_error(x.s.d));
    assert_ok(mbsr_body_twist(x.s.m, x.s.d, 1, V), mbsr_data_error(x.s.d));
    assert_ok(mbsr_energy(x.s.m, x.s.d, &kinetic, NULL), mbsr_data_error(x.s.d));
    assert_ok(mbsr_momenta(x.s.m, x.s.d, p), mbsr_data_error(x.s.d));
    assert_close(pose[0], cos(q[0]), 1e-14);
    assert_close(V[2], u[0] + u[1], 1e-14);
    assert_close(kinetic, 0.5 * (p[0] * u[0] + p[1] * u[1]), 1e-12);
    mbsr_stage_positions(x.s.m, x.s.d, 0.02, q);
    mbsr_stage_velocities(x.s.m, x.s.d, u);
    mbsr_body_pose(x.s.m, x.s.d, 1, expected);
    mbsr_energy(x.s.m, x.s.d, &again, NULL);
    assert_memory_equal(pose, expected, sizeof pose);
    assert_true(kinetic == again);
    close_scene(&x);
}

/* The torque set before a step acts in that step: p' = torque less weight. */
static void inputs_are_held_over_the_step(void **state)
{
    (void)state;
    scene x;
    double y[2][MOST];
    for (int k = 0; k < 2; ++k) {
        open_scene(&x);
        go(&x, 3);
        x.e.torque = k ? 1000.0 : 0.0;
        go(&x, 1);
        mbsr_stepper_state(x.stepper, NULL, y[k], NULL);
        close_scene(&x);
    }
    assert_close(y[1][2] - y[0][2], 1000.0 * 1e-3, 0.01);
}

/* A rod on a hinge with a stop falls on it; lengths in metre, millimetre, kilometre, masses in
 * kilogram, gram, tonne; times in seconds, and in half a year. */
static void units_do_not_matter(void **state)
{
    (void)state;
    enum { SYSTEMS = 4 };
    static const double metre[SYSTEMS] = {1.0, 1e3, 1e-3, 1.0},
                        kilogram[SYSTEMS] = {1.0, 1e3, 1e-3, 1.0},
                        second[SYSTEMS] = {1.0, 1.0, 1.0, 0x1p-24};
    double q[SYSTEMS], u[SYSTEMS];
    mbsr_stepper_info info[SYSTEMS];
    for (int k = 0; k < SYSTEMS; ++k) {
        const double T = second[k], moment = kilogram[k] * metre[k] * metre[k],
                     energy = moment / (T * T);
        const mbsr_planar_frame origin = {0}, end = {metre[k], 0.0, 0.0};
        const double com[2] = {0.5 * metre[k], 0.0};
        mbsr_model *m;
        mbsr_data *d;
        mbsr_stepper *stepper;
        mbsr_error error;
        mbsr_stepper_opt opt = mbsr_default_stepper_opt();
        opt.h = 0.01 * T;
        assert_ok(mbsr_model_create(NULL, &m, &error), &error);
        const int a = test_add_body(m, MBSR_GROUND, mbsr_joint_planar_revolute(origin, origin),
                                    mbsr_inertia_planar(kilogram[k], com, moment / 12.0));
        test_add_body(m, a, mbsr_joint_planar_revolute(end, origin),
                      mbsr_inertia_planar(kilogram[k], com, moment / 12.0));
        const mbsr_force_def forces[] = {
            mbsr_force_gravity(0.0, -9.81 * metre[k] / (T * T), 0.0),
            mbsr_force_joint_stop(a, 0, -0.5, INFINITY, 1e6 * energy, 1e3 * energy * T),
            mbsr_force_joint_friction(a + 1, 0, 0.1 * energy, 1e-3 / T)};
        for (int f = 0; f < 3; ++f)
            assert_ok(mbsr_model_add_force(m, forces + f, NULL), mbsr_model_error(m));
        assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
        assert_ok(mbsr_data_create(m, &d, &error), &error);
        assert_ok(mbsr_stepper_create(m, d, &opt, &stepper, &error), &error);
        const double zero[2] = {0.0};
        double now_q[2], now_u[2];
        assert_ok(mbsr_stepper_start(stepper, 0.0, zero, zero), mbsr_stepper_error(stepper));
        for (int n = 0; n < 60; ++n)
            assert_ok(mbsr_stepper_step(stepper), mbsr_stepper_error(stepper));
        mbsr_stepper_motion(stepper, NULL, now_q, now_u);
        mbsr_stepper_get_info(stepper, info + k);
        q[k] = now_q[1], u[k] = now_u[1] * T;
        mbsr_stepper_destroy(stepper);
        mbsr_data_destroy(d);
        mbsr_model_destroy(m);
    }
    assert_true(fabs(q[0]) > 0.1);
    for (int k = 1; k < SYSTEMS; ++k) {
        assert_close(q[k], q[0], 1e-9);
        assert_close(u[k], u[0], 1e-7);
        assert_int_equal(info[k].most.residuals, info[0].most.residuals);
        assert_int_equal(info[k].most.substeps, info[0].most.substeps);
    }
}

/* Carts in a row, none of which turns: the last rubs, the first runs against a stop. Ways of 64
 * steps. */
static void run_carts(double L, double M, double T, double *q)
{
    enum { CARTS = 4, STEPS = 64 };
    const double x_axis[3] = {1.0, 0.0, 0.0}, none[3] = {0.0}, force = M * L / (T * T);
    double u[CARTS];
    mbsr_model *m = NULL;
    mbsr_data *d = NULL;
    mbsr_stepper *stepper = NULL;
    mbsr_stepper_opt opt = mbsr_default_stepper_opt();
    opt.h = T / STEPS;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    for (int k = 0; k < CARTS; ++k) {
        mbsr_body_def body = mbsr_default_body_def();
        body.parent = k - 1;
        body.joint = mbsr_joint_prismatic(NULL, NULL, x_axis);
        body.inertia = mbsr_inertia_point_mass((1 + k) * M, none);
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
        const double damping = k == 1 || k == 2 ? 2.0 : 0.1;
        const mbsr_force_def spring =
            mbsr_force_joint_spring(k, 0, (10 + 5 * k) * force / L, damping * force * T / L, 0.0);
        assert_ok(mbsr_model_add_force(m, &spring, NULL), mbsr_model_error(m));
        q[k] = (k % 2 ? 0.1 : -0.1) * (k + 1) * L;
        u[k] = 0.2 * k * L / T;
    }
    const mbsr_force_def more[] = {
        mbsr_force_joint_friction(3, 0, 2.0 * force, 0.01 * L / T),
        mbsr_force_joint_stop(0, 0, -0.05 * L, 0.05 * L, 1e4 * force / L, 10.0 * force * T / L)};
    for (int k = 0; k < 2; ++k)
        assert_ok(mbsr_model_add_force(m, more + k, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_close(mbsr_model_length(m) / (0.05 * L), 1.0, 1e-12);
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    assert_ok(mbsr_stepper_create(m, d, &opt, &stepper, NULL), NULL);
    assert_ok(mbsr_stepper_start(stepper, 0.0, q, u), mbsr_stepper_error(stepper));
    for (int k = 0; k < STEPS; ++k)
        assert_ok(mbsr_stepper_step(stepper), mbsr_stepper_error(stepper));
    assert_ok(mbsr_stepper_motion(stepper, NULL, q, u), mbsr_stepper_error(stepper));
    for (int k = 0; k < CARTS; ++k) q[k] /= L;
    mbsr_stepper_destroy(stepper);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

static void nor_do_they_where_nothing_turns(void **state)
{
    (void)state;
    double si[4], other[4];
    run_carts(1.0, 1.0, 1.0, si);
    run_carts(1.0 / 4096, 4096, 1.0 / 4096, other);
    for (int k = 0; k < 4; ++k) assert_close(other[k], si[k], 1e-9);
}

/* ---- refused steps ---- */

static void a_failing_callback_refuses_the_step_and_nothing_else(void **state)
{
    (void)state;
    const int statuses[] = {7, -7};
    for (int k = 0; k < 2; ++k) {
        scene x, calm;
        double before[MOST], after[MOST], expected[MOST];
        open_scene(&x);
        open_scene(&calm);
        go(&x, 5);
        go(&calm, 5);
        x.e.status = statuses[k], x.e.failing = 5e-3, x.e.healthy = INFINITY;
        const int n = look(x.stepper, x.s.size, before);
        assert_refused(mbsr_stepper_step(x.stepper), mbsr_stepper_error(x.stepper), statuses[k],
                       MBSR_NONE, x.force, "t = 0.005 s|refused|motor");
        assert_int_equal(look(x.stepper, x.s.size, after), n);
        assert_memory_equal(before, after, (size_t)n * sizeof *before);
        assert_int_equal(info_of(&x).refused, 1);
        assert_int_equal(info_of(&x).steps, 5);
        assert_int_equal(info_of(&x).last.attempts, statuses[k] < 0 ? 1 : 6);
        /* the data, too */
        double pose[3];
        assert_ok(mbsr_body_pose(x.s.m, x.s.d, 1, pose), mbsr_data_error(x.s.d));
        assert_true(pose[0] == cos(before[1]));
        x.e.failing = INFINITY;
        go(&x, 5);
        go(&calm, 5);
        look(x.stepper, x.s.size, after);
        look(calm.stepper, x.s.size, expected);
        assert_memory_equal(after, expected, (size_t)n * sizeof *after);
        close_scene(&calm);
        close_scene(&x);
    }
}

static void a_step_that_fails_in_between_is_halved(void **state)
{
    (void)state;
    scene x;
    open_scene(&x);
    go(&x, 5);
    x.e.status = 7, x.e.failing = 5.29e-3, x.e.healthy = 5.30e-3; /* stage 1 is at 5.293 ms */
    go(&x, 1);
    assert_int_equal(info_of(&x).last.substeps, 2);
    assert_int_equal(info_of(&x).last.attempts, 3);
    close_scene(&x);
}

static void what_is_not_finite_refuses_the_step(void **state)
{
    (void)state;
    scene x;
    double before[MOST], after[MOST];
    open_scene(&x);
    x.e.failing = 0.0, x.e.healthy = INFINITY, x.e.value = NAN;
    const int n = look(x.stepper, x.s.size, before);
    const int status = mbsr_stepper_step(x.stepper);
    assert_int_equal(status, MBSR_NOT_FINITE);
    assert_contains(mbsr_stepper_error(x.stepper)->text, "refused after|body 0 'a'|not finite");
    look(x.stepper, x.s.size, after);
    assert_memory_equal(before, after, (size_t)n * sizeof *before);
    close_scene(&x);
}

/* A massless bead loses the springs that determine its motion. */
static void a_singular_matrix_refuses_the_step_by_the_name_of_the_body(void **state)
{
    (void)state;
    loops s;
    mbsr_stepper *stepper;
    mbsr_error error;
    int force;
    double before[MOST], after[MOST];
    loops_begin(&s, NULL);
    mbsr_body_def bead = mbsr_default_body_def();
    bead.name = "bead";
    bead.joint = mbsr_joint_point((mbsr_planar_frame){0}, 1, 0, NULL, NULL);
    assert_ok(mbsr_model_add_body(s.m, &bead, NULL), mbsr_model_error(s.m));
    const mbsr_force_def spring = mbsr_force_joint_spring(0, 0, 10.0, 1.0, 0.0);
    assert_ok(mbsr_model_add_force(s.m, &spring, &force), mbsr_model_error(s.m));
    loops_finish(&s);
    assert_ok(mbsr_stepper_create(s.m, s.d, NULL, &stepper, &error), &error);
    assert_ok(mbsr_stepper_start(stepper, 0.0, s.q, s.u), mbsr_stepper_error(stepper));
    assert_ok(mbsr_stepper_step(stepper), mbsr_stepper_error(stepper));
    const int n = look(stepper, s.size, before);
    assert_ok(mbsr_force_switch(s.m, s.d, force, 0), mbsr_data_error(s.d));
    assert_int_equal(mbsr_stepper_step(stepper), MBSR_SINGULAR_BLOCK);
    assert_contains(mbsr_stepper_error(stepper)->text, "bead");
    look(stepper, s.size, after);
    assert_memory_equal(before, after, (size_t)n * sizeof *before);
    mbsr_stepper_destroy(stepper);
    loops_free(&s);
}

/* ---- the same again ---- */

static void the_same_inputs_give_the_same_bits(void **state)
{
    (void)state;
    double numbers[2][MOST];
    int n = 0;
    for (int k = 0; k < 2; ++k) {
        scene x;
        open_scene(&x);
        for (int step = 0; step < 200; ++step) {
            x.e.torque = 5.0 * sin(0.1 * step);
            go(&x, 1);
        }
        n = look(x.stepper, x.s.size, numbers[k]);
        close_scene(&x);
    }
    assert_memory_equal(numbers[0], numbers[1], (size_t)n * sizeof(double));
}

static void a_state_that_is_kept_is_gone_on_with_in_another_stepper(void **state)
{
    (void)state;
    scene x, other;
    double kept[MOST], after[MOST], again[MOST];
    open_scene(&x);
    open_scene(&other);
    go(&x, 50);
    const int n = look(x.stepper, x.s.size, kept);
    go(&x, 50);
    look(x.stepper, x.s.size, after);
    assert_ok(mbsr_stepper_resume(other.stepper, kept[0], kept + 1, kept + 1 + x.s.size),
              mbsr_stepper_error(other.stepper));
    for (int k = 51; k <= 100; ++k)
        assert_ok(mbsr_stepper_to(other.stepper, k * 1e-3), mbsr_stepper_error(other.stepper));
    look(other.stepper, x.s.size, again);
    /* steps to a time differ from those of h by rounding, and so by what Newton's method leaves */
    for (int k = 0; k < n; ++k) assert_close(after[k], again[k], 1e-9 * (1.0 + fabs(after[k])));
    /* the same calls: the same bits */
    assert_ok(mbsr_stepper_resume(x.stepper, kept[0], kept + 1, kept + 1 + x.s.size), NULL);
    for (int k = 51; k <= 100; ++k)
        assert_ok(mbsr_stepper_to(x.stepper, k * 1e-3), mbsr_stepper_error(x.stepper));
    look(x.stepper, x.s.size, after);
    assert_memory_equal(after, again, (size_t)n * sizeof *after);
    kept[2] = NAN;
    assert_int_equal(mbsr_stepper_resume(x.stepper, 0.0, kept + 1, kept + 1 + x.s.size),
                     MBSR_NOT_FINITE);
    look(x.stepper, x.s.size, again);
    assert_memory_equal(after, again, (size_t)n * sizeof *after);
    close_scene(&other);
    close_scene(&x);
}

static void work_is_counted_and_bounded(void **state)
{
    (void)state;
    scene x;
    mbsr_stepper_opt opt = mbsr_default_stepper_opt();
    opt.halvings = 2, opt.corrections = 5;
    build(&x, NULL);
    create(&x, &opt);
    start(&x);
    const mbsr_stepper_work bound = info_of(&x).bound;
    assert_int_equal(bound.attempts, 7 + 4);
    assert_int_equal(bound.substeps, 4);
    assert_int_equal(bound.residuals, (7 * 2 + 4 * 4) * 5);
    assert_int_equal(bound.solves, 2 * bound.residuals);
    assert_int_equal(bound.factorisations, bound.residuals + 7 * 2 + 4);
    go(&x, 3);
    assert_int_equal(info_of(&x).last.factorisations, 1);
    assert_int_equal(info_of(&x).last.attempts, 1);
    assert_int_equal(info_of(&x).last.residuals, info_of(&x).last.solves);
    assert_in_range(info_of(&x).last.residuals, 4, 6);
    x.e.failing = 3e-3, x.e.healthy = INFINITY, x.e.status = 1;
    assert_int_equal(mbsr_stepper_step(x.stepper), 1);
    assert_int_equal(info_of(&x).most.attempts, 4);
    start(&x);
    assert_int_equal(info_of(&x).most.attempts, 0);
    assert_int_equal(info_of(&x).bound.attempts, 11);
    assert_true(info_of(&x).bytes > sizeof(double) * 10 * (size_t)x.s.size);
    close_scene(&x);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(options_out_of_range_are_refused_by_name),
        cmocka_unit_test(models_and_data_that_do_not_fit_are_refused),
        cmocka_unit_test(a_newton_solver_that_leaves_elements_out_is_refused),
        cmocka_unit_test(calls_before_the_start_and_wrong_times_are_refused),
        cmocka_unit_test(memory_that_fails_leaves_nothing),
        cmocka_unit_test(a_step_of_an_oscillator_is_that_of_the_method),
        cmocka_unit_test(times_are_multiples_of_h),
        cmocka_unit_test(the_data_is_at_velocities_of_the_new_state),
        cmocka_unit_test(inputs_are_held_over_the_step),
        cmocka_unit_test(units_do_not_matter),
        cmocka_unit_test(nor_do_they_where_nothing_turns),
        cmocka_unit_test(a_failing_callback_refuses_the_step_and_nothing_else),
        cmocka_unit_test(a_step_that_fails_in_between_is_halved),
        cmocka_unit_test(what_is_not_finite_refuses_the_step),
        cmocka_unit_test(a_singular_matrix_refuses_the_step_by_the_name_of_the_body),
        cmocka_unit_test(the_same_inputs_give_the_same_bits),
        cmocka_unit_test(a_state_that_is_kept_is_gone_on_with_in_another_stepper),
        cmocka_unit_test(work_is_counted_and_bounded),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
