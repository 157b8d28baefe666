/* Motions in space that are known: a pendulum, the heavy top, a free body that turns over, a
 * floating tree, a flyball governor.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "reference_runs.h"
#include "space.h"

#include <string.h>

static const double e_x[3] = {1.0, 0.0, 0.0}, e_z[3] = {0.0, 0.0, 1.0};

static void cross(const double *a, const double *b, double *c)
{
    for (int k = 0; k < 3; ++k)
        c[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

static double dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* ---- what a state of a model is -------------------------------------------------------------- */

typedef struct observed {
    double energy, momentum[6];            /* J; angular about the world's origin, linear */
    double pose[MBSR_POSE_SIZE], twist[6]; /* of body 0 */
} observed;

static observed observe(const mbsr_model *m, mbsr_data *d, const run_state *s)
{
    observed o;
    double kinetic, potential;
    assert_ok(mbsr_stage_positions(m, d, s->t, s->q), mbsr_data_error(d));
    assert_ok(mbsr_stage_velocities(m, d, s->u), mbsr_data_error(d));
    assert_ok(mbsr_energy(m, d, &kinetic, &potential), mbsr_data_error(d));
    o.energy = kinetic + potential;
    assert_ok(mbsr_tree_momentum(m, d, NULL, NULL, NULL, o.momentum), mbsr_data_error(d));
    assert_ok(mbsr_body_pose(m, d, 0, o.pose), mbsr_data_error(d));
    assert_ok(mbsr_body_twist(m, d, 0, o.twist), mbsr_data_error(d));
    return o;
}

/* A form, its tolerance, and bounds on the error and on the drift of what is conserved: about five
 * times what is found. */
typedef struct trial {
    mbsr_dae_form form;
    double tolerance, error, drift;
} trial;

/* Integrates and observes the start and all outputs. */
enum { MOST_POINTS = 40 };
static void observe_run(run *r, run_state *state, observed *o)
{
    mbsr_data *d = NULL;
    assert_in_range(r->points, 1, MOST_POINTS);
    run_integrate(r, state);
    if (r->form == MBSR_DAE_MOMENTUM && r->tolerance > 5e-8) run_compare(r, RUN_REPEATS);
    assert_ok(mbsr_data_create(r->model, &d, NULL), NULL);
    for (int k = 0; k <= r->points; ++k) o[k] = observe(r->model, d, state + k);
    mbsr_data_destroy(d);
}

/* ---- pendulum -------------------------------------------------------------------------------- */

/* 4 K(1 / sqrt 2) sqrt(l / g) by the arithmetic-geometric mean, l = 1 m. */
static double quarter_period(void)
{
    double a = 1.0, b = sqrt(0.5);
    for (int k = 0; k < 8; ++k) {
        const double mean = 0.5 * (a + b);
        b = sqrt(a * b);
        a = mean;
    }
    const double pi = acos(-1.0);
    assert_close(2.0 * pi / a / sqrt(9.81), 2.3678, 5e-5);
    return 0.5 * pi / a / sqrt(9.81);
}

static int at_the_bottom(void *user, double t, const double *y, const double *yp, double *value)
{
    (void)t, (void)yp;
    value[0] = y[0] - *(const double *)user;
    return MBSR_OK;
}

/* A particle of 1 kg on a rod of 1 m without mass, let go from the horizontal, about a horizontal
 * axis: passes the bottom at 1/4, 3/4, 5/4 of its period. */
static void the_pendulum_has_its_period(void **unused)
{
    (void)unused;
    const double axis[3] = {0.6, -0.8, 0.0}, out[3] = {0.8, 0.6, 0.0};
    double bottom = acos(0.0);
    mbsr_model *m = run_model();
    run_body(m, "pendulum", MBSR_GROUND, mbsr_joint_revolute(NULL, NULL, axis),
             mbsr_inertia_point_mass(1.0, out));
    run_force(m, mbsr_force_gravity(0.0, 0.0, -9.81));
    run_finish(m);
    mbsr_data *d = NULL;
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    for (int f = 0; f < RUN_FORMS; ++f) {
        mbsr_ida *ida = NULL;
        mbsr_error error = {0};
        run_state start;
        run r = {.model = m, .form = run_forms[f]};
        double y[3], yp[3], t;
        run_consistent(&r, d, y, yp, &start);
        /* the axis turns `out` down for which sign of the angle? */
        double sense[3];
        cross(axis, out, sense);
        bottom = sense[2] < 0.0 ? fabs(bottom) : -fabs(bottom);
        mbsr_ida_opt opt = mbsr_default_ida_opt();
        opt.form = run_forms[f];
        opt.rtol = opt.atol = 1e-10;
        opt.events = 1;
        opt.event = at_the_bottom;
        opt.event_user = &bottom;
        assert_ok(mbsr_ida_create(m, d, &opt, &ida, &error), &error);
        assert_ok(mbsr_ida_start(ida, 0.0, y, yp), mbsr_ida_error(ida));
        for (int pass = 0; pass < 3; ++pass) {
            assert_int_equal(mbsr_ida_advance(ida, 10.0, &t, y, NULL), MBSR_EVENT);
            assert_close(t, (1 + 2 * pass) * quarter_period(), 1e-7);
        }
        mbsr_ida_destroy(ida);
    }
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

/* ---- the heavy top --------------------------------------------------------------------------- */

static const double top_mass = 15.0, top_transverse = 0.234375, top_axial = 0.46875;

/* Angular momentum L about the fixed point, the top's axis n and another direction e of it:
 *
 *   L' = n x (-m g e_z),   n' = omega x n,   e' = omega x e,
 *   omega = L / I + (1 / I3 - 1 / I) (L . n) n,   I about the fixed point */
static void top_slope(const double *x, double *slope)
{
    const double *L = x, *n = x + 3, *e = x + 6, weight[3] = {0.0, 0.0, -9.81 * top_mass};
    const double I = top_transverse + top_mass, axial = dot(L, n);
    double omega[3];
    for (int k = 0; k < 3; ++k) omega[k] = L[k] / I + (1.0 / top_axial - 1.0 / I) * axial * n[k];
    cross(n, weight, slope);
    cross(omega, n, slope + 3);
    cross(omega, e, slope + 6);
}

/* Classical Runge-Kutta steps of `size` numbers. */
static void runge_kutta(int size, double *x, double h, int steps,
                        void (*slope)(const double *x, double *slope))
{
    static const double node[] = {0.0, 0.5, 0.5, 1.0}, weight[] = {1.0, 2.0, 2.0, 1.0};
    for (int step = 0; step < steps; ++step) {
        double stage[16], k[16] = {0.0}, sum[16] = {0.0};
        for (int s = 0; s < 4; ++s) {
            for (int c = 0; c < size; ++c) stage[c] = x[c] + node[s] * h * k[c];
            slope(stage, k);
            for (int c = 0; c < size; ++c) sum[c] += weight[s] * h / 6.0 * k[c];
        }
        for (int c = 0; c < size; ++c) x[c] += sum[c];
    }
}

static mbsr_model *top(void)
{
    const double com[3] = {0.0, 1.0, 0.0},
                 tensor[6] = {top_transverse, top_axial, top_transverse, 0.0, 0.0, 0.0};
    mbsr_model *m = run_model();
    run_body(m, "top", MBSR_GROUND, mbsr_joint_spherical(NULL, NULL),
             mbsr_inertia_rigid(top_mass, com, tensor));
    run_force(m, mbsr_force_gravity(0.0, 0.0, -9.81));
    return run_finish(m);
}

static const double top_q[4] = {1.0, 0.0, 0.0, 0.0}, top_u[3] = {0.0, 150.0, -4.61538};
static const double top_T = 1.0;

/* L, n, e at top_T; two step sizes agree. */
static void top_reference(double *x)
{
    const double I = top_transverse + top_mass,
                 start[9] = {0.0, top_axial * top_u[1], I * top_u[2], 0.0, 1.0, 0.0, 1.0, 0.0, 0.0};
    double coarse[9];
    memcpy(x, start, sizeof start);
    memcpy(coarse, start, sizeof start);
    const int steps = test_seeds(50000, 100000);
    runge_kutta(9, x, 0.5 * top_T / steps, 2 * steps, top_slope);
    runge_kutta(9, coarse, top_T / steps, steps, top_slope);
    for (int k = 0; k < 9; ++k) assert_close(x[k], coarse[k], 1e-9);
}

static void check_top(const mbsr_model *m, const double *x, const trial *is)
{
    run_state state[MOST_POINTS + 1];
    observed o[MOST_POINTS + 1];
    run r = {.name = "heavy top",
             .model = m,
             .form = is->form,
             .tolerance = is->tolerance,
             .T = top_T,
             .points = 10,
             .q = top_q,
             .u = top_u};
    observe_run(&r, state, o);
    double error = 0.0, drift = 0.0;
    const double momentum = top_axial * top_u[1];
    for (int k = 0; k <= r.points; ++k) {
        const double *axis = o[k].pose + MBSR_POSE_R + 3;
        drift = run_larger(drift, fabs(o[k].energy / o[0].energy - 1.0));
        drift = run_larger(drift, fabs(o[k].momentum[2] - o[0].momentum[2]) / momentum);
        drift = run_larger(drift, fabs(dot(axis, o[k].twist) / top_u[1] - 1.0));
    }
    const observed *last = o + r.points;
    for (int k = 0; k < 3; ++k) {
        error = run_larger(error, fabs(last->pose[MBSR_POSE_R + 3 + k] - x[3 + k]));
        error = run_larger(error, fabs(last->pose[MBSR_POSE_R + k] - x[6 + k]));
        error = run_larger(error, fabs(last->momentum[k] - x[k]) / momentum);
    }
    run_report(&r, error);
    print_message("    energy, vertical momentum, spin to %.1e\n", drift);
    assert_less(error, is->error);
    assert_less(drift, is->drift);
}

static void the_heavy_top_moves_as_its_angular_momentum_says(void **unused)
{
    (void)unused;
    static const trial trials[] = {
        {MBSR_DAE_MOMENTUM, 1e-6, 1e-2, 1e-3},  {MBSR_DAE_MOMENTUM, 1e-8, 7e-4, 2e-5},
        {MBSR_DAE_MOMENTUM, 1e-10, 2e-5, 6e-7}, {MBSR_DAE_MOMENTUM, 1e-12, 5e-7, 2e-8},
        {MBSR_DAE_RECURSIVE, 1e-8, 3e-4, 6e-5}, {MBSR_DAE_INVERSE_DYNAMICS, 1e-8, 1e-4, 3e-5},
        {MBSR_DAE_INDEX1, 1e-8, 5e-5, 4e-5}};
    double x[9];
    top_reference(x);
    mbsr_model *m = top();
    for (size_t k = 0; k < sizeof trials / sizeof trials[0]; ++k) check_top(m, x, trials + k);
    mbsr_model_destroy(m);
}

/* ---- a free body ----------------------------------------------------------------------------- */

static const double principal[3] = {1.0, 1.8, 2.5};

/* Euler's equations in body axes, and the axes: R' = R [omega]x, columns of R behind omega. */
static void free_slope(const double *x, double *slope)
{
    const double *w = x, *R = x + 3;
    for (int k = 0; k < 3; ++k) {
        const int a = (k + 1) % 3, b = (k + 2) % 3;
        slope[k] = (principal[a] - principal[b]) / principal[k] * w[a] * w[b];
        for (int l = 0; l < 3; ++l)
            slope[3 + 3 * k + l] = R[3 * a + l] * w[b] - R[3 * b + l] * w[a];
    }
}

/* A body that spins about its middle axis and turns over again and again, on its way through
 * space; its frame of reference stands off its centre of mass and its principal axes. */
static void check_free_body(const trial *is)
{
    test_rng rng = test_seed(3);
    const mbsr_frame home = test_frame(&rng, 2.0), at = test_frame(&rng, 0.7);
    const double w0[3] = {0.1, 2.0, 0.0}, v0[3] = {0.3, -0.2, 0.4};
    double com[3], omega[3] = {0.0}, arm[3], sweep[3];
    double x[12], q[7] = {0.0}, u[6];
    /* at: principal frame in the body; home: where it starts */
    const mbsr_frame back = mbsr_frame_inverse(&at), start = mbsr_frame_product(&home, &back);
    mbsr_model *m = run_model();
    const double tensor[6] = {principal[0], principal[1], principal[2], 0.0, 0.0, 0.0};
    memset(com, 0, sizeof com);
    run_body(m, "body", MBSR_GROUND, mbsr_joint_free(NULL, NULL),
             mbsr_inertia_in_frame(&at, mbsr_inertia_rigid(3.0, com, tensor)));
    run_finish(m);
    mbsr_rotation_quaternion(start.R, q);
    memcpy(q + 4, start.x, sizeof start.x);
    for (int k = 0; k < 3; ++k) {
        for (int l = 0; l < 3; ++l) omega[l] += home.R[3 * k + l] * w0[k];
        arm[k] = start.x[k] - home.x[k];
    }
    cross(omega, arm, sweep);
    for (int k = 0; k < 3; ++k) u[k] = omega[k], u[3 + k] = v0[k] + sweep[k];

    run_state state[MOST_POINTS + 1];
    observed o[MOST_POINTS + 1];
    run r = {.name = "free body",
             .model = m,
             .form = is->form,
             .tolerance = is->tolerance,
             .T = 20.0,
             .points = MOST_POINTS,
             .q = q,
             .u = u};
    observe_run(&r, state, o);
    memcpy(x, w0, sizeof w0);
    memcpy(x + 3, home.R, sizeof home.R);
    double error = 0.0, drift = 0.0;
    int turned = 0;
    for (int k = 0; k <= r.points; ++k) {
        if (k > 0) {
            const double before = x[1];
            runge_kutta(12, x, 20.0 / MOST_POINTS / 1000, 1000, free_slope);
            turned += before * x[1] < 0.0;
        }
        mbsr_frame now;
        memcpy(now.R, o[k].pose + MBSR_POSE_R, sizeof now.R);
        memcpy(now.x, o[k].pose + MBSR_POSE_X, sizeof now.x);
        now = mbsr_frame_product(&now, &at);
        for (int c = 0; c < 9; ++c) error = run_larger(error, fabs(now.R[c] - x[3 + c]));
        for (int c = 0; c < 3; ++c)
            error = run_larger(error, fabs(now.x[c] - home.x[c] - state[k].t * v0[c]));
        drift = run_larger(drift, fabs(o[k].energy / o[0].energy - 1.0));
        for (int c = 0; c < 6; ++c)
            drift = run_larger(drift, fabs(o[k].momentum[c] - o[0].momentum[c]));
    }
    run_report(&r, error);
    print_message("    energy and momentum to %.1e, %d times turned over\n", drift, turned);
    assert_in_range(turned, 2, 10);
    assert_less(error, is->error);
    assert_less(drift, is->drift);
    mbsr_model_destroy(m);
}

static void a_free_body_turns_over_as_euler_says(void **unused)
{
    (void)unused;
    static const trial trials[] = {
        {MBSR_DAE_MOMENTUM, 1e-6, 4e-2, 2e-2},  {MBSR_DAE_MOMENTUM, 1e-8, 3e-4, 1e-3},
        {MBSR_DAE_MOMENTUM, 1e-10, 6e-6, 4e-6}, {MBSR_DAE_MOMENTUM, 1e-12, 1e-7, 4e-8},
        {MBSR_DAE_RECURSIVE, 1e-8, 6e-5, 4e-5}, {MBSR_DAE_INVERSE_DYNAMICS, 1e-8, 6e-5, 2e-5},
        {MBSR_DAE_INDEX1, 1e-8, 2e-4, 1e-4}};
    for (size_t k = 0; k < sizeof trials / sizeof trials[0]; ++k) check_free_body(trials + k);
}

/* ---- a floating tree ------------------------------------------------------------------------- */

/* A free body that carries others on all kinds of joints with torsion springs. `light`: the joints
 * are damped, and four bodies have no mass or are a mass point: a leaf without mass, a mass point
 * on a link without mass between two spherical joints, of whose six rotations two move it, and a
 * link whose joint is regular nevertheless. */
static mbsr_model *floating_tree(int light, double *q, double *u)
{
    enum { BOX, POINT, NOTHING };
    static const struct {
        int kind, parent, light;
    } part[] = {{TEST_FREE, MBSR_GROUND, BOX}, {TEST_SPHERICAL, 0, NOTHING},
                {TEST_SPHERICAL, 1, POINT},    {TEST_UNIVERSAL, 0, NOTHING},
                {TEST_CYLINDRICAL, 3, BOX},    {TEST_COMPOUND, 4, NOTHING},
                {TEST_PRISMATIC, 0, BOX}};
    test_rng rng = test_seed(8);
    mbsr_model *m = run_model();
    for (int k = 0; k < 7; ++k) {
        const mbsr_frame at = test_frame(&rng, 0.3);
        const double edges[3] = {0.4, 0.5, 0.3};
        const mbsr_joint joint = test_joint_in_space(&rng, part[k].kind, 1.0);
        const mbsr_inertia inertia[] = {mbsr_inertia_in_frame(&at, mbsr_inertia_box(20.0, edges)),
                                        mbsr_inertia_point_mass(1.2, at.x), mbsr_inertia_zero()};
        run_body(m, NULL, part[k].parent, joint, inertia[light ? part[k].light : BOX]);
        if (k > 0) run_force(m, test_joint_law(k, 3.0, light ? 2.0 : 0.0));
    }
    run_finish(m);
    test_fill(&rng, mbsr_model_nq(m), q);
    test_fill(&rng, mbsr_model_nu(m), u);
    return m;
}

/* Linear and angular momentum stay, and without damping the energy, which damping lowers. The last
 * coordinates are compared with `known` ones (NULL: with none) and written to q_last. Returns by
 * how much what stays has drifted. */
static double run_floating_tree(int light, const trial *is, const double *known, double *q_last)
{
    double q[RUN_MOST], u[RUN_MOST], off[RUN_MOST] = {0.0};
    mbsr_model *m = floating_tree(light, q, u);
    run_state state[MOST_POINTS + 1];
    observed o[MOST_POINTS + 1];
    run r = {.name = light ? "floating tree with massless bodies" : "floating tree",
             .model = m,
             .form = is->form,
             .tolerance = is->tolerance,
             .T = 4.0,
             .points = 20,
             .q = q,
             .u = u};
    observe_run(&r, state, o);
    assert_int_equal(r.info.null_directions, light ? 6 : 0);
    assert_int_equal(r.info.elastic, 0);
    const double size = test_largest(6, o[0].momentum);
    double drift = 0.0;
    for (int k = 1; k <= r.points; ++k) {
        for (int c = 0; c < 6; ++c)
            drift = run_larger(drift, fabs(o[k].momentum[c] - o[0].momentum[c]) / size);
        if (light)
            assert_less(o[k].energy, o[k - 1].energy);
        else
            drift = run_larger(drift, fabs(o[k].energy / o[0].energy - 1.0));
    }
    const int nq = mbsr_model_nq(m);
    for (int k = 0; k < nq && known; ++k) off[k] = state[r.points].q[k] - known[k];
    memcpy(q_last, state[r.points].q, sizeof(double) * (size_t)nq);
    run_report(&r, test_largest(nq, off));
    print_message("    conserved to %.1e\n", drift);
    assert_less(test_largest(nq, off), is->error);
    mbsr_model_destroy(m);
    return drift;
}

static void a_floating_tree_keeps_its_momentum(void **unused)
{
    (void)unused;
    static const trial trials[2][7] = {{{MBSR_DAE_MOMENTUM, 1e-12, 1e-15, 3e-8},
                                        {MBSR_DAE_MOMENTUM, 1e-6, 8e-3, 2e-2},
                                        {MBSR_DAE_MOMENTUM, 1e-8, 4e-5, 5e-5},
                                        {MBSR_DAE_MOMENTUM, 1e-10, 2e-6, 2e-6},
                                        {MBSR_DAE_RECURSIVE, 1e-8, 1e-4, 3e-5},
                                        {MBSR_DAE_INVERSE_DYNAMICS, 1e-8, 5e-5, 1e-5},
                                        {MBSR_DAE_INDEX1, 1e-8, 3e-5, 3e-6}},
                                       {{MBSR_DAE_MOMENTUM, 1e-11, 1e-15, 3e-9},
                                        {MBSR_DAE_MOMENTUM, 1e-6, 4e-5, 5e-4},
                                        {MBSR_DAE_MOMENTUM, 1e-8, 6e-7, 4e-6},
                                        {MBSR_DAE_INDEX1, 1e-6, 1e-4, 2e-4},
                                        {MBSR_DAE_INDEX1, 1e-8, 3e-6, 2e-6},
                                        {MBSR_DAE_RECURSIVE, 1e-6, 2e-4, 4e-4},
                                        {MBSR_DAE_INVERSE_DYNAMICS, 1e-6, 1e-4, 2e-4}}};
    for (int light = 0; light < 2; ++light) {
        double known[RUN_MOST], q[RUN_MOST];
        for (int k = 0; k < 7; ++k) {
            /* the drift of one run at the smallest tolerance scatters by ten and more, with
             * rounding: the mean of many counts, as far as the limit is near */
            const int turns = k ? 1 : light ? 21 : 3;
            trial is = trials[light][k];
            double drift = run_floating_tree(light, &is, k ? known : NULL, k ? q : known);
            for (int turn = 1; turn < turns; ++turn) {
                is.tolerance = trials[light][k].tolerance * (1.0 + 0.005 * turn);
                drift += run_floating_tree(light, &is, NULL, q);
            }
            assert_less(drift / turns, trials[light][k].drift);
        }
    }
}

/* ---- flyball governor ------------------------------------------------------------------------ */

/* A shaft about the vertical with two arms on it, each a rod without mass with a ball at its end,
 * and a spring between the balls. Each hinge opens about an axis across the shaft and, on a
 * torsion spring, gives way sideways. `crosses`: the hinges are two revolute joints with a cross
 * without mass between them. Parameters of this test's own, SI units. */
typedef struct governor {
    double arm, ball,
        offset; /* length of an arm, mass of a ball, hinge from the axis of the shaft */
    double stiffness, free_length, sideways;
} governor;

static const governor governor_standard = {1.0, 5.0, 0.1, 400.0, 0.8, 500.0};

static mbsr_model *make_governor(const governor *g, int crosses, mbsr_joint shaft_joint)
{
    mbsr_model *m = run_model();
    const int shaft =
        run_body(m, "shaft", MBSR_GROUND, shaft_joint, mbsr_inertia_cylinder(7800.0, 0.15, 0.1));
    const double end[3] = {0.0, 0.0, -g->arm};
    int ball[2];
    for (int k = 0; k < 2; ++k) {
        /* turned by half a turn, so that opening is positive for both */
        const double place[3] = {k ? -g->offset : g->offset, 0.0, 0.0};
        const mbsr_frame hinge = mbsr_frame_rotated(place, e_z, k ? acos(-1.0) : 0.0);
        const mbsr_inertia inertia = mbsr_inertia_point_mass(g->ball, end);
        const double opening[3] = {0.0, -1.0, 0.0};
        if (crosses) {
            const int cross_id = run_body(
                m, "cross", shaft, mbsr_joint_revolute(&hinge, NULL, opening), mbsr_inertia_zero());
            ball[k] = run_body(m, "arm", cross_id, mbsr_joint_revolute(NULL, NULL, e_x), inertia);
        } else {
            ball[k] = run_body(m, "arm", shaft, mbsr_joint_universal(&hinge, NULL, opening, e_x),
                               inertia);
        }
        run_force(m, mbsr_force_joint_spring(ball[k], crosses ? 0 : 1, g->sideways, 0.0, 0.0));
    }
    run_force(
        m, mbsr_force_point_spring(ball[0], end, ball[1], end, g->stiffness, 0.0, g->free_length));
    run_force(m, mbsr_force_gravity(0.0, 0.0, -9.81));
    return run_finish(m);
}

/* States are shaft angle; opening and sideways of each arm, whichever the formulation. */
static const double governor_q[5] = {0.0, 0.5, 0.02, 0.6, 0.0};
static const double governor_u[5] = {9.0, 0.0, 0.3, 0.5, 0.0};

static void run_governor(int crosses, mbsr_dae_form form, double tolerance, double bound,
                         run_state *last)
{
    mbsr_model *m =
        make_governor(&governor_standard, crosses, mbsr_joint_revolute(NULL, NULL, e_z));
    run_state state[MOST_POINTS + 1];
    observed o[MOST_POINTS + 1];
    run r = {.name = crosses ? "governor with crosses" : "governor",
             .model = m,
             .form = form,
             .tolerance = tolerance,
             .T = 3.0,
             .points = 10,
             .q = governor_q,
             .u = governor_u};
    observe_run(&r, state, o);
    assert_int_equal(mbsr_model_bodies(m), crosses ? 5 : 3);
    double drift = 0.0;
    for (int k = 1; k <= r.points; ++k) {
        drift = run_larger(drift, fabs(o[k].energy / o[0].energy - 1.0));
        drift = run_larger(drift, fabs(o[k].momentum[2] / o[0].momentum[2] - 1.0));
    }
    *last = state[r.points];
    run_report(&r, drift);
    assert_less(drift, bound);
    mbsr_model_destroy(m);
}

static double apart(const run_state *a, const run_state *b)
{
    double distance = 0.0;
    for (int k = 0; k < 5; ++k) {
        distance = run_larger(distance, fabs(a->q[k] - b->q[k]));
        distance = run_larger(distance, fabs(a->u[k] - b->u[k]));
    }
    return distance;
}

static void the_governor_does_not_know_its_formulation(void **unused)
{
    (void)unused;
    run_state best, compound, crosses;
    run_governor(0, MBSR_DAE_MOMENTUM, 1e-13, 2e-10, &best);
    static const trial trials[] = {
        {MBSR_DAE_MOMENTUM, 1e-5, 0.2, 6e-4},   {MBSR_DAE_MOMENTUM, 1e-7, 2e-3, 2e-5},
        {MBSR_DAE_MOMENTUM, 1e-9, 4e-5, 4e-7},  {MBSR_DAE_MOMENTUM, 1e-11, 8e-7, 1e-8},
        {MBSR_DAE_RECURSIVE, 1e-9, 4e-5, 4e-7}, {MBSR_DAE_INVERSE_DYNAMICS, 1e-9, 4e-5, 4e-7},
        {MBSR_DAE_INDEX1, 1e-9, 4e-5, 4e-7}};
    for (size_t k = 0; k < sizeof trials / sizeof trials[0]; ++k) {
        const trial *is = trials + k;
        run_governor(0, is->form, is->tolerance, is->drift, &compound);
        run_governor(1, is->form, is->tolerance, is->drift, &crosses);
        const double error = run_larger(apart(&compound, &best), apart(&crosses, &best));
        print_message("    error %.1e, between the two %.1e\n", error, apart(&compound, &crosses));
        assert_less(error, is->error);
    }
}

/* Turned at a constant rate w the arms rest at the opening a with
 *
 *   m w^2 r l cos a = m g l sin a + k (2 r - l0) l cos a,   r = offset + l sin a */
static int constant_rate(void *user, double t, double *s, double *sdot, double *sddot)
{
    const double rate = *(const double *)user;
    *s = rate * t, *sdot = rate, *sddot = 0.0;
    return MBSR_OK;
}

static void the_driven_governor_rests_where_forces_balance(void **unused)
{
    (void)unused;
    governor g = governor_standard;
    const double opening = 0.7, r = g.offset + g.arm * sin(opening);
    double rate = 8.0;
    g.stiffness = g.ball * (rate * rate * r - 9.81 * tan(opening)) / (2.0 * r - g.free_length);
    assert_less(0.0, g.stiffness);
    const mbsr_axis axis = {.kind = MBSR_AXIS_ROTATION, .direction = {0.0, 0.0, 1.0}, .driven = 1};
    for (int crosses = 0; crosses < 2; ++crosses) {
        mbsr_model *m = make_governor(
            &g, crosses, mbsr_joint_compound(NULL, NULL, 1, &axis, constant_rate, &rate));
        mbsr_data *d = NULL;
        const double q[4] = {opening, 0.0, opening, 0.0}, u[4] = {0.0};
        double udot[4];
        assert_ok(mbsr_data_create(m, &d, NULL), NULL);
        assert_ok(mbsr_forward_dynamics(m, d, 0.4, q, u, NULL, udot), mbsr_data_error(d));
        for (int k = 0; k < 4; ++k) assert_close(udot[k], 0.0, 1e-12);
        mbsr_data_destroy(d);
        mbsr_model_destroy(m);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_pendulum_has_its_period),
        cmocka_unit_test(the_heavy_top_moves_as_its_angular_momentum_says),
        cmocka_unit_test(a_free_body_turns_over_as_euler_says),
        cmocka_unit_test(a_floating_tree_keeps_its_momentum),
        cmocka_unit_test(the_governor_does_not_know_its_formulation),
        cmocka_unit_test(the_driven_governor_rests_where_forces_balance),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
