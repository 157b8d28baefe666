/* Amendments that a caller states: mass added to a body, joint coordinates held fixed.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"

#include "tree.h"

#include <stdlib.h>

static const mbsr_planar_frame origin = {0};
static const mbsr_planar_frame tip = {1.0, 0.2, 0.4};

static mbsr_model *empty(void)
{
    mbsr_model *m;
    assert_int_equal(mbsr_model_create(NULL, &m, NULL), MBSR_OK);
    return m;
}

static int add(mbsr_model *m, int parent, mbsr_joint joint, mbsr_inertia inertia)
{
    mbsr_body_def body = mbsr_default_body_def();
    int id = -1;
    body.name = "link";
    body.parent = parent;
    body.joint = joint;
    body.inertia = inertia;
    assert_ok(mbsr_model_add_body(m, &body, &id), mbsr_model_error(m));
    return id;
}

static void add_force(mbsr_model *m, mbsr_force_def force)
{
    assert_ok(mbsr_model_add_force(m, &force, NULL), mbsr_model_error(m));
}

static mbsr_data *finish(mbsr_model *m)
{
    mbsr_data *d = NULL;
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_int_equal(mbsr_data_create(m, &d, NULL), MBSR_OK);
    return d;
}

static void release(mbsr_model *m, mbsr_data *d)
{
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

static const double com[2] = {0.4, -0.1};

static mbsr_inertia rod(void)
{
    return mbsr_inertia_planar(1.3, com, 0.2);
}

/* Inverse and forward dynamics, momentum residual and pose of the last body of two models with the
 * same coordinates agree. */
static void assert_same_motion(const mbsr_model *a, mbsr_data *da, const mbsr_model *b,
                               mbsr_data *db)
{
    enum { MOST = 8 };
    double q[MOST], u[MOST], udot[MOST], ra[3 * MOST] = {0}, rb[3 * MOST] = {0}, y[3 * MOST],
                                                yp[3 * MOST];
    test_rng rng = test_seed(5);
    const int n = mbsr_model_nu(a), last = mbsr_model_bodies(a) - 1;
    assert_int_equal(mbsr_model_nu(b), n);
    assert_int_equal(mbsr_model_nq(a), n);
    assert_int_equal(mbsr_model_nq(b), n);
    test_fill(&rng, MOST, q);
    test_fill(&rng, MOST, u);
    test_fill(&rng, MOST, udot);
    test_fill(&rng, 3 * MOST, y);
    test_fill(&rng, 3 * MOST, yp);
    assert_ok(mbsr_inverse_dynamics(a, da, 0.3, q, u, udot, NULL, ra), mbsr_data_error(da));
    assert_ok(mbsr_inverse_dynamics(b, db, 0.3, q, u, udot, NULL, rb), mbsr_data_error(db));
    for (int k = 0; k < n; ++k) assert_close(ra[k], rb[k], 1e-12);
    assert_ok(mbsr_forward_dynamics(a, da, 0.3, q, u, NULL, ra), mbsr_data_error(da));
    assert_ok(mbsr_forward_dynamics(b, db, 0.3, q, u, NULL, rb), mbsr_data_error(db));
    for (int k = 0; k < n; ++k) assert_close(ra[k], rb[k], 1e-10);
    assert_ok(mbsr_body_pose(a, da, last, ra), mbsr_data_error(da));
    assert_ok(mbsr_body_pose(b, db, last, rb), mbsr_data_error(db));
    for (int k = 0; k < 3; ++k) assert_close(ra[k], rb[k], 1e-14);
    assert_ok(mbsr_dae_residual(a, da, MBSR_DAE_MOMENTUM, 0.3, y, yp, ra), mbsr_data_error(da));
    assert_ok(mbsr_dae_residual(b, db, MBSR_DAE_MOMENTUM, 0.3, y, yp, rb), mbsr_data_error(db));
    for (int k = 0; k < 3 * n; ++k) assert_close(ra[k], rb[k], 1e-11);
}

/* Base, a middle body on the joint given, with `held` coordinates locked at zero, and a tip. */
static mbsr_model *chain(mbsr_joint middle, int first, int second)
{
    mbsr_model *m = empty();
    add(m, MBSR_GROUND, mbsr_joint_planar_revolute(origin, origin), rod());
    add(m, 0, middle, rod());
    add(m, 1, mbsr_joint_planar_revolute(tip, origin), rod());
    if (first >= 0) assert_ok(mbsr_model_lock(m, 1, first, 0.0), mbsr_model_error(m));
    if (second >= 0) assert_ok(mbsr_model_lock(m, 1, second, 0.0), mbsr_model_error(m));
    add_force(m, mbsr_force_gravity(0.0, -9.81, 0.0));
    return m;
}

static void a_locked_joint_is_the_smaller_joint(void **state)
{
    (void)state;
    const struct {
        mbsr_joint larger;
        int first, second;
        mbsr_joint smaller;
    } cases[] = {
        {mbsr_joint_planar_revolute(tip, origin), 0, -1, mbsr_joint_planar_weld(tip, origin)},
        {mbsr_joint_planar_pin_slot(tip, origin), 0, -1, mbsr_joint_planar_revolute(tip, origin)},
        {mbsr_joint_planar_pin_slot(tip, origin), 1, -1, mbsr_joint_planar_prismatic(tip, origin)},
        {mbsr_joint_planar_free(tip, tip), 2, 0,
         mbsr_joint_planar(tip, tip, MBSR_Y, 0, NULL, NULL)},
    };
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; ++k) {
        mbsr_model *a = chain(cases[k].larger, cases[k].first, cases[k].second),
                   *b = chain(cases[k].smaller, -1, -1);
        mbsr_data *da = finish(a), *db = finish(b);
        int n = -1, nq = -1;
        assert_int_equal(mbsr_body_locks(a, 1), cases[k].second < 0 ? 1 : 2);
        assert_int_equal(mbsr_body_locks(b, 1), 0);
        assert_int_equal(mbsr_body_coordinates(a, 1, NULL, &nq, NULL, &n), MBSR_OK);
        assert_int_equal(n, cases[k].smaller.n);
        assert_int_equal(nq, cases[k].smaller.n);
        assert_same_motion(a, da, b, db);
        release(a, da);
        release(b, db);
    }
}

/* A value other than zero: the same as a frame moved by it. */
static void a_coordinate_is_held_at_its_value(void **state)
{
    (void)state;
    const double angle = 0.7;
    mbsr_model *a = empty(), *b = empty();
    add(a, MBSR_GROUND, mbsr_joint_planar_pin_slot(tip, tip), rod());
    add(a, 0, mbsr_joint_planar_revolute(tip, origin), rod());
    assert_int_equal(mbsr_model_lock(a, 0, 1, angle), MBSR_OK);
    add(b, MBSR_GROUND,
        mbsr_joint_planar_prismatic(tip, (mbsr_planar_frame){tip.x, tip.y, tip.angle - angle}),
        rod());
    add(b, 0, mbsr_joint_planar_revolute(tip, origin), rod());
    mbsr_data *da = finish(a), *db = finish(b);
    assert_same_motion(a, da, b, db);
    release(a, da);
    release(b, db);
}

/* Joints with K other than the unit matrix, analytic rates and rates by differences. */
static void general_joints_lose_the_column(void **state)
{
    (void)state;
    mbsr_joint_table slow = test_joint_table;
    slow.rates = NULL;
    const mbsr_joint_table *const tables[] = {&test_joint_table, &slow};
    for (int t = 0; t < 2; ++t) {
        test_joint larger = {.d = 4, .d_pred = 0, .n = 3, .a = 0.3}, smaller;
        test_rng rng = test_seed(11);
        double mass[16] = {0};
        test_fill(&rng, 16, larger.K0);
        for (int k = 0; k < 16; ++k) larger.K0[k] *= 0.1;
        for (int k = 0; k < 4; ++k) larger.K0[5 * k] += 1.0, mass[5 * k] = 1.0 + k;
        test_fill(&rng, 12, larger.J0);
        test_fill(&rng, 4, larger.g);
        test_fill(&rng, 3, larger.v);
        smaller = larger;
        smaller.n = 2;
        for (int k = 0; k < 4; ++k) smaller.J0[4 + k] = larger.J0[8 + k];
        smaller.v[1] = larger.v[2];
        mbsr_model *a = empty(), *b = empty();
        add(a, MBSR_GROUND, mbsr_joint_custom(tables[t], 4, 3, &larger),
            mbsr_inertia_matrix(4, mass));
        assert_int_equal(mbsr_model_lock(a, 0, 1, 0.0), MBSR_OK);
        add(b, MBSR_GROUND, mbsr_joint_custom(tables[t], 4, 2, &smaller),
            mbsr_inertia_matrix(4, mass));
        mbsr_data *da = finish(a), *db = finish(b);
        assert_same_motion(a, da, b, db);
        release(a, da);
        release(b, db);
    }
}

/* Forces on joint coordinates count those that the joint has. */
static void joint_forces_count_locked_coordinates_too(void **state)
{
    (void)state;
    mbsr_model *a = chain(mbsr_joint_planar_pin_slot(tip, origin), 0, -1),
               *b = chain(mbsr_joint_planar_revolute(tip, origin), -1, -1),
               *c = chain(mbsr_joint_planar_pin_slot(tip, origin), 0, -1);
    add_force(a, mbsr_force_joint_spring(1, 1, 40.0, 3.0, 0.1));
    add_force(b, mbsr_force_joint_spring(1, 0, 40.0, 3.0, 0.1));
    add_force(c, mbsr_force_joint_spring(1, 2, 40.0, 3.0, 0.1));
    mbsr_data *da = finish(a), *db = finish(b);
    assert_same_motion(a, da, b, db);
    assert_refused(mbsr_model_finish(c), mbsr_model_error(c), MBSR_ERR_VALUE, MBSR_NONE, 1,
                   "body 1 'link'|coordinate is 2|has 2");
    release(a, da);
    release(b, db);
    mbsr_model_destroy(c);
}

static int no_mass(void *user, double t, const double *p, const double *V, double *M, double *h)
{
    (void)user, (void)t, (void)p, (void)V, (void)M, (void)h;
    return 0;
}

/* The same mass as regularisation and as inertia, beside every kind of inertia. */
static void a_regularisation_is_mass(void **state)
{
    (void)state;
    const double added[9] = {2, 0, 0, 0, 2, 0, 0, 0, 0.5}, both[9] = {5, 0, 0, 0, 5, 0, 0, 0, 0.5};
    const double three[9] = {3, 0, 0, 0, 3, 0, 0, 0, 0};
    const struct {
        mbsr_inertia base, sum;
    } cases[] = {
        {mbsr_default_body_def().inertia, mbsr_inertia_matrix(3, added)},
        {mbsr_inertia_zero(), mbsr_inertia_planar(2.0, (double[2]){0}, 0.5)},
        {mbsr_inertia_particle(3.0), mbsr_inertia_matrix(3, both)},
        {mbsr_inertia_matrix(3, three), mbsr_inertia_matrix(3, both)},
        {mbsr_inertia_planar(3.0, (double[2]){0}, 0.0), mbsr_inertia_matrix(3, both)},
        {mbsr_inertia_function(no_mass, NULL), mbsr_inertia_matrix(3, added)},
    };
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; ++k) {
        mbsr_model *m[2] = {empty(), empty()};
        mbsr_data *d[2];
        for (int side = 0; side < 2; ++side) {
            add(m[side], MBSR_GROUND, mbsr_joint_planar_free(origin, tip),
                side ? cases[k].sum : cases[k].base);
            add(m[side], 0, mbsr_joint_planar_revolute(tip, origin), rod());
            if (!side) assert_int_equal(mbsr_model_regularise(m[0], 0, 3, added), MBSR_OK);
            add_force(m[side], mbsr_force_gravity(0.0, -9.81, 0.0));
            d[side] = finish(m[side]);
        }
        assert_memory_equal(mbsr_body_regularisation(m[0], 0), added, sizeof added);
        assert_null(mbsr_body_regularisation(m[0], 1));
        assert_null(mbsr_body_regularisation(m[1], 0));
        assert_same_motion(m[0], d[0], m[1], d[1]);
        release(m[0], d[0]);
        release(m[1], d[1]);
    }
}

enum { AS_IS, LOCKED, REGULARISED };

/* A massless flap on a rod: what the report says, and what becomes of it. */
static void what_the_report_advises_helps(void **state)
{
    (void)state;
    const int undetermined[] = {1, 0, 0}, dynamic[] = {1, 1, 2};
    const double moment[9] = {0, 0, 0, 0, 0, 0, 0, 0, 1e-3};
    for (int way = AS_IS; way <= REGULARISED; ++way) {
        mbsr_model *m = empty();
        add(m, MBSR_GROUND, mbsr_joint_planar_revolute(origin, origin), rod());
        add(m, 0, mbsr_joint_planar_revolute(tip, origin), mbsr_inertia_zero());
        if (way == LOCKED) assert_int_equal(mbsr_model_lock(m, 1, 0, 0.2), MBSR_OK);
        if (way == REGULARISED) assert_int_equal(mbsr_model_regularise(m, 1, 3, moment), MBSR_OK);
        mbsr_data *d = finish(m);
        const double q[2] = {0.3, 0.4}, u[2] = {1.0, -2.0};
        mbsr_index_report *report;
        assert_ok(mbsr_index_report_create(m, d, 0.0, q, u, &report), mbsr_data_error(d));
        assert_int_equal(report->undetermined, undetermined[way]);
        assert_int_equal(report->dynamic, dynamic[way]);
        assert_int_equal(report->index, way == AS_IS ? -1 : 0);
        assert_contains(report->text, way == AS_IS ? "body 1 'link'|inertia|lock it" : "");
        mbsr_index_report_destroy(m, report);
        release(m, d);
    }
}

static int rates_of_two(const mbsr_joint_args *args, double *qdot)
{
    qdot[0] = args->u[0];
    return 0;
}

static void refusals_name_the_body_and_change_nothing(void **state)
{
    (void)state;
    const double one[1] = {1.0}, good[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1},
                 negative[9] = {1, 0, 0, 0, -1, 0, 0, 0, 1}, skew[9] = {1, 1, 0, 0, 1, 0, 0, 0, 1};
    mbsr_model *m = empty();
    const mbsr_error *e = mbsr_model_error(m);
    add(m, MBSR_GROUND, mbsr_joint_planar_pin_slot(origin, origin), rod());
    assert_int_equal(mbsr_model_lock(NULL, 0, 0, 0.0), MBSR_ERR_NULL);
    assert_int_equal(mbsr_model_regularise(NULL, 0, 3, good), MBSR_ERR_NULL);
    assert_refused(mbsr_model_lock(m, 1, 0, 0.0), e, MBSR_ERR_ID, -2, -2, "mbsr_model_lock|body 1");
    assert_refused(mbsr_model_lock(m, -1, 0, 0.0), e, MBSR_ERR_ID, -2, -2, "no body -1");
    assert_refused(mbsr_model_lock(m, 0, 2, 0.0), e, MBSR_ERR_VALUE, 0, -2, "'link'|is 2|has 2");
    assert_refused(mbsr_model_lock(m, 0, -1, 0.0), e, MBSR_ERR_VALUE, 0, -2, "coordinate is -1");
    assert_refused(mbsr_model_lock(m, 0, 0, NAN), e, MBSR_ERR_VALUE, 0, -2, "value is");
    assert_int_equal(mbsr_model_lock(m, 0, 0, 1.0), MBSR_OK);
    assert_refused(mbsr_model_lock(m, 0, 0, 1.0), e, MBSR_ERR_VALUE, 0, -2, "locked already");
    assert_refused(mbsr_model_regularise(m, 5, 3, good), e, MBSR_ERR_ID, -2, -2, "no body 5");
    assert_refused(mbsr_model_regularise(m, 0, 3, NULL), e, MBSR_ERR_NULL, 0, -2, "matrix is NULL");
    assert_refused(mbsr_model_regularise(m, 0, 0, good), e, MBSR_ERR_VALUE, 0, -2, "d must be");
    assert_refused(mbsr_model_regularise(m, 0, 1, one), e, MBSR_ERR_VALUE, 0, -2, "1 x 1|d = 3");
    assert_refused(mbsr_model_regularise(m, 0, 3, negative), e, MBSR_ERR_VALUE, 0, -2,
                   "'link'|mbsr_model_regularise|negative");
    assert_refused(mbsr_model_regularise(m, 0, 3, skew), e, MBSR_ERR_VALUE, 0, -2, "symmetric");
    assert_int_equal(mbsr_model_regularise(m, 0, 3, good), MBSR_OK);
    assert_refused(mbsr_model_regularise(m, 0, 3, good), e, MBSR_ERR_VALUE, 0, -2, "already");

    mbsr_joint_table table = test_joint_table;
    table.coordinate_rates = rates_of_two;
    test_joint joint = {.d = 1, .n = 1, .K0 = {1.0}, .J0 = {1.0}};
    add(m, MBSR_GROUND, mbsr_joint_custom(&table, 1, 1, &joint), mbsr_inertia_zero());
    assert_refused(mbsr_model_lock(m, 1, 0, 0.0), e, MBSR_ERR_SPACE, 1, -2, "rates other than u");
    assert_int_equal(mbsr_body_locks(m, 0), -1);
    assert_null(mbsr_body_regularisation(m, 0));
    mbsr_data *d = finish(m);
    assert_int_equal(mbsr_model_nu(m), 2);
    assert_int_equal(mbsr_body_locks(m, 0), 1);
    assert_int_equal(mbsr_body_locks(m, 7), -1);
    assert_int_equal(mbsr_body_locks(m, MBSR_GROUND), -1);
    assert_refused(mbsr_model_lock(m, 0, 1, 0.0), e, MBSR_ERR_FINISHED, -2, -2, "finished");
    assert_refused(mbsr_model_regularise(m, 0, 3, good), e, MBSR_ERR_FINISHED, -2, -2, "finished");
    release(m, d);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_locked_joint_is_the_smaller_joint),
        cmocka_unit_test(a_coordinate_is_held_at_its_value),
        cmocka_unit_test(general_joints_lose_the_column),
        cmocka_unit_test(joint_forces_count_locked_coordinates_too),
        cmocka_unit_test(a_regularisation_is_mass),
        cmocka_unit_test(what_the_report_advises_helps),
        cmocka_unit_test(refusals_name_the_body_and_change_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
