/* An arm of two links under a controller that samples at 1 kHz and holds its torques in between.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The torques jump a thousand times a second. mbsr_simulation_sample takes one period: the torques
 * set before, no step across its end. The table shows what it costs not to say so, with
 * mbsr_simulation_to: the driver finds each jump by failed error tests, or does not. Reference: the
 * same with a tolerance of 1e-11. */
#include <mbsrank/simulation.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { SAMPLES = 1000 };
static const double kp[2] = {400.0, 100.0}, kd[2] = {30.0, 8.0}; /* N m/rad, N m s/rad */

/* Runs for 1 s; writes q, returns the steps. */
static long run(double tolerance, int sampled, double q[2])
{
    const double y_axis[3] = {0, 1, 0}, middle[3] = {0, 0, -0.25};
    double held[2] = {0.0, 0.0};
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    for (int k = 0; k < 2; ++k) {
        const mbsr_frame at = mbsr_frame_at(0.0, 0.0, k ? -0.5 : 0.0);
        mbsr_simulation_add_body(&s, k ? "forearm" : "arm", k - 1,
                                 mbsr_joint_revolute(&at, NULL, y_axis),
                                 mbsr_inertia_point_mass(k ? 2.0 : 4.0, middle));
        mbsr_simulation_add_force(&s, mbsr_force_joint_applied(k, mbsr_stored_force, held + k));
    }
    mbsr_simulation_add_force(&s, mbsr_force_gravity(0.0, 0.0, -9.81));
    opt.rtol = opt.atol = tolerance;
    mbsr_simulation_start(&s, &opt, 0.0, NULL, NULL);
    for (int n = 1; n <= SAMPLES && !s.status; ++n) {
        for (int k = 0; k < 2; ++k)
            held[k] = kp[k] * (sin(3.0 * s.t + k) - s.q[k]) - kd[k] * s.u[k];
        if (sampled)
            mbsr_simulation_sample(&s, 1e-3 * n);
        else
            mbsr_simulation_to(&s, 1e-3 * n);
    }
    if (s.status) {
        fprintf(stderr, "%s\n", s.error.text);
        exit(1);
    }
    q[0] = s.q[0], q[1] = s.q[1];
    mbsr_ida_stats stats;
    mbsr_simulation_get_stats(&s, &stats);
    const long steps = stats.steps;
    mbsr_simulation_end(&s);
    return steps;
}

int main(void)
{
    double exact[2], q[2], error[2];
    long steps[2];
    run(1e-11, 1, exact);
    printf("                        steps   error of q [rad]\n");
    for (int sampled = 0; sampled < 2; ++sampled) {
        steps[sampled] = run(1e-6, sampled, q);
        error[sampled] = hypot(q[0] - exact[0], q[1] - exact[1]);
        printf("%-22s %6ld   %.1e\n", sampled ? "mbsr_simulation_sample" : "mbsr_simulation_to",
               steps[sampled], error[sampled]);
    }
    return error[1] < 1e-6 && error[1] < 0.1 * error[0] && 2 * steps[1] < 5 * SAMPLES ? 0 : 1;
}
