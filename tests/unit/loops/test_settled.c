/* Starts that load settled springs where the forces that these bear depend on how far they give
 * way.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "body.h"
#include "close.h"
#include "units.h"

#include <mbsrank/mbsrank.h>

#include <math.h>
#include <stdlib.h>

enum { SLIDES = 4, SIZE = 5 * SLIDES };

/* Slides along one line, each drawn from 0 to `far` by a spring as stiff as `share` says beside
 * that of the row that holds it there; at rest. */
static mbsr_model *slides(const units *in, const double *share, double *far)
{
    const double stiffness = 1e4 * in->mass / (in->time * in->time), along[3] = {1.0, 0.0, 0.0};
    mbsr_model *m = NULL;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    for (int k = 0; k < SLIDES; ++k) {
        far[k] = (0.1 + 0.02 * k) * in->length;
        const int slide = test_add_body(m, MBSR_GROUND, mbsr_joint_prismatic(NULL, NULL, along),
                                        mbsr_inertia_particle((1.0 + k) * in->mass));
        const mbsr_force_def spring =
            mbsr_force_joint_spring(slide, 0, share[k] * stiffness, 0.0, far[k]);
        mbsr_closure_def held = mbsr_closure_rows(slide, NULL, MBSR_GROUND, NULL, 1, along);
        held.stiffness[0] = stiffness;
        assert_ok(mbsr_model_add_force(m, &spring, NULL), mbsr_model_error(m));
        assert_ok(mbsr_model_add_closure(m, &held, NULL), mbsr_model_error(m));
    }
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    return m;
}

/* x = far share / (1 + share). Gaps found for the forces at one another would miss that by share^n.
 */
static void springs_share_the_way(void **state)
{
    (void)state;
    static const double share[][SLIDES] = {{0.1, 0.2, 0.3, 0.4},
                                           {0.9, 0.5, 0.3, 0.7},
                                           {0.99, 0.5, 0.98, 0.2},
                                           {2.0, 0.5, 0.1, 0.9},
                                           {3.0, 2.0, 0.5, 0.9}};
    for (size_t s = 0; s < sizeof systems / sizeof systems[0]; ++s) {
        for (size_t k = 0; k < sizeof share / sizeof share[0]; ++k) {
            double far[SLIDES], y[SIZE] = {0.0}, yp[SIZE], F[SIZE];
            mbsr_model *m = slides(systems + s, share[k], far);
            mbsr_data *d = NULL;
            assert_ok(mbsr_data_create(m, &d, NULL), NULL);
            assert_int_equal(mbsr_dae_size(m, MBSR_DAE_MOMENTUM), SIZE);
            assert_ok(mbsr_dae_consistent(m, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL),
                      mbsr_data_error(d));
            for (int i = 0; i < SLIDES; ++i)
                assert_close(y[i], far[i] * share[k][i] / (1.0 + share[k][i]),
                             1e-11 * fmax(1.0, far[i]));
            assert_ok(mbsr_dae_residual(m, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, F),
                      mbsr_data_error(d));
            assert_less(test_largest(SLIDES, F + 4 * SLIDES), 1e-11 * fmax(1.0, systems[s].length));
            mbsr_data_destroy(d);
            mbsr_model_destroy(m);
        }
    }
}

/* A coupler on five legs, all turned by 2 rad: three of the eight rows of its pins depend on
 * others, and the legs' shares of its weight are the same however stiff the pins are, also where
 * their gaps are rounding. What they bear is s + d / k s'. */
static void legs_share_what_they_bear(void **state)
{
    (void)state;
    enum { LEGS = 5, NU = LEGS + 1, ROWS = 2 * (LEGS - 1), ALL = 3 * NU + 2 * ROWS };
    static const double stiffness[] = {1e8, 1e10, 1e12, 1e14, 1e16};
    double first[ROWS];
    for (int l = 0; l < 5; ++l) {
        mbsr_model *m = NULL;
        mbsr_data *d = NULL;
        double q[NU], u[NU], y[ALL], yp[ALL];
        const mbsr_planar_frame here = {0.0, 0.0, 0.0}, tip = {1.0, 0.0, 0.0};
        const double half[2] = {0.5, 0.0}, middle[2] = {0.5 * (LEGS - 1), 0.0}, end[3] = {1.0};
        const mbsr_force_def weight = mbsr_force_gravity(0.0, -9.81, 0.0);
        assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
        for (int k = 0; k < LEGS; ++k) {
            const mbsr_planar_frame at = {k, 0.0, 0.0};
            test_add_body(m, MBSR_GROUND, mbsr_joint_planar_revolute(at, here),
                          mbsr_inertia_planar(1.0, half, 1.0 / 12.0));
            q[k] = 2.0, u[k] = 1.0;
        }
        q[LEGS] = -2.0, u[LEGS] = -1.0;
        const int coupler = test_add_body(m, 0, mbsr_joint_planar_revolute(tip, here),
                                          mbsr_inertia_planar(4.0, middle, 64.0 / 12.0));
        assert_ok(mbsr_model_add_force(m, &weight, NULL), mbsr_model_error(m));
        for (int k = 1; k < LEGS; ++k) {
            mbsr_closure_def pin = mbsr_closure_ball(k, end, coupler, (double[3]){k, 0.0, 0.0});
            for (int r = 0; r < 2; ++r)
                pin.stiffness[r] = stiffness[l], pin.damping[r] = 1e-4 * stiffness[l];
            assert_ok(mbsr_model_add_closure(m, &pin, NULL), mbsr_model_error(m));
        }
        assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
        assert_ok(mbsr_data_create(m, &d, NULL), NULL);
        assert_int_equal(mbsr_dae_size(m, MBSR_DAE_MOMENTUM), ALL);
        assert_ok(mbsr_dae_pack(m, d, MBSR_DAE_MOMENTUM, 0.0, q, u, y), mbsr_data_error(d));
        assert_ok(mbsr_dae_consistent(m, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL),
                  mbsr_data_error(d));
        for (int r = 0; r < ROWS; ++r) {
            const double borne = y[3 * NU + r] + 1e-4 * yp[3 * NU + r];
            if (l == 0) first[r] = borne;
            assert_close(borne, first[r], 1e-6 * 10.0);
        }
        mbsr_data_destroy(d);
        mbsr_model_destroy(m);
    }
}

/* Arms that hang on two bushings each, 0.4 m apart along y, their weights 0.3 m out along x: six of
 * twelve rows depend on the others. Both bushings bear half of weight and moment; across and along
 * the line between them springs of two kinds bear the moment of the weight. */
static void arms_on_bushings(void **state)
{
    (void)state;
    enum { ARMS = 30, ROWS = 12 };
    static const double stiffness[] = {1e5, 1e7, 1e9}, mass = 5.0, out = 0.3, half = 0.2,
                        down = 9.81, side = 0.3;
    for (int l = 0; l < 12; ++l) {
        const units *in = systems + l % 4;
        const double k = stiffness[l / 4] * in->mass / (in->time * in->time),
                     turn = 1e-2 * k * in->length * in->length, meter = in->length,
                     weight = in->mass * in->length / (in->time * in->time),
                     K[6] = {turn, turn, turn, k, k, k}, damping = 1e-3 * in->time,
                     com[3] = {out * meter, 0.0, 0.0},
                     tensor[6] = {0.05 * in->mass * meter * meter, 0.2 * in->mass * meter * meter,
                                  0.2 * in->mass * meter * meter};
        double D[6];
        mbsr_model *m = NULL;
        mbsr_data *d = NULL;
        for (int r = 0; r < 6; ++r) D[r] = damping * K[r];
        const mbsr_force_def load = mbsr_force_gravity(0.0, side * meter / (in->time * in->time),
                                                       -down * meter / (in->time * in->time));
        assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
        for (int i = 0; i < ARMS; ++i) {
            const mbsr_frame at = mbsr_frame_at(i * meter, 0.0, 0.0);
            const int arm = test_add_body(m, MBSR_GROUND, mbsr_joint_free(&at, NULL),
                                          mbsr_inertia_rigid(mass * in->mass, com, tensor));
            for (int s = -1; s <= 1; s += 2) {
                const mbsr_frame there = mbsr_frame_at(i * meter, s * half * meter, 0.0),
                                 here = mbsr_frame_at(0.0, s * half * meter, 0.0);
                mbsr_force_def bushing = mbsr_force_bushing(MBSR_GROUND, &there, arm, &here, K, D);
                bushing.as_closure = MBSR_SPRING_SETTLED;
                assert_ok(mbsr_model_add_force(m, &bushing, NULL), mbsr_model_error(m));
            }
        }
        assert_ok(mbsr_model_add_force(m, &load, NULL), mbsr_model_error(m));
        assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
        assert_ok(mbsr_data_create(m, &d, NULL), NULL);
        const int nq = mbsr_model_nq(m), nu = mbsr_model_nu(m),
                  size = mbsr_dae_size(m, MBSR_DAE_MOMENTUM);
        double *y = calloc(3 * (size_t)size, sizeof *y), *yp = y + size, *F = yp + size;
        for (int i = 0; i < ARMS; ++i) y[7 * i] = 1.0;
        assert_ok(mbsr_dae_consistent(m, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL),
                  mbsr_data_error(d));
        const double *s = y + nq + 2 * nu;
        const double force = mass * down * weight, moment = out * force * meter;
        for (int i = 0; i < ARMS; ++i) {
            for (int b = 0; b < 2; ++b) {
                const double *own = s + ROWS * i + 6 * b;
                assert_close(own[1], 0.5 * moment, 1e-3 * moment);
                assert_close(own[4], 0.5 * mass * side * weight, 1e-3 * force);
                assert_close(own[5], -0.5 * force, 1e-3 * force);
            }
            for (int r = 0; r < ROWS; ++r)
                assert_close(s[ROWS * i + r], s[r], 1e-6 * (r % 6 < 3 ? moment : force));
        }
        assert_ok(mbsr_dae_residual(m, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, F), mbsr_data_error(d));
        assert_less(test_largest(size, F), 1e-11 * fmax(1.0, in->length * in->mass));
        free(y);
        mbsr_data_destroy(d);
        mbsr_model_destroy(m);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(springs_share_the_way),
                                       cmocka_unit_test(legs_share_what_they_bear),
                                       cmocka_unit_test(arms_on_bushings)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
