/* Forward dynamics with an estimate of its error, and ranks of trees whose masses and lengths
 * differ by many powers of ten.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"
#include "extreme.h"
#include "rigid_tree.h"

/* All masses are positive: a joint block may be too small to tell from zero, never negative. */
static void extreme_masses_are_not_indefinite(void **unused)
{
    (void)unused;
    static const uint64_t found[] = {9718,   60027,  63475,  65731,  111030, 125062,
                                     139516, 160818, 190878, 197444, 210903, 215131,
                                     265481, 271096, 276132, 297051};
    enum { FOUND = sizeof found / sizeof found[0], MORE = 3000 };
    int full = 0;
    for (int k = 0; k < FOUND + MORE; ++k) {
        extreme s;
        double udot[EXTREME_NU];
        extreme_make(&s, k < FOUND ? found[k] : (uint64_t)k);
        const int status = mbsr_forward_dynamics(s.model, s.data, 0.0, s.q, s.u, NULL, udot);
        if (status != MBSR_UNDETERMINED) assert_ok(status, mbsr_data_error(s.data));
        full += status == MBSR_OK;
        extreme_free(&s);
    }
    assert_true(full > MORE / 3);
}

/* Against long double, wherever that is exact enough to judge. */
static void large_errors_are_reported(void **unused)
{
    (void)unused;
    int judged = 0, wrong_before = 0, wrong = 0, unreported = 0, false_alarms = 0;
    for (uint64_t seed = 1; seed <= 6000; ++seed) {
        extreme s;
        double plain[EXTREME_NU], udot[EXTREME_NU], error[EXTREME_NU], truth[EXTREME_NU], relative;
        extreme_make(&s, seed);
        int status = mbsr_forward_dynamics(s.model, s.data, 0.0, s.q, s.u, NULL, plain);
        if (!status)
            status = mbsr_forward_dynamics_refined(s.model, s.data, 0.0, s.q, s.u, NULL, udot,
                                                   error, &relative);
        if (!status && extreme_accelerations(&s, truth) < 1e-8) {
            const double before = extreme_distance(&s, plain, truth),
                         after = extreme_distance(&s, udot, truth);
            ++judged;
            wrong_before += before > 1e-6;
            wrong += after > 1e-6;
            unreported += after > 1e-6 && relative < 1e-6;
            false_alarms += after < 1e-9 && relative > 1e-6;
        }
        extreme_free(&s);
    }
    print_message("%d trees: %d wrong by more than 1e-6, refined %d, of these %d not reported, %d "
                  "false alarms\n",
                  judged, wrong_before, wrong, unreported, false_alarms);
    assert_true(judged > 2000 && wrong_before > 50);
    assert_true(2 * wrong < wrong_before);
    assert_true(1000 * unreported < judged);
    assert_true(10 * false_alarms < judged);
}

static void ordinary_trees_are_right(void **unused)
{
    (void)unused;
    for (int k = 0; k < 20; ++k) {
        const test_rigid_choice choice = {.seed = 31 + (uint64_t)k,
                                          .bodies = 3 + k,
                                          .armature = k % 4 == 3 ? 0.5 : 0.0,
                                          .many = 0.3,
                                          .branching = 0.5,
                                          .length = 1.0,
                                          .forces = k % 2,
                                          .moving = k % 3 == 0,
                                          .shuffle = k % 2};
        test_rigid_tree s;
        test_rigid_tree_make(&s, choice);
        double *error = s.expected, relative, alone;
        double udot[256];
        assert_true(s.nu <= 256);
        assert_ok(mbsr_forward_dynamics(s.model, s.data, s.t, s.q, s.u, s.tau, s.udot),
                  mbsr_data_error(s.data));
        assert_ok(mbsr_forward_dynamics_refined(s.model, s.data, s.t, s.q, s.u, s.tau, udot, error,
                                                &relative),
                  mbsr_data_error(s.data));
        assert_less(relative, 1e-9);
        const double size = test_largest(s.nu, s.udot);
        for (int l = 0; l < s.nu; ++l) {
            assert_close(udot[l], s.udot[l], 1e-9 * size);
            assert_less(-1e-300, error[l]);
            assert_less(error[l], 1e-10 * size);
        }
        /* outputs may be NULL and change nothing */
        assert_ok(mbsr_forward_dynamics_refined(s.model, s.data, s.t, s.q, s.u, s.tau, s.udot, NULL,
                                                &alone),
                  mbsr_data_error(s.data));
        assert_true(alone == relative);
        assert_ok(mbsr_forward_dynamics_refined(s.model, s.data, s.t, s.q, s.u, s.tau, s.udot, NULL,
                                                NULL),
                  mbsr_data_error(s.data));
        for (int l = 0; l < s.nu; ++l) assert_true(udot[l] == s.udot[l]);
        test_rigid_tree_free(&s);
    }
}

/* The verdict is the same in other units. */
static void units_do_not_matter(void **unused)
{
    (void)unused;
    double relative[3];
    for (int k = 0; k < 3; ++k) {
        const double length = k == 1 ? 1e3 : 1.0, mass = k == 2 ? 1e3 : 1.0;
        mbsr_model *m;
        mbsr_data *d;
        assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
        for (int i = 0; i < 2; ++i) {
            /* a heavy body at the end of a light one */
            const double edges[3] = {0.1 * length, 0.2 * length, 0.3 * length},
                         density = (i ? 1e9 : 1e-3) * mass / (length * length * length);
            const mbsr_frame A = mbsr_frame_at(0.2 * i * length, 0.4 * i * length, 0.0),
                             at = mbsr_frame_at(0.3 * length, 0.1 * length, 0.2 * length);
            mbsr_body_def body = mbsr_default_body_def();
            body.parent = i - 1;
            body.joint = i ? mbsr_joint_cylindrical(&A, NULL, (double[3]){1.0, 0.2, 0.1})
                           : mbsr_joint_universal(&A, NULL, (double[3]){0.0, 1.0, 0.1},
                                                  (double[3]){1.0, 0.2, 0.3});
            body.inertia = mbsr_inertia_in_frame(&at, mbsr_inertia_box(density, edges));
            assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
        }
        const mbsr_force_def gravity = mbsr_force_gravity(0.0, -9.81 * length, 0.0);
        assert_ok(mbsr_model_add_force(m, &gravity, NULL), mbsr_model_error(m));
        assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
        assert_ok(mbsr_data_create(m, &d, NULL), NULL);
        const double q[4] = {0.3, 0.4, 0.5, 0.1 * length}, u[4] = {1.0, -0.5, 0.2, 0.3 * length};
        double udot[4];
        assert_ok(mbsr_forward_dynamics_refined(m, d, 0.0, q, u, NULL, udot, NULL, relative + k),
                  mbsr_data_error(d));
        mbsr_data_destroy(d);
        mbsr_model_destroy(m);
    }
    for (int k = 1; k < 3; ++k) {
        assert_less(relative[k], 10.0 * relative[0]);
        assert_less(relative[0], 10.0 * relative[k]);
    }
}

static void what_is_undetermined_is_refused(void **unused)
{
    (void)unused;
    const test_rigid_choice choice = {.seed = 5, .bodies = 6, .massless = 1.0, .length = 1.0};
    test_rigid_tree s;
    test_rigid_tree_make(&s, choice);
    double relative = -1.0;
    assert_int_equal(mbsr_forward_dynamics_refined(s.model, s.data, s.t, s.q, s.u, NULL, s.udot,
                                                   NULL, &relative),
                     MBSR_UNDETERMINED);
    assert_true(relative == -1.0);
    test_rigid_tree_free(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(extreme_masses_are_not_indefinite),
        cmocka_unit_test(large_errors_are_reported),
        cmocka_unit_test(ordinary_trees_are_right),
        cmocka_unit_test(units_do_not_matter),
        cmocka_unit_test(what_is_undetermined_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
