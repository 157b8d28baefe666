/* Models with flexible bodies: see flexible.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "flexible.h"

#include "expect.h"

#include <string.h>

static const double ex[3] = {1.0, 0.0, 0.0}, ey[3] = {0.0, 1.0, 0.0}, ez[3] = {0.0, 0.0, 1.0};

static int add_body(mbsr_model *m, int parent, mbsr_joint joint, mbsr_inertia inertia)
{
    mbsr_body_def def = mbsr_default_body_def();
    int id;
    def.parent = parent, def.joint = joint, def.inertia = inertia;
    assert_ok(mbsr_model_add_body(m, &def, &id), mbsr_model_error(m));
    return id;
}

static void add_force(mbsr_model *m, mbsr_force_def def)
{
    assert_ok(mbsr_model_add_force(m, &def, NULL), mbsr_model_error(m));
}

static int add_flexible(mbsr_model *m, int parent, const mbsr_flex *flex, int marker,
                        mbsr_joint joint)
{
    mbsr_flexible_def def = mbsr_default_flexible_def();
    int id;
    def.parent = parent, def.flex = flex, def.marker = marker, def.joint = joint;
    assert_ok(mbsr_model_add_flexible(m, &def, &id), mbsr_model_error(m));
    return id;
}

static int add_marker(mbsr_model *m, int body, int marker)
{
    int id;
    assert_ok(mbsr_model_add_marker(m, body, marker, NULL, &id), mbsr_model_error(m));
    return id;
}

static void begin(test_flexible *w)
{
    mbsr_error error;
    memset(w, 0, sizeof *w);
    assert_ok(mbsr_model_create(NULL, &w->model, &error), &error);
}

static void finish(test_flexible *w, const double *q, const double *u)
{
    mbsr_error error;
    assert_ok(mbsr_model_finish(w->model), mbsr_model_error(w->model));
    assert_ok(mbsr_data_create(w->model, &w->data, &error), &error);
    const size_t nu = (size_t)mbsr_model_nu(w->model);
    memcpy(w->q, q, nu * sizeof *q);
    memcpy(w->u, u, nu * sizeof *u);
}

void test_flexible_pendulum(test_flexible *w, double EI, int stiffening)
{
    test_ritz beam = test_ritz_pendulum(EI);
    beam.stiffening = stiffening;
    test_flexible_swing(w, &beam);
}

void test_flexible_swing(test_flexible *w, const test_ritz *beam)
{
    static const double q[1 + TEST_RITZ_MODES] = {0.3, 0.02, -0.01},
                              u[1 + TEST_RITZ_MODES] = {1.0, 0.5, -0.2};
    begin(w);
    w->flex[0] = test_ritz_make(beam);
    w->flexible[0] =
        add_flexible(w->model, MBSR_GROUND, w->flex[0], 0, mbsr_joint_revolute(NULL, NULL, ez));
    w->tip = add_marker(w->model, w->flexible[0], 1);
    add_force(w->model, mbsr_force_gravity(0.0, -9.81, 0.0));
    finish(w, q, u);
}

static int load(void *user, double t, int n, double *value)
{
    static const double wrench[6] = {0.1, 0.2, -0.3, 1.0, -2.0, 0.5};
    (void)user, (void)t;
    memcpy(value, wrench, (size_t)n * sizeof *value);
    return MBSR_OK;
}

static int tip_load(void *user, double t, int n, double *value)
{
    static const double wrench[6] = {0.0, 0.0, 0.0, 1.0, -2.0, 0.5};
    (void)user, (void)t;
    memcpy(value, wrench, (size_t)n * sizeof *value);
    return MBSR_OK;
}

void test_flexible_tree(test_flexible *w, int reversed, int stiffening)
{
    static const double q[8] = {0.4, 0.05, -0.03, 0.02, -0.6, 0.04, 0.02, 0.1},
                        u[8] = {1.0, 0.2, -0.1, 0.3, -0.5, 0.1, 0.4, 0.2};
    static const double com[3] = {0.1, 0.0, 0.05}, tensor[6] = {0.02, 0.03, 0.04, 0.0, 0.0, 0.0};
    test_ritz first = test_ritz_first(), second = test_ritz_second();
    first.stiffening = second.stiffening = stiffening;
    begin(w);
    w->flex[0] = test_ritz_make(&first);
    w->flex[1] = test_ritz_make(&second);
    w->flexible[0] =
        add_flexible(w->model, MBSR_GROUND, w->flex[0], 0, mbsr_joint_revolute(NULL, NULL, ez));
    int middle = MBSR_NONE;
    if (reversed) {
        add_marker(w->model, w->flexible[0], 0);
        middle = add_marker(w->model, w->flexible[0], 2);
    }
    w->tip = add_marker(w->model, w->flexible[0], 1);
    w->flexible[1] =
        add_flexible(w->model, w->tip, w->flex[1], 1, mbsr_joint_revolute(NULL, NULL, ey));
    if (reversed) add_marker(w->model, w->flexible[1], 1);
    const int root = add_marker(w->model, w->flexible[1], 0);
    w->last = add_body(w->model, root, mbsr_joint_prismatic(NULL, NULL, ex),
                       mbsr_inertia_rigid(0.7, com, tensor));
    if (!reversed) middle = add_marker(w->model, w->flexible[0], 2);
    add_force(w->model, mbsr_force_gravity(0.0, 0.0, -9.81));
    add_force(w->model, mbsr_force_joint_spring(w->flexible[1] - 1, 0, 2.0, 0.1, 0.0));
    add_force(w->model, mbsr_force_joint_spring(w->last, 0, 50.0, 0.0, 0.0));
    add_force(w->model, mbsr_force_wrench(middle, NULL, 0, load, NULL));
    finish(w, q, u);
}

void test_flexible_massless(test_flexible *w)
{
    static const double q[4] = {0.3, 0.05, -0.04, 0.01}, u[4] = {1.0, 0.5, -0.3, 0.2};
    const test_ritz beam = test_ritz_massless();
    begin(w);
    w->flex[0] = test_ritz_make(&beam);
    w->flexible[0] =
        add_flexible(w->model, MBSR_GROUND, w->flex[0], 0, mbsr_joint_revolute(NULL, NULL, ez));
    w->tip = add_marker(w->model, w->flexible[0], 1);
    add_force(w->model, mbsr_force_gravity(0.0, -9.81, 0.0));
    add_force(w->model, mbsr_force_wrench(w->tip, NULL, 0, tip_load, NULL));
    finish(w, q, u);
}

void test_flexible_free(test_flexible *w)
{
    mbsr_data_destroy(w->data);
    mbsr_model_destroy(w->model);
    for (int k = 0; k < 2; ++k) mbsr_flex_destroy(w->flex[k]);
}
