/* Tolerances by kind of variable, and errors measured by the largest entry.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "own_joint.h"
#include "problems.h"
#include "reference_runs.h"

#include "ida/compat.h"

#include <mbsrank/driver.h>

#include <ida/ida.h>
#include <nvector/nvector_serial.h>
#include <stdbool.h>

/* ---- by kind ---- */

enum { BODIES = 5 };

/* Every kind: a body in the plane, a massless point on it, a body on a ball joint with a slide on
 * it, and a joint of which nothing is known. */
static mbsr_model *mixture(void)
{
    const double com[3] = {0.1, 0.2, 0.3}, tensor[6] = {1.0, 2.0, 2.5, 0.1, 0.2, 0.3}, mass = 7.0,
                 axis[3] = {1.0, 1.0, 0.0};
    mbsr_model *m = run_model();
    const int plane =
        run_body(m, "plane", MBSR_GROUND, mbsr_joint_planar_free(run_origin, run_origin),
                 mbsr_inertia_planar(3.0, (double[2]){0.1, 0.0}, 0.5));
    run_body(m, "point", plane, mbsr_joint_point(run_origin, 3, 0, NULL, NULL),
             mbsr_inertia_zero());
    const int ball = run_body(m, "ball", MBSR_GROUND, mbsr_joint_spherical(NULL, NULL),
                              mbsr_inertia_rigid(2.0, com, tensor));
    run_body(m, "slide", ball, mbsr_joint_prismatic(NULL, NULL, axis),
             mbsr_inertia_rigid(1.5, com, tensor));
    run_body(m, "own", MBSR_GROUND, mbsr_joint_custom(&test_own_table, 1, 1, NULL),
             mbsr_inertia_matrix(1, &mass));
    for (int k = 0; k < 2; ++k) {
        run_force(m, mbsr_force_axis_spring(1, MBSR_GROUND, k, 10.0, 2.0, 0.0));
    }
    return run_finish(m);
}

/* a: angles, l: lengths, o: others, in q and in u. */
static const char position_kinds[] = "llallaaaalo", velocity_kinds[] = "llallaaalo";

static double expected_atol(const mbsr_ida_opt *opt, char kind, bool rate)
{
    const double own = kind == 'a'   ? (rate ? opt->atol_angular_velocity : opt->atol_angle)
                       : kind == 'l' ? (rate ? opt->atol_velocity : opt->atol_length)
                                     : 0.0;
    return own > 0.0 ? own : opt->atol;
}

/* Masses of momenta at the start, that of the body in the plane by what it is. Of the point, which
 * has none, the largest on joints that move. */
static void masses(const mbsr_model *m, mbsr_data *d, const double *q, const double *u,
                   double *mass)
{
    double largest = 0.0;
    assert_ok(mbsr_stage_positions(m, d, 0.0, q), mbsr_data_error(d));
    assert_ok(mbsr_stage_velocities(m, d, u), mbsr_data_error(d));
    assert_ok(mbsr_stage_forces(m, d, NULL), mbsr_data_error(d));
    assert_ok(mbsr_stage_backward(m, d), mbsr_data_error(d));
    for (int i = 0; i < BODIES; ++i) {
        mbsr_rank_info info;
        assert_ok(mbsr_body_rank(m, d, i, &info), mbsr_data_error(d));
        int first, n;
        assert_ok(mbsr_body_coordinates(m, i, NULL, NULL, &first, &n), NULL);
        for (int k = first; k < first + n; ++k) {
            mass[k] = info.scale;
            if (velocity_kinds[k] == 'l') largest = fmax(largest, mass[k]);
        }
        assert_true((i == 1) == (info.scale == 0.0));
    }
    mass[2] = 0.5 + 3.0 * 0.1 * 0.1; /* m, com and moment: about its origin */
    mass[3] = mass[4] = largest;
}

/* The tolerances that IDA has, without their relative part. */
static void tolerances(const mbsr_model *m, mbsr_data *d, const mbsr_ida_opt *opt, const double *q,
                       const double *u, int size, double *found)
{
    mbsri_ida_messages messages = {0};
    double y[64], yp[64];
    mbsr_ida *ida = NULL;
    mbsr_error error = {0};
    SUNContext context = NULL;
    assert_int_equal(mbsr_dae_size(m, opt->form), size);
    assert_ok(mbsr_index1_reset(m, d), NULL);
    assert_ok(mbsr_dae_pack(m, d, opt->form, 0.0, q, u, y), mbsr_data_error(d));
    assert_ok(mbsr_dae_consistent(m, d, opt->form, 0.0, y, yp, NULL, NULL), mbsr_data_error(d));
    assert_ok(mbsr_ida_create(m, d, opt, &ida, &error), &error);
    for (int again = 0; again < 2; ++again) {
        assert_ok(mbsr_ida_start(ida, 0.0, y, yp), mbsr_ida_error(ida));
        assert_ok(mbsr_ida_advance(ida, 1e-4, NULL, NULL, NULL), mbsr_ida_error(ida));
    }
    assert_true(mbsri_ida_context(&context, &messages));
    N_Vector weights = N_VNew_Serial(size, context);
    assert_int_equal(IDAGetErrWeights(mbsr_ida_memory(ida), weights), IDA_SUCCESS);
    for (int k = 0; k < size; ++k) found[k] = 1.0 / N_VGetArrayPointer(weights)[k];
    N_VDestroy(weights);
    SUNContext_Free(&context);
    mbsr_ida_destroy(ida);
}

static void check_kinds(const mbsr_model *m, mbsr_data *d, const mbsr_ida_opt *opt)
{
    const double q[11] = {0.1, 0.2, 0.3, 0.0, 0.0, 1.0, 0.2, 0.0, 0.0, 0.4, 0.5};
    const double u[10] = {0.1, 0.2, 0.3, 0.0, 0.0, 0.2, 0.1, 0.3, 0.4, 0.5};
    const int nq = (int)strlen(position_kinds), nu = (int)strlen(velocity_kinds);
    const bool momentum = opt->form == MBSR_DAE_MOMENTUM, index1 = opt->form == MBSR_DAE_INDEX1;
    double found[64], mass[10];
    assert_int_equal(mbsr_model_nq(m), nq);
    assert_int_equal(mbsr_model_nu(m), nu);
    masses(m, d, q, u, mass);
    tolerances(m, d, opt, q, u, momentum ? nq + 2 * nu : nq + nu, found);
    for (int k = 0; k < nq; ++k) {
        const double atol = expected_atol(opt, position_kinds[k], false);
        assert_close(found[k] / atol, 1.0, 1e-12);
    }
    for (int i = 0; i < BODIES; ++i) {
        int first, n;
        double largest = 0.0; /* of sqrt(mass) atol, mass by kind */
        assert_ok(mbsr_body_coordinates(m, i, NULL, NULL, &first, &n), NULL);
        for (int k = first; k < first + n; ++k) {
            const double atol = expected_atol(opt, velocity_kinds[k], true);
            largest = fmax(largest, sqrt(mass[k]) * atol);
        }
        for (int k = first; k < first + n; ++k) {
            const double atol = expected_atol(opt, velocity_kinds[k], true);
            if (momentum) assert_close(found[nq + k] / (sqrt(mass[k]) * largest), 1.0, 1e-9);
            if (momentum) assert_close(found[nq + nu + k] / atol, 1.0, 1e-12);
            if (index1) assert_close(found[nq + k] / largest, 1.0, 1e-9);
            if (!momentum && !index1) assert_close(found[nq + k] / atol, 1.0, 1e-12);
        }
    }
}

static void each_kind_has_its_tolerance(void **state)
{
    (void)state;
    mbsr_model *m = mixture();
    mbsr_data *d = NULL;
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    for (int f = 0; f < RUN_FORMS; ++f) {
        for (int given = 0; given < 16; ++given) {
            mbsr_ida_opt opt = mbsr_default_ida_opt();
            assert_true(opt.atol_angle == 0.0 && opt.atol_length == 0.0 &&
                        opt.atol_angular_velocity == 0.0 && opt.atol_velocity == 0.0);
            opt.form = run_forms[f];
            opt.rtol = 1e-300;
            opt.atol = 1e-5;
            opt.initial_step = 1e-6;
            if (given & 1) opt.atol_angle = 2e-5;
            if (given & 2) opt.atol_length = 3e-5;
            if (given & 4) opt.atol_angular_velocity = 5e-6;
            if (given & 8) opt.atol_velocity = 7e-6;
            check_kinds(m, d, &opt);
        }
    }
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

/* Where nothing in the tree has a mass, p is tested with that of 1 kg. */
static void without_any_mass_momenta_have_a_tolerance(void **state)
{
    (void)state;
    mbsr_model *m = run_model();
    const double q[1] = {0.5}, u[1] = {0.0};
    double found[3];
    mbsr_data *d = NULL;
    run_cart(m, "cart", MBSR_GROUND, 0.0);
    run_force(m, mbsr_force_joint_spring(0, 0, 6.0, 2.0, 0.0));
    run_finish(m);
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.rtol = 1e-300;
    opt.atol = 1e-5;
    opt.atol_velocity = 3e-5;
    tolerances(m, d, &opt, q, u, 3, found);
    assert_close(found[0], 1e-5, 1e-17);
    assert_close(found[1], 3e-5, 1e-17);
    assert_close(found[2], 3e-5, 1e-17);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

static void wrong_tolerances_of_a_kind_are_refused(void **state)
{
    (void)state;
    problem p;
    problem_oscillator(&p, NULL);
    const double no[] = {NAN, INFINITY, -1e-6}, each[6] = {1e-6, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6};
    const char *const text[] = {" is nan", " is inf", " is -1e-06"};
    const char *const name[] = {"atol_angle", "atol_length", "atol_angular_velocity",
                                "atol_velocity"};
    for (int field = 0; field < 4; ++field) {
        for (int k = 0; k < 3; ++k) {
            mbsr_ida *ida = NULL;
            mbsr_error error = {0};
            mbsr_ida_opt opt = mbsr_default_ida_opt();
            double *const value[] = {&opt.atol_angle, &opt.atol_length, &opt.atol_angular_velocity,
                                     &opt.atol_velocity};
            *value[field] = no[k];
            assert_refused(mbsr_ida_create(p.model, p.data, &opt, &ida, &error), &error,
                           MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE, name[field]);
            assert_contains(error.text, text[k]);
            opt.atol_each = each; /* then they are not read */
            assert_ok(mbsr_ida_create(p.model, p.data, &opt, &ida, &error), &error);
            mbsr_ida_destroy(ida);
        }
    }
    problem_free(&p);
}

/* ---- the largest entry ---- */

/* Carts on springs of their own; only the first one moves, x = cos(10 t). */
static mbsr_model *carts(int count)
{
    mbsr_model *m = run_model();
    for (int k = 0; k < count; ++k) {
        const int cart = run_cart(m, NULL, MBSR_GROUND, 2.0);
        run_force(m, mbsr_force_joint_spring(cart, 0, 200.0, 0.0, 0.0));
    }
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    return m;
}

enum { MOST_CARTS = 100 };

typedef struct outcome {
    mbsr_ida_stats stats;
    double first; /* s, the first step */
    double error; /* of x at t = 3 */
} outcome;

/* `moving`: how many of them move, alike. */
static outcome run_carts(int count, int moving, mbsr_ida_opt opt)
{
    static double q[MOST_CARTS], u[MOST_CARTS], y[3 * MOST_CARTS], yp[3 * MOST_CARTS];
    outcome found;
    mbsr_model *m = carts(count);
    mbsr_data *d = NULL;
    mbsr_ida *ida = NULL;
    for (int k = 0; k < count; ++k) q[k] = k < moving ? 1.0 : 0.0;
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    assert_ok(mbsr_dae_pack(m, d, opt.form, 0.0, q, u, y), mbsr_data_error(d));
    assert_ok(mbsr_dae_consistent(m, d, opt.form, 0.0, y, yp, NULL, NULL), mbsr_data_error(d));
    assert_ok(mbsr_ida_create(m, d, &opt, &ida, NULL), NULL);
    assert_ok(mbsr_ida_start(ida, 0.0, y, yp), mbsr_ida_error(ida));
    assert_ok(mbsr_ida_advance(ida, 3.0, NULL, y, NULL), mbsr_ida_error(ida));
    found.error = fabs(y[0] - cos(30.0));
    found.stats = problem_stats(ida);
    assert_int_equal(IDAGetActualInitStep(mbsr_ida_memory(ida), &found.first), IDA_SUCCESS);
    mbsr_ida_destroy(ida);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
    return found;
}

static void bodies_at_rest_do_not_dilute_the_error(void **state)
{
    (void)state;
    for (int s = 0; s < 4; ++s) {
        mbsr_ida_opt opt = mbsr_default_ida_opt();
        assert_int_equal(opt.max_norm, 0);
        if (s == 3) opt.form = MBSR_DAE_RECURSIVE;
        if (s < 3) opt.linear_solver = (mbsr_ida_solver)(MBSR_IDA_DENSE + s);
        opt.rtol = opt.atol = 1e-7;
        opt.renew_matrices =
            0; /* steps of one run are chance, those of these have been looked at */
        const outcome alone = run_carts(1, 1, opt), among = run_carts(MOST_CARTS, 1, opt);
        opt.max_norm = 1;
        const outcome all_max = run_carts(MOST_CARTS, MOST_CARTS, opt);
        const outcome alone_max = run_carts(1, 1, opt), among_max = run_carts(MOST_CARTS, 1, opt);
        print_message("steps alone %ld, among %ld; largest entry %ld, %ld; errors %.1e %.1e %.1e "
                      "%.1e\n",
                      alone.stats.steps, among.stats.steps, alone_max.stats.steps,
                      among_max.stats.steps, alone.error, among.error, alone_max.error,
                      among_max.error);
        assert_true(among.stats.steps < alone.stats.steps);
        assert_less(3.0 * alone.error, among.error);
        assert_true(alone_max.stats.steps > alone.stats.steps);
        assert_true(alone_max.first == among_max.first);
        assert_true(alone_max.first == all_max.first);
        if (s + MBSR_IDA_DENSE == MBSR_IDA_KRYLOV) {
            /* the difference quotients depend on all entries */
            assert_close((double)among_max.stats.steps / (double)alone_max.stats.steps, 1.0, 0.02);
            continue;
        }
        assert_int_equal(among_max.stats.steps, alone_max.stats.steps);
        assert_int_equal(all_max.stats.steps, alone_max.stats.steps);
        assert_int_equal(among_max.stats.newton_iterations, alone_max.stats.newton_iterations);
        assert_true(among_max.error == alone_max.error);
    }
}

/* q, p and u have the same tolerance here; x'' = 100 is the largest of the second derivatives that
 * count, those of x and p. */
static void the_first_step_goes_with_the_largest_entry(void **state)
{
    (void)state;
    const double each[3] = {1e-7, 1e-7, 1e-7};
    for (int max_norm = 0; max_norm < 2; ++max_norm) {
        mbsr_ida_opt opt = mbsr_default_ida_opt();
        opt.max_norm = max_norm;
        opt.atol_each = each;
        opt.rtol = 1e-12;
        const outcome found = run_carts(1, 1, opt);
        const double bend = 100.0 / 1e-7 * (max_norm ? 1.0 : sqrt(1.0 / 3.0));
        assert_close(found.first * sqrt(bend), 1.0, 1e-3);
    }
}

/* What the error test leaves out does not limit the steps. */
static void algebraic_entries_stay_out_of_the_error_test(void **state)
{
    (void)state;
    outcome found[2];
    for (int suppress = 0; suppress < 2; ++suppress) {
        double each[3] = {1e-5, 1e-5, 1e-9};
        mbsr_ida_opt opt = mbsr_default_ida_opt();
        opt.max_norm = 1;
        opt.atol_each = each;
        opt.rtol = 1e-12;
        opt.suppress_algebraic = suppress;
        found[suppress] = run_carts(1, 1, opt);
    }
    assert_true(found[0].stats.steps > 2 * found[1].stats.steps);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_kind_has_its_tolerance),
        cmocka_unit_test(without_any_mass_momenta_have_a_tolerance),
        cmocka_unit_test(wrong_tolerances_of_a_kind_are_refused),
        cmocka_unit_test(bodies_at_rest_do_not_dilute_the_error),
        cmocka_unit_test(the_first_step_goes_with_the_largest_entry),
        cmocka_unit_test(algebraic_entries_stay_out_of_the_error_test),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
