/* Equilibria: with an answer on paper, refused by name, and of random models in four systems of
 * units, whose modes are held against derivatives of forward dynamics.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "build.h"
#include "duration.h"
#include "units.h"

#include <mbsrank/driver.h>
#include <mbsrank/flex.h>
#include <mbsrank/linear.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST = 40 };

static const double x_axis[3] = {1, 0, 0}, y_axis[3] = {0, 1, 0}, z_axis[3] = {0, 0, 1};

/* From nearly upright to where gravity and the spring balance. */
static void a_pendulum_on_a_spring(void **state)
{
    (void)state;
    mbsr_model *m = empty();
    mbsr_equilibrium_info info;
    mbsr_error error;
    double q = 2.9;
    add_body(m, MBSR_GROUND, "bob", mbsr_joint_revolute(NULL, NULL, y_axis),
             mbsr_inertia_point_mass(2.0, (const double[3]){0, 0, -1}));
    add_force(m, mbsr_force_gravity(0, 0, -9.81));
    add_force(m, mbsr_force_joint_spring(0, 0, 3.0, 0.1, 0.4));
    mbsr_data *d = finish(m);
    assert_ok(mbsr_equilibrium(m, d, 0.0, &q, NULL, &q, NULL, &info, &error), &error);
    assert_close(3.0 * (q - 0.4) + 2.0 * 9.81 * sin(q), 0.0, 1e-13);
    assert_int_equal(info.worst, MBSR_NONE);
    /* once more, from there */
    const double found = q;
    assert_ok(mbsr_equilibrium(m, d, 0.0, &q, NULL, &q, NULL, &info, &error), &error);
    assert_close(q, found, 1e-14);
    assert_int_equal(info.iterations, 1);
    free_both(m, d);
}

/* Steps in which a box comes to rest on four springs; unit of length: 2^exponent. */
static int steps_of_a_box(int exponent, double q[7])
{
    const double L = ldexp(1.0, exponent), com[3] = {0.02 * L, 0.01 * L, 0.03 * L},
                 tensor[6] = {0.02 * L * L, 0.03 * L * L, 0.04 * L * L};
    const double start[7] = {0.8, 0.0, 0.6, 0.0, 0.1 * L, 0.2 * L, 0.5 * L};
    mbsr_model *m = empty();
    mbsr_equilibrium_info info;
    mbsr_error error;
    add_body(m, MBSR_GROUND, "box", mbsr_joint_free(NULL, NULL),
             mbsr_inertia_rigid(2.0, com, tensor));
    add_force(m, mbsr_force_gravity(0, 0, -9.81 * L));
    for (int k = 0; k < 4; ++k) {
        const double x = k % 2 ? 0.2 * L : -0.3 * L, y = k / 2 ? 0.25 * L : -0.2 * L,
                     corner[3] = {x, y, 0.0}, foot[3] = {1.5 * x, 2.0 * y, -0.4 * L};
        add_force(m, mbsr_force_point_spring(0, corner, MBSR_GROUND, foot, 400.0 + 50.0 * k, 1.0,
                                             0.5 * L));
    }
    mbsr_data *d = finish(m);
    assert_ok(mbsr_equilibrium(m, d, 0.0, start, NULL, q, NULL, &info, &error), &error);
    free_both(m, d);
    for (int k = 4; k < 7; ++k) q[k] /= L;
    return info.iterations;
}

/* Joint rates are other in number and kind than the quaternion's coordinates. */
static void a_box_comes_to_rest_alike_in_all_units(void **state)
{
    (void)state;
    double expected[7], q[7];
    const int steps = steps_of_a_box(0, expected);
    for (int exponent = -12; exponent <= 12; exponent += 6) {
        assert_int_equal(steps_of_a_box(exponent, q), steps);
        for (int k = 0; k < 7; ++k) assert_close(q[k], expected[k], 1e-13);
    }
}

/* A chain of twenty rods lets itself hang, from lying flat. */
static void a_chain(void **state)
{
    (void)state;
    enum { LINKS = 20 };
    mbsr_model *m = empty();
    mbsr_error error;
    double q[LINKS] = {-0.1};
    for (int k = 0; k < LINKS; ++k) {
        const mbsr_frame at = mbsr_frame_at(k > 0 ? 0.1 : 0.0, 0, 0);
        add_body(m, k > 0 ? k - 1 : MBSR_GROUND, NULL, mbsr_joint_revolute(&at, NULL, y_axis),
                 mbsr_inertia_rod(0.2, (const double[3]){0, 0, 0}, (const double[3]){0.1, 0, 0}));
    }
    add_force(m, mbsr_force_gravity(0, 0, -9.81));
    mbsr_data *d = finish(m);
    assert_ok(mbsr_equilibrium(m, d, 0.0, q, NULL, q, NULL, NULL, &error), &error);
    assert_close(q[0], 0.5 * 3.14159265358979323846, 1e-11);
    for (int k = 1; k < LINKS; ++k) assert_close(q[k], 0.0, 1e-11);
    free_both(m, d);
}

/* A point without mass on two springs, one of which a loop holds: a mass hangs on a rod and a
 * spring. The rod of length l from (0, 0), the spring of k and free length 0 from (a, 0): k and m g
 * determine the angle, lambda the force. */
static void a_rod_and_a_spring(void **state)
{
    (void)state;
    const double mass = 2.0, g = 9.81, length = 1.5, k = 12.0, a = 1.0;
    mbsr_model *m = empty();
    mbsr_error error;
    double q[2] = {1.4, -0.2}, lambda;
    const mbsr_closure_def rod = mbsr_closure_distance(0, NULL, MBSR_GROUND, NULL, length);
    add_body(m, MBSR_GROUND, "mass", mbsr_joint_point_free(), mbsr_inertia_particle(mass));
    add_force(m, mbsr_force_gravity(0, -g, 0));
    add_force(m, mbsr_force_axis_spring(0, MBSR_GROUND, 0, k, 0.0, a));
    add_force(m, mbsr_force_axis_spring(0, MBSR_GROUND, 1, k, 0.0, 0.0));
    assert_ok(mbsr_model_add_closure(m, &rod, NULL), mbsr_model_error(m));
    mbsr_data *d = finish(m);
    assert_ok(mbsr_equilibrium(m, d, 0.0, q, NULL, q, &lambda, NULL, &error), &error);
    assert_close(hypot(q[0], q[1]), length, 1e-13);
    /* along the circle: k a cos = m g sin, with the angle from below */
    const double angle = atan2(k * a, mass * g);
    assert_close(q[0], length * sin(angle), 1e-12);
    assert_close(q[1], -length * cos(angle), 1e-12);
    const double outward = k * a * sin(angle) + mass * g * cos(angle) - k * length;
    assert_close(lambda, -outward, 1e-11);
    free_both(m, d);
}

static void what_nothing_holds_is_named(void **state)
{
    (void)state;
    mbsr_model *m = empty();
    mbsr_error error;
    mbsr_equilibrium_info info;
    const double q[2] = {0.2, 0.0};
    double found[2] = {17.0, 17.0};
    add_body(m, MBSR_GROUND, "hangs", mbsr_joint_revolute(NULL, NULL, y_axis),
             mbsr_inertia_point_mass(2.0, (const double[3]){0, 0, -1}));
    add_body(m, MBSR_GROUND, "falls", mbsr_joint_prismatic(NULL, NULL, z_axis),
             mbsr_inertia_particle(1.0));
    add_force(m, mbsr_force_gravity(0, 0, -9.81));
    mbsr_data *d = finish(m);
    assert_refused(mbsr_equilibrium(m, d, 0.0, q, NULL, found, NULL, &info, &error), &error,
                   MBSR_NO_CONVERGENCE, 1, MBSR_NONE, "mbsr_equilibrium|u0 of body 1 'falls'");
    assert_int_equal(info.worst, 1);
    assert_true(found[0] == 17.0);
    free_both(m, d);

    m = empty();
    add_body(m, MBSR_GROUND, "loose", mbsr_joint_revolute(NULL, NULL, y_axis), mbsr_inertia_zero());
    d = finish(m);
    assert_int_equal(mbsr_equilibrium(m, d, 0.0, q, NULL, found, NULL, &info, &error),
                     MBSR_UNDETERMINED);
    assert_contains(error.text, "mbsr_equilibrium|loose");
    mbsr_equilibrium_opt opt = mbsr_default_equilibrium_opt();
    opt.tolerance = 0.0;
    assert_refused(mbsr_equilibrium(m, d, 0.0, q, &opt, found, NULL, NULL, &error), &error,
                   MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE, "tolerance");
    opt.cookie = 0;
    assert_refused(mbsr_equilibrium(m, d, 0.0, q, &opt, found, NULL, NULL, &error), &error,
                   MBSR_ERR_NO_DEFAULT, MBSR_NONE, MBSR_NONE, "opt");
    assert_refused(mbsr_equilibrium(m, d, 0.0, NULL, NULL, found, NULL, NULL, &error), &error,
                   MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "q is NULL");
    free_both(m, d);
}

/* ---- random models ---- */

typedef struct random_model {
    mbsr_model *m;
    mbsr_data *d;
    int nu;
    double q[MOST];
    bool turns[MOST]; /* of the coordinates */
} random_model;

static double positive(test_rng *rng)
{
    return exp(test_uniform(rng));
}

/* Trees of hinges, sliders and universal joints with a spring and a damper at each coordinate, some
 * bodies without mass; every third has a rod from its last body to the ground. */
static void make(random_model *r, int seed, const units *s)
{
    test_rng rng = test_seed((uint64_t)seed);
    const double L = s->length, force = s->mass * s->length / (s->time * s->time);
    const int bodies = test_integer(&rng, 1, 9);
    *r = (random_model){.m = empty()};
    for (int k = 0; k < bodies; ++k) {
        const mbsr_frame at =
            mbsr_frame_at(L * test_uniform(&rng), L * test_uniform(&rng), L * test_uniform(&rng));
        double axis[3], other[3], centre[3];
        test_fill(&rng, 3, axis);
        test_fill(&rng, 3, other);
        test_fill(&rng, 3, centre);
        for (int l = 0; l < 3; ++l) centre[l] *= 0.5 * L;
        const int parent = k == 0 ? MBSR_GROUND : test_integer(&rng, -1, k - 1),
                  kind = test_integer(&rng, 0, 2);
        const double mass = s->mass * positive(&rng), of_size = 0.1 * mass * L * L;
        const bool massless = k + 1 < bodies && test_uniform(&rng) > 0.6;
        add_body(r->m, parent < 0 ? MBSR_GROUND : parent, NULL,
                 kind == 0   ? mbsr_joint_revolute(&at, NULL, axis)
                 : kind == 1 ? mbsr_joint_prismatic(&at, NULL, axis)
                             : mbsr_joint_universal(&at, NULL, axis, other),
                 massless ? mbsr_inertia_zero()
                          : mbsr_inertia_rigid(mass, centre,
                                               (const double[6]){of_size, of_size, of_size}));
        for (int l = 0; l < (kind == 2 ? 2 : 1); ++l) {
            const bool turns = kind != 1;
            const double k_of = 30.0 * positive(&rng) * force * (turns ? L : 1.0 / L),
                         rest = 0.5 * test_uniform(&rng) * (turns ? 1.0 : L);
            add_force(r->m, mbsr_force_joint_spring(k, l, k_of, 0.05 * k_of * s->time, rest));
            r->turns[r->nu] = turns;
            r->q[r->nu++] = test_uniform(&rng) * (turns ? 1.0 : L);
        }
    }
    add_force(r->m, mbsr_force_gravity(0, 0, -9.81 * s->length / (s->time * s->time)));
    if (seed % 3 == 0 && r->nu > 2) {
        const mbsr_closure_def rod = mbsr_closure_distance(
            bodies - 1, NULL, MBSR_GROUND, (const double[3]){0, 0, 9.0 * L}, 9.0 * L);
        assert_ok(mbsr_model_add_closure(r->m, &rod, NULL), mbsr_model_error(r->m));
    }
    r->d = finish(r->m);
}

/* Nothing is missing but loop forces. */
static void expect_balance(const random_model *r, const double *q, const double *lambda,
                           double force, double length)
{
    double bias[MOST], u[MOST] = {0.0}, loop[MOST] = {0.0};
    assert_ok(mbsr_bias_forces(r->m, r->d, 0.0, q, u, bias), mbsr_data_error(r->d));
    if (mbsr_model_rows(r->m) > 0) {
        double gap;
        assert_ok(mbsr_stage_positions(r->m, r->d, 0.0, q), NULL);
        assert_ok(mbsr_closures_transpose(r->m, r->d, lambda, loop), mbsr_data_error(r->d));
        assert_ok(mbsr_stage_positions(r->m, r->d, 0.0, q), NULL);
        assert_ok(mbsr_closures_gap(r->m, r->d, &gap), NULL);
        assert_close(gap / length, 0.0, 1e-11);
    }
    for (int k = 0; k < r->nu; ++k)
        assert_close((bias[k] - loop[k]) / (force * (r->turns[k] ? length : 1.0)), 0.0, 1e-7);
}

/* Each mode solves the equations of motion: s^2 x = du'/dq x + s du'/du x. */
static void expect_modes(const random_model *r, const double *q, double rate)
{
    mbsr_derivatives *d;
    mbsr_linear *l;
    mbsr_error error;
    mbsr_mode mode[2 * MOST];
    int count;
    const double rest[MOST] = {0.0};
    assert_ok(mbsr_derivatives_create(r->m, &d, &error), &error);
    if (mbsr_derivatives_forward(d, 0.0, q, rest, NULL, NULL, NULL) == MBSR_OK) {
        assert_ok(mbsr_linear_create(r->m, r->d, 0.0, q, NULL, NULL, &l, &error), &error);
        assert_ok(mbsr_linear_modes(l, mode, &count), NULL);
        for (int k = 0; k < count; ++k) {
            double x[2][MOST], v[2][MOST], out[2][MOST];
            const double re = mode[k].real, im = mode[k].imaginary;
            assert_ok(mbsr_linear_shape(l, k, x[0], x[1]), NULL);
            for (int j = 0; j < r->nu; ++j) {
                v[0][j] = re * x[0][j] - im * x[1][j];
                v[1][j] = re * x[1][j] + im * x[0][j];
            }
            for (int part = 0; part < 2; ++part)
                assert_ok(mbsr_derivatives_tangent(d, x[part], v[part], NULL, out[part], NULL),
                          NULL);
            const double size =
                (re * re + im * im + rate * rate) * (1.0 + test_largest(r->nu, x[0]));
            for (int j = 0; j < r->nu; ++j) {
                assert_close((out[0][j] - (re * v[0][j] - im * v[1][j])) / size, 0.0, 1e-8);
                assert_close((out[1][j] - (re * v[1][j] + im * v[0][j])) / size, 0.0, 1e-8);
            }
        }
        mbsr_linear_destroy(l);
    }
    mbsr_derivatives_destroy(d);
}

/* The slowest modes by Krylov's way are those of the matrices. */
static void expect_slowest(const random_model *r, const double *q)
{
    mbsr_linear *l;
    mbsr_error error;
    mbsr_mode mode[2 * MOST], near[5];
    mbsr_near_opt opt = mbsr_default_near_opt();
    double re[5 * MOST], im[5 * MOST], x[MOST], y[MOST];
    int count, found;
    opt.count = 5;
    assert_ok(mbsr_linear_create(r->m, r->d, 0.0, q, NULL, NULL, &l, &error), &error);
    assert_ok(mbsr_linear_modes(l, mode, &count), NULL);
    assert_ok(mbsr_modes_near(r->m, r->d, 0.0, q, &opt, near, &found, re, im, &error), &error);
    assert_int_equal(found, count < opt.count ? count : opt.count);
    for (int k = 0; k < found; ++k) {
        const double size = hypot(mode[k].real, mode[k].imaginary);
        assert_close(near[k].real / size, mode[k].real / size, 1e-8);
        assert_close(near[k].imaginary / size, mode[k].imaginary / size, 1e-8);
        bool alone = true; /* equal ones have any mixture of shapes */
        for (int j = 0; j < count; ++j)
            alone = alone && (j == k || hypot(mode[j].real - mode[k].real,
                                              mode[j].imaginary - mode[k].imaginary) > 1e-5 * size);
        assert_ok(mbsr_linear_shape(l, k, x, y), NULL);
        for (int j = 0; j < r->nu && alone; ++j) {
            assert_close(re[k * r->nu + j], x[j], 1e-6);
            assert_close(im[k * r->nu + j], y[j], 1e-6);
        }
    }
    mbsr_linear_destroy(l);
}

static void random_models(void **state)
{
    (void)state;
    int found = 0, refused = 0;
    const int seeds = test_long() ? 300 : test_seeds(10, 75);
    for (int seed = 1; seed <= seeds; ++seed) {
        double first[MOST] = {0.0};
        int expected = MBSR_OK;
        for (int k = 0; k < 4; ++k) {
            const units *s = systems + k;
            random_model r;
            mbsr_error error;
            double q[MOST], lambda[4] = {0.0};
            make(&r, seed, s);
            const int status = mbsr_equilibrium(r.m, r.d, 0.0, r.q, NULL, q, lambda, NULL, &error);
            if (k == 0) expected = status;
            if (status != expected) print_error("seed %d, %s: %s\n", seed, s->name, error.text);
            assert_int_equal(status, expected);
            if (status) {
                if (status != MBSR_LOOP_OPEN) print_error("seed %d: %s\n", seed, error.text);
                assert_int_equal(status, MBSR_LOOP_OPEN); /* the rod does not reach */
                ++refused;
            } else {
                const double force = s->mass * s->length / (s->time * s->time);
                expect_balance(&r, q, lambda, force, s->length);
                if (k == 0) expect_modes(&r, q, 1.0);
                expect_slowest(&r, q);
                for (int j = 0; j < r.nu; ++j) {
                    const double value = q[j] / (r.turns[j] ? 1.0 : s->length);
                    if (k == 0) first[j] = value;
                    if (!(fabs(value - first[j]) < 1e-8))
                        print_error("seed %d, %s\n", seed, s->name);
                    assert_close(value, first[j], 1e-8);
                }
                ++found;
            }
            free_both(r.m, r.d);
        }
    }
    assert_true(found > 3 * seeds);
    (void)refused;
}

/* At the start nothing has a stiffness, so that the model has no rate of its own: it falls into a
 * cable that is slack there, x = l + m g / k. */
static void a_mass_falls_into_a_slack_cable(void **state)
{
    static const double along[3] = {1, 0, 0};
    const mbsr_spring cable = {.stiffness = 400.0, .free_length = 1.0, .one_sided = 1};
    const double start = 0.2;
    double rest;
    mbsr_error error;
    (void)state;
    mbsr_model *m = empty();
    add_body(m, MBSR_GROUND, NULL, mbsr_joint_prismatic(NULL, NULL, along),
             mbsr_inertia_particle(2.0));
    add_force(m, mbsr_force_spring(MBSR_GROUND, NULL, 0, NULL, &cable));
    add_force(m, mbsr_force_gravity(10.0, 0, 0));
    mbsr_data *d = finish(m);
    assert_ok(mbsr_equilibrium(m, d, 0.0, &start, NULL, &rest, NULL, NULL, &error), &error);
    assert_close(rest, 1.05, 1e-9);
    free_both(m, d);
}

/* A beam sags under a force at its tip by P L^3 / (3 EI), in as many steps whatever the units:
 * amplitudes of modes are in units of their own. */
static void a_beam_sags_in_any_units(void **state)
{
    (void)state;
    int iterations[4][2];
    double sag[4];
    for (int k = 0; k < 4; ++k) {
        const units *s = systems + k;
        const double force = s->mass * s->length / (s->time * s->time);
        double load[6] = {0, 0, 0, 0, 0, -2.0 * force};
        mbsr_beam_def def = mbsr_default_beam_def();
        mbsr_flex *flex;
        mbsr_error error;
        mbsr_equilibrium_info found;
        mbsr_trim_info trimmed;
        mbsr_parameters *list;
        double q[MOST] = {0.0}, x[3];
        int tip;
        def.length = s->length, def.density = 0.5 * s->mass / s->length;
        def.EI_y = def.EI_z = 20.0 * force * s->length * s->length;
        def.elements = 4, def.modes = 3, def.loaded = 1, def.node = (const int[]){4};
        assert_ok(mbsr_flex_beam(&def, &flex, &error), &error);
        mbsr_model *m = empty();
        mbsr_flexible_def at = mbsr_default_flexible_def();
        at.flex = flex, at.joint = mbsr_joint_weld(NULL, NULL);
        int body;
        assert_ok(mbsr_model_add_flexible(m, &at, &body), mbsr_model_error(m));
        assert_ok(mbsr_model_add_marker(m, body, 4, "tip", &tip), mbsr_model_error(m));
        add_force(m, mbsr_force_wrench(tip, NULL, 0, mbsr_stored_force, load));
        mbsr_data *d = finish(m);
        assert_ok(mbsr_parameters_create(m, &list, &error), &error);
        assert_ok(mbsr_trim(list, 0.0, q, 0, NULL, NULL, q, NULL, &trimmed, &error), &error);
        memset(q, 0, sizeof q);
        assert_ok(mbsr_equilibrium(m, d, 0.0, q, NULL, q, NULL, &found, &error), &error);
        assert_ok(mbsr_stage_positions(m, d, 0.0, q), mbsr_data_error(d));
        assert_ok(mbsr_body_point(m, d, tip, NULL, x, NULL, NULL), mbsr_data_error(d));
        sag[k] = -x[2] / s->length;
        iterations[k][0] = found.iterations, iterations[k][1] = trimmed.iterations;
        assert_close(sag[k], 2.0 / (3.0 * 20.0), 1e-9);
        assert_close(sag[k], sag[0], 1e-9);
        for (int l = 0; l < 2; ++l) assert_int_equal(iterations[k][l], iterations[0][l]);
        mbsr_parameters_destroy(list);
        free_both(m, d);
        mbsr_flex_destroy(flex);
    }
}

/* Two cranks and a coupler without mass, all in one line, where a row of the loop depends on the
 * other: the cranks come to hang. */
static void a_flat_parallelogram_opens(void **state)
{
    (void)state;
    const double weight = 9.81, down = -2.0 * atan(1.0), start[3] = {0.0, 0.0, -2.0 * down};
    for (int k = 0; k < 4; ++k) {
        const units *s = systems + k;
        const double L = s->length, force = s->mass * L / (s->time * s->time);
        const mbsr_frame end = mbsr_frame_at(L, 0.0, 0.0), other = mbsr_frame_at(2.0 * L, 0.0, 0.0);
        double q[3], lambda[3];
        mbsr_error error;
        mbsr_model *m = empty();
        add_body(m, MBSR_GROUND, "crank", mbsr_joint_revolute(NULL, NULL, z_axis),
                 mbsr_inertia_point_mass(s->mass, (const double[3]){L, 0, 0}));
        add_body(m, 0, "coupler", mbsr_joint_revolute(&end, NULL, z_axis), mbsr_inertia_zero());
        add_body(m, 1, "other", mbsr_joint_revolute(&other, NULL, z_axis),
                 mbsr_inertia_point_mass(2.0 * s->mass, (const double[3]){0.5 * L, 0, 0}));
        const mbsr_closure_def pin = mbsr_closure_ball(2, end.x, MBSR_GROUND, other.x);
        assert_ok(mbsr_model_add_closure(m, &pin, NULL), mbsr_model_error(m));
        add_force(m, mbsr_force_gravity(0, -weight * L / (s->time * s->time), 0));
        mbsr_data *d = finish(m);
        assert_ok(mbsr_equilibrium(m, d, 0.0, start, NULL, q, lambda, NULL, &error), &error);
        assert_close(q[0], down, 1e-9);
        assert_close(q[1], -down, 1e-9);
        assert_close(q[2], -down, 1e-9);
        assert_close(lambda[0] / force, 0.0, 1e-8);
        assert_close(lambda[1] / force, 2.0 * weight, 1e-8);
        free_both(m, d);
    }
}

static const mbsr_closure_table *stock_ball;
static long asked; /* how often closures were asked for their rows */

static int counted_jacobian(const mbsr_closure_args *args, const mbsr_closure_jacobian *out)
{
    ++asked;
    return stock_ball->jacobian(args, out);
}

/* Calls for each closure of an equilibrium of that many four-bars side by side. */
static long calls_for_each(int loops)
{
    static const double out_of_plane[3] = {0, 0, 0.3};
    const mbsr_frame end = mbsr_frame_at(1.0, 0.0, 0.0), other = mbsr_frame_at(2.0, 0.0, 0.0);
    const double start[3] = {0.5, -0.5, 0.5 - 3.14159265358979};
    mbsr_closure_table table;
    double q[48], lambda[96];
    mbsr_error error;
    mbsr_model *m = empty();
    for (int k = 0; k < loops; ++k) {
        const double ground[3] = {2.0, 0.0, 0.0};
        add_body(m, MBSR_GROUND, "crank", mbsr_joint_revolute(NULL, NULL, z_axis),
                 mbsr_inertia_rigid(1.0, end.x, (const double[6]){0.1, 0.2, 0.2, 0, 0, 0}));
        add_body(m, 3 * k, "coupler", mbsr_joint_revolute(&end, NULL, z_axis),
                 mbsr_inertia_rigid(1.0, out_of_plane, (const double[6]){0.1, 0.2, 0.2, 0, 0, 0}));
        add_body(m, 3 * k + 1, "other", mbsr_joint_revolute(&other, NULL, z_axis),
                 mbsr_inertia_rigid(1.0, end.x, (const double[6]){0.1, 0.2, 0.2, 0, 0, 0}));
        mbsr_closure_def pin = mbsr_closure_ball(3 * k + 2, end.x, MBSR_GROUND, ground);
        stock_ball = pin.table;
        table = *pin.table;
        table.jacobian = counted_jacobian;
        pin.table = &table;
        assert_ok(mbsr_model_add_closure(m, &pin, NULL), mbsr_model_error(m));
        memcpy(q + 3 * k, start, sizeof start);
    }
    add_force(m, mbsr_force_gravity(0, -9.81, 0));
    mbsr_data *d = finish(m);
    asked = 0;
    assert_ok(mbsr_equilibrium(m, d, 0.0, q, NULL, q, lambda, NULL, &error), &error);
    for (int k = 0; k < loops; ++k) assert_close(q[3 * k], -1.5707963267949, 1e-9);
    free_both(m, d);
    return asked / loops;
}

static void loops_are_asked_as_often_however_many(void **state)
{
    (void)state;
    const long few = calls_for_each(4);
    assert_true(few > 0);
    assert_true(calls_for_each(16) <= few + few / 4);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_mass_falls_into_a_slack_cable),
                                       cmocka_unit_test(a_pendulum_on_a_spring),
                                       cmocka_unit_test(a_beam_sags_in_any_units),
                                       cmocka_unit_test(a_box_comes_to_rest_alike_in_all_units),
                                       cmocka_unit_test(a_chain),
                                       cmocka_unit_test(a_flat_parallelogram_opens),
                                       cmocka_unit_test(a_rod_and_a_spring),
                                       cmocka_unit_test(loops_are_asked_as_often_however_many),
                                       cmocka_unit_test(what_nothing_holds_is_named),
                                       cmocka_unit_test(random_models)};
    (void)x_axis;
    return cmocka_run_group_tests(tests, NULL, NULL);
}
