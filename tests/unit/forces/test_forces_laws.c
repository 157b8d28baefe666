/* The laws of force elements: values by hand, where they switch on and off, and elements on joints.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "parts.h"

static const double pi = 3.14159265358979323846;

static void ask_forces(const mbsr_force_def *def, test_part *parts, int count)
{
    assert_int_equal(test_ask(def, parts, count, TEST_FORCES, NULL), 0);
}

/* A force on a SPATIAL part is moment (mx, my, mz), force (fx, fy, fz). */
#define assert_wrench(part, mx, my, mz, fx, fy, fz, tolerance)                                     \
    do {                                                                                           \
        const double expected_[6] = {mx, my, mz, fx, fy, fz};                                      \
        for (int c_ = 0; c_ < 6; ++c_)                                                             \
            assert_close((part).f[c_], expected_[c_], (tolerance) * (1.0 + fabs(expected_[c_])));  \
    } while (0)

/* A body in space and the ground at rest. */
static void body_and_ground(test_part part[2])
{
    part[0] = test_part_make(MBSR_SPACE_SPATIAL);
    part[1] = test_part_make(MBSR_SPACE_FIXED);
}

static void turn(test_part *part, double ax, double ay, double az, double angle)
{
    const double axis[3] = {ax, ay, az};
    const mbsr_frame at = mbsr_frame_rotated(NULL, axis, angle);
    memcpy(part->p, at.R, sizeof at.R);
}

static void set(double *x, double a, double b, double c)
{
    x[0] = a, x[1] = b, x[2] = c;
}

/* ---- springs between points ------------------------------------------------------------------ */

static void a_spring_in_space_pulls_as_calculated_by_hand(void **state)
{
    (void)state;
    test_part part[2];
    body_and_ground(part);
    /* turned by 90 degrees about x the point (0, 0, 2) is at arm (0, -2, 0): at (1, 0, 3), moving
     * with (2, 0, 0.25); the ground's is 5 above, so the length shrinks by 0.25 */
    turn(part, 1, 0, 0, pi / 2.0);
    set(part->p + 9, 1, 2, 3);
    set(part->V, 0, 0, 1);
    set(part->V + 3, 0, 0, 0.25);
    const mbsr_spring spring = {
        .stiffness = 10.0, .cubic = 2.0, .damping = 0.5, .free_length = 3.0};
    const mbsr_force_def def = mbsr_force_spring(0, (const double[3]){0, 0, 2}, MBSR_GROUND,
                                                 (const double[3]){1, 0, 8}, &spring);
    const double force = 10.0 * 2.0 + 2.0 * 8.0 - 0.5 * 0.25;
    ask_forces(&def, part, 2);
    assert_wrench(part[0], -2.0 * force, 0, 0, 0, 0, force, 1e-13);
    assert_close(test_value(&def, part, 2, TEST_ENERGY), 5.0 * 4.0 + 0.5 * 16.0, 1e-12);
    assert_close(test_value(&def, part, 2, TEST_DISSIPATION), 0.5 * 0.0625, 1e-14);
}

/* Without free length and damping the force needs no direction, and is another formula. */
static void a_spring_without_free_length_pulls_along_its_ends(void **state)
{
    (void)state;
    const mbsr_spring spring = {.stiffness = 2.0, .cubic = 3.0};
    const mbsr_force_def def = mbsr_force_spring(0, NULL, MBSR_GROUND, NULL, &spring);
    test_part part[2];
    body_and_ground(part);
    set(part->p + 9, 2, 0, 0);
    set(part->V + 3, 0.7, 0.2, 0);
    assert_close(test_balance(&def, part, 2), 0.0, 0.0);
    assert_wrench(part[0], 0, 0, 0, -28, 0, 0, 1e-14);
    assert_close(test_value(&def, part, 2, TEST_ENERGY), 4.0 + 12.0, 1e-14);
}

/* Force towards the ground on a body at x with velocity v, by a cable of 1 m from the origin. */
static double cable(double x, double v, double *energy, double *heat)
{
    const mbsr_spring spring = {
        .stiffness = 100.0, .cubic = 1000.0, .damping = 5.0, .free_length = 1.0, .one_sided = 1};
    const mbsr_force_def def = mbsr_force_spring(0, NULL, MBSR_GROUND, NULL, &spring);
    test_part part[2];
    body_and_ground(part);
    part->p[9] = x;
    part->V[3] = v;
    ask_forces(&def, part, 2);
    if (energy) *energy = test_value(&def, part, 2, TEST_ENERGY);
    if (heat) *heat = test_value(&def, part, 2, TEST_DISSIPATION);
    return -part->f[3];
}

static void a_cable_pulls_and_never_pushes(void **state)
{
    (void)state;
    double E, P;
    assert_close(cable(0.5, 3.0, &E, &P), 0.0, 0.0);
    assert_close(E + P, 0.0, 0.0);
    assert_close(cable(0.0, 3.0, NULL, NULL), 0.0, 0.0); /* without direction, and needing none */
    assert_close(cable(1.0, 3.0, NULL, NULL), 0.0, 0.0);
    /* stretched by 0.1: elastic 10 + 1, damping 5 v within -11 .. 11 */
    assert_close(cable(1.1, 0.5, &E, &P), 13.5, 1e-12);
    assert_close(E, 0.5 + 0.025, 1e-13);
    assert_close(P, 1.25, 1e-12);
    assert_close(cable(1.1, -0.5, NULL, &P), 8.5, 1e-12);
    assert_close(P, 1.25, 1e-12);
    assert_close(cable(1.1, 100.0, NULL, &P), 22.0, 1e-12);
    assert_close(P, 1100.0, 1e-9);
    assert_close(cable(1.1, -100.0, NULL, &P), 0.0, 1e-12);
    assert_close(P, 1100.0, 1e-9);
}

static int no_law(void *user, double x, double v, double *force, double *energy, double *power)
{
    (void)x, (void)v, (void)force, (void)energy, (void)power;
    return *(const int *)user;
}

/* Two points in one place. */
static void springs_without_length_need_no_direction_or_say_so(void **state)
{
    (void)state;
    int code = 0;
    const struct {
        mbsr_spring spring;
        int status;
    } cases[] = {
        {{.stiffness = 2, .cubic = 3}, MBSR_OK},
        {{.stiffness = 2, .free_length = 1}, MBSR_DEGENERATE_FORCE},
        {{.stiffness = 2, .damping = 1}, MBSR_DEGENERATE_FORCE},
        {{.stiffness = 2, .free_length = 1, .damping = 1, .one_sided = 1}, MBSR_OK},
        {{.stiffness = 2, .damping = 1, .one_sided = 1}, MBSR_OK},
        {{.stiffness = 2, .function = no_law, .user = &code}, MBSR_DEGENERATE_FORCE},
    };
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; ++k) {
        const mbsr_force_def def = mbsr_force_spring(0, NULL, MBSR_GROUND, NULL, &cases[k].spring);
        test_part part[2];
        double value;
        body_and_ground(part);
        part->V[3] = 1.0;
        assert_int_equal(test_ask(&def, part, 2, TEST_FORCES, NULL), cases[k].status);
        assert_wrench(part[0], 0, 0, 0, 0, 0, 0, 0.0);
        const int heat = test_ask(&def, part, 2, TEST_DISSIPATION, &value);
        assert_int_equal(heat, cases[k].status);
        assert_close(value, 0.0, 0.0);
        assert_int_equal(test_ask(&def, part, 2, TEST_ENERGY, &value), 0);
        if (cases[k].spring.free_length > 0.0 && !cases[k].spring.one_sided)
            assert_close(value, 1.0, 1e-15);
    }
}

/* As far apart as the rounding of their places. */
static void a_free_length_needs_a_direction_that_is_not_rounding(void **state)
{
    (void)state;
    const struct {
        double apart, free_length, damping;
        int status;
    } cases[] = {{1e-16, 1.0, 0.0, MBSR_DEGENERATE_FORCE},
                 {1e-12, 1.0, 0.0, MBSR_OK},
                 {1e-16, 0.0, 1.0, MBSR_OK}};
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; ++k) {
        const double a[3] = {0.7, 0.0, 0.0}, b[3] = {0.7 + cases[k].apart, 0.0, 0.0};
        const mbsr_force_def def = mbsr_force_point_spring(0, a, MBSR_GROUND, b, 2.0,
                                                           cases[k].damping, cases[k].free_length);
        test_part part[2];
        body_and_ground(part);
        assert_int_equal(test_ask(&def, part, 2, TEST_FORCES, NULL), cases[k].status);
    }
}

/* A hinge about z that is free turns through pi; what tilts by pi has nowhere to go back to. */
static void a_bushing_at_half_a_turn_has_no_direction_where_it_is_stiff(void **state)
{
    (void)state;
    const double none[6] = {0}, hinge[6] = {5, 5, 0, 1, 1, 1}, stiff[6] = {5, 5, 5, 1, 1, 1};
    const double *of[] = {hinge, stiff};
    for (int k = 0; k < 2; ++k) {
        for (int l = 0; l < 2; ++l) {
            const mbsr_frame B = mbsr_frame_rotated(
                (const double[3]){0, 0, 0}, (const double[3]){0, 0, 1}, pi - (l ? 1e-9 : 0.0));
            const mbsr_force_def def = mbsr_force_bushing(MBSR_GROUND, NULL, 0, &B, of[k], none);
            test_part part[2];
            double value;
            body_and_ground(part);
            const test_part first = part[0];
            part[0] = part[1], part[1] = first;
            const int status = k == 1 && l == 0 ? MBSR_DEGENERATE_FORCE : MBSR_OK;
            assert_int_equal(test_ask(&def, part, 2, TEST_FORCES, NULL), status);
            assert_int_equal(test_ask(&def, part, 2, TEST_ENERGY, &value), MBSR_OK);
        }
    }
}

static void what_a_law_returns_is_passed_on(void **state)
{
    (void)state;
    int code = 17;
    const mbsr_spring spring = {.function = no_law, .user = &code};
    const mbsr_force_def def = mbsr_force_spring(0, NULL, MBSR_GROUND, NULL, &spring);
    test_part part[2];
    double value;
    body_and_ground(part);
    part->p[9] = 1.0;
    for (int ask = TEST_FORCES; ask <= TEST_DISSIPATION; ++ask)
        assert_int_equal(test_ask(&def, part, 2, (test_question)ask, &value), 17);
}

/* ---- bushing --------------------------------------------------------------------------------- */

static void a_bushing_holds_as_calculated_by_hand(void **state)
{
    (void)state;
    const double stiffness[6] = {2, 3, 4, 10, 20, 30}, damping[6] = {0.1, 0.2, 0.3, 1, 2, 3};
    /* A at (0, 0, 1), turned by 90 degrees about z: its x axis is the world's y, its y axis -x */
    const double z[3] = {0, 0, 1};
    const mbsr_frame A = mbsr_frame_rotated((const double[3]){0, 0, 1}, z, pi / 2.0),
                     B = mbsr_frame_rotated((const double[3]){0, 1, 0}, z, pi / 2.0);
    const mbsr_force_def def = mbsr_force_bushing(MBSR_GROUND, &A, 0, &B, stiffness, damping);
    test_part part[2];
    part[0] = test_part_make(MBSR_SPACE_FIXED);
    part[1] = test_part_make(MBSR_SPACE_SPATIAL);
    set(part[1].p + 9, 0.5, 0, 0);
    set(part[1].V, 0, 0, 2);
    set(part[1].V + 3, 3, 0, 0);
    /* B's origin at (0.5, 1, 0), in A (1, -0.5, -1); its velocity (3, 0, 0) + 2 ez x ey = (1, 0,
     * 0), in A (0, -1, 0). Force in A (-10, 10 + 2, 30), in the world (-12, -10, 30); arm
     * (0, 1, 0) */
    ask_forces(&def, part, 2);
    assert_wrench(part[1], 30, 0, 12 - 0.3 * 2, -12, -10, 30, 1e-14);
    assert_close(test_value(&def, part, 2, TEST_ENERGY), 0.5 * (10 + 5 + 30), 1e-13);
    assert_close(test_value(&def, part, 2, TEST_DISSIPATION), 0.3 * 4 + 2, 1e-13);
    /* body turned by 0.3 about its x axis, which is the world's x and A's -y: moment 3 * 0.3 */
    body_and_ground(part);
    turn(part, 1, 0, 0, 0.3);
    const mbsr_force_def centred = mbsr_force_bushing(MBSR_GROUND, &A, 0, NULL, stiffness, damping);
    const mbsr_frame at = mbsr_frame_rotated(NULL, z, pi / 2.0);
    test_part two[2] = {part[1], part[0]};
    mbsr_frame body = mbsr_frame_identity();
    memcpy(body.R, part->p, sizeof body.R);
    body = mbsr_frame_product(&body, &at);
    memcpy(two[1].p, body.R, sizeof body.R);
    two[1].p[11] = 1.0;
    ask_forces(&centred, two, 2);
    assert_wrench(two[1], -3 * 0.3, 0, 0, 0, 0, 0, 1e-14);
}

/* Equal angular stiffnesses: the moment is -c theta for any rotation up to pi. */
static void a_bushing_of_equal_stiffnesses_turns_back_along_its_rotation_vector(void **state)
{
    (void)state;
    static const double angles[] = {0.0, 1e-200, 1e-9, 0.01, 0.0999, 0.1001, 1.0, 3.0, 3.1415926};
    const double stiffness[6] = {2, 2, 2, 0, 0, 0}, none[6] = {0};
    const mbsr_force_def def = mbsr_force_bushing(MBSR_GROUND, NULL, 0, NULL, stiffness, none);
    for (size_t k = 0; k < sizeof angles / sizeof angles[0]; ++k) {
        const double m = 2.0 * angles[k];
        test_part part[2];
        body_and_ground(part);
        turn(part, 0.6, 0, -0.8, angles[k]);
        test_part two[2] = {part[1], part[0]};
        ask_forces(&def, two, 2);
        assert_wrench(two[1], -0.6 * m, 0, 0.8 * m, 0, 0, 0, 1e-14);
        assert_close(test_value(&def, two, 2, TEST_ENERGY), 0.5 * m * angles[k], 1e-14);
    }
}

/* Unequal ones, at all sizes of rotation, and across the switch from series to closed form. */
static void a_bushing_of_unequal_stiffnesses_keeps_the_balance_of_power(void **state)
{
    (void)state;
    const double stiffness[6] = {20, 3, 0, 0, 0, 0}, none[6] = {0};
    const mbsr_force_def def = mbsr_force_bushing(MBSR_GROUND, NULL, 0, NULL, stiffness, none);
    test_rng rng = test_seed(3);
    for (int round = 0; round < 60; ++round) {
        const double angle = round < 30 ? pow(10.0, -0.1 * round) : 0.1 + 0.1 * (round - 30);
        double axis[3], moment[2][3];
        test_part two[2] = {test_part_make(MBSR_SPACE_FIXED),
                            test_part_random(MBSR_SPACE_SPATIAL, &rng)};
        test_fill(&rng, 3, axis);
        turn(two + 1, axis[0], axis[1], axis[2], angle);
        assert_close(test_balance(&def, two, 2), 0.0, 0.0);
        for (int side = 0; side < 2; ++side) {
            turn(two + 1, axis[0], axis[1], axis[2], 0.1 * (1.0 + (side ? 1e-9 : -1e-9)));
            ask_forces(&def, two, 2);
            memcpy(moment[side], two[1].f, sizeof moment[side]);
        }
        for (int k = 0; k < 3; ++k) assert_close(moment[0][k], moment[1][k], 1e-8);
    }
}

/* Axes that are accepted with an error of 1e-7 do not turn into forces with one. */
static void frames_that_are_slightly_off_are_set_right(void **state)
{
    (void)state;
    const double stiffness[6] = {1, 1, 1, 10, 10, 10}, none[6] = {0};
    mbsr_frame frame = mbsr_frame_rotated(NULL, (const double[3]){1, 2, 3}, 0.7);
    for (int k = 0; k < 9; ++k) frame.R[k] *= 1.0 + 2e-7;
    const mbsr_force_def def = mbsr_force_bushing(MBSR_GROUND, &frame, 0, &frame, stiffness, none);
    test_part part[2];
    body_and_ground(part);
    set(part->p + 9, 1, 2, 3);
    test_part two[2] = {part[1], part[0]};
    ask_forces(&def, two, 2);
    assert_wrench(two[1], 0, 0, 0, -10, -20, -30, 1e-13);
}

/* ---- contact --------------------------------------------------------------------------------- */

/* A ball of radius 0.5 on the plane z = 2 of the ground. */
static mbsr_force_def ball(double exponent, double damping, double friction, double normal)
{
    const mbsr_contact c = {.radius = 0.5,
                            .normal = {0, 0, normal},
                            .point = {7, -3, 2},
                            .stiffness = 1000.0,
                            .exponent = exponent,
                            .damping = damping,
                            .friction = friction,
                            .slip = 0.01};
    return mbsr_force_contact(0, MBSR_GROUND, &c);
}

/* The ball at height z above the plane. */
static void ball_at(test_part part[2], double z, double vx, double vz, double spin)
{
    body_and_ground(part);
    set(part->p + 9, 1, 2, 2.0 + z);
    set(part->V + 3, vx, 0, vz);
    part->V[1] = spin;
}

static void a_pressed_ball_is_pushed_as_calculated_by_hand(void **state)
{
    (void)state;
    static const double lengths[] = {1.0, 3.0, 1e-200, 1e200};
    test_part part[2];
    const double elastic = 1000.0 * pow(0.2, 1.5), N = elastic * 1.2, drag = 0.3 * N / sqrt(1.0001);
    for (int k = 0; k < 4; ++k) {
        const mbsr_force_def def = ball(1.5, 0.5, 0.3, lengths[k]);
        ball_at(part, 0.3, 1.0, -0.4, 0.0);
        ask_forces(&def, part, 2);
        assert_wrench(part[0], 0, 0.5 * drag, 0, -drag, 0, N, 1e-13);
        assert_close(test_value(&def, part, 2, TEST_ENERGY), elastic * 0.2 / 2.5, 1e-12);
        assert_close(test_value(&def, part, 2, TEST_DISSIPATION), 0.2 * elastic * 0.4 + drag,
                     1e-11);
    }
    mbsr_force_def def = ball(1.5, 0.5, 0.3, 1.0);
    /* rolling, no friction; 0.5 * 2 = 1 */
    ball_at(part, 0.3, 1.0, 0.0, 2.0);
    ask_forces(&def, part, 2);
    assert_wrench(part[0], 0, 0, 0, 0, 0, elastic, 1e-13);
    /* spinning on the spot is braked, and so pushed forward */
    ball_at(part, 0.3, 0.0, 0.0, 2.0);
    ask_forces(&def, part, 2);
    const double forward = 0.3 * elastic / sqrt(1.0001);
    assert_wrench(part[0], 0, -0.5 * forward, 0, forward, 0, elastic, 1e-13);
    /* leaving fast: neither pull nor friction, and what was stored is lost */
    ball_at(part, 0.3, 1.0, 5.0, 0.0);
    ask_forces(&def, part, 2);
    assert_wrench(part[0], 0, 0, 0, 0, 0, 0, 0.0);
    assert_close(test_value(&def, part, 2, TEST_DISSIPATION), 5.0 * elastic, 1e-10);
    /* no friction, and no slip velocity, which it would need */
    def = mbsr_force_contact(0, MBSR_GROUND,
                             &(mbsr_contact){.radius = 0.5,
                                             .normal = {0, 0, 1},
                                             .point = {7, -3, 2},
                                             .stiffness = 1000.0,
                                             .exponent = 1.5});
    ball_at(part, 0.3, 0.0, 0.0, 0.0);
    ask_forces(&def, part, 2);
    assert_wrench(part[0], 0, 0, 0, 0, 0, elastic, 1e-13);
}

static void a_ball_above_the_plane_feels_nothing(void **state)
{
    (void)state;
    static const double heights[] = {0.5, 0.5000001, 1.0, 100.0};
    for (int k = 0; k < 4; ++k) {
        const mbsr_force_def def = ball(1.5, 0.5, 0.3, 1.0);
        test_part part[2];
        ball_at(part, heights[k], 1.0, -3.0, 1.0);
        ask_forces(&def, part, 2);
        assert_wrench(part[0], 0, 0, 0, 0, 0, 0, 0.0);
        assert_close(test_value(&def, part, 2, TEST_ENERGY), 0.0, 0.0);
        assert_close(test_value(&def, part, 2, TEST_DISSIPATION), 0.0, 0.0);
    }
}

/* ---- elements on joints ---------------------------------------------------------------------- */

/* tau of an element on coordinate 1 of a joint at q, u. */
static double on_joint(const mbsr_force_def *def, double q, double u, double *energy, double *heat)
{
    test_part part = test_part_make(MBSR_SPACE_PLANAR);
    part.q[1] = q;
    part.u[1] = u;
    ask_forces(def, &part, 1);
    assert_close(part.tau[0], 0.0, 0.0);
    assert_close(part.tau[2], 0.0, 0.0);
    if (energy) *energy = test_value(def, &part, 1, TEST_ENERGY);
    if (heat) *heat = test_value(def, &part, 1, TEST_DISSIPATION);
    return part.tau[1];
}

static void stops_push_back_and_let_go(void **state)
{
    (void)state;
    double E, P;
    const mbsr_force_def stop = mbsr_force_joint_stop(0, 1, -1.0, 2.0, 50.0, 4.0);
    static const double inside[] = {-1.0, -0.5, 0.0, 1.9, 2.0};
    for (int k = 0; k < 5; ++k) {
        assert_close(on_joint(&stop, inside[k], 3.0, &E, &P), 0.0, 0.0);
        assert_close(E + P, 0.0, 0.0);
    }
    /* beyond the upper stop by 0.1, elastic force 5 */
    assert_close(on_joint(&stop, 2.1, 0.5, &E, &P), -7.0, 1e-12);
    assert_close(E, 0.25, 1e-12);
    assert_close(P, 1.0, 1e-12);
    assert_close(on_joint(&stop, 2.1, -0.5, NULL, NULL), -3.0, 1e-12);
    assert_close(on_joint(&stop, 2.1, 9.0, NULL, &P), -10.0, 1e-12);
    assert_close(P, 45.0, 1e-11);
    assert_close(on_joint(&stop, 2.1, -9.0, NULL, &P), 0.0, 1e-12);
    assert_close(P, 45.0, 1e-11);
    /* beyond the lower one */
    assert_close(on_joint(&stop, -1.1, -0.5, &E, &P), 7.0, 1e-12);
    assert_close(E, 0.25, 1e-12);
    assert_close(P, 1.0, 1e-12);
    assert_close(on_joint(&stop, -1.1, 9.0, NULL, NULL), 0.0, 1e-12);
    /* only one of them */
    const mbsr_force_def upper = mbsr_force_joint_stop(0, 1, -INFINITY, 2.0, 50.0, 4.0),
                         lower = mbsr_force_joint_stop(0, 1, -1.0, INFINITY, 50.0, 4.0),
                         none = mbsr_force_joint_stop(0, 1, -INFINITY, INFINITY, 50.0, 4.0);
    assert_close(on_joint(&upper, -1e9, 0.0, NULL, NULL), 0.0, 0.0);
    assert_close(on_joint(&upper, 2.1, 0.0, NULL, NULL), -5.0, 1e-12);
    assert_close(on_joint(&lower, 1e9, 0.0, NULL, NULL), 0.0, 0.0);
    assert_close(on_joint(&lower, -1.1, 0.0, NULL, NULL), 5.0, 1e-12);
    assert_close(on_joint(&none, 1e9, 1e9, NULL, NULL), 0.0, 0.0);
    assert_close(on_joint(&none, -1e9, -1e9, NULL, NULL), 0.0, 0.0);
}

static void friction_opposes_the_motion(void **state)
{
    (void)state;
    double P;
    const mbsr_force_def def = mbsr_force_joint_friction(0, 1, 6.0, 0.04);
    assert_close(on_joint(&def, 0.3, 0.03, NULL, &P), -6.0 * 0.6, 1e-14);
    assert_close(P, 6.0 * 0.6 * 0.03, 1e-15);
    assert_close(on_joint(&def, 0.3, -0.03, NULL, &P), 6.0 * 0.6, 1e-14);
    assert_close(P, 6.0 * 0.6 * 0.03, 1e-15);
    assert_close(on_joint(&def, 0.3, 0.0, NULL, NULL), 0.0, 0.0);
    assert_close(on_joint(&def, 0.3, 1e-9, NULL, NULL), -6.0 / 0.04 * 1e-9, 1e-18);
    assert_close(on_joint(&def, 0.3, 1e3, NULL, NULL), -6.0, 1e-8);
    assert_close(on_joint(&def, 0.3, -1e200, NULL, NULL), 6.0, 0.0);
}

static void elements_on_joints_keep_the_balance_of_power(void **state)
{
    (void)state;
    const mbsr_force_def list[] = {mbsr_force_joint_spring(0, 1, 30.0, 2.0, 0.4),
                                   mbsr_force_joint_friction(0, 1, 6.0, 0.2),
                                   mbsr_force_joint_stop(0, 1, -0.1, 0.1, 30.0, 2.0),
                                   mbsr_force_joint_stop(0, 1, -0.1, 0.1, 30.0, 200.0)};
    test_rng rng = test_seed(8);
    for (int k = 0; k < 4; ++k) {
        double heat = 0.0;
        for (int round = 0; round < 50; ++round) {
            test_part part = test_part_random(MBSR_SPACE_PLANAR, &rng);
            heat = fmax(heat, test_balance(list + k, &part, 1));
        }
        assert_less(0.5, heat);
    }
}

/* ---- where one-sided elements switch --------------------------------------------------------- */

static double stop_force(double x, double v)
{
    const mbsr_force_def stop = mbsr_force_joint_stop(0, 1, -1.0, 2.0, 100.0, 7.0);
    return -on_joint(&stop, 2.0 + x, v, NULL, NULL);
}

static double lower_stop_force(double x, double v)
{
    const mbsr_force_def stop = mbsr_force_joint_stop(0, 1, -1.0, 2.0, 100.0, 7.0);
    return on_joint(&stop, -1.0 - x, -v, NULL, NULL);
}

static double cable_force(double x, double v)
{
    return cable(1.0 + x, v, NULL, NULL);
}

static double contact_force(double x, double v)
{
    const mbsr_force_def def = ball(1.0, 0.3, 0.0, 1.0);
    test_part part[2];
    ball_at(part, 0.5 - x, 0.0, -v, 0.0);
    ask_forces(&def, part, 2);
    return part->f[5];
}

/* None before contact, none that pulls the wrong way, and in steps of x and of v no more change
 * than a bound on the slopes allows. */
static void one_sided_forces_do_not_jump(void **state)
{
    (void)state;
    double (*const laws[])(double, double) = {stop_force, lower_stop_force, cable_force,
                                              contact_force};
    static const double slope[] = {200.0, 200.0, 210.0, 1000.0 * (1.0 + 0.3 * 20.0)};
    const double step = 1e-4;
    for (int law = 0; law < 4; ++law) {
        double most = 0.0;
        for (int i = -20; i <= 20; ++i) {
            for (int j = -20; j <= 20; ++j) {
                const double x = i * step, v = j * 1.0, F = laws[law](x, v);
                if (i < 0) assert_close(F, 0.0, 0.0);
                assert_less(-1e-300, F);
                assert_less(fabs(laws[law](x + step, v) - F), slope[law] * step * (1.0 + 1e-6));
                assert_less(fabs(laws[law](x, v + 1e-4) - F), 7.1 * 1e-4);
                most = fmax(most, F);
            }
        }
        assert_less(0.1, most);
    }
}

/* Power balance where the laws are cut off, far inside contact. */
static void one_sided_elements_keep_the_balance_of_power_at_any_velocity(void **state)
{
    (void)state;
    const mbsr_spring cable_of = {
        .stiffness = 10.0, .cubic = 4.0, .damping = 30.0, .free_length = 0.1, .one_sided = 1};
    const mbsr_force_def list[] = {
        mbsr_force_spring(0, (const double[3]){0.3, 0.2, 0.1}, MBSR_GROUND, NULL, &cable_of),
        ball(1.5, 8.0, 0.4, 1.0)};
    test_rng rng = test_seed(9);
    for (int k = 0; k < 2; ++k) {
        int cut = 0;
        for (int round = 0; round < 100; ++round) {
            test_part part[2] = {test_part_random(MBSR_SPACE_SPATIAL, &rng),
                                 test_part_make(MBSR_SPACE_FIXED)};
            part->p[11] += 1.0; /* in the ground */
            assert_less(-1e-300, test_balance(list + k, part, 2));
            cut += test_largest(6, part->f) == 0.0;
        }
        assert_in_range(cut, 10, 90);
    }
}

/* ---- gravity and applied forces -------------------------------------------------------------- */

/* M = diag(R, R) A diag(R, R)^T */
static void turned_mass(const double *A, const double *R, double *M)
{
    double T[36];
    for (int pass = 0; pass < 2; ++pass) {
        const double *from = pass ? T : A;
        double *to = pass ? M : T;
        for (int i = 0; i < 6; ++i) { /* to = (diag(R, R) from)^T */
            for (int j = 0; j < 6; ++j) {
                double sum = 0.0;
                for (int k = 0; k < 3; ++k) sum += R[3 * k + i % 3] * from[6 * j + i / 3 * 3 + k];
                to[6 * i + j] = sum;
            }
        }
    }
}

static void gravity_in_space_acts_at_the_centre_of_mass(void **state)
{
    (void)state;
    const double m = 3.0, c[3] = {0.2, -0.5, 0.7}, g[3] = {1.0, -2.0, -9.0};
    const mbsr_force_def def = mbsr_force_gravity(g[0], g[1], g[2]);
    test_part part = test_part_make(MBSR_SPACE_SPATIAL);
    set(part.p + 9, 1, 2, 3);
    /* what (omega, v) gives the momentum m (v + omega x c): column by column */
    for (int k = 0; k < 3; ++k) {
        double e[3] = {0, 0, 0};
        e[k] = m;
        part.M[6 * (3 + k) + 3 + k] = m;
        const double p[3] = {e[1] * c[2] - e[2] * c[1], e[2] * c[0] - e[0] * c[2],
                             e[0] * c[1] - e[1] * c[0]};
        for (int l = 0; l < 3; ++l) part.M[6 * k + 3 + l] = part.M[6 * (3 + l) + k] = p[l];
    }
    ask_forces(&def, &part, 1);
    assert_wrench(part, m * (c[1] * g[2] - c[2] * g[1]), m * (c[2] * g[0] - c[0] * g[2]),
                  m * (c[0] * g[1] - c[1] * g[0]), m * g[0], m * g[1], m * g[2], 1e-14);
    const double height = g[0] * (1 + c[0]) + g[1] * (2 + c[1]) + g[2] * (3 + c[2]);
    assert_close(test_value(&def, &part, 1, TEST_ENERGY), -m * height, 1e-13);
    assert_close(test_value(&def, &part, 1, TEST_DISSIPATION), 0.0, 0.0);
}

/* Any symmetric matrix that turns with the body, such as one with added masses. */
static void gravity_has_an_energy_whatever_the_matrix(void **state)
{
    (void)state;
    const mbsr_force_def def = mbsr_force_gravity(1.0, -2.0, -9.0);
    test_rng rng = test_seed(31);
    for (int round = 0; round < 20; ++round) {
        const double h = 1e-5;
        double A[36], E[2];
        test_fill(&rng, 36, A);
        for (int i = 0; i < 6; ++i) {
            for (int j = 0; j < i; ++j) A[6 * i + j] = A[6 * j + i];
        }
        test_part part = test_part_random(MBSR_SPACE_SPATIAL, &rng);
        for (int side = 0; side < 2; ++side) {
            test_part moved = test_part_moved(&part, side ? h : -h);
            turned_mass(A, moved.p, moved.M);
            E[side] = test_value(&def, &moved, 1, TEST_ENERGY);
        }
        turned_mass(A, part.p, part.M);
        ask_forces(&def, &part, 1);
        assert_close(test_power(&part, 1), -(E[1] - E[0]) / (2.0 * h), 1e-8);
        assert_less(0.01, test_largest(3, part.f));
    }
}

/* A planar body as a body in space: the same forces and energy. */
static void gravity_in_the_plane_is_gravity_in_space(void **state)
{
    (void)state;
    const mbsr_force_def def = mbsr_force_gravity(1.0, -9.0, 0.0);
    test_part flat = test_part_make(MBSR_SPACE_PLANAR), part = test_part_make(MBSR_SPACE_SPATIAL);
    const double m = 2.0, hx = 0.3, hy = -0.4, position[3] = {1.5, -0.5, 0.0};
    memcpy(flat.p, position, sizeof position);
    memcpy(part.p + 9, position, sizeof position);
    flat.M[0] = flat.M[4] = part.M[21] = part.M[28] = part.M[35] = m;
    flat.M[2] = flat.M[6] = part.M[6 * 2 + 3] = part.M[6 * 3 + 2] = -hy;
    flat.M[5] = flat.M[7] = part.M[6 * 2 + 4] = part.M[6 * 4 + 2] = hx;
    part.M[6 * 0 + 5] = part.M[6 * 5 + 0] = hy;
    part.M[6 * 1 + 5] = part.M[6 * 5 + 1] = -hx;
    ask_forces(&def, &flat, 1);
    ask_forces(&def, &part, 1);
    assert_wrench(part, 0, 0, flat.f[2], flat.f[0], flat.f[1], 0, 1e-14);
    assert_close(flat.f[2], hx * -9.0 - hy * 1.0, 1e-14);
    assert_close(test_value(&def, &flat, 1, TEST_ENERGY), test_value(&def, &part, 1, TEST_ENERGY),
                 1e-14);
}

/* 1 .. n, times t = 0.5 */
static int count_up(void *user, double t, int n, double *value)
{
    for (int k = 0; k < n; ++k) {
        assert_close(value[k], 0.0, 0.0);
        value[k] = (k + 1) * t;
    }
    return user ? *(const int *)user : 0;
}

static void wrenches_act_at_their_point_along_their_axes(void **state)
{
    (void)state;
    int code = -7;
    const double point[3] = {0, 0, 2};
    test_part part = test_part_make(MBSR_SPACE_SPATIAL);
    set(part.p + 9, 5, 6, 7);
    turn(&part, 1, 0, 0, pi / 2.0); /* x -> x, y -> z, z -> -y; arm (0, -2, 0) */
    const mbsr_force_def world = mbsr_force_wrench(0, point, 0, count_up, NULL),
                         body = mbsr_force_wrench(0, point, 1, count_up, NULL),
                         origin = mbsr_force_wrench(0, NULL, 0, count_up, NULL),
                         moody = mbsr_force_wrench(0, NULL, 0, count_up, &code);
    /* moment (0.5, 1, 1.5), force (2, 2.5, 3); arm x force = (-6, 0, 4) */
    ask_forces(&world, &part, 1);
    assert_wrench(part, 0.5 - 6.0, 1.0, 1.5 + 4.0, 2.0, 2.5, 3.0, 1e-14);
    /* in the world: moment (0.5, -1.5, 1), force (2, -3, 2.5); arm x force = (-5, 0, 4) */
    ask_forces(&body, &part, 1);
    assert_wrench(part, 0.5 - 5.0, -1.5, 1.0 + 4.0, 2.0, -3.0, 2.5, 1e-14);
    ask_forces(&origin, &part, 1);
    assert_wrench(part, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 1e-14);
    assert_int_equal(test_ask(&moody, &part, 1, TEST_FORCES, NULL), -7);
    assert_wrench(part, 0, 0, 0, 0, 0, 0, 0.0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_spring_in_space_pulls_as_calculated_by_hand),
        cmocka_unit_test(a_spring_without_free_length_pulls_along_its_ends),
        cmocka_unit_test(a_cable_pulls_and_never_pushes),
        cmocka_unit_test(springs_without_length_need_no_direction_or_say_so),
        cmocka_unit_test(a_free_length_needs_a_direction_that_is_not_rounding),
        cmocka_unit_test(a_bushing_at_half_a_turn_has_no_direction_where_it_is_stiff),
        cmocka_unit_test(what_a_law_returns_is_passed_on),
        cmocka_unit_test(a_bushing_holds_as_calculated_by_hand),
        cmocka_unit_test(a_bushing_of_equal_stiffnesses_turns_back_along_its_rotation_vector),
        cmocka_unit_test(a_bushing_of_unequal_stiffnesses_keeps_the_balance_of_power),
        cmocka_unit_test(frames_that_are_slightly_off_are_set_right),
        cmocka_unit_test(a_pressed_ball_is_pushed_as_calculated_by_hand),
        cmocka_unit_test(a_ball_above_the_plane_feels_nothing),
        cmocka_unit_test(stops_push_back_and_let_go),
        cmocka_unit_test(friction_opposes_the_motion),
        cmocka_unit_test(elements_on_joints_keep_the_balance_of_power),
        cmocka_unit_test(one_sided_forces_do_not_jump),
        cmocka_unit_test(one_sided_elements_keep_the_balance_of_power_at_any_velocity),
        cmocka_unit_test(gravity_in_space_acts_at_the_centre_of_mass),
        cmocka_unit_test(gravity_has_an_energy_whatever_the_matrix),
        cmocka_unit_test(gravity_in_the_plane_is_gravity_in_space),
        cmocka_unit_test(wrenches_act_at_their_point_along_their_axes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
