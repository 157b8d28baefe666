/* A few modes of models of many bodies: with an answer on paper, of equal parts, refused by name.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "build.h"
#include "duration.h"

#include <mbsrank/linear.h>

#include <stdlib.h>

static const double pi = 3.14159265358979323846, along[3] = {1, 0, 0}, y_axis[3] = {0, 1, 0};

/* Four hundred masses and nodes without mass in a row on springs of 2 k between walls: f_i = 1/pi
 * sqrt(k/m) cos((n+1-i)/(n+1) pi/2). */
static void a_string_of_masses_and_nodes(void **state)
{
    (void)state;
    enum { MASSES = 400, BODIES = 2 * MASSES + 1, MODES = 20 };
    const double mass = 0.7, stiffness = 120.0;
    mbsr_model *m = empty();
    double *q = calloc(BODIES, sizeof *q), *re = calloc(MODES * BODIES, sizeof *re);
    mbsr_mode mode[MODES];
    mbsr_error error;
    int found;
    add_string(m, BODIES, mass, stiffness);
    mbsr_data *d = finish(m);
    assert_ok(mbsr_modes_near(m, d, 0.0, q, NULL, mode, &found, re, NULL, &error), &error);
    assert_int_equal(found, MODES);
    for (int i = 1; i <= MODES; ++i) {
        const double n = MASSES,
                     f = sqrt(stiffness / mass) / pi * cos((n + 1.0 - i) / (n + 1.0) * pi / 2.0);
        assert_close(mode[i - 1].frequency / f, 1.0, 1e-9);
        assert_close(mode[i - 1].damping, 0.0, 1e-9);
        /* places of masses are sines */
        double place = 0.0, worst = 0.0, scale = 0.0, sign = 0.0;
        for (int k = 0; k < BODIES; ++k) {
            place += re[(i - 1) * BODIES + k];
            const double sine = sin((k / 2 + 1) * i * pi / (n + 1.0));
            if (k % 2 == 0) continue;
            if (fabs(sine) > 0.5 && sign == 0.0) sign = place / sine;
            if (sign == 0.0) continue;
            scale = fmax(scale, fabs(sign));
            worst = fmax(worst, fabs(place - sign * sine));
        }
        assert_close(worst / scale, 0.0, 1e-6);
    }
    free(q);
    free(re);
    free_both(m, d);
}

/* Six equal pendulums have one frequency, six times; a body free in space rests in six directions.
 */
static void what_comes_several_times_is_given_as_often(void **state)
{
    (void)state;
    enum { EQUAL = 6, MORE = 12 };
    const double g = 9.81;
    mbsr_model *m = empty();
    mbsr_near_opt opt = mbsr_default_near_opt();
    mbsr_mode mode[EQUAL + 2];
    mbsr_error error;
    double q[EQUAL + MORE] = {0.0};
    int found;
    for (int k = 0; k < EQUAL + MORE; ++k) {
        const double length = k < EQUAL ? 2.0 : 1.0 / (1.0 + k);
        add_body(m, MBSR_GROUND, NULL, mbsr_joint_revolute(NULL, NULL, y_axis),
                 mbsr_inertia_point_mass(1.0, (const double[3]){0, 0, -length}));
    }
    add_force(m, mbsr_force_gravity(0, 0, -g));
    mbsr_data *d = finish(m);
    opt.count = EQUAL + 1;
    assert_ok(mbsr_modes_near(m, d, 0.0, q, &opt, mode, &found, NULL, NULL, &error), &error);
    assert_int_equal(found, EQUAL + 1);
    for (int k = 0; k < EQUAL; ++k) assert_close(mode[k].imaginary, sqrt(g / 2.0), 1e-9);
    assert_close(mode[EQUAL].imaginary, sqrt(g * (1.0 + EQUAL)), 1e-9);
    /* nearest to a shift: those of the same pencil, and no slower one in their place */
    opt.count = 2;
    opt.shift = 3.0;
    assert_ok(mbsr_modes_near(m, d, 0.0, q, &opt, mode, &found, NULL, NULL, &error), &error);
    assert_int_equal(found, 2);
    for (int k = 0; k < 2; ++k) assert_close(mode[k].imaginary, sqrt(g / 2.0), 1e-9);
    free_both(m, d);
}

/* Sliders with 1, 1.001, 1.002 ... rad/s: beside others their eigenvalues are hardly larger. Those
 * nearest to a shift take the space many times over, and as near to a shift of half their rate as
 * the slowest are more than a space holds, at a lower one not. */
static mbsr_model *many_sliders(int sliders, double apart, double damping)
{
    mbsr_model *m = empty();
    for (int k = 0; k < sliders; ++k) {
        const double rate = 1.0 + apart * k;
        add_body(m, MBSR_GROUND, NULL, mbsr_joint_prismatic(NULL, NULL, along),
                 mbsr_inertia_particle(1.0));
        add_force(m, mbsr_force_joint_spring(k, 0, rate * rate,
                                             2.0 * damping * rate * (k * 37 % sliders) / sliders,
                                             0.0));
    }
    return m;
}

static void close_frequencies(int sliders)
{
    enum { MODES = 4 };
    mbsr_model *m = many_sliders(sliders, 1e-3, 0.0);
    mbsr_near_opt opt = mbsr_default_near_opt();
    mbsr_mode mode[MODES];
    mbsr_error error;
    double *q = calloc((size_t)sliders, sizeof *q);
    int found;
    mbsr_data *d = finish(m);
    for (int slowest = 0; slowest < 2; ++slowest) {
        opt.count = slowest ? 1 : MODES;
        opt.shift = slowest ? 0.0 : 0.5;
        for (; opt.count <= MODES; opt.count += MODES - 1) {
            assert_ok(mbsr_modes_near(m, d, 0.0, q, &opt, mode, &found, NULL, NULL, &error),
                      &error);
            assert_int_equal(found, opt.count);
            for (int k = 0; k < found; ++k) assert_close(mode[k].imaginary, 1.0 + 1e-3 * k, 1e-9);
        }
    }
    free(q);
    free_both(m, d);
}

static void frequencies_close_to_each_other(void **state)
{
    (void)state;
    close_frequencies(150);
    if (test_seeds(0, 1)) close_frequencies(600);
}

/* 550 whose rates differ by 1e-6, and their damping by no order: a space of 46 vectors does not
 * tell them apart. */
static void too_close_to_each_other(void **state)
{
    (void)state;
    enum { SLIDERS = 550, MODES = 4 };
    mbsr_model *m = many_sliders(SLIDERS, 1e-6, 0.03);
    mbsr_near_opt opt = mbsr_default_near_opt();
    mbsr_mode mode[MODES];
    mbsr_error error;
    const double q[SLIDERS] = {0.0};
    int found;
    mbsr_data *d = finish(m);
    opt.count = MODES;
    assert_refused(mbsr_modes_near(m, d, 0.0, q, &opt, mode, &found, NULL, NULL, &error), &error,
                   MBSR_NO_CONVERGENCE, MBSR_NONE, MBSR_NONE, "4 modes|at another shift");
    assert_int_equal(found, 0);
    free_both(m, d);
}

/* A damper past the critical one: two numbers that decay, slower and faster than what swings. */
static void slow_ones_are_slow_whatever_their_phase(void **state)
{
    (void)state;
    mbsr_model *m = empty();
    mbsr_near_opt opt = mbsr_default_near_opt();
    mbsr_mode mode[3];
    mbsr_error error;
    const double q[3] = {0.0}, k[3] = {4.0, 26.0, 49.0}, c[3] = {5.0, 0.2, 50.0};
    int found;
    for (int i = 0; i < 3; ++i) {
        add_body(m, MBSR_GROUND, NULL, mbsr_joint_prismatic(NULL, NULL, along),
                 mbsr_inertia_particle(1.0));
        add_force(m, mbsr_force_joint_spring(i, 0, k[i], c[i], 0.0));
    }
    mbsr_data *d = finish(m);
    opt.count = 3;
    assert_ok(mbsr_modes_near(m, d, 0.0, q, &opt, mode, &found, NULL, NULL, &error), &error);
    assert_int_equal(found, 3);
    assert_close(mode[0].real, -25.0 + sqrt(625.0 - 49.0), 1e-9); /* -1 */
    assert_close(mode[1].real, -1.0, 1e-9);
    assert_close(mode[2].real, -4.0, 1e-9);
    opt.count = 1;
    assert_ok(mbsr_modes_near(m, d, 0.0, q, &opt, mode, &found, NULL, NULL, &error), &error);
    assert_close(mode[0].real, -1.0, 1e-9);
    free_both(m, d);
}

static void what_is_wrong_is_refused(void **state)
{
    (void)state;
    mbsr_model *m = empty();
    mbsr_mode mode[20];
    mbsr_near_opt opt = mbsr_default_near_opt();
    mbsr_error error;
    const double q[2] = {0.0, 0.1};
    int found = 7;
    add_body(m, MBSR_GROUND, NULL, mbsr_joint_prismatic(NULL, NULL, along),
             mbsr_inertia_particle(1.0));
    add_body(m, MBSR_GROUND, NULL, mbsr_joint_revolute(NULL, NULL, y_axis),
             mbsr_inertia_point_mass(1.0, (const double[3]){0, 0, -1}));
    add_force(m, mbsr_force_gravity(0, 0, -9.81));
    mbsr_data *d = finish(m);
    assert_refused(mbsr_modes_near(m, d, 0.0, q, NULL, mode, &found, NULL, NULL, &error), &error,
                   MBSR_ERR_VALUE, 1, MBSR_NONE, "not at rest|mbsr_equilibrium");
    assert_int_equal(found, 0);
    assert_refused(mbsr_modes_near(m, NULL, 0.0, q, NULL, mode, &found, NULL, NULL, &error), &error,
                   MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "data is NULL");
    assert_int_equal(mbsr_modes_near(m, d, 0.0, NULL, NULL, mode, &found, NULL, NULL, &error),
                     MBSR_ERR_NULL);
    assert_int_equal(mbsr_modes_near(m, d, 0.0, q, NULL, NULL, &found, NULL, NULL, &error),
                     MBSR_ERR_NULL);
    assert_int_equal(mbsr_modes_near(m, d, 0.0, q, NULL, mode, NULL, NULL, NULL, &error),
                     MBSR_ERR_NULL);
    mbsr_near_opt bad[] = {opt, opt, opt, opt, opt};
    bad[0].count = 1001, bad[1].shift = -1.0, bad[2].shift = INFINITY, bad[3].tolerance = 0.0;
    bad[4].tolerance = NAN;
    for (int k = 0; k < 5; ++k)
        assert_refused(mbsr_modes_near(m, d, 0.0, q, bad + k, mode, &found, NULL, NULL, &error),
                       &error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE, "count is|shift|tolerance");
    opt.count = 0;
    assert_refused(mbsr_modes_near(m, d, 0.0, q, &opt, mode, &found, NULL, NULL, &error), &error,
                   MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE, "count is 0");
    opt.cookie = 0;
    assert_refused(mbsr_modes_near(m, d, 0.0, q, &opt, mode, &found, NULL, NULL, &error), &error,
                   MBSR_ERR_NO_DEFAULT, MBSR_NONE, MBSR_NONE, "opt");
    free_both(m, d);
    m = empty();
    add_body(m, MBSR_GROUND, NULL, mbsr_joint_point_free(), mbsr_inertia_particle(1.0));
    mbsr_closure_def rod = mbsr_closure_distance(0, NULL, MBSR_GROUND, NULL, 1.0);
    rod.stiffness[0] = 1e4;
    assert_ok(mbsr_model_add_closure(m, &rod, NULL), mbsr_model_error(m));
    d = finish(m);
    assert_refused(mbsr_modes_near(m, d, 0.0, q, NULL, mode, &found, NULL, NULL, &error), &error,
                   MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE, "closure 0 has stiff rows");
    free_both(m, d);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_string_of_masses_and_nodes),
                                       cmocka_unit_test(what_comes_several_times_is_given_as_often),
                                       cmocka_unit_test(frequencies_close_to_each_other),
                                       cmocka_unit_test(too_close_to_each_other),
                                       cmocka_unit_test(slow_ones_are_slow_whatever_their_phase),
                                       cmocka_unit_test(what_is_wrong_is_refused)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
