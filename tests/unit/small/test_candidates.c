/* Which masses are looked at where none are named.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"

#include <mbsrank/small_masses.h>

#include <stdbool.h>

enum { MOST = 8 };

static int add(mbsr_model *m, int parent, double mass)
{
    static const double x[3] = {1.0, 0.0, 0.0};
    mbsr_body_def body = mbsr_default_body_def();
    int id = MBSR_NONE;
    body.parent = parent;
    body.joint = mbsr_joint_prismatic(NULL, NULL, x);
    body.inertia = mbsr_inertia_particle(mass);
    assert_ok(mbsr_model_add_body(m, &body, &id), mbsr_model_error(m));
    const mbsr_force_def spring = mbsr_force_joint_spring(id, 0, 100.0, 20.0, 0.0);
    assert_ok(mbsr_model_add_force(m, &spring, NULL), mbsr_model_error(m));
    return id;
}

/* Of carts on each other, or each on the ground with springs between neighbours. */
static void compare(int count, const double *mass, const bool *found, bool on_ground)
{
    double q[MOST] = {0.0};
    mbsr_model *m = NULL;
    mbsr_small_masses *small = NULL;
    mbsr_small_masses_report report;
    mbsr_error error;
    mbsr_small_masses_opt opt = mbsr_default_small_masses_opt();
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    for (int k = 0; k < count; ++k) {
        add(m, on_ground ? MBSR_GROUND : k - 1, mass[k]);
        const double none[3] = {0.0};
        const mbsr_force_def spring = mbsr_force_point_spring(k, none, k - 1, none, 50.0, 1.0, 0.0);
        if (on_ground && k > 0)
            assert_ok(mbsr_model_add_force(m, &spring, NULL), mbsr_model_error(m));
        q[k] = on_ground ? 0.1 * (k + 1) : 0.1;
    }
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    opt.duration = 1.0;
    assert_ok(mbsr_small_masses_create(m, &opt, &small, &error), &error);
    assert_ok(mbsr_small_masses_start(small, 0.0, q, (double[MOST]){0.0}),
              mbsr_small_masses_error(small));
    assert_ok(mbsr_small_masses_get_report(small, &report), NULL);
    for (int k = 0; k < count; ++k) {
        bool listed = false;
        for (int l = 0; l < report.masses; ++l) listed = listed || report.mass[l].body == k;
        assert_int_equal(listed, found[k]);
    }
    mbsr_small_masses_destroy(small);
    mbsr_model_destroy(m);
}

/* Only the outer ones stand beside a heavy body. */
static void light_bodies_in_a_row_are_all_found(void **state)
{
    (void)state;
    const double mass[6] = {10.0, 2e-3, 1e-3, 3e-3, 1e-3, 8.0};
    const bool found[6] = {false, true, true, true, true, false};
    for (int on_ground = 0; on_ground < 2; ++on_ground) compare(6, mass, found, on_ground == 1);
}

/* A chain of links of one weight, and masses that fall off slowly, are not small. */
static void bodies_of_one_size_are_not(void **state)
{
    (void)state;
    const double equal[5] = {1e-3, 1e-3, 1e-3, 1e-3, 1e-3}, falling[5] = {16.0, 8.0, 4.0, 2.0, 1.0};
    const bool none[5] = {false};
    for (int on_ground = 0; on_ground < 2; ++on_ground) {
        compare(5, equal, none, on_ground == 1);
        compare(5, falling, none, on_ground == 1);
    }
}

/* A wheel of 1 g and 1e-5 kg m^2 that turns on a cart of 10 kg, by its matrix: small in all units.
 */
static void a_matrix_is_as_small_in_all_units(void **state)
{
    (void)state;
    for (double unit = 1.0; unit < 1e4; unit *= 1000.0) {
        const double square = unit * unit,
                     matrix[9] = {1e-3, 0.0, 0.0, 0.0, 1e-3, 0.0, 0.0, 0.0, 1e-5 * square};
        mbsr_model *m = NULL;
        mbsr_small_masses *small = NULL;
        mbsr_small_masses_report report;
        mbsr_error error;
        mbsr_small_masses_opt opt = mbsr_default_small_masses_opt();
        mbsr_body_def cart = mbsr_default_body_def(), wheel = cart;
        assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
        cart.joint = mbsr_joint_planar_prismatic((mbsr_planar_frame){0}, (mbsr_planar_frame){0});
        cart.inertia = mbsr_inertia_planar(10.0, (const double[2]){0.0, 0.0}, 0.1 * square);
        assert_ok(mbsr_model_add_body(m, &cart, NULL), mbsr_model_error(m));
        wheel.parent = 0;
        wheel.joint = mbsr_joint_planar_revolute((mbsr_planar_frame){.x = 0.3 * unit},
                                                 (mbsr_planar_frame){0});
        wheel.inertia = mbsr_inertia_matrix(3, matrix);
        assert_ok(mbsr_model_add_body(m, &wheel, NULL), mbsr_model_error(m));
        const mbsr_force_def spring[2] = {
            mbsr_force_joint_spring(0, 0, 100.0, 20.0, 0.0),
            mbsr_force_joint_spring(1, 0, 3.0 * square, 0.1 * square, 0.0)};
        for (int k = 0; k < 2; ++k)
            assert_ok(mbsr_model_add_force(m, spring + k, NULL), mbsr_model_error(m));
        assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
        opt.duration = 1.0;
        assert_ok(mbsr_small_masses_create(m, &opt, &small, &error), &error);
        assert_ok(
            mbsr_small_masses_start(small, 0.0, (double[2]){0.1 * unit, 0.1}, (double[2]){0.0}),
            mbsr_small_masses_error(small));
        assert_ok(mbsr_small_masses_get_report(small, &report), NULL);
        assert_int_equal(report.masses, 1);
        assert_int_equal(report.mass[0].body, 1);
        mbsr_small_masses_destroy(small);
        mbsr_model_destroy(m);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(light_bodies_in_a_row_are_all_found),
                                       cmocka_unit_test(bodies_of_one_size_are_not),
                                       cmocka_unit_test(a_matrix_is_as_small_in_all_units)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
