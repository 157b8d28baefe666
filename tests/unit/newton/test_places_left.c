/* A body that flies hangs by a hinge at its origin on a body without mass, which three slides with
 * springs and dampers carry. Places of slides that are left to the loop, since their own rows
 * vanish beside it, are found with it: the front solves as the sweeps in vector code do.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"

#include <mbsrank/newton.h>

#include <math.h>
#include <stdbool.h>

enum { NUMBERS = 64 };

static int add_body(mbsr_model *m, int parent, mbsr_joint joint, mbsr_inertia inertia)
{
    mbsr_body_def body = mbsr_default_body_def();
    int id;
    body.parent = parent;
    body.joint = joint;
    body.inertia = inertia;
    assert_ok(mbsr_model_add_body(m, &body, &id), mbsr_model_error(m));
    return id;
}

static mbsr_frame some_frame(test_rng *rng)
{
    double x[3], quaternion[4];
    test_fill(rng, 3, x);
    test_fill(rng, 4, quaternion);
    return mbsr_frame_quaternion(x, quaternion);
}

/* Closed where all coordinates are zero. The hinge is cut off from either of both bodies. */
static mbsr_model *hanging(test_rng *rng, bool from_slides)
{
    static const double axis[3][3] = {{0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}, {1.0, 0.0, 0.0}},
                        com[3] = {0.25, 0.0, -0.25}, tensor[6] = {0.3, 0.3, 0.2},
                        stiffness[4] = {3.0, 0.0, 0.0, 0.0}, damping[4] = {1.0, 1.0, 0.5, 3.0};
    const mbsr_frame at = some_frame(rng), slides = some_frame(rng),
                     back = mbsr_frame_inverse(&slides), there = mbsr_frame_product(&back, &at);
    const mbsr_joint hinge = mbsr_joint_revolute(from_slides ? &there : NULL, NULL, axis[0]);
    mbsr_model *m;
    int cut;
    double point[2][3];
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    for (int k = 0; k < 3; ++k)
        add_body(m, k - 1, mbsr_joint_prismatic(k ? NULL : &slides, NULL, axis[k]),
                 mbsr_inertia_zero());
    add_body(m, MBSR_GROUND, mbsr_joint_free(&at, NULL), mbsr_inertia_rigid(2.5, com, tensor));
    assert_ok(mbsr_model_add_loop_joint(m, "loop", from_slides ? 2 : 3, &hinge, from_slides ? 3 : 2,
                                        from_slides ? NULL : &there, NULL, &cut),
              mbsr_model_error(m));
    for (int k = 0; k < 4; ++k) {
        const mbsr_force_def force =
            mbsr_force_joint_spring(k < 3 ? k : cut, 0, stiffness[k], damping[k], 0.0);
        assert_ok(mbsr_model_add_force(m, &force, NULL), mbsr_model_error(m));
    }
    for (int k = 0; k < 2; ++k) test_fill(rng, 3, point[k]);
    for (int k = 0; k < 2; ++k) {
        const mbsr_force_def force =
            mbsr_force_point_spring(3, point[0], k ? 2 : MBSR_GROUND, point[1], 6.0, 0.0, 1.0);
        assert_ok(mbsr_model_add_force(m, &force, NULL), mbsr_model_error(m));
    }
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    return m;
}

/* delta of r = 1, 2, ... */
static int solve(const mbsr_model *m, mbsr_data *d, const double *y, const double *yp, double c,
                 int front, double *delta)
{
    const int size = mbsr_dae_size(m, MBSR_DAE_MOMENTUM);
    mbsr_newton_opt opt = mbsr_default_newton_opt();
    mbsr_newton *newton;
    opt.by_blocks = front;
    assert_ok(mbsr_newton_create(m, MBSR_DAE_MOMENTUM, &opt, &newton, NULL), NULL);
    for (int k = 0; k < size; ++k) delta[k] = 1.0 + k;
    int status = mbsr_newton_factor(newton, d, 0.0, y, yp, c);
    if (!status) status = mbsr_newton_solve(newton, delta, delta);
    mbsr_newton_destroy(newton);
    return status;
}

static void places_wait_for_loops(void **state)
{
    (void)state;
    int wrong = 0;
    for (int seed = 0; seed < 20; ++seed) {
        test_rng rng = test_seed((uint64_t)seed);
        double q[NUMBERS] = {0.0, 0.0, 0.0, 1.0}, u[NUMBERS] = {0.0}, y[2 * NUMBERS],
               yp[2 * NUMBERS], delta[2][2 * NUMBERS];
        mbsr_data *d;
        mbsr_model *m = hanging(&rng, seed % 2);
        test_fill(&rng, 3, u);
        assert_ok(mbsr_data_create(m, &d, NULL), NULL);
        assert_ok(mbsr_dae_pack(m, d, MBSR_DAE_MOMENTUM, 0.0, q, u, y), mbsr_data_error(d));
        assert_ok(mbsr_dae_consistent(m, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL),
                  mbsr_data_error(d));
        for (double c = 0.01; c < 2e3; c *= 10.0) {
            double off = 0.0, most = 1.0;
            const int status = solve(m, d, y, yp, c, 0, delta[0]),
                      other = solve(m, d, y, yp, c, 1, delta[1]);
            for (int k = 0; k < mbsr_model_nq(m) + 2 * mbsr_model_nu(m); ++k) {
                off = fmax(off, fabs(delta[0][k] - delta[1][k]));
                most = fmax(most, fabs(delta[0][k]));
            }
            wrong += status || other || !(off < 1e-6 * most);
        }
        mbsr_data_destroy(d);
        mbsr_model_destroy(m);
    }
    assert_int_equal(wrong, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(places_wait_for_loops)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
