/* Solutions and products with the transposed Newton matrix: an oscillator by hand, what they
 * refuse, groups of joints. Mechanisms of everything at once: property/test_newton_medley.c.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"
#include "newton_system.h"

#include <stdlib.h>
#include <string.h>

enum { MOST = 24 };

static mbsr_newton *create(const mbsr_model *model, int transposes)
{
    mbsr_newton_opt opt = mbsr_default_newton_opt();
    mbsr_newton *newton;
    mbsr_error error;
    opt.products = 1;
    opt.transposes = transposes;
    assert_ok(mbsr_newton_create(model, MBSR_DAE_MOMENTUM, &opt, &newton, &error), &error);
    return newton;
}

static double dot(int n, const double *a, const double *b)
{
    double sum = 0.0;
    for (int k = 0; k < n; ++k) sum += a[k] * b[k];
    return sum;
}

/* ---- an oscillator ---- */

static const double mass = 2.0, stiffness = 30.0, damping = 0.7;

/* A slider with a spring and a damper. */
static void open_oscillator(mbsr_model **m, mbsr_data **d, test_newton_state *s)
{
    static const double axis[3] = {0.0, 0.6, 0.8}, centre[3] = {0.1, 0.2, 0.3};
    const double q = 0.3, u = -1.2;
    mbsr_body_def body = mbsr_default_body_def();
    assert_int_equal(mbsr_model_create(NULL, m, NULL), 0);
    body.joint = mbsr_joint_prismatic(NULL, NULL, axis);
    body.inertia = mbsr_inertia_point_mass(mass, centre);
    assert_ok(mbsr_model_add_body(*m, &body, NULL), mbsr_model_error(*m));
    const mbsr_force_def spring = mbsr_force_joint_spring(0, 0, stiffness, damping, 0.1);
    assert_ok(mbsr_model_add_force(*m, &spring, NULL), mbsr_model_error(*m));
    assert_ok(mbsr_model_finish(*m), mbsr_model_error(*m));
    assert_ok(mbsr_data_create(*m, d, NULL), NULL);
    assert_ok(test_newton_start(s, *m, *d, 0.0, &q, &u, NULL), mbsr_data_error(*d));
}

static void close(mbsr_model *m, mbsr_data *d, test_newton_state *s)
{
    test_newton_free(s);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

/* F = (q' - u, p' + k q + d u, m u - p): columns of A are (c, k, 0), (0, c, -1), (-1, d, m). */
static void an_oscillator_by_hand(void **state)
{
    (void)state;
    static const double v[3] = {0.4, -1.7, 2.2};
    mbsr_model *m;
    mbsr_data *d;
    test_newton_state s;
    open_oscillator(&m, &d, &s);
    mbsr_newton *newton = create(m, 1);
    for (double c = -50.0; c < 1e6; c = c < 0.0 ? 1.0 : 30.0 * c) {
        double x[3], back[3];
        /* c xq + k xp = v0, c xp - xu = v1, -xq + d xp + m xu = v2 */
        const double det = mass * c * c + damping * c + stiffness,
                     xp = (c * v[2] + v[0] + mass * c * v[1]) / det, xu = c * xp - v[1],
                     xq = (v[0] - stiffness * xp) / c;
        assert_ok(mbsr_newton_factor(newton, d, 0.0, s.y, s.yp, c), mbsr_newton_error(newton));
        assert_ok(mbsr_newton_solve_transposed(newton, v, x), mbsr_newton_error(newton));
        assert_close(x[0], xq, 1e-13 * (fabs(v[0] / c) + fabs(xq)));
        assert_close(x[1], xp, 1e-13 * fabs(xp));
        assert_close(x[2], xu, 1e-13 * (fabs(v[1]) + fabs(xu)));
        assert_ok(mbsr_newton_linearise(newton, d, 0.0, s.y, s.yp, c), mbsr_newton_error(newton));
        assert_ok(mbsr_newton_multiply_transposed(newton, x, back), mbsr_newton_error(newton));
        for (int k = 0; k < 3; ++k) assert_close(back[k], v[k], 1e-11);
        /* in place */
        memcpy(back, v, sizeof back);
        assert_ok(mbsr_newton_solve_transposed(newton, back, back), mbsr_newton_error(newton));
        assert_memory_equal(back, x, sizeof x);
    }
    mbsr_newton_destroy(newton);
    close(m, d, &s);
}

/* ---- refusals ---- */

static void what_is_wrong_is_refused(void **state)
{
    (void)state;
    mbsr_model *m;
    mbsr_data *d;
    test_newton_state s;
    mbsr_error why;
    open_oscillator(&m, &d, &s);
    mbsr_newton *newton = NULL, *without = create(m, 0);
    double v[3] = {1.0, 2.0, 3.0}, x[3] = {17.0, 17.0, 17.0};
    mbsr_newton_opt opt = mbsr_default_newton_opt();
    opt.lean = opt.transposes = 1;
    assert_refused(mbsr_newton_create(m, MBSR_DAE_MOMENTUM, &opt, &newton, &why), &why,
                   MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE, "lean|transposes is 1");
    assert_null(newton);
    assert_ok(mbsr_newton_factor(without, d, 0.0, s.y, s.yp, 5.0), mbsr_newton_error(without));
    assert_refused(mbsr_newton_solve_transposed(without, v, x), mbsr_newton_error(without),
                   MBSR_ERR_SEQUENCE, MBSR_NONE, MBSR_NONE, "without `transposes`");
    mbsr_newton_destroy(without);

    newton = create(m, 1);
    const mbsr_error *error = mbsr_newton_error(newton);
    assert_int_equal(mbsr_newton_solve_transposed(NULL, v, x), MBSR_ERR_NULL);
    assert_int_equal(mbsr_newton_multiply_transposed(NULL, v, x), MBSR_ERR_NULL);
    assert_refused(mbsr_newton_solve_transposed(newton, v, x), error, MBSR_ERR_SEQUENCE, MBSR_NONE,
                   MBSR_NONE, "no factorisation");
    assert_refused(mbsr_newton_multiply_transposed(newton, v, x), error, MBSR_ERR_SEQUENCE,
                   MBSR_NONE, MBSR_NONE, "mbsr_newton_linearise");
    assert_ok(mbsr_newton_factor(newton, d, 0.0, s.y, s.yp, 5.0), error);
    assert_ok(mbsr_newton_linearise(newton, d, 0.0, s.y, s.yp, 5.0), error);
    assert_refused(mbsr_newton_solve_transposed(newton, NULL, x), error, MBSR_ERR_NULL, MBSR_NONE,
                   MBSR_NONE, "NULL");
    assert_refused(mbsr_newton_solve_transposed(newton, v, NULL), error, MBSR_ERR_NULL, MBSR_NONE,
                   MBSR_NONE, "NULL");
    assert_refused(mbsr_newton_multiply_transposed(newton, NULL, x), error, MBSR_ERR_NULL,
                   MBSR_NONE, MBSR_NONE, "NULL");
    assert_refused(mbsr_newton_multiply_transposed(newton, v, NULL), error, MBSR_ERR_NULL,
                   MBSR_NONE, MBSR_NONE, "NULL");
    static const double wrong[] = {NAN, INFINITY, -INFINITY};
    for (int k = 0; k < 3; ++k) {
        const double before = v[k];
        v[k] = wrong[k];
        assert_refused(mbsr_newton_solve_transposed(newton, v, x), error, MBSR_NOT_FINITE,
                       MBSR_NONE, MBSR_NONE, "v is not finite");
        assert_refused(mbsr_newton_multiply_transposed(newton, v, x), error, MBSR_NOT_FINITE,
                       MBSR_NONE, MBSR_NONE, "x is not finite");
        v[k] = before;
    }
    v[1] = 1e308;
    assert_refused(mbsr_newton_multiply_transposed(newton, v, x), error, MBSR_NOT_FINITE, MBSR_NONE,
                   MBSR_NONE, "product is not finite");
    for (int k = 0; k < 3; ++k) assert_true(x[k] == 17.0);
    mbsr_newton_destroy(newton);
    close(m, d, &s);
}

/* ---- massless bodies ---- */

/* Sliders without mass along y and z and a rod with its mass at the end: their joints lack rank,
 * together and alone. */
static void massless_joints_and_groups(void **state)
{
    (void)state;
    static const double axes[3][3] = {{0, 1, 0}, {0, 0, 1}, {1, 0, 0}}, tip[3] = {0.0, 0.6, 0.8};
    const double q[3] = {0.1, -0.2, 0.7}, u[3] = {0.4, 0.5, -1.0};
    mbsr_model *m = NULL;
    mbsr_data *d = NULL;
    test_newton_state s;
    double v[MOST], w[MOST], x[MOST], y[MOST], column[MOST] = {0.0}, of[MOST];
    assert_int_equal(mbsr_model_create(NULL, &m, NULL), 0);
    for (int k = 0; k < 3; ++k) {
        mbsr_body_def body = mbsr_default_body_def();
        body.parent = k - 1;
        body.joint = k < 2 ? mbsr_joint_prismatic(NULL, NULL, axes[k])
                           : mbsr_joint_revolute(NULL, NULL, axes[2]);
        if (k == 2) body.inertia = mbsr_inertia_point_mass(2.0, tip);
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
        const mbsr_force_def spring = mbsr_force_joint_spring(k, 0, 40.0 + k, 3.0, 0.1);
        assert_ok(mbsr_model_add_force(m, &spring, NULL), mbsr_model_error(m));
    }
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_int_equal(mbsr_body_group(m, 1), 0);
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    assert_ok(test_newton_start(&s, m, d, 0.0, q, u, NULL), mbsr_data_error(d));
    mbsr_newton *newton = create(m, 1);
    test_rng rng = test_seed(5);
    test_fill(&rng, s.n, v);
    test_fill(&rng, s.n, w);
    for (double c = 1.0; c < 2e4; c *= 100.0) {
        assert_ok(mbsr_newton_factor(newton, d, 0.0, s.y, s.yp, c), mbsr_newton_error(newton));
        assert_ok(mbsr_newton_linearise(newton, d, 0.0, s.y, s.yp, c), mbsr_newton_error(newton));
        assert_ok(mbsr_newton_solve(newton, w, y), mbsr_newton_error(newton));
        assert_ok(mbsr_newton_solve_transposed(newton, v, x), mbsr_newton_error(newton));
        for (int k = 0; k < s.n; ++k) {
            column[k] = 1.0;
            assert_ok(mbsr_newton_multiply(newton, column, of), mbsr_newton_error(newton));
            column[k] = 0.0;
            assert_close(dot(s.n, of, x), v[k], 1e-12 * (1.0 + c) * test_largest(s.n, x));
        }
        assert_close(dot(s.n, v, y), dot(s.n, x, w), 1e-11 * (1.0 + fabs(dot(s.n, v, y))));
    }
    mbsr_newton_destroy(newton);
    close(m, d, &s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_oscillator_by_hand),
        cmocka_unit_test(what_is_wrong_is_refused),
        cmocka_unit_test(massless_joints_and_groups),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
