/* The masses by which momenta are tested, beside ranks and the mass matrix.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "duration.h"
#include "expect.h"
#include "rigid_tree.h"

#include <mbsrank/mbsrank.h>
#include <mbsrank/driver.h>

#include <math.h>
#include <stdlib.h>

static void run_to_backward(const mbsr_model *m, mbsr_data *d, double t, const double *q,
                            const double *u)
{
    assert_ok(mbsr_stage_positions(m, d, t, q), mbsr_data_error(d));
    assert_ok(mbsr_stage_velocities(m, d, u), mbsr_data_error(d));
    assert_ok(mbsr_stage_forces(m, d, NULL), mbsr_data_error(d));
    assert_ok(mbsr_stage_backward(m, d), mbsr_data_error(d));
}

/* Of the joint of each body; returns the largest. */
static double scales_of(const mbsr_model *m, mbsr_data *d, double *scale)
{
    double largest = 0.0;
    for (int i = 0; i < mbsr_model_bodies(m); ++i) {
        mbsr_rank_info info;
        assert_ok(mbsr_body_rank(m, d, i, &info), mbsr_data_error(d));
        scale[i] = info.scale;
        largest = fmax(largest, info.scale);
    }
    return largest;
}

/* The scale of the joint, or 3 % of the diagonal entry; ranks are there afterwards as before.
 * Returns how many are the latter. */
static int check(const mbsr_model *m, mbsr_data *d)
{
    const int nu = mbsr_model_nu(m), bodies = mbsr_model_bodies(m);
    double *mass = calloc((size_t)(nu + 2 * bodies + nu * nu) + 1, sizeof *mass),
           *scale = mass + nu, *again = scale + bodies, *matrix = again + bodies;
    int raised = 0;
    const double largest = scales_of(m, d, scale);
    assert_ok(mbsr_momentum_scales(m, d, mass), mbsr_data_error(d));
    scales_of(m, d, again);
    assert_ok(mbsr_mass_matrix(m, d, matrix), mbsr_data_error(d));
    for (int i = 0; i < bodies; ++i) {
        int u, n;
        assert_ok(mbsr_body_coordinates(m, i, NULL, NULL, &u, &n), NULL);
        assert_true(again[i] == scale[i]);
        for (int k = u; k < u + n; ++k) {
            const double locked = 0.03 * matrix[k * (nu + 1)],
                         expected = scale[i] > 0.0 ? fmax(scale[i], locked) : largest;
            assert_close(mass[k], expected, 1e-12 * largest);
            raised += scale[i] > 0.0 && locked > scale[i];
        }
    }
    free(mass);
    return raised;
}

static void light_carriers_are_tested_as_what_they_carry(void **state)
{
    (void)state;
    const double up[3] = {0.0, 0.0, 1.0}, mass[3] = {1e-3, 1e-5, 400.0}, zero[3] = {0.0};
    mbsr_model *m = NULL;
    mbsr_data *d = NULL;
    double found[3];
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    for (int k = 0; k < 3; ++k) {
        mbsr_body_def body = mbsr_default_body_def();
        body.parent = k - 1;
        body.joint = mbsr_joint_prismatic(NULL, NULL, up);
        body.inertia = mbsr_inertia_particle(mass[k]);
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    }
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    run_to_backward(m, d, 0.0, zero, zero);
    assert_ok(mbsr_momentum_scales(m, d, found), mbsr_data_error(d));
    assert_close(found[0], 0.03 * (400.0 + 1e-3 + 1e-5), 1e-12);
    assert_in_range((int)found[1], 12,
                    800); /* by the scale, too, in which twice 400 has cancelled */
    assert_close(found[2], 400.0, 1e-10);
    assert_int_equal(check(m, d), 1);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

static void random_trees(void **state)
{
    (void)state;
    int raised = 0;
    for (uint64_t seed = 1; seed <= (uint64_t)test_seeds(10, 60); ++seed) {
        test_rigid_tree s;
        test_rigid_tree_make(&s, (test_rigid_choice){.seed = seed,
                                                     .bodies = 12,
                                                     .massless = 0.1,
                                                     .light = 0.3,
                                                     .points = 0.3,
                                                     .many = 0.5,
                                                     .branching = 0.5,
                                                     .length = 0.5,
                                                     .shuffle = 1,
                                                     .held = 0.1,
                                                     .armature = 0.2});
        run_to_backward(s.model, s.data, s.t, s.q, s.u);
        raised += check(s.model, s.data);
        test_rigid_tree_free(&s);
    }
    assert_true(raised > 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(light_carriers_are_tested_as_what_they_carry),
        cmocka_unit_test(random_trees),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
