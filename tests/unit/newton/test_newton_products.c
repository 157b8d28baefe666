/* Products with the Newton matrix: what they refuse, what they leave alone, and cases beside the
 * random trees and loops of property/test_newton.c and test_newton_loops.c.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"
#include "newton_scene.h"
#include "rigid_tree.h"

#include <mbsrank/driver.h>

#include <stdlib.h>

enum { MOST = 160 };

typedef struct scene {
    test_rigid_tree tree;
    test_newton_state s;
    double x[MOST], p[MOST];
} scene;

static void open_scene(scene *z, test_rigid_choice choice)
{
    choice.bodies = 7;
    test_newton_scene(&z->tree, &z->s, choice, MOST, z->x);
}

static void close_scene(scene *z)
{
    test_newton_scene_free(&z->tree, &z->s);
}

static mbsr_newton *create(const mbsr_model *model, mbsr_newton_method method, int products)
{
    mbsr_newton_opt opt = mbsr_default_newton_opt();
    mbsr_newton *newton;
    mbsr_error error;
    opt.method = method;
    opt.products = products;
    assert_ok(mbsr_newton_create(model, MBSR_DAE_MOMENTUM, &opt, &newton, &error), &error);
    return newton;
}

static int linearise(mbsr_newton *newton, const test_newton_state *s, double c)
{
    return mbsr_newton_linearise(newton, s->data, s->t, s->y, s->yp, c);
}

static void multiply(mbsr_newton *newton, const double *x, double *p)
{
    assert_ok(mbsr_newton_multiply(newton, x, p), mbsr_newton_error(newton));
}

/* ---- refusals ---- */

static void what_is_wrong_is_refused(void **state)
{
    (void)state;
    scene z, other;
    open_scene(&z, (test_rigid_choice){.seed = 8, .forces = 1});
    open_scene(&other, (test_rigid_choice){.seed = 9});
    const test_newton_state *s = &z.s;
    mbsr_newton *newton = NULL, *without = create(s->model, MBSR_NEWTON_AUTO, 0);
    mbsr_newton_opt opt = mbsr_default_newton_opt();
    mbsr_error why;
    opt.lean = opt.products = 1;
    assert_refused(mbsr_newton_create(s->model, MBSR_DAE_MOMENTUM, &opt, &newton, &why), &why,
                   MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE, "lean|products is 1");
    assert_null(newton);
    assert_refused(linearise(without, s, 1.0), mbsr_newton_error(without), MBSR_ERR_SEQUENCE,
                   MBSR_NONE, MBSR_NONE, "mbsr_newton_linearise|without `products`");
    mbsr_newton_destroy(without);

    newton = create(s->model, MBSR_NEWTON_AUTO, 1);
    const mbsr_error *error = mbsr_newton_error(newton);
    assert_int_equal(linearise(NULL, s, 1.0), MBSR_ERR_NULL);
    assert_int_equal(mbsr_newton_multiply(NULL, z.x, z.p), MBSR_ERR_NULL);
    assert_refused(mbsr_newton_multiply(newton, z.x, z.p), error, MBSR_ERR_SEQUENCE, MBSR_NONE,
                   MBSR_NONE, "mbsr_newton_multiply|mbsr_newton_linearise");
    assert_refused(mbsr_newton_linearise(newton, NULL, s->t, s->y, s->yp, 1.0), error,
                   MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "NULL");
    assert_refused(mbsr_newton_linearise(newton, s->data, s->t, NULL, s->yp, 1.0), error,
                   MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "NULL");
    assert_refused(mbsr_newton_linearise(newton, s->data, s->t, s->y, NULL, 1.0), error,
                   MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "NULL");
    assert_refused(mbsr_newton_linearise(newton, other.s.data, s->t, s->y, s->yp, 1.0), error,
                   MBSR_ERR_MISMATCH, MBSR_NONE, MBSR_NONE, "another model");
    static const double wrong[] = {NAN, INFINITY, -INFINITY};
    for (int k = 0; k < 3; ++k) {
        assert_ok(linearise(newton, s, 3.0), error);
        assert_refused(linearise(newton, s, wrong[k]), error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                       "c is");
        /* a failure takes the derivatives away */
        assert_int_equal(mbsr_newton_multiply(newton, z.x, z.p), MBSR_ERR_SEQUENCE);
        const double y = s->y[k];
        s->y[k] = wrong[k];
        assert_int_equal(linearise(newton, s, 3.0), MBSR_NOT_FINITE);
        assert_int_equal(error->status, MBSR_NOT_FINITE);
        assert_int_equal(mbsr_newton_multiply(newton, z.x, z.p), MBSR_ERR_SEQUENCE);
        s->y[k] = y;
    }
    assert_ok(linearise(newton, s, 3.0), error);
    assert_refused(mbsr_newton_multiply(newton, NULL, z.p), error, MBSR_ERR_NULL, MBSR_NONE,
                   MBSR_NONE, "NULL");
    assert_refused(mbsr_newton_multiply(newton, z.x, NULL), error, MBSR_ERR_NULL, MBSR_NONE,
                   MBSR_NONE, "NULL");
    for (int k = 0; k < s->n; ++k) {
        const double x = z.x[k];
        z.p[0] = 17.0;
        z.x[k] = wrong[k % 3];
        assert_refused(mbsr_newton_multiply(newton, z.x, z.p), error, MBSR_NOT_FINITE, MBSR_NONE,
                       MBSR_NONE, "delta is not finite");
        assert_true(z.p[0] == 17.0);
        z.x[k] = x;
    }
    double large[MOST];
    for (int k = 0; k < s->n; ++k) large[k] = 1e308;
    assert_refused(mbsr_newton_multiply(newton, large, z.p), error, MBSR_NOT_FINITE, MBSR_NONE,
                   MBSR_NONE, "product is not finite");
    assert_true(z.p[0] == 17.0);
    multiply(newton, z.x, z.p);
    mbsr_newton_destroy(newton);

    mbsr_data *lean = NULL; /* which stages do not serve */
    newton = create(s->model, MBSR_NEWTON_AUTO, 1);
    assert_ok(mbsr_data_create_lean(s->model, &lean, NULL), NULL);
    assert_int_equal(mbsr_newton_linearise(newton, lean, s->t, s->y, s->yp, 3.0), MBSR_ERR_LEAN);
    mbsr_data_destroy(lean);
    mbsr_newton_destroy(newton);
    close_scene(&z);
    close_scene(&other);
}

/* ---- what it is ---- */

/* In vector code, and with elements across. */
static const test_rigid_choice variants[2] = {
    {.seed = 8}, {.seed = 9, .forces = 2, .massless = 0.3, .many = 0.4, .points = 0.5}};

/* A(c) = A + c B, for any c: that of the dense matrices, the same in place, and forgotten states
 * leave nothing. */
static void products_are_linear_in_c(void **state)
{
    (void)state;
    for (int v = 0; v < 2; ++v) {
        scene z;
        double one[MOST], two[MOST];
        open_scene(&z, variants[v]);
        assert_ok(test_newton_matrices(&z.s, z.s.model, z.s.data), NULL);
        mbsr_newton *newton = create(z.s.model, MBSR_NEWTON_AUTO, 1);
        assert_ok(linearise(newton, &z.s, 0.0), mbsr_newton_error(newton));
        multiply(newton, z.x, one);
        assert_less(test_newton_product_error(&z.s, 0.0, z.x, one, NULL), 1e-7);
        assert_ok(linearise(newton, &z.s, 1.0), mbsr_newton_error(newton));
        multiply(newton, z.x, two);
        assert_ok(linearise(newton, &z.s, -70.0), mbsr_newton_error(newton));
        multiply(newton, z.x, z.p);
        for (int k = 0; k < z.s.n; ++k)
            assert_close(z.p[k], one[k] - 70.0 * (two[k] - one[k]),
                         1e-11 * (1.0 + test_largest(z.s.n, z.p)));
        memcpy(one, z.x, sizeof one);
        multiply(newton, one, one);
        assert_memory_equal(one, z.p, (size_t)z.s.n * sizeof *one);
        mbsr_newton_destroy(newton);
        close_scene(&z);
    }
}

/* dF/dy' is what A(c) gains with c. */
static void parts_of_the_matrix(void **state)
{
    (void)state;
    for (int v = 0; v < 2; ++v) {
        scene z;
        double one[MOST], two[MOST], r[MOST];
        open_scene(&z, variants[v]);
        const int n = z.s.n;
        mbsr_newton *newton = create(z.s.model, MBSR_NEWTON_AUTO, 1);
        const mbsr_error *error = mbsr_newton_error(newton);
        assert_refused(mbsr_newton_multiply_rate(newton, z.x, r), error, MBSR_ERR_SEQUENCE,
                       MBSR_NONE, MBSR_NONE, "mbsr_newton_linearise");
        for (int c = 0; c < 2; ++c) {
            assert_ok(linearise(newton, &z.s, c == 0 ? 3.0 : 4.0), error);
            multiply(newton, z.x, c == 0 ? one : two);
        }
        assert_ok(mbsr_newton_multiply_rate(newton, z.x, r), error);
        for (int k = 0; k < n; ++k) assert_close(r[k], two[k] - one[k], 1e-11);
        multiply(newton, z.x, one); /* c is what it was */
        for (int k = 0; k < n; ++k) assert_close(one[k], two[k], 0.0);
        z.x[0] = NAN;
        assert_refused(mbsr_newton_multiply_rate(newton, z.x, r), error, MBSR_NOT_FINITE, MBSR_NONE,
                       MBSR_NONE, "not finite");
        mbsr_newton_destroy(newton);
        close_scene(&z);
    }
}

/* A factorisation at one state, linearised at another: neither disturbs the other, and the first
 * preconditions the second, x <- x + M^-1 (r - A x). Off solutions the matrix is that of factoring
 * too. */
static void a_factorisation_of_an_earlier_state_preconditions(void **state)
{
    (void)state;
    for (int v = 0; v < 2; ++v) {
        scene z;
        double before[MOST], after[MOST], r[MOST], exact[MOST], x[MOST] = {0.0};
        open_scene(&z, variants[v]);
        const test_newton_state *s = &z.s;
        mbsr_newton *newton = create(s->model, MBSR_NEWTON_CORRECTED, 1),
                    *fresh = create(s->model, MBSR_NEWTON_CORRECTED, 0);
        test_rng rng = test_seed(3);
        test_fill(&rng, s->n, r);
        assert_ok(mbsr_newton_factor(newton, s->data, s->t, s->y, s->yp, 50.0),
                  mbsr_newton_error(newton));
        assert_ok(mbsr_newton_solve(newton, r, before), mbsr_newton_error(newton));
        for (int k = 0; k < s->n; ++k) s->y[k] += 1e-3 * sin(k + 1.0);
        assert_ok(linearise(newton, s, 51.0), mbsr_newton_error(newton));
        multiply(newton, z.x, z.p);
        assert_ok(mbsr_newton_solve(newton, r, after), mbsr_newton_error(newton));
        assert_memory_equal(before, after, (size_t)s->n * sizeof *before);
        double last = INFINITY;
        for (int k = 0; k < 12; ++k) {
            multiply(newton, x, z.p);
            for (int l = 0; l < s->n; ++l) z.p[l] = r[l] - z.p[l];
            last = test_largest(s->n, z.p);
            assert_ok(mbsr_newton_solve(newton, z.p, after), mbsr_newton_error(newton));
            for (int l = 0; l < s->n; ++l) x[l] += after[l];
        }
        assert_less(last, 1e-8);
        assert_ok(mbsr_newton_factor(fresh, s->data, s->t, s->y, s->yp, 51.0),
                  mbsr_newton_error(fresh));
        assert_ok(mbsr_newton_solve(fresh, r, exact), mbsr_newton_error(fresh));
        assert_less(test_newton_distance(s, exact, x), 1e-7);
        assert_less(1e-4, test_newton_distance(s, exact, before));
        mbsr_newton_destroy(newton);
        mbsr_newton_destroy(fresh);
        close_scene(&z);
    }
}

/* Elements across are in the product where the solver leaves them out; elements that are switched
 * off are in neither. */
static void products_have_all_elements_that_are_on(void **state)
{
    (void)state;
    scene z;
    open_scene(&z, variants[1]);
    mbsr_newton *tree = create(z.s.model, MBSR_NEWTON_TREE, 1);
    mbsr_newton_info info;
    assert_int_equal(mbsr_newton_get_info(tree, &info), 0);
    assert_true(!info.exact && info.across > 0);
    for (int round = 0; round < 2; ++round) {
        double other[MOST];
        assert_ok(test_newton_matrices(&z.s, z.s.model, z.s.data), NULL);
        assert_ok(linearise(tree, &z.s, 5.0), mbsr_newton_error(tree));
        multiply(tree, z.x, z.p);
        assert_less(test_newton_product_error(&z.s, 5.0, z.x, z.p, NULL), 1e-7);
        if (round == 1) break;
        for (int k = 2; k < mbsr_model_forces(z.s.model); k += 3)
            assert_ok(mbsr_force_switch(z.s.model, z.s.data, k, 0), mbsr_data_error(z.s.data));
        memcpy(other, z.p, sizeof other);
        assert_ok(linearise(tree, &z.s, 5.0), mbsr_newton_error(tree));
        multiply(tree, z.x, z.p);
        assert_less(1e-3, test_newton_distance(&z.s, other, z.p));
    }
    mbsr_newton_destroy(tree);
    close_scene(&z);
}

/* Sliders without mass along y and z and a rod that turns about x, with its mass at the end, where
 * a wheel turns: the block of both sliders has rank 1, and neither alone tells which one lacks it.
 */
static void groups_of_joints_are_taken_together(void **state)
{
    (void)state;
    static const double axes[3][3] = {{0, 1, 0}, {0, 0, 1}, {1, 0, 0}}, tip[3] = {0.0, 0.6, 0.8};
    const double q[4] = {0.1, -0.2, 0.7, 0.3}, u[4] = {0.4, 0.5, -1.0, 0.2};
    mbsr_model *m = NULL;
    mbsr_data *d = NULL;
    test_newton_state s;
    mbsr_consistent_info info;
    const mbsr_frame end = mbsr_frame_at(tip[0], tip[1], tip[2]);
    assert_int_equal(mbsr_model_create(NULL, &m, NULL), 0);
    for (int k = 0; k < 4; ++k) {
        mbsr_body_def body = mbsr_default_body_def();
        body.parent = k - 1;
        body.joint = k < 2 ? mbsr_joint_prismatic(NULL, NULL, axes[k])
                           : mbsr_joint_revolute(k == 3 ? &end : NULL, NULL, axes[2]);
        if (k == 2) body.inertia = mbsr_inertia_point_mass(2.0, tip);
        if (k == 3) body.inertia = mbsr_inertia_sphere(0.1, 1.0);
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
        const mbsr_force_def spring = mbsr_force_joint_spring(k, 0, 40.0 + k, 3.0, 0.1);
        assert_ok(mbsr_model_add_force(m, &spring, NULL), mbsr_model_error(m));
    }
    const mbsr_force_def gravity = mbsr_force_gravity(0.3, 0.2, -9.81);
    assert_ok(mbsr_model_add_force(m, &gravity, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_int_equal(mbsr_body_group(m, 1), 0);
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    assert_ok(test_newton_start(&s, m, d, 0.0, q, u, &info), mbsr_data_error(d));
    assert_ok(test_newton_matrices(&s, m, d), mbsr_data_error(d));
    mbsr_newton *newton = create(m, MBSR_NEWTON_AUTO, 1);
    double x[12], p[12], r[12];
    for (int k = 0; k < 12; ++k) r[k] = cos(3.0 * k);
    for (double c = 1.0; c < 2e4; c *= 100.0) {
        assert_ok(mbsr_newton_factor(newton, d, 0.0, s.y, s.yp, c), mbsr_newton_error(newton));
        assert_ok(mbsr_newton_solve(newton, r, x), mbsr_newton_error(newton));
        assert_ok(linearise(newton, &s, c), mbsr_newton_error(newton));
        multiply(newton, r, p);
        assert_less(test_newton_product_error(&s, c, r, p, NULL), 1e-8);
        multiply(newton, x, p);
        assert_less(test_newton_product_error(&s, c, x, p, r), 1e-12);
    }
    assert_true(info.null_directions > 0);
    mbsr_newton_destroy(newton);
    test_newton_free(&s);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

/* Memory grows as bodies do, and only where it is asked for. */
static void memory_grows_with_the_bodies(void **state)
{
    (void)state;
    size_t extra[2];
    for (int k = 0; k < 2; ++k) {
        test_rigid_tree tree;
        size_t bytes[2];
        test_rigid_tree_make(&tree,
                             (test_rigid_choice){.seed = 4, .bodies = 40 << k, .length = 0.5});
        for (int products = 0; products < 2; ++products) {
            mbsr_newton *newton = create(tree.model, MBSR_NEWTON_AUTO, products);
            mbsr_newton_info info;
            assert_int_equal(mbsr_newton_get_info(newton, &info), 0);
            bytes[products] = info.bytes;
            mbsr_newton_destroy(newton);
        }
        extra[k] = bytes[1] - bytes[0];
        test_rigid_tree_free(&tree);
    }
    assert_in_range(extra[0], 40 * 1000, 40 * 20000);
    assert_in_range(extra[1], 19 * extra[0] / 10, 21 * extra[0] / 10);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_wrong_is_refused),
        cmocka_unit_test(products_are_linear_in_c),
        cmocka_unit_test(parts_of_the_matrix),
        cmocka_unit_test(a_factorisation_of_an_earlier_state_preconditions),
        cmocka_unit_test(products_have_all_elements_that_are_on),
        cmocka_unit_test(groups_of_joints_are_taken_together),
        cmocka_unit_test(memory_grows_with_the_bodies),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
