/* The benchmark bicycle: eigenvalues over speed, from M s^2 + v C1 s + g K0 + v^2 K2.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "bicycle.h"

#include <mbsrank/linear.h>

#include <complex.h>

static const double M[2][2] = {{80.81722, 2.31941332208709}, {2.31941332208709, 0.29784188199686}},
                    C1[2][2] = {{0.0, 33.86641391492494}, {-0.85035641456978, 1.68540397397560}},
                    K0[2][2] = {{-80.95, -2.59951685249872},
                                {-2.59951685249872, -0.80329488458618}},
                    K2[2][2] = {{0.0, 76.59734589573222}, {0.0, 2.65431523794604}};

/* How far s is from a root of the determinant, by one step of Newton's method. */
static double distance_to_root(double v, double complex s)
{
    double complex value[2];
    const double complex h = 1e-5 * (1.0 + cabs(s));
    double complex at[2] = {s + h, s - h}, here = 0.0;
    for (int k = 0; k < 3; ++k) {
        const double complex z = k < 2 ? at[k] : s;
        double complex D[2][2];
        for (int i = 0; i < 2; ++i) {
            for (int j = 0; j < 2; ++j)
                D[i][j] = M[i][j] * z * z + v * C1[i][j] * z + bicycle_gravity * K0[i][j] +
                          v * v * K2[i][j];
        }
        const double complex determinant = D[0][0] * D[1][1] - D[0][1] * D[1][0];
        if (k < 2)
            value[k] = determinant;
        else
            here = determinant;
    }
    return cabs(here / ((value[0] - value[1]) / (2.0 * h)));
}

static void eigenvalues_over_speed(void **state)
{
    (void)state;
    mbsr_model *m = bicycle_make();
    mbsr_data *d;
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    for (int speed = 0; speed <= 10; ++speed) {
        double q[BICYCLE_RATES], u[BICYCLE_RATES];
        mbsr_linear *l;
        mbsr_linear_info info;
        mbsr_mode mode[64];
        mbsr_error error;
        int count, found = 0;
        bicycle_ride(speed, q, u);
        assert_ok(mbsr_linear_create(m, d, 0.0, q, u, NULL, &l, &error), &error);
        assert_ok(mbsr_linear_get_info(l, &info), NULL);
        assert_int_equal(info.states, 10); /* 9 - 2 places, 3 speeds */
        assert_less(info.acceleration, 1e-9);
        assert_ok(mbsr_linear_modes(l, mode, &count), NULL);
        for (int k = 0; k < count; ++k) {
            if (hypot(mode[k].real, mode[k].imaginary) < 1e-3)
                continue; /* where it stands and heads */
            /* rounding moves a small root by its size over the square: zero is one, too */
            const double size = hypot(mode[k].real, mode[k].imaginary);
            assert_close(distance_to_root(speed, mode[k].real + mode[k].imaginary * I), 0.0,
                         fmax(1e-9, 1e-13 / (size * size)));
            found += mode[k].imaginary > 0.0 ? 2 : 1;
        }
        assert_int_equal(found, 4);
        mbsr_linear_destroy(l);
    }
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

/* Published digits at 5 m/s. */
static void five_metres_a_second(void **state)
{
    (void)state;
    mbsr_model *m = bicycle_make();
    mbsr_data *d;
    double q[BICYCLE_RATES], u[BICYCLE_RATES];
    mbsr_linear *l;
    mbsr_mode mode[64];
    mbsr_error error;
    int count;
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    bicycle_ride(5.0, q, u);
    assert_ok(mbsr_linear_create(m, d, 0.0, q, u, NULL, &l, &error), &error);
    assert_ok(mbsr_linear_modes(l, mode, &count), NULL);
    assert_close(mode[count - 3].real, -0.32286642900409, 1e-10); /* capsize */
    assert_close(mode[count - 2].real, -0.77534188219585, 1e-10); /* weave */
    assert_close(mode[count - 2].imaginary, 4.46486771378823, 1e-10);
    assert_close(mode[count - 1].real, -14.07838969279822, 1e-10); /* castering */
    mbsr_linear_destroy(l);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(eigenvalues_over_speed),
                                       cmocka_unit_test(five_metres_a_second)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
