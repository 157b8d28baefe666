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

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(light_bodies_in_a_row_are_all_found),
                                       cmocka_unit_test(bodies_of_one_size_are_not)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
