/* What static modes cost and bring, with mass and without: steps of the driver and errors of the
 * tip of a cantilever under a smooth load, against many normal modes.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"

#include <mbsrank/ida.h>

enum { TIP = 15, MOST = 16, OUTPUTS = 50 };

typedef enum treatment { NORMAL_ONLY, WITH_MASS, MASSLESS, ELASTIC } treatment;

/* Up to 1 N within 1 s. */
static int load(void *user, double t, int n, double *value)
{
    const double pi = 3.14159265358979323846;
    (void)user;
    for (int k = 0; k < n; ++k) value[k] = 0.0;
    value[4] = t < 1.0 ? 0.5 * (1.0 - cos(pi * t)) : 1.0;
    return MBSR_OK;
}

static mbsr_flex *beam(int modes, treatment how)
{
    static const int tip = TIP;
    mbsr_beam_def def = mbsr_default_beam_def();
    mbsr_flex *flex;
    mbsr_error error;
    def.length = def.density = def.EI_z = 1.0;
    def.modes = modes;
    def.damping = 0.002;
    if (how != NORMAL_ONLY) def.loaded = 1, def.node = &tip;
    if (how == WITH_MASS) def.cutoff = INFINITY;
    assert_ok(mbsr_flex_beam(&def, &flex, &error), &error);
    if (how != ELASTIC) return flex;
    /* the same without damping of the massless modes: index 2 */
    mbsr_flex_def data;
    mbsr_flex *elastic;
    double D[MOST * MOST] = {0.0};
    assert_int_equal(mbsr_flex_definition(flex, &data), MBSR_OK);
    for (int k = 0; k < modes; ++k) D[k * (data.modes + 1)] = data.D[k * (data.modes + 1)];
    data.D = D;
    assert_ok(mbsr_flex_create(&data, &elastic, &error), &error);
    mbsr_flex_destroy(flex);
    return elastic;
}

/* Tip deflections at t = 0.2, 0.4, .. 10 from rest; steps. */
static long run(int modes, treatment how, double tolerance, double deflection[OUTPUTS])
{
    mbsr_flex *flex = beam(modes, how);
    mbsr_model *m;
    mbsr_data *d;
    mbsr_ida *ida;
    mbsr_error error;
    mbsr_ida_stats stats;
    mbsr_consistent_info start;
    mbsr_flexible_def def = mbsr_default_flexible_def();
    int body, tip;
    assert_ok(mbsr_model_create(NULL, &m, &error), &error);
    def.flex = flex;
    assert_ok(mbsr_model_add_flexible(m, &def, &body), mbsr_model_error(m));
    assert_ok(mbsr_model_add_marker(m, body, TIP, NULL, &tip), mbsr_model_error(m));
    mbsr_force_def push = mbsr_force_wrench(tip, NULL, 0, load, NULL);
    assert_ok(mbsr_model_add_force(m, &push, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_ok(mbsr_data_create(m, &d, &error), &error);

    double zero[MOST] = {0.0}, y[3 * MOST], yp[3 * MOST] = {0.0}, t, pose[12];
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.rtol = opt.atol = tolerance;
    const mbsr_error *e = mbsr_data_error(d);
    assert_in_range(mbsr_model_nu(m), modes, MOST);
    assert_ok(mbsr_dae_pack(m, d, MBSR_DAE_MOMENTUM, 0.0, zero, zero, y), e);
    assert_ok(mbsr_dae_consistent(m, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, &start), e);
    assert_ok(mbsr_ida_create(m, d, &opt, &ida, &error), &error);
    assert_ok(mbsr_ida_start(ida, 0.0, y, yp), mbsr_ida_error(ida));
    for (int k = 0; k < OUTPUTS; ++k) {
        assert_ok(mbsr_ida_advance(ida, 0.2 * (k + 1), &t, y, yp), mbsr_ida_error(ida));
        assert_ok(mbsr_stage_positions(m, d, t, y), e);
        assert_ok(mbsr_body_pose(m, d, tip, pose), e);
        deflection[k] = pose[MBSR_POSE_X + 1];
    }
    mbsr_ida_get_stats(ida, &stats);
    mbsr_ida_destroy(ida);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
    mbsr_flex_destroy(flex);
    return stats.steps;
}

static double distance(const double *x, const double *reference)
{
    double largest = 0.0, size = 0.0;
    for (int k = 0; k < OUTPUTS; ++k) {
        largest = fmax(largest, fabs(x[k] - reference[k]));
        size = fmax(size, fabs(reference[k]));
    }
    return largest / size;
}

static void massless_static_modes_cost_no_steps(void **state)
{
    (void)state;
    static const char *const name[] = {"normal only", "with mass", "massless", "elastic"};
    double reference[OUTPUTS], x[OUTPUTS];
    run(12, MASSLESS, 1e-9, reference);
    for (int modes = 1; modes <= 3; ++modes) {
        long steps[4];
        double error[4];
        for (int how = NORMAL_ONLY; how <= ELASTIC; ++how) {
            steps[how] = run(modes, (treatment)how, 1e-6, x);
            /* at a tolerance at which the error is that of the modes */
            if (how != WITH_MASS) run(modes, (treatment)how, 1e-8, x);
            error[how] = distance(x, reference);
            print_message("%d modes, %-11s: %5ld steps, error %.1e\n", modes, name[how], steps[how],
                          error[how]);
        }
        assert_less((double)steps[MASSLESS], 1.2 * (double)steps[NORMAL_ONLY]);
        assert_less((double)steps[ELASTIC], 1.2 * (double)steps[NORMAL_ONLY]);
        assert_less(1.5 * (double)steps[MASSLESS], (double)steps[WITH_MASS]);
        assert_less(50.0 * error[MASSLESS], error[NORMAL_ONLY]);
        assert_less(50.0 * error[ELASTIC], error[NORMAL_ONLY]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(massless_static_modes_cost_no_steps),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
