/* Closing loops from a guess, and what cannot be closed.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "body.h"
#include "loops.h"
#include "units.h"

#include <stdbool.h>
#include <stdlib.h>
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
            assert_ok(mbsr_stage_positions(s.m, s.d, 0.0, closed), NULL);
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

/* Coordinates that stay do so to the last digit, or what they leave open is told. */
static void a_coordinate_stays(void **state)
{
    (void)state;
    loops s;
    four_bar(&s, 2.0, 1.0);
    const double guess[3] = {1.2, -0.9, 1.3};
    static const int crank[3] = {1, 0, 0}, two[3] = {1, 1, 0};
    mbsr_assembly_opt opt = mbsr_default_assembly_opt();
    opt.keep_position = crank;
    assert_ok(mbsr_assemble(s.m, s.d, 0.0, guess, &opt, s.q, NULL), mbsr_data_error(s.d));
    assert_true(s.q[0] == 1.2);
    opt.keep_position = two;
    assert_refused(mbsr_assemble(s.m, s.d, 0.0, guess, &opt, s.q, NULL), mbsr_data_error(s.d),
                   MBSR_LOOP_OPEN, 1, MBSR_NONE, "pin");
    assert_true(s.q[0] == 1.2 && s.q[1] == -0.9);
    loops_free(&s);
}

/* Crank 0.3, rod 1 and slider; in a rod the joint to the slider has a coordinate, on a body without
 * mass, or the joint to the crank, where the rod hangs on the slider. */
typedef enum cut { CUT_PIN, CUT_AT_SLIDER, CUT_AT_CRANK } cut;

static void slider_crank(loops *s, const units *of, cut where)
{
    const double L = of->length, zero[3] = {0.0, 0.0, 0.0}, end[3] = {L, 0.0, 0.0};
    const mbsr_planar_frame none = {0.0, 0.0, 0.0}, tip = {0.3 * L, 0.0, 0.0}, far = {L, 0.0, 0.0};
    const mbsr_inertia rod = mbsr_inertia_planar(of->mass, zero, of->mass * L * L);
    loops_begin(s, NULL);
    const int crank = test_add_body(s->m, MBSR_GROUND, mbsr_joint_planar_revolute(none, none), rod),
              slider =
                  test_add_body(s->m, MBSR_GROUND, mbsr_joint_planar_prismatic(none, none), rod),
              link = where == CUT_AT_CRANK
                         ? test_add_body(s->m, slider, mbsr_joint_planar_revolute(none, far), rod)
                         : test_add_body(s->m, crank, mbsr_joint_planar_revolute(tip, none), rod);
    mbsr_closure_def loop = mbsr_closure_ball(link, end, slider, zero);
    if (where != CUT_PIN) {
        const bool at_slider = where == CUT_AT_SLIDER;
        const int cut_body = test_add_body(s->m, at_slider ? link : crank,
                                           mbsr_joint_planar_revolute(at_slider ? far : tip, none),
                                           mbsr_inertia_zero());
        loop = mbsr_closure_weld(cut_body, NULL, at_slider ? slider : link, NULL);
    }
    assert_ok(mbsr_model_add_closure(s->m, &loop, NULL), NULL);
    loops_finish(s);
}

/* Positions found, and steps, are the same in all units. */
static void in_four_systems_of_units(void **state)
{
    (void)state;
    enum { GUESSES = 50 };
    static double found[GUESSES][3];
    static int steps[GUESSES];
    for (size_t k = 0; k < sizeof systems / sizeof systems[0]; ++k) {
        loops s;
        slider_crank(&s, systems + k, CUT_PIN);
        for (uint64_t seed = 0; seed < GUESSES; ++seed) {
            test_rng rng = test_seed(seed + 1);
            double q[3];
            mbsr_assembly_info info;
            test_fill(&rng, 3, q);
            for (int j = 0; j < 3; ++j) q[j] *= j == 1 ? 2.0 * systems[k].length : pi;
            assert_ok(mbsr_assemble(s.m, s.d, 0.0, q, NULL, q, &info), mbsr_data_error(s.d));
            q[1] /= systems[k].length;
            if (k == 0) memcpy(found[seed], q, sizeof q);
            if (k == 0) steps[seed] = info.iterations;
            for (int j = 0; j < 3; ++j) assert_close(q[j], found[seed][j], 1e-10);
            assert_int_equal(info.iterations, steps[seed]);
        }
        loops_free(&s);
    }
}

/* A tip 2 m from its hinge, at 45 degrees, on a slide along the line that it is to be moved on by
 * 3 mm: the slide moves by 2 mm, and the hinge by the third one, in whatever units; and whatever
 * armature is on the joints. */
static void a_slide_below_a_hinge(void **state)
{
    (void)state;
    static const double length[] = {1.0, 1e3, 1048576.0}, armature[] = {0.0, 1e14};
    const mbsr_planar_frame none = {0.0, 0.0, 0.0};
    const mbsr_inertia nothing = mbsr_inertia_planar(0.0, (double[2]){0.0, 0.0}, 0.0);
    for (int k = 0; k < 6; ++k) {
        const double L = length[k % 3], tip[3] = {2.0 * L, 0.0, 0.0},
                     aim[3] = {2.0 * L * cos(pi / 4.0) - 3e-3 * L, 0.0, 0.0},
                     along[3] = {1.0, 0.0, 0.0}, guess[2] = {0.0, pi / 4.0};
        loops s;
        double q[2];
        loops_begin(&s, NULL);
        const int a = test_add_body(s.m, MBSR_GROUND, mbsr_joint_planar_prismatic(none, none),
                                    nothing),
                  b = test_add_body(s.m, a, mbsr_joint_planar_revolute(none, none), nothing);
        assert_ok(mbsr_model_armature(s.m, a, 1, armature + k / 3), mbsr_model_error(s.m));
        assert_ok(mbsr_model_armature(s.m, b, 1, armature + k / 3), mbsr_model_error(s.m));
        const mbsr_closure_def line = mbsr_closure_rows(b, tip, MBSR_GROUND, aim, 1, along);
        assert_ok(mbsr_model_add_closure(s.m, &line, NULL), mbsr_model_error(s.m));
        loops_finish(&s);
        assert_ok(mbsr_assemble(s.m, s.d, 0.0, guess, NULL, q, NULL), mbsr_data_error(s.d));
        assert_close(q[0] / L, -2e-3, 1e-5);
        assert_close(q[1] - guess[1], 1e-3 / sqrt(2.0), 1e-5);
        loops_free(&s);
    }
}

/* With the same joint coordinates two cuts differ by the square of what the guess is open by. */
static void where_the_loop_is_cut(void **state)
{
    (void)state;
    const double lean = asin(0.3 * sin(0.7)), x = 0.3 * cos(0.7) + cos(lean);
    for (uint64_t seed = 1; seed <= 20; ++seed) {
        for (int k = 1; k <= 3; ++k) {
            const double off = pow(10.0, -k);
            test_rng rng = test_seed(seed);
            loops a, b;
            double q[2][4], r[4];
            test_fill(&rng, 4, r);
            /* crank, slider, rod on the crank, slider on the rod */
            const double guess[4] = {0.7 + off * r[0], x + off * r[1], -0.7 - lean + off * r[2],
                                     lean + off * r[3]},
                         other[4] = {guess[0], guess[1], -guess[3], guess[2]};
            slider_crank(&a, systems, CUT_AT_SLIDER);
            slider_crank(&b, systems, CUT_AT_CRANK);
            assert_ok(mbsr_assemble(a.m, a.d, 0.0, guess, NULL, q[0], NULL), mbsr_data_error(a.d));
            assert_ok(mbsr_assemble(b.m, b.d, 0.0, other, NULL, q[1], NULL), mbsr_data_error(b.d));
            assert_close(q[0][0], q[1][0], off * off);
            assert_close(q[0][1], q[1][1], off * off);
            loops_free(&a);
            loops_free(&b);
        }
    }
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
    const mbsr_frame there = mbsr_frame_rotated(at, axis, 2.0);
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
        assert_ok(mbsr_stage_positions(s.m, s.d, 0.0, s.q), NULL);
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

/* ---- many loops ---- */

static void *allocate_counted(void *user, size_t size)
{
    *(size_t *)user += size;
    return malloc(size);
}

static void release_counted(void *user, void *memory)
{
    (void)user;
    free(memory);
}

/* Four-bars on the ground, each rocker the next one's crank. */
static void closes_many(int count, size_t *bytes)
{
    loops s = {0};
    mbsr_model_def def = mbsr_default_model_def();
    mbsr_assembly_info info;
    test_rng rng = test_seed(3);
    *bytes = 0;
    def.allocator = (mbsr_allocator){allocate_counted, release_counted, bytes};
    assert_ok(mbsr_model_create(&def, &s.m, NULL), NULL);
    int before = loops_rod(&s, "rocker", MBSR_GROUND, 0.0, 0.0, 1.0, 1.0);
    for (int k = 1; k <= count; ++k) {
        const int coupler = loops_rod(&s, "coupler", before, 1.0, 0.0, 1.0, 1.0),
                  rocker = loops_rod(&s, "rocker", MBSR_GROUND, k, 0.0, 1.0, 1.0);
        loops_pin(&s, "pin", coupler, 1.0, 0.0, rocker, 1.0, 0.0);
        before = rocker;
    }
    loops_build(&s);
    double *q = calloc(2 * (size_t)s.nq + (size_t)s.position_rows, sizeof *q), *closed = q + s.nq,
           *gap = closed + s.nq;
    for (int k = 0; k < s.nq; ++k) {
        const double angle = k == 0 || k % 2 == 0 ? 1.5 : -1.5; /* rockers up, couplers level */
        q[k] = angle + 0.03 * test_uniform(&rng);
    }
    *bytes = 0;
    assert_ok(mbsr_assemble(s.m, s.d, 0.0, q, NULL, closed, &info), mbsr_data_error(s.d));
    assert_ok(mbsr_stage_positions(s.m, s.d, 0.0, closed), NULL);
    assert_ok(mbsr_closures_gap(s.m, s.d, gap), NULL);
    assert_less(test_largest(s.position_rows, gap), 1e-8);
    assert_true(info.iterations <= 30);
    *bytes /= (size_t)s.nq;
    free(q);
    loops_free(&s);
}

static void many_loops_close_in_proportion(void **state)
{
    (void)state;
    size_t few, many;
    closes_many(10, &few);
    closes_many(600, &many);
    assert_true(many <= few);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(random_guesses),
                                       cmocka_unit_test(many_loops_close_in_proportion),
                                       cmocka_unit_test(weights),
                                       cmocka_unit_test(it_cannot_be_closed),
                                       cmocka_unit_test(a_coordinate_stays),
                                       cmocka_unit_test(in_four_systems_of_units),
                                       cmocka_unit_test(a_slide_below_a_hinge),
                                       cmocka_unit_test(where_the_loop_is_cut),
                                       cmocka_unit_test(a_weld_in_space),
                                       cmocka_unit_test(options)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
