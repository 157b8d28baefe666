/* A drive train: a motor by its characteristic, a gear that gives and has play, a flange without
 * mass that is braked for a while, a drum; and where the power goes.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Rotor and flange turn about axes on the ground, two branches of the tree: the gear is a force
 * element between their coordinates. Characteristic and brake are tables, over speed and over time.
 * The torque of the gear is asked of the element; so are the powers, with which the sum of energy,
 * heat and work of motor and brake must stay what it was. */
#include <mbsrank/simulation.h>

#include <math.h>
#include <stdio.h>

enum { SAMPLES = 10000 };
static const double T = 2.0;

static int add_shaft(mbsr_simulation *s, const char *name, int parent, double moment)
{
    const double x[3] = {1, 0, 0}, centre[3] = {0}, tensor[6] = {moment, moment, moment, 0, 0, 0};
    return mbsr_simulation_add_body(s, name, parent, mbsr_joint_revolute(NULL, NULL, x),
                                    moment > 0.0 ? mbsr_inertia_rigid(moment, centre, tensor)
                                                 : mbsr_inertia_zero());
}

/* Torque of an element on the joint of a body, place 0 in its list. */
static double torque_of(mbsr_simulation *s, int force)
{
    double tau = 0.0;
    mbsr_simulation_check(s, mbsr_force_load(s->model, s->data, force, 0, NULL, &tau));
    return tau;
}

int main(void)
{
    const double speed[4] = {0, 100, 150, 300}, torque[4] = {2, 2, 1.5, 0}; /* rad/s, N m */
    const double time[5] = {0, 1.0, 1.1, 1.5, 1.6}, load[5] = {0, 0, -30, -30, 0};
    const mbsr_gear with = {.ratio = 10, .stiffness = 50, .damping = 0.05, .backlash = 0.01};
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.rtol = opt.atol = 1e-8;
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    mbsr_table *curve = mbsr_simulation_add_table(&s, MBSR_TABLE_LINEAR, 4, speed, torque);
    mbsr_table *braked = mbsr_simulation_add_table(&s, MBSR_TABLE_LINEAR, 5, time, load);
    const int rotor = add_shaft(&s, "rotor", MBSR_GROUND, 1e-3); /* kg m^2 */
    const int flange = add_shaft(&s, "flange", MBSR_GROUND, 0.0);
    const int drum = add_shaft(&s, "drum", flange, 0.4);
    const int motor = mbsr_simulation_add_force(&s, mbsr_force_joint_curve(rotor, 0, curve));
    const int gear = mbsr_simulation_add_force(&s, mbsr_force_gear(rotor, 0, flange, 0, &with));
    mbsr_simulation_add_force(&s, mbsr_force_joint_spring(drum, 0, 3000.0, 5.0, 0.0));
    mbsr_simulation_add_force(&s, mbsr_force_joint_friction(flange, 0, 0.5, 0.1));
    const int brake =
        mbsr_simulation_add_force(&s, mbsr_force_joint_applied(flange, mbsr_table_force, braked));
    mbsr_simulation_start(&s, &opt, 0.0, NULL, NULL);

    double work = 0.0, before = 0.0, worst = 0.0;
    printf("t [s]   rotor [rad/s]   drum [rad/s]   torque of the gear [N m]   energy [J]\n");
    for (int k = 1; k <= SAMPLES && !mbsr_simulation_to(&s, T * k / SAMPLES); ++k) {
        double kinetic = 0.0, potential = 0.0, heat = 0.0;
        mbsr_simulation_check(&s, mbsr_energy(s.model, s.data, &kinetic, &potential));
        mbsr_simulation_check(&s, mbsr_dissipation(s.model, s.data, &heat));
        const double power =
            torque_of(&s, motor) * s.u[rotor] + torque_of(&s, brake) * s.u[flange] - heat;
        work += 0.5 * T / SAMPLES * (before + power);
        before = power;
        worst = fmax(worst, fabs(work - kinetic - potential));
        if (k % (SAMPLES / 10) == 0)
            printf("%5.2f   %13.3f   %12.4f   %24.4f   %10.4f\n", s.t, s.u[rotor],
                   s.u[flange] + s.u[drum], -torque_of(&s, gear), kinetic + potential);
    }
    if (s.status) fprintf(stderr, "%s\n", s.error.text);
    mbsr_ida_stats stats;
    mbsr_simulation_get_stats(&s, &stats);
    printf("%ld steps; energy, heat and work add up to %.1e J\n", stats.steps, worst);
    const int failed = s.status || worst > 1e-2;
    mbsr_simulation_end(&s);
    return failed;
}
