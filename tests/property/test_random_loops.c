/* Random trees with random loops against the dense equations: accelerations and loop forces,
 * starts, ranks, inverse dynamics.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "loops.h"
#include "own_closure.h"

#include <mbsrank/driver.h>

#include <stdbool.h>
#include <string.h>

static void vector(test_rng *rng, double *x)
{
    test_fill(rng, 3, x);
}

static mbsr_joint random_joint(test_rng *rng)
{
    double x[3], y[3], p[3];
    vector(rng, x);
    vector(rng, y);
    vector(rng, p);
    const mbsr_frame A = mbsr_frame_rotated(p, y, 1.0);
    switch (test_integer(rng, 0, 5)) {
    case 0: return mbsr_joint_revolute(&A, NULL, x);
    case 1: return mbsr_joint_cylindrical(&A, NULL, x);
    case 2: return mbsr_joint_universal(&A, NULL, x, y);
    case 3: return mbsr_joint_spherical(&A, NULL);
    case 4: return mbsr_joint_free(&A, NULL);
    default: return mbsr_joint_translational(&A, NULL);
    }
}

static void random_closure(loops *s, test_rng *rng, int bodies)
{
    double p[3], q[3], x[6];
    vector(rng, p);
    vector(rng, q);
    test_fill(rng, 6, x);
    const int a = test_integer(rng, 0, bodies - 1);
    int b = test_integer(rng, -1, bodies - 1);
    if (a == b) b = MBSR_GROUND;
    mbsr_closure_def def;
    switch (test_integer(rng, 0, 3)) {
    case 0: def = mbsr_closure_ball(a, p, b, q); break;
    case 1: def = mbsr_closure_rows(a, p, b, q, test_integer(rng, 1, 2), x); break;
    case 2: def = mbsr_closure_distance(a, p, b, q, 1.0); break;
    default: {
        const mbsr_joint joint = random_joint(rng);
        assert_ok(mbsr_model_add_loop_joint(s->m, "loop joint", a, &joint, b, NULL, NULL, NULL),
                  mbsr_model_error(s->m));
        return;
    }
    }
    assert_ok(mbsr_model_add_closure(s->m, &def, NULL), mbsr_model_error(s->m));
}

static void add_tree(loops *s, test_rng *rng, int bodies)
{
    loops_begin(s, NULL);
    for (int k = 0; k < bodies; ++k) {
        double com[3];
        const double tensor[6] = {0.3, 0.4, 0.5, 0.01, 0.02, -0.03};
        mbsr_body_def body = mbsr_default_body_def();
        vector(rng, com);
        body.parent = test_integer(rng, -1, k - 1);
        body.joint = random_joint(rng);
        body.inertia = mbsr_inertia_rigid(1.0 + 0.5 * test_uniform(rng), com, tensor);
        assert_ok(mbsr_model_add_body(s->m, &body, NULL), mbsr_model_error(s->m));
    }
}

/* The twice added closure is redundant. */
static void make(loops *s, test_rng *rng, int bodies, int closures, int twice)
{
    add_tree(s, rng, bodies);
    for (int k = 0; k < closures; ++k) random_closure(s, rng, bodies);
    for (int k = 0; k < twice; ++k) {
        const double p[3] = {0.3, 0.1, -0.2}, q[3] = {0.2, 0.2, 0.5};
        const mbsr_closure_def def = mbsr_closure_ball(bodies - 1, p, MBSR_GROUND, q);
        assert_ok(mbsr_model_add_closure(s->m, &def, NULL), mbsr_model_error(s->m));
    }
    loops_finish(s);
}

/* Any state, open or not, as long as the rows are independent or the same twice. */
static void accelerations(void **state)
{
    (void)state;
    int compared = 0;
    for (uint64_t seed = 1; seed <= 60; ++seed) {
        test_rng rng = test_seed(seed);
        loops s;
        double udot[LOOPS_MOST], lambda[LOOPS_MOST], tau[LOOPS_MOST], both[LOOPS_MOST];
        const int twice = seed % 3 == 0 ? 2 : 0;
        make(&s, &rng, test_integer(&rng, 2, 5), test_integer(&rng, 1, 2), twice);
        loops_random_state(&s, &rng);
        test_fill(&rng, s.nu, tau);
        const int rank = loops_accelerations(&s, 0.0, tau);
        const bool regular = rank == s.nu + s.rows - (twice ? 3 : 0);
        const int status = mbsr_forward_dynamics(s.m, s.d, 0.0, s.q, s.u, tau, udot);
        if (regular) {
            assert_ok(status, mbsr_data_error(s.d));
            const double size = 1.0 + test_largest(s.nu, s.udot) + test_largest(s.rows, s.lambda);
            assert_ok(mbsr_closures_lambda(s.m, s.d, lambda), mbsr_data_error(s.d));
            for (int k = 0; k < s.nu; ++k) assert_close(udot[k], s.udot[k], 1e-7 * size);
            /* loop forces of rows that stand there twice are shared: C^T lambda is compared */
            assert_ok(mbsr_closures_transpose(s.m, s.d, lambda, both), NULL);
            assert_ok(mbsr_closures_transpose(s.m, s.d, s.lambda, lambda), NULL);
            for (int k = 0; k < s.nu; ++k) assert_close(both[k], lambda[k], 1e-7 * size);
            ++compared;
        }
        loops_free(&s);
    }
    assert_true(compared > 30); /* others have more rows than freedoms */
}

/* ---- rolling, couplings, closures of one's own ---- */

enum { COUPLING, BALL, DISC, BARE, OWN, OTHERS };

/* Whether the tree has two joints that a coupling may read, where it is one. */
static bool add_other(loops *s, test_rng *rng, int kind, const int *joint, int bodies)
{
    double p[3], r[3], coefficient[2];
    const int body[2] = {joint[0], joint[1]}, coordinate[2] = {0, 0};
    vector(rng, p);
    vector(rng, r);
    test_fill(rng, 2, coefficient);
    const mbsr_frame there = mbsr_frame_along(p, r);
    const int a = bodies - 1, b = test_integer(rng, -1, bodies - 2), two[2] = {a, b < 0 ? 0 : b};
    mbsr_closure_def def;
    switch (kind) {
    case COUPLING:
        if (joint[1] < 0) return false;
        def = mbsr_closure_coupling(2, body, coordinate, coefficient, 0.3);
        break;
    case BALL: def = mbsr_closure_rolling_ball(a, r, 0.3, b, &there); break;
    case DISC: def = mbsr_closure_rolling_disc(a, NULL, 0.4, b, &there); break;
    default: def = mbsr_closure_custom(test_own_closure + (kind == OWN), 2, two, 1, 1, NULL); break;
    }
    assert_ok(mbsr_model_add_closure(s->m, &def, NULL), mbsr_model_error(s->m));
    return true;
}

/* The first two joints with q' = u. */
static void find_joints(const loops *s, int bodies, int joint[2])
{
    int found = 0;
    joint[0] = joint[1] = -1;
    for (int k = 0; k < bodies && found < 2; ++k) {
        int nq, n;
        assert_ok(mbsr_body_coordinates(s->m, k, NULL, &nq, NULL, &n), NULL);
        if (nq == n && n > 0) joint[found++] = k;
    }
}

/* C u + g_t a little earlier or later on the way that u and u' lead. */
static void rates_after(loops *s, double h, double *rate)
{
    double q[LOOPS_MOST], u[LOOPS_MOST];
    const mbsr_error *error = mbsr_data_error(s->d);
    assert_ok(mbsr_stage_positions(s->m, s->d, 0.0, s->q), error);
    assert_ok(mbsr_stage_velocities(s->m, s->d, s->u), error);
    assert_ok(mbsr_coordinate_rates(s->m, s->d, q), error);
    for (int k = 0; k < s->nq; ++k) q[k] = s->q[k] + h * q[k];
    for (int k = 0; k < s->nu; ++k) u[k] = s->u[k] + h * s->udot[k];
    assert_ok(mbsr_stage_positions(s->m, s->d, h, q), error);
    assert_ok(mbsr_stage_velocities(s->m, s->d, u), error);
    assert_ok(mbsr_closures_rate(s->m, s->d, rate), error);
}

/* Accelerations against the dense equations, and the velocity rows that they keep by differences.
 */
static void other_kinds(void **state)
{
    (void)state;
    int compared = 0;
    for (uint64_t seed = 1; seed <= 60; ++seed) {
        test_rng rng = test_seed(seed), again = test_seed(seed);
        loops tree, s;
        int joint[2];
        const int bodies = 2 + (int)seed % 4, kind = (int)seed % OTHERS;
        double udot[LOOPS_MOST], lambda[LOOPS_MOST], ahead[LOOPS_MOST], behind[LOOPS_MOST];
        add_tree(&tree, &again, bodies);
        loops_finish(&tree);
        find_joints(&tree, bodies, joint);
        loops_free(&tree);
        add_tree(&s, &rng, bodies);
        const bool added = add_other(&s, &rng, kind, joint, bodies);
        loops_finish(&s);
        loops_random_state(&s, &rng);
        if (added && loops_accelerations(&s, 0.0, NULL) == s.nu + s.rows) {
            const double size = 1.0 + test_largest(s.nu, s.udot) + test_largest(s.rows, s.lambda);
            assert_ok(mbsr_forward_dynamics(s.m, s.d, 0.0, s.q, s.u, NULL, udot),
                      mbsr_data_error(s.d));
            assert_ok(mbsr_closures_lambda(s.m, s.d, lambda), mbsr_data_error(s.d));
            for (int k = 0; k < s.nu; ++k) assert_close(udot[k], s.udot[k], 1e-7 * size);
            for (int k = 0; k < s.rows; ++k) assert_close(lambda[k], s.lambda[k], 1e-7 * size);
            memcpy(s.udot, udot, sizeof udot);
            rates_after(&s, 1e-5, ahead);
            rates_after(&s, -1e-5, behind);
            for (int k = 0; k < s.rows; ++k)
                assert_close((ahead[k] - behind[k]) / 2e-5, 0.0, 1e-5 * size);
            ++compared;
        }
        loops_free(&s);
    }
    assert_true(compared > 40);
}

/* Torques of all joints, or of some, and loop forces bring about the accelerations asked for. */
static void inverse_dynamics(void **state)
{
    (void)state;
    int compared = 0;
    for (uint64_t seed = 1; seed <= 30; ++seed) {
        test_rng rng = test_seed(seed);
        loops s;
        int all[LOOPS_MOST];
        double tau[LOOPS_MOST], lambda[LOOPS_MOST], again[LOOPS_MOST];
        make(&s, &rng, 4, 1, 0);
        loops_random_state(&s, &rng);
        test_fill(&rng, s.nu, tau);
        if (mbsr_forward_dynamics(s.m, s.d, 0.0, s.q, s.u, tau, s.udot) == MBSR_OK) {
            const double size = 1.0 + test_largest(s.nu, s.udot);
            for (int k = 0; k < s.nu; ++k) all[k] = k;
            assert_ok(
                loops_inverse_dynamics(s.m, s.d, 0.0, s.q, s.u, s.udot, s.nu, all, tau, lambda),
                mbsr_data_error(s.d));
            assert_ok(mbsr_forward_dynamics(s.m, s.d, 0.0, s.q, s.u, tau, again),
                      mbsr_data_error(s.d));
            for (int k = 0; k < s.nu; ++k) assert_close(again[k], s.udot[k], 1e-6 * size);
            assert_int_equal(
                loops_inverse_dynamics(s.m, s.d, 0.0, s.q, s.u, s.udot, 0, NULL, tau, lambda),
                MBSR_UNDETERMINED);
            assert_contains(mbsr_data_error(s.d)->text, "mbsr_inverse_dynamics|driven by none");
            ++compared;
        }
        loops_free(&s);
    }
    assert_true(compared > 20);
}

/* The index report of the start finds the directions that the start itself has found, by other
 * ways. */
static void compare_report(loops *s, const double *y, const mbsr_consistent_info *info)
{
    mbsr_index_report *r;
    mbsr_closure_report rows;
    assert_ok(mbsr_dae_unpack(s->m, s->d, MBSR_DAE_MOMENTUM, 0.0, y, s->q, s->u), NULL);
    assert_ok(mbsr_index_report_create(s->m, s->d, 0.0, s->q, s->u, &r), mbsr_data_error(s->d));
    assert_ok(mbsr_closures_report(s->m, s->d, 0.0, s->q, &rows, NULL, NULL),
              mbsr_data_error(s->d));
    assert_int_equal(r->directions, info->null_directions);
    assert_int_equal(r->elastic > 0, info->elastic);
    assert_int_equal(r->undetermined, 0);
    assert_int_equal(r->directions, rows.undetermined);
    assert_int_equal(r->dynamic, rows.mobility);
    assert_int_equal(r->directions + r->loop_supported, rows.massless);
    mbsr_index_report_destroy(s->m, r);
}

/* A start is closed, moves as the loops allow, and F is zero at its y and y'. */
static void starts(void **state)
{
    (void)state;
    int started = 0;
    for (uint64_t seed = 1; seed <= 40; ++seed) {
        test_rng rng = test_seed(seed);
        loops s;
        double y[8 * LOOPS_MOST], yp[8 * LOOPS_MOST], F[8 * LOOPS_MOST];
        mbsr_consistent_info info;
        const int twice = seed % 3 == 0 ? 2 : 0;
        make(&s, &rng, test_integer(&rng, 2, 5), 1, twice);
        loops_random_state(&s, &rng);
        assert_ok(mbsr_dae_pack(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, s.q, s.u, y), NULL);
        const int status =
            mbsr_dae_consistent(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, &info);
        if (status == MBSR_OK) {
            const double size = 1.0 + test_largest(s.size, yp);
            assert_ok(mbsr_dae_residual(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, y, yp, F),
                      mbsr_data_error(s.d));
            assert_less(test_largest(s.size, F), 1e-8 * size);
            compare_report(&s, y, &info);
            ++started;
        } else {
            assert_true(status == MBSR_LOOP_OPEN || status == MBSR_UNDETERMINED);
        }
        loops_free(&s);
    }
    assert_true(started > 20);
}

/* Rods one behind the other, of which the last turns about itself alone, its end in a plane: that
 * moves no mass, and no row of the loop, but for rounding. */
static void add_rods(loops *s, test_rng *rng, bool damped)
{
    double tip[3] = {0.0}, plane[3], normal[3];
    int last = MBSR_GROUND;
    loops_begin(s, NULL);
    for (int k = 0; k < 4; ++k) {
        double along[3], axis[3], turn[3], from[3], to[3];
        vector(rng, along);
        vector(rng, axis);
        vector(rng, turn);
        vector(rng, from);
        for (int l = 0; l < 3; ++l) to[l] = from[l] + along[l];
        const mbsr_frame A = mbsr_frame_rotated(tip, turn, 1.0),
                         B = mbsr_frame_at(from[0], from[1], from[2]);
        mbsr_body_def body = mbsr_default_body_def();
        body.parent = last;
        body.joint = mbsr_joint_revolute(&A, &B, k < 3 ? axis : along);
        body.inertia = mbsr_inertia_rod(1.3, from, to);
        assert_ok(mbsr_model_add_body(s->m, &body, &last), mbsr_model_error(s->m));
        memcpy(tip, to, sizeof tip);
    }
    const mbsr_force_def damper = mbsr_force_joint_spring(last, 0, 0.0, 0.7, 0.0);
    if (damped) assert_ok(mbsr_model_add_force(s->m, &damper, NULL), mbsr_model_error(s->m));
    vector(rng, plane);
    vector(rng, normal);
    const mbsr_closure_def def = mbsr_closure_rows(last, tip, MBSR_GROUND, plane, 1, normal);
    assert_ok(mbsr_model_add_closure(s->m, &def, NULL), mbsr_model_error(s->m));
    loops_finish(s);
}

static void spinning_rods(void **state)
{
    (void)state;
    int started = 0;
    for (uint64_t seed = 1; seed <= 60; ++seed) {
        test_rng rng = test_seed(seed);
        const bool damped = seed % 2 == 0;
        double y[8 * LOOPS_MOST], yp[8 * LOOPS_MOST];
        mbsr_consistent_info info;
        loops s;
        add_rods(&s, &rng, damped);
        loops_random_state(&s, &rng);
        assert_ok(mbsr_dae_pack(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, s.q, s.u, y), NULL);
        const int status =
            mbsr_dae_consistent(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, &info);
        if (status != MBSR_LOOP_OPEN) {
            assert_int_equal(status, damped ? MBSR_OK : MBSR_UNDETERMINED);
            if (damped) assert_int_equal(info.null_directions, 1);
            if (damped) assert_less(test_largest(s.size, yp), 1e6);
            if (damped) compare_report(&s, y, &info);
            if (!damped) assert_contains(mbsr_data_error(s.d)->text, "body 3|moves no mass");
            ++started;
        }
        loops_free(&s);
    }
    assert_true(started > 40);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(accelerations),
                                       cmocka_unit_test(other_kinds),
                                       cmocka_unit_test(inverse_dynamics), cmocka_unit_test(starts),
                                       cmocka_unit_test(spinning_rods)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
