/* Functions of the caller's give a number that is not finite at each of their calls while a rest, a
 * trim, linear equations or modes are found: that is said, or the numbers are finite.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "acts.h"
#include "duration.h"
#include "expect.h"

#include <mbsrank/linear.h>

#include <string.h>

#define PART(k) (scene.out + (size_t)(k)*TEST_ACTS_PART)

enum { SIZE = TEST_ACTS_PARTS * TEST_ACTS_PART };

static const double odd[] = {NAN, INFINITY, -INFINITY, 1e300};

static test_acts_scene scene;
static mbsr_parameters *list;
static double rest[TEST_ACTS_MOST]; /* an equilibrium */

static int rests(void)
{
    return mbsr_equilibrium(scene.model, scene.data, 0.0, scene.q, NULL, PART(0), PART(1), NULL,
                            NULL);
}

static int is_trimmed(void)
{
    const int which = mbsr_parameters_find(list, "forces.force0.rest");
    mbsr_trim_opt opt = mbsr_default_trim_opt();
    opt.held = 1, opt.hold = (const int[]){0};
    return mbsr_trim(list, 0.0, rest, 1, &which, &opt, PART(0), PART(1), NULL, NULL);
}

/* A parameter is the input, a coordinate the output. */
static int is_linear(void)
{
    mbsr_signal signal[2];
    mbsr_mode mode[TEST_ACTS_MOST];
    mbsr_linear_opt opt = mbsr_default_linear_opt();
    mbsr_linear *l = NULL;
    int count = 0;
    int status = mbsr_signal_find(scene.model, list, "forces.force0.stiffness", signal, NULL);
    if (!status) status = mbsr_signal_find(scene.model, list, "bodies.body1.q", signal + 1, NULL);
    opt.inputs = opt.outputs = 1;
    opt.input = signal, opt.output = signal + 1, opt.list = list;
    if (!status)
        status = mbsr_linear_create(scene.model, scene.data, 0.0, rest, NULL, &opt, &l, NULL);
    if (!status) status = mbsr_linear_modes(l, mode, &count);
    for (int k = 0; k < count && !status; ++k)
        PART(4)[2 * k] = mode[k].real, PART(4)[2 * k + 1] = mode[k].imaginary;
    if (!status) status = mbsr_linear_response(l, 1.0, PART(2), PART(3));
    mbsr_linear_destroy(l);
    return status;
}

static int has_modes(void)
{
    mbsr_near_opt opt = mbsr_default_near_opt();
    mbsr_mode mode[2];
    int found = 0;
    opt.count = 2;
    const int status = mbsr_modes_near(scene.model, scene.data, 0.0, rest, &opt, mode, &found,
                                       PART(0), PART(1), NULL);
    for (int k = 0; k < found && !status; ++k)
        PART(4)[2 * k] = mode[k].real, PART(4)[2 * k + 1] = mode[k].imaginary;
    return status;
}

static int act(int (*call)(void))
{
    memset(scene.out, 0, sizeof scene.out);
    test_acts_of.asked = 0;
    return call();
}

/* The first calls, then ever fewer of them. */
static int each(const char *what, int (*call)(void))
{
    static double good[SIZE];
    if (act(call) != MBSR_OK) return 0;
    memcpy(good, scene.out, sizeof good);
    const long calls = test_acts_of.asked;
    for (long k = 1; k <= calls; k += 1 + (test_long() ? k / 4 : 2 * k)) {
        test_acts_of.fail_at = k, test_acts_of.gives = odd[k % 4];
        const int status = act(call);
        for (int l = 0; l < SIZE && status == MBSR_OK; ++l)
            if (!isfinite(scene.out[l]) && isfinite(good[l]))
                fail_msg("%s: call %ld is not finite, nor is number %d", what, k, l);
    }
    test_acts_of.fail_at = 0;
    assert_int_equal(act(call), MBSR_OK);
    assert_memory_equal(good, scene.out, sizeof good);
    return 1;
}

static void of_linkages(void **state)
{
    (void)state;
    int acts = 0;
    test_acts_of.with = 0;
    for (int k = 0; k < (test_long() ? 8 : 4); ++k) {
        test_acts_make(&scene, k & 1, (test_acts_slider)(k / 2));
        assert_ok(mbsr_parameters_create(scene.model, &list, NULL), mbsr_model_error(scene.model));
        memcpy(rest, scene.q, sizeof rest);
        (void)mbsr_equilibrium(scene.model, scene.data, 0.0, scene.q, NULL, rest, NULL, NULL, NULL);
        acts += each("rests", rests) + each("is trimmed", is_trimmed);
        acts += each("is linear", is_linear) + each("has modes", has_modes);
        mbsr_parameters_destroy(list);
        mbsr_data_destroy(scene.data);
        mbsr_model_destroy(scene.model);
    }
    assert_in_range(acts, 4, 32);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(of_linkages)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
