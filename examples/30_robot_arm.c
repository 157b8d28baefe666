/* A robot arm follows points in time: PD control, and the torques that the motion takes fed
 * forward.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The reference of each joint is a spline through points. A servo reads it, and its rate; inverse
 * dynamics along it, with its second derivative, gives the torques that an arm without error would
 * need. That wants the arm without its drives: the same model, with second data in which they are
 * switched off. */
#include <mbsrank/simulation.h>

#include <math.h>
#include <stdio.h>

enum { N = 3, POINTS = 5, SAMPLES = 200 };
static const double T = 2.0;

typedef struct feed {
    int joint;
    mbsr_table *const *reference;
    const mbsr_model *model;
    mbsr_data *bare; /* without drives */
} feed;

static int feed_forward(void *user, double t, int n, double *value)
{
    const feed *f = user;
    double q[N], u[N], a[N], tau[N];
    int status = MBSR_OK;
    (void)n;
    for (int k = 0; k < N && !status; ++k)
        status = mbsr_table_value(f->reference[k], t, q + k, u + k, a + k);
    if (!status) status = mbsr_inverse_dynamics(f->model, f->bare, t, q, u, a, NULL, tau);
    if (!status) value[0] = tau[f->joint];
    return status;
}

/* Largest error of a joint, rad; negative after a failure. */
static double follow(int fed)
{
    const double x[POINTS] = {0.0, 0.4, 1.0, 1.5, 2.0};
    const double way[N][POINTS] = {
        {0, 0.6, 1.2, 0.5, 0}, {0.3, 0.9, 0.2, 0.7, 0.3}, {1, 0.4, 1.3, 1, 1}};
    const double y[3] = {0, 1, 0}, z[3] = {0, 0, 1}, from[3] = {0}, to[3] = {0, 0, 0.5};
    const mbsr_frame elbow = mbsr_frame_at(0.0, 0.0, 0.5);
    mbsr_table *reference[N];
    feed feeds[N];
    int drive[2 * N], drives = 0;
    double q[N], u[N], worst = 0.0, r;
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    int body = mbsr_simulation_add_body(&s, "base", MBSR_GROUND, mbsr_joint_revolute(NULL, NULL, z),
                                        mbsr_inertia_cylinder(2700.0, 0.1, 0.1));
    body = mbsr_simulation_add_body(&s, "upper arm", body, mbsr_joint_revolute(NULL, NULL, y),
                                    mbsr_inertia_rod(4.0, from, to));
    mbsr_simulation_add_body(&s, "forearm", body, mbsr_joint_revolute(&elbow, NULL, y),
                             mbsr_inertia_rod(2.0, from, to));
    mbsr_simulation_add_force(&s, mbsr_force_gravity(0.0, 0.0, -9.81));
    for (int k = 0; k < N; ++k) {
        reference[k] = mbsr_simulation_add_table(&s, MBSR_TABLE_SPLINE, POINTS, x, way[k]);
        const mbsr_servo servo = {.kp = 400.0, .kd = 30.0, .limit = 80.0, .table = reference[k]};
        feeds[k] = (feed){.joint = k, .reference = reference};
        drive[drives++] = mbsr_simulation_add_force(&s, mbsr_force_joint_servo(k, 0, &servo));
        if (!fed) continue;
        drive[drives++] =
            mbsr_simulation_add_force(&s, mbsr_force_joint_applied(k, feed_forward, &feeds[k]));
    }
    mbsr_data *bare = mbsr_simulation_add_data(&s);
    for (int k = 0; k < drives; ++k) mbsr_force_switch(s.model, bare, drive[k], 0);
    for (int k = 0; k < N; ++k) {
        feeds[k].model = s.model;
        feeds[k].bare = bare;
        mbsr_simulation_check(&s, mbsr_table_value(reference[k], 0.0, q + k, u + k, NULL));
    }
    mbsr_simulation_start(&s, NULL, 0.0, q, u);
    for (int n = 1; n <= SAMPLES && !mbsr_simulation_to(&s, T * n / SAMPLES); ++n) {
        for (int k = 0; k < N; ++k) {
            mbsr_simulation_check(&s, mbsr_table_value(reference[k], s.t, &r, NULL, NULL));
            worst = fmax(worst, fabs(s.q[k] - r));
        }
    }
    if (s.status) fprintf(stderr, "%s\n", s.error.text);
    mbsr_ida_stats stats;
    mbsr_simulation_get_stats(&s, &stats);
    printf("%-22s %4ld steps, largest error %.1e rad\n", fed ? "torques fed forward" : "PD alone",
           stats.steps, worst);
    const int status = s.status;
    mbsr_simulation_end(&s);
    return status ? -1.0 : worst;
}

int main(void)
{
    const double alone = follow(0), fed = follow(1);
    return alone > 1e-2 && fed >= 0.0 && fed < 1e-4 ? 0 : 1;
}
