/* A double pendulum in space on an elastic support without mass.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The support may move in all six directions against a bushing. The pendulum gives it mass along
 * its upper rod only: what is left, five of the six directions, follows from the bushing's springs
 * and dampers by equations of first order. Energy that leaves the pendulum becomes heat in the
 * bushing:
 *
 *   kinetic + potential energy + integral of the dissipated power = constant.
 *
 * The stiffer the support, the closer the motion is to that on a rigid one, as 1 / stiffness. */
#include <mbsrank/simulation.h>

#include "run.h"

#include <math.h>

static const double rod = 0.5, arm = 0.2, weight = 1.0, T = 2.0; /* m, m, kg, s */
enum { SAMPLES = 5000 };

/* stiffness 0: a rigid support. */
static mbsr_model *pendulum(double stiffness)
{
    const double x[3] = {1.0, 0.0, 0.0}, y[3] = {0.0, 1.0, 0.0};
    const mbsr_frame mounted = mbsr_frame_at(arm, 0.0, 0.0), top = mbsr_frame_at(0.0, 0.0, rod);
    double c[6], d[6];
    for (int k = 0; k < 6; ++k) {
        c[k] = stiffness * (k < 3 ? 0.1 : 1.0);
        d[k] = 0.01 * c[k]; /* relaxes in 10 ms */
    }
    mbsr_model *m = new_model();
    int body = add_body(m, "support", MBSR_GROUND,
                        stiffness > 0.0 ? mbsr_joint_free(NULL, NULL) : mbsr_joint_weld(NULL, NULL),
                        mbsr_inertia_zero());
    if (stiffness > 0.0) add_force(m, mbsr_force_bushing(MBSR_GROUND, NULL, body, NULL, c, d));
    body = add_body(m, "upper rod", body, mbsr_joint_universal(&mounted, &top, y, x),
                    mbsr_inertia_particle(weight));
    add_body(m, "lower rod", body, mbsr_joint_universal(NULL, &top, y, x),
             mbsr_inertia_particle(weight));
    add_force(m, mbsr_force_gravity(0.0, 0.0, -9.81));
    return m;
}

/* Swings until T; *tip: the lower mass. Returns what is missing in the balance of energy, J. */
static double swing(double stiffness, double tip[3])
{
    const double angles[4] = {1.0, 0.3, 0.5, -0.2}, zero[10] = {0.0};
    double q[11] = {1.0}, p[MBSR_POSE_SIZE], heat = 0.0, defect = 0.0;
    for (int k = 0; k < 4; ++k) q[k + (stiffness > 0.0 ? 7 : 0)] = angles[k];
    mbsr_simulation r = run_start(pendulum(stiffness), q, zero, 1e-8);
    double before = run_dissipation(&r);
    const double begin = run_energy(&r);
    for (int k = 1; k <= SAMPLES; ++k) {
        run_to(&r, T * k / SAMPLES);
        const double power = run_dissipation(&r);
        heat += 0.5 * T / SAMPLES * (before + power);
        before = power;
        defect = fmax(defect, fabs(run_energy(&r) + heat - begin));
    }
    check(mbsr_body_pose(r.model, r.data, 2, p), mbsr_data_error(r.data));
    for (int k = 0; k < 3; ++k) tip[k] = p[MBSR_POSE_X + k];
    printf("%16g %9d %7ld   %10.6f   %+.6f   %.1e", stiffness, r.start.null_directions,
           run_steps(&r), heat, run_energy(&r) - begin, defect);
    mbsr_simulation_end(&r);
    return defect;
}

int main(void)
{
    double rigid[3], tip[3], worst, before = 0.0, ratio = 10.0;
    printf(
        "stiffness [N/m]  massless   steps   heat [J]   energy change   defect   off rigid [m]\n");
    worst = swing(0.0, rigid);
    printf("\n");
    for (double stiffness = 1e4; stiffness < 2e6; stiffness *= 10.0) {
        worst = fmax(worst, swing(stiffness, tip));
        const double off = hypot(hypot(tip[0] - rigid[0], tip[1] - rigid[1]), tip[2] - rigid[2]);
        printf("   %.1e\n", off);
        if (before > 0.0) ratio = fmin(ratio, before / off);
        before = off;
    }
    return worst < 2e-4 && ratio > 5.0 ? 0 : 1;
}
