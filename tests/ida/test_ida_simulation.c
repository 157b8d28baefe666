/* Model, data and driver in one hand.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "counting.h"
#include "expect.h"

#include <mbsrank/simulation.h>
#include <mbsrank/driver.h>
#include <mbsrank/parameters.h>
#include <mbsrank/sensitivity.h>

static const double AXIS[3] = {0.0, 1.0, 0.0}, TIP[3] = {0.0, 0.0, -1.0};

static mbsr_simulation pendulum(void)
{
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    assert_int_equal(mbsr_simulation_add_body(&s, "rod", MBSR_GROUND,
                                              mbsr_joint_revolute(NULL, NULL, AXIS),
                                              mbsr_inertia_point_mass(1.0, TIP)),
                     0);
    assert_int_equal(mbsr_simulation_add_force(&s, mbsr_force_gravity(0.0, 0.0, -9.81)), 0);
    return s;
}

static void a_run_needs_one_look_at_the_end(void **state)
{
    (void)state;
    const double q = 0.5;
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.rtol = opt.atol = 1e-9;
    for (int form = 0; form < 4; ++form) {
        mbsr_simulation s = pendulum();
        opt.form = (mbsr_dae_form)form;
        mbsr_simulation_start(&s, &opt, 1.0, &q, NULL);
        assert_true(s.t == 1.0 && s.q[0] == 0.5 && s.u[0] == 0.0);
        for (int k = 1; k <= 10; ++k) mbsr_simulation_to(&s, 1.0 + 0.3 * k);
        assert_ok(s.status, &s.error);
        assert_close(s.t, 4.0, 1e-15);
        assert_close(0.5 * s.u[0] * s.u[0] - 9.81 * cos(s.q[0]), -9.81 * cos(0.5), 1e-6);
        double kinetic = 0.0, twist[6];
        assert_ok(mbsr_energy(s.model, s.data, &kinetic, NULL), mbsr_data_error(s.data));
        assert_close(kinetic, 0.5 * s.u[0] * s.u[0], 1e-12);
        assert_ok(mbsr_body_twist(s.model, s.data, 0, twist), mbsr_data_error(s.data));
        assert_true(twist[1] == s.u[0]);
        /* another run from where this one is */
        assert_int_equal(mbsr_simulation_start(&s, &opt, s.t, s.q, s.u), 0);
        mbsr_simulation_sample(&s, 4.5);
        assert_ok(s.status, &s.error);
        assert_close(0.5 * s.u[0] * s.u[0] - 9.81 * cos(s.q[0]), -9.81 * cos(0.5), 2e-6);
        mbsr_simulation_end(&s);
        assert_null(s.model);
    }
}

/* The index-1 form as it is interpolated has no accelerations; there is no fifth form. */
static void raw_outputs_have_no_accelerations(void **state)
{
    (void)state;
    const double q = 0.5;
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.form = MBSR_DAE_INDEX1;
    opt.rtol = opt.atol = 1e-9;
    opt.raw_outputs = 1;
    mbsr_simulation s = pendulum();
    mbsr_simulation_start(&s, &opt, 0.0, &q, NULL);
    assert_int_equal(mbsr_simulation_to(&s, 1.0), 0);
    assert_true(isnan(s.udot[0]));
    assert_close(0.5 * s.u[0] * s.u[0] - 9.81 * cos(s.q[0]), -9.81 * cos(0.5), 1e-6);
    mbsr_simulation_end(&s);
    s = pendulum();
    opt.form = (mbsr_dae_form)17;
    assert_int_equal(mbsr_simulation_start(&s, &opt, 0.0, &q, NULL), MBSR_ERR_VALUE);
    assert_contains(s.error.text, "no such form");
    mbsr_simulation_end(&s);
}

static void zero_stands_for_no_coordinates(void **state)
{
    (void)state;
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    mbsr_simulation_add_body(&s, NULL, MBSR_GROUND, mbsr_joint_prismatic(NULL, NULL, AXIS),
                             mbsr_inertia_particle(1.0));
    mbsr_simulation_add_body(&s, NULL, 0, mbsr_joint_spherical(NULL, NULL),
                             mbsr_inertia_sphere(1.0, 1.0));
    mbsr_simulation_start(&s, NULL, 0.0, NULL, NULL);
    assert_ok(s.status, &s.error);
    assert_true(s.q[0] == 0.0 && s.q[1] == 1.0 && s.q[2] == 0.0);
    assert_int_equal(mbsr_simulation_to(&s, 1.0), 0);
    assert_close(s.q[1], 1.0, 1e-12);
    mbsr_simulation_end(&s);
}

static void the_first_failure_stays(void **state)
{
    (void)state;
    mbsr_simulation s = pendulum();
    assert_int_equal(mbsr_simulation_to(&s, 1.0), MBSR_ERR_SEQUENCE);
    assert_contains(s.error.text, "mbsr_simulation_to|mbsr_simulation_start");
    assert_int_equal(mbsr_simulation_start(&s, NULL, 0.0, NULL, NULL), MBSR_ERR_SEQUENCE);
    mbsr_simulation_forgive(&s);
    assert_int_equal(mbsr_simulation_add_force(&s, mbsr_force_joint_spring(0, 3, 1.0, 0.0, 0.0)),
                     1);
    assert_int_equal(mbsr_simulation_start(&s, NULL, 0.0, NULL, NULL), MBSR_ERR_VALUE);
    assert_contains(s.error.text, "coordinate is 3");
    assert_int_equal(s.error.force, 1);
    double udot;
    assert_int_equal(mbsr_simulation_accelerations(&s, &udot), MBSR_ERR_VALUE);
    assert_int_equal(mbsr_simulation_reactions(&s, &udot), MBSR_ERR_VALUE);
    assert_contains(s.error.text, "coordinate is 3");
    assert_int_equal(
        mbsr_simulation_add_body(&s, NULL, 0, mbsr_joint_weld(NULL, NULL), mbsr_inertia_zero()),
        MBSR_NONE);
    assert_int_equal(mbsr_simulation_add_force(&s, mbsr_force_gravity(0, 0, 1)), MBSR_NONE);
    assert_int_equal(s.status, MBSR_ERR_VALUE);
    mbsr_simulation_end(&s);

    s = mbsr_simulation_of(NULL);
    assert_int_equal(s.status, MBSR_ERR_NULL);
    mbsr_simulation_forgive(&s);
    assert_int_equal(mbsr_simulation_start(&s, NULL, 0.0, NULL, NULL), MBSR_ERR_NULL);
    mbsr_simulation_end(&s);
    mbsr_simulation_end(NULL);
    assert_int_equal(mbsr_simulation_to(NULL, 0.0), MBSR_ERR_NULL);
}

/* A crank of 0.3 m whose rod, without mass, moves a slider: its rate and position are given, the
 * rest follows. */
static void a_crank_turns_as_told(void **state)
{
    (void)state;
    static const double y_axis[3] = {0, 1, 0}, x_axis[3] = {1, 0, 0}, o[3] = {0, 0, 0},
                        end[3] = {1.0, 0.0, 0.0};
    const mbsr_frame tip = mbsr_frame_rotated((double[3]){0.3, 0, 0}, y_axis, 0.0);
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    const int crank = mbsr_simulation_add_body(
                  &s, "crank", MBSR_GROUND, mbsr_joint_revolute(NULL, NULL, y_axis),
                  mbsr_inertia_point_mass(2.0, (double[3]){0.1, 0, 0.1})),
              rod = mbsr_simulation_add_body(
                  &s, "rod", crank, mbsr_joint_revolute(&tip, NULL, y_axis), mbsr_inertia_zero()),
              slider = mbsr_simulation_add_body(&s, "slider", MBSR_GROUND,
                                                mbsr_joint_prismatic(NULL, NULL, x_axis),
                                                mbsr_inertia_point_mass(1.0, o));
    static const double guess[3] = {0.0, -1.0, 1.0};
    mbsr_closure_def pin = mbsr_closure_ball(rod, end, slider, o);
    pin.name = "pin";
    mbsr_simulation_add_closure(&s, pin);
    mbsr_simulation_set_position(&s, crank, 0, 0.7);
    mbsr_simulation_set_rate(&s, crank, 0, 50.0);
    mbsr_simulation_set_rate(&s, crank, 0, 100.0);
    mbsr_simulation_start(&s, NULL, 0.0, guess, NULL);
    const double lean = asin(0.3 * sin(0.7));
    assert_ok(s.status, &s.error);
    assert_true(s.q[0] == 0.7 && s.u[0] == 100.0);
    assert_close(s.u[2], -30.0 * (sin(0.7) + cos(0.7) * tan(lean)), 1e-9);
    mbsr_simulation_to(&s, 0.001);
    assert_ok(s.status, &s.error);
    assert_close(s.q[0], 0.8, 5e-3);

    mbsr_simulation_set_rate(&s, slider, 0, 5.0);
    assert_int_equal(mbsr_simulation_start(&s, NULL, 0.0, guess, NULL), MBSR_LOOP_OPEN);
    assert_contains(s.error.text, "cannot keep|closure 0 'pin'");
    mbsr_simulation_forgive(&s);
    mbsr_simulation_set_none(&s);
    mbsr_simulation_set_rate(&s, slider, 1, 5.0);
    assert_int_equal(mbsr_simulation_start(&s, NULL, 0.0, guess, NULL), MBSR_ERR_VALUE);
    assert_contains(s.error.text, "mbsr_simulation_set_rate: coordinate is 1|'slider' has 1");
    mbsr_simulation_forgive(&s);
    mbsr_simulation_set_none(&s);
    mbsr_simulation_set_position(&s, 7, 0, 5.0);
    assert_int_equal(mbsr_simulation_start(&s, NULL, 0.0, guess, NULL), MBSR_ERR_ID);
    assert_contains(s.error.text, "mbsr_simulation_set_position: there is no body 7");
    mbsr_simulation_forgive(&s);
    mbsr_simulation_set_none(&s);
    mbsr_simulation_set_rate(&s, slider, 0, NAN);
    assert_int_equal(mbsr_simulation_start(&s, NULL, 0.0, guess, NULL), MBSR_ERR_VALUE);
    mbsr_simulation_end(&s);
}

/* Numbers of a quaternion, one by one: it is made one of length 1. */
static void a_ball_joint_is_turned_as_told(void **state)
{
    (void)state;
    const double tensor[6] = {0.1, 0.2, 0.3, 0.0, 0.0, 0.0};
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    const int body =
        mbsr_simulation_add_body(&s, "top", MBSR_GROUND, mbsr_joint_spherical(NULL, NULL),
                                 mbsr_inertia_rigid(1.0, TIP, tensor));
    mbsr_simulation_set_position(&s, body, 0, 3.0);
    mbsr_simulation_set_position(&s, body, 2, 4.0);
    mbsr_simulation_start(&s, NULL, 0.0, NULL, NULL);
    assert_ok(s.status, &s.error);
    const double turned[4] = {0.6, 0.0, 0.8, 0.0};
    for (int k = 0; k < 4; ++k) assert_close(s.q[k], turned[k], 1e-15);
    mbsr_simulation_end(&s);
}

/* A force that ends at 0.5 s: the state is the last good one. */
static int ends(void *user, double t, int n, double *value)
{
    (void)user;
    (void)n;
    value[0] = 0.1;
    return t > 0.5 ? -77 : 0;
}

static int crossing(void *user, double t, const double *y, const double *yp, double *value)
{
    (void)user;
    (void)t;
    (void)yp;
    *value = y[0] - 0.002;
    return 0;
}

static void events_pass_and_failures_keep_the_last_state(void **state)
{
    (void)state;
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    mbsr_simulation s = pendulum();
    opt.events = 1;
    opt.event = crossing;
    mbsr_simulation_add_force(&s, mbsr_force_joint_applied(0, ends, NULL));
    mbsr_simulation_start(&s, &opt, 0.0, NULL, NULL);
    assert_int_equal(mbsr_simulation_to(&s, 2.0), MBSR_EVENT);
    assert_int_equal(s.status, 0);
    assert_close(s.q[0], 0.002, 1e-9);
    assert_int_equal(mbsr_simulation_to(&s, 2.0), -77);
    assert_int_equal(s.status, -77);
    assert_true(s.t > 0.3 && s.t <= 0.5);
    assert_close(s.q[0], 0.1 / 9.81 * (1.0 - cos(sqrt(9.81) * s.t)), 1e-4);
    mbsr_simulation_end(&s);
}

/* A force that fails from 0.5 s on, until its cause is dealt with. */
typedef struct fragile {
    int broken;
} fragile;

static int breaks(void *user, double t, int n, double *value)
{
    const fragile *f = user;
    for (int k = 0; k < n; ++k) value[k] = 0.1;
    return f->broken && t >= 0.5 ? -77 : 0;
}

static int kinks(void *user, double t, int direction, mbsr_kink *next)
{
    (void)user;
    *next = (mbsr_kink){direction * (double)INFINITY, 1};
    for (int k = 1; k <= 3; ++k) { /* 0.25, 0.5, 0.75 */
        const int at = direction > 0 ? k : 4 - k;
        if (direction * (0.25 * at - t) <= 0.0) continue;
        next->t = 0.25 * at;
        break;
    }
    return 0;
}

/* In all forms, in the middle of steps or where one has ended at a kink: the last good state is
 * there with its statistics, fits the solution, and a new start goes on from it. */
static void runs_go_on_from_the_last_good_state(void **state)
{
    (void)state;
    const double rate = sqrt(9.81), offset = 0.1 / 9.81;
    for (int form = 0; form < 4; ++form) {
        for (int way = 0; way < 3; ++way) {
            fragile f = {1};
            mbsr_ida_opt opt = mbsr_default_ida_opt();
            mbsr_ida_stats stats;
            double t = 0.0, y[3], yp[3];
            mbsr_simulation s = pendulum();
            opt.form = (mbsr_dae_form)form;
            opt.rtol = opt.atol = 1e-8;
            if (way > 0) opt.kink = kinks;
            mbsr_simulation_add_force(&s, mbsr_force_joint_applied(0, breaks, &f));
            mbsr_simulation_start(&s, &opt, 0.0, NULL, NULL);
            if (way == 2) mbsr_simulation_sample(&s, 0.4);
            assert_ok(s.status, &s.error);
            assert_int_equal(mbsr_simulation_to(&s, 2.0), -77);
            assert_int_equal(mbsr_simulation_to(&s, 2.0), -77);
            assert_int_equal(s.error.status, -77);
            assert_true(s.t > (way ? 0.24 : 0.2) && s.t <= 0.5);
            assert_close(s.q[0], offset * (1.0 - cos(rate * s.t)), 1e-6);
            assert_close(s.u[0], offset * rate * sin(rate * s.t), 2e-6);
            assert_int_equal(mbsr_ida_state(s.ida, &t, y, yp), 0);
            const size_t size = (size_t)mbsr_dae_size(s.model, s.form) * sizeof *y;
            assert_true(t == s.t && size <= sizeof y);
            assert_memory_equal(y, s.y, size);
            assert_memory_equal(yp, s.yp, size);
            assert_int_equal(mbsr_ida_get_stats(s.ida, &stats), 0);
            assert_true(stats.steps > 0);
            /* again without a remedy, and then with one */
            mbsr_simulation_forgive(&s);
            if (mbsr_simulation_start(&s, &opt, s.t, s.q, s.u) == 0) mbsr_simulation_to(&s, 2.0);
            assert_int_equal(s.status, -77);
            assert_true(s.t >= t && s.t <= 0.5);
            f.broken = 0;
            mbsr_simulation_forgive(&s);
            mbsr_simulation_start(&s, &opt, s.t, s.q, s.u);
            mbsr_simulation_to(&s, 2.0);
            assert_ok(s.status, &s.error);
            assert_close(s.q[0], offset * (1.0 - cos(rate * 2.0)), 2e-6);
            mbsr_simulation_end(&s);
        }
    }
}

/* A heavy body, a body without mass on it, and a light one on that. */
static void momenta_have_the_masses_of_their_joints(void **state)
{
    (void)state;
    const double mass[3] = {5.0, 0.0, 0.25};
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    for (int k = 0; k < 3; ++k) {
        mbsr_simulation_add_body(&s, NULL, k - 1, mbsr_joint_translational(NULL, NULL),
                                 mbsr_inertia_particle(mass[k]));
        for (int c = 0; c < 3; ++c)
            mbsr_simulation_add_force(&s, mbsr_force_joint_spring(k, c, 1.0, 1.0, 0.0));
    }
    mbsr_simulation_start(&s, NULL, 0.0, NULL, NULL);
    assert_ok(s.status, &s.error);
    double scale[9];
    assert_int_equal(mbsr_momentum_scales(s.model, s.data, NULL), MBSR_ERR_NULL);
    assert_ok(mbsr_stage_forces(s.model, s.data, NULL), mbsr_data_error(s.data));
    assert_ok(mbsr_stage_backward(s.model, s.data), mbsr_data_error(s.data));
    assert_ok(mbsr_momentum_scales(s.model, s.data, scale), mbsr_data_error(s.data));
    for (int k = 0; k < 3; ++k) {
        mbsr_rank_info info;
        assert_ok(mbsr_body_rank(s.model, s.data, k, &info), mbsr_data_error(s.data));
        assert_true(info.scale > 0.0 || k == 1);
        for (int c = 0; c < 3; ++c)
            assert_true(scale[3 * k + c] == (info.scale > 0.0 ? info.scale : scale[0]));
    }
    assert_true(scale[0] >= 5.0 && scale[0] <= 5.5 && scale[6] >= 0.25 && scale[6] < 1.0);
    mbsr_simulation_end(&s);
}

/* A pendulum as a particle at a distance from the origin. */
static void closed_loops_run_too(void **state)
{
    (void)state;
    const double q[3] = {0.6, 0.0, -0.8}, origin[3] = {0.0, 0.0, 0.0};
    double u[3] = {0.0};
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.rtol = opt.atol = 1e-9;
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    const int body =
        mbsr_simulation_add_body(&s, "particle", MBSR_GROUND, mbsr_joint_translational(NULL, NULL),
                                 mbsr_inertia_particle(2.0));
    mbsr_simulation_add_force(&s, mbsr_force_gravity(0.0, 0.0, -9.81));
    assert_int_equal(mbsr_simulation_add_closure(
                         &s, mbsr_closure_distance(body, NULL, MBSR_GROUND, origin, 1.0)),
                     0);
    for (int run = 0; run < 2; ++run) {
        mbsr_simulation_start(&s, &opt, 0.0, q, u);
        mbsr_simulation_to(&s, 1.0);
        assert_ok(s.status, &s.error);
        assert_close(hypot(s.q[0], s.q[2]), 1.0, 1e-7);
        assert_close(0.5 * (s.u[0] * s.u[0] + s.u[2] * s.u[2]) + 9.81 * s.q[2], -9.81 * 0.8, 1e-6);
    }
    mbsr_simulation_end(&s);
}

/* A slider that a table pushes and a table moves; both go with the simulation. */
static void tables_belong_to_the_simulation(void **state)
{
    (void)state;
    const double t[3] = {0.0, 1.0, 2.0}, f[3] = {0.0, 3.0, 3.0}, bad[3] = {0.0, 1.0, 1.0};
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.rtol = opt.atol = 1e-8;
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    mbsr_table *push = mbsr_simulation_add_table(&s, MBSR_TABLE_LINEAR, 3, t, f);
    for (int k = 0; k < 5; ++k)
        assert_non_null(mbsr_simulation_add_table(&s, MBSR_TABLE_SPLINE, 2 + k % 2, t, f));
    mbsr_simulation_add_body(&s, NULL, MBSR_GROUND, mbsr_joint_prismatic(NULL, NULL, AXIS),
                             mbsr_inertia_particle(2.0));
    mbsr_simulation_add_force(&s, mbsr_force_joint_applied(0, mbsr_table_force, push));
    mbsr_ida_stats stats;
    mbsr_simulation_get_stats(&s, &stats);
    assert_true(stats.steps == 0);
    mbsr_simulation_start(&s, &opt, 0.0, NULL, NULL);
    mbsr_simulation_to(&s, 2.0);
    assert_ok(s.status, &s.error);
    assert_close(s.u[0], 1.5 * (0.5 + 1.0), 1e-6);
    mbsr_simulation_get_stats(&s, &stats);
    assert_true(stats.steps > 0);
    assert_null(mbsr_simulation_add_table(&s, MBSR_TABLE_LINEAR, 3, bad, f));
    assert_int_equal(s.status, MBSR_ERR_VALUE);
    assert_contains(s.error.text, "x[2] is 1, not above x[1], which is 1");
    assert_null(mbsr_simulation_add_table(&s, MBSR_TABLE_LINEAR, 3, t, f));
    mbsr_simulation_end(&s);
    assert_null(s.parts);
    assert_null(mbsr_simulation_add_table(NULL, MBSR_TABLE_LINEAR, 3, t, f));
    mbsr_simulation_get_stats(NULL, &stats);
    assert_true(stats.steps == 0);
}

/* With a force switched off in them inverse dynamics is that of the model without it. */
static void data_belong_to_the_simulation(void **state)
{
    (void)state;
    const double q = 0.4, zero = 0.0;
    double tau = 0.0;
    mbsr_simulation s = pendulum();
    const int spring = mbsr_simulation_add_force(&s, mbsr_force_joint_spring(0, 0, 50.0, 1.0, 0.0));
    mbsr_data *bare = mbsr_simulation_add_data(&s), *other = mbsr_simulation_add_data(&s);
    assert_ok(s.status, &s.error);
    assert_non_null(bare);
    assert_true(other && other != bare && mbsr_model_bodies(s.model) == 1);
    assert_ok(mbsr_force_switch(s.model, bare, spring, 0), mbsr_data_error(bare));
    mbsr_simulation_start(&s, NULL, 0.0, &q, NULL);
    assert_true(s.data != bare && s.data != other);
    assert_ok(mbsr_inverse_dynamics(s.model, bare, 0.0, &q, &zero, &zero, NULL, &tau),
              mbsr_data_error(bare));
    assert_close(fabs(tau), 9.81 * sin(0.4), 1e-12);
    const double weight = tau;
    assert_ok(mbsr_inverse_dynamics(s.model, other, 0.0, &q, &zero, &zero, NULL, &tau),
              mbsr_data_error(other));
    assert_close(tau - weight, 50.0 * 0.4, 1e-12);
    mbsr_simulation_end(&s);
    s = mbsr_simulation_begin(NULL);
    mbsr_simulation_add_force(&s, mbsr_force_joint_spring(0, 0, 1.0, 0.0, 0.0));
    assert_null(mbsr_simulation_add_data(&s));
    assert_true(s.status != MBSR_OK && s.error.text[0]);
    assert_null(mbsr_simulation_add_data(&s));
    assert_null(mbsr_simulation_add_data(NULL));
    mbsr_simulation_end(&s);
}

static void calls_with_its_data_may_fail_too(void **state)
{
    (void)state;
    double pose[MBSR_POSE_SIZE];
    mbsr_simulation s = pendulum();
    assert_int_equal(mbsr_simulation_check(&s, mbsr_model_lock(s.model, 3, 0, 0.0)), MBSR_ERR_ID);
    assert_contains(s.error.text, "3");
    mbsr_simulation_forgive(&s);
    mbsr_simulation_start(&s, NULL, 0.0, NULL, NULL);
    assert_int_equal(mbsr_simulation_check(&s, mbsr_body_pose(s.model, s.data, 0, pose)), 0);
    assert_int_equal(mbsr_simulation_check(&s, mbsr_body_pose(s.model, s.data, 5, pose)),
                     MBSR_ERR_ID);
    assert_contains(s.error.text, "5");
    assert_int_equal(mbsr_simulation_check(&s, MBSR_OK), MBSR_ERR_ID);
    assert_int_equal(mbsr_simulation_to(&s, 1.0), MBSR_ERR_ID);
    mbsr_simulation_end(&s);
    assert_int_equal(mbsr_simulation_check(NULL, MBSR_OK), MBSR_ERR_NULL);
}

static void functions_read_what_the_struct_has(void **state)
{
    (void)state;
    mbsr_simulation s = pendulum();
    assert_null(mbsr_simulation_q(&s));
    assert_true(mbsr_simulation_model(&s) == s.model);
    mbsr_simulation_start(&s, NULL, 0.0, NULL, NULL);
    mbsr_simulation_to(&s, 0.5);
    assert_true(mbsr_simulation_time(&s) == 0.5);
    assert_true(mbsr_simulation_q(&s) == s.q && mbsr_simulation_u(&s) == s.u && s.q);
    assert_true(mbsr_simulation_data(&s) == s.data && mbsr_simulation_ida(&s) == s.ida);
    assert_int_equal(mbsr_simulation_status(&s), MBSR_OK);
    mbsr_simulation_check(&s, mbsr_body_pose(s.model, s.data, 5, s.y));
    assert_int_equal(mbsr_simulation_status(&s), MBSR_ERR_ID);
    assert_contains(mbsr_simulation_error(&s)->text, "5");
    mbsr_simulation_end(&s);
    assert_true(isnan(mbsr_simulation_time(NULL)));
    assert_true(!mbsr_simulation_q(NULL) && !mbsr_simulation_u(NULL));
    assert_true(!mbsr_simulation_model(NULL) && !mbsr_simulation_data(NULL));
    assert_null(mbsr_simulation_ida(NULL));
    assert_int_equal(mbsr_simulation_status(NULL), MBSR_ERR_NULL);
    assert_contains(mbsr_simulation_error(NULL)->text, "NULL");
}

/* m x'' = f_k in the k-th period. */
static void held_forces_change_between_samples(void **state)
{
    (void)state;
    double held = 1.0, x = 0.0, v = 0.0;
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    mbsr_simulation_add_body(&s, NULL, MBSR_GROUND, mbsr_joint_prismatic(NULL, NULL, AXIS),
                             mbsr_inertia_particle(2.0));
    mbsr_simulation_add_force(&s, mbsr_force_joint_applied(0, mbsr_stored_force, &held));
    mbsr_simulation_start(&s, NULL, 0.0, NULL, NULL);
    for (int k = 1; k <= 8; ++k) {
        held = k % 2 ? 2.0 * k : -3.0;
        x += 0.25 * v + 0.5 * 0.0625 * held / 2.0;
        v += 0.25 * held / 2.0;
        mbsr_simulation_sample(&s, 0.25 * k);
        assert_ok(s.status, &s.error);
        assert_close(s.q[0], x, 1e-10);
        assert_close(s.u[0], v, 1e-10);
    }
    mbsr_simulation_end(&s);
}

/* ---- memory ---- */

/* Three links, the second without mass or the end held to a circle; a spring that is stiff. */
typedef struct linkage {
    int massless, closed, stiff;
} linkage;

/* From the call `says_at` on a spring's law says `with`; 0: never. */
static long asked, says_at;
static int with;

static int law(void *user, double x, double v, double *force, double *energy, double *power)
{
    (void)user;
    *force = 5.0 * (x - 0.3) + 0.1 * v;
    if (energy) *energy = 2.5 * (x - 0.3) * (x - 0.3);
    if (power) *power = 0.1 * v * v;
    return ++asked >= says_at && says_at > 0 ? with : 0;
}

static int build(mbsr_simulation *s, const linkage *l, test_counting *counting)
{
    static const mbsr_spring own = {.function = law};
    static const double end[3] = {1.0, 0.0, 0.0}, there[3] = {1.0, 1.0, 0.0}, com[2] = {0.5, 0.0};
    mbsr_model_def def = mbsr_default_model_def();
    int body = MBSR_GROUND;
    def.allocator = test_counting_allocator(counting);
    *s = mbsr_simulation_begin(&def);
    for (int k = 0; k < 3; ++k) {
        const mbsr_planar_frame at = {k > 0 ? 1.0 : 0.0, 0.0, 0.0}, origin = {0.0, 0.0, 0.0};
        body = mbsr_simulation_add_body(s, NULL, body, mbsr_joint_planar_revolute(at, origin),
                                        k == 1 && l->massless ? mbsr_inertia_zero()
                                                              : mbsr_inertia_planar(1, com, 0.1));
    }
    mbsr_simulation_add_force(s, mbsr_force_gravity(0.0, -9.81, 0.0));
    mbsr_simulation_add_force(s, mbsr_force_joint_spring(1, 0, 10.0, 1.0, 0.0));
    mbsr_simulation_add_force(s, mbsr_force_spring(MBSR_GROUND, there, 2, end, &own));
    if (l->stiff) {
        mbsr_force_def spring = mbsr_force_joint_spring(2, 0, 1e7, 0.0, 0.0);
        spring.as_closure = MBSR_SPRING_SETTLED;
        mbsr_simulation_add_force(s, spring);
    }
    if (l->closed)
        mbsr_simulation_add_closure(s, mbsr_closure_distance(2, end, MBSR_GROUND, there, 1.0));
    return s->status;
}

static int runs(const linkage *l, test_counting *counting)
{
    double lambda[8];
    mbsr_simulation s;
    if (!build(&s, l, counting)) mbsr_simulation_start(&s, NULL, 0.0, NULL, NULL);
    if (!s.status) mbsr_simulation_to(&s, 0.02);
    const int status = s.status ? s.status : mbsr_simulation_reactions(&s, lambda);
    mbsr_simulation_end(&s);
    return status;
}

static int differentiates(const linkage *l, test_counting *counting)
{
    static const int which = 0;
    static const double time = 0.02, w[3] = {1.0, 0.5, 0.2};
    double q[3], u[3], by;
    mbsr_simulation s;
    mbsr_parameters *list = NULL;
    mbsr_sensitivity *sensitivity = NULL;
    mbsr_sensitivity_opt opt = mbsr_default_sensitivity_opt();
    int status = build(&s, l, counting);
    if (!status) status = mbsr_model_finish(s.model);
    if (!status) status = mbsr_parameters_create(s.model, &list, NULL);
    opt.list = list;
    opt.parameters = 1;
    opt.which = &which;
    if (!status) status = mbsr_sensitivity_create(s.model, &opt, &sensitivity, NULL);
    if (!status) status = mbsr_sensitivity_run(sensitivity, 0.0, NULL, NULL, 1, &time, q, u);
    if (!status) status = mbsr_sensitivity_forward(sensitivity, q, u);
    if (!status) status = mbsr_sensitivity_adjoint(sensitivity, w, NULL, &by);
    mbsr_sensitivity_destroy(sensitivity);
    mbsr_parameters_destroy(list);
    mbsr_simulation_end(&s);
    return status;
}

static int (*const act[])(const linkage *l, test_counting *counting) = {runs, differentiates};
static const linkage all[] = {{0, 1, 0}, {1, 0, 0}, {1, 1, 1}};

/* A function of the caller's fails from one of its calls on: a run ends with its status. */
static void each_call_of_a_law_fails(void **state)
{
    (void)state;
    for (int k = 0; k < 6; ++k) {
        test_counting counting = {0};
        asked = says_at = 0;
        assert_int_equal(act[k % 2](all + k / 2, &counting), MBSR_OK);
        const long count = asked;
        assert_true(count > 50);
        for (long at = 1; at <= count; at += 1 + at / 8) {
            asked = 0, says_at = at, with = at % 2 ? -41 : 41;
            const int status = act[k % 2](all + k / 2, &counting);
            if (status != with || counting.live != 0)
                fail_msg("%d: call %ld of %ld says %d: %s (%d), %ld are left", k, at, count, with,
                         mbsr_status_name(status), status, counting.live);
        }
        says_at = 0;
    }
}

/* Each allocation of a run fails in turn, and of its derivatives: it is said, nothing is lost. */
static void each_allocation_fails(void **state)
{
    (void)state;
    for (int k = 0; k < 6; ++k) {
        test_counting counting = {0};
        assert_int_equal(act[k % 2](all + k / 2, &counting), MBSR_OK);
        const long count = counting.calls;
        assert_in_range(count, 50, 2000);
        for (long at = 1; at <= count; ++at) {
            counting = (test_counting){.fail_at = at};
            const int status = act[k % 2](all + k / 2, &counting);
            if (status != MBSR_ERR_NO_MEMORY || counting.live != 0)
                fail_msg("%d: allocation %ld of %ld: %s, %ld are left", k, at, count,
                         mbsr_status_name(status), counting.live);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(closed_loops_run_too),
        cmocka_unit_test(tables_belong_to_the_simulation),
        cmocka_unit_test(data_belong_to_the_simulation),
        cmocka_unit_test(calls_with_its_data_may_fail_too),
        cmocka_unit_test(functions_read_what_the_struct_has),
        cmocka_unit_test(held_forces_change_between_samples),
        cmocka_unit_test(a_run_needs_one_look_at_the_end),
        cmocka_unit_test(raw_outputs_have_no_accelerations),
        cmocka_unit_test(zero_stands_for_no_coordinates),
        cmocka_unit_test(a_crank_turns_as_told),
        cmocka_unit_test(a_ball_joint_is_turned_as_told),
        cmocka_unit_test(the_first_failure_stays),
        cmocka_unit_test(each_allocation_fails),
        cmocka_unit_test(each_call_of_a_law_fails),
        cmocka_unit_test(momenta_have_the_masses_of_their_joints),
        cmocka_unit_test(events_pass_and_failures_keep_the_last_state),
        cmocka_unit_test(runs_go_on_from_the_last_good_state),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
