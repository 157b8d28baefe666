/* The car axis of the Test Set for IVP Solvers, with small masses and with none.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A ground line turns by psi(t), sin psi = r sin(omega t) / L. The left wheel slides at the
 * distance s from the origin along the normal of that line, the right wheel is at the distance L
 * from the left one, in the direction phi. Springs of stiffness 1 hold the wheels above (0, 0) and
 * above the other end of the line. Wheels of mass eps^2 M / 2; the reference values are those of
 * the test set at t = 3 for eps = 0.01. Without mass, s = L0 and phi = psi(t). */
#include "reference_runs.h"

static const double L = 1.0, L0 = 0.5, R = 0.1, OMEGA = 10.0, M = 10.0, T = 3.0;

static int ground_angle(void *unused, double t, double *psi, double *rate, double *acceleration)
{
    (void)unused;
    const double x = R * sin(OMEGA * t) / L, v = OMEGA * R * cos(OMEGA * t) / L,
                 root = sqrt(1.0 - x * x);
    *psi = asin(x);
    *rate = v / root;
    *acceleration = -OMEGA * OMEGA * x / root + x * v * v / (root * root * root);
    return MBSR_OK;
}

/* In the plane or in space; the angle of the bar is phi - psi where the left wheel turns with the
 * ground line (relative), phi where it does not. q = s and that angle. */
typedef struct telling {
    int space, relative;
} telling;

enum { TELLINGS = 4 };
static const telling tellings[TELLINGS] = {{0, 0}, {0, 1}, {1, 0}, {1, 1}};

static const char *name(const telling *how, int massless)
{
    static const char *const names[2][2][2] = {
        {{"car axis, absolute angle", "car axis without mass, absolute angle"},
         {"car axis, relative angle", "car axis without mass, relative angle"}},
        {{"car axis in space, absolute angle", "car axis in space without mass, absolute angle"},
         {"car axis in space, relative angle", "car axis in space without mass, relative angle"}}};
    return names[how->space][how->relative][massless];
}

/* psi and -psi, for wheels that slide along a normal that turns and do not turn themselves. */
static int there_and_back(void *unused, double t, double *psi, double *rate, double *acceleration)
{
    ground_angle(unused, t, psi, rate, acceleration);
    psi[1] = -psi[0], rate[1] = -rate[0], acceleration[1] = -acceleration[0];
    return MBSR_OK;
}

/* The ground line, the left wheel, the bar with the right wheel. */
static void joints(const telling *how, mbsr_joint joint[3])
{
    const mbsr_planar_frame normal = {0.0, 0.0, acos(0.0)};
    joint[0] = mbsr_joint_planar(run_origin, run_origin, 0, MBSR_ANGLE, ground_angle, NULL);
    joint[1] = how->relative ? mbsr_joint_planar_prismatic(normal, normal)
                             : mbsr_joint_point(normal, MBSR_X, 0, NULL, NULL);
    joint[2] = mbsr_joint_planar_revolute(run_origin, run_origin);
    if (!how->space) return;
    const double e_y[3] = {0.0, 1.0, 0.0}, e_z[3] = {0.0, 0.0, 1.0};
    const mbsr_axis turn = {.kind = MBSR_AXIS_ROTATION, .direction = {0.0, 0.0, 1.0}, .driven = 1},
                    axes[] = {
                        turn, {.kind = MBSR_AXIS_TRANSLATION, .direction = {0.0, 1.0, 0.0}}, turn};
    joint[0] = mbsr_joint_compound(NULL, NULL, 1, &turn, ground_angle, NULL);
    joint[1] = how->relative ? mbsr_joint_prismatic(NULL, NULL, e_y)
                             : mbsr_joint_compound(NULL, NULL, 3, axes, there_and_back, NULL);
    joint[2] = mbsr_joint_revolute(NULL, NULL, e_z);
}

static mbsr_model *car_axis(double eps, const telling *how)
{
    mbsr_model *m = run_model();
    const double mass = eps * eps * M / 2.0, origin[3] = {0.0, 0.0, 0.0}, end[3] = {L, 0.0, 0.0};
    mbsr_joint joint[3];
    joints(how, joint);
    const int line = run_body(m, "ground line", MBSR_GROUND, joint[0], mbsr_inertia_zero());
    /* in space the wheel that does not turn stands on the ground */
    const int left = run_body(m, "left wheel", how->space && !how->relative ? MBSR_GROUND : line,
                              joint[1], mbsr_inertia_particle(mass));
    const int bar = run_body(m, "bar", left, joint[2],
                             how->space ? mbsr_inertia_point_mass(mass, end)
                                        : mbsr_inertia_planar(mass, end, 0.0));
    run_force(m, mbsr_force_point_spring(left, origin, MBSR_GROUND, origin, 1.0, 0.0, L0));
    run_force(m, mbsr_force_point_spring(bar, end, line, end, 1.0, 0.0, L0));
    run_force(m, mbsr_force_gravity(0.0, -1.0, 0.0));
    return run_finish(m);
}

/* xl yl xr yr and their rates. */
static void wheels(const run_state *state, int relative, double w[8])
{
    double psi, rate, acceleration;
    ground_angle(NULL, state->t, &psi, &rate, &acceleration);
    const double s = state->q[0], v = state->u[0], phi = state->q[1] + (relative ? psi : 0.0),
                 turn = state->u[1] + (relative ? rate : 0.0);
    w[0] = -s * sin(psi), w[1] = s * cos(psi);
    w[2] = w[0] + L * cos(phi), w[3] = w[1] + L * sin(phi);
    w[4] = -v * sin(psi) - s * rate * cos(psi), w[5] = v * cos(psi) - s * rate * sin(psi);
    w[6] = w[4] - L * turn * sin(phi), w[7] = w[5] + L * turn * cos(phi);
}

static long check_small_masses(const mbsr_model *m, const telling *how, mbsr_dae_form form,
                               double tolerance, double bound)
{
    static const double reference[8] = {
        .0493455784275402809,  .496989460230171154,   1.04174252488542152,  .373911027265361257,
        -.0770583684040972358, .00744686658723778553, .0175568157537232222, .770341043779251976};
    const double q[2] = {0.5, 0.0}, u[2] = {0.0, how->relative ? -OMEGA * R / L : 0.0};
    run_state state[2];
    run r = {.name = name(how, 0),
             .model = m,
             .form = form,
             .tolerance = tolerance,
             .T = T,
             .points = 1,
             .q = q,
             .u = u};
    double w[8], error = 0.0;
    run_integrate(&r, state);
    assert_int_equal(r.info.null_directions, 0);
    wheels(state + 1, how->relative, w);
    for (int k = 0; k < 8; ++k) w[k] -= reference[k];
    error = test_largest(8, w);
    run_report(&r, error);
    assert_less(error, bound);
    if (form == MBSR_DAE_MOMENTUM && tolerance > 1e-9) run_compare(&r, RUN_REPEATS);
    return r.stats.steps;
}

/* From a start off the solution; the library finds positions and velocities. */
static long check_without_mass(const mbsr_model *m, const telling *how, mbsr_dae_form form,
                               double tolerance, double bound)
{
    enum { POINTS = 30 };
    const double q[2] = {0.55, 0.07}, u[2] = {0.3, -0.4};
    run_state state[POINTS + 1];
    run r = {.name = name(how, 1),
             .model = m,
             .form = form,
             .tolerance = tolerance,
             .T = T,
             .points = POINTS,
             .q = q,
             .u = u};
    run_integrate(&r, state);
    assert_int_equal(r.info.null_directions, 2);
    assert_int_equal(r.info.elastic_directions, 2);
    double error = 0.0;
    for (int k = 0; k <= POINTS; ++k) {
        double psi, rate, acceleration;
        ground_angle(NULL, state[k].t, &psi, &rate, &acceleration);
        error = run_larger(error, fabs(state[k].q[0] - L0));
        error = run_larger(error, fabs(state[k].q[1] - (how->relative ? 0.0 : psi)));
        if (k > 0) continue;
        assert_close(error, 0.0, 1e-9);
        assert_close(state[k].u[0], 0.0, 1e-6);
        assert_close(state[k].u[1], how->relative ? 0.0 : rate, 1e-6);
    }
    run_report(&r, error);
    assert_less(error, bound);
    if (form == MBSR_DAE_MOMENTUM && tolerance > 1e-9) run_compare(&r, RUN_REPEATS);
    return r.stats.steps;
}

static void small_masses_reach_the_reference_values(void **unused)
{
    (void)unused;
    for (const telling *how = tellings; how < tellings + TELLINGS; ++how) {
        mbsr_model *m = car_axis(1e-2, how);
        for (int f = 0; f < RUN_FORMS; ++f) check_small_masses(m, how, run_forms[f], 1e-13, 1e-8);
        mbsr_model_destroy(m);
    }
}

/* Springs alone hold the wheels: index 2, for the momentum form. In relative coordinates nothing
 * moves, and any form will do. */
static void without_mass_the_wheels_follow_the_closed_form(void **unused)
{
    (void)unused;
    for (const telling *how = tellings; how < tellings + TELLINGS; ++how) {
        mbsr_model *m = car_axis(0.0, how);
        if (how->relative) {
            for (int f = 0; f < RUN_FORMS; ++f)
                check_without_mass(m, how, run_forms[f], 1e-8, 1e-12);
        } else {
            for (double tolerance = 1e-4; tolerance > 1e-11; tolerance *= 1e-2)
                check_without_mass(m, how, MBSR_DAE_MOMENTUM, tolerance, 3.0 * tolerance);
        }
        mbsr_model_destroy(m);
    }
}

static void zero_mass_takes_fewer_steps_than_a_small_one(void **unused)
{
    (void)unused;
    for (const telling *how = tellings; how < tellings + TELLINGS; ++how) {
        mbsr_model *small = car_axis(1e-2, how), *zero = car_axis(0.0, how);
        for (double tolerance = 1e-4; tolerance > 1e-9; tolerance *= 1e-2) {
            const long with_mass =
                check_small_masses(small, how, MBSR_DAE_MOMENTUM, tolerance, INFINITY);
            const long without =
                check_without_mass(zero, how, MBSR_DAE_MOMENTUM, tolerance, 3.0 * tolerance);
            assert_true(4 * without < with_mass);
        }
        mbsr_model_destroy(small);
        mbsr_model_destroy(zero);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(small_masses_reach_the_reference_values),
        cmocka_unit_test(without_mass_the_wheels_follow_the_closed_form),
        cmocka_unit_test(zero_mass_takes_fewer_steps_than_a_small_one),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
