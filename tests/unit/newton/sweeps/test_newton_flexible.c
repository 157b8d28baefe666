/* Newton systems of chains of rigid bodies with a beam among them: the beam and its marker by a
 * front, the others in vector code; of beams with massless modes all by the front.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"
#include "newton_ways.h"

#include <stdlib.h>

enum { BODIES = 10, AT = 4, ELEMENTS = 6, MIDDLE = 3 };

typedef struct chain {
    mbsr_flex *flex;
    mbsr_model *model;
    mbsr_data *data;
    double *q, *u;
} chain;

static mbsr_flex *beam(int modes, int loaded)
{
    static const int middle = MIDDLE;
    mbsr_beam_def def = mbsr_default_beam_def();
    mbsr_flex *flex;
    mbsr_error error;
    def.length = 1.0, def.density = 1.3, def.EI_y = 70.0, def.EI_z = 50.0;
    def.elements = ELEMENTS, def.modes = modes, def.damping = 0.02;
    def.loaded = loaded, def.node = &middle;
    assert_ok(mbsr_flex_beam(&def, &flex, &error), &error);
    return flex;
}

/* A beam on a hinge; the marker on its end. */
static int add_beam(chain *c, int parent)
{
    static const double axis[3] = {0.0, 0.0, 1.0};
    mbsr_flexible_def def = mbsr_default_flexible_def();
    int id, end;
    def.parent = parent;
    def.flex = c->flex;
    def.joint = mbsr_joint_revolute(NULL, NULL, axis);
    assert_ok(mbsr_model_add_flexible(c->model, &def, &id), mbsr_model_error(c->model));
    assert_ok(mbsr_model_add_marker(c->model, id, ELEMENTS, NULL, &end),
              mbsr_model_error(c->model));
    return end;
}

/* light: a hinge behind which a body without inertia and the next one turn about the same axis. */
static int add_rigid(chain *c, int parent, int k, bool light)
{
    static const double axes[3][3] = {{0.0, 0.0, 1.0}, {0.0, 1.0, 0.0}, {1.0, 0.0, 0.0}};
    const mbsr_frame at = mbsr_frame_at(0.3, 0.1, -0.2);
    const bool same = light && k == 2;
    mbsr_body_def def = mbsr_default_body_def();
    int id;
    def.parent = parent;
    def.joint = mbsr_joint_revolute(k == 0 || same ? NULL : &at, NULL, axes[same ? 1 : k % 3]);
    def.inertia = light && k == 1 ? mbsr_inertia_zero()
                                  : mbsr_inertia_in_frame(&at, mbsr_inertia_sphere(2000.0, 0.1));
    assert_ok(mbsr_model_add_body(c->model, &def, &id), mbsr_model_error(c->model));
    const mbsr_force_def spring = mbsr_force_joint_spring(id, 0, 40.0, 3.0, 0.1);
    assert_ok(mbsr_model_add_force(c->model, &spring, NULL), mbsr_model_error(c->model));
    return id;
}

static void open_chain(chain *c, int modes, int loaded, bool light)
{
    const mbsr_force_def gravity = mbsr_force_gravity(0.3, 1.0, -9.81);
    test_rng rng = test_seed(7);
    int last = MBSR_GROUND;
    c->flex = beam(modes, loaded);
    assert_ok(mbsr_model_create(NULL, &c->model, NULL), NULL);
    for (int k = 0; k < BODIES; ++k)
        last = k == AT ? add_beam(c, last) : add_rigid(c, last, k, light);
    assert_ok(mbsr_model_add_force(c->model, &gravity, NULL), mbsr_model_error(c->model));
    assert_ok(mbsr_model_finish(c->model), mbsr_model_error(c->model));
    assert_ok(mbsr_data_create(c->model, &c->data, NULL), NULL);
    const int nu = mbsr_model_nu(c->model);
    c->q = calloc(2 * (size_t)nu, sizeof *c->q);
    c->u = c->q + nu;
    test_fill(&rng, nu, c->q);
    test_fill(&rng, nu, c->u);
    for (int k = 0; k < nu; ++k) c->q[k] *= 0.05;
}

static void close_chain(chain *c)
{
    free(c->q);
    mbsr_data_destroy(c->data);
    mbsr_model_destroy(c->model);
    mbsr_flex_destroy(c->flex);
}

/* The solver in vector code, or, 0 blocks, by the front, against the front and the dense matrix. */
static void compare(chain *c, int blocks)
{
    static const double factors[] = {1.0, 100.0, 1e4, -30.0};
    test_newton_state at;
    test_rng rng = test_seed(11);
    mbsr_newton *newton = newton_solver(c->model, 0), *front = newton_solver(c->model, 1);
    assert_ok(test_newton_start(&at, c->model, c->data, 0.0, c->q, c->u, NULL),
              mbsr_data_error(c->data));
    assert_ok(test_newton_matrices(&at, c->model, c->data), mbsr_data_error(c->data));
    double *r = calloc(3 * (size_t)at.n, sizeof *r), *x = r + at.n, *y = x + at.n;
    for (int k = 0; k < 4; ++k) {
        mbsr_newton_info info;
        test_fill(&rng, at.n, r);
        newton_solve(newton, &at, factors[k], r, x);
        newton_solve(front, &at, factors[k], r, y);
        assert_ok(mbsr_newton_get_info(newton, &info), NULL);
        assert_int_equal(info.vector_code, blocks > 0);
        assert_int_equal(info.blocks, blocks > 0 ? blocks : mbsr_model_bodies(c->model));
        const test_newton_errors e = test_newton_compare(&at, factors[k], r, x);
        assert_less(test_newton_distance(&at, x, y), 1e-11 * (1.0 + e.amplification));
        assert_less(e.net_row, 1e-8);
        assert_less(e.net_delta, 1e-7);
    }
    free(r);
    mbsr_newton_destroy(newton);
    mbsr_newton_destroy(front);
    test_newton_free(&at);
}

/* The mount and the marker are blocks; 12 modes: in factors elsewhere. */
static void one_beam_leaves_the_rest_in_vector_code(void **state)
{
    (void)state;
    static const int modes[] = {2, 4, 12};
    for (int k = 0; k < 3; ++k) {
        chain c;
        open_chain(&c, modes[k], 0, false);
        compare(&c, 2);
        close_chain(&c);
    }
}

static void a_beam_behind_a_joint_without_inertia(void **state)
{
    (void)state;
    chain c;
    open_chain(&c, 4, 0, true);
    compare(&c, 2);
    close_chain(&c);
}

static void massless_modes_are_for_the_front(void **state)
{
    (void)state;
    chain c;
    open_chain(&c, 4, 1, false);
    compare(&c, 0);
    close_chain(&c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_beam_leaves_the_rest_in_vector_code),
        cmocka_unit_test(a_beam_behind_a_joint_without_inertia),
        cmocka_unit_test(massless_modes_are_for_the_front),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
