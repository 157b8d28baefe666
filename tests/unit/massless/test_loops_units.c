/* Starts of a closed mechanism with bodies without mass that no loop holds, in four systems of
 * units.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "body.h"
#include "close.h"
#include "units.h"

#include <mbsrank/mbsrank.h>

#include <math.h>
#include <stdbool.h>

enum { SLIDE = 3, SWING = 4, BODIES = 5, MOST = 64 };

typedef struct start {
    double q[BODIES], u[BODIES], udot[BODIES];
    int null, elastic;
} start;

static mbsr_inertia rod(const units *of, double mass, double length)
{
    const double com[2] = {0.5 * length * of->length, 0.0};
    return mbsr_inertia_planar(mass * of->mass, com,
                               mass * length * length / 12.0 * of->mass * of->length * of->length);
}

static void add_force(mbsr_model *m, const mbsr_force_def *force)
{
    assert_ok(mbsr_model_add_force(m, force, NULL), mbsr_model_error(m));
}

/* A bushing between the ground and a body without mass. */
static void hold(mbsr_model *m, const units *of, int body, double stiffness, double damping)
{
    const double N_m = of->mass / (of->time * of->time), turn = of->length * of->length;
    const double K[9] = {stiffness * N_m,
                         0.0,
                         0.0,
                         0.0,
                         0.7 * stiffness * N_m,
                         0.0,
                         0.0,
                         0.0,
                         0.1 * stiffness * N_m * turn};
    const double D[9] = {damping * N_m * of->time,
                         0.0,
                         0.0,
                         0.0,
                         damping * N_m * of->time,
                         0.0,
                         0.0,
                         0.0,
                         0.1 * damping * N_m * turn * of->time};
    const mbsr_planar_frame at = {1.1 * of->length, 0.9 * of->length, 0.0}, none = {0.0, 0.0, 0.0};
    const mbsr_force_def bushing = mbsr_force_planar_bushing(MBSR_GROUND, at, body, none, K, D);
    add_force(m, &bushing);
}

/* A four-bar linkage; a slide on its coupler and a swing on its rocker have no mass. The swing is
 * damped, the slide where `damping` is not zero. */
static mbsr_model *linkage(const units *of, double damping)
{
    const double L = of->length, gravity = -9.81 * L / (of->time * of->time);
    const mbsr_planar_frame none = {0.0, 0.0, 0.0}, tip = {L, 0.0, 0.0},
                            right = {2.0 * L, 0.0, 0.0}, middle = {1.2 * L, 0.1 * L, 0.2};
    mbsr_model *m = NULL;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    const int crank = test_add_body(m, MBSR_GROUND, mbsr_joint_planar_revolute(none, none),
                                    rod(of, 1.0, 1.0)),
              coupler =
                  test_add_body(m, crank, mbsr_joint_planar_revolute(tip, none), rod(of, 2.5, 2.5)),
              rocker = test_add_body(m, MBSR_GROUND, mbsr_joint_planar_revolute(right, none),
                                     rod(of, 2.0, 2.0)),
              slide = test_add_body(m, coupler, mbsr_joint_planar_prismatic(middle, none),
                                    mbsr_inertia_zero()),
              swing = test_add_body(m, rocker, mbsr_joint_planar_revolute(tip, none),
                                    mbsr_inertia_zero());
    const mbsr_force_def weight = mbsr_force_gravity(0.0, gravity, 0.0);
    add_force(m, &weight);
    hold(m, of, slide, 300.0, damping);
    hold(m, of, swing, 200.0, 4.0);
    const mbsr_closure_def pin = mbsr_closure_ball(coupler, (double[3]){2.5 * L, 0.0, 0.0}, rocker,
                                                   (double[3]){2.0 * L, 0.0, 0.0});
    assert_ok(mbsr_model_add_closure(m, &pin, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    return m;
}

/* What the start makes of a guess, in SI units; the rate of the crank is kept, or none. */
static start find(const units *of, double damping, bool kept)
{
    const double q[BODIES] = {1.2, -0.9, 1.9, 0.2 * of->length, 0.3},
                 u[BODIES] = {3.0 / of->time, -1.0 / of->time, 2.0 / of->time,
                              0.4 * of->length / of->time, 0.5 / of->time};
    double y[MOST] = {0.0}, yp[MOST] = {0.0};
    static const int crank[BODIES] = {1, 0, 0, 0, 0};
    mbsr_consistent_opt opt = mbsr_default_consistent_opt();
    mbsr_consistent_info info;
    mbsr_data *d = NULL;
    mbsr_model *m = linkage(of, damping);
    if (kept) opt.keep_rate = crank;
    start found;
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    assert_in_range(mbsr_dae_size(m, MBSR_DAE_MOMENTUM), 1, MOST);
    assert_ok(mbsr_dae_pack(m, d, MBSR_DAE_MOMENTUM, 0.0, q, u, y), mbsr_data_error(d));
    assert_ok(mbsr_dae_consistent(m, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, &opt, &info),
              mbsr_data_error(d));
    for (int k = 0; k < BODIES; ++k) {
        const double span = k == SLIDE ? of->length : 1.0;
        found.q[k] = y[k] / span;
        found.u[k] = y[2 * BODIES + k] * of->time / span;
        found.udot[k] = yp[2 * BODIES + k] * of->time * of->time / span;
    }
    if (kept) assert_true(y[2 * BODIES] == u[0]);
    found.null = info.null_directions;
    found.elastic = info.elastic;
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
    return found;
}

static void compare(double damping, int elastic, double tolerance, bool kept)
{
    const start si = find(systems, damping, kept);
    assert_int_equal(si.null, 2);
    assert_int_equal(si.elastic, elastic);
    for (size_t k = 1; k < sizeof systems / sizeof systems[0]; ++k) {
        const start other = find(systems + k, damping, kept);
        assert_int_equal(other.null, si.null);
        assert_int_equal(other.elastic, si.elastic);
        for (int l = 0; l < BODIES; ++l) {
            assert_close(other.q[l], si.q[l], 1e-9);
            assert_close(other.u[l], si.u[l], tolerance);
            assert_close(other.udot[l], si.udot[l], 100.0 * tolerance);
        }
    }
}

static void damped(void **state)
{
    (void)state;
    for (int kept = 0; kept < 2; ++kept) compare(5.0, 0, 1e-8, kept == 1);
}

static void elastic(void **state)
{
    (void)state;
    for (int kept = 0; kept < 2; ++kept) compare(0.0, 1, 1e-7, kept == 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(damped), cmocka_unit_test(elastic)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
