/* Runs of the driver and their derivatives, where each place of the core and of the driver at which
 * a status is taken fails.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "acts.h"
#include "faults.h"

#include <mbsrank/driver.h>
#include <mbsrank/ida.h>
#include <mbsrank/sensitivity.h>
#include <mbsrank/simulation.h>

#include <string.h>

#define PART(k) (scene.out + (size_t)(k)*TEST_ACTS_PART)

static test_acts_scene scene;
static long failed;

static const double until = 0.005;

static int passes(void *user, double t, const double *y, const double *yp, double *g)
{
    (void)user, (void)yp;
    g[0] = t - 0.4 * until, g[1] = y[0] - 1e3;
    return 0;
}

static int handed_out(void *user, int index, double t, const double *y, const double *yp)
{
    (void)user, (void)index, (void)t, (void)yp;
    PART(3)[0] += y[0];
    return 0;
}

static int run(const mbsr_ida_opt *opt)
{
    const int size = mbsr_dae_size(scene.model, opt->form);
    const double times[2] = {0.5 * until, until};
    mbsr_ida *ida = NULL;
    mbsr_ida_drift drift;
    double y[TEST_ACTS_MOST], yp[TEST_ACTS_MOST], t = 0.0, share[4];
    int force[4], count, next = 0, direction[4];
    if (size > TEST_ACTS_MOST) return MBSR_ERR_VALUE;
    mbsr_index1_reset(scene.model, scene.data);
    int status = mbsr_dae_pack(scene.model, scene.data, opt->form, 0.0, scene.q, scene.u, y);
    if (!status)
        status = mbsr_dae_consistent(scene.model, scene.data, opt->form, 0.0, y, yp, NULL, NULL);
    if (!status) status = mbsr_ida_create(scene.model, scene.data, opt, &ida, NULL);
    if (!status) status = mbsr_ida_start(ida, 0.0, y, yp);
    if (!status) status = mbsr_ida_advance(ida, 0.5 * until, &t, y, yp);
    if (status == MBSR_EVENT) status = mbsr_ida_event_info(ida, direction);
    if (!status) status = mbsr_ida_jump(ida);
    if (!status) status = mbsr_ida_run(ida, 2, times, &next, handed_out, NULL);
    if (!status) status = mbsr_ida_state(ida, &t, PART(0), PART(1));
    if (!status) status = mbsr_ida_motion(ida, NULL, PART(2), NULL, NULL);
    if (!status) status = mbsr_ida_dense(ida, t, 0, y);
    if (!status) status = mbsr_ida_get_drift(ida, &drift);
    if (!status) status = mbsr_ida_stiffest(ida, 4, force, share, &count);
    if (!status) status = mbsr_ida_sample(ida, 1.1 * until, &t, y, NULL);
    memset(PART(1), 0, TEST_ACTS_PART * sizeof(double));
    mbsr_ida_destroy(ida);
    return status;
}

static int runs(void *user)
{
    return run(user);
}

static int is_sensitive(void *user)
{
    const double time[2] = {0.5 * until, until};
    mbsr_parameters *list = NULL;
    mbsr_sensitivity *s = NULL;
    mbsr_sensitivity_opt opt = mbsr_default_sensitivity_opt();
    (void)user;
    int status = mbsr_parameters_create(scene.model, &list, NULL);
    const int which[2] = {mbsr_parameters_find(list, "bodies.body1.mass"),
                          mbsr_parameters_find(list, "forces.force0.stiffness")};
    opt.list = list, opt.parameters = 2, opt.which = which;
    if (!status) status = mbsr_sensitivity_create(scene.model, &opt, &s, NULL);
    if (!status) status = mbsr_sensitivity_run(s, 0.0, scene.q, scene.u, 2, time, PART(0), PART(1));
    if (!status) status = mbsr_sensitivity_forward(s, PART(2), PART(3));
    if (!status) status = mbsr_sensitivity_adjoint(s, PART(0), PART(1), PART(4));
    mbsr_sensitivity_destroy(s);
    mbsr_parameters_destroy(list);
    return status;
}

static int is_simulated(void *user)
{
    mbsr_simulation s = mbsr_simulation_of(scene.model);
    (void)user;
    mbsr_simulation_set_rate(&s, 0, 0, 0.5);
    mbsr_simulation_start(&s, NULL, 0.0, scene.q, scene.u);
    mbsr_simulation_to(&s, until);
    mbsr_simulation_accelerations(&s, PART(0));
    if (mbsr_model_rows(scene.model) > 0) mbsr_simulation_reactions(&s, PART(1));
    const int status = s.status;
    if (!status) memcpy(PART(2), s.q, (size_t)scene.nq * sizeof *s.q);
    s.model = NULL;
    mbsr_simulation_end(&s);
    return status;
}

static void each(const char *name, int (*call)(void *user), void *user)
{
    const test_faults_act act = {name, call, user, scene.out, sizeof scene.out / sizeof(double),
                                 1e-3, 1};
    failed += test_faults_each(&act);
}

static void of_linkages(void **state)
{
    (void)state;
    for (int k = 0; k < 6; ++k) {
        mbsr_ida_opt opt = mbsr_default_ida_opt();
        test_acts_make(&scene, k & 1, (test_acts_slider)(k / 2));
        each("runs", runs, &opt);
        opt.events = 2, opt.event = passes;
        opt.linear_solver = MBSR_IDA_KRYLOV;
        each("runs", runs, &opt);
        opt.linear_solver = MBSR_IDA_DENSE;
        opt.max_norm = 1, opt.raw_outputs = 1;
        each("runs", runs, &opt);
        opt = mbsr_default_ida_opt();
        opt.form = MBSR_DAE_INDEX1;
        each("runs", runs, &opt);
        opt.form = MBSR_DAE_RECURSIVE;
        each("runs", runs, &opt);
        each("is sensitive", is_sensitive, NULL);
        each("is simulated", is_simulated, NULL);
        mbsr_data_destroy(scene.data);
        mbsr_model_destroy(scene.model);
    }
    assert_in_range(failed, 100, 100000);
}

/* ---- small masses ---- */

static int is_followed(void *user)
{
    mbsr_small_masses_opt opt = mbsr_default_small_masses_opt();
    mbsr_small_masses *small = NULL;
    mbsr_small_masses_report report;
    mbsr_ida_stats stats;
    (void)user;
    opt.duration = 10.0;
    int status = mbsr_small_masses_create(scene.model, &opt, &small, NULL);
    if (!status) status = mbsr_small_masses_start(small, 0.0, scene.q, scene.u);
    if (!status) status = mbsr_small_masses_smooth(small, 1, PART(0), PART(1));
    if (!status) status = mbsr_small_masses_run(small, NULL, 10.0 * until, &stats, NULL);
    if (!status) status = mbsr_small_masses_get_report(small, &report);
    if (!status) PART(2)[0] = report.directions;
    mbsr_small_masses_destroy(small);
    return status;
}

static void add_slider(mbsr_model *m, int parent, double mass, double stiffness, double damping)
{
    static const double along[3] = {1.0, 0.0, 0.0};
    mbsr_body_def b = mbsr_default_body_def();
    int id;
    b.parent = parent;
    b.joint = mbsr_joint_prismatic(NULL, NULL, along);
    b.inertia = mbsr_inertia_particle(mass);
    assert_ok(mbsr_model_add_body(m, &b, &id), mbsr_model_error(m));
    const mbsr_force_def spring = mbsr_force_joint_spring(id, 0, stiffness, damping, 0.0);
    assert_ok(mbsr_model_add_force(m, &spring, NULL), mbsr_model_error(m));
}

/* A gram between kilograms, with a damper, without one, in a loop. */
static void of_small_masses(void **state)
{
    static const double q[3] = {0.02, 0.01, 0.0}, u[3] = {0.0, 0.0, 0.1};
    (void)state;
    for (int kind = 0; kind < 3; ++kind) {
        mbsr_model *m;
        mbsr_data *d;
        assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
        add_slider(m, MBSR_GROUND, 1.0, 50.0, 0.5);
        add_slider(m, 0, 1e-6, 80.0, kind == 0 ? 4.0 : 0.0);
        add_slider(m, kind == 2 ? MBSR_GROUND : 1, kind == 2 ? 1e-6 : 2.0, 60.0, 0.2);
        const mbsr_closure_def gear = mbsr_closure_coupling(
            2, (const int[]){1, 2}, (const int[]){0, 0}, (const double[]){1.0, -1.0}, 0.01);
        if (kind == 2) assert_ok(mbsr_model_add_closure(m, &gear, NULL), mbsr_model_error(m));
        assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
        assert_ok(mbsr_data_create(m, &d, NULL), NULL);
        assert_true(test_acts_take(&scene, m, d, 0.0, q, u));
        each("is followed", is_followed, NULL);
        mbsr_data_destroy(d);
        mbsr_model_destroy(m);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(of_linkages),
                                       cmocka_unit_test(of_small_masses)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
