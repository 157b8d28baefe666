/* Equilibria, trim, linear equations and modes, where each place of the core and of the component
 * linear at which a status is taken fails.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "acts.h"
#include "faults.h"
#include "../linear/build.h"

#include <mbsrank/linear.h>

#include <string.h>

#define PART(k) (scene.out + (size_t)(k)*TEST_ACTS_PART)

static test_acts_scene scene;
static long failed;
static mbsr_parameters *list;
static double rest[TEST_ACTS_MOST]; /* an equilibrium */

static int rests(void *user)
{
    (void)user;
    return mbsr_equilibrium(scene.model, scene.data, 0.0, scene.q, NULL, PART(0), PART(1), NULL,
                            NULL);
}

static int is_trimmed(void *user)
{
    const int which = mbsr_parameters_find(list, "forces.force0.rest");
    mbsr_trim_opt opt = mbsr_default_trim_opt();
    (void)user;
    opt.held = 1, opt.hold = (const int[]){0};
    return mbsr_trim(list, 0.0, rest, 1, &which, &opt, PART(0), PART(1), NULL, NULL);
}

static int is_linear(void *user)
{
    static const char *const names[] = {
        "bodies.body0.tau", "forces.force0.stiffness", "bodies.body3.motion", "bodies.body1.mass",
        "bodies.body1.q",   "bodies.body2.u",          "bodies.body4.x",      "forces.force0.tau"};
    enum { INPUTS = 4, SIGNALS = sizeof names / sizeof *names };
    mbsr_signal signal[SIGNALS];
    mbsr_mode mode[TEST_ACTS_MOST];
    mbsr_linear_opt opt = mbsr_default_linear_opt();
    mbsr_linear *l = NULL;
    int count, status = MBSR_OK;
    (void)user;
    for (int k = 0; k < SIGNALS && !status; ++k)
        status = mbsr_signal_find(scene.model, list, names[k], signal + k, NULL);
    opt.inputs = INPUTS, opt.outputs = SIGNALS - INPUTS;
    opt.input = signal, opt.output = signal + INPUTS, opt.list = list;
    if (!status)
        status = mbsr_linear_create(scene.model, scene.data, 0.0, rest, NULL, &opt, &l, NULL);
    if (!status) status = mbsr_linear_modes(l, mode, &count);
    if (!status) status = mbsr_linear_shape(l, 0, PART(0), PART(1));
    if (!status) status = mbsr_linear_response(l, 1.0, PART(2), PART(3));
    mbsr_linear_destroy(l);
    return status;
}

static int has_modes(void *user)
{
    mbsr_near_opt opt = mbsr_default_near_opt();
    mbsr_mode mode[2];
    int found = 0;
    (void)user;
    opt.count = 2;
    int status = mbsr_modes_near(scene.model, scene.data, 0.0, rest, &opt, mode, &found, PART(0),
                                 PART(1), NULL);
    memset(scene.out, 0, sizeof scene.out);
    if (!status && found > 0) PART(0)[0] = mode[0].imaginary;
    return status;
}

static int takes_part(void *user)
{
    const mbsr_mode mode = {.frequency = 1.0};
    (void)user;
    return mbsr_mode_participation(scene.model, scene.data, 0.0, rest, &mode, scene.y, scene.yp,
                                   PART(0), PART(1), PART(2), NULL);
}

static void each(const char *name, int (*call)(void *user))
{
    const test_faults_act act = {name, call, NULL, scene.out, sizeof scene.out / sizeof(double),
                                 1e-6, 1};
    failed += test_faults_each(&act);
}

static void of_linkages(void **state)
{
    (void)state;
    for (int k = 0; k < 8; ++k) {
        test_acts_make(&scene, k & 1, (test_acts_slider)(k / 2));
        assert_ok(mbsr_parameters_create(scene.model, &list, NULL), mbsr_model_error(scene.model));
        memcpy(rest, scene.q, sizeof rest);
        (void)mbsr_equilibrium(scene.model, scene.data, 0.0, scene.q, NULL, rest, NULL, NULL, NULL);
        each("rests", rests);
        each("is trimmed", is_trimmed);
        each("is linear", is_linear);
        each("has modes", has_modes);
        each("takes part", takes_part);
        mbsr_parameters_destroy(list);
        mbsr_data_destroy(scene.data);
        mbsr_model_destroy(scene.model);
    }
}

/* Particles and nodes without mass on springs. */
static void of_a_string(void **state)
{
    enum { NODES = 6 };
    static const double zero[NODES] = {0.0};
    (void)state;
    mbsr_model *m = empty();
    add_string(m, NODES, 0.7, 120.0);
    for (int k = 0; k < NODES; k += 2) add_force(m, mbsr_force_joint_spring(k, 0, 0.0, 1.0, 0.0));
    mbsr_data *d = finish(m);
    assert_ok(mbsr_equilibrium(m, d, 0.0, zero, NULL, rest, NULL, NULL, NULL), mbsr_data_error(d));
    assert_true(test_acts_take(&scene, m, d, 0.0, rest, zero));
    for (int k = 0; k < NODES; ++k) scene.y[k] = 0.1 * k, scene.yp[k] = 0.2;
    each("rests", rests);
    each("has modes", has_modes);
    each("takes part", takes_part);
    free_both(m, d);
    assert_in_range(failed, 100, 100000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(of_linkages),
                                       cmocka_unit_test(of_a_string)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
