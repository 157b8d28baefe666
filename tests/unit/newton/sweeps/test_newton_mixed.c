/* Newton systems of trees in which a user's joint stands among rigid bodies: by vectors where they
 * serve, and told as ever where they do not.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "close.h"
#include "expect.h"

#include <mbsrank/mbsrank.h>

#include <math.h>
#include <stdbool.h>

enum { BODIES = 5, OWN = 2, LAST = BODIES - 1, NONE = -1 };

/* ---- a user's hinge: the stock one, whose functions fail on demand ---- */

static const mbsr_joint_table *stock;
static int failing_rates, failing_tangent;

static int position(const mbsr_joint_args *args, double *p)
{
    return stock->position(args, p);
}

static int rates(const mbsr_joint_args *args, double *Kdot, double *Hdot, double *Jdot)
{
    return failing_rates ? failing_rates : stock->rates(args, Kdot, Hdot, Jdot);
}

static int tangent(const mbsr_joint_args *args, const mbsr_joint_change *by, double *dp, double *dK,
                   double *dH, double *dJ, double *dkI)
{
    if (failing_tangent) return failing_tangent;
    return stock->tangent(args, by, dp, dK, dH, dJ, dkI);
}

/* ---- a chain of hinges, one of them a user's ---- */

typedef struct scene {
    mbsr_joint_table own;
    mbsr_model *model;
    mbsr_data *data;
    mbsr_newton *newton, *blocks;
    double y[3 * BODIES], yp[3 * BODIES], r[3 * BODIES], x[3 * BODIES], other[3 * BODIES];
} scene;

static mbsr_newton *make_solver(const mbsr_model *model, int by_blocks, int lean)
{
    mbsr_newton_opt opt = mbsr_default_newton_opt();
    mbsr_newton *newton;
    mbsr_error error;
    opt.by_blocks = by_blocks;
    opt.lean = lean;
    assert_ok(mbsr_newton_create(model, MBSR_DAE_MOMENTUM, &opt, &newton, &error), &error);
    return newton;
}

/* own: the body on the user's hinge, which, if it is bare, has no rates; light: one without
 * inertia. */
static void make_scene(scene *s, int own, bool bare, int light)
{
    const double edges[3] = {0.3, 0.5, 0.7};
    mbsr_joint joint;
    *s = (scene){.model = NULL};
    failing_rates = failing_tangent = 0;
    assert_ok(mbsr_model_create(NULL, &s->model, NULL), NULL);
    for (int i = 0; i < BODIES; ++i) {
        const mbsr_frame A = mbsr_frame_at(0.5, 0.1 * i, -0.2);
        const double axis[3] = {i % 2, 1.0 - i % 2, 0.3};
        mbsr_body_def body = mbsr_default_body_def();
        joint = mbsr_joint_revolute(&A, NULL, axis);
        body.name = i == light ? "light" : NULL;
        body.parent = i - 1;
        body.joint = joint;
        body.inertia = i == light ? mbsr_inertia_zero() : mbsr_inertia_box(3.0, edges);
        if (i == own) {
            stock = joint.table;
            s->own = *stock;
            s->own.position = position;
            s->own.rates = bare ? NULL : rates;
            s->own.tangent = tangent;
            body.joint.table = &s->own;
        }
        assert_ok(mbsr_model_add_body(s->model, &body, NULL), mbsr_model_error(s->model));
    }
    const mbsr_force_def gravity = mbsr_force_gravity(0.0, 0.0, -9.81);
    assert_ok(mbsr_model_add_force(s->model, &gravity, NULL), mbsr_model_error(s->model));
    assert_ok(mbsr_model_finish(s->model), mbsr_model_error(s->model));
    assert_ok(mbsr_data_create(s->model, &s->data, NULL), NULL);
    s->newton = make_solver(s->model, 0, 0);
    s->blocks = make_solver(s->model, 1, 0);
    test_rng rng = test_seed(5);
    test_fill(&rng, 3 * BODIES, s->y);
    test_fill(&rng, 3 * BODIES, s->r);
    const double *q = s->y, *u = s->y + 2 * BODIES;
    assert_ok(mbsr_dae_pack(s->model, s->data, MBSR_DAE_MOMENTUM, 0.0, q, u, s->y),
              mbsr_data_error(s->data));
}

static void free_scene(scene *s)
{
    mbsr_newton_destroy(s->newton);
    mbsr_newton_destroy(s->blocks);
    mbsr_data_destroy(s->data);
    mbsr_model_destroy(s->model);
}

static int factor(scene *s, mbsr_newton *newton)
{
    return mbsr_newton_factor(newton, s->data, 0.0, s->y, s->yp, 30.0);
}

static int vector_code(const mbsr_newton *newton)
{
    mbsr_newton_info info;
    assert_ok(mbsr_newton_get_info(newton, &info), NULL);
    return info.vector_code;
}

static void assert_same_solution(scene *s)
{
    assert_ok(factor(s, s->newton), mbsr_newton_error(s->newton));
    assert_ok(factor(s, s->blocks), mbsr_newton_error(s->blocks));
    assert_ok(mbsr_newton_solve(s->newton, s->r, s->x), NULL);
    assert_ok(mbsr_newton_solve(s->blocks, s->r, s->other), NULL);
    for (int part = 0; part < 3; ++part) {
        double size = 0.0;
        for (int k = 0; k < BODIES; ++k) size = fmax(size, fabs(s->other[BODIES * part + k]));
        for (int k = BODIES * part; k < BODIES * (part + 1); ++k)
            assert_close(s->x[k], s->other[k], 1e-11 * size);
    }
}

/* ---- tests ---- */

static void one_own_joint_leaves_the_rest_in_vector_code(void **state)
{
    (void)state;
    scene s;
    make_scene(&s, OWN, false, NONE);
    assert_same_solution(&s);
    assert_int_equal(vector_code(s.newton), 1);
    assert_int_equal(vector_code(s.blocks), 0);
    free_scene(&s);
}

static void a_joint_without_rates_leaves_the_rest_in_vector_code(void **state)
{
    (void)state;
    scene s;
    make_scene(&s, OWN, true, NONE);
    assert_same_solution(&s);
    assert_int_equal(vector_code(s.newton), 1);
    free_scene(&s);
}

static void singular_joints_of_both_kinds_are_named(void **state)
{
    (void)state;
    static const int own[] = {OWN, LAST};
    for (int k = 0; k < 2; ++k) {
        scene s;
        make_scene(&s, own[k], false, LAST);
        assert_refused(factor(&s, s.newton), mbsr_newton_error(s.newton), MBSR_SINGULAR_BLOCK, LAST,
                       MBSR_NONE, "light|singular|inertia");
        assert_int_equal(mbsr_newton_solve(s.newton, s.r, s.x), MBSR_ERR_SEQUENCE);
        free_scene(&s);
    }
}

static void failures_of_a_joint_reach_the_caller(void **state)
{
    (void)state;
    scene s;
    double F[3 * BODIES];
    make_scene(&s, OWN, false, NONE);
    failing_rates = 41;
    assert_refused(factor(&s, s.newton), mbsr_newton_error(s.newton), 41, OWN, MBSR_NONE,
                   "rates|41");
    assert_int_equal(mbsr_dae_residual(s.model, s.data, MBSR_DAE_MOMENTUM, 0.0, s.y, s.yp, F), 41);
    failing_rates = 0;
    failing_tangent = -43;
    assert_refused(factor(&s, s.newton), mbsr_newton_error(s.newton), -43, OWN, MBSR_NONE,
                   "tangent|-43");
    failing_tangent = 0;
    assert_same_solution(&s);
    assert_int_equal(vector_code(s.newton), 1);
    free_scene(&s);
}

static void lean_solvers_have_room_for_blocks(void **state)
{
    (void)state;
    for (int differenced = 0; differenced < 2; ++differenced) {
        scene s;
        make_scene(&s, OWN, differenced, NONE);
        mbsr_newton *const full = s.newton;
        s.newton = make_solver(s.model, 0, 1);
        assert_same_solution(&s);
        mbsr_newton_destroy(s.newton);
        s.newton = full;
        free_scene(&s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_own_joint_leaves_the_rest_in_vector_code),
        cmocka_unit_test(a_joint_without_rates_leaves_the_rest_in_vector_code),
        cmocka_unit_test(singular_joints_of_both_kinds_are_named),
        cmocka_unit_test(failures_of_a_joint_reach_the_caller),
        cmocka_unit_test(lean_solvers_have_room_for_blocks),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
