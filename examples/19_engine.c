/* A slider-crank engine whose connecting rod has no mass.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The loop ground - crank - rod - piston - ground is cut at the piston's pin, a closure. The rod
 * without mass is a direction of the tree that moves no mass; the loop holds it, so that nothing
 * has to be invented for it. With the crank at angle a the piston stands at
 *
 *   x = r cos(a) + sqrt(l^2 - r^2 sin^2(a)),
 *
 * and the rod's force, along the rod because it has no mass, follows from the piston's acceleration
 * and the gas: both are held against the run. Gas pushes on the piston in every second half turn, a
 * load brakes the flywheel. engine.csv has the motion for engine.gp; then the pin is given the
 * elasticity of steel, 1e9 N/m, at no cost in steps. */
#include <mbsrank/simulation.h>

#include "run.h"

#include <math.h>

enum { SAMPLES = 1000 };
static const double r = 0.04, l = 0.14, piston = 0.4, flywheel = 0.02,
                    T = 0.3;                   /* m, kg, kg m^2, s */
static const double gas = 8000.0, load = 0.05; /* N at the upper dead centre; N m s */

static double push(double x)
{
    const double top = l + r, gap = 0.01 + top - x; /* polytropic expansion, 1 cm of dead space */
    return gas * pow(0.01 / gap, 1.3);
}

/* On the piston, whose coordinate it reads: only while the crank goes down, sin(a) > 0. */
static int ignite(const mbsr_force_args *args)
{
    const double a = args->body[0].q[0];
    if (sin(a) > 0.0) args->body[1].tau[0] -= push(args->body[1].q[0]) * sin(a) * sin(a);
    return MBSR_OK;
}

static const mbsr_force_table ignition = {.version = MBSR_FORCE_TABLE_VERSION,
                                          .flags = MBSR_FORCE_JOINT_ONLY,
                                          .name = "gas",
                                          .evaluate = ignite};

static mbsr_model *engine(double stiffness)
{
    const mbsr_planar_frame at = {0.0, 0.0, 0.0}, pin_of_crank = {r, 0.0, 0.0};
    const double end[3] = {l, 0.0, 0.0}, centre[2] = {0.0, 0.0};
    mbsr_model *m = new_model();
    const int crank = add_body(m, "crank", MBSR_GROUND, mbsr_joint_planar_revolute(at, at),
                               mbsr_inertia_planar(1.0, centre, flywheel));
    const int rod = add_body(m, "rod", crank, mbsr_joint_planar_revolute(pin_of_crank, at),
                             mbsr_inertia_zero());
    const int slider = add_body(m, "piston", MBSR_GROUND, mbsr_joint_planar_prismatic(at, at),
                                mbsr_inertia_planar(piston, centre, 0.0));
    mbsr_closure_def pin = mbsr_closure_ball(rod, end, slider, NULL);
    pin.name = "piston pin";
    for (int k = 0; k < 2; ++k) {
        pin.stiffness[k] = stiffness;
        pin.damping[k] = 1e-4 * stiffness;
    }
    check(mbsr_model_add_closure(m, &pin, NULL), mbsr_model_error(m));
    add_force(m, mbsr_force_custom(&ignition, 2, (const int[2]){crank, slider}, NULL));
    add_force(m, mbsr_force_joint_spring(crank, 0, 0.0, load, 0.0));
    return m;
}

int main(void)
{
    const double q[3] = {0.5, -0.6, 0.17}, u[3] = {150.0, 0.0, 0.0};
    double off = 0.0, slant = 0.0, most = 0.0;
    mbsr_simulation s = run_start(engine(0.0), q, u, 1e-7);
    FILE *file = csv("engine.csv");
    printf("t [s]   crank [rev]   speed [rad/s]   piston [mm]   force of the rod [N]\n");
    for (int k = 0; k <= SAMPLES; ++k) {
        if (k) run_to(&s, T * k / SAMPLES);
        /* lambda of the pin: along x and y, the force on the rod */
        const double a = s.q[0], *pin = s.lambda, rod = a + s.q[1];
        double bearing[3]; /* what the crank's bearing exerts: x, y, moment */
        check(mbsr_joint_reaction(s.model, s.data, 0, bearing), mbsr_data_error(s.data));
        most = fmax(most, hypot(bearing[0], bearing[1]));
        const double x = r * cos(a) + sqrt(l * l - r * r * sin(a) * sin(a));
        const double along = -(pin[0] * cos(rod) + pin[1] * sin(rod)),
                     across = pin[1] * cos(rod) - pin[0] * sin(rod);
        off = fmax(off, fabs(s.q[2] - x));
        slant = fmax(slant, fabs(across) / (1.0 + fabs(along)));
        fprintf(file, "%g,%g,%g,%g,%g\n", s.t, a, s.u[0], s.q[2], along);
        if (k % (SAMPLES / 10) == 0)
            printf("%5.3f   %11.4f   %13.3f   %11.4f   %12.2f\n", s.t, a / (2.0 * acos(-1.0)),
                   s.u[0], 1e3 * s.q[2], along);
    }
    fclose(file);
    printf("piston off its closed form by %.1e m at most, force across the rod %.1e of that along "
           "it\n",
           off, slant);
    printf("the crank's bearing holds %.0f N at most\n", most);
    printf("%d directions without mass that no loop holds; %ld steps\n", s.start.null_directions,
           run_steps(&s));
    const double end = s.q[0];
    mbsr_simulation_end(&s);
    mbsr_simulation elastic = run_start(engine(1e9), q, u, 1e-7);
    run_to(&elastic, T);
    printf("with an elastic pin, 1e9 N/m: %ld steps, crank %.1e rad off\n", run_steps(&elastic),
           fabs(elastic.q[0] - end));
    const double apart = fabs(elastic.q[0] - end);
    mbsr_simulation_end(&elastic);
    return off < 1e-6 && slant < 1e-2 && apart < 0.05 ? 0 : 1;
}
