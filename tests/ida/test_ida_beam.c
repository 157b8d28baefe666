/* The beam of the Test Set for IVP Solvers in the plane.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "beam.h"

#include "recursion/data.h"

#include <mbsrank/driver.h>

/* The fastest oscillation has about 6400 rad/s and no damping. BDF of order 5 is not stable for it
 * at steps much above 5e-5 s: the tolerance then bounds the oscillation, but not its rates well. So
 * the step is limited. */
static void beam_reaches_the_reference_values(void **unused)
{
    (void)unused;
    mbsr_model *m = beam(0);
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
    mbsr_model *m = beam(0);
    mbsr_data *d = NULL;
    double q[BEAM_RODS], u[BEAM_RODS] = {0.0};
    test_rng rng = test_seed(7);
    test_fill(&rng, BEAM_RODS, q);
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    assert_ok(mbsr_stage_positions(m, d, 0.0, q), mbsr_data_error(d));
    assert_ok(mbsr_stage_velocities(m, d, u), mbsr_data_error(d));
    assert_ok(mbsr_stage_forces(m, d, NULL), mbsr_data_error(d));
    assert_ok(mbsr_stage_backward(m, d), mbsr_data_error(d));
    for (int i = 1; i <= BEAM_RODS; ++i) {
        const mbsri_body *b = m->body + i;
        const double *M = d->M + b->dd,
                     mass = b->id < BEAM_RODS - 1 ? 1.0 / BEAM_RODS : 0.5 / BEAM_RODS;
        assert_false(b->mass.regular);
        for (int k = 0; k < 9; ++k) assert_close(M[k], k == 0 || k == 4 ? mass : 0.0, 0.0);
        mbsr_rank_info rank;
        assert_ok(mbsr_body_rank(m, d, b->id, &rank), mbsr_data_error(d));
        assert_int_equal(rank.n, 1);
        assert_int_equal(rank.rank, 1);
        assert_less(1e-3, rank.smallest_kept);
    }
    assert_int_equal(mbsr_total_rank(m, d), BEAM_RODS);
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
