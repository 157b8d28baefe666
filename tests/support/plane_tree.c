/* Random trees in the plane: see plane_tree.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "plane_tree.h"

#include "expect.h"

#include <stdbool.h>

static double share(test_rng *rng)
{
    return 0.5 * (1.0 + test_uniform(rng));
}

/* ---- inertias by function ---- */

static int by_function(int d, const double *S, double t, const double *p, const double *V,
                       double *M, double *h)
{
    double phase = t;
    for (int k = 0; k < d; ++k) phase += (0.4 - 0.1 * k) * p[k];
    for (int j = 0; j < d; ++j) {
        for (int k = 0; k < d; ++k) {
            double sum = 0.0;
            for (int l = 0; l < d; ++l) sum += S[l * d + j] * S[l * d + k];
            M[j * d + k] = (1.5 + sin(phase)) * sum;
        }
        h[j] = 0.2 * cos(phase + j) * V[j] * V[(j + 1) % d] + 0.1 * V[d - 1] * V[d - 1];
    }
    return 0;
}

int test_inertia_2(void *user, double t, const double *p, const double *V, double *M, double *h)
{
    return by_function(2, user, t, p, V, M, h);
}

int test_inertia_3(void *user, double t, const double *p, const double *V, double *M, double *h)
{
    return by_function(3, user, t, p, V, M, h);
}

int test_inertia_6(void *user, double t, const double *p, const double *V, double *M, double *h)
{
    return by_function(6, user, t, p, V, M, h);
}

/* S S^T of a random rank. */
static void random_shape(test_rng *rng, int d, double *S)
{
    const int rank = test_integer(rng, 1, d);
    for (int k = 0; k < d * d; ++k) S[k] = k < rank * d ? test_uniform(rng) : 0.0;
}

static mbsr_inertia random_inertia(test_rng *rng, const test_plane_choice *c, bool point,
                                   double *shape, double *matrix)
{
    const int d = point ? 2 : 3;
    const double com[2] = {test_uniform(rng), test_uniform(rng)}, mass = 0.2 + share(rng);
    const int kind = test_integer(rng, 0, c->functions ? 3 : c->rigid ? 1 : 2);
    random_shape(rng, d, shape);
    if (share(rng) < c->massless) return mbsr_inertia_zero();
    if (kind == 3) return mbsr_inertia_function(point ? test_inertia_2 : test_inertia_3, shape);
    if (kind == 2) {
        for (int k = 0; k < d * d; ++k) matrix[k] = 0.0;
        for (int l = 0; l < d; ++l) {
            for (int k = 0; k < d * d; ++k)
                matrix[k] += shape[l * d + k / d] * shape[l * d + k % d];
        }
        return mbsr_inertia_matrix(d, matrix);
    }
    if (point || kind == 0) return mbsr_inertia_particle(mass);
    return mbsr_inertia_planar(mass, com, 0.1 + share(rng));
}

/* ---- joints ---- */

static double wave(int k, double t, int derivative)
{
    const double a = 0.4 - 0.1 * k, w = 1.3 + 0.4 * k;
    if (derivative == 0) return a * sin(w * t + k);
    return derivative == 1 ? a * w * cos(w * t + k) : -a * w * w * sin(w * t + k);
}

static int drive(void *user, double t, double *s, double *sdot, double *sddot)
{
    (void)user;
    *s = wave(0, t, 0), *sdot = wave(0, t, 1), *sddot = wave(0, t, 2);
    return 0;
}

static int move_root(void *user, double t, double *p, double *V, double *A)
{
    (void)user;
    for (int k = 0; k < 3; ++k) p[k] = wave(k, t, 0), V[k] = wave(k, t, 1), A[k] = wave(k, t, 2);
    return 0;
}

static mbsr_joint random_joint(test_rng *rng, bool point)
{
    const mbsr_planar_frame A = {test_uniform(rng), test_uniform(rng), 3.0 * test_uniform(rng)},
                            B = {test_uniform(rng), test_uniform(rng), 3.0 * test_uniform(rng)};
    static const int all[] = {MBSR_X, MBSR_Y, MBSR_ANGLE};
    const int driven = share(rng) < 0.2 ? all[test_integer(rng, 0, point ? 1 : 2)] : 0,
              mask = point ? 3 : 7, wanted = test_integer(rng, 1, mask) & ~driven & mask;
    if (point && wanted == 3) return mbsr_joint_point_free();
    if (point) return mbsr_joint_point(A, wanted, driven, driven ? drive : NULL, NULL);
    return mbsr_joint_planar(A, B, wanted, driven, driven ? drive : NULL, NULL);
}

/* ---- trees ---- */

static void add_force(test_plane_tree *s, mbsr_force_def def)
{
    assert_ok(mbsr_model_add_force(s->model, &def, NULL), mbsr_model_error(s->model));
}

/* Springs to the ground along every axis, and here and there to another body. */
static void add_springs(test_plane_tree *s, test_rng *rng, const test_plane_choice *c, int body,
                        bool point)
{
    for (int axis = 0; axis < (point ? 2 : 3); ++axis) {
        const double stiffness = 2.0 + share(rng), damping = 1.0 + share(rng);
        if (c->damped) {
            add_force(
                s, mbsr_force_axis_spring(body, MBSR_GROUND, axis, stiffness, damping, share(rng)));
        }
        const int other = test_integer(rng, 0, c->bodies - 1);
        if (axis < 2 && other != body && share(rng) < 0.2)
            add_force(s, mbsr_force_axis_spring(body, other, axis, stiffness, damping, 0.3));
    }
}

void test_plane_make(test_plane_tree *s, test_plane_choice c)
{
    test_rng rng = test_seed(c.seed);
    bool point[TEST_PLANE_BODIES];
    mbsr_model_def def = mbsr_default_model_def();
    if (c.moving) def.root = mbsr_root_moving(MBSR_SPACE_PLANAR, 3, 3, move_root, NULL);
    assert_ok(mbsr_model_create(&def, &s->model, NULL), NULL);
    for (int k = 0; k < c.bodies; ++k) {
        mbsr_body_def body = mbsr_default_body_def();
        point[k] = share(&rng) < 0.4;
        body.parent = test_integer(&rng, -1, k - 1);
        while (c.rigid && body.parent >= 0 && point[body.parent]) --body.parent;
        body.joint = random_joint(&rng, point[k]);
        body.inertia = random_inertia(&rng, &c, point[k], s->shape[k], s->matrix[k]);
        assert_ok(mbsr_model_add_body(s->model, &body, NULL), mbsr_model_error(s->model));
    }
    for (int k = 0; k < c.bodies; ++k) add_springs(s, &rng, &c, k, point[k]);
    add_force(s, mbsr_force_gravity(0.3, -9.81, 0.0));
    assert_ok(mbsr_model_finish(s->model), mbsr_model_error(s->model));
    assert_ok(mbsr_data_create(s->model, &s->data, NULL), NULL);
    s->nq = mbsr_model_nq(s->model);
    s->nu = mbsr_model_nu(s->model);
    s->t = 0.4;
    test_fill(&rng, s->nq, s->q);
    test_fill(&rng, s->nu, s->u);
}

void test_plane_free(test_plane_tree *s)
{
    mbsr_data_destroy(s->data);
    mbsr_model_destroy(s->model);
}
