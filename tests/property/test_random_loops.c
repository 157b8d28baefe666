/* Random trees with random loops against the dense equations: accelerations and loop forces, starts,
 * ranks, inverse dynamics.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "loops.h"

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
    const mbsr_frame A = mbsr_frame_turned(p, y, 1.0);
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

/* Bodies with mass, but some; the twice added closure is redundant. */
static void make(loops *s, test_rng *rng, int bodies, int closures, int twice)
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
    for (int k = 0; k < closures; ++k) random_closure(s, rng, bodies);
    for (int k = 0; k < twice; ++k) {
        const double p[3] = {0.3, 0.1, -0.2}, q[3] = {0.2, 0.2, 0.5};
        const mbsr_closure_def def = mbsr_closure_ball(bodies - 1, p, MBSR_GROUND, q);
        assert_ok(mbsr_model_add_closure(s->m, &def, NULL), mbsr_model_error(s->m));
    }
    loops_finish(s);
}

static void random_state(loops *s, test_rng *rng)
{
    double y[8 * LOOPS_MOST];
    test_fill(rng, s->nq, s->q);
    test_fill(rng, s->nu, s->u);
    assert_ok(mbsr_dae_pack(s->m, s->d, MBSR_DAE_MOMENTUM, 0.0, s->q, s->u, y),
              mbsr_data_error(s->d));
    memcpy(s->q, y, (size_t)s->nq * sizeof *y); /* quaternions of length 1 */
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
        random_state(&s, &rng);
        test_fill(&rng, s.nu, tau);
        const int rank = loops_accelerations(&s, 0.0, tau);
        const bool regular = rank == s.nu + s.rows - (twice ? 3 : 0);
        const int status = mbsr_forward_dynamics(s.m, s.d, 0.0, s.q, s.u, tau, udot);
        if (regular) {
            assert_ok(status, mbsr_data_error(s.d));
            const double size = 1.0 + test_largest(s.nu, s.udot) + test_largest(s.rows, s.lambda);
            assert_ok(mbsr_closures_force(s.m, s.d, lambda), mbsr_data_error(s.d));
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
        random_state(&s, &rng);
        test_fill(&rng, s.nu, tau);
        if (mbsr_forward_dynamics(s.m, s.d, 0.0, s.q, s.u, tau, s.udot) == MBSR_OK) {
            const double size = 1.0 + test_largest(s.nu, s.udot);
            for (int k = 0; k < s.nu; ++k) all[k] = k;
            assert_ok(mbsr_closures_inverse_dynamics(s.m, s.d, 0.0, s.q, s.u, s.udot, s.nu, all,
                                                     tau, lambda),
                      mbsr_data_error(s.d));
            assert_ok(mbsr_forward_dynamics(s.m, s.d, 0.0, s.q, s.u, tau, again),
                      mbsr_data_error(s.d));
            for (int k = 0; k < s.nu; ++k) assert_close(again[k], s.udot[k], 1e-6 * size);
            assert_int_equal(mbsr_closures_inverse_dynamics(s.m, s.d, 0.0, s.q, s.u, s.udot, 0,
                                                            NULL, tau, lambda),
                             MBSR_UNDETERMINED);
            assert_contains(mbsr_data_error(s.d)->text,
                            "mbsr_closures_inverse_dynamics|driven by none");
            ++compared;
        }
        loops_free(&s);
    }
    assert_true(compared > 20);
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
        random_state(&s, &rng);
        assert_ok(mbsr_dae_pack(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, s.q, s.u, y), NULL);
        const int status =
            mbsr_dae_consistent(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, &info);
        if (status == MBSR_OK) {
            const double size = 1.0 + test_largest(s.size, yp);
            assert_ok(mbsr_dae_residual(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, y, yp, F),
                      mbsr_data_error(s.d));
            assert_less(test_largest(s.size, F), 1e-8 * size);
            ++started;
        } else {
            assert_true(status == MBSR_LOOP_OPEN || status == MBSR_UNDETERMINED);
        }
        loops_free(&s);
    }
    assert_true(started > 20);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(accelerations),
                                       cmocka_unit_test(inverse_dynamics),
                                       cmocka_unit_test(starts)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
