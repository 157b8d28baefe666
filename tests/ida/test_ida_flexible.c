/* Runs with flexible bodies against digits of independent programs (DOP853 at 1e-12).
 * SPDX-License-Identifier: BSD-3-Clause */
#include "flexible.h"

#include "duration.h"
#include "expect.h"

#include <mbsrank/ida.h>

#include <string.h>

/* From w->q, w->u at t = 0 through `count` times; x (count x nq): q there. The steps. */
static long run(const test_flexible *w, double tolerance, int count, const double *times, double *x,
                double *u)
{
    const int nu = mbsr_model_nu(w->model);
    double y[24], yp[24] = {0.0}, t;
    mbsr_error error;
    mbsr_consistent_info start;
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    mbsr_ida *ida;
    mbsr_ida_stats stats;
    const mbsr_error *e = mbsr_data_error(w->data);
    assert_ok(mbsr_dae_pack(w->model, w->data, MBSR_DAE_MOMENTUM, 0.0, w->q, w->u, y), e);
    assert_ok(mbsr_dae_consistent(w->model, w->data, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, &start),
              e);
    opt.rtol = opt.atol = tolerance;
    opt.linear_solver = MBSR_IDA_TREE;
    assert_ok(mbsr_ida_create(w->model, w->data, &opt, &ida, &error), &error);
    assert_ok(mbsr_ida_start(ida, 0.0, y, yp), mbsr_ida_error(ida));
    for (int k = 0; k < count; ++k) {
        assert_ok(mbsr_ida_advance(ida, times[k], &t, y, yp), mbsr_ida_error(ida));
        memcpy(x + k * nu, y, (size_t)nu * sizeof *x);
        memcpy(u + k * nu, y + 2 * nu, (size_t)nu * sizeof *u);
    }
    mbsr_ida_get_stats(ida, &stats);
    mbsr_ida_destroy(ida);
    return stats.steps;
}

static void a_pendulum_falls_and_bends(void **state)
{
    (void)state;
    static const double times[3] = {0.25, 0.5, 1.0};
    static const double expected[3][4] = {
        {-0.4565796816, -0.0000584925, -0.0000152478, -3.53564515},
        {-1.6603994921, -0.0010816161, 0.0001565658, -5.25437787},
        {-3.1324277197, -0.0015821338, 0.0003182206, 0.61866007}};
    test_flexible w;
    double x[9], u[9];
    test_flexible_pendulum(&w, 100.0, 0);
    memset(w.q, 0, sizeof w.q);
    memset(w.u, 0, sizeof w.u);
    run(&w, 1e-11, 3, times, x, u);
    for (int k = 0; k < 3; ++k) {
        for (int l = 0; l < 3; ++l) assert_close(x[3 * k + l], expected[k][l], 2e-8);
        assert_close(u[3 * k], expected[k][3], 1e-5);
    }
    test_flexible_free(&w);
}

/* The stiffer, the nearer to a rigid rod: the line from the pin to the tip, after 1 s. */
static void stiff_pendulums_fall_as_rigid_ones(void **state)
{
    (void)state;
    static const double end = 1.0, rigid = -3.133418044829, off[3] = {-2.7e-4, -2.6e-5, -3.2e-6};
    const int count = test_seeds(2, 3);
    for (int k = 0; k < count; ++k) {
        const double EI = (double[3]){1e2, 1e3, 1e4}[k];
        test_flexible w;
        double x[3], u[3];
        test_flexible_pendulum(&w, EI, 0);
        memset(w.q, 0, sizeof w.q);
        memset(w.u, 0, sizeof w.u);
        const long steps = run(&w, k < 2 ? 1e-8 : 1e-9, 1, &end, x, u);
        const double ray = x[0] + atan(x[1] + x[2]) - rigid;
        print_message("EI = %g: %.2e rad from the rigid one, %ld steps\n", EI, ray, steps);
        assert_close(ray, off[k], 0.05 * fabs(off[k]));
        test_flexible_free(&w);
    }
}

static void a_massless_mode_follows_its_loads(void **state)
{
    (void)state;
    static const double end = 0.5;
    static const double expected[4] = {-1.4448731107, 0.0069695151, 0.0355977591, 0.0014206962},
                        rates[3] = {-7.221254383, 0.032596331, -0.631540908};
    static const double tolerance[3] = {1e-6, 1e-8, 1e-10}, off[3] = {5e-5, 1e-6, 2e-8};
    static const long most[3] = {170, 350, 750};
    test_flexible w;
    double x[4], u[4];
    test_flexible_massless(&w);
    for (int k = 0; k < 3; ++k) {
        const long steps = run(&w, tolerance[k], 1, &end, x, u);
        print_message("tolerance %.0e: %ld steps\n", tolerance[k], steps);
        assert_in_range(steps, 10, most[k]);
        for (int l = 0; l < 4; ++l) assert_close(x[l], expected[l], off[k]);
    }
    for (int l = 0; l < 3; ++l) assert_close(u[l], rates[l], 1e-5);
    test_flexible_free(&w);
}

/* A beam that flies free and whose mass is all on its axis: nothing turns it about that. */
static void a_slender_beam_flies(void **state)
{
    (void)state;
    const double q[9] = {1.0}, u[8] = {0.0};
    double y[32], yp[32] = {0.0};
    mbsr_beam_def def = mbsr_default_beam_def();
    mbsr_flexible_def on = mbsr_default_flexible_def();
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    mbsr_flex *flex;
    mbsr_model *m;
    mbsr_data *d;
    mbsr_ida *ida;
    mbsr_error error;
    int body;
    def.length = def.density = def.EI_z = 1.0;
    def.modes = 2;
    assert_ok(mbsr_flex_beam(&def, &flex, &error), &error);
    on.flex = flex;
    on.joint = mbsr_joint_free(NULL, NULL);
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    assert_ok(mbsr_model_add_flexible(m, &on, &body), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    assert_ok(mbsr_dae_pack(m, d, MBSR_DAE_MOMENTUM, 0.0, q, u, y), mbsr_data_error(d));
    assert_ok(mbsr_ida_create(m, d, &opt, &ida, &error), &error);
    assert_int_equal(mbsr_ida_start(ida, 0.0, y, yp), MBSR_UNDETERMINED);
    assert_contains(mbsr_ida_error(ida)->text, "moves no mass|radius_y, radius_z");
    mbsr_ida_destroy(ida);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
    mbsr_flex_destroy(flex);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_pendulum_falls_and_bends),
        cmocka_unit_test(stiff_pendulums_fall_as_rigid_ones),
        cmocka_unit_test(a_massless_mode_follows_its_loads),
        cmocka_unit_test(a_slender_beam_flies),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
