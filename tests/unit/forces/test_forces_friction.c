/* Friction at points, of bearings and of tyres, and bushings in the plane: the laws by hand, loads
 * that change in time, and Newton systems with such elements across the tree.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "parts.h"
#include "newton_along.h"

#include <mbsrank/verify.h>

static mbsr_force_body seen(const mbsr_force_def *def, test_part *part, int k)
{
    return (mbsr_force_body){.id = def->body[k],
                             .space = part->space,
                             .d = part->d,
                             .np = part->np,
                             .p = part->p,
                             .V = part->V,
                             .f = part->f};
}

/* What an element between two parts adds to their f, at the time t. */
static void ask_at(const mbsr_force_def *def, test_part part[2], double t)
{
    mbsr_force_body body[2];
    for (int k = 0; k < 2; ++k) {
        memset(part[k].f, 0, sizeof part[k].f);
        body[k] = seen(def, part + k, k);
    }
    const mbsr_force_args args = {.force = def, .t = t, .bodies = 2, .body = body};
    assert_int_equal(def->table->evaluate(&args), 0);
}

/* ---- friction at a point ---- */

/* A block at (1, 2, 3) that slides with (0.3, -0.4, 1.2) and does not turn. */
static void block(test_part part[2])
{
    static const double x[3] = {1.0, 2.0, 3.0}, v[3] = {0.3, -0.4, 1.2};
    part[0] = test_part_make(MBSR_SPACE_SPATIAL);
    part[1] = test_part_make(MBSR_SPACE_FIXED);
    memcpy(part[0].p + 9, x, sizeof x);
    memcpy(part[0].V + 3, v, sizeof v);
}

static void friction_at_a_point_is_as_calculated_by_hand(void **state)
{
    (void)state;
    test_part part[2];
    block(part);
    const double *f = part[0].f, tip[3] = {0.0, 0.0, -0.5};
    mbsr_friction law = {.coefficient = 0.5, .viscous = 0.2, .slip = 0.9, .load = 20.0};
    mbsr_force_def def = mbsr_force_point_friction(0, tip, MBSR_GROUND, &law);
    ask_at(&def, part, 0.0);
    /* |v| = 1.3 */
    double drag = 10.0 / sqrt(1.69 + 0.81) + 0.2;
    for (int k = 0; k < 3; ++k) assert_close(f[3 + k], -drag * part[0].V[3 + k], 1e-13);
    assert_close(f[0], 0.5 * f[4], 1e-13); /* tip x force */
    assert_close(f[1], -0.5 * f[3], 1e-13);
    /* along the floor, of any length: |v| = 0.5 */
    law.normal[2] = 7.0;
    def = mbsr_force_point_friction(0, NULL, MBSR_GROUND, &law);
    ask_at(&def, part, 0.0);
    drag = 10.0 / sqrt(0.25 + 0.81) + 0.2;
    assert_close(f[3], -0.3 * drag, 1e-13);
    assert_close(f[4], 0.4 * drag, 1e-13);
    assert_close(f[5], 0.0, 1e-15);
    assert_close(test_largest(3, f), 0.0, 0.0);
}

/* The side force of a wheel that rolls freely along z, its axle along x. */
static void side_forces_grow_with_the_slip_angle(void **state)
{
    (void)state;
    test_part part[2];
    block(part);
    part[0].V[4] = 0.0;
    const double *f = part[0].f;
    mbsr_friction law = {
        .coefficient = 0.8, .slip = 1e-3, .creep = 0.1, .load = 1000.0, .axle = {-2.0, 0.0, 0.0}};
    const mbsr_force_def def = mbsr_force_point_friction(0, NULL, MBSR_GROUND, &law);
    ask_at(&def, part, 0.0);
    assert_close(f[3], -800.0 * 0.3 / sqrt(0.09 + 1e-6 + 0.0144), 1e-11);
    assert_close(f[4], 0.0, 1e-13);
    assert_close(f[5], 0.0, 1e-13);
    /* at small angles by load coefficient / creep, whatever the speed */
    for (double speed = 10.0; speed < 100.0; speed *= 2.0) {
        part[0].V[3] = 1e-4 * speed;
        part[0].V[5] = speed;
        ask_at(&def, part, 0.0);
        assert_close(f[3], -0.8, 2e-6);
    }
    part[0].V[5] = 0.0; /* standing, it slides as anything else does */
    part[0].V[3] = 0.3;
    ask_at(&def, part, 0.0);
    assert_close(f[3], -800.0 * 0.3 / hypot(0.3, 1e-3), 1e-11);
}

static int wave(void *user, double t, int n, double *value)
{
    assert_int_equal(n, 1);
    value[0] = 10.0 * sin(t);
    return t > 50.0 ? *(const int *)user : 0;
}

static void loads_may_change_in_time(void **state)
{
    (void)state;
    static const double t[3] = {0.0, 1.0, 2.0}, N[3] = {4.0, 8.0, -8.0};
    const int failure = 17;
    test_part part[2];
    block(part);
    mbsr_table *table = NULL;
    mbsr_table_def def = mbsr_default_table_def();
    def.points = 3;
    def.x = t;
    def.value = N;
    def.kind = MBSR_TABLE_LINEAR;
    assert_int_equal(mbsr_table_create(&def, &table, NULL), MBSR_OK);
    mbsr_friction law = {.coefficient = 0.5, .viscous = 0.2, .slip = 0.9, .load = 55.0};
    law.function = wave;
    law.user = (void *)(uintptr_t)&failure;
    const mbsr_force_def by_function = mbsr_force_point_friction(0, NULL, MBSR_GROUND, &law);
    law.table = table;
    const mbsr_force_def by_table = mbsr_force_point_friction(0, NULL, MBSR_GROUND, &law);
    const double root = sqrt(1.69 + 0.81);
    ask_at(&by_function, part, 0.7);
    assert_close(part[0].f[3], -0.3 * (5.0 * sin(0.7) / root + 0.2), 1e-13);
    ask_at(&by_function, part, 4.0); /* lifted off */
    assert_close(part[0].f[3], -0.3 * 0.2, 1e-14);
    ask_at(&by_table, part, 0.5);
    assert_close(part[0].f[3], -0.3 * (3.0 / root + 0.2), 1e-13);
    ask_at(&by_table, part, 1.75);
    assert_close(part[0].f[3], -0.3 * 0.2, 1e-14);

    const mbsr_force_body body[2] = {seen(&by_function, part, 0), seen(&by_function, part + 1, 1)};
    const mbsr_force_args late = {.force = &by_function, .t = 60.0, .bodies = 2, .body = body};
    double power = 0.0;
    assert_int_equal(by_function.table->evaluate(&late), failure);
    assert_int_equal(by_function.table->dissipation(&late, &power), failure);
    assert_close(power, 0.0, 0.0);
    mbsr_table_destroy(table);

    /* the driver is told of the kinks, and the wrong table is refused */
    static const double two[6] = {0};
    def.columns = 2;
    def.value = two;
    assert_int_equal(mbsr_table_create(&def, &table, NULL), MBSR_OK);
    law.table = table;
    for (int k = 0; k < 2; ++k) {
        mbsr_model *m = NULL;
        mbsr_body_def ball = mbsr_default_body_def();
        ball.joint = mbsr_joint_free(NULL, NULL);
        assert_int_equal(mbsr_model_create(NULL, &m, NULL), MBSR_OK);
        assert_ok(mbsr_model_add_body(m, &ball, NULL), mbsr_model_error(m));
        const mbsr_force_def force = mbsr_force_point_friction(0, NULL, MBSR_GROUND, &law);
        assert_ok(mbsr_model_add_force(m, &force, NULL), mbsr_model_error(m));
        if (k == 0) {
            assert_refused(mbsr_model_finish(m), mbsr_model_error(m), MBSR_ERR_VALUE, MBSR_NONE, 0,
                           "force 0|point friction|2 columns, must have 1");
            mbsr_table_destroy(table);
            def.columns = 1;
            def.value = N;
            assert_int_equal(mbsr_table_create(&def, &table, NULL), MBSR_OK);
            law.table = table;
        } else {
            mbsr_kink next;
            assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
            assert_int_equal(mbsr_model_kink(m, 0.5, 1, &next), MBSR_OK);
            assert_close(next.t, 1.0, 0.0);
        }
        mbsr_model_destroy(m);
    }
    mbsr_table_destroy(table);
}

/* ---- bearings ---- */

static void bearings_rub_about_their_axis(void **state)
{
    (void)state;
    static const double omega[3] = {1.0, 2.0, 0.5};
    test_part part[2] = {test_part_make(MBSR_SPACE_SPATIAL), test_part_make(MBSR_SPACE_PLANAR)};
    memcpy(part[0].V, omega, sizeof omega);
    part[1].V[2] = -0.25;
    const double *f = part[0].f;
    mbsr_bearing law = {.torque = 3.0, .viscous = 0.5, .slip = 0.2, .axis = {0.0, 6.0, 8.0}};
    mbsr_force_def def = mbsr_force_bearing_friction(0, 1, &law);
    ask_at(&def, part, 0.0);
    /* omega about the axis: 0.6 * 2 + 0.8 * (0.5 + 0.25) */
    const double torque = 3.0 * 1.8 / hypot(1.8, 0.2) + 0.5 * 1.8;
    assert_close(f[0], 0.0, 1e-15);
    assert_close(f[1], -0.6 * torque, 1e-13);
    assert_close(f[2], -0.8 * torque, 1e-13);
    assert_close(part[1].f[2], 0.8 * torque, 1e-13);
    /* a clutch that closes in time */
    law.function = wave;
    def = mbsr_force_bearing_friction(0, 1, &law);
    ask_at(&def, part, 0.3);
    assert_close(f[1], -0.6 * (10.0 * sin(0.3) * 1.8 / hypot(1.8, 0.2) + 0.5 * 1.8), 1e-13);
    ask_at(&def, part, 4.0); /* open */
    assert_close(f[1], -0.6 * 0.5 * 1.8, 1e-14);
    def = mbsr_force_bearing_friction(0, 1, &(mbsr_bearing){.torque = 3.0, .slip = 0.2});
    ask_at(&def, part, 0.0);
    const double drag = 3.0 / sqrt(1.0 + 4.0 + 0.5625 + 0.04);
    assert_close(f[0], -1.0 * drag, 1e-13);
    assert_close(f[1], -2.0 * drag, 1e-13);
    assert_close(f[2], -0.75 * drag, 1e-13);
    assert_close(test_largest(3, f + 3), 0.0, 0.0);
}

/* ---- tyres ---- */

/* A wheel of radius 0.4 and depth 0.1 that travels along x at v and turns about y, in space, or the
 * same in the plane x, y. */
static void tyres_push_by_their_slip(void **state)
{
    (void)state;
    const double v = 10.0, N = 1000.0, mu = 0.9;
    for (int planar = 0; planar < 2; ++planar) {
        for (double ratio = -0.2; ratio < 0.25; ratio += 0.1) {
            mbsr_contact tyre = {.radius = 0.4,
                                 .stiffness = 1e4,
                                 .exponent = 1.0,
                                 .friction = mu,
                                 .slip = 0.01,
                                 .creep = 0.08};
            test_part part[2] = {test_part_make(planar ? MBSR_SPACE_PLANAR : MBSR_SPACE_SPATIAL),
                                 test_part_make(MBSR_SPACE_FIXED)};
            const double spin = v * (1.0 + ratio) / 0.4; /* rolling without slip: v / 0.4 */
            tyre.normal[planar ? 1 : 2] = 2.0;
            part[0].p[planar ? 1 : 11] = 0.3;
            part[0].V[planar ? 0 : 3] = v;
            part[0].V[planar ? 2 : 1] = planar ? -spin : spin;
            const mbsr_force_def def = mbsr_force_contact(0, MBSR_GROUND, &tyre);
            ask_at(&def, part, 0.0);
            const double sliding = -v * ratio,
                         force = -mu * N * sliding / sqrt(sliding * sliding + 1e-4 + 0.64);
            const double *f = part[0].f;
            assert_close(f[planar ? 0 : 3], force, 1e-10 * N);
            assert_close(f[planar ? 1 : 5], N, 1e-10 * N);
            /* the lever is from the origin to the deepest point */
            assert_close(f[planar ? 2 : 1], planar ? 0.4 * force : -0.4 * force, 1e-10 * N);
        }
    }
}

/* ---- bushings in the plane ---- */

static void bushings_in_the_plane_couple_their_coordinates(void **state)
{
    (void)state;
    static const double K[9] = {10, 2, 3, 2, 20, 4, 3, 4, 30},
                        D[9] = {1, 0, 0, 0, 2, 0.5, 0, 0.5, 3};
    const mbsr_planar_frame o = {0, 0, 0};
    test_part part[2] = {test_part_make(MBSR_SPACE_FIXED), test_part_make(MBSR_SPACE_PLANAR)};
    const double e[3] = {0.1, -0.2, 7.0}, rate[3] = {0.4, 0.5, -0.6};
    memcpy(part[1].p, e, sizeof e);
    memcpy(part[1].V, rate, sizeof rate);
    const mbsr_force_def def = mbsr_force_planar_bushing(MBSR_GROUND, o, 0, o, K, D);
    ask_at(&def, part, 0.0);
    for (int k = 0; k < 3; ++k) {
        double sum = 0.0;
        for (int l = 0; l < 3; ++l) sum += K[3 * l + k] * e[l] + D[3 * l + k] * rate[l];
        assert_close(part[1].f[k], -sum, 1e-12);
    }
}

/* With diagonal matrices it is the bushing in space, of bodies that stay in the plane. */
static void bushings_in_the_plane_are_those_in_space(void **state)
{
    (void)state;
    static const double z[3] = {0, 0, 1};
    test_rng rng = test_seed(8);
    for (int round = 0; round < 20; ++round) {
        test_part flat[2], space[2];
        mbsr_planar_frame at[2];
        mbsr_frame in_space[2];
        double stiffness[6] = {0}, damping[6] = {0}, K[9] = {0}, D[9] = {0};
        static const int entry[3] = {3, 4, 2};
        for (int k = 0; k < 3; ++k) {
            stiffness[entry[k]] = K[4 * k] = 2.0 + test_uniform(&rng);
            damping[entry[k]] = D[4 * k] = 2.0 + test_uniform(&rng);
        }
        for (int k = 0; k < 2; ++k) {
            flat[k] = test_part_random(MBSR_SPACE_PLANAR, &rng);
            double place[2];
            test_fill(&rng, 2, place);
            at[k] = (mbsr_planar_frame){place[0], place[1], 0.5 * k};
            const double x[3] = {at[k].x, at[k].y, 0.0};
            in_space[k] = mbsr_frame_rotated(x, z, at[k].angle);
            space[k] = test_part_make(MBSR_SPACE_SPATIAL);
            const mbsr_frame R = mbsr_frame_rotated(NULL, z, flat[k].p[2]);
            memcpy(space[k].p, R.R, sizeof R.R);
            memcpy(space[k].p + 9, flat[k].p, 2 * sizeof(double));
            memcpy(space[k].V + 3, flat[k].V, 2 * sizeof(double));
            space[k].V[2] = flat[k].V[2];
        }
        const mbsr_force_def a = mbsr_force_planar_bushing(0, at[0], 1, at[1], K, D),
                             b = mbsr_force_bushing(0, in_space, 1, in_space + 1, stiffness,
                                                    damping);
        ask_at(&a, flat, 0.0);
        ask_at(&b, space, 0.0);
        for (int k = 0; k < 2; ++k) {
            for (int l = 0; l < 3; ++l)
                assert_close(flat[k].f[l], space[k].f[l < 2 ? 3 + l : 2], 1e-12);
        }
        assert_close(test_value(&a, flat, 2, TEST_ENERGY), test_value(&b, space, 2, TEST_ENERGY),
                     1e-12);
        assert_close(test_value(&a, flat, 2, TEST_DISSIPATION),
                     test_value(&b, space, 2, TEST_DISSIPATION), 1e-12);
    }
}

/* ---- in models ---- */

enum { NU = 7, SIZE = 3 * NU };

static mbsr_model *machine(void)
{
    static const double y[3] = {0, 1, 0}, x[3] = {1, 0, 0}, tip[3] = {0.1, 0.2, -0.5},
                        K[9] = {10, 2, 3, 2, 20, 4, 3, 4, 30};
    const mbsr_planar_frame o = {0, 0, 0}, p = {0.3, 0.1, 0.7};
    const mbsr_friction rub = {.coefficient = 0.6, .viscous = 0.3, .slip = 0.2, .load = 9.0},
                        wheel = {.coefficient = 0.6,
                                 .slip = 0.2,
                                 .creep = 0.3,
                                 .load = 7.0,
                                 .axle = {0.2, 1.0, 0.0}};
    const mbsr_bearing bearing = {.torque = 2.0, .viscous = 0.1, .slip = 0.3},
                       about_y = {
                           .torque = 2.0, .viscous = 0.1, .slip = 0.3, .axis = {0.0, 1.0, 0.0}};
    const mbsr_contact tyre = {.radius = 4.0,
                               .normal = {0.1, 0.3, 1.0},
                               .stiffness = 3.0,
                               .exponent = 1.5,
                               .damping = 0.05,
                               .friction = 0.7,
                               .slip = 0.2,
                               .creep = 0.5};
    mbsr_model *m = NULL;
    assert_int_equal(mbsr_model_create(NULL, &m, NULL), MBSR_OK);
    for (int k = 0; k < 5; ++k) {
        mbsr_body_def body = mbsr_default_body_def();
        body.parent = k < 3 ? k - 1 : MBSR_GROUND;
        body.joint = k < 3   ? mbsr_joint_revolute(NULL, NULL, y)
                     : k < 4 ? mbsr_joint_prismatic(NULL, NULL, x)
                             : mbsr_joint_planar_free(o, p);
        body.inertia = k < 4 ? mbsr_inertia_point_mass(1.0 + k, tip)
                             : mbsr_inertia_planar(1.5, (double[]){0.1, 0.2}, 0.6);
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    }
    const mbsr_force_def forces[] = {
        mbsr_force_point_friction(2, tip, 3, &rub),
        mbsr_force_point_friction(4, tip, 1, &wheel),
        mbsr_force_contact(2, 3, &tyre),
        mbsr_force_contact(4, MBSR_GROUND, &tyre),
        mbsr_force_bearing_friction(1, MBSR_GROUND, &about_y),
        mbsr_force_bearing_friction(2, 4, &bearing),
        mbsr_force_axis_friction(4, MBSR_GROUND, 0, 2.0, 0.3),
        mbsr_force_planar_bushing(MBSR_GROUND, p, 4, o, K, K),
    };
    for (size_t k = 0; k < sizeof forces / sizeof forces[0]; ++k)
        assert_ok(mbsr_model_add_force(m, forces + k, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    return m;
}

/* On a shaft that hangs on another, by the absolute speed: the torque on the second acts on both.
 */
static void a_bearing_on_the_ground_sees_the_sum_of_the_speeds(void **state)
{
    (void)state;
    const double q[NU] = {0.3, -0.4, 0.9, 0.25, 0.1, 0.2, 0.3},
                 u[NU] = {1.5, -0.7, 0.4, -0.3, 0.5, 0.2, -0.6};
    mbsr_model *m = machine();
    mbsr_data *d = NULL;
    double f[6];
    assert_int_equal(mbsr_data_create(m, &d, NULL), MBSR_OK);
    assert_ok(mbsr_stage_positions(m, d, 0.0, q), mbsr_data_error(d));
    assert_ok(mbsr_stage_velocities(m, d, u), mbsr_data_error(d));
    assert_ok(mbsr_force_load(m, d, 4, 0, f, NULL), mbsr_data_error(d));
    assert_close(f[1], -2.0 * 0.8 / hypot(0.8, 0.3) - 0.08, 1e-13);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

/* Elements across corrected and eliminated. */
static void solve_in_both_ways(const mbsr_model *m, mbsr_data *d, const double y[SIZE],
                               const double yp[SIZE], const double r[SIZE])
{
    const double c = 30.0;
    static const mbsr_newton_method methods[] = {MBSR_NEWTON_CORRECTED, MBSR_NEWTON_ELIMINATED};
    for (int way = 0; way < 2; ++way) {
        mbsr_newton_opt opt = mbsr_default_newton_opt();
        mbsr_newton *newton = NULL;
        mbsr_newton_info info;
        double delta[SIZE];
        opt.method = methods[way];
        assert_int_equal(mbsr_newton_create(m, MBSR_DAE_MOMENTUM, &opt, &newton, NULL), MBSR_OK);
        assert_ok(mbsr_newton_factor(newton, d, 0.0, y, yp, c), mbsr_newton_error(newton));
        assert_int_equal(mbsr_newton_get_info(newton, &info), MBSR_OK);
        assert_int_equal(info.method, methods[way]);
        assert_true(info.exact && (info.rank > 0) == (way == 0));
        assert_ok(mbsr_newton_solve(newton, r, delta), mbsr_newton_error(newton));
        test_newton_along(m, d, 0.0, y, yp, c, r, delta);
        mbsr_newton_destroy(newton);
    }
}

static void derivatives_serve_newton_systems(void **state)
{
    (void)state;
    const double q[NU] = {0.3, -0.4, 0.9, 0.25, 0.1, 0.2, 0.3},
                 u[NU] = {1.5, -0.7, 0.4, -0.3, 0.5, 0.2, -0.6};
    mbsr_model *m = machine();
    mbsr_data *d = NULL;
    double y[SIZE], yp[SIZE], r[SIZE];
    assert_int_equal(mbsr_data_create(m, &d, NULL), MBSR_OK);
    assert_ok(mbsr_stage_positions(m, d, 0.0, q), mbsr_data_error(d));
    assert_ok(mbsr_stage_velocities(m, d, u), mbsr_data_error(d));
    for (int k = 0; k < mbsr_model_forces(m); ++k) {
        mbsr_force_errors errors;
        double heat = 0.0;
        assert_ok(mbsr_force_verify(m, d, k, &errors), mbsr_data_error(d));
        assert_less(errors.largest, 1e-7);
        assert_ok(mbsr_force_power(m, d, k, NULL, &heat), mbsr_data_error(d));
        assert_less(1e-3, heat);
    }
    assert_ok(mbsr_dae_pack(m, d, MBSR_DAE_MOMENTUM, 0.0, q, u, y), mbsr_data_error(d));
    for (int k = 0; k < SIZE; ++k) yp[k] = 0.1 * k, r[k] = sin(k + 1.0);
    solve_in_both_ways(m, d, y, yp, r);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(friction_at_a_point_is_as_calculated_by_hand),
        cmocka_unit_test(side_forces_grow_with_the_slip_angle),
        cmocka_unit_test(loads_may_change_in_time),
        cmocka_unit_test(bearings_rub_about_their_axis),
        cmocka_unit_test(tyres_push_by_their_slip),
        cmocka_unit_test(bushings_in_the_plane_couple_their_coordinates),
        cmocka_unit_test(bushings_in_the_plane_are_those_in_space),
        cmocka_unit_test(a_bearing_on_the_ground_sees_the_sum_of_the_speeds),
        cmocka_unit_test(derivatives_serve_newton_systems),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
