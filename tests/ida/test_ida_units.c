/* The same motion in other units takes the same steps.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"

#include <mbsrank/ida.h>

#include <ida/ida.h>

enum { RODS = 4, SIZE = 3 * RODS };

/* m, kg, s in units of a system. */
typedef struct units {
    const char *name;
    double length, mass, time;
} units;

static const units systems[] = {{"m, kg, s", 1.0, 1.0, 1.0},
                                {"mm, t, s", 1e3, 1e-3, 1.0},
                                {"mm, g, ms", 1e3, 1e3, 1e3},
                                {"m, kg, ks", 1.0, 1.0, 1e-3}};
enum { SYSTEMS = sizeof systems / sizeof systems[0] };

/* A sledge that carries rods on springs, the second without mass; or nothing but a pendulum that hangs at rest. */
static mbsr_model *make(const units *in, int hangs)
{
    const double L = in->length, M = in->mass, T = in->time, torque = M * L * L / (T * T);
    const double com[2] = {0.1 * L, 0.0}, down[2] = {0.0, -0.1 * L};
    const mbsr_planar_frame here = {0.0, 0.0, 0.0}, tip = {0.2 * L, 0.0, 0.0};
    mbsr_model *m = NULL;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    for (int k = 0; k < (hangs ? 1 : RODS); ++k) {
        mbsr_body_def body = mbsr_default_body_def();
        body.parent = k - 1;
        body.joint = k == 0 && !hangs ? mbsr_joint_planar_prismatic(here, here)
                                      : mbsr_joint_planar_revolute(k > 1 ? tip : here, here);
        body.inertia = k == 2 ? mbsr_inertia_zero()
                              : mbsr_inertia_planar(0.5 * M, hangs ? down : com, 2e-3 * M * L * L);
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
        const double unit = k == 0 ? M / (T * T) : torque;
        const mbsr_force_def spring =
            mbsr_force_joint_spring(k, 0, 30.0 * unit, 0.3 * unit * T, 0.0);
        if (!hangs) assert_ok(mbsr_model_add_force(m, &spring, NULL), mbsr_model_error(m));
    }
    const mbsr_force_def gravity = mbsr_force_gravity(0.0, -9.81 * L / (T * T), 0.0);
    assert_ok(mbsr_model_add_force(m, &gravity, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    return m;
}

typedef struct outcome {
    long steps, residuals;
    double first, angle; /* s, the first step; rad, at the end */
} outcome;

static outcome run(const units *in, int hangs, mbsr_dae_form form, mbsr_ida_solver solver)
{
    const double L = in->length, T = in->time;
    double q[RODS] = {0.05 * L, 0.3, -0.2, 0.1}, u[RODS] = {0.4 * L / T, 1.0 / T, 0.0, -2.0 / T};
    if (hangs) q[0] = u[0] = 0.0;
    double y[SIZE], yp[SIZE];
    outcome o = {0};
    mbsr_model *m = make(in, hangs);
    mbsr_data *d = NULL;
    mbsr_ida *ida = NULL;
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.form = form;
    opt.linear_solver = solver;
    opt.atol_angle = 1e-6;
    opt.atol_length = 1e-6 * L;
    opt.atol_angular_velocity = 1e-6 / T;
    opt.atol_velocity = 1e-6 * L / T;
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    assert_ok(mbsr_dae_pack(m, d, form, 0.0, q, u, y), mbsr_data_error(d));
    assert_ok(mbsr_dae_consistent(m, d, form, 0.0, y, yp, NULL, NULL), mbsr_data_error(d));
    assert_ok(mbsr_ida_create(m, d, &opt, &ida, NULL), NULL);
    assert_ok(mbsr_ida_start(ida, 0.0, y, yp), mbsr_ida_error(ida));
    assert_ok(mbsr_ida_advance(ida, 1.0 * T, NULL, y, NULL), mbsr_ida_error(ida));
    assert_int_equal(IDAGetActualInitStep(mbsr_ida_memory(ida), &o.first), IDA_SUCCESS);
    mbsr_ida_stats stats;
    assert_int_equal(mbsr_ida_get_stats(ida, &stats), MBSR_OK);
    o.steps = stats.steps;
    o.residuals = stats.residuals;
    o.first /= T;
    o.angle = y[hangs ? 0 : 1];
    mbsr_ida_destroy(ida);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
    return o;
}

static void steps_do_not_depend_on_units(void **state)
{
    (void)state;
    static const struct {
        mbsr_dae_form form;
        mbsr_ida_solver solver;
    } way[] = {{MBSR_DAE_MOMENTUM, MBSR_IDA_TREE},
               {MBSR_DAE_MOMENTUM, MBSR_IDA_DENSE},
               {MBSR_DAE_INDEX1, MBSR_IDA_DENSE},
               {MBSR_DAE_RECURSIVE, MBSR_IDA_DENSE}};
    for (size_t w = 0; w < sizeof way / sizeof way[0]; ++w) {
        for (int hangs = 0; hangs < 2; ++hangs) {
            outcome si = {0};
            for (int s = 0; s < SYSTEMS; ++s) {
                const outcome o = run(systems + s, hangs, way[w].form, way[w].solver);
                print_message("%s: first step %.6g s, %ld steps, %ld residuals, angle %.8f\n",
                              systems[s].name, o.first, o.steps, o.residuals, o.angle);
                if (s == 0) si = o;
                assert_close(o.first / si.first, 1.0, 1e-6);
                assert_close(o.angle, si.angle, 1e-7);
                assert_close((double)o.steps / (double)si.steps, 1.0, 0.03);
            }
            if (hangs) assert_close(si.first, 1e-3, 1e-12);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(steps_do_not_depend_on_units)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
