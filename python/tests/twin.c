/* A run of a chain whose last body has no mass, as test_driver.py makes it: all numbers in
 * hexadecimal. SPDX-License-Identifier: BSD-3-Clause */
#include <mbsrank/simulation.h>

#include <stdio.h>

static int push(void *user, double t, int n, double *value)
{
    (void)user;
    for (int k = 0; k < n; ++k) value[k] = 3.0 * t * t;
    return 0;
}

int main(void)
{
    static const double down[3] = {0.0, 0.0, -1.0}, y[3] = {0.0, 1.0, 0.0}, top[3] = {0.0};
    static const double q[4] = {0.3, 0.2, -0.1, 0.4};
    const mbsr_frame below = mbsr_frame_at(0.0, 0.0, -1.0);
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    int body = MBSR_GROUND;
    for (int k = 0; k < 4; ++k) {
        const mbsr_inertia rod =
            k == 3 ? mbsr_inertia_zero() : mbsr_inertia_rod(1.0 + k, top, down);
        body = mbsr_simulation_add_body(&s, NULL, body,
                                        mbsr_joint_revolute(k ? &below : NULL, NULL, y), rod);
        mbsr_simulation_add_force(&s, mbsr_force_joint_spring(body, 0, 20.0, 0.5, 0.1));
    }
    mbsr_simulation_add_force(&s, mbsr_force_gravity(0.0, 0.0, -9.81));
    mbsr_simulation_add_force(&s, mbsr_force_joint_applied(body, push, NULL));
    mbsr_simulation_start(&s, NULL, 0.0, q, NULL);
    for (int k = 1; k <= 20; ++k) {
        mbsr_simulation_to(&s, 0.1 * k);
        for (int l = 0; l < 4 && !s.status; ++l) printf("%a %a %a\n", s.q[l], s.u[l], s.udot[l]);
    }
    if (s.status) puts(s.error.text);
    mbsr_ida_stats stats = {0};
    mbsr_simulation_get_stats(&s, &stats);
    printf("%ld\n", stats.steps);
    mbsr_simulation_end(&s);
    return 0;
}
