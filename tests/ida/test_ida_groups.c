/* Dummy bodies: joints of one axis in a row, of which all but the last move no mass of their own,
 * beside one joint with the freedoms of all of them. As the tree moves, the direction without mass
 * passes from one of them to the next.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "reference_runs.h"

#include <math.h>

static const double axis_x[3] = {1.0, 0.0, 0.0}, tip[3] = {0.0, 0.6, 0.0};

enum { SLIDES = 2, GIMBAL = 5, POINTS = 8 };

/* The axes before the last joint: two slides, or three and two turns. */
static const mbsr_axis chain[GIMBAL] = {
    {.kind = MBSR_AXIS_TRANSLATION, .direction = {0.0, 1.0, 0.0}},
    {.kind = MBSR_AXIS_TRANSLATION, .direction = {0.0, 0.0, 1.0}},
    {.kind = MBSR_AXIS_TRANSLATION, .direction = {1.0, 0.0, 0.0}},
    {.kind = MBSR_AXIS_ROTATION, .direction = {0.0, 0.0, 1.0}},
    {.kind = MBSR_AXIS_ROTATION, .direction = {0.0, 1.0, 0.0}}};

/* A rod without mass, with a point mass at its end, turns about x on the first `count` axes, a body
 * each or, with `merged`, all in one joint; springs and dampers hold them. `rotor`: the last of
 * these bodies has a moment of inertia and no mass, which the slides do not move. */
static mbsr_model *bead(int count, int merged, double rotor)
{
    mbsr_model *m = run_model();
    const double tensor[6] = {rotor, rotor, rotor, 0.0, 0.0, 0.0}, origin[3] = {0.0, 0.0, 0.0};
    const mbsr_inertia carried =
        rotor > 0.0 ? mbsr_inertia_rigid(0.0, origin, tensor) : mbsr_inertia_zero();
    int body[GIMBAL], on = MBSR_GROUND;
    if (merged)
        on = run_body(m, "all", on, mbsr_joint_compound(NULL, NULL, count, chain, NULL, NULL),
                      carried);
    for (int k = 0; k < count; ++k) {
        const double *axis = chain[k].direction;
        const mbsr_joint joint = chain[k].kind == MBSR_AXIS_TRANSLATION
                                     ? mbsr_joint_prismatic(NULL, NULL, axis)
                                     : mbsr_joint_revolute(NULL, NULL, axis);
        if (!merged)
            on = run_body(m, NULL, on, joint, k < count - 1 ? mbsr_inertia_zero() : carried);
        body[k] = on;
    }
    run_body(m, "rod", on, mbsr_joint_revolute(NULL, NULL, axis_x),
             mbsr_inertia_point_mass(1.0, tip));
    run_force(m, mbsr_force_gravity(0.0, 0.0, -9.81));
    for (int k = 0; k < count; ++k) {
        const double size = chain[k].kind == MBSR_AXIS_TRANSLATION ? 1.0 : 0.36;
        run_force(m,
                  mbsr_force_joint_spring(body[k], merged ? k : 0, 100.0 * size, 5.0 * size, 0.0));
    }
    return run_finish(m);
}

/* One run; the coordinates at the outputs go to `state`. */
static mbsr_ida_stats integrate(int count, int merged, mbsr_dae_form form, double rotor,
                                double tolerance, run_state *state)
{
    const double turn = count == GIMBAL ? 0.3 : 0.0,
                 q[GIMBAL + 1] = {0.0, 0.0, 0.0, turn, turn + turn / 3.0, 2.0 * turn};
    double u[GIMBAL + 1] = {0.0};
    u[count] = count == SLIDES ? 25.0 : 8.0;
    mbsr_model *m = bead(count, merged, rotor);
    run r = {.name = merged ? "one joint" : "dummy bodies",
             .model = m,
             .form = form,
             .tolerance = tolerance,
             .T = 1.0,
             .points = POINTS,
             .q = q,
             .u = u};
    run_integrate(&r, state);
    assert_int_equal(r.info.null_directions, count == SLIDES ? 1 : 3);
    if (form == MBSR_DAE_MOMENTUM) assert_int_equal(r.stats.linear_solver, MBSR_IDA_TREE);
    mbsr_model_destroy(m);
    return r.stats;
}

static double distance(int count, const run_state *a, const run_state *b)
{
    double off = 0.0;
    for (int k = 0; k <= POINTS; ++k) {
        for (int l = 0; l <= count; ++l) off = fmax(off, fabs(a[k].q[l] - b[k].q[l]));
    }
    return off;
}

/* Dummy bodies are as good as one joint, in the mean of three tolerances side by side; `exact`: the
 * way at a sharp tolerance, `all`: sums of steps and iterations. */
static void compare(int count, mbsr_dae_form form, double rotor, double tolerance,
                    const run_state *exact, mbsr_ida_stats all[2])
{
    run_state state[2][POINTS + 1];
    mbsr_ida_stats stats[2];
    double error[2];
    for (int merged = 0; merged < 2; ++merged) {
        /* one run's error depends on rounding by a factor of 2 */
        error[merged] = 0.0;
        for (int near = 1; near >= -1; --near) {
            const mbsr_ida_stats one = integrate(count, merged, form, rotor,
                                                 (1.0 + 0.02 * near) * tolerance, state[merged]);
            error[merged] += distance(count, state[merged], exact) / 3.0;
            all[merged].steps += one.steps;
            all[merged].newton_iterations += one.newton_iterations;
            if (near == 0) stats[merged] = one;
        }
    }
    print_message("%d bodies, %s, tolerance %.0e, rotor %g: %ld steps, %ld iterations, error %.1e; "
                  "merged %ld, %ld, %.1e\n",
                  count, run_form_name(form), tolerance, rotor, stats[0].steps,
                  stats[0].newton_iterations, error[0], stats[1].steps, stats[1].newton_iterations,
                  error[1]);
    assert_less(error[0], 1.5 * error[1] + tolerance);
}

/* Rounding decides between steps of single runs; of all together they are as many. */
static void assert_as_many(const mbsr_ida_stats all[2])
{
    assert_true(100 * all[0].steps <= 102 * all[1].steps);
    assert_true(100 * all[0].newton_iterations <= 102 * all[1].newton_iterations);
}

static void the_rank_may_pass_from_body_to_body(void **state)
{
    (void)state;
    static const int counts[2] = {SLIDES, GIMBAL};
    for (int k = 0; k < 2; ++k) {
        run_state exact[POINTS + 1];
        mbsr_ida_stats all[2] = {{.steps = 0}, {.steps = 0}};
        double turned = 0.0;
        (void)integrate(counts[k], 1, MBSR_DAE_MOMENTUM, 0.0, 1e-12, exact);
        for (int l = 0; l <= POINTS; ++l) turned = fmax(turned, fabs(exact[l].q[counts[k]]));
        assert_true(turned > 3.2); /* the rod lay along each of the slides */
        for (double tolerance = 1e-4; tolerance > 0.5e-9; tolerance *= 0.1)
            compare(counts[k], MBSR_DAE_MOMENTUM, 0.0, tolerance, exact, all);
        assert_as_many(all);
        if (k > 0) continue;
        compare(SLIDES, MBSR_DAE_MOMENTUM, 0.1, 1e-8, exact, all);
        compare(SLIDES, MBSR_DAE_INDEX1, 0.0, 1e-6, exact, all);
        compare(SLIDES, MBSR_DAE_INDEX1, 0.1, 1e-8, exact, all);
        assert_as_many(all);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_rank_may_pass_from_body_to_body),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
