/* What is left of the balance of forces along directions without mass: a number to act on, or none.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "body.h"
#include "expect.h"
#include "units.h"

#include <mbsrank/mbsrank.h>
#include <mbsrank/driver.h>

#include <math.h>

/* A cart without mass between two springs, a mass on it behind a third; the free lengths are those
 * of the state but for rounding. damping: N s/m, beside the first. */
static mbsr_model *cart(const units *of, double damping)
{
    const double x[3] = {1.0, 0.0, 0.0}, k = of->mass / (of->time * of->time), L = of->length,
                 I = 0.1 * of->mass * L * L, none[3] = {0.0}, tensor[6] = {I, I, I};
    mbsr_model *m = NULL;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    const int a = test_add_body(m, MBSR_GROUND, mbsr_joint_prismatic(NULL, NULL, x),
                                mbsr_inertia_zero()),
              b = test_add_body(m, a, mbsr_joint_prismatic(NULL, NULL, x),
                                mbsr_inertia_rigid(2.0 * of->mass, none, tensor));
    const mbsr_force_def springs[] = {
        mbsr_force_joint_spring(a, 0, 300.0 * k, damping * k * of->time, (0.3 - 0.2) * L),
        mbsr_force_joint_spring(b, 0, 200.0 * k, 0.0, (1.1 - 0.4) * L),
    };
    for (int l = 0; l < 2; ++l)
        assert_ok(mbsr_model_add_force(m, springs + l, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    return m;
}

/* The share at rest with the cart at `place`; dq of the cart in m of SI. */
static double share_at(const units *of, double damping, double place, int *body, double *step)
{
    mbsr_model *m = cart(of, damping);
    mbsr_data *d = NULL;
    const double q[2] = {place * of->length, 0.7 * of->length}, u[2] = {0.0};
    double y[6], dq[2], du[2], share = -1.0;
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    assert_int_equal(mbsr_dae_size(m, MBSR_DAE_MOMENTUM), 6);
    assert_ok(mbsr_dae_pack(m, d, MBSR_DAE_MOMENTUM, 0.0, q, u, y), mbsr_data_error(d));
    assert_ok(mbsr_dae_imbalance(m, d, MBSR_DAE_MOMENTUM, 0.0, y, &share, body, dq, du),
              mbsr_data_error(d));
    *step = dq[0] / of->length;
    double again = -1.0;
    int same = -2;
    assert_ok(mbsr_dae_imbalance(m, d, MBSR_DAE_MOMENTUM, 0.0, y, &again, &same, NULL, NULL),
              mbsr_data_error(d));
    assert_true(again == share && same == *body);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
    return share;
}

/* 0.3 - 0.2 is not 0.1: forces of 1e-14 N that nothing balances are none. */
static void forces_of_rounding_are_none(void **state)
{
    (void)state;
    for (size_t k = 0; k < sizeof systems / sizeof systems[0]; ++k) {
        int body;
        double step;
        assert_true(share_at(systems + k, 0.0, 0.1, &body, &step) == 0.0);
        assert_int_equal(body, MBSR_NONE);
        assert_close(step, 0.0, 1e-15);
    }
}

static void a_cart_beside_its_place_is_told(void **state)
{
    (void)state;
    static const double off[] = {0.2, -1e-2, 1e-4};
    for (size_t k = 0; k < sizeof systems / sizeof systems[0]; ++k) {
        for (int l = 0; l < 3; ++l) {
            int body;
            double step;
            assert_true(share_at(systems + k, 0.0, 0.1 + off[l], &body, &step) > 0.1);
            assert_int_equal(body, 0);
            assert_close(step, -0.6 * off[l],
                         5e-3 * fabs(off[l])); /* the mass stays: 300 of 500 N/m */
        }
    }
}

/* Newton's step towards the balance, within the time in which the model changes. */
static void steps_are_the_same_in_all_units(void **state)
{
    (void)state;
    double si = 0.0;
    for (size_t k = 0; k < sizeof systems / sizeof systems[0]; ++k) {
        int body;
        double step;
        assert_true(share_at(systems + k, 20.0, 0.13, &body, &step) > 0.1);
        if (k == 0) si = step;
        assert_true(si < -1e-5 && si > -0.02); /* springs alone: -0.03 m */
        assert_close(step / si, 1.0, 1e-9);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(forces_of_rounding_are_none),
                                       cmocka_unit_test(a_cart_beside_its_place_is_told),
                                       cmocka_unit_test(steps_are_the_same_in_all_units)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
