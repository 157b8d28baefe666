/* The table of small masses tells bodies of one name apart.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"
#include "tree.h"

#include <mbsrank/small_masses.h>

#include <string.h>

static int add(mbsr_model *m, const char *name, int parent, double mass)
{
    static const double x[3] = {1.0, 0.0, 0.0};
    mbsr_body_def body = mbsr_default_body_def();
    int id = -1;
    body.name = name;
    body.parent = parent;
    body.joint = mbsr_joint_prismatic(NULL, NULL, x);
    body.inertia = mbsr_inertia_particle(mass);
    assert_ok(mbsr_model_add_body(m, &body, &id), mbsr_model_error(m));
    const mbsr_force_def spring = mbsr_force_joint_spring(id, 0, 100.0, 20.0, 0.0);
    assert_ok(mbsr_model_add_force(m, &spring, NULL), mbsr_model_error(m));
    return id;
}

static void names_of_several_bodies_have_their_ids(void **state)
{
    (void)state;
    const double q[4] = {0.1, 0.1, 0.1, 0.1}, u[4] = {0.0};
    const char *const long_name = "a name of more than twenty letters";
    mbsr_model *m = NULL;
    mbsr_small_masses *small = NULL;
    mbsr_small_masses_report report;
    mbsr_error error;
    mbsr_small_masses_opt opt = mbsr_default_small_masses_opt();
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    const int first = add(m, "link", MBSR_GROUND, 1e-6), heavy = add(m, long_name, first, 1.0),
              second = add(m, "link", heavy, 1e-6), last = add(m, "tip", second, 1e-6);
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    const mbsr_small_part part[3] = {{first, MBSR_MASS}, {second, MBSR_MASS}, {last, MBSR_MASS}};
    opt.duration = 1.0;
    opt.parts = 3;
    opt.part = part;
    assert_ok(mbsr_small_masses_create(m, &opt, &small, &error), &error);
    assert_ok(mbsr_small_masses_start(small, 0.0, q, u), mbsr_small_masses_error(small));
    assert_ok(mbsr_small_masses_get_report(small, &report), NULL);
    assert_contains(report.text, "link #0|link #2|tip ");
    assert_null(strstr(report.text, "tip #"));
    mbsr_small_masses_destroy(small);
    mbsr_model_destroy(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(names_of_several_bodies_have_their_ids),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
