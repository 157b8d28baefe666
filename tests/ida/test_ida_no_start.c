/* Massless bodies for which no consistent start exists, because no force determines a direction or
 * no position balances the forces: refused by every form, and the state stays as it was.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "reference_runs.h"

#include <mbsrank/driver.h>

enum { SIZE_MOST = 16 };

/* Refused with this status, body and words, y and yp unchanged, in every form. */
static void check_refusal(const mbsr_model *m, const double *q, const double *u, int status,
                          int body, const char *words)
{
    mbsr_data *d = NULL;
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    for (int f = 0; f < RUN_FORMS; ++f) {
        double y[SIZE_MOST], yp[SIZE_MOST], y_before[SIZE_MOST], yp_before[SIZE_MOST];
        const int size = mbsr_dae_size(m, run_forms[f]);
        assert_in_range(size, 1, SIZE_MOST);
        for (int k = 0; k < SIZE_MOST; ++k) y[k] = yp[k] = 0.125 * k - 3.0;
        assert_ok(mbsr_dae_pack(m, d, run_forms[f], 0.0, q, u, y), mbsr_data_error(d));
        memcpy(y_before, y, sizeof y);
        memcpy(yp_before, yp, sizeof yp);
        mbsr_consistent_info info;
        assert_refused(mbsr_dae_consistent(m, d, run_forms[f], 0.0, y, yp, NULL, &info),
                       mbsr_data_error(d), status, body, MBSR_NONE, words);
        assert_memory_equal(y, y_before, sizeof y);
        assert_memory_equal(yp, yp_before, sizeof yp);
        assert_null(strstr(mbsr_data_error(d)->text, "nan"));
    }
    mbsr_data_destroy(d);
}

/* Found: the same models with what was missing. */
static void check_start(const mbsr_model *m, const double *q, const double *u, double q0,
                        double tolerance)
{
    mbsr_data *d = NULL;
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    for (int f = 0; f < RUN_FORMS; ++f) {
        double y[SIZE_MOST], yp[SIZE_MOST];
        assert_ok(mbsr_dae_pack(m, d, run_forms[f], 0.0, q, u, y), mbsr_data_error(d));
        assert_ok(mbsr_dae_consistent(m, d, run_forms[f], 0.0, y, yp, NULL, NULL),
                  mbsr_data_error(d));
        assert_close(y[0], q0, tolerance);
    }
    mbsr_data_destroy(d);
}

/* ---- undetermined ---- */

/* Between ground and mass two massless carts; `spring` ties the second one to the first. */
static mbsr_model *loose_chain(double spring, double damping)
{
    mbsr_model *m = run_model();
    const int first = run_cart(m, "first", MBSR_GROUND, 0.0),
              second = run_cart(m, "second", first, 0.0);
    run_cart(m, "mass", second, 1.0);
    run_force(m, mbsr_force_axis_spring(first, MBSR_GROUND, 0, 10.0, 2.0, 0.0));
    run_force(m, mbsr_force_axis_spring(second, first, 0, spring, damping, 0.0));
    return run_finish(m);
}

static void massless_cart_without_any_force(void **unused)
{
    (void)unused;
    const double q[3] = {0.0, 0.2, 0.3}, u[3] = {0.1, -0.2, 0.3};
    mbsr_model *m = loose_chain(0.0, 0.0);
    check_refusal(m, q, u, MBSR_UNDETERMINED, 1, "second|moves no mass");
    mbsr_model_destroy(m);
    m = loose_chain(3.0, 0.0); /* elastic: the second cart goes where its spring is at rest */
    check_start(m, q, u, 0.0, 1e-9);
    mbsr_model_destroy(m);
}

/* A massless point in the plane; only x is held unless the spring along y has a stiffness. */
static mbsr_model *half_held_point(double along_y)
{
    mbsr_model *m = run_model();
    const int node = run_body(m, "node", MBSR_GROUND, mbsr_joint_point_free(), mbsr_inertia_zero());
    run_body(m, "mass", node, mbsr_joint_point_free(), mbsr_inertia_particle(1.0));
    run_force(m, mbsr_force_axis_spring(node, MBSR_GROUND, 0, 10.0, 2.0, 0.0));
    run_force(m, mbsr_force_axis_spring(node, MBSR_GROUND, 1, along_y, 0.0, 0.0));
    return run_finish(m);
}

static void massless_point_held_along_one_axis_only(void **unused)
{
    (void)unused;
    const double q[4] = {0.3, 0.2, 0.1, 0.4}, u[4] = {0.1, -0.2, 0.3, 0.2};
    mbsr_model *m = half_held_point(0.0);
    check_refusal(m, q, u, MBSR_UNDETERMINED, 0, "node|moves no mass");
    mbsr_model_destroy(m);
    m = half_held_point(5.0);
    check_start(m, q, u, 0.3, 1e-12);
    mbsr_model_destroy(m);
}

/* ---- infeasible ---- */

/* Force -S q / sqrt(1 + q^2) + F along x: balanced at q = F / sqrt(S^2 - F^2), nowhere if F > S. */
typedef struct saturation {
    double S, F;
} saturation;

static int saturate(const mbsr_force_args *args)
{
    const saturation *w = args->force->user;
    const double q = args->body[0].q[0];
    args->body[0].tau[0] += w->F - w->S * q / sqrt(1.0 + q * q);
    return MBSR_OK;
}

static const mbsr_force_table saturated_spring = {
    .version = MBSR_FORCE_TABLE_VERSION,
    .name = "saturated spring",
    .evaluate = saturate,
};

/* w must outlive the model. */
static mbsr_model *pulled_node(saturation *w)
{
    mbsr_model *m = run_model();
    const int node = run_cart(m, "node", MBSR_GROUND, 0.0);
    run_cart(m, "mass", node, 1.0);
    run_force(m, mbsr_force_custom(&saturated_spring, 1, &node, w));
    return run_finish(m);
}

static void force_beyond_what_the_spring_can_balance(void **unused)
{
    (void)unused;
    const double starts[] = {0.0, 0.5, -2.0}, u[2] = {0.1, -0.2};
    for (int k = 0; k < 3; ++k) {
        const double q[2] = {starts[k], 0.3};
        saturation w = {.S = 2.0, .F = 4.0};
        mbsr_model *m = pulled_node(&w);
        check_refusal(m, q, u, MBSR_NO_CONVERGENCE, 0, "node|no position balances");
        w.F = 1.0;
        check_start(m, q, u, 1.0 / sqrt(3.0), 1e-11);
        mbsr_model_destroy(m);
    }
}

/* ---- starts that are handed to the driver as they are ---- */

/* The state q, u of two carts, packed in a form, is refused by the driver and names the first cart.
 */
static void check_driver(const mbsr_model *m, const double *q, const double *u, bool refused)
{
    mbsr_data *d = NULL;
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    for (int f = 0; f < RUN_FORMS; ++f) {
        double y[SIZE_MOST], yp[SIZE_MOST] = {0.0}, share;
        int body;
        mbsr_ida *ida = NULL;
        mbsr_ida_opt opt = mbsr_default_ida_opt();
        opt.form = run_forms[f];
        mbsr_index1_reset(m, d);
        assert_ok(mbsr_dae_pack(m, d, run_forms[f], 0.0, q, u, y), mbsr_data_error(d));
        assert_ok(mbsr_dae_imbalance(m, d, run_forms[f], 0.0, y, &share, &body, NULL, NULL), NULL);
        assert_true((share > 0.01) == refused);
        assert_ok(mbsr_ida_create(m, d, &opt, &ida, NULL), NULL);
        const int status = mbsr_ida_start(ida, 0.0, y, yp);
        if (refused)
            assert_refused(status, mbsr_ida_error(ida), MBSR_NO_CONVERGENCE, 0, MBSR_NONE,
                           "node|do not balance");
        else
            assert_ok(status, mbsr_ida_error(ida));
        mbsr_ida_destroy(ida);
    }
    mbsr_data_destroy(d);
}

static void starts_beside_the_balance_are_refused(void **unused)
{
    (void)unused;
    const double there[2] = {1.0 / sqrt(3.0), 0.3}, beside[2] = {0.9, 0.3}, u[2] = {0.0, 0.4};
    saturation w = {.S = 2.0, .F = 1.0};
    mbsr_model *m = pulled_node(&w);
    check_driver(m, there, u, false);
    check_driver(m, beside, u, true);
    mbsr_model_destroy(m);
    /* damped: 2 u = 1 N */
    m = run_model();
    const int node = run_cart(m, "node", MBSR_GROUND, 0.0);
    run_cart(m, "mass", node, 1.0);
    w.S = 0.0;
    run_force(m, mbsr_force_custom(&saturated_spring, 1, &node, &w));
    run_force(m, mbsr_force_axis_spring(node, MBSR_GROUND, 0, 0.0, 2.0, 0.0));
    run_finish(m);
    const double right[2] = {0.5, 0.4}, wrong[2] = {0.3, 0.4};
    check_driver(m, there, right, false);
    check_driver(m, there, wrong, true);
    mbsr_model_destroy(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(massless_cart_without_any_force),
        cmocka_unit_test(massless_point_held_along_one_axis_only),
        cmocka_unit_test(force_beyond_what_the_spring_can_balance),
        cmocka_unit_test(starts_beside_the_balance_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
