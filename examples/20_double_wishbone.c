/* A double-wishbone suspension in space: massless links, rigid joints and bushings side by side.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * x forward, y to the left, z up. Upper and lower wishbone turn on the chassis, the knuckle with
 * the wheel hangs on the lower one by a ball joint. Two closures make the loops: a ball joint
 * between upper wishbone and knuckle, and the tie rod, a distance between knuckle and rack.
 * Wishbones and tie rod have no mass; only knuckle and wheel do. One freedom is left, the jounce of
 * the wheel, which spring and damper carry. The tyre, a vertical spring and damper, runs over a
 * bump.
 *
 * The report says so before the run: 4 rows, all independent, mobility 1, no direction without mass
 * that no loop holds. Then the upper joint becomes a bushing, a stiff closure of 2e6 N/m
 * (def.stiffness): two freedoms more, which no integrator is troubled with. wishbone.csv has both
 * for wishbone.gp. */
#include <mbsrank/simulation.h>

#include "run.h"

#include <math.h>

enum { SAMPLES = 600 };
static const double T = 1.5, radius = 0.3, wheel = 40.0, tyre = 2e5, tyre_damping = 300.0;

/* Height of the road under the wheel: a bump of 5 cm between 0.3 s and 0.45 s. */
static double road(double t)
{
    const double x = (t - 0.3) / 0.15;
    return x > 0.0 && x < 1.0 ? 0.025 * (1.0 - cos(2.0 * acos(-1.0) * x)) : 0.0;
}

static double road_rate(double t)
{
    const double h = 1e-6;
    return (road(t + h) - road(t - h)) / (2.0 * h);
}

/* The tyre on the knuckle, whose origin is the wheel's centre. */
static int roll(const mbsr_force_args *args)
{
    const double *p = args->body[0].p + MBSR_POSE_X, *v = args->body[0].V + 3;
    const double in = radius + road(args->t) - p[2], rate = road_rate(args->t) - v[2];
    if (in > 0.0) args->body[0].f[5] += fmax(0.0, tyre * in + tyre_damping * rate);
    return MBSR_OK;
}

static const mbsr_force_table tyre_table = {.version = MBSR_FORCE_TABLE_VERSION,
                                            .flags = MBSR_FORCE_NO_MASS,
                                            .name = "tyre",
                                            .evaluate = roll};

static mbsr_model *suspension(double stiffness)
{
    const double x[3] = {1.0, 0.05, 0.0}, along[3] = {1.0, 0.0, 0.03}, none[3] = {0.0};
    const mbsr_frame lower_axis = mbsr_frame_at(0.0, 0.30, 0.20),
                     upper_axis = mbsr_frame_at(-0.02, 0.38, 0.46),
                     lower_ball = mbsr_frame_at(0.0, 0.40, 0.0), /* on the lower wishbone */
        below = mbsr_frame_at(0.01, -0.05, -0.10);               /* on the knuckle */
    const double upper_end[3] = {0.0, 0.26, 0.0}, above[3] = {-0.01, -0.11, 0.16},
                 arm[3] = {-0.12, -0.06, -0.02}, rack[3] = {-0.13, 0.33, 0.28},
                 seat[3] = {0.0, 0.25, 0.02}, top[3] = {0.0, 0.48, 0.65};
    const double tensor[6] = {1.2, 1.8, 1.2, 0.0, 0.0, 0.0};
    mbsr_model *m = new_model();
    const int lower = add_body(m, "lower wishbone", MBSR_GROUND,
                               mbsr_joint_revolute(&lower_axis, NULL, x), mbsr_inertia_zero());
    const int upper = add_body(m, "upper wishbone", MBSR_GROUND,
                               mbsr_joint_revolute(&upper_axis, NULL, along), mbsr_inertia_zero());
    const int knuckle = add_body(m, "knuckle", lower, mbsr_joint_spherical(&lower_ball, &below),
                                 mbsr_inertia_rigid(wheel, none, tensor));
    mbsr_closure_def ball = mbsr_closure_ball(upper, upper_end, knuckle, above);
    ball.name = "upper ball joint";
    for (int k = 0; k < 3; ++k) {
        ball.stiffness[k] = stiffness;
        ball.damping[k] = 1e-3 * stiffness;
    }
    check(mbsr_model_add_closure(m, &ball, NULL), mbsr_model_error(m));
    mbsr_closure_def rod = mbsr_closure_distance(knuckle, arm, MBSR_GROUND, rack, 0.36);
    rod.name = "tie rod";
    check(mbsr_model_add_closure(m, &rod, NULL), mbsr_model_error(m));
    add_force(m, mbsr_force_gravity(0.0, 0.0, -9.81));
    add_force(m, mbsr_force_point_spring(lower, seat, MBSR_GROUND, top, 4e4, 2.5e3, 0.55));
    add_force(m, mbsr_force_custom(&tyre_table, 1, &knuckle, NULL));
    return m;
}

/* Height of the wheel's centre, m, and the angle by which it steers, degrees. */
static void attitude(mbsr_simulation *s, double *height, double *steer)
{
    double pose[MBSR_POSE_SIZE];
    check(mbsr_body_pose(s->model, s->data, 2, pose), mbsr_data_error(s->data));
    *height = pose[MBSR_POSE_X + 2];
    *steer = atan2(pose[1], pose[0]) * 180.0 / acos(-1.0);
}

static void report(const mbsr_simulation *s)
{
    mbsr_closure_report found;
    check(mbsr_closures_report(s->model, s->data, s->t, s->q, &found, NULL, NULL),
          mbsr_data_error(s->data));
    printf("%d rows, %d independent; freedoms left: %d; directions without mass: %d, held by no "
           "loop: %d\n",
           found.rows, found.independent, found.mobility, found.massless, found.undetermined);
    if (found.independent != found.rows || found.mobility != 1) exit(1);
}

int main(void)
{
    const double q[6] = {0.0, 0.0, 1.0, 0.0, 0.0, 0.0}, u[5] = {0.0};
    double apart = 0.0, gap = 0.0;
    mbsr_simulation rigid = run_start(suspension(0.0), q, u, 1e-6),
                    soft = run_start(suspension(2e6), q, u, 1e-6);
    report(&rigid);
    FILE *file = csv("wishbone.csv");
    printf("t [s]   height [mm]   steer [deg]   with a bushing: height   steer\n");
    for (int k = 0; k <= SAMPLES; ++k) {
        double h[2], a[2], g[4];
        if (k) run_to(&rigid, T * k / SAMPLES), run_to(&soft, T * k / SAMPLES);
        attitude(&rigid, h, a);
        attitude(&soft, h + 1, a + 1);
        check(mbsr_closures_gap(rigid.model, rigid.data, g), mbsr_data_error(rigid.data));
        for (int j = 0; j < 4; ++j) gap = fmax(gap, fabs(g[j]));
        apart = fmax(apart, fabs(h[0] - h[1]));
        fprintf(file, "%g,%g,%g,%g,%g,%g\n", rigid.t, road(rigid.t), h[0], a[0], h[1], a[1]);
        if (k % (SAMPLES / 10) == 0)
            printf("%5.2f   %11.3f   %11.4f   %22.3f   %7.4f\n", rigid.t, 1e3 * h[0], a[0],
                   1e3 * h[1], a[1]);
    }
    fclose(file);
    printf("steps: %ld rigid, %ld with the bushing; loops open by %.1e m at most\n",
           run_steps(&rigid), run_steps(&soft), gap);
    mbsr_simulation_end(&rigid);
    mbsr_simulation_end(&soft);
    return gap < 1e-5 && apart < 5e-3 ? 0 : 1;
}
