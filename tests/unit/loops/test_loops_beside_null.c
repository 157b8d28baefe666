/* Loops that do not hold what moves no mass, beside joints that move little.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "body.h"

#include <mbsrank/closure.h>
#include <mbsrank/completion.h>
#include <mbsrank/mbsrank.h>

#include <math.h>
#include <string.h>

enum { RATES = 6 };

static mbsr_frame any_frame(test_rng *rng)
{
    double quaternion[4], place[3];
    test_fill(rng, 4, quaternion);
    test_fill(rng, 3, place);
    return mbsr_frame_quaternion(place, quaternion);
}

static mbsr_axis axis(mbsr_axis_kind kind, int along)
{
    mbsr_axis a = {.kind = kind};
    a.direction[along] = 1.0;
    return a;
}

/* A solid body by six rates, four of them slides, of which one combination moves nothing but bodies
 * without mass; a rod from the body to the ground. */
static mbsr_model *make(int seed, mbsr_data **d)
{
    test_rng rng = test_seed((uint64_t)seed);
    const mbsr_axis first[2] = {axis(MBSR_AXIS_ROTATION, 2), axis(MBSR_AXIS_TRANSLATION, 2)},
                    second[3] = {axis(MBSR_AXIS_TRANSLATION, 2), axis(MBSR_AXIS_TRANSLATION, 0),
                                 axis(MBSR_AXIS_ROTATION, 1)};
    const double centre[3] = {0.5, 0.5, -0.5}, tensor[6] = {0.3, 0.2, 0.3},
                 end[3] = {0.9, -0.2, 0.6}, edge[3] = {0, 1, 0};
    mbsr_frame A[3], B[2];
    mbsr_model *m;
    for (int k = 0; k < 3; ++k) A[k] = any_frame(&rng);
    for (int k = 0; k < 2; ++k) B[k] = any_frame(&rng);
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    test_add_body(m, MBSR_GROUND, mbsr_joint_compound(A, B, 2, first, NULL, NULL),
                  mbsr_inertia_zero());
    test_add_body(m, 0, mbsr_joint_compound(A + 1, B + 1, 3, second, NULL, NULL),
                  mbsr_inertia_zero());
    test_add_body(m, 1, mbsr_joint_prismatic(A + 2, NULL, edge),
                  mbsr_inertia_rigid(2.0, centre, tensor));
    const mbsr_closure_def rod = mbsr_closure_distance(MBSR_GROUND, NULL, 2, end, 2.4);
    assert_ok(mbsr_model_add_closure(m, &rod, NULL), mbsr_model_error(m));
    for (int k = 0; k < 3; ++k) {
        const mbsr_force_def damper = mbsr_force_joint_spring(1, k, 1.0, 2.0, 0.0);
        assert_ok(mbsr_model_add_force(m, &damper, NULL), mbsr_model_error(m));
    }
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_ok(mbsr_data_create(m, d, NULL), NULL);
    return m;
}

/* Rounding in that combination, which the least masses make large, is no hold. */
static void a_rod_does_not_hold_what_it_does_not_see(void **state)
{
    (void)state;
    for (int seed = 1; seed <= 60; ++seed) {
        mbsr_data *d;
        mbsr_model *m = make(seed, &d);
        test_rng rng = test_seed((uint64_t)seed + 100);
        double q[RATES], u[RATES] = {0.0}, udot[RATES];
        for (int k = 0; k < RATES; ++k) q[k] = 1.5 * test_uniform(&rng);
        const int status = mbsr_assemble(m, d, 0.0, q, NULL, q, NULL);
        if (status == MBSR_OK)
            assert_int_equal(mbsr_forward_dynamics(m, d, 0.0, q, u, NULL, udot), MBSR_UNDETERMINED);
        else
            assert_int_equal(status, MBSR_LOOP_OPEN);
        mbsr_data_destroy(d);
        mbsr_model_destroy(m);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_rod_does_not_hold_what_it_does_not_see)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
