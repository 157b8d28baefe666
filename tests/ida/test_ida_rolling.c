/* Rolling without slip, by motions that are known: a ball on a turntable, level or inclined, and a
 * coin that circles, in four systems of units.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"
#include "units.h"

#include <mbsrank/simulation.h>

#include <complex.h>
#include <math.h>

static const double pi = 3.14159265358979323846;

static int turn_evenly(void *user, double t, double *value, double *rate, double *acceleration)
{
    const double *speed = user;
    *value = *speed * t;
    *rate = *speed;
    *acceleration = 0.0;
    return 0;
}

/* A free body of that mass, with moments A, A, C, from q and u on. */
static int add_rolling(mbsr_simulation *s, double mass, double A, double C)
{
    const double centre[3] = {0, 0, 0}, moments[6] = {A, A, C, 0, 0, 0};
    return mbsr_simulation_add_body(s, "rolling", MBSR_GROUND, mbsr_joint_free(NULL, NULL),
                                    mbsr_inertia_rigid(mass, centre, moments));
}

static void start(mbsr_simulation *s, const units *of, const double *q, const double *u)
{
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.rtol = 1e-9;
    opt.atol = 1e-9 * fmin(of->length, 1.0);
    assert_ok(mbsr_simulation_start(s, &opt, 0.0, q, u), mbsr_simulation_error(s));
}

/* Its centre has v' = i a v + b with a = 2/7 of the table's speed and b = 5/7 of gravity along the
 * table, x + i y: it circles at that rate and drifts across the slope. */
static void a_ball_on_a_turntable(void **state)
{
    (void)state;
    for (int k = 0; k < 8; ++k) {
        const units *of = systems + k % 4;
        const double L = of->length, M = of->mass, T = of->time, r = 0.2 * L, mass = 3.0 * M;
        const double slope = k < 4 ? 0.0 : 0.1, g = 9.81 * L / (T * T), moment = 0.4 * mass * r * r;
        double speed = 2.5 / T;
        const double complex x0 = L * (0.6 - 0.2 * I), v0 = L / T * (0.3 + 0.5 * I);
        mbsr_simulation s = mbsr_simulation_begin(NULL);
        const mbsr_axis turn = {MBSR_AXIS_ROTATION, {0, 0, 1}, 0.0, 1};
        const int table = mbsr_simulation_add_body(
            &s, "table", MBSR_GROUND,
            mbsr_joint_compound(NULL, NULL, 1, &turn, turn_evenly, &speed), mbsr_inertia_zero());
        const int ball = add_rolling(&s, mass, moment, moment);
        mbsr_simulation_add_force(&s, mbsr_force_gravity(g * sin(slope), 0.0, -g * cos(slope)));
        mbsr_simulation_add_closure(&s, mbsr_closure_rolling_ball(ball, NULL, r, table, NULL));
        const double complex slip = speed * I * x0 - v0;
        const double q[7] = {1, 0, 0, 0, creal(x0), cimag(x0), r},
                     u[6] = {cimag(slip) / r, -creal(slip) / r, 3.0 / T, creal(v0), cimag(v0), 0};
        start(&s, of, q, u);
        const double complex rate = 2.0 / 7.0 * speed * I,
                             drift = 5.0 / 7.0 * g * sin(slope) / rate;
        for (int l = 1; l <= 4; ++l) {
            const double t = 2.0 * T * l;
            const double complex x = x0 + (v0 + drift) * (cexp(rate * t) - 1.0) / rate - drift * t;
            assert_ok(mbsr_simulation_to(&s, t), mbsr_simulation_error(&s));
            const double *at = mbsr_simulation_q(&s) + 4, *spin = mbsr_simulation_u(&s);
            assert_close(at[0] / L, creal(x) / L, 2e-6);
            assert_close(at[1] / L, cimag(x) / L, 2e-6);
            assert_close(at[2] / r, 1.0, 1e-9);
            assert_close(spin[2] * T, 3.0, 1e-6);
        }
        mbsr_simulation_end(&s);
    }
}

/* Its axis stands at an angle to the vertical and goes round at an even rate, its spin is
 *
 *   n = cos (A rate^2 sin - m g r) / (rate sin (C + m r^2)),
 *
 * its centre on a circle of radius -n r / rate. */
static void a_coin_circles(void **state)
{
    (void)state;
    for (int k = 0; k < 4; ++k) {
        const units *of = systems + k;
        const double L = of->length, M = of->mass, T = of->time, r = 0.3 * L, mass = 2.0 * M;
        const double A = 0.25 * mass * r * r, C = 2.0 * A, g = 9.81 * L / (T * T),
                     tilt = 0.5 * pi - 0.3, rate = 1.4 / T, c = cos(tilt), sine = sin(tilt),
                     n = c * (A * rate * rate * sine - mass * g * r) /
                         (rate * sine * (C + mass * r * r)),
                     radius = -n * r / rate, own = n - rate * c;
        mbsr_simulation s = mbsr_simulation_begin(NULL);
        const int coin = add_rolling(&s, mass, A, C);
        mbsr_simulation_add_force(&s, mbsr_force_gravity(0.0, 0.0, -g));
        mbsr_simulation_add_closure(&s,
                                    mbsr_closure_rolling_disc(coin, NULL, r, MBSR_GROUND, NULL));
        const double q[7] = {cos(0.5 * tilt), 0, sin(0.5 * tilt), 0, radius, 0, r * sine},
                     u[6] = {own * sine, 0, rate + own * c, 0, -r * n, 0};
        start(&s, of, q, u);
        double udot[6];
        for (int l = 1; l <= 4; ++l) {
            const double t = 0.5 * pi * l / rate;
            assert_ok(mbsr_simulation_to(&s, t), mbsr_simulation_error(&s));
            const double *at = mbsr_simulation_q(&s) + 4;
            assert_close(at[0] / L, radius / L * cos(rate * t), 1e-6);
            assert_close(at[1] / L, radius / L * sin(rate * t), 1e-6);
            assert_close(at[2] / L, 0.3 * sine, 1e-6);
        }
        assert_ok(mbsr_simulation_accelerations(&s, udot), mbsr_simulation_error(&s));
        assert_close(hypot(udot[3], udot[4]) / (radius * rate * rate), 1.0, 1e-6);
        mbsr_simulation_end(&s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_ball_on_a_turntable),
                                       cmocka_unit_test(a_coin_circles)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
