/* Springs that are closures take no rank from rigid rows.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "body.h"

#include <mbsrank/closure.h>
#include <mbsrank/mbsrank.h>

#include <math.h>
#include <stdbool.h>

enum { RATES = 4, SPRINGS = 2 };

/* Two bodies on axes, with a rod and a hinge to the ground, on the axes of which they stand: four
 * of seven rows are independent. Springs of two hinges are closures, or forces. */
static int independent_rows(bool as_closures)
{
    const double half = sqrt(0.5), y[3] = {0, 1, 0}, z[3] = {0, 0, 1},
                 q[RATES] = {atan(1.0), 2.0 * atan(1.0), 0.0, 0.0}, tensor[6] = {0.2, 0.3, 0.2},
                 on_ground[3] = {-0.5, 0.0, 0.5}, on_body[3] = {1.0, -0.5, 0.0};
    const mbsr_frame A0 = {.R = {3.45e-16, 1, 0, -1, 3.45e-16, 0, 0, 0, 1}, .x = {1, 0.5, 1}},
                     B0 = {.R = {1, -4.44e-16, 0, 0, -2.22e-16, -1, 4.44e-16, 1, -2.22e-16},
                           .x = {0.5, 1, -0.5}},
                     A1 = {.R = {-3.45e-16, -1, -1.22e-16, -1, 3.45e-16, 0, 0, 1.22e-16, -1},
                           .x = {0, 1, -0.5}},
                     A2 = {.R = {-3.45e-16, -1, 0, 1, -3.45e-16, 0, 0, 0, 1}, .x = {-1, 0, -0.5}},
                     B2 = {.R = {4.01e-16, half, half, 1, 0, -5.67e-16, -4.01e-16, half, -half},
                           .x = {-2.0, -0.5 - half, 2.0 * half}};
    const mbsr_joint first = mbsr_joint_revolute(&A0, &B0, y),
                     second = mbsr_joint_universal(&A1, NULL, y, z),
                     last = mbsr_joint_revolute(&A2, NULL, z);
    const mbsr_inertia solid = mbsr_inertia_rigid(2.0, NULL, tensor);
    mbsr_closure_report report;
    mbsr_model *m;
    mbsr_data *d;
    int cut, closure;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    test_add_body(m, MBSR_GROUND, first, solid);
    test_add_body(m, 0, second, solid);
    const mbsr_closure_def rod = mbsr_closure_distance(MBSR_GROUND, on_ground, 0, on_body, 2.2088);
    assert_ok(mbsr_model_add_closure(m, &rod, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_add_loop_joint(m, "hinge", MBSR_GROUND, &last, 1, &B2, &closure, &cut),
              mbsr_model_error(m));
    for (int k = 0; k < SPRINGS; ++k) {
        mbsr_force_def spring = k ? mbsr_force_joint_spring(cut, 0, 2.0, 0.0, 0.0)
                                  : mbsr_force_joint_spring(1, 1, 3.0, 3.0, 0.0);
        if (as_closures) spring.as_closure = MBSR_SPRING_LOOSE;
        assert_ok(mbsr_model_add_force(m, &spring, NULL), mbsr_model_error(m));
    }
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    assert_ok(mbsr_closures_report(m, d, 0.0, q, &report, NULL, NULL), mbsr_data_error(d));
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
    return report.independent;
}

static void springs_take_no_rank(void **state)
{
    (void)state;
    const int rigid = independent_rows(false);
    assert_int_equal(independent_rows(true), rigid);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(springs_take_no_rank)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
