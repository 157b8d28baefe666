/* What a run hands out between its steps is as good as the run.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"

#include <mbsrank/simulation.h>

#include <stdlib.h>
#include <string.h>

/* ---- a quarter car on a patch that shakes, whose mount has no mass ---- */

enum { POINTS = 600, OUTPUTS = 400 };

static const double carrier_mass = 35.0, car_mass = 360.0, tyre = 1.7e5, coil = 2e4, rubber = 2e5,
                    spacing = 0.0023;

/* damping of the coil spring: without, springs alone hold the mount */
static void quarter_car(mbsr_simulation *s, double damping)
{
    const double z[3] = {0.0, 0.0, 1.0};
    double t[POINTS], h[POINTS];
    for (int k = 0; k < POINTS; ++k) {
        t[k] = 0.01 * k;
        h[k] = 0.02 * sin(7.0 * t[k]) * sin(31.0 * t[k] * t[k]);
    }
    *s = mbsr_simulation_begin(NULL);
    mbsr_table *road = mbsr_simulation_add_table(s, MBSR_TABLE_SPLINE, POINTS, t, h);
    const mbsr_axis rise = {MBSR_AXIS_TRANSLATION, {0, 0, 1}, 0, 1};
    const mbsr_joint patch_joint =
                         mbsr_joint_compound(NULL, NULL, 1, &rise, mbsr_table_motion, road),
                     slide = mbsr_joint_prismatic(NULL, NULL, z);
    int at = mbsr_simulation_add_body(s, "patch", MBSR_GROUND, patch_joint, mbsr_inertia_zero());
    at = mbsr_simulation_add_body(s, "carrier", at, slide, mbsr_inertia_particle(carrier_mass));
    mbsr_simulation_add_force(s, mbsr_force_joint_spring(at, 0, tyre, 100.0, 0.0));
    at = mbsr_simulation_add_body(s, "mount", at, slide, mbsr_inertia_zero());
    mbsr_simulation_add_force(s, mbsr_force_joint_spring(at, 0, coil, damping, 0.0));
    at = mbsr_simulation_add_body(s, "car", at, slide, mbsr_inertia_particle(car_mass));
    mbsr_simulation_add_force(s, mbsr_force_joint_spring(at, 0, rubber, 0.0, 0.0));
}

static mbsr_ida_opt with_tolerance(double tolerance)
{
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.rtol = opt.atol = tolerance;
    return opt;
}

/* q, u, u' at the outputs. */
typedef struct record {
    double q[OUTPUTS][3], u[OUTPUTS][3], udot[OUTPUTS][3];
} record;

static void drive(double damping, const mbsr_ida_opt *opt, record *r)
{
    mbsr_simulation s;
    quarter_car(&s, damping);
    mbsr_simulation_start(&s, opt, 0.0, NULL, NULL);
    for (int k = 0; k < OUTPUTS; ++k) {
        mbsr_simulation_to(&s, spacing * (k + 1));
        assert_ok(s.status, &s.error);
        memcpy(r->q[k], s.q, sizeof r->q[k]);
        memcpy(r->u[k], s.u, sizeof r->u[k]);
        memcpy(r->udot[k], s.udot, sizeof r->udot[k]);
        /* the rubber alone pushes the car, what is on both sides of the mount is one force */
        double a[3], force[6], pull = coil * s.q[1] + damping * s.u[1];
        assert_ok(mbsr_body_point(s.model, s.data, 3, NULL, NULL, NULL, a),
                  mbsr_data_error(s.data));
        assert_close(car_mass * a[2], -rubber * s.q[2], 1e-8 * rubber * 0.02);
        if (damping > 0.0) assert_close(pull, rubber * s.q[2], 1e-9 * rubber * 0.02);
        assert_ok(mbsr_joint_reaction(s.model, s.data, 3, force), mbsr_data_error(s.data));
        assert_close(force[5], -rubber * s.q[2], 1e-7 * rubber * 0.02);
        /* and the carrier feels tyre and coil */
        assert_ok(mbsr_body_point(s.model, s.data, 1, NULL, NULL, NULL, a),
                  mbsr_data_error(s.data));
        if (damping > 0.0)
            assert_close(carrier_mass * a[2], pull - tyre * s.q[0] - 100.0 * s.u[0],
                         1e-7 * tyre * 0.02);
    }
    mbsr_simulation_end(&s);
}

static double farthest(double (*a)[3], double (*b)[3])
{
    double off = 0.0;
    for (int k = 0; k < OUTPUTS; ++k)
        for (int j = 0; j < 3; ++j) off = fmax(off, fabs(a[k][j] - b[k][j]));
    return off;
}

/* Errors of u and u' follow those of q, by what the equations make of these. */
static void a_mount_without_mass(void **state)
{
    (void)state;
    static record exact, found;
    static const double dampings[] = {2.5e3, 0.0};
    for (int d = 0; d < 2; ++d) {
        mbsr_ida_opt opt = with_tolerance(1e-11);
        drive(dampings[d], &opt, &exact);
        for (double tolerance = 1e-4; tolerance > 1e-10; tolerance *= 1e-2) {
            opt = with_tolerance(tolerance);
            drive(dampings[d], &opt, &found);
            const double q = farthest(found.q, exact.q), u = farthest(found.u, exact.u),
                         udot = farthest(found.udot, exact.udot);
            print_message("damping %g, tolerance %g: q %.1e, u %.1e, u' %.1e\n", dampings[d],
                          tolerance, q, u, udot);
            /* rates of this car: k / d = 80 / s, sqrt(k / m) = 70 / s */
            assert_less(u, 200.0 * q + 1e-11);
            double largest = 0.0;
            for (int k = 0; k < OUTPUTS; ++k)
                largest = fmax(largest, test_largest(3, exact.udot[k]));
            assert_less(udot, 2e4 * q + 2e-6 * largest);
        }
    }
}

/* Where outputs are does not change the steps, nor where they end. */
static void steps_do_not_depend_on_outputs(void **state)
{
    (void)state;
    double last[2][9];
    long steps[2];
    for (int dense = 0; dense < 2; ++dense) {
        mbsr_simulation s;
        quarter_car(&s, 2.5e3);
        mbsr_ida_opt opt = with_tolerance(1e-6);
        mbsr_simulation_start(&s, &opt, 0.0, NULL, NULL);
        for (int k = 1; k <= (dense ? 1000 : 1); ++k)
            mbsr_simulation_to(&s, dense ? 0.001 * k : 1.0);
        assert_ok(s.status, &s.error);
        memcpy(last[dense], s.y, sizeof last[dense]);
        mbsr_ida_stats stats;
        mbsr_simulation_get_stats(&s, &stats);
        steps[dense] = stats.steps;
        mbsr_simulation_end(&s);
    }
    assert_memory_equal(last[0], last[1], sizeof last[0]);
    assert_int_equal(steps[0], steps[1]);
}

/* The differential variables are the integrator's; the raw ones are there on request. */
static void raw_outputs_are_interpolated(void **state)
{
    (void)state;
    double y[2][9], yp[2][9], dky[9];
    for (int raw = 0; raw < 2; ++raw) {
        mbsr_simulation s;
        quarter_car(&s, 2.5e3);
        mbsr_ida_opt opt = with_tolerance(1e-6);
        opt.raw_outputs = raw;
        mbsr_simulation_start(&s, &opt, 0.0, NULL, NULL);
        assert_ok(s.status, &s.error);
        assert_ok(mbsr_ida_advance(s.ida, 0.7003, NULL, y[raw], yp[raw]), mbsr_ida_error(s.ida));
        assert_ok(mbsr_ida_dense(s.ida, 0.7003, 0, dky), mbsr_ida_error(s.ida));
        if (raw) assert_memory_equal(dky, y[raw], sizeof dky);
        mbsr_simulation_end(&s);
    }
    assert_memory_equal(y[0], y[1], 6 * sizeof y[0][0]);
    assert_true(memcmp(y[0] + 6, y[1] + 6, 3 * sizeof y[0][0]) != 0);
}

/* F at a state handed out: no row beyond rounding, by every way out. */
static void expect_equations(mbsr_simulation *s, mbsr_data *d, double t, const double *y,
                             const double *yp)
{
    double F[9];
    assert_ok(mbsr_dae_residual(s->model, d, MBSR_DAE_MOMENTUM, t, y, yp, F), mbsr_data_error(d));
    for (int k = 0; k < 3; ++k) {
        assert_close(F[k], 0.0, 1e-12);
        assert_close(F[3 + k], 0.0, 1e-10 * rubber * 0.02);
        assert_close(F[6 + k], 0.0, 1e-10 * rubber * 0.02);
    }
}

typedef struct outputs {
    mbsr_simulation *s;
    mbsr_data *d;
    int count;
} outputs;

static int take(void *user, int index, double t, const double *y, const double *yp)
{
    outputs *o = user;
    (void)index;
    expect_equations(o->s, o->d, t, y, yp);
    ++o->count;
    return 0;
}

static int through_zero(void *user, double t, const double *y, const double *yp, double *value)
{
    (void)user, (void)t, (void)yp;
    value[0] = y[2] - 1e-4;
    return 0;
}

static void every_way_out_is_completed(void **state)
{
    (void)state;
    mbsr_simulation s;
    double t, y[9], yp[9], times[50];
    int next = 0, events = 0;
    quarter_car(&s, 2.5e3);
    mbsr_ida_opt opt = with_tolerance(1e-5);
    opt.events = 1;
    opt.event = through_zero;
    mbsr_simulation_start(&s, &opt, 0.0, NULL, NULL);
    assert_ok(s.status, &s.error);
    outputs o = {&s, mbsr_simulation_add_data(&s), 0};
    for (int k = 0; k < 50; ++k) times[k] = 0.0071 * (k + 1);
    while (next < 50) {
        const int status = mbsr_ida_run(s.ida, 50, times, &next, take, &o);
        if (status != MBSR_EVENT) assert_ok(status, mbsr_ida_error(s.ida));
        events += status == MBSR_EVENT;
        assert_ok(mbsr_ida_state(s.ida, &t, y, yp), mbsr_ida_error(s.ida));
        expect_equations(&s, o.d, t, y, yp);
    }
    assert_true(o.count == 50 && events > 0);
    /* the last good state after a failure */
    opt.max_steps = 20;
    opt.events = 0;
    opt.event = NULL;
    mbsr_simulation_start(&s, &opt, 0.0, NULL, NULL);
    assert_int_equal(mbsr_ida_advance(s.ida, 3.0, NULL, NULL, NULL), MBSR_ERR_SOLVER);
    assert_ok(mbsr_ida_state(s.ida, &t, y, yp), mbsr_ida_error(s.ida));
    expect_equations(&s, o.d, t, y, yp);
    mbsr_simulation_end(&s);
}

/* ---- closed loops: a four-bar linkage, the coupler with and without mass ---- */

static mbsr_simulation four_bar(double coupler_mass, double stiffness, int *coupler, int *pin)
{
    const double y[3] = {0.0, 1.0, 0.0}, origin[3] = {0.0}, crank_end[3] = {0.2, 0.0, 0.0},
                 coupler_end[3] = {0.5, 0.0, 0.0}, rocker_end[3] = {0.35, 0.0, 0.0};
    const mbsr_frame tip = mbsr_frame_at(0.2, 0.0, 0.0), right = mbsr_frame_at(0.4, 0.0, 0.0);
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    const int crank =
        mbsr_simulation_add_body(&s, "crank", MBSR_GROUND, mbsr_joint_revolute(NULL, NULL, y),
                                 mbsr_inertia_rod(1.0, origin, crank_end));
    *coupler = mbsr_simulation_add_body(&s, "coupler", crank, mbsr_joint_revolute(&tip, NULL, y),
                                        coupler_mass > 0.0
                                            ? mbsr_inertia_rod(coupler_mass, origin, coupler_end)
                                            : mbsr_inertia_zero());
    const int rocker =
        mbsr_simulation_add_body(&s, "rocker", MBSR_GROUND, mbsr_joint_revolute(&right, NULL, y),
                                 mbsr_inertia_rod(1.5, origin, rocker_end));
    mbsr_closure_def ball = mbsr_closure_ball(*coupler, coupler_end, rocker, rocker_end);
    for (int k = 0; k < 3; ++k) {
        ball.stiffness[k] = stiffness;
        ball.damping[k] = 1e-4 * stiffness;
    }
    *pin = mbsr_simulation_add_closure(&s, ball);
    mbsr_simulation_add_force(&s, mbsr_force_gravity(0.0, 0.0, -9.81));
    return s;
}

/* Newton's and Euler's laws for the coupler from what its two pins exert, at every output; a
 * balance of forces where it has no mass, which is what massless rods are: the force is along it.
 */
static void laws_of_the_coupler(mbsr_simulation *s, double mass, int coupler, int pin)
{
    const double centre[3] = {0.25, 0.0, 0.0};
    double joint[6], loop[6], a[3], at[3], origin[3], A[6];
    mbsr_simulation_check(s, mbsr_joint_reaction(s->model, s->data, coupler, joint));
    mbsr_simulation_check(s, mbsr_closure_reaction(s->model, s->data, pin, 0, loop, NULL));
    mbsr_simulation_check(s, mbsr_body_point(s->model, s->data, coupler, centre, at, NULL, a));
    mbsr_simulation_check(s, mbsr_body_point(s->model, s->data, coupler, NULL, origin, NULL, NULL));
    mbsr_simulation_check(s, mbsr_body_acceleration(s->model, s->data, coupler, A));
    assert_ok(s->status, &s->error);
    const double size = 10.0 + fabs(joint[3]) + fabs(joint[5]), weight = 9.81 * mass,
                 arm[2] = {at[0] - origin[0], at[2] - origin[2]}, inertia = mass * 0.25 / 12.0;
    assert_close(joint[3] + loop[3], mass * a[0], 1e-8 * size);
    assert_close(joint[5] + loop[5] - weight, mass * a[2], 1e-8 * size);
    /* about the origin: moments of pins, weight, and m (c x a) + I alpha; y up out of x and z */
    const double moment = joint[1] + loop[1] + arm[0] * weight,
                 spin = inertia * A[1] + mass * (arm[1] * a[0] - arm[0] * a[2]);
    assert_close(moment, spin, 1e-8 * size);
}

static void pins_accelerate_the_coupler(void **state)
{
    (void)state;
    static const double stiffness[] = {0.0, 1e8};
    for (int light = 0; light < 2; ++light) {
        for (int k = 0; k < 2; ++k) {
            const double q[3] = {-1.2, 0.6, -1.9}, mass = light ? 0.0 : 0.8;
            int coupler, pin;
            mbsr_simulation s = four_bar(mass, stiffness[k], &coupler, &pin);
            const mbsr_ida_opt opt = with_tolerance(1e-6);
            mbsr_simulation_start(&s, &opt, 0.0, q, NULL);
            for (int n = 0; n <= 300; ++n) {
                if (n > 0) mbsr_simulation_to(&s, 0.0053 * n);
                assert_ok(s.status, &s.error);
                laws_of_the_coupler(&s, mass, coupler, pin);
            }
            /* energy from outputs against the start, nothing is dissipated but in the stiff pin */
            mbsr_ida_drift drift;
            assert_ok(mbsr_ida_get_drift(s.ida, &drift), mbsr_ida_error(s.ida));
            assert_close(drift.energy_change, 0.0, 1e-3);
            mbsr_ida_stats stats;
            mbsr_simulation_get_stats(&s, &stats);
            assert_int_equal(stats.raw_states, 0);
            mbsr_simulation_end(&s);
        }
    }
}

/* A parallelogram whose coupler has no mass and carries no force: at every output velocities and
 * the force are found, though what closes the velocities to rounding is a large force over a short
 * time. */
static void a_coupler_that_carries_nothing(void **state)
{
    (void)state;
    const double y[3] = {0.0, 1.0, 0.0}, origin[3] = {0.0}, up[3] = {0.0, 0.0, 1.0},
                 end[3] = {1.0, 0.0, 0.0}, rows[6] = {1.0, 0.0, 0.0, 0.0, 0.0, 1.0};
    const mbsr_frame tip = mbsr_frame_at(0.0, 0.0, 1.0), right = mbsr_frame_at(1.0, 0.0, 0.0);
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    const int crank =
        mbsr_simulation_add_body(&s, "crank", MBSR_GROUND, mbsr_joint_revolute(NULL, NULL, y),
                                 mbsr_inertia_rod(1.0, origin, up));
    const int coupler = mbsr_simulation_add_body(
        &s, "coupler", crank, mbsr_joint_revolute(&tip, NULL, y), mbsr_inertia_zero());
    const int rocker =
        mbsr_simulation_add_body(&s, "rocker", MBSR_GROUND, mbsr_joint_revolute(&right, NULL, y),
                                 mbsr_inertia_rod(1.0, origin, up));
    mbsr_simulation_add_closure(&s, mbsr_closure_rows(coupler, end, rocker, up, 2, rows));
    mbsr_simulation_add_force(&s, mbsr_force_gravity(1.0, 0.0, -9.81));
    mbsr_simulation_start(&s, NULL, 0.0, NULL, NULL);
    for (int n = 1; n <= 2000; ++n) {
        double force[2], udot[3];
        mbsr_simulation_to(&s, 0.0025 * n);
        assert_ok(mbsr_simulation_reactions(&s, force), &s.error);
        assert_ok(mbsr_simulation_accelerations(&s, udot), &s.error);
        /* a rod alone: 1/3 u' = 1/2 (g sin q + 1 m/s^2 cos q); but for what the rods differ by
         * where all are in a row */
        if (fabs(cos(s.q[0])) < 0.2) continue;
        assert_close(udot[0], 1.5 * (9.81 * sin(s.q[0]) + cos(s.q[0])), 1e-4);
        assert_close(hypot(force[0], force[1]), 0.0, 1e-4);
        assert_close(s.u[2], s.u[0], 1e-5);
    }
    mbsr_ida_stats stats;
    mbsr_simulation_get_stats(&s, &stats);
    assert_int_equal(stats.raw_states, 0);
    mbsr_simulation_end(&s);
}

/* Two rods whose joint falls on a stop of up to 1e12 N m/rad, which a step passes over: off by a
 * tolerance the stop would hold joules. From output to output energy does not grow by more than 100
 * tolerances of what the rods can have, 30 J. */
static void an_impact_gives_no_energy(void **state)
{
    (void)state;
    static const double stiffness[] = {1e6, 1e9, 1e12};
    const double y[3] = {0.0, 1.0, 0.0}, down[3] = {0.0, 0.0, -1.0}, origin[3] = {0.0},
                 q[2] = {1.2, 0.3};
    const mbsr_frame tip = mbsr_frame_at(0.0, 0.0, -1.0);
    for (int j = 0; j < 3; ++j) {
        for (double tolerance = 1e-3; tolerance > 1e-7; tolerance *= 0.1) {
            const mbsr_ida_opt opt = with_tolerance(tolerance);
            const double k = stiffness[j];
            double kinetic, potential, last = INFINITY;
            mbsr_simulation s = mbsr_simulation_begin(NULL);
            const int upper = mbsr_simulation_add_body(&s, "upper rod", MBSR_GROUND,
                                                       mbsr_joint_revolute(NULL, NULL, y),
                                                       mbsr_inertia_rod(1.0, origin, down));
            const int lower =
                mbsr_simulation_add_body(&s, "lower rod", upper, mbsr_joint_revolute(&tip, NULL, y),
                                         mbsr_inertia_rod(1.0, origin, down));
            mbsr_simulation_add_force(&s, mbsr_force_gravity(0.0, 0.0, -9.81));
            mbsr_simulation_add_force(
                &s, mbsr_force_joint_stop(lower, 0, -0.1, 0.8, k, 0.6 * sqrt(k / 3.0)));
            mbsr_simulation_start(&s, &opt, 0.0, q, NULL);
            for (int n = 1; n <= 5000; ++n) {
                mbsr_simulation_to(&s, 8e-4 * n);
                assert_ok(s.status, &s.error);
                assert_ok(mbsr_energy(s.model, s.data, &kinetic, &potential),
                          mbsr_data_error(s.data));
                assert_less(kinetic + potential - last, 100.0 * tolerance * 30.0);
                last = kinetic + potential;
            }
            mbsr_simulation_end(&s);
        }
    }
}

/* ---- what has no mass between a spring and a damper, k / d = 1e5 / s ---- */

static int push(void *user, double t, int n, double *value)
{
    (void)user;
    for (int k = 0; k < n; ++k) value[k] = k == 3 ? cos(t) : 0.0;
    return MBSR_OK;
}

/* A mass of 1 kg is pushed by cos t; it hangs on a spring of 1e5 N/m on a link that a damper of
 * 1 N s/m holds: u' = cos t - u, and the link follows within d / k = 1e-5 s. Errors of its position
 * that are tolerances are accelerations (k / d)^2 times these. */
static void a_link_follows_its_mass(void **state)
{
    (void)state;
    static const double x[3] = {1.0, 0.0, 0.0};
    for (double tolerance = 1e-4; tolerance > 5e-9; tolerance *= 1e-2) {
        mbsr_ida_opt opt = with_tolerance(tolerance);
        mbsr_simulation s = mbsr_simulation_begin(NULL);
        const mbsr_joint slide = mbsr_joint_prismatic(NULL, NULL, x);
        const int link =
                      mbsr_simulation_add_body(&s, "link", MBSR_GROUND, slide, mbsr_inertia_zero()),
                  mass =
                      mbsr_simulation_add_body(&s, "mass", link, slide, mbsr_inertia_particle(1.0));
        mbsr_simulation_add_force(&s, mbsr_force_joint_spring(link, 0, 0.0, 1.0, 0.0));
        mbsr_simulation_add_force(&s, mbsr_force_joint_spring(mass, 0, 1e5, 0.0, 0.0));
        mbsr_simulation_add_force(&s, mbsr_force_applied(mass, push, NULL));
        mbsr_simulation_start(&s, &opt, 0.0, NULL, NULL);
        for (int k = 1; k <= 100; ++k) {
            const double t = 0.0731 * k, u = 0.5 * (cos(t) + sin(t) - exp(-t));
            mbsr_simulation_to(&s, t);
            assert_ok(s.status, &s.error);
            assert_close(s.u[0], u, 10.0 * tolerance + 3e-5);
            assert_close(s.udot[0], cos(t) - u, 100.0 * sqrt(tolerance));
        }
        mbsr_simulation_end(&s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_mount_without_mass),
        cmocka_unit_test(steps_do_not_depend_on_outputs),
        cmocka_unit_test(raw_outputs_are_interpolated),
        cmocka_unit_test(every_way_out_is_completed),
        cmocka_unit_test(pins_accelerate_the_coupler),
        cmocka_unit_test(a_coupler_that_carries_nothing),
        cmocka_unit_test(an_impact_gives_no_energy),
        cmocka_unit_test(a_link_follows_its_mass),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
