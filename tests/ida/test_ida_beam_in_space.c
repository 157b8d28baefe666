/* The beam of the Test Set for IVP Solvers, of bodies in space.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "beam.h"

/* A random state; the tip force acts at t = 1. */
static void random_state(double *t, double *q, double *u, double *udot)
{
    test_rng rng = test_seed(17);
    *t = 1.0;
    test_fill(&rng, BEAM_RODS, q);
    test_fill(&rng, BEAM_RODS, u);
    test_fill(&rng, BEAM_RODS, udot);
}

static void joint_forces(int space, double *tau)
{
    mbsr_model *m = beam(space);
    mbsr_data *d = NULL;
    double t, q[BEAM_RODS], u[BEAM_RODS], udot[BEAM_RODS];
    random_state(&t, q, u, udot);
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    assert_ok(mbsr_inverse_dynamics(m, d, t, q, u, udot, NULL, tau), mbsr_data_error(d));
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

static void its_equations_are_those_of_the_planar_beam(void **unused)
{
    (void)unused;
    double plane[BEAM_RODS], space[BEAM_RODS];
    joint_forces(0, plane);
    joint_forces(1, space);
    const double size = test_largest(BEAM_RODS, plane);
    assert_less(1.0, size);
    for (int k = 0; k < BEAM_RODS; ++k) assert_close(space[k], plane[k], 1e-13 * size);
}

static void it_reaches_the_reference_values(void **unused)
{
    (void)unused;
    mbsr_model *m = beam(1);
    check_beam(m, MBSR_DAE_MOMENTUM, 1e-8, 7e-5, 2e-6);
    mbsr_model_destroy(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(its_equations_are_those_of_the_planar_beam),
        cmocka_unit_test(it_reaches_the_reference_values),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
