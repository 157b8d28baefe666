/* Known kinks, jumps and sampled controls.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "problems.h"

#include <stdbool.h>

enum { FORMS = 4 };

static const mbsr_dae_form forms[FORMS] = {MBSR_DAE_MOMENTUM, MBSR_DAE_RECURSIVE,
                                           MBSR_DAE_INVERSE_DYNAMICS, MBSR_DAE_INDEX1};

/* Multiples of `period` at which something jumps in this derivative of q and p. */
typedef struct beat {
    double period;
    int derivative;
} beat;

static int next_beat(void *user, double t, int direction, mbsr_kink *next)
{
    const beat *b = user;
    double k = floor(t / b->period) + (direction > 0 ? 1.0 : 0.0);
    if (direction > 0 && k * b->period <= t) k += 1.0;
    if (direction < 0 && k * b->period >= t) k -= 1.0;
    next->t = k * b->period;
    next->derivative = b->derivative;
    return 0;
}

typedef struct run {
    mbsr_model *model;
    mbsr_data *data;
    mbsr_ida *ida;
    mbsr_dae_form form;
    double t, y[16], yp[16], q[4], u[4];
} run;

static void finish(run *r)
{
    assert_ok(mbsr_model_finish(r->model), mbsr_model_error(r->model));
    assert_ok(mbsr_data_create(r->model, &r->data, NULL), NULL);
    assert_in_range(mbsr_dae_size(r->model, MBSR_DAE_MOMENTUM), 1, 16);
}

/* At t from r->q, r->u. */
static void begin(run *r, double t, mbsr_ida_opt opt)
{
    mbsr_error error = {0};
    opt.form = r->form;
    mbsr_consistent_opt later = mbsr_default_consistent_opt();
    later.side = 1;
    r->t = t;
    assert_ok(mbsr_dae_pack(r->model, r->data, r->form, t, r->q, r->u, r->y),
              mbsr_data_error(r->data));
    assert_ok(mbsr_dae_consistent(r->model, r->data, r->form, t, r->y, r->yp, &later, NULL),
              mbsr_data_error(r->data));
    assert_ok(mbsr_ida_create(r->model, r->data, &opt, &r->ida, &error), &error);
    assert_ok(mbsr_ida_start(r->ida, t, r->y, r->yp), mbsr_ida_error(r->ida));
}

static void advance(run *r, double t, bool sample)
{
    assert_ok(sample ? mbsr_ida_sample(r->ida, t, &r->t, r->y, r->yp)
                     : mbsr_ida_advance(r->ida, t, &r->t, r->y, r->yp),
              mbsr_ida_error(r->ida));
    assert_true(r->t == t);
    assert_ok(mbsr_dae_unpack(r->model, r->data, r->form, t, r->y, r->q, r->u),
              mbsr_data_error(r->data));
}

static void end(run *r)
{
    mbsr_ida_destroy(r->ida);
    mbsr_data_destroy(r->data);
    mbsr_model_destroy(r->model);
}

static mbsr_ida_opt precise(double tolerance)
{
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.rtol = opt.atol = tolerance;
    return opt;
}

static void add_body(run *r, int parent, mbsr_joint joint, mbsr_inertia inertia)
{
    mbsr_body_def body = mbsr_default_body_def();
    body.parent = parent;
    body.joint = joint;
    body.inertia = inertia;
    assert_ok(mbsr_model_add_body(r->model, &body, NULL), mbsr_model_error(r->model));
}

static void add_force(run *r, mbsr_force_def force)
{
    assert_ok(mbsr_model_add_force(r->model, &force, NULL), mbsr_model_error(r->model));
}

/* ---- a force that jumps ---- */

static const double STIFFNESS = 18.0, DAMPING = 3.0;

/* +-6 N, by turns of 0.25 s, from 6 N in [0, 0.25) on. */
static int square_wave(void *user, double t, int n, double *value)
{
    (void)user;
    (void)n;
    value[0] = fmod(floor(t / 0.25), 2.0) == 0.0 ? 6.0 : -6.0;
    return 0;
}

/* A slider of this mass on a spring and a damper, under the square wave. */
static void slider(run *r, double mass)
{
    const double axis[3] = {1.0, 0.0, 0.0};
    assert_ok(mbsr_model_create(NULL, &r->model, NULL), NULL);
    add_body(r, MBSR_GROUND, mbsr_joint_prismatic(NULL, NULL, axis),
             mass > 0.0 ? mbsr_inertia_particle(mass) : mbsr_inertia_zero());
    add_force(r, mbsr_force_joint_spring(0, 0, STIFFNESS, DAMPING, 0.0));
    add_force(r, mbsr_force_joint_applied(0, square_wave, NULL));
    finish(r);
}

/* x, x' after s from x, x' under a constant force. */
static void slide(double mass, double force, double s, double *x, double *v)
{
    const double rest = force / STIFFNESS, e = *x - rest;
    if (mass == 0.0) {
        *x = rest + e * exp(-STIFFNESS / DAMPING * s);
        *v = -STIFFNESS / DAMPING * (*x - rest);
        return;
    }
    const double d = 0.5 * DAMPING / mass, w = sqrt(STIFFNESS / mass - d * d), B = (*v + d * e) / w,
                 C = cos(w * s), S = sin(w * s);
    *x = rest + exp(-d * s) * (e * C + B * S);
    *v = exp(-d * s) * ((B * w - d * e) * C - (e * w + d * B) * S);
}

/* Runs from 0 to 1.875 s (back: from 1.9375 s to 0.0625 s) and compares at the jumps and between;
 * the largest error. */
static double follow(mbsr_dae_form form, double mass, bool back, mbsr_ida_opt opt, long *steps)
{
    run r = {.form = form, .q = {0.1}, .u = {0.2}};
    beat jumps = {0.25, 1};
    double worst = 0.0;
    const double part = back ? -0.0625 : 0.0625;
    slider(&r, mass);
    opt.kink = next_beat;
    opt.kink_user = &jumps;
    begin(&r, back ? 1.9375 : 0.0, opt);
    double x = r.q[0], v = r.u[0];
    for (int k = 0; k < 30; ++k) {
        double force = 0.0;
        square_wave(NULL, r.t + 0.5 * part, 1, &force);
        slide(mass, force, part, &x, &v);
        advance(&r, r.t + part, false);
        worst = fmax(worst, fmax(fabs(r.q[0] - x), 0.1 * fabs(r.u[0] - v)));
    }
    mbsr_ida_stats stats;
    assert_ok(mbsr_ida_get_stats(r.ida, &stats), mbsr_ida_error(r.ida));
    *steps = stats.steps;
    end(&r);
    return worst;
}

/* With mass and without, in all forms; with mass both ways of time. */
static void forces_that_jump_cost_no_accuracy(void **state)
{
    (void)state;
    for (int f = 0; f < FORMS; ++f) {
        for (int k = 0; k < 3; ++k) {
            long steps = 0;
            const double mass = k < 2 ? 2.0 : 0.0;
            const double error = follow(forms[f], mass, k == 1, precise(1e-8), &steps);
            assert_less(error, 1e-6);
            assert_less((double)steps, 1400.0);
        }
    }
}

static void solvers_agree_behind_kinks(void **state)
{
    (void)state;
    const mbsr_ida_solver solver[] = {MBSR_IDA_DENSE, MBSR_IDA_TREE, MBSR_IDA_KRYLOV};
    for (int k = 0; k < 3; ++k) {
        for (int massless = 0; massless < 2; ++massless) {
            mbsr_ida_opt opt = precise(1e-8);
            long steps = 0;
            opt.linear_solver = solver[k];
            assert_less(follow(MBSR_DAE_MOMENTUM, massless ? 0.0 : 2.0, false, opt, &steps), 1e-6);
        }
    }
}

/* ---- a prescribed velocity that jumps ---- */

/* A pivot that goes to and fro at 1 m/s, turning at each 0.25 s. */
static int to_and_fro(void *user, double t, double *s, double *sdot, double *sddot)
{
    const double k = floor(t / 0.25), way = fmod(k, 2.0) == 0.0 ? 1.0 : -1.0;
    (void)user;
    *s = way > 0.0 ? t - 0.25 * k : 0.25 * (k + 1.0) - t;
    *sdot = way;
    *sddot = 0.0;
    return 0;
}

/* A point mass on a rod of 0.5 m, hung from the pivot, which feels a blow where the pivot turns: u
 * jumps by -(cos q) (jump of the pivot's velocity) / l. Between the blows it is a pendulum, of
 * which the energy as seen from the pivot is conserved. */
static void pivots_that_turn_strike(void **state)
{
    (void)state;
    const double y_axis[3] = {0.0, 1.0, 0.0}, tip[3] = {0.0, 0.0, -0.5};
    const mbsr_axis slide_x = {
        .kind = MBSR_AXIS_TRANSLATION, .direction = {1.0, 0.0, 0.0}, .driven = 1};
    for (int f = 0; f < FORMS; ++f) {
        run r = {.form = forms[f]};
        beat jumps = {0.25, 1};
        mbsr_ida_opt opt = precise(1e-9);
        opt.kink = next_beat;
        opt.kink_user = &jumps;
        assert_ok(mbsr_model_create(NULL, &r.model, NULL), NULL);
        add_body(&r, MBSR_GROUND, mbsr_joint_compound(NULL, NULL, 1, &slide_x, to_and_fro, NULL),
                 mbsr_inertia_particle(3.0));
        add_body(&r, 0, mbsr_joint_revolute(NULL, NULL, y_axis), mbsr_inertia_point_mass(2.0, tip));
        add_force(&r, mbsr_force_gravity(0.0, 0.0, -9.81));
        finish(&r);
        r.q[0] = 0.3;
        r.u[0] = -1.0;
        begin(&r, 0.0, opt);
        /* the tip is at x = -l sin q, its velocity relative to the pivot -l cos q u */
        double energy = 0.125 * r.u[0] * r.u[0] - 0.5 * 9.81 * cos(r.q[0]);
        for (int k = 1; k <= 6; ++k) {
            advance(&r, 0.25 * k, false);
            assert_close(0.125 * r.u[0] * r.u[0] - 0.5 * 9.81 * cos(r.q[0]), energy, 2e-7);
            const double jump = k % 2 ? -2.0 : 2.0, u = r.u[0] + cos(r.q[0]) * jump / 0.5;
            energy = 0.125 * u * u - 0.5 * 9.81 * cos(r.q[0]);
            advance(&r, 0.25 * k + 1e-7, false);
            assert_close(r.u[0], u, 1e-5);
        }
        end(&r);
    }
}

/* ---- sampled control ---- */

enum { SAMPLES = 150 };

static int torque(void *user, double t, int n, double *value)
{
    (void)t;
    (void)n;
    value[0] = *(const double *)user;
    return 0;
}

static void arm(run *r, double control[2])
{
    const double y_axis[3] = {0.0, 1.0, 0.0}, middle[3] = {0.0, 0.0, -0.25};
    assert_ok(mbsr_model_create(NULL, &r->model, NULL), NULL);
    for (int k = 0; k < 2; ++k) {
        mbsr_frame A = mbsr_frame_identity();
        A.x[2] = k ? -0.5 : 0.0;
        add_body(r, k - 1, mbsr_joint_revolute(&A, NULL, y_axis),
                 mbsr_inertia_point_mass(k ? 2.0 : 4.0, middle));
        add_force(r, mbsr_force_joint_applied(k, torque, control + k));
    }
    add_force(r, mbsr_force_gravity(0.0, 0.0, -9.81));
    finish(r);
}

/* 1 kHz. `anew`: by mbsr_ida_start at each sample. Writes q; returns the steps. */
static long control(double tolerance, bool anew, bool krylov, double q[2])
{
    double input[2] = {0.0, 0.0};
    run r = {.form = MBSR_DAE_MOMENTUM};
    mbsr_ida_opt opt = precise(tolerance);
    mbsr_ida_stats stats;
    long steps = 0;
    if (krylov) opt.linear_solver = MBSR_IDA_KRYLOV;
    arm(&r, input);
    begin(&r, 0.0, opt);
    for (int k = 0; k < SAMPLES; ++k) {
        for (int i = 0; i < 2; ++i)
            input[i] =
                (i ? 100.0 : 400.0) * (sin(3.0 * r.t + i) - r.q[i]) - (i ? 8.0 : 30.0) * r.u[i];
        if (anew) {
            assert_ok(mbsr_dae_consistent(r.model, r.data, r.form, r.t, r.y, r.yp, NULL, NULL),
                      mbsr_data_error(r.data));
            assert_ok(mbsr_ida_start(r.ida, r.t, r.y, r.yp), mbsr_ida_error(r.ida));
        }
        advance(&r, 1e-3 * (k + 1), !anew);
        mbsr_ida_get_stats(r.ida, &stats);
        steps = anew ? steps + stats.steps : stats.steps;
    }
    memcpy(q, r.q, 2 * sizeof *q);
    end(&r);
    return steps;
}

static void samples_take_few_steps(void **state)
{
    (void)state;
    double exact[2], restarted[2], q[2];
    control(1e-10, false, false, exact);
    const long before = control(1e-6, true, false, restarted);
    for (int k = 0; k < 2; ++k) {
        const long steps = control(1e-6, false, k == 1, q);
        assert_less(hypot(q[0] - exact[0], q[1] - exact[1]),
                    0.1 * hypot(restarted[0] - exact[0], restarted[1] - exact[1]));
        assert_less((double)steps, 2.5 * SAMPLES);
        assert_less((double)steps, 0.7 * (double)before);
    }
}

/* Where the driver integrates y - c, everything that it gives out is still y. */
static void dense_output_is_of_the_state(void **state)
{
    (void)state;
    double input[2] = {0.0, 0.0}, y[16], yp[16], dense[16];
    run r = {.form = MBSR_DAE_MOMENTUM};
    arm(&r, input);
    begin(&r, 0.0, precise(1e-8));
    const int size = mbsr_dae_size(r.model, r.form);
    for (int k = 0; k < 40; ++k) {
        for (int i = 0; i < 2; ++i) input[i] = sin(k + i);
        advance(&r, 1e-3 * (k + 1), true);
        assert_ok(mbsr_dae_consistent(r.model, r.data, r.form, r.t, memcpy(y, r.y, sizeof y), yp,
                                      NULL, NULL),
                  mbsr_data_error(r.data));
        for (int n = 0; n < 2; ++n) {
            assert_ok(mbsr_ida_dense(r.ida, r.t - 1e-15, n, dense), mbsr_ida_error(r.ida));
            for (int l = 0; l < (n ? 4 : size); ++l)
                assert_close(dense[l], n ? yp[l] : r.y[l], n ? 1e-4 : 1e-11);
        }
    }
    end(&r);
}

/* ---- smooth kinks, events, mbsr_ida_jump ---- */

typedef struct ends {
    int count, order;
    double t[4000];
} ends;

static int keep_end(void *user, const mbsr_ida_progress *now)
{
    ends *e = user;
    assert_in_range(e->count, 0, 3999);
    e->t[e->count++] = now->t;
    if (now->order > e->order) e->order = now->order;
    return 0;
}

/* Steps end there, the order stays. */
static void smooth_kinks_end_steps(void **state)
{
    (void)state;
    static ends found;
    run r = {.form = MBSR_DAE_MOMENTUM, .q = {1.0}};
    beat bends = {0.3, 3};
    mbsr_ida_opt opt = precise(1e-7);
    const double axis[3] = {1.0, 0.0, 0.0};
    assert_ok(mbsr_model_create(NULL, &r.model, NULL), NULL);
    add_body(&r, MBSR_GROUND, mbsr_joint_prismatic(NULL, NULL, axis), mbsr_inertia_particle(2.0));
    add_force(&r, mbsr_force_joint_spring(0, 0, 8.0, 0.0, 0.0));
    finish(&r);
    found = (ends){0};
    opt.kink = next_beat;
    opt.kink_user = &bends;
    opt.progress = keep_end;
    opt.progress_user = &found;
    begin(&r, 0.0, opt);
    advance(&r, 3.1, false);
    assert_close(r.q[0], cos(2.0 * 3.1), 1e-4);
    int met = 0, low = 0;
    for (int k = 0; k < found.count; ++k) {
        const double turns = found.t[k] / 0.3;
        met += fabs(turns - round(turns)) < 1e-12;
        low += found.t[k] > 0.3 && found.t[k] - 0.3 * floor(turns) < 1e-3;
    }
    assert_int_equal(met, 10);
    assert_int_equal(low, 0); /* no new beginning with small steps */
    assert_in_range(found.order, 3, 5);
    end(&r);
}

static int crossing(void *user, double t, const double *y, const double *yp, double *value)
{
    (void)t;
    (void)yp;
    *value = y[0] - *(const double *)user;
    return 0;
}

/* A slider that a force of 3 N pulls from rest until it is at 0.5 m, where the force is turned
 * round: it comes to rest at 1 m. The statistics go on. */
static void a_switch_at_an_event(void **state)
{
    (void)state;
    for (int f = 0; f < FORMS; ++f) {
        const double axis[3] = {1.0, 0.0, 0.0};
        double force = 3.0, place = 0.5;
        run r = {.form = forms[f]};
        mbsr_ida_opt opt = precise(1e-9);
        mbsr_ida_stats before, after;
        assert_ok(mbsr_model_create(NULL, &r.model, NULL), NULL);
        add_body(&r, MBSR_GROUND, mbsr_joint_prismatic(NULL, NULL, axis),
                 mbsr_inertia_particle(2.0));
        add_force(&r, mbsr_force_joint_applied(0, torque, &force));
        finish(&r);
        opt.events = 1;
        opt.event = crossing;
        opt.event_user = &place;
        begin(&r, 0.0, opt);
        assert_int_equal(mbsr_ida_advance(r.ida, 9.0, &r.t, r.y, r.yp), MBSR_EVENT);
        const double half = sqrt(2.0 * 0.5 * 2.0 / 3.0);
        assert_close(r.t, half, 1e-7);
        assert_ok(mbsr_ida_get_stats(r.ida, &before), mbsr_ida_error(r.ida));
        force = -3.0;
        assert_ok(mbsr_ida_jump(r.ida), mbsr_ida_error(r.ida));
        advance(&r, 2.0 * half, false);
        assert_close(r.q[0], 1.0, 1e-7);
        assert_close(r.u[0], 0.0, 1e-7);
        assert_ok(mbsr_ida_get_stats(r.ida, &after), mbsr_ida_error(r.ida));
        assert_true(after.steps > before.steps);
        assert_true(after.steps < 2 * before.steps + 40);
        end(&r);
    }
}

/* ---- closed loops ---- */

static int across(void *user, double t, int n, double *value)
{
    (void)user;
    (void)n;
    value[0] = fmod(floor(t / 0.25), 2.0) == 0.0 ? 2.0 : -2.0;
    return 0;
}

/* A pendulum under a torque that jumps. `looped`: half of its tip's mass stands on two sliders that
 * a ball joint ties to the tip. */
static void pendulum(run *r, bool looped)
{
    const double x_axis[3] = {1.0, 0.0, 0.0}, y_axis[3] = {0.0, 1.0, 0.0},
                 z_axis[3] = {0.0, 0.0, 1.0}, tip[3] = {0.0, 0.0, -1.0};
    assert_ok(mbsr_model_create(NULL, &r->model, NULL), NULL);
    add_body(r, MBSR_GROUND, mbsr_joint_revolute(NULL, NULL, y_axis),
             mbsr_inertia_point_mass(looped ? 0.5 : 1.0, tip));
    add_force(r, mbsr_force_gravity(0.0, 0.0, -9.81));
    add_force(r, mbsr_force_joint_applied(0, across, NULL));
    if (looped) {
        add_body(r, MBSR_GROUND, mbsr_joint_prismatic(NULL, NULL, x_axis), mbsr_inertia_zero());
        add_body(r, 1, mbsr_joint_prismatic(NULL, NULL, z_axis), mbsr_inertia_particle(0.5));
        const double plane[6] = {1.0, 0.0, 0.0, 0.0, 0.0, 1.0};
        const mbsr_closure_def pin = mbsr_closure_rows(2, NULL, 0, tip, 2, plane);
        assert_ok(mbsr_model_add_closure(r->model, &pin, NULL), mbsr_model_error(r->model));
        r->q[2] = -1.0;
    }
    finish(r);
}

static void loops_stay_closed_at_jumps(void **state)
{
    (void)state;
    beat jumps = {0.25, 1};
    run tree = {.form = MBSR_DAE_MOMENTUM}, loop = {.form = MBSR_DAE_MOMENTUM};
    mbsr_ida_opt opt = precise(1e-8);
    opt.kink = next_beat;
    opt.kink_user = &jumps;
    pendulum(&tree, false);
    pendulum(&loop, true);
    begin(&tree, 0.0, opt);
    begin(&loop, 0.0, opt);
    for (int k = 1; k <= 8; ++k) {
        advance(&tree, 0.2 * k, false);
        advance(&loop, 0.2 * k, false);
        assert_close(loop.q[0], tree.q[0], 1e-6);
        assert_close(loop.u[0], tree.u[0], 1e-6);
        assert_close(loop.q[1], -sin(tree.q[0]), 1e-6);
        assert_close(loop.q[2], -cos(tree.q[0]), 1e-6);
    }
    end(&tree);
    end(&loop);
}

/* ---- tables ---- */

enum { ROAD = 151 };

/* A quarter of a car without mass between tyre and spring on a road of points; steps and the place
 * of the body after 1.4 s. `known`: as a table, else as a function that reads it. */
static int hidden(void *user, double t, double *s, double *sdot, double *sddot)
{
    return mbsr_table_value(user, t, s, sdot, sddot);
}

static double drive(mbsr_table_kind kind, bool known, double tolerance, long *steps)
{
    static const double stiffness[3] = {2e5, 2e4, 1e6}, damping[3] = {50.0, 1500.0, 50.0};
    const double up[3] = {0.0, 0.0, 1.0};
    const mbsr_axis rise = {.kind = MBSR_AXIS_TRANSLATION, .direction = {0, 0, 1}, .driven = 1};
    double x[ROAD], v[ROAD] = {0.0};
    test_rng rng = test_seed(5);
    mbsr_table_def def = mbsr_default_table_def();
    mbsr_table *road = NULL;
    run r = {.form = MBSR_DAE_MOMENTUM};
    for (int k = 0; k < ROAD; ++k) {
        x[k] = 0.01 * k;
        if (k > 0) v[k] = 0.98 * v[k - 1] + 0.003 * test_uniform(&rng);
    }
    def.points = ROAD;
    def.x = x;
    def.value = v;
    def.kind = kind;
    assert_int_equal(mbsr_table_create(&def, &road, NULL), MBSR_OK);
    assert_ok(mbsr_model_create(NULL, &r.model, NULL), NULL);
    add_body(&r, MBSR_GROUND,
             mbsr_joint_compound(NULL, NULL, 1, &rise, known ? mbsr_table_motion : hidden, road),
             mbsr_inertia_zero());
    for (int i = 0; i < 3; ++i) {
        add_body(&r, i, mbsr_joint_prismatic(NULL, NULL, up),
                 i < 2 ? mbsr_inertia_zero() : mbsr_inertia_particle(400.0));
        add_force(&r, mbsr_force_joint_spring(i + 1, 0, stiffness[i], damping[i], 0.0));
    }
    finish(&r);
    begin(&r, 0.0, precise(tolerance));
    advance(&r, 1.4, false);
    mbsr_ida_stats stats;
    mbsr_ida_get_stats(r.ida, &stats);
    *steps = stats.steps;
    const double place = r.q[0] + r.q[1] + r.q[2];
    end(&r);
    mbsr_table_destroy(road);
    return place;
}

/* A carriage that follows a polyline, by its joint or by a closure: what swings on it gets the same
 * blows. */
static void closures_that_follow_tables_strike(void **state)
{
    (void)state;
    static const double x[4] = {-1.0, 1.0, 2.0, 3.0}, value[4] = {0.0, 0.4, -0.2, 0.1},
                        up[3] = {0.0, 0.0, 1.0}, across[3] = {0.0, 1.0, 0.0},
                        out[4] = {0.9, 1.0, 1.7, 2.4}, arm[3] = {0.3, 0.1, -0.2};
    const mbsr_axis axis = {MBSR_AXIS_TRANSLATION, {0.0, 0.0, 1.0}, 0.0, 1};
    mbsr_table_def def = mbsr_default_table_def();
    mbsr_table *table;
    double angle[4], rate[4];
    def.points = 4, def.x = x, def.value = value;
    assert_ok(mbsr_table_create(&def, &table, NULL), NULL);
    for (int closed = 0; closed < 2; ++closed) {
        run r = {.form = MBSR_DAE_MOMENTUM, .q = {0.2}};
        assert_ok(mbsr_model_create(NULL, &r.model, NULL), NULL);
        add_body(&r, MBSR_GROUND,
                 closed ? mbsr_joint_prismatic(NULL, NULL, up)
                        : mbsr_joint_compound(NULL, NULL, 1, &axis, mbsr_table_motion, table),
                 mbsr_inertia_particle(1.5));
        add_body(&r, 0, mbsr_joint_revolute(NULL, NULL, across), mbsr_inertia_point_mass(2.0, arm));
        add_force(&r, mbsr_force_joint_spring(1, 0, 30.0, 0.3, 0.1));
        mbsr_closure_def rows = mbsr_closure_rows(0, NULL, MBSR_GROUND, NULL, 1, up);
        rows.motion = mbsr_table_motion, rows.user = table;
        if (closed)
            assert_ok(mbsr_model_add_closure(r.model, &rows, NULL), mbsr_model_error(r.model));
        finish(&r);
        if (closed) r.q[0] = 0.25, r.q[1] = 0.2, r.u[0] = 0.2;
        begin(&r, 0.25, precise(1e-9));
        for (int k = 0; k < 4; ++k) {
            advance(&r, out[k], false);
            if (closed) {
                double s, speed, acceleration;
                assert_ok(mbsr_table_motion(table, out[k], &s, &speed, &acceleration), NULL);
                assert_close(r.q[0], s, 1e-7);
                assert_close(r.q[1], angle[k], 1e-6);
                assert_close(r.u[1], rate[k], 1e-6);
            }
            angle[k] = r.q[0], rate[k] = r.u[0];
        }
        end(&r);
    }
    mbsr_table_destroy(table);
}

static void roads_of_points_take_a_few_steps_a_point(void **state)
{
    (void)state;
    for (int kind = 0; kind < 3; ++kind) {
        long steps = 0, before = 0;
        const double blind = drive((mbsr_table_kind)kind, false, 1e-6, &before);
        const double found = drive((mbsr_table_kind)kind, true, kind == 0 ? 1e-4 : 1e-6, &steps);
        if (kind > 0) { /* smooth ones are left alone */
            assert_true(steps == before && found == blind);
            continue;
        }
        long most = 0;
        const double exact = drive((mbsr_table_kind)kind, true, 1e-9, &most);
        assert_true(steps < 6 * ROAD && steps < before / 2);
        assert_less(fabs(found - exact), 1e-4);
    }
}

/* ---- refusals ---- */

typedef struct odd {
    double t;
    int derivative, status;
} odd;

static int odd_kink(void *user, double t, int direction, mbsr_kink *next)
{
    const odd *o = user;
    assert_true(next->t == (direction > 0 ? INFINITY : -INFINITY));
    assert_int_equal(next->derivative, 1);
    assert_true(t == 0.0);
    next->t = o->t;
    next->derivative = o->derivative;
    return o->status;
}

static void kinks_that_make_no_sense_are_refused(void **state)
{
    (void)state;
    static const struct {
        odd kink;
        int status;
        const char *text;
    } wrong[] = {{{NAN, 1, 0}, MBSR_ERR_VALUE, "after t = 0 |at nan"},
                 {{-1.0, 1, 0}, MBSR_ERR_VALUE, "after t = 0 |at -1"},
                 {{0.0, 1, 0}, MBSR_ERR_VALUE, "after t = 0 |at 0"},
                 {{1.0, 0, 0}, MBSR_ERR_VALUE, "derivative 0"},
                 {{1.0, 1, 77}, 77, "function of kinks|returned 77"},
                 {{1.0, 1, -77}, -77, "function of kinks|returned -77"}};
    for (size_t k = 0; k < sizeof wrong / sizeof wrong[0]; ++k) {
        run r = {.form = MBSR_DAE_MOMENTUM};
        mbsr_ida_opt opt = precise(1e-6);
        odd o = wrong[k].kink;
        opt.kink = odd_kink;
        opt.kink_user = &o;
        slider(&r, 2.0);
        begin(&r, 0.0, opt);
        assert_refused(mbsr_ida_advance(r.ida, 0.1, NULL, NULL, NULL), mbsr_ida_error(r.ida),
                       wrong[k].status, MBSR_NONE, MBSR_NONE, wrong[k].text);
        o = (odd){INFINITY, 1, 0}; /* and then the run goes on */
        advance(&r, 0.1, false);
        end(&r);
    }
}

static void jumps_and_samples_want_a_run(void **state)
{
    (void)state;
    run r = {.form = MBSR_DAE_MOMENTUM};
    mbsr_ida *ida = NULL;
    slider(&r, 2.0);
    assert_ok(mbsr_ida_create(r.model, r.data, NULL, &ida, NULL), NULL);
    assert_int_equal(mbsr_ida_jump(NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_ida_sample(NULL, 0.0, NULL, NULL, NULL), MBSR_ERR_NULL);
    assert_refused(mbsr_ida_jump(ida), mbsr_ida_error(ida), MBSR_ERR_SEQUENCE, MBSR_NONE, MBSR_NONE,
                   "mbsr_ida_jump|mbsr_ida_start");
    assert_refused(mbsr_ida_sample(ida, 1.0, NULL, NULL, NULL), mbsr_ida_error(ida),
                   MBSR_ERR_SEQUENCE, MBSR_NONE, MBSR_NONE, "mbsr_ida_sample|mbsr_ida_start");
    assert_refused(mbsr_ida_sample(ida, NAN, NULL, NULL, NULL), mbsr_ida_error(ida), MBSR_ERR_VALUE,
                   MBSR_NONE, MBSR_NONE, "mbsr_ida_sample|t_end is nan");
    begin(&r, 0.0, precise(1e-6));
    advance(&r, 0.2, true);
    assert_refused(mbsr_ida_sample(r.ida, 0.1, NULL, NULL, NULL), mbsr_ida_error(r.ida),
                   MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE, "behind the present time");
    advance(&r, 0.25, true);
    mbsr_ida_destroy(ida);
    end(&r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(forces_that_jump_cost_no_accuracy),
        cmocka_unit_test(solvers_agree_behind_kinks),
        cmocka_unit_test(pivots_that_turn_strike),
        cmocka_unit_test(samples_take_few_steps),
        cmocka_unit_test(dense_output_is_of_the_state),
        cmocka_unit_test(smooth_kinks_end_steps),
        cmocka_unit_test(a_switch_at_an_event),
        cmocka_unit_test(loops_stay_closed_at_jumps),
        cmocka_unit_test(closures_that_follow_tables_strike),
        cmocka_unit_test(roads_of_points_take_a_few_steps_a_point),
        cmocka_unit_test(kinks_that_make_no_sense_are_refused),
        cmocka_unit_test(jumps_and_samples_want_a_run),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
