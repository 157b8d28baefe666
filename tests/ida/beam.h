/* The beam of the Test Set for IVP Solvers: a chain of 40 rods without mass with particles between
 * them, each body rank-deficient, each joint with inertia; in the plane and in space.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The test set's unknowns are the angles theta_k of the rods against the x axis; the joints have
 * the differences of them. The reference values are those of the test set at t = 5. */
#ifndef TEST_BEAM_H
#define TEST_BEAM_H

#include "reference_runs.h"

enum { BEAM_RODS = RUN_MOST };
static const double BEAM_SOON = 0.2; /* s */

/* (-phi, phi) at the tip: the first two of the three components of a body in the plane, or the
 * fourth and fifth of six in space. */
static inline int beam_tip_force(void *unused, double t, int n, double *value)
{
    (void)unused;
    const double pi = acos(-1.0), phi = t <= pi ? 1.5 * sin(t) * sin(t) : 0.0;
    double *force = n == 6 ? value + 3 : value;
    for (int k = 0; k < n; ++k) value[k] = 0.0;
    force[0] = -phi, force[1] = phi;
    return MBSR_OK;
}

/* The reference point of each body is its particle at the outer end of the rod. `space`: of bodies
 * in space that turn about z. */
static inline mbsr_model *beam(int space)
{
    mbsr_model *m = run_model();
    const mbsr_planar_frame inner_end = {-1.0 / BEAM_RODS, 0.0, 0.0};
    const mbsr_frame inner_in_space = mbsr_frame_at(-1.0 / BEAM_RODS, 0.0, 0.0);
    const double axis[3] = {0.0, 0.0, 1.0}, at[3] = {0.0, 0.0, 0.0};
    int predecessor = MBSR_GROUND;
    for (int k = 0; k < BEAM_RODS; ++k) {
        const double mass = k < BEAM_RODS - 1 ? 1.0 / BEAM_RODS : 0.5 / BEAM_RODS;
        predecessor =
            run_body(m, NULL, predecessor,
                     space ? mbsr_joint_revolute(NULL, &inner_in_space, axis)
                           : mbsr_joint_planar_revolute(run_origin, inner_end),
                     space ? mbsr_inertia_point_mass(mass, at) : mbsr_inertia_particle(mass));
        run_force(m, mbsr_force_joint_spring(predecessor, 0, k == 0 ? 2.0 * BEAM_RODS : BEAM_RODS,
                                             0.0, 0.0));
    }
    run_force(m, mbsr_force_applied(predecessor, beam_tip_force, NULL));
    return run_finish(m);
}

/* Largest relative error of three angles and three rates at t = 5. */
static inline double beam_error(const run_state *s)
{
    static const struct {
        int rod, rate;
        double value;
    } reference[] = {{1, 0, -0.5792366591285007e-2}, {2, 0, -0.1695298550721735e-1},
                     {40, 0, -0.1767201761075488},   {1, 1, 0.03747362681329794},
                     {10, 1, 0.5987609702624270},    {40, 1, 1.186724615113034}};
    double worst = 0.0;
    for (size_t r = 0; r < sizeof reference / sizeof reference[0]; ++r) {
        double value = 0.0;
        for (int k = 0; k < reference[r].rod; ++k) value += reference[r].rate ? s->u[k] : s->q[k];
        worst = run_larger(worst, fabs(value / reference[r].value - 1.0));
    }
    return worst;
}

/* Largest difference of angles or rates, relative to the largest of them. */
static inline double beam_distance(const run_state *s, const run_state *reference)
{
    double q = 0.0, u = 0.0;
    for (int k = 0; k < BEAM_RODS; ++k) {
        q = run_larger(q, fabs(s->q[k] - reference->q[k]));
        u = run_larger(u, fabs(s->u[k] - reference->u[k]));
    }
    return run_larger(q / test_largest(BEAM_RODS, reference->q),
                      u / test_largest(BEAM_RODS, reference->u));
}

/* The state of the planar one at BEAM_SOON, in the momentum form by small steps. */
static inline const run_state *beam_soon(void)
{
    static run_state state[2];
    if (state[1].t > 0.0) return state + 1;
    mbsr_model *m = beam(0);
    run r = {.model = m,
             .form = MBSR_DAE_MOMENTUM,
             .tolerance = 1e-12,
             .max_step = 2.5e-5,
             .T = BEAM_SOON,
             .points = 1};
    run_integrate(&r, state);
    mbsr_model_destroy(m);
    return state + 1;
}

/* The momentum form goes to t = 5, in slow builds only to BEAM_SOON, as do the other forms unless
 * long runs are asked for. */
static inline void check_beam(const mbsr_model *m, mbsr_dae_form form, double tolerance,
                              double max_step, double bound)
{
    static run_state state[2];
    const bool whole = test_long() || (form == MBSR_DAE_MOMENTUM && test_seeds(0, 1));
    run r = {.name = mbsr_body_dimension(m, 0) == 6 ? "beam in space" : "beam",
             .model = m,
             .form = form,
             .tolerance = tolerance,
             .max_step = max_step,
             .T = whole ? 5.0 : BEAM_SOON,
             .points = 1};
    run_integrate(&r, state);
    assert_int_equal(r.info.null_directions, 0);
    const double error = whole ? beam_error(state + 1) : beam_distance(state + 1, beam_soon());
    run_report(&r, error);
    assert_less(error, whole ? bound : 2e-5); /* relative to a small motion */
    r.tolerance = 1e-8;
    r.max_step = 7e-5;
    if (!test_long()) r.T = BEAM_SOON;
    if (form == MBSR_DAE_MOMENTUM) run_compare(&r, RUN_REPEATS);
}

#endif
