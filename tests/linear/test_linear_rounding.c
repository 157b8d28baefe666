/* Rests and responses where masses, stiffnesses and forces of rows are small beside others, are
 * rounding, or follow from others alone.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "build.h"
#include "units.h"

#include <mbsrank/driver.h>
#include <mbsrank/flex.h>
#include <mbsrank/linear.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double two_pi = 6.283185307179586, tilted[3] = {0.36, 0.48, 0.8};

/* Response of signal `output` to the force along rate `input`, at a rest q. */
static void respond(const mbsr_model *m, mbsr_data *d, const double *q, int input,
                    mbsr_signal output, double frequency, double *re, double *im, int *states)
{
    const mbsr_signal force = {.kind = MBSR_SIGNAL_JOINT, .id = input};
    mbsr_linear_opt opt = mbsr_default_linear_opt();
    mbsr_linear *l;
    mbsr_linear_info info;
    mbsr_error error;
    opt.inputs = opt.outputs = 1, opt.input = &force, opt.output = &output;
    assert_ok(mbsr_linear_create(m, d, 0.0, q, NULL, &opt, &l, &error), &error);
    assert_ok(mbsr_linear_get_info(l, &info), NULL);
    assert_ok(mbsr_linear_response(l, frequency, re, im), NULL);
    *states = info.states;
    mbsr_linear_destroy(l);
}

/* A frame in which numbers that would vanish are rounding. */
static mbsr_frame turned(double x, double y, double z)
{
    const double right = 1.5707963267948966;
    mbsr_frame f = mbsr_frame_rotated(NULL, (const double[3]){1, 0, 0}, right);
    const mbsr_frame g = mbsr_frame_rotated(NULL, (const double[3]){0, 0, 1}, right);
    f = mbsr_frame_product(&f, &g);
    f.x[0] = x, f.x[1] = y, f.x[2] = z;
    return f;
}

/* A mass on two slides without mass of their own, almost in line, with a damper on the second: what
 * both move together, and against each other by less than a thousandth of that.
 *
 *   m s^2 (x + c y) = f,     m (1 - c^2) s^2 y + d s y = -c f */
static void check_slides(double slope, double damping)
{
    const double c = cos(slope), sine = sin(slope), mass = 2.0, q[2] = {0.0}, frequency = 0.1,
                 omega = two_pi * frequency;
    double re, im;
    int states;
    mbsr_model *m = empty();
    add_body(m, MBSR_GROUND, "first", mbsr_joint_prismatic(NULL, NULL, (const double[3]){1, 0, 0}),
             mbsr_inertia_zero());
    add_body(m, 0, "second", mbsr_joint_prismatic(NULL, NULL, (const double[3]){c, sine, 0}),
             mbsr_inertia_particle(mass));
    add_force(m, mbsr_force_joint_spring(1, 0, 0.0, damping, 0.0));
    mbsr_data *d = finish(m);
    respond(m, d, q, 0, (mbsr_signal){.kind = MBSR_SIGNAL_JOINT, .id = 1}, frequency, &re, &im,
            &states);
    const double inertia = -mass * sine * sine * omega * omega, loss = damping * omega,
                 square = inertia * inertia + loss * loss;
    assert_int_equal(states, 4);
    assert_close(re * loss, -c * inertia * loss / square, 1e-8);
    assert_close(im * loss, c * loss * loss / square, 1e-8);
    free_both(m, d);
}

static void slides_almost_in_line(void **state)
{
    (void)state;
    check_slides(7e-4, 3e-3);
    check_slides(1e-4, 3.0);
}

/* A rod on its own axis, on which gravity acts: its stiffness is rounding, 1 / (J s^2) is not. */
static void a_body_balanced_on_its_hinge(void **state)
{
    const mbsr_frame at = turned(-0.5, 0.5, -1.0);
    const double frequency = 4.3, omega = two_pi * frequency, q = -0.7853981633974483;
    double re, im;
    int states;
    (void)state;
    mbsr_model *m = empty();
    add_body(
        m, MBSR_GROUND, "wheel", mbsr_joint_revolute(&at, NULL, (const double[3]){1, 0, 0}),
        mbsr_inertia_rigid(1.0, (const double[3]){0.5, 0, 0}, (const double[6]){0.3, 0.3, 0.2}));
    add_force(m, mbsr_force_gravity(4.7088, 3.5316, -7.848));
    mbsr_data *d = finish(m);
    respond(m, d, &q, 0, (mbsr_signal){.kind = MBSR_SIGNAL_JOINT}, frequency, &re, &im, &states);
    assert_int_equal(states, 2);
    assert_close(re * 0.3 * omega * omega, -1.0, 1e-8);
    assert_close(im * 0.3 * omega * omega, 0.0, 1e-8);
    free_both(m, d);
}

/* A rod that slides in a plane and turns about itself, which moves no mass but for rounding: a
 * damper holds it. The rest is a mass on a spring along one edge. */
static void a_rod_along_its_axis(void **state)
{
    (void)state;
    for (int k = 0; k < 4; ++k) {
        const units *s = systems + k;
        const double force = s->mass * s->length / (s->time * s->time);
        const mbsr_frame at = turned(0.5 * s->length, 0.5 * s->length, 0.5 * s->length);
        const mbsr_axis axes[3] = {{MBSR_AXIS_TRANSLATION, {1, 0, 0}, 0.0, 0},
                                   {MBSR_AXIS_TRANSLATION, {0, 1, 0}, 0.0, 0},
                                   {MBSR_AXIS_ROTATION, {0, 0, 1}, 0.0, 0}};
        const double end[3] = {0, 0, -0.5 * s->length}, q[3] = {-0.5 * s->length, 0.0, 0.3};
        mbsr_linear *l;
        mbsr_mode mode[6];
        mbsr_error error;
        int count;
        mbsr_model *m = empty();
        add_body(m, MBSR_GROUND, "rod", mbsr_joint_compound(&at, NULL, 3, axes, NULL, NULL),
                 mbsr_inertia_rod(0.5 * s->mass, NULL, end));
        add_force(m, mbsr_force_joint_spring(0, 1, 3.0 * force / s->length,
                                             force * s->time / s->length, 0.0));
        add_force(m, mbsr_force_joint_spring(0, 2, 0.0, 1.5 * force * s->length * s->time, 0.0));
        mbsr_data *d = finish(m);
        assert_ok(mbsr_linear_create(m, d, 0.0, q, NULL, NULL, &l, &error), &error);
        assert_ok(mbsr_linear_modes(l, mode, &count), NULL);
        assert_int_equal(count, 4);
        assert_close(mode[3].real * s->time, -1.0, 1e-9);
        assert_close(mode[3].imaginary * s->time, sqrt(5.0), 1e-9);
        for (int j = 0; j < 3; ++j)
            assert_close(hypot(mode[j].real, mode[j].imaginary) * s->time, 0.0, 1e-6);
        mbsr_linear_destroy(l);
        free_both(m, d);
    }
}

/* A mass on a slide that a loop holds at the place of its second spring, which is a closure: the
 * spring follows from where it stands, and adds no state. */
static void a_spring_that_a_loop_holds(void **state)
{
    const double q[2] = {0.0};
    const int body = 0, coordinate = 0;
    const double one = 1.0;
    double re, im;
    int states;
    (void)state;
    mbsr_model *m = empty();
    add_body(m, MBSR_GROUND, "held", mbsr_joint_prismatic(NULL, NULL, tilted),
             mbsr_inertia_particle(2.0));
    add_body(m, 0, "free", mbsr_joint_prismatic(NULL, NULL, tilted), mbsr_inertia_particle(2.0));
    add_force(m, mbsr_force_joint_spring(1, 0, 8.0, 1.0, 0.0));
    mbsr_force_def spring = mbsr_force_joint_spring(0, 0, 5.0, 0.5, 0.25);
    spring.as_closure = MBSR_SPRING_LOOSE;
    add_force(m, spring);
    const mbsr_closure_def hold = mbsr_closure_coupling(1, &body, &coordinate, &one, 0.0);
    assert_ok(mbsr_model_add_closure(m, &hold, NULL), mbsr_model_error(m));
    mbsr_data *d = finish(m);
    respond(m, d, q, 1, (mbsr_signal){.kind = MBSR_SIGNAL_JOINT, .id = 1}, 0.0, &re, &im, &states);
    assert_int_equal(states, 2);
    assert_close(re, 0.125, 1e-12);
    free_both(m, d);
}

/* A bar on a pin, by three coordinates and a loop, with springs at two of them that are closures
 * and depend on the loop's rows: it rests where
 *
 *   k (y - r) y' + c (a - s) = 0,     y = 1.25 - sin(a) / 2
 *
 * however far from where it begins. */
static void springs_that_depend_on_loops(void **state)
{
    (void)state;
    for (int k = 0; k < 4; ++k) {
        const units *s = systems + k;
        const double force = s->mass * s->length / (s->time * s->time), L = s->length;
        const mbsr_frame pin = mbsr_frame_at(1.0 * L, 1.25 * L, 0.0),
                         end = mbsr_frame_at(0.5 * L, 0.0, 0.0);
        const mbsr_joint hinge = mbsr_joint_revolute(&pin, NULL, (const double[3]){0, 0, 1});
        double start[4] = {0.5 * L, 1.25 * L, 0.0, 0.0}, q[4], lambda[8];
        mbsr_error error;
        int closure, cut;
        mbsr_model *m = empty();
        add_body(m, MBSR_GROUND, "bar", mbsr_joint_in_plane(NULL, NULL),
                 mbsr_inertia_point_mass(s->mass, (const double[3]){0.1 * L, 0, 0}));
        assert_ok(mbsr_model_add_loop_joint(m, "pin", MBSR_GROUND, &hinge, 0, &end, &closure, &cut),
                  mbsr_model_error(m));
        mbsr_force_def spring = mbsr_force_joint_spring(0, 1, 3.0 * force / L, 0.0, 0.9 * L);
        spring.as_closure = MBSR_SPRING_LOOSE;
        add_force(m, spring);
        spring = mbsr_force_joint_spring(0, 2, 0.5 * force * L, 0.0, 1.2);
        spring.as_closure = MBSR_SPRING_LOOSE;
        add_force(m, spring);
        mbsr_data *d = finish(m);
        assert_ok(mbsr_equilibrium(m, d, 0.0, start, NULL, q, lambda, NULL, &error), &error);
        const double a = q[2], y = q[1] / L;
        assert_close(y, 1.25 - 0.5 * sin(a), 1e-10);
        assert_close(-3.0 * (y - 0.9) * 0.5 * cos(a) + 0.5 * (a - 1.2), 0.0, 1e-9);
        assert_close(lambda[6] / force, -3.0 * (y - 0.9), 1e-9);
        assert_close(lambda[7] / (force * L), -0.5 * (a - 1.2), 1e-9);
        free_both(m, d);
    }
}

/* A cantilever of length 1, mass 1 and stiffness 1 with a particle at its end, b^4 = w^2:
 *
 *   1 + cos b cosh b + m b (cos b sinh b - sin b cosh b) = 0
 *
 * by five modes and two without mass of the end, of which one moves the particle. */
static double frequency_of_cantilever(double tip, double low, double high)
{
    for (int k = 0; k < 60; ++k) {
        const double b = 0.5 * (low + high),
                     x = 1.0 + cos(b) * cosh(b) + tip * b * (cos(b) * sinh(b) - sin(b) * cosh(b));
        if ((x > 0.0) == (low < 2.0))
            low = b;
        else
            high = b;
    }
    return low * low;
}

static void modes_without_mass_that_move_a_particle(void **state)
{
    (void)state;
    static const double tip = 1.5;
    for (int k = 0; k < 5; ++k) {
        const units slow = {"m, kg, ms / 4", 1.0, 1.0, 4000.0}, *s = k < 4 ? systems + k : &slow;
        const int end = 15;
        double q[8] = {0.0};
        mbsr_beam_def def = mbsr_default_beam_def();
        mbsr_flexible_def at = mbsr_default_flexible_def();
        mbsr_flex *flex;
        mbsr_linear *l;
        mbsr_linear_info info;
        mbsr_mode mode[12];
        mbsr_error error;
        int body, marker, count;
        def.length = s->length, def.density = s->mass / s->length;
        def.EI_y = s->mass * pow(s->length, 3.0) / (s->time * s->time);
        def.modes = 5, def.loaded = 1, def.node = &end;
        assert_ok(mbsr_flex_beam(&def, &flex, &error), &error);
        mbsr_model *m = empty();
        at.flex = flex, at.joint = mbsr_joint_weld(NULL, NULL);
        assert_ok(mbsr_model_add_flexible(m, &at, &body), mbsr_model_error(m));
        assert_ok(mbsr_model_add_marker(m, body, end, NULL, &marker), mbsr_model_error(m));
        add_body(m, marker, "particle", mbsr_joint_weld(NULL, NULL),
                 mbsr_inertia_particle(tip * s->mass));
        mbsr_data *d = finish(m);
        assert_ok(mbsr_linear_create(m, d, 0.0, q, NULL, NULL, &l, &error), &error);
        assert_ok(mbsr_linear_get_info(l, &info), NULL);
        assert_int_equal(info.states, 12);
        assert_ok(mbsr_linear_modes(l, mode, &count), NULL);
        assert_int_equal(count, 6);
        assert_close(mode[0].imaginary * s->time, frequency_of_cantilever(tip, 0.5, 2.0), 1e-6);
        assert_close(mode[1].imaginary * s->time, frequency_of_cantilever(tip, 3.0, 5.0), 1e-3);
        for (int j = 0; j < count; ++j) assert_close(mode[j].real / mode[j].imaginary, 0.0, 1e-9);
        mbsr_linear_destroy(l);
        free_both(m, d);
        mbsr_flex_destroy(flex);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_body_balanced_on_its_hinge),
                                       cmocka_unit_test(a_rod_along_its_axis),
                                       cmocka_unit_test(a_spring_that_a_loop_holds),
                                       cmocka_unit_test(modes_without_mass_that_move_a_particle),
                                       cmocka_unit_test(slides_almost_in_line),
                                       cmocka_unit_test(springs_that_depend_on_loops)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
