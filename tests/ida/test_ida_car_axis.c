/* The car axis of the Test Set for IVP Solvers, with small masses and with none.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The reference values are those of the test set at t = 3 for eps = 0.01. Without mass, s = L0 and
 * phi = psi(t). */
#include "car_axis.h"

static const double T = 3.0;

static const char *name(const telling *how, int massless)
{
    static const char *const names[2][2][2] = {
        {{"car axis, absolute angle", "car axis without mass, absolute angle"},
         {"car axis, relative angle", "car axis without mass, relative angle"}},
        {{"car axis in space, absolute angle", "car axis in space without mass, absolute angle"},
         {"car axis in space, relative angle", "car axis in space without mass, relative angle"}}};
    return names[how->space][how->relative][massless];
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

/* From a start off the solution; the library finds positions and velocities. `compare`: with a
 * dense matrix, too. */
static long check_without_mass(const mbsr_model *m, const telling *how, mbsr_dae_form form,
                               double tolerance, double bound, bool compare)
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
    assert_int_equal(r.info.elastic, 1);
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
    if (compare) run_compare(&r, RUN_REPEATS);
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
                check_without_mass(m, how, run_forms[f], 1e-8, 1e-12, false);
        } else {
            for (double tolerance = 1e-4; tolerance > 1e-11; tolerance *= 1e-2)
                check_without_mass(m, how, MBSR_DAE_MOMENTUM, tolerance, 3.0 * tolerance, false);
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
                check_without_mass(zero, how, MBSR_DAE_MOMENTUM, tolerance, 3.0 * tolerance, true);
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
