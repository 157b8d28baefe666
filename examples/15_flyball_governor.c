/* Watt's governor: two balls lift a sleeve without mass.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The spindle turns with a prescribed speed w that rises from 10 to 14 rad/s. Two arms of length L,
 * each with a ball at its end, hinge on the spindle's top. A link, which is a stiff spring and
 * damper, goes from the middle of each arm to the sleeve, which slides on the spindle against a
 * spring and a dashpot. Having no mass the sleeve follows from these forces by an equation of first
 * order. At constant speed, with the arms at angle a and links of length s that pull by
 * F = c (s - s0),
 *
 *   m w^2 L^2 sin(a) cos(a) - m g L sin(a) + moment of F about the hinge = 0,
 *   2 F down / s = force of the sleeve's spring,
 *
 * solved below by Newton's method: the governor must settle there. It is released with the sleeve
 * at the first such height and the arms 0.1 rad above: the links are stretched by 1.6 cm, which is
 * 81 N in each, and pull the sleeve up. It has no inertia, only 80 N s/m of dampers against
 * 5000 N/m of links, so that it starts at full speed, and follows within 16 ms; then both go down
 * as the balls fall back. governor.csv has the motion for governor.gp. */
#include <mbsrank/simulation.h>

#include "run.h"

#include <math.h>

enum { SAMPLES = 3000 };
/* arm and link m, ball kg, link N/m and N s/m */
static const double L = 0.3, s0 = 0.16, ball = 0.5, g = 9.81, c = 5000.0, d = 20.0;
/* sleeve: N/m, N s/m, height without force m;  spindle: rad/s, end s */
static const double spring = 100.0, dashpot = 60.0, rest = -0.3, slow = 10.0, fast = 14.0, T = 6.0;

/* The spindle's angle and speed; it speeds up from 2 s to 3 s. */
static int speed(void *user, double t, double *phi, double *w, double *acceleration)
{
    const double x = fmin(fmax(t - 2.0, 0.0), 1.0), rise = fast - slow;
    (void)user;
    *phi = slow * t + rise * (pow(x, 4.0) * (2.5 - 3.0 * x + x * x) + fmax(t - 3.0, 0.0));
    *w = slow + rise * pow(x, 3.0) * (10.0 - 15.0 * x + 6.0 * x * x);
    *acceleration = rise * 30.0 * x * x * (1.0 - x) * (1.0 - x);
    return MBSR_OK;
}

static mbsr_model *governor(void)
{
    const double up[3] = {0.0, 0.0, 1.0}, y[3] = {0.0, 1.0, 0.0}, minus_y[3] = {0.0, -1.0, 0.0};
    const double middle[3] = {0.0, 0.0, -0.5 * L}, end[3] = {0.0, 0.0, -L}, centre[3] = {0.0};
    const mbsr_axis turn = {.kind = MBSR_AXIS_ROTATION, .direction = {0, 0, 1}, .driven = 1};
    const mbsr_inertia none = mbsr_inertia_zero();
    mbsr_model *m = new_model();
    const int spindle = add_body(m, "spindle", MBSR_GROUND,
                                 mbsr_joint_compound(NULL, NULL, 1, &turn, speed, NULL), none);
    const int sleeve = add_body(m, "sleeve", spindle, mbsr_joint_prismatic(NULL, NULL, up), none);
    add_force(m, mbsr_force_joint_spring(sleeve, 0, spring, dashpot, rest));
    for (int side = 0; side < 2; ++side) {
        /* positive angles swing outwards, to -x and to +x */
        const int arm =
            add_body(m, "arm", spindle, mbsr_joint_revolute(NULL, NULL, side ? minus_y : y),
                     mbsr_inertia_point_mass(ball, end));
        add_force(m, mbsr_force_point_spring(arm, middle, sleeve, centre, c, d, s0));
    }
    add_force(m, mbsr_force_gravity(0.0, 0.0, -g));
    return m;
}

/* What is out of balance with the arms at x[0] and the sleeve at height x[1]: moment and force. */
static void balance(double w, const double x[2], double out[2])
{
    /* from the arm's middle to the sleeve */
    const double in = 0.5 * L * sin(x[0]), down = -x[1] - 0.5 * L * cos(x[0]);
    const double s = hypot(in, down), pull = c * (s - s0);
    const double moment = -0.5 * L * pull * (in * cos(x[0]) + down * sin(x[0])) / s;
    out[0] = ball * L * sin(x[0]) * (w * w * L * cos(x[0]) - g) + moment;
    out[1] = 2.0 * pull * down / s - spring * (x[1] - rest);
}

/* From a guess x, Newton's method with differences. */
static void equilibrium(double w, double x[2])
{
    for (int k = 0; k < 50; ++k) {
        const double h = 1e-6, xa[2] = {x[0] + h, x[1]}, xz[2] = {x[0], x[1] + h};
        double f[2], fa[2], fz[2];
        balance(w, x, f);
        balance(w, xa, fa);
        balance(w, xz, fz);
        for (int i = 0; i < 2; ++i) fa[i] = (fa[i] - f[i]) / h, fz[i] = (fz[i] - f[i]) / h;
        const double det = fa[0] * fz[1] - fz[0] * fa[1];
        x[0] -= (fz[1] * f[0] - fz[0] * f[1]) / det;
        x[1] -= (fa[0] * f[1] - fa[1] * f[0]) / det;
    }
}

int main(void)
{
    const double degree = acos(-1.0) / 180.0;
    double x[2][2] = {{0.8, -0.2}, {1.1, -0.15}}, worst = 0.0;
    equilibrium(slow, x[0]);
    equilibrium(fast, x[1]);
    /* released with the arms, but not the sleeve, above the first equilibrium */
    const double q[3] = {x[0][1], x[0][0] + 0.1, x[0][0] + 0.1}, u[3] = {0.0};
    mbsr_simulation r = run_start(governor(), q, u, 1e-7);
    FILE *file = csv("governor.csv");
    printf("t [s]   speed [rad/s]   arms [deg]   sleeve [m]\n");
    for (int k = 0; k <= SAMPLES; ++k) {
        double phi, w, acceleration;
        if (k) run_to(&r, T * k / SAMPLES);
        speed(NULL, r.t, &phi, &w, &acceleration);
        fprintf(file, "%g,%g,%g,%g\n", r.t, w, r.q[1] / degree, r.q[0]);
        if (k % (SAMPLES / 12) == 0)
            printf("%5.2f   %13.3f   %10.4f   %10.6f\n", r.t, w, r.q[1] / degree, r.q[0]);
        if (k != SAMPLES / 3 && k != SAMPLES) continue;
        const double *y = x[k == SAMPLES];
        printf("        in equilibrium: %10.4f   %10.6f\n", y[0] / degree, y[1]);
        worst = fmax(worst, fmax(fabs(r.q[1] - y[0]), fabs(r.q[0] - y[1])));
    }
    printf("directions without mass: %d; steps: %ld\n", r.start.null_directions, run_steps(&r));
    fclose(file);
    mbsr_simulation_end(&r);
    return worst < 1e-5 ? 0 : 1;
}
