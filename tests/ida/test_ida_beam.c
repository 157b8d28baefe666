/* The beam of the Test Set for IVP Solvers: a chain of 40 rods without mass with particles between
 * them, each body rank-deficient, each joint with inertia.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The test set's unknowns are the angles theta_k of the rods against the x axis; the joints have
 * the differences of them. The reference values are those of the test set at t = 5. */
#include "reference_runs.h"

#include "internal.h"

enum { N = RUN_MOST };

/* (-phi, phi) at the tip. */
static int tip_force(void *unused, double t, int n, double *value)
{
    (void)unused, (void)n;
    const double pi = acos(-1.0), phi = t <= pi ? 1.5 * sin(t) * sin(t) : 0.0;
    value[0] = -phi, value[1] = phi, value[2] = 0.0;
    return MBSR_OK;
}

/* The reference point of each body is its particle at the outer end of the rod. */
static mbsr_model *beam(void)
{
    mbsr_model *m = run_model();
    const mbsr_planar_frame inner_end = {-1.0 / N, 0.0, 0.0};
    int predecessor = MBSR_GROUND;
    for (int k = 0; k < N; ++k) {
        predecessor =
            run_body(m, NULL, predecessor, mbsr_joint_planar_revolute(run_origin, inner_end),
                     mbsr_inertia_particle(k < N - 1 ? 1.0 / N : 0.5 / N));
        run_force(m, mbsr_force_joint_spring(predecessor, 0, k == 0 ? 2.0 * N : N, 0.0, 0.0));
    }
    run_force(m, mbsr_force_applied(predecessor, tip_force, NULL));
    return run_finish(m);
}

/* Largest relative error of three angles and three rates at t = 5. */
static double beam_error(const run_state *s)
{
    static const struct {
        int rod, rate;
        double value;
    } reference[] = {{1, 0, -0.5792366591285007e-2}, {2, 0, -0.1695298550721735e-1},
                     {40, 0, -0.1767201761075488},   {1, 1, 0.03747362681329794},
                     {10, 1, 0.5987609702624270},    {40, 1, 1.186724615113034}};
    double worst = 0.0;
    for (size_t r = 0; r < sizeof reference / sizeof reference[0]; ++r) {
        double value = 0.0;
        for (int k = 0; k < reference[r].rod; ++k) value += reference[r].rate ? s->u[k] : s->q[k];
        worst = run_larger(worst, fabs(value / reference[r].value - 1.0));
    }
    return worst;
}

static void check_beam(const mbsr_model *m, mbsr_dae_form form, double tolerance, double max_step,
                       double bound)
{
    static run_state state[2];
    run r = {.name = "beam",
             .model = m,
             .form = form,
             .tolerance = tolerance,
             .max_step = max_step,
             .T = 5.0,
             .points = 1};
    run_integrate(&r, state);
    assert_int_equal(r.info.null_directions, 0);
    const double error = beam_error(state + 1);
    run_report(&r, error);
    assert_less(error, bound);
}

/* The fastest oscillation has about 6400 rad/s and no damping. BDF of order 5 is not stable for it
 * at steps much above 5e-5 s: the tolerance then bounds the oscillation, but not its rates well. So
 * the step is limited. */
static void beam_reaches_the_reference_values(void **unused)
{
    (void)unused;
    mbsr_model *m = beam();
    check_beam(m, MBSR_DAE_MOMENTUM, 1e-12, 5e-5, 5e-8);
    check_beam(m, MBSR_DAE_INDEX1, 1e-8, 7e-5, 2e-6);
    check_beam(m, MBSR_DAE_RECURSIVE, 1e-8, 7e-5, 2e-6);
    check_beam(m, MBSR_DAE_INVERSE_DYNAMICS, 1e-8, 7e-5, 2e-6);
    mbsr_model_destroy(m);
}

/* Body mass matrices diag(m, m, 0), joint blocks D with rank 1. */
static void every_body_of_the_beam_is_deficient_and_every_joint_regular(void **unused)
{
    (void)unused;
    mbsr_model *m = beam();
    mbsr_data *d = NULL;
    double q[N], u[N] = {0.0};
    test_rng rng = test_seed(7);
    test_fill(&rng, N, q);
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    assert_ok(mbsr_positions(m, d, 0.0, q), mbsr_data_error(d));
    assert_ok(mbsr_velocities(m, d, u), mbsr_data_error(d));
    assert_ok(mbsr_forces(m, d, NULL), mbsr_data_error(d));
    assert_ok(mbsr_backward(m, d), mbsr_data_error(d));
    for (int i = 1; i <= N; ++i) {
        const mbsri_body *b = m->body + i;
        const double *M = d->M + b->dd, mass = b->id < N - 1 ? 1.0 / N : 0.5 / N;
        assert_false(b->regular);
        for (int k = 0; k < 9; ++k) assert_close(M[k], k == 0 || k == 4 ? mass : 0.0, 0.0);
        mbsr_rank_info rank;
        assert_ok(mbsr_body_rank(m, d, b->id, &rank), mbsr_data_error(d));
        assert_int_equal(rank.n, 1);
        assert_int_equal(rank.rank, 1);
        assert_less(1e-3, rank.smallest_kept);
    }
    assert_int_equal(mbsr_total_rank(m, d), N);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_body_of_the_beam_is_deficient_and_every_joint_regular),
        cmocka_unit_test(beam_reaches_the_reference_values),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
