/* Where steps do not move the time, as where rates grow beyond all bounds, a run ends.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "body.h"

#include <mbsrank/ida.h>

enum { SIZE = 6 };

/* After so long a time steps as short as these are lost in its rounding. The second body is the
 * faster one. */
static void steps_shorter_than_rounding_of_the_time(void **state)
{
    (void)state;
    static const double axis[2][3] = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}};
    const double late = 1e9, q[2] = {0.0, 0.0}, u[2] = {1.0, -2.0};
    double y[SIZE], yp[SIZE], t;
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    mbsr_model *m;
    mbsr_data *data;
    mbsr_ida *ida;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    for (int k = 0; k < 2; ++k)
        test_add_body(m, k - 1, mbsr_joint_prismatic(NULL, NULL, axis[k]),
                      mbsr_inertia_particle(1.0));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_ok(mbsr_data_create(m, &data, NULL), NULL);
    opt.max_step = 1e-8;
    opt.max_steps = 20000;
    assert_ok(mbsr_ida_create(m, data, &opt, &ida, NULL), NULL);
    assert_ok(mbsr_dae_pack(m, data, MBSR_DAE_MOMENTUM, late, q, u, y), mbsr_data_error(data));
    assert_ok(mbsr_dae_consistent(m, data, MBSR_DAE_MOMENTUM, late, y, yp, NULL, NULL),
              mbsr_data_error(data));
    assert_ok(mbsr_ida_start(ida, late, y, yp), mbsr_ida_error(ida));
    assert_refused(mbsr_ida_advance(ida, late + 1.0, NULL, y, yp), mbsr_ida_error(ida),
                   MBSR_ERR_SOLVER, 1, MBSR_NONE, "mbsr_ida_advance: 10000 steps|body 1");
    assert_ok(mbsr_ida_state(ida, &t, y, yp), mbsr_ida_error(ida));
    assert_true(t == late);
    mbsr_ida_destroy(ida);
    mbsr_data_destroy(data);
    mbsr_model_destroy(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(steps_shorter_than_rounding_of_the_time)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
