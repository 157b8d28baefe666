/* Functions of the caller's give a number that is not finite at each of their calls in a run: the
 * run says so, or its numbers are finite.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "acts.h"
#include "duration.h"
#include "expect.h"

#include <mbsrank/driver.h>
#include <mbsrank/ida.h>
#include <mbsrank/sensitivity.h>
#include <mbsrank/simulation.h>

#include <string.h>

#define PART(k) (scene.out + (size_t)(k)*TEST_ACTS_PART)

enum { SIZE = TEST_ACTS_PARTS * TEST_ACTS_PART };

static test_acts_scene scene;

static const double until = 0.005, odd[] = {NAN, INFINITY, -INFINITY, 1e300};

/* Calls of the functions that these runs have besides. */
static long asked, odd_at;

static double give(double x)
{
    return ++asked == odd_at ? NAN : x;
}

static int passes(void *user, double t, const double *y, const double *yp, double *g)
{
    (void)user, (void)yp;
    g[0] = give(t - 0.4 * until), g[1] = y[0] - 1e3;
    return 0;
}

static int kink(void *user, double t, int direction, mbsr_kink *next)
{
    (void)user;
    const double at = 0.6 * until;
    next->t = give(direction > 0 ? (t < at ? at : INFINITY) : (t > at ? at : -INFINITY));
    return 0;
}

/* ---- acts ---- */

static int run(const mbsr_ida_opt *opt)
{
    mbsr_ida *ida = NULL;
    double y[TEST_ACTS_MOST], yp[TEST_ACTS_MOST], t = 0.0;
    int status = mbsr_dae_pack(scene.model, scene.data, opt->form, 0.0, scene.q, scene.u, y);
    if (!status)
        status = mbsr_dae_consistent(scene.model, scene.data, opt->form, 0.0, y, yp, NULL, NULL);
    if (!status) status = mbsr_ida_create(scene.model, scene.data, opt, &ida, NULL);
    if (!status) status = mbsr_ida_start(ida, 0.0, y, yp);
    if (!status) status = mbsr_ida_advance(ida, until, &t, y, yp);
    if (status == MBSR_EVENT) status = mbsr_ida_jump(ida);
    if (!status) status = mbsr_ida_advance(ida, until, &t, y, yp);
    if (!status) status = mbsr_ida_state(ida, &t, PART(0), PART(1));
    if (!status) status = mbsr_ida_motion(ida, NULL, PART(2), NULL, NULL);
    mbsr_ida_destroy(ida);
    return status;
}

static int runs(void)
{
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.events = 2, opt.event = passes, opt.kink = kink;
    return run(&opt);
}

static int runs_in_index1(void)
{
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    mbsr_index1_reset(scene.model, scene.data);
    opt.form = MBSR_DAE_INDEX1;
    return run(&opt);
}

static int is_sensitive(void)
{
    const double time[2] = {0.5 * until, until};
    mbsr_parameters *list = NULL;
    mbsr_sensitivity *s = NULL;
    mbsr_sensitivity_opt opt = mbsr_default_sensitivity_opt();
    int status = mbsr_parameters_create(scene.model, &list, NULL);
    const int which = mbsr_parameters_find(list, "bodies.body1.mass");
    opt.list = list, opt.parameters = 1, opt.which = &which;
    if (!status) status = mbsr_sensitivity_create(scene.model, &opt, &s, NULL);
    if (!status) status = mbsr_sensitivity_run(s, 0.0, scene.q, scene.u, 2, time, PART(0), PART(1));
    if (!status) status = mbsr_sensitivity_forward(s, PART(2), PART(3));
    if (!status) status = mbsr_sensitivity_adjoint(s, PART(0), PART(1), PART(4));
    mbsr_sensitivity_destroy(s);
    mbsr_parameters_destroy(list);
    return status;
}

static int is_simulated(void)
{
    mbsr_simulation s = mbsr_simulation_of(scene.model);
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

/* ---- each call ---- */

static int act(int (*call)(void))
{
    memset(scene.out, 0, sizeof scene.out);
    asked = test_acts_of.asked = 0;
    return call();
}

static void stays_finite(const char *what, int (*call)(void), long at)
{
    const int status = act(call);
    for (int k = 0; k < SIZE && status == MBSR_OK; ++k)
        if (!isfinite(scene.out[k])) fail_msg("%s: call %ld: number %d", what, at, k);
}

static void each(const char *what, int (*call)(void))
{
    static double good[SIZE];
    if (act(call) != MBSR_OK) return;
    memcpy(good, scene.out, sizeof good);
    const long calls = test_acts_of.asked, own = asked;
    for (long k = 1; k <= calls; k += 1 + (test_long() ? k / 4 : 2 * k)) {
        test_acts_of.fail_at = k, test_acts_of.gives = odd[k % 4];
        stays_finite(what, call, k);
    }
    test_acts_of.fail_at = 0;
    for (odd_at = 1; odd_at <= own; odd_at += 1 + odd_at / 2) {
        if (act(call) == MBSR_OK) fail_msg("%s: no word of call %ld", what, odd_at);
    }
    odd_at = 0;
    assert_int_equal(act(call), MBSR_OK);
    assert_memory_equal(good, scene.out, sizeof good);
}

static void of_linkages(void **state)
{
    (void)state;
    test_acts_of.with = 0;
    for (int k = 0; k < (test_long() ? 6 : 4); ++k) {
        test_acts_make(&scene, k & 1, (test_acts_slider)(k / 2));
        each("runs", runs);
        each("runs in index 1", runs_in_index1);
        each("is sensitive", is_sensitive);
        each("is simulated", is_simulated);
        mbsr_data_destroy(scene.data);
        mbsr_model_destroy(scene.model);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(of_linkages)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
