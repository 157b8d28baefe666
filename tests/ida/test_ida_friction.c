/* Runs with friction under a load, with tyres and with bearings, against solutions found by hand or
 * by equations written out here.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"

#include <mbsrank/simulation.h>

static mbsr_ida_opt fine(void)
{
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.rtol = opt.atol = 1e-9;
    return opt;
}

/* v' = -g v / sqrt(v^2 + s^2):  sqrt(v^2 + s^2) - s asinh(s / v) falls by g t. */
static double fall(double v, double s)
{
    return hypot(v, s) - s * asinh(s / v);
}

/* A slider under its load, and a shaft that hangs on another and rubs on the ground. */
static void rubbing_bodies_slow_down_as_integrated_by_hand(void **state)
{
    (void)state;
    static const double x[3] = {1, 0, 0};
    const double mass = 2.0, inertia = 0.4, s = 0.05, u0[2] = {2.0, -3.0};
    const mbsr_ida_opt opt = fine();
    mbsr_simulation run = mbsr_simulation_begin(NULL);
    mbsr_simulation_add_body(&run, "slider", MBSR_GROUND, mbsr_joint_prismatic(NULL, NULL, x),
                             mbsr_inertia_particle(mass));
    mbsr_simulation_add_body(
        &run, "shaft", 0, mbsr_joint_revolute(NULL, NULL, x),
        mbsr_inertia_rigid(mass, (double[3]){0}, (double[6]){inertia, 1.0, 1.0, 0, 0, 0}));
    mbsr_simulation_add_force(
        &run,
        mbsr_force_point_friction(
            0, NULL, MBSR_GROUND,
            &(mbsr_friction){.coefficient = 0.3, .load = 40.0, .slip = s, .normal = {0, 0, 1}}));
    mbsr_simulation_add_force(
        &run, mbsr_force_bearing_friction(
                  1, MBSR_GROUND, &(mbsr_bearing){.torque = 0.6, .slip = s, .axis = {-2, 0, 0}}));
    mbsr_simulation_start(&run, &opt, 0.0, NULL, u0);
    for (int k = 1; k <= 8; ++k) {
        double heat = 0.0, kinetic = 0.0;
        const double t = 0.2 * k, g[2] = {12.0 / (2.0 * mass), 0.6 / inertia};
        mbsr_simulation_to(&run, t);
        assert_ok(run.status, &run.error);
        for (int l = 0; l < 2; ++l) {
            const double v = fabs(run.u[l]), off = fall(v, s) - fall(fabs(u0[l]), s) + g[l] * t;
            assert_close(off * v / hypot(v, s), 0.0, 1e-6); /* of the velocity */
        }
        assert_ok(mbsr_dissipation(run.model, run.data, &heat), mbsr_data_error(run.data));
        assert_ok(mbsr_energy(run.model, run.data, &kinetic, NULL), mbsr_data_error(run.data));
        assert_close(heat,
                     12.0 * run.u[0] * run.u[0] / hypot(run.u[0], s) +
                         0.6 * run.u[1] * run.u[1] / hypot(run.u[1], s),
                     1e-12);
        assert_close(kinetic, mass * run.u[0] * run.u[0] + 0.5 * inertia * run.u[1] * run.u[1],
                     1e-12);
    }
    mbsr_simulation_end(&run);
}

/* ---- a car seen from above ---- */

typedef struct car {
    double mass, moment, front, rear, steer, coefficient, creep, slip;
} car;

/* Side force of a wheel that rolls along `angle` with the velocity v, all in the world. */
static void side_force(const car *c, double load, double angle, const double v[2], double f[2])
{
    const double n[2] = {-sin(angle), cos(angle)}, across = v[0] * n[0] + v[1] * n[1],
                 along = v[0] * n[1] - v[1] * n[0];
    const double size =
        -c->coefficient * load * across /
        sqrt(across * across + c->slip * c->slip + c->creep * c->creep * along * along);
    f[0] = size * n[0];
    f[1] = size * n[1];
}

/* z = (x, y, angle) and its rates */
static void derive(const car *c, const double z[6], double dz[6])
{
    const double L = c->front + c->rear, g = 9.81, co = cos(z[2]), si = sin(z[2]);
    const double place[2] = {c->front, -c->rear},
                 load[2] = {c->mass * g * c->rear / L, c->mass * g * c->front / L};
    for (int k = 0; k < 3; ++k) dz[k] = z[3 + k], dz[3 + k] = 0.0;
    for (int k = 0; k < 2; ++k) {
        const double v[2] = {z[3] - z[5] * place[k] * si, z[4] + z[5] * place[k] * co};
        double f[2];
        side_force(c, load[k], z[2] + (k ? 0.0 : c->steer), v, f);
        dz[3] += f[0] / c->mass;
        dz[4] += f[1] / c->mass;
        dz[5] += place[k] * (co * f[1] - si * f[0]) / c->moment;
    }
}

static void step(const car *c, double h, double z[6])
{
    static const double at[4] = {0.0, 0.5, 0.5, 1.0}, weight[4] = {1.0, 2.0, 2.0, 1.0};
    double sum[6] = {0}, dz[6] = {0}, x[6];
    for (int k = 0; k < 4; ++k) {
        for (int l = 0; l < 6; ++l) x[l] = z[l] + at[k] * h * dz[l];
        derive(c, x, dz);
        for (int l = 0; l < 6; ++l) sum[l] += weight[k] * dz[l];
    }
    for (int l = 0; l < 6; ++l) z[l] += h / 6.0 * sum[l];
}

/* Loads and stiffnesses in proportion: neutral steering, whose yaw rate is v steer / L at any
 * speed. */
static void a_car_turns_as_it_is_steered(void **state)
{
    (void)state;
    const car c = {.mass = 1200.0,
                   .moment = 1800.0,
                   .front = 1.2,
                   .rear = 1.4,
                   .steer = 0.02,
                   .coefficient = 0.9,
                   .creep = 0.08,
                   .slip = 1e-3};
    const double L = c.front + c.rear, u0[3] = {20.0, 0.0, 0.0};
    const mbsr_planar_frame o = {0, 0, 0};
    const mbsr_ida_opt opt = fine();
    mbsr_simulation run = mbsr_simulation_begin(NULL);
    mbsr_simulation_add_body(&run, "car", MBSR_GROUND, mbsr_joint_planar_free(o, o),
                             mbsr_inertia_planar(c.mass, (double[2]){0, 0}, c.moment));
    for (int k = 0; k < 2; ++k) {
        const double point[3] = {k ? -c.rear : c.front, 0, 0}, angle = k ? 0.0 : c.steer;
        const mbsr_friction wheel = {.coefficient = c.coefficient,
                                     .slip = c.slip,
                                     .creep = c.creep,
                                     .load = c.mass * 9.81 * (k ? c.front : c.rear) / L,
                                     .axle = {-sin(angle), cos(angle), 0}};
        mbsr_simulation_add_force(&run, mbsr_force_point_friction(0, point, MBSR_GROUND, &wheel));
    }
    mbsr_simulation_start(&run, &opt, 0.0, NULL, u0);
    double z[6] = {0, 0, 0, u0[0], u0[1], u0[2]};
    for (int k = 1; k <= 4; ++k) {
        for (int l = 0; l < 500; ++l) step(&c, 1e-3, z);
        mbsr_simulation_to(&run, 0.5 * k);
        assert_ok(run.status, &run.error);
        for (int l = 0; l < 3; ++l) {
            assert_close(run.q[l], z[l], 2e-6 * (1.0 + fabs(z[l])));
            assert_close(run.u[l], z[3 + l], 2e-6 * (1.0 + fabs(z[3 + l])));
        }
    }
    assert_close(run.u[2] / (hypot(run.u[0], run.u[1]) * c.steer / L), 1.0, 0.02);
    mbsr_simulation_end(&run);
}

/* A wheel on a road, driven by a torque: in the plane with x and y free, its axle pressed down by a
 * weight. At a steady slip the force is torque / radius, so the ratio of sliding to travelling is
 * known. */
static void a_driven_wheel_slips_as_its_torque_asks(void **state)
{
    (void)state;
    const double mass = 30.0, radius = 0.3, N = mass * 9.81, mu = 0.9, creep = 0.08, torque = 20.0;
    const mbsr_planar_frame o = {0, 0, 0};
    const mbsr_ida_opt opt = fine();
    mbsr_simulation run = mbsr_simulation_begin(NULL);
    const double light = 1e-4, q0[3] = {0.0, radius - N / 2e5, 0.0},
                 u0[3] = {5.0, 0.0, -5.0 / radius};
    mbsr_simulation_add_body(&run, "wheel", MBSR_GROUND, mbsr_joint_planar_free(o, o),
                             mbsr_inertia_planar(mass, (double[2]){0, 0}, light));
    mbsr_simulation_add_force(&run, mbsr_force_gravity(0.0, -9.81, 0.0));
    mbsr_simulation_add_force(&run, mbsr_force_contact(0, MBSR_GROUND,
                                                       &(mbsr_contact){.radius = radius,
                                                                       .normal = {0, 1, 0},
                                                                       .stiffness = 2e5,
                                                                       .exponent = 1.0,
                                                                       .damping = 1.0,
                                                                       .friction = mu,
                                                                       .slip = 1e-6,
                                                                       .creep = creep}));
    /* a constant torque, but for the 2e-6 N m/rad of a spring that is 1e7 rad from its rest */
    mbsr_simulation_add_force(&run, mbsr_force_joint_spring(0, 2, 1e-7 * torque, 0.0, -1e7));
    mbsr_simulation_start(&run, &opt, 0.0, q0, u0);
    mbsr_simulation_to(&run, 1.0);
    assert_ok(run.status, &run.error);
    mbsr_contact_state at;
    assert_ok(mbsr_contact_at(run.model, run.data, 1, &at), mbsr_data_error(run.data));
    /* the force acts where the wheel is deepest, a radius from its centre */
    const double force = torque / radius, share = force / (mu * N);
    /* share = s / sqrt(s^2 + creep^2) with s = sliding / travelling */
    const double expected = creep * share / sqrt(1.0 - share * share);
    assert_close(at.normal_force, N, 1e-3 * N);
    assert_close(at.friction[0], force, 1e-3 * force);
    assert_close(-at.sliding[0] / run.u[0], expected, 2e-3 * expected);
    assert_close(run.u[0], 5.0 + force / mass, 1e-2);
    mbsr_simulation_end(&run);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rubbing_bodies_slow_down_as_integrated_by_hand),
        cmocka_unit_test(a_car_turns_as_it_is_steered),
        cmocka_unit_test(a_driven_wheel_slips_as_its_torque_asks),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
