/* Closing loops from a guess, and what cannot be closed.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "loops.h"

#include <string.h>

static const double pi = 3.14159265358979323846;

static void four_bar(loops *s, double ground, double crank)
{
    loops_begin(s, NULL);
    const int a = loops_rod(s, "crank", MBSR_GROUND, 0.0, 0.0, 1.0, crank);
    const int b = loops_rod(s, "coupler", a, crank, 0.0, 2.5, 2.5);
    const int c = loops_rod(s, "rocker", MBSR_GROUND, ground, 0.0, 2.0, 2.0);
    loops_pin(s, "pin", b, 2.5, 0.0, c, 2.0, 0.0);
    loops_finish(s);
}

static void one_loop_of_twelve(loops *s)
{
    int last = MBSR_GROUND;
    loops_begin(s, NULL);
    for (int k = 0; k < 12; ++k) last = loops_rod(s, "", last, k > 0 ? 1.0 : 0.0, 0.0, 1.0, 1.0);
    loops_pin(s, "end", last, 1.0, 0.0, MBSR_GROUND, 3.0, 0.5);
    loops_finish(s);
}

/* Any guess is closed, within its tolerance. */
static void random_guesses(void **state)
{
    (void)state;
    for (int model = 0; model < 2; ++model) {
        loops s;
        if (model == 0)
            four_bar(&s, 2.0, 1.0);
        else
            one_loop_of_twelve(&s);
        for (uint64_t seed = 1; seed <= 100; ++seed) {
            test_rng rng = test_seed(seed);
            double g[2], closed[LOOPS_MOST];
            mbsr_assembly_info info;
            test_fill(&rng, s.nq, s.q);
            for (int k = 0; k < s.nq; ++k) s.q[k] *= pi;
            assert_ok(mbsr_assemble(s.m, s.d, 0.0, s.q, NULL, closed, &info), mbsr_data_error(s.d));
            assert_ok(mbsr_positions(s.m, s.d, 0.0, closed), NULL);
            assert_ok(mbsr_closures_gap(s.m, s.d, g), NULL);
            assert_less(test_largest(2, g), 1e-10);
            assert_true(info.iterations <= 50);
            assert_int_equal(info.closure, MBSR_NONE);
        }
        loops_free(&s);
    }
}

/* Coordinates to keep stay; without weights all move. */
static void weights(void **state)
{
    (void)state;
    loops s;
    four_bar(&s, 2.0, 1.0);
    const double guess[3] = {1.2, -0.9, 1.3}, weight[3] = {1e6, 1.0, 1.0};
    mbsr_assembly_opt opt = mbsr_default_assembly_opt();
    mbsr_assembly_info info;
    assert_ok(mbsr_assemble(s.m, s.d, 0.0, guess, NULL, s.q, &info), mbsr_data_error(s.d));
    assert_close(s.q[0], 1.256084040027, 3e-4);
    assert_true(info.gap_before > 0.1);
    assert_close(info.change, fabs(s.q[0] - 1.2), 0.1);
    opt.weight = weight;
    assert_ok(mbsr_assemble(s.m, s.d, 0.0, guess, &opt, s.q, NULL), mbsr_data_error(s.d));
    assert_close(s.q[0], 1.2, 1e-5);
    loops_free(&s);
}

/* Links of 1, 2.5 and 2 m over 7 m of ground: 1.5 m are missing. */
static void it_cannot_be_closed(void **state)
{
    (void)state;
    loops s;
    four_bar(&s, 7.0, 1.0);
    const double guess[3] = {1.0, -0.5, 2.0};
    double nearest[3], y[64], yp[64];
    mbsr_assembly_info info;
    assert_refused(mbsr_assemble(s.m, s.d, 0.0, guess, NULL, nearest, &info), mbsr_data_error(s.d),
                   MBSR_LOOP_OPEN, 1, MBSR_NONE,
                   "closure 0 'pin'|ball|body 1|body 2|stays open by 1.5");
    assert_close(info.gap, 1.5, 1e-4);
    assert_int_equal(info.closure, 0);
    assert_close(nearest[0], 0.0, 0.02);
    assert_close(fabs(nearest[2]), pi, 0.02);
    assert_ok(mbsr_dae_pack(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, guess, s.u, y), NULL);
    assert_refused(mbsr_dae_consistent(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL),
                   mbsr_data_error(s.d), MBSR_LOOP_OPEN, 1, MBSR_NONE, "mbsr_dae_consistent|pin");
    assert_memory_equal(y, guess, sizeof guess);
    loops_free(&s);
}

/* Quaternions: a body is welded to the ground from any turn but half a one. */
static void a_weld_in_space(void **state)
{
    (void)state;
    const double axis[3] = {1.0, 2.0, -1.0}, at[3] = {0.3, 0.2, 0.1};
    const mbsr_frame there = mbsr_frame_turned(at, axis, 2.0);
    loops s;
    loops_begin(&s, NULL);
    mbsr_body_def body = mbsr_default_body_def();
    body.joint = mbsr_joint_free(NULL, NULL);
    assert_ok(mbsr_model_add_body(s.m, &body, NULL), NULL);
    const mbsr_closure_def weld = mbsr_closure_weld(0, NULL, MBSR_GROUND, &there);
    assert_ok(mbsr_model_add_closure(s.m, &weld, NULL), NULL);
    loops_finish(&s);
    for (uint64_t seed = 1; seed <= 50; ++seed) {
        test_rng rng = test_seed(seed);
        double guess[7], pose[MBSR_POSE_SIZE];
        test_fill(&rng, 7, guess);
        assert_ok(mbsr_assemble(s.m, s.d, 0.0, guess, NULL, s.q, NULL), mbsr_data_error(s.d));
        assert_ok(mbsr_positions(s.m, s.d, 0.0, s.q), NULL);
        assert_ok(mbsr_body_pose(s.m, s.d, 0, pose), NULL);
        for (int k = 0; k < 9; ++k) assert_close(pose[k], there.R[k], 1e-10);
        for (int k = 0; k < 3; ++k) assert_close(pose[9 + k], there.x[k], 1e-10);
    }
    loops_free(&s);
}

static void options(void **state)
{
    (void)state;
    loops s;
    four_bar(&s, 2.0, 1.0);
    double zero[3] = {0.0, 1.0, 1.0};
    mbsr_assembly_opt opt = mbsr_default_assembly_opt();
    opt.cookie = 0;
    const mbsr_error *error = mbsr_data_error(s.d);
    assert_refused(mbsr_assemble(s.m, s.d, 0.0, s.q, &opt, s.q, NULL), error, MBSR_ERR_NO_DEFAULT,
                   MBSR_NONE, MBSR_NONE, "mbsr_default_assembly_opt");
    opt = mbsr_default_assembly_opt();
    opt.max_iterations = 0;
    assert_refused(mbsr_assemble(s.m, s.d, 0.0, s.q, &opt, s.q, NULL), error, MBSR_ERR_VALUE,
                   MBSR_NONE, MBSR_NONE, "max_iterations");
    opt = mbsr_default_assembly_opt();
    opt.weight = zero;
    assert_refused(mbsr_assemble(s.m, s.d, 0.0, s.q, &opt, s.q, NULL), error, MBSR_ERR_VALUE,
                   MBSR_NONE, MBSR_NONE, "weight[0]");
    loops_free(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(random_guesses), cmocka_unit_test(weights),
                                       cmocka_unit_test(it_cannot_be_closed),
                                       cmocka_unit_test(a_weld_in_space),
                                       cmocka_unit_test(options)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
