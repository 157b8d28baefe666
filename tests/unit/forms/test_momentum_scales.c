/* The masses by which momenta are tested, beside ranks and the mass matrix.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "duration.h"
#include "expect.h"
#include "rigid_tree.h"
#include "units.h"

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

enum { KINDS = 3 };

/* Of the joint of each body, and the largest by kinds of rates. */
static void scales_of(const mbsr_model *m, mbsr_data *d, double *scale, double *largest)
{
    for (int k = 0; k < KINDS; ++k) largest[k] = 0.0;
    for (int i = 0; i < mbsr_model_bodies(m); ++i) {
        mbsr_rank_info info;
        mbsr_coordinate_kind kind[MBSR_MAX_D];
        assert_ok(mbsr_body_rank(m, d, i, &info), mbsr_data_error(d));
        assert_ok(mbsr_body_coordinate_kinds(m, i, NULL, kind), NULL);
        scale[i] = info.scale;
        for (int k = 0; k < info.n; ++k)
            largest[(int)kind[k]] = fmax(largest[(int)kind[k]], info.scale);
    }
}

/* The scale of the joint, or 3 % of the diagonal entry; without mass the largest of the kind, where
 * there is one. Ranks are there afterwards as before. Returns how many are of the diagonal. */
static int check(const mbsr_model *m, mbsr_data *d)
{
    const int nu = mbsr_model_nu(m), bodies = mbsr_model_bodies(m);
    double *mass = calloc((size_t)(nu + 2 * bodies + nu * nu) + 1, sizeof *mass),
           *scale = mass + nu, *again = scale + bodies, *matrix = again + bodies, largest[KINDS];
    int raised = 0;
    scales_of(m, d, scale, largest);
    assert_ok(mbsr_momentum_scales(m, d, mass), mbsr_data_error(d));
    scales_of(m, d, again, largest);
    assert_ok(mbsr_mass_matrix(m, d, matrix), mbsr_data_error(d));
    for (int i = 0; i < bodies; ++i) {
        int u, n;
        mbsr_coordinate_kind kind[MBSR_MAX_D];
        assert_ok(mbsr_body_coordinates(m, i, NULL, NULL, &u, &n), NULL);
        assert_ok(mbsr_body_coordinate_kinds(m, i, NULL, kind), NULL);
        assert_true(again[i] == scale[i]);
        for (int k = u; k < u + n; ++k) {
            const double locked = 0.03 * matrix[k * (nu + 1)],
                         own = scale[i] > 0.0 ? scale[i] : largest[(int)kind[k - u]],
                         expected = fmax(own, locked);
            assert_true(mass[k] > 0.0);
            if (own > 0.0) assert_close(mass[k], expected, 1e-12 * expected);
            raised += scale[i] > 0.0 && locked > scale[i];
        }
    }
    free(mass);
    return raised;
}

/* A slider of 2 kg carries a wheel of 1 kg, which carries an arm on a hinge, without mass. */
static void masses_of_kinds(const units *s, double *mass)
{
    const double up[3] = {0.0, 0.0, 1.0}, zero[3] = {0.0};
    const double tensor = 0.5 * s->mass * s->length * s->length;
    const mbsr_joint turns = mbsr_joint_revolute(NULL, NULL, up);
    const mbsr_inertia inertias[3] = {
        mbsr_inertia_particle(2.0 * s->mass),
        mbsr_inertia_rigid(s->mass, zero, (const double[6]){tensor, tensor, tensor}),
        mbsr_inertia_zero()};
    mbsr_model *m = NULL;
    mbsr_data *d = NULL;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    for (int k = 0; k < 3; ++k) {
        mbsr_body_def body = mbsr_default_body_def();
        body.parent = k - 1;
        body.joint = k == 0 ? mbsr_joint_prismatic(NULL, NULL, up) : turns;
        body.inertia = inertias[k];
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    }
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    run_to_backward(m, d, 0.0, zero, zero);
    assert_ok(mbsr_momentum_scales(m, d, mass), mbsr_data_error(d));
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

/* The arm has the wheel's kg m^2, not the slider's kg. */
static void no_kind_has_the_mass_of_another(void **state)
{
    (void)state;
    for (size_t k = 0; k < sizeof systems / sizeof *systems; ++k) {
        const units *s = systems + k;
        const double turned = s->mass * s->length * s->length;
        double mass[3];
        masses_of_kinds(s, mass);
        assert_close(mass[1] / turned, 0.5, 1e-12);
        assert_close(mass[2] / mass[1], 1.0, 1e-12);
    }
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
        cmocka_unit_test(no_kind_has_the_mass_of_another),
        cmocka_unit_test(random_trees),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
