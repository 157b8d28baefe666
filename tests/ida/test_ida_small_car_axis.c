/* The report on small masses of the car axis: its wheels without mass.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "car_axis.h"
#include "small_study.h"

static void wheels_without_mass(void **unused)
{
    (void)unused;
    static const mbsr_small_part wheels[2] = {{1, MBSR_MASS}, {2, MBSR_MASS}};
    const int count = test_long() ? TELLINGS : 2;
    for (const telling *how = tellings; how < tellings + count; ++how) {
        const double q[2] = {L0, 0.0}, u[2] = {0.0, how->relative ? -OMEGA * R / L : 0.0};
        for (int e = -2; e >= (test_long() ? -4 : -3); --e) {
            mbsr_model *m = car_axis(pow(10.0, e), how);
            study s = study_of(m, 3.0, 1.0 / OMEGA);
            s.opt.part = wheels;
            s.opt.parts = 2;
            s.q = q;
            s.u = u;
            study_check(how->relative ? "car axis, relative" : "car axis", pow(10.0, e), &s);
            mbsr_model_destroy(m);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(wheels_without_mass),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
