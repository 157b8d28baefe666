/* Trim and preloads: with answers on paper, and of random models in four systems of units.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "build.h"
#include "units.h"

#include <mbsrank/driver.h>
#include <mbsrank/linear.h>

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>

static const double x_axis[3] = {1, 0, 0}, y_axis[3] = {0, 1, 0}, z_axis[3] = {0, 0, 1};

/* The list of a model, which is finished and freed. */
static mbsr_parameters *list_of(mbsr_model *m)
{
    mbsr_parameters *list;
    mbsr_error error;
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_ok(mbsr_parameters_create(m, &list, &error), &error);
    mbsr_model_destroy(m);
    return list;
}

static int named(const mbsr_parameters *list, const char *text)
{
    const int k = mbsr_parameters_find(list, text);
    assert_true(k >= 0);
    return k;
}

/* Two rods that a servo at each hinge holds: the references that keep them where they are drawn,
 * reference = q + m g .../kp. */
static void references_of_servos(void **state)
{
    (void)state;
    mbsr_model *m = empty();
    const mbsr_frame elbow = mbsr_frame_at(1.0, 0.0, 0.0);
    const mbsr_servo servo = {.kp = 50.0, .kd = 1.0};
    for (int k = 0; k < 2; ++k)
        add_body(m, k - 1, k ? "fore" : "upper",
                 mbsr_joint_revolute(k ? &elbow : NULL, NULL, y_axis),
                 mbsr_inertia_point_mass(2.0, (const double[3]){1, 0, 0}));
    add_force(m, mbsr_force_gravity(0, 0, -10.0));
    for (int k = 0; k < 2; ++k) add_force(m, mbsr_force_joint_servo(k, 0, &servo));
    mbsr_parameters *list = list_of(m);
    const int which[] = {named(list, "forces.force1.reference"),
                         named(list, "forces.force2.reference")};
    const double q[2] = {-0.3, 0.5};
    double rest[2], value[2];
    mbsr_trim_opt opt = mbsr_default_trim_opt();
    mbsr_trim_info info;
    mbsr_error error;
    opt.held = -1;
    assert_ok(mbsr_trim(list, 0.0, q, 2, which, &opt, rest, value, &info, &error), &error);
    /* about y a positive angle turns x down: weights pull down by m g cos of the angles */
    const double fore = 20.0 * cos(q[0] + q[1]), upper = 40.0 * cos(q[0]) + fore;
    assert_close(value[0], q[0] - upper / 50.0, 1e-12);
    assert_close(value[1], q[1] - fore / 50.0, 1e-12);
    assert_true(rest[0] == q[0] && rest[1] == q[1] && info.loose == 0.0);
    /* one hinge held, its reference free, the other as it comes to rest */
    opt.held = 1;
    opt.hold = (const int[]){0};
    assert_ok(mbsr_trim(list, 0.0, q, 1, which, &opt, rest, value, &info, &error), &error);
    assert_true(rest[0] == q[0]);
    assert_close(-50.0 * rest[1] + 20.0 * cos(q[0] + rest[1]), 0.0, 1e-8);
    assert_close(50.0 * (value[0] - q[0]) + 40.0 * cos(q[0]) + 20.0 * cos(q[0] + rest[1]), 0.0,
                 1e-8);
    mbsr_parameters_destroy(list);
}

/* A rod that stands upright, and hangs: it leaves the one as exp(sqrt(g / l) t). */
static void how_a_rest_grows(void **state)
{
    (void)state;
    mbsr_model *m = empty();
    add_body(m, MBSR_GROUND, "rod", mbsr_joint_revolute(NULL, NULL, y_axis),
             mbsr_inertia_point_mass(2.0, (const double[3]){0, 0, 0.4}));
    add_force(m, mbsr_force_gravity(0, 0, -10.0));
    mbsr_parameters *list = list_of(m);
    mbsr_trim_info info;
    mbsr_error error;
    double rest;
    for (int hangs = 0; hangs < 2; ++hangs) {
        const double q = hangs ? 3.0 : 0.1;
        assert_ok(mbsr_trim(list, 0.0, &q, 0, NULL, NULL, &rest, NULL, &info, &error), &error);
        assert_close(rest, hangs ? 3.14159265358979 : 0.0, 1e-9);
        assert_close(info.growth, hangs ? 0.0 : 5.0, 1e-9);
    }
    mbsr_parameters_destroy(list);
}

/* A table on three springs, of which two are enough: the least change of free lengths, and a spring
 * beside the way is loose. */
static void what_nothing_determines_is_named(void **state)
{
    (void)state;
    mbsr_model *m = empty();
    add_body(m, MBSR_GROUND, "table", mbsr_joint_prismatic(NULL, NULL, z_axis),
             mbsr_inertia_particle(3.0));
    add_body(m, MBSR_GROUND, "cart", mbsr_joint_prismatic(NULL, NULL, x_axis),
             mbsr_inertia_particle(1.0));
    add_force(m, mbsr_force_gravity(0, 0, -10.0));
    for (int k = 0; k < 2; ++k) add_force(m, mbsr_force_joint_spring(0, 0, 60.0, 0.0, 0.0));
    mbsr_parameters *list = list_of(m);
    const int which[] = {named(list, "forces.force1.rest"), named(list, "forces.force2.rest")};
    const double q[2] = {0.1, 0.4};
    double rest[2], value[2];
    mbsr_trim_info info;
    mbsr_error error;
    mbsr_trim_opt opt = mbsr_default_trim_opt();
    opt.held = -1;
    /* 60 (2 q - r1 - r2) + 30 = 0, shared */
    assert_ok(mbsr_trim(list, 0.0, q, 2, which, &opt, rest, value, &info, &error), &error);
    assert_close(value[0], 0.35, 1e-12);
    assert_close(value[1], 0.35, 1e-12);
    assert_close(info.loose, 0.5, 1e-9);
    assert_int_equal(info.loose_parameter, which[0]);
    assert_int_equal(info.loose_rate, MBSR_NONE);
    /* nothing holds the cart: where it is it rests */
    assert_ok(mbsr_trim(list, 0.0, q, 0, NULL, NULL, rest, NULL, &info, &error), &error);
    assert_close(rest[0], -0.25, 1e-12);
    assert_true(rest[1] == q[1]);
    assert_close(info.loose, 1.0, 1e-9);
    assert_int_equal(info.loose_rate, 1);
    mbsr_parameters_destroy(list);
}

/* A weight on a rod, a loop: the free length of a spring to the ground keeps it at an angle. */
static void a_spring_and_a_loop(void **state)
{
    (void)state;
    const double angle = 0.6, length = 1.5, k = 12.0, mass = 2.0, g = 9.81;
    mbsr_model *m = empty();
    const mbsr_closure_def rod = mbsr_closure_distance(0, NULL, MBSR_GROUND, NULL, length);
    add_body(m, MBSR_GROUND, "mass", mbsr_joint_point_free(), mbsr_inertia_particle(mass));
    add_force(m, mbsr_force_gravity(0, -g, 0));
    add_force(m, mbsr_force_axis_spring(0, MBSR_GROUND, 0, k, 0.0, 0.1));
    assert_ok(mbsr_model_add_closure(m, &rod, NULL), mbsr_model_error(m));
    mbsr_parameters *list = list_of(m);
    const int which = named(list, "forces.force1.rest");
    const double q[2] = {length * sin(angle), -length * cos(angle)};
    double rest[2], value;
    mbsr_trim_opt opt = mbsr_default_trim_opt();
    mbsr_error error;
    opt.held = -1;
    assert_ok(mbsr_trim(list, 0.0, q, 1, &which, &opt, rest, &value, NULL, &error), &error);
    /* along the circle: k (rest - x) cos = m g sin */
    assert_close(value, q[0] + mass * g * tan(angle) / k, 1e-12);
    /* and back: free in position, from elsewhere */
    const double start[2] = {0.3, -1.4};
    mbsr_model *trimmed;
    assert_ok(mbsr_parameters_model(list, 1, &which, &value, &trimmed, &error), &error);
    mbsr_parameters *second;
    assert_ok(mbsr_parameters_create(trimmed, &second, &error), &error);
    assert_ok(mbsr_trim(second, 0.0, start, 0, NULL, NULL, rest, NULL, NULL, &error), &error);
    assert_close(rest[0], q[0], 1e-9);
    assert_close(rest[1], q[1], 1e-9);
    /* with the rod's end held off the circle there is no loop */
    const double off[2] = {0.3, -1.0};
    assert_refused(mbsr_trim(list, 0.0, off, 1, &which, &opt, rest, &value, NULL, &error), &error,
                   MBSR_LOOP_OPEN, MBSR_NONE, MBSR_NONE, "mbsr_trim|loops");
    mbsr_parameters_destroy(second);
    mbsr_model_destroy(trimmed);
    mbsr_parameters_destroy(list);
}

/* Over gravity, from load to load: a cubic spring, and an arch that snaps is left out. */
static void a_path_over_the_load(void **state)
{
    (void)state;
    mbsr_model *m = empty();
    add_body(m, MBSR_GROUND, "bob", mbsr_joint_revolute(NULL, NULL, y_axis),
             mbsr_inertia_point_mass(1.0, (const double[3]){1, 0, 0}));
    add_force(m, mbsr_force_gravity(0, 0, 0.0));
    add_force(m, mbsr_force_joint_cubic_spring(0, 0, 2.0, 3.0, 0.0, 0.0));
    mbsr_parameters *list = list_of(m);
    const int load = named(list, "forces.force0.gz");
    double q = 0.0;
    mbsr_error error;
    for (int k = 1; k <= 10; ++k) {
        const double g = -4.0 * k;
        mbsr_model *at;
        mbsr_parameters *here;
        assert_ok(mbsr_parameters_model(list, 1, &load, &g, &at, &error), &error);
        assert_ok(mbsr_parameters_create(at, &here, &error), &error);
        assert_ok(mbsr_trim(here, 0.0, &q, 0, NULL, NULL, &q, NULL, NULL, &error), &error);
        assert_close(2.0 * q + 3.0 * q * q * q, -g * cos(q), 1e-8);
        mbsr_parameters_destroy(here);
        mbsr_model_destroy(at);
    }
    /* and the load for a given angle */
    double g;
    mbsr_trim_opt opt = mbsr_default_trim_opt();
    opt.held = -1;
    q = 0.7;
    assert_ok(mbsr_trim(list, 0.0, &q, 1, &load, &opt, &q, &g, NULL, &error), &error);
    assert_close(g, -(2.0 * q + 3.0 * q * q * q) / cos(q), 1e-9);
    mbsr_parameters_destroy(list);
}

static void what_trim_refuses(void **state)
{
    (void)state;
    mbsr_model *m = empty();
    add_body(m, MBSR_GROUND, "hangs", mbsr_joint_prismatic(NULL, NULL, z_axis),
             mbsr_inertia_particle(1.0));
    add_body(m, MBSR_GROUND, "falls", mbsr_joint_prismatic(NULL, NULL, z_axis),
             mbsr_inertia_particle(1.0));
    add_force(m, mbsr_force_gravity(0, 0, -9.81));
    add_force(m, mbsr_force_joint_spring(0, 0, 3.0, 0.1, 0.4));
    mbsr_parameters *list = list_of(m);
    const int rest = named(list, "forces.force1.rest"), twice[] = {rest, rest}, none = 1000;
    const double q[2] = {0.2, 0.1};
    double found[2] = {17.0, 17.0}, value[2] = {5.0, 5.0};
    mbsr_trim_info info;
    mbsr_error error;
    mbsr_trim_opt opt = mbsr_default_trim_opt();
    opt.held = -1;
    assert_refused(mbsr_trim(list, 0.0, q, 1, &rest, &opt, found, value, &info, &error), &error,
                   MBSR_NO_CONVERGENCE, 1, MBSR_NONE, "mbsr_trim|u0 of body 1 'falls'|(-9.81)");
    assert_int_equal(info.worst, 1);
    assert_true(found[0] == 17.0 && value[0] == 5.0);
    assert_refused(mbsr_trim(list, 0.0, q, 2, twice, &opt, found, value, NULL, &error), &error,
                   MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE, "which[0] and which[1]");
    assert_refused(mbsr_trim(list, 0.0, q, 1, &none, &opt, found, value, NULL, &error), &error,
                   MBSR_ERR_ID, MBSR_NONE, MBSR_NONE, "which[0]|1000");
    opt.held = 1, opt.hold = &none;
    assert_refused(mbsr_trim(list, 0.0, q, 1, &rest, &opt, found, value, NULL, &error), &error,
                   MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE, "hold");
    opt.held = 0, opt.tolerance = NAN;
    assert_refused(mbsr_trim(list, 0.0, q, 1, &rest, &opt, found, value, NULL, &error), &error,
                   MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE, "tolerance");
    mbsr_trim_opt bad[] = {mbsr_default_trim_opt(), mbsr_default_trim_opt()};
    bad[0].max_iterations = 0, bad[1].held = -2;
    for (int k = 0; k < 2; ++k)
        assert_int_equal(mbsr_trim(list, 0.0, q, 1, &rest, bad + k, found, value, NULL, &error),
                         MBSR_ERR_VALUE);
    assert_int_equal(mbsr_trim(list, 0.0, q, -1, &rest, NULL, found, value, NULL, NULL),
                     MBSR_ERR_VALUE);
    assert_int_equal(mbsr_trim(NULL, 0.0, q, 1, &rest, NULL, found, value, NULL, &error),
                     MBSR_ERR_NULL);
    assert_int_equal(mbsr_trim(list, 0.0, q, 1, NULL, NULL, found, value, NULL, &error),
                     MBSR_ERR_NULL);
    assert_int_equal(mbsr_trim(list, 0.0, q, 1, &rest, NULL, NULL, value, NULL, &error),
                     MBSR_ERR_NULL);
    assert_int_equal(mbsr_trim(list, 0.0, q, 1, &rest, NULL, found, NULL, NULL, &error),
                     MBSR_ERR_NULL);
    const int negative = -1;
    assert_int_equal(mbsr_trim(list, 0.0, q, 1, &negative, NULL, found, value, NULL, &error),
                     MBSR_ERR_ID);
    opt.cookie = 0;
    assert_refused(mbsr_trim(list, 0.0, q, 1, &rest, &opt, found, value, NULL, &error), &error,
                   MBSR_ERR_NO_DEFAULT, MBSR_NONE, MBSR_NONE, "opt");
    assert_refused(mbsr_trim(list, 0.0, NULL, 1, &rest, NULL, found, value, NULL, &error), &error,
                   MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "q");
    assert_refused(
        mbsr_trim(list, 0.0, (const double[]){NAN, 0.0}, 0, NULL, NULL, found, value, NULL, &error),
        &error, MBSR_NOT_FINITE, error.body, MBSR_NONE, "");
    mbsr_parameters_destroy(list);
}

/* ---- random models ---- */

enum { MOST = 40 };

/* Trees of hinges, sliders and balls, some bodies without mass, a spring at each coordinate whose
 * rest is sought; every third has a rod from its last body to the ground. */
static mbsr_parameters *random_list(int seed, const units *s, double *q, int *which, int *count)
{
    test_rng rng = test_seed((uint64_t)seed);
    const double L = s->length, force = s->mass * s->length / (s->time * s->time);
    const int bodies = test_integer(&rng, 1, 8);
    mbsr_model *m = empty();
    int nq = 0;
    for (int k = 0; k < bodies; ++k) {
        const double at[3] = {L * test_uniform(&rng), L * test_uniform(&rng),
                              L * test_uniform(&rng)};
        const mbsr_frame A = mbsr_frame_at(at[0], at[1], at[2]);
        const bool slides = test_integer(&rng, 0, 2) == 0, none = k + 1 < bodies && k % 3 == 1;
        const double *const axes[] = {x_axis, y_axis, z_axis},
                            *axis = axes[test_integer(&rng, 0, 2)];
        add_body(m, test_integer(&rng, -1, k - 1), NULL,
                 slides ? mbsr_joint_prismatic(&A, NULL, axis)
                        : mbsr_joint_revolute(&A, NULL, axis),
                 none ? mbsr_inertia_zero()
                      : mbsr_inertia_point_mass(s->mass * exp(test_uniform(&rng)), at));
        q[nq++] = slides ? L * 0.3 * test_uniform(&rng) : test_uniform(&rng);
        const double stiff = (slides ? force / L : force * L) * exp(3.0 * test_uniform(&rng));
        add_force(m, mbsr_force_joint_spring(k, 0, 20.0 * stiff, 0.0, 0.0));
    }
    add_force(
        m, mbsr_force_gravity(0.0, 2.0 * L / (s->time * s->time), -9.0 * L / (s->time * s->time)));
    mbsr_parameters *list = list_of(m);
    *count = bodies;
    for (int k = 0; k < bodies; ++k) {
        char text[64];
        snprintf(text, sizeof text, "forces.force%d.rest", k);
        which[k] = named(list, text);
    }
    return list;
}

/* Preloads keep a model where it is drawn: forces balance there, to the last digits, and the free
 * positions come back from beside. The same in all units. */
static void preloads_of_random_models(void **state)
{
    (void)state;
    for (int seed = 1; seed <= 40; ++seed) {
        double first[MOST] = {0.0};
        for (size_t system = 0; system < sizeof systems / sizeof *systems; ++system) {
            double q[MOST], rest[MOST], value[MOST], tau[MOST], zero[MOST] = {0.0}, beside[MOST];
            int which[MOST], count;
            mbsr_trim_opt opt = mbsr_default_trim_opt();
            mbsr_error error;
            mbsr_data *d;
            mbsr_model *own;
            mbsr_parameters *second, *list = random_list(seed, systems + system, q, which, &count);
            opt.held = -1;
            assert_ok(mbsr_trim(list, 0.0, q, count, which, &opt, rest, value, NULL, &error),
                      &error);
            assert_ok(mbsr_parameters_data(list, count, which, value, &d, &error), &error);
            assert_ok(mbsr_bias_forces(mbsr_data_model(d), d, 0.0, q, zero, tau),
                      mbsr_data_error(d));
            const units *s = systems + system;
            const double work = s->mass * s->length * s->length / (s->time * s->time);
            for (int k = 0; k < count; ++k) {
                mbsr_coordinate_kind kind;
                mbsr_body_coordinate_kinds(mbsr_data_model(d), k, NULL, &kind);
                const double unit = kind == MBSR_COORDINATE_TRANSLATION ? s->length : 1.0;
                assert_close(tau[k] * unit / work, 0.0, 1e-9);
                if (system == 0) first[k] = value[k] / unit;
                assert_close(value[k] / unit, first[k], 1e-9);
                beside[k] = q[k] + 1e-3 * unit;
            }
            mbsr_data_destroy(d);
            assert_ok(mbsr_parameters_model(list, count, which, value, &own, &error), &error);
            assert_ok(mbsr_parameters_create(own, &second, &error), &error);
            assert_ok(mbsr_trim(second, 0.0, beside, 0, NULL, NULL, rest, NULL, NULL, &error),
                      &error);
            for (int k = 0; k < count; ++k)
                assert_close(rest[k] / s->length, q[k] / s->length, 1e-7 * (1.0 + 1.0 / s->length));
            mbsr_parameters_destroy(second);
            mbsr_model_destroy(own);
            mbsr_parameters_destroy(list);
        }
    }
}

/* Where the hinge of a pendulum is that a rod without mass holds as drawn: places of joints in
 * loops have no products, their columns are differences. */
static void place_of_a_hinge(void **state)
{
    static const double end[3] = {1.0, 0.0, 0.0}, hook[3] = {0.3, 0.0, 2.0};
    (void)state;
    mbsr_model *m = empty();
    add_body(m, MBSR_GROUND, "pendulum", mbsr_joint_revolute(NULL, NULL, y_axis),
             mbsr_inertia_point_mass(2.0, end));
    add_force(m, mbsr_force_gravity(0, 0, -10.0));
    mbsr_closure_def rod = mbsr_closure_distance(0, end, MBSR_GROUND, hook, 1.7);
    rod.name = "rod";
    assert_ok(mbsr_model_add_closure(m, &rod, NULL), mbsr_model_error(m));
    mbsr_parameters *list = list_of(m);
    const int which = named(list, "bodies.pendulum.joint_position[1]");
    const double q = -0.4, below = 2.0 + sin(q);
    double rest, value;
    mbsr_trim_opt opt = mbsr_default_trim_opt();
    mbsr_error error;
    opt.held = -1;
    assert_ok(mbsr_trim(list, 0.0, &q, 1, &which, &opt, &rest, &value, NULL, &error), &error);
    assert_true(rest == q);
    assert_close(value, hook[0] - cos(q) + sqrt(1.7 * 1.7 - below * below), 1e-9);
    mbsr_parameters_destroy(list);
}

/* A cart that is drawn where all begins, on a spring to a point two metres on. */
static void from_where_all_begins(void **state)
{
    (void)state;
    double rest[sizeof systems / sizeof *systems];
    mbsr_trim_info info[sizeof systems / sizeof *systems];
    for (size_t k = 0; k < sizeof systems / sizeof *systems; ++k) {
        const units *s = systems + k;
        const double L = s->length, stiffness = s->mass / (s->time * s->time),
                     moment = 0.1 * s->mass * L * L, tensor[6] = {moment, moment, moment, 0, 0, 0},
                     com[3] = {0.0, 0.1 * L, 0.0}, hook[3] = {0.0, 0.3 * L, 0.0},
                     far[3] = {2.0 * L, 0.5 * L, 0.0}, q = 0.0;
        mbsr_model *m = empty();
        mbsr_error error;
        add_body(m, MBSR_GROUND, "cart", mbsr_joint_prismatic(NULL, NULL, x_axis),
                 mbsr_inertia_rigid(2.0 * s->mass, com, tensor));
        add_force(
            m, mbsr_force_point_spring(0, hook, MBSR_GROUND, far, 400.0 * stiffness, 0.0, 0.5 * L));
        add_force(m, mbsr_force_joint_spring(0, 0, 10.0 * stiffness, 0.0, 0.0));
        mbsr_parameters *list = list_of(m);
        assert_ok(mbsr_trim(list, 0.0, &q, 0, NULL, NULL, rest + k, NULL, info + k, &error),
                  &error);
        assert_close(rest[k] / L, rest[0], 1e-9);
        assert_int_equal(info[k].iterations, info[0].iterations);
        mbsr_parameters_destroy(list);
    }
    assert_true(rest[0] > 1.4 && rest[0] < 1.6);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(references_of_servos),  cmocka_unit_test(place_of_a_hinge),
        cmocka_unit_test(how_a_rest_grows),      cmocka_unit_test(what_nothing_determines_is_named),
        cmocka_unit_test(a_spring_and_a_loop),   cmocka_unit_test(a_path_over_the_load),
        cmocka_unit_test(what_trim_refuses),     cmocka_unit_test(preloads_of_random_models),
        cmocka_unit_test(from_where_all_begins),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
