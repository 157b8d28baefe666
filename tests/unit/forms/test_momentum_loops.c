/* The momentum form with closures: its rows where accelerations and loop forces are those of the
 * dense equations, and what each multiplier does.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "loops.h"

#include <mbsrank/driver.h>

#include <string.h>

enum { Y_MOST = 8 * LOOPS_MOST };

/* A ring in space: ball joint, revolute joint, and a universal loop joint to the ground; a point on
 * a line; one body without mass. */
static void ring(loops *s)
{
    const double x[3] = {1.0, 0.0, 0.0}, y[3] = {0.0, 1.0, 0.2}, z[3] = {0.1, 0.0, 1.0},
                 end[3] = {0.5, 0.1, 0.0}, moment[6] = {0.2, 0.25, 0.3, 0.01, 0.0, 0.02};
    const mbsr_frame far = mbsr_frame_at(1.0, 0.2, -0.1), there = mbsr_frame_at(1.5, 0.7, 0.3);
    const mbsr_joint last = mbsr_joint_universal(&far, NULL, x, y);
    int a, b, c;
    loops_begin(s, NULL);
    mbsr_body_def body = mbsr_default_body_def();
    body.joint = mbsr_joint_spherical(NULL, NULL);
    body.inertia = mbsr_inertia_rigid(1.5, end, moment);
    assert_ok(mbsr_model_add_body(s->m, &body, &a), mbsr_model_error(s->m));
    body.parent = a;
    body.joint = mbsr_joint_revolute(&far, NULL, z);
    body.inertia = mbsr_inertia_zero();
    assert_ok(mbsr_model_add_body(s->m, &body, &b), mbsr_model_error(s->m));
    body.parent = b;
    body.joint = mbsr_joint_cylindrical(&far, NULL, y);
    body.inertia = mbsr_inertia_rigid(0.7, end, moment);
    assert_ok(mbsr_model_add_body(s->m, &body, &c), mbsr_model_error(s->m));
    assert_ok(mbsr_model_add_loop_joint(s->m, "far end", c, &last, MBSR_GROUND, &there, NULL, NULL),
              mbsr_model_error(s->m));
    const mbsr_closure_def line = mbsr_closure_rows(b, end, a, NULL, 1, x);
    assert_ok(mbsr_model_add_closure(s->m, &line, NULL), mbsr_model_error(s->m));
    loops_finish(s);
}

static void normalise(loops *s)
{
    double length = 0.0;
    for (int k = 0; k < 4; ++k) length += s->q[k] * s->q[k];
    for (int k = 0; k < 4; ++k) s->q[k] /= sqrt(length);
}

/* p at the state of s moved by h along q' and u'. */
static void momenta_after(loops *s, double h, const double *qdot, double *p)
{
    double q[LOOPS_MOST], u[LOOPS_MOST], y[Y_MOST];
    for (int k = 0; k < s->nq; ++k) q[k] = s->q[k] + h * qdot[k];
    for (int k = 0; k < s->nu; ++k) u[k] = s->u[k] + h * s->udot[k];
    assert_ok(mbsr_dae_pack(s->m, s->d, MBSR_DAE_MOMENTUM, h, q, u, y), mbsr_data_error(s->d));
    memcpy(p, y + s->nq, (size_t)s->nu * sizeof *p);
}

/* At any state, open or not: with u' and lambda of the dense equations p' is the rate of M u. */
static void rates_of_momenta(void **state)
{
    (void)state;
    loops s;
    ring(&s);
    for (uint64_t seed = 1; seed < 6; ++seed) {
        test_rng rng = test_seed(seed);
        double y[Y_MOST], yp[Y_MOST], F[Y_MOST], after[LOOPS_MOST], before[LOOPS_MOST];
        const double h = 1e-5;
        test_fill(&rng, s.nq, s.q);
        test_fill(&rng, s.nu, s.u);
        normalise(&s);
        loops_accelerations(&s, 0.0, NULL);
        loops_state(&s, 0.0, y, yp);
        assert_ok(mbsr_dae_residual(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, y, yp, F),
                  mbsr_data_error(s.d));
        momenta_after(&s, h, yp, after);
        momenta_after(&s, -h, yp, before);
        for (int k = 0; k < s.nu; ++k) {
            const double rate = (after[k] - before[k]) / (2.0 * h);
            assert_close(yp[s.nq + k], rate, 1e-7 * (1.0 + test_largest(s.rows, s.lambda)));
        }
        /* the algebraic equations: velocities by momenta, forces of the massless body, rows */
        const double size = 1.0 + test_largest(s.rows, s.lambda);
        double g[LOOPS_MOST], rate[LOOPS_MOST];
        loops_rows(&s, 0.0, s.q, s.u, NULL, g, rate, NULL);
        const double *rows = F + s.nq + 2 * s.nu;
        for (int k = 0; k < s.nu; ++k) assert_close(F[s.nq + s.nu + k], 0.0, 1e-9 * size);
        for (int k = 0; k < s.rows; ++k) assert_close(rows[k], rate[k], 1e-14);
        for (int k = 0; k < s.position_rows; ++k) assert_close(rows[s.rows + k], g[k], 1e-14);
    }
    loops_free(&s);
}

/* Lambda and Eta themselves are in no equation, Eta' in that of q' alone. */
static void what_each_multiplier_does(void **state)
{
    (void)state;
    loops s;
    ring(&s);
    test_rng rng = test_seed(9);
    double y[Y_MOST], yp[Y_MOST], F[Y_MOST], G[Y_MOST], id[Y_MOST];
    test_fill(&rng, s.nq, s.q);
    test_fill(&rng, s.nu, s.u);
    normalise(&s);
    loops_accelerations(&s, 0.0, NULL);
    loops_state(&s, 0.0, y, yp);
    const mbsr_error *error = mbsr_data_error(s.d);
    assert_ok(mbsr_dae_residual(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, y, yp, F), error);
    const int first = s.nq + 2 * s.nu;
    for (int k = first; k < s.size; ++k) {
        assert_true(fabs(y[k]) <= 0.0); /* as packed */
        y[k] = test_uniform(&rng);
    }
    assert_ok(mbsr_dae_residual(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, y, yp, G), error);
    assert_memory_equal(F, G, (size_t)s.size * sizeof *F);
    /* q' = G (u + w C^T Eta'): the same as with other velocities */
    double w[LOOPS_MOST], eta[LOOPS_MOST], along[LOOPS_MOST], qdot[LOOPS_MOST], u[LOOPS_MOST];
    test_fill(&rng, s.position_rows, eta);
    memcpy(yp + first + s.rows, eta, (size_t)s.position_rows * sizeof *eta);
    assert_ok(mbsr_dae_residual(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, y, yp, G), error);
    assert_int_equal(s.position_rows, s.rows);
    assert_ok(mbsr_closures_transpose(s.m, s.d, eta, along), error);
    assert_ok(mbsr_closures_weight(s.m, w), NULL);
    for (int k = 0; k < s.nu; ++k) u[k] = s.u[k] + w[k] * along[k];
    assert_ok(mbsr_stage_positions(s.m, s.d, 0.0, s.q), error);
    assert_ok(mbsr_stage_velocities(s.m, s.d, u), error);
    assert_ok(mbsr_coordinate_rates(s.m, s.d, qdot), error);
    const double largest = fmax(1.0, test_largest(s.nq, qdot));
    for (int k = 0; k < s.nq; ++k) assert_close(G[k], yp[k] - qdot[k], 1e-14 * largest);
    assert_memory_equal(F + s.nq, G + s.nq, (size_t)(s.size - s.nq) * sizeof *F);
    assert_ok(mbsr_dae_id(s.m, s.d, MBSR_DAE_MOMENTUM, id), error);
    for (int k = 0; k < s.size; ++k)
        assert_true(fabs(id[k] - (k < s.nq + s.nu ? 1.0 : 0.0)) <= 0.0);
    loops_free(&s);
}

/* A stiff pin: its force is a spring's where its variable is, and its rows say so. */
static void a_stiff_pin(void **state)
{
    (void)state;
    loops s;
    loops_begin(&s, NULL);
    const int a = loops_rod(&s, "a", MBSR_GROUND, 0.0, 0.0, 1.0, 1.0);
    mbsr_closure_def pin =
        mbsr_closure_ball(a, (double[3]){1.0, 0.0, 0.0}, MBSR_GROUND, (double[3]){0.9, 0.1, 0.0});
    for (int k = 0; k < 2; ++k) {
        pin.stiffness[k] = 1e4 * (k + 1);
        pin.damping[k] = 30.0;
    }
    assert_ok(mbsr_model_add_closure(s.m, &pin, NULL), mbsr_model_error(s.m));
    loops_finish(&s);
    s.q[0] = 0.1, s.u[0] = 2.0;
    double y[16], yp[16] = {0.0}, F[16], g[2], rate[2], tau[1], zero[1] = {0.0};
    loops_rows(&s, 0.0, s.q, s.u, NULL, g, rate, NULL);
    assert_ok(mbsr_dae_pack(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, s.q, s.u, y), mbsr_data_error(s.d));
    for (int k = 0; k < 2; ++k) {
        assert_close(y[3 + k], pin.stiffness[k] * g[k], 1e-9);
        yp[3 + k] = pin.stiffness[k] * rate[k];
    }
    assert_ok(mbsr_dae_residual(s.m, s.d, MBSR_DAE_MOMENTUM, 0.0, y, yp, F), mbsr_data_error(s.d));
    for (int k = 0; k < 4; ++k) assert_close(F[3 + k], 0.0, 1e-12);
    assert_ok(mbsr_inverse_dynamics(s.m, s.d, 0.0, s.q, s.u, zero, NULL, tau),
              mbsr_data_error(s.d));
    assert_close(F[1], tau[0],
                 1e-9); /* p' - (.) with p' = 0, M constant: what is missing at rest */
    double by_hand = 9.81 * 0.5 * cos(0.1);
    for (int k = 0; k < 2; ++k) {
        const double arm = k == 0 ? -sin(0.1) : cos(0.1);
        by_hand += arm * (pin.stiffness[k] * g[k] + pin.damping[k] * rate[k]);
    }
    assert_close(tau[0], by_hand, 1e-9);
    loops_free(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(rates_of_momenta),
                                       cmocka_unit_test(what_each_multiplier_does),
                                       cmocka_unit_test(a_stiff_pin)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
