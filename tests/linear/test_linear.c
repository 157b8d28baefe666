/* Linear equations and modes of models with an answer on paper.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "build.h"
#include "units.h"

#include <mbsrank/linear.h>

#include <stdlib.h>

static const double pi = 3.14159265358979323846, along[3] = {1, 0, 0};

static mbsr_linear *linearise(mbsr_model *m, mbsr_data *d, const double *q, const double *u,
                              const mbsr_linear_opt *opt, int states)
{
    mbsr_linear *l;
    mbsr_error error;
    mbsr_linear_info info;
    assert_ok(mbsr_linear_create(m, d, 0.0, q, u, opt, &l, &error), &error);
    assert_ok(mbsr_linear_get_info(l, &info), NULL);
    assert_int_equal(info.states, states);
    return l;
}

static void done(mbsr_linear *l, mbsr_data *d, mbsr_model *m)
{
    mbsr_linear_destroy(l);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

/* m x" + d x' + k x = w in four systems of units: eigenvalues, response at rest and at resonance.
 */
static void an_oscillator(void **state)
{
    (void)state;
    for (int k = 0; k < 4; ++k) {
        const units *s = systems + k;
        const double mass = 2.0 * s->mass, stiffness = 50.0 * s->mass / (s->time * s->time),
                     damping = 1.0 * s->mass / s->time, rate = 1.0 / s->time;
        const mbsr_signal first = {.kind = MBSR_SIGNAL_JOINT};
        mbsr_linear_opt opt = mbsr_default_linear_opt();
        mbsr_model *m = empty();
        mbsr_mode mode[2];
        int count;
        double q = 0.0, re, im;
        opt.inputs = opt.outputs = 1;
        opt.input = opt.output = &first;
        add_body(m, MBSR_GROUND, "mass", mbsr_joint_prismatic(NULL, NULL, along),
                 mbsr_inertia_particle(mass));
        add_force(m, mbsr_force_joint_spring(0, 0, stiffness, damping, 0.0));
        mbsr_data *d = finish(m);
        mbsr_linear *l = linearise(m, d, &q, NULL, &opt, 2);
        assert_ok(mbsr_linear_modes(l, mode, &count), NULL);
        assert_int_equal(count, 1);
        assert_close(mode[0].real, -0.25 * rate, 1e-13 * rate);
        assert_close(mode[0].imaginary, sqrt(25.0 - 0.0625) * rate, 1e-12 * rate);
        assert_close(mode[0].frequency, mode[0].imaginary / (2.0 * pi), 1e-13 * rate);
        assert_close(mode[0].damping, 0.05, 1e-14);
        assert_ok(mbsr_linear_response(l, 0.0, &re, &im), NULL);
        assert_close(re * stiffness, 1.0, 1e-13);
        assert_close(im, 0.0, 0.0);
        assert_ok(mbsr_linear_response(l, 5.0 * rate / (2.0 * pi), &re, &im), NULL);
        assert_close(re * stiffness, 0.0, 1e-12);
        assert_close(im * stiffness, -10.0, 1e-11); /* -1 / (d w) */
        done(l, d, m);
    }
}

/* Masses and nodes without mass in a row on springs of 2 k between walls: f_i = 1/pi sqrt(k/m)
 * cos(...). The nodes have no eigenvalues, infinite or huge. */
static void a_string_of_masses_and_nodes(void **state)
{
    (void)state;
    enum { MASSES = 7, BODIES = 2 * MASSES + 1 };
    const double mass = 0.7, stiffness = 120.0;
    mbsr_model *m = empty();
    double q[BODIES] = {0.0};
    mbsr_mode mode[2 * BODIES];
    int count;
    add_string(m, BODIES, mass, stiffness);
    mbsr_data *d = finish(m);
    mbsr_linear *l = linearise(m, d, q, NULL, NULL, 2 * MASSES);
    assert_ok(mbsr_linear_modes(l, mode, &count), NULL);
    assert_int_equal(count, MASSES);
    for (int i = 1; i <= MASSES; ++i) {
        const double f =
            sqrt(stiffness / mass) / pi * cos((MASSES + 1.0 - i) / (MASSES + 1.0) * pi / 2.0);
        assert_close(mode[i - 1].frequency, f, 1e-11);
        assert_close(mode[i - 1].damping, 0.0, 1e-12);
        double re[BODIES], im[BODIES];
        assert_ok(mbsr_linear_shape(l, i - 1, re, im), NULL);
        assert_close(test_largest(BODIES, re), 1.0, 1e-12);
        assert_close(test_largest(BODIES, im), 0.0, 1e-9);
    }
    done(l, d, m);
}

/* A node without mass between a damper to the wall and a spring to a mass: three states. s (m s^2 +
 * k) d + k m s^2 = 0. */
static void a_damped_node(void **state)
{
    (void)state;
    const double mass = 1.5, k = 30.0, damping = 4.0, q[2] = {0.0};
    mbsr_model *m = empty();
    mbsr_mode mode[4];
    int count;
    add_body(m, MBSR_GROUND, "node", mbsr_joint_prismatic(NULL, NULL, along), mbsr_inertia_zero());
    add_body(m, 0, "mass", mbsr_joint_prismatic(NULL, NULL, along), mbsr_inertia_particle(mass));
    add_force(m, mbsr_force_joint_spring(0, 0, 0.0, damping, 0.0));
    add_force(m, mbsr_force_joint_spring(1, 0, k, 0.0, 0.0));
    mbsr_data *d = finish(m);
    mbsr_linear_opt opt = mbsr_default_linear_opt();
    const mbsr_signal node = {.kind = MBSR_SIGNAL_JOINT};
    opt.inputs = opt.outputs = 1;
    opt.input = opt.output = &node;
    mbsr_linear *l = linearise(m, d, q, NULL, &opt, 3);
    assert_ok(mbsr_linear_modes(l, mode, &count), NULL);
    assert_int_equal(count, 2); /* at rest anywhere, and a pair or two: m d s^2 + m k s + k d = 0 */
    const double half = k / (2.0 * damping), rest = k / mass - half * half;
    assert_close(hypot(mode[0].real, mode[0].imaginary), 0.0, 1e-12);
    assert_close(mode[1].real, -half, 1e-12);
    assert_close(mode[1].imaginary, sqrt(rest), 1e-12);
    /* a force on the node: q = w / (d s + k m s^2 / (m s^2 + k)), s = i r */
    const double r = 3.0, part = -k * mass * r * r / (k - mass * r * r),
                 size = part * part + damping * damping * r * r;
    double re, im;
    assert_ok(mbsr_linear_response(l, r / (2.0 * pi), &re, &im), NULL);
    assert_close(re, part / size, 1e-13);
    assert_close(im, -damping * r / size, 1e-13);
    done(l, d, m);
}

/* A point on a circle below and above its centre: sqrt(g / l), and +- sqrt(g / l). */
static void a_pendulum_of_a_loop(void **state)
{
    (void)state;
    const double length = 1.5, mass = 2.0, g = 9.81, q[2][2] = {{0, -length}, {0, length}};
    const mbsr_signal first = {.kind = MBSR_SIGNAL_JOINT};
    mbsr_linear_opt opt = mbsr_default_linear_opt();
    mbsr_model *m = empty();
    const mbsr_closure_def rod = mbsr_closure_distance(0, NULL, MBSR_GROUND, NULL, length);
    mbsr_mode mode[4];
    int count;
    double re, im;
    opt.inputs = opt.outputs = 1;
    opt.input = opt.output = &first;
    add_body(m, MBSR_GROUND, "point", mbsr_joint_point_free(), mbsr_inertia_particle(mass));
    add_force(m, mbsr_force_gravity(0, -g, 0));
    assert_ok(mbsr_model_add_closure(m, &rod, NULL), mbsr_model_error(m));
    mbsr_data *d = finish(m);
    mbsr_linear *l = linearise(m, d, q[0], NULL, &opt, 2);
    assert_ok(mbsr_linear_modes(l, mode, &count), NULL);
    assert_int_equal(count, 1);
    assert_close(mode[0].imaginary, sqrt(g / length), 1e-13);
    assert_ok(mbsr_linear_response(l, 0.0, &re, &im), NULL);
    assert_close(re, length / (mass * g), 1e-13);
    mbsr_linear_destroy(l);
    l = linearise(m, d, q[1], NULL, NULL, 2);
    assert_ok(mbsr_linear_modes(l, mode, &count), NULL);
    assert_int_equal(count, 2);
    for (int k = 0; k < 2; ++k) assert_close(fabs(mode[k].real), sqrt(g / length), 1e-13);
    assert_true(mode[0].real * mode[1].real < 0.0);
    done(l, d, m);
}

/* A sleeping top: A s^2 - i C w s - m g h = 0 for the tilt seen from the world; on a quaternion
 * that turns. */
static void a_sleeping_top(void **state)
{
    (void)state;
    const double mass = 1.2, h = 0.3, A = 0.05 + mass * h * h, C = 0.08, w = 40.0, g = 9.81,
                 root = sqrt(C * C * w * w - 4.0 * A * mass * g * h), q[4] = {1, 0, 0, 0},
                 u[3] = {0, 0, w};
    mbsr_model *m = empty();
    mbsr_mode mode[6];
    int count;
    add_body(m, MBSR_GROUND, "top", mbsr_joint_spherical(NULL, NULL),
             mbsr_inertia_rigid(mass, (const double[3]){0, 0, h},
                                (const double[6]){0.05, 0.05, C, 0, 0, 0}));
    add_force(m, mbsr_force_gravity(0, 0, -g));
    mbsr_data *d = finish(m);
    mbsr_linear *l = linearise(m, d, q, u, NULL, 6);
    assert_ok(mbsr_linear_modes(l, mode, &count), NULL);
    assert_int_equal(count, 4); /* its spin and the angle of that */
    assert_close(mode[2].imaginary, (C * w - root) / (2.0 * A), 1e-11);
    assert_close(mode[3].imaginary, (C * w + root) / (2.0 * A), 1e-11);
    done(l, d, m);
}

/* Nothing half-built. */
static void what_is_wrong_is_refused(void **state)
{
    (void)state;
    mbsr_model *m = empty(), *loose = empty();
    mbsr_linear *l = NULL;
    mbsr_linear_opt opt = mbsr_default_linear_opt();
    mbsr_error error;
    const double q[2] = {0.0};
    const mbsr_signal wrong = {.kind = MBSR_SIGNAL_JOINT, .id = 2},
                      other = {.kind = MBSR_SIGNAL_POINT};
    add_body(m, MBSR_GROUND, "mass", mbsr_joint_prismatic(NULL, NULL, along),
             mbsr_inertia_particle(1.0));
    add_body(loose, MBSR_GROUND, "loose", mbsr_joint_prismatic(NULL, NULL, along),
             mbsr_inertia_zero());
    assert_refused(mbsr_linear_create(m, NULL, 0.0, q, NULL, NULL, &l, &error), &error,
                   MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "mbsr_linear_create|data is NULL");
    mbsr_data *d = finish(m), *of_loose = finish(loose);
    assert_refused(mbsr_linear_create(m, d, 0.0, NULL, NULL, NULL, &l, &error), &error,
                   MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "q is NULL");
    assert_refused(mbsr_linear_create(NULL, d, 0.0, q, NULL, NULL, &l, &error), &error,
                   MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "model is NULL");
    opt.inputs = 1;
    assert_refused(mbsr_linear_create(m, d, 0.0, q, NULL, &opt, &l, &error), &error, MBSR_ERR_VALUE,
                   MBSR_NONE, MBSR_NONE, "no list");
    opt.input = &wrong;
    assert_refused(mbsr_linear_create(m, d, 0.0, q, NULL, &opt, &l, &error), &error, MBSR_ERR_VALUE,
                   MBSR_NONE, MBSR_NONE, "input 0 is of no such joint rate: 2");
    opt.input = &other;
    assert_refused(mbsr_linear_create(m, d, 0.0, q, NULL, &opt, &l, &error), &error, MBSR_ERR_VALUE,
                   MBSR_NONE, MBSR_NONE, "input 0 is of a kind that it cannot be");
    opt.cookie = 0;
    assert_refused(mbsr_linear_create(m, d, 0.0, q, NULL, &opt, &l, &error), &error,
                   MBSR_ERR_NO_DEFAULT, MBSR_NONE, MBSR_NONE, "opt");
    assert_refused(mbsr_linear_create(m, of_loose, 0.0, q, NULL, NULL, &l, &error), &error,
                   MBSR_ERR_MISMATCH, MBSR_NONE, MBSR_NONE, "another model");
    assert_int_equal(mbsr_linear_create(loose, of_loose, 0.0, q, NULL, NULL, &l, &error),
                     MBSR_UNDETERMINED);
    assert_contains(error.text, "mbsr_linear_create");
    assert_null(l);
    assert_ok(mbsr_linear_create(m, d, 0.0, q, NULL, NULL, &l, &error), &error);
    int count, rows, columns;
    double re;
    assert_int_equal(mbsr_linear_modes(NULL, NULL, &count), MBSR_ERR_NULL);
    assert_int_equal(mbsr_linear_shape(l, 5, &re, NULL), MBSR_ERR_VALUE);
    assert_int_equal(mbsr_linear_response(l, NAN, &re, &re), MBSR_NOT_FINITE);
    assert_null(mbsr_linear_matrix(l, MBSR_LINEAR_PARTS, NULL, NULL));
    assert_non_null(mbsr_linear_matrix(l, MBSR_LINEAR_A, &rows, &columns));
    assert_int_equal(rows, 3);
    assert_int_equal(columns, 3);
    mbsr_data_destroy(of_loose);
    mbsr_model_destroy(loose);
    done(l, d, m);
}

/* With the data of another, since it has none. */
static void unfinished_models_are_refused(void **state)
{
    (void)state;
    mbsr_model *m = empty(), *raw = empty();
    add_body(m, MBSR_GROUND, NULL, mbsr_joint_prismatic(NULL, NULL, along),
             mbsr_inertia_particle(1.0));
    mbsr_data *d = finish(m);
    mbsr_linear *l;
    mbsr_parameters *list;
    mbsr_signal signal;
    mbsr_mode mode[6] = {{0}};
    mbsr_error e;
    const double q[1] = {0.0};
    double rest[1];
    int found;
    const int unfinished = MBSR_ERR_UNFINISHED;
    assert_refused(mbsr_linear_create(raw, d, 0.0, q, NULL, NULL, &l, &e), &e, unfinished,
                   MBSR_NONE, MBSR_NONE, "mbsr_linear_create|not finished");
    assert_refused(mbsr_equilibrium(raw, d, 0.0, q, NULL, rest, NULL, NULL, &e), &e, unfinished,
                   MBSR_NONE, MBSR_NONE, "mbsr_equilibrium|not finished");
    assert_refused(mbsr_modes_near(raw, d, 0.0, q, NULL, mode, &found, NULL, NULL, &e), &e,
                   unfinished, MBSR_NONE, MBSR_NONE, "mbsr_modes_near|not finished");
    assert_refused(mbsr_mode_participation(raw, d, 0.0, q, mode, q, NULL, rest, rest, NULL, &e), &e,
                   unfinished, MBSR_NONE, MBSR_NONE, "mbsr_mode_participation|not finished");
    assert_refused(mbsr_signal_find(raw, NULL, "x", &signal, &e), &e, unfinished, MBSR_NONE,
                   MBSR_NONE, "mbsr_signal_find|not finished");
    assert_refused(mbsr_parameters_create(raw, &list, &e), &e, unfinished, MBSR_NONE, MBSR_NONE,
                   "mbsr_parameters_create|not finished");
    free_both(m, d);
    mbsr_model_destroy(raw);
}

/* Two free masses with a spring between them: a mode of sqrt(2) w, however slow or fast, and two
 * zeros. */
static void modes_of_any_rate(void **state)
{
    (void)state;
    for (int k = -12; k <= 12; ++k) {
        const double w = pow(10.0, k), at[2] = {0.0, 0.0};
        mbsr_model *m = empty();
        mbsr_mode mode[4];
        int count;
        for (int l = 0; l < 2; ++l)
            add_body(m, l - 1, NULL, mbsr_joint_prismatic(NULL, NULL, along),
                     mbsr_inertia_particle(2.0));
        add_force(m, mbsr_force_joint_spring(1, 0, 2.0 * w * w, 0.0, 0.0));
        mbsr_data *d = finish(m);
        mbsr_linear *l = linearise(m, d, at, NULL, NULL, 4);
        assert_ok(mbsr_linear_modes(l, mode, &count), NULL);
        assert_close(mode[count - 1].imaginary / w, sqrt(2.0), 1e-12);
        assert_close(mode[count - 1].real / w, 0.0, 1e-12);
        done(l, d, m);
    }
}

/* Springs and bodies without mass have no state, in whatever unit of time. */
static void springs_alone(void **state)
{
    (void)state;
    for (int k = -9; k <= 9; ++k) {
        const double unit = pow(10.0, k), none = 0.0, com[2] = {0.0, 0.0}, at[3] = {0.3, 0.2, 0.1};
        const mbsr_planar_frame A = {0.3, 0.1, 0.4}, B = {none, none, none};
        mbsr_model *m = empty();
        for (int l = 0; l < 3; ++l) {
            add_body(m, l - 1, NULL,
                     l == 1 ? mbsr_joint_planar_revolute(A, B) : mbsr_joint_planar_prismatic(A, B),
                     mbsr_inertia_planar(0.0, com, 0.0));
            add_force(m,
                      mbsr_force_joint_spring(l, 0, (3.7 + 1.3 * l) / (unit * unit), 0.0, at[l]));
        }
        add_force(m, mbsr_force_point_spring(2, NULL, MBSR_GROUND, (const double[3]){0.3, 0.9, 0.0},
                                             2.9 / (unit * unit), 0.0, 0.2));
        mbsr_data *d = finish(m);
        done(linearise(m, d, at, NULL, NULL, 0), d, m);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(an_oscillator),
                                       cmocka_unit_test(a_string_of_masses_and_nodes),
                                       cmocka_unit_test(a_damped_node),
                                       cmocka_unit_test(modes_of_any_rate),
                                       cmocka_unit_test(springs_alone),
                                       cmocka_unit_test(a_pendulum_of_a_loop),
                                       cmocka_unit_test(a_sleeping_top),
                                       cmocka_unit_test(what_is_wrong_is_refused),
                                       cmocka_unit_test(unfinished_models_are_refused)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
