/* A vehicle on massless suspension links: at rest, its modes, and how they move with one damper.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Seen from the side: the chassis heaves and pitches. At each axle a trailing arm without mass
 * hinges on it, and carries the wheel through a rubber mount, which is as stiff as no integrator of
 * its rates would like; a coil spring with a damper goes from the chassis to the arm, and the tyre
 * from the wheel to the road:
 *
 *   chassis -- hinge -- arm (0 kg) -- rubber -- wheel (40 kg) -- tyre -- road
 *
 * Springs are as long as they were made, so the vehicle first sinks to where it rests. Then its
 * modes for dampers of 0 .. 20000 N s/m at the front axle: root_locus.csv for root_locus.gp. Each
 * arm adds one state where its dampers are, and no frequency of its own. The slow modes are found a
 * second time without matrices. */
#include "build.h"

#include <mbsrank/linear.h>

#include <math.h>

enum { BODIES = 6, MODES = 2 * BODIES, POINTS = 120, SLOW = 4 };
static const double g = 9.81, most = 20000.0; /* m/s^2; N s/m */

/* Everything of one axle, at x along the chassis; damper in N s/m. */
static void add_axle(mbsr_model *m, int chassis, double x, double coil, double damper)
{
    const double y[3] = {0, 1, 0}, up[3] = {0, 0, 1}, middle[3] = {-0.25, 0, 0};
    const double arm_length = 0.45, above[3] = {x - 0.25, 0, 0.35};
    const mbsr_frame hinge = mbsr_frame_at(x, 0, 0), end = mbsr_frame_at(-arm_length, 0, 0),
                     road = mbsr_frame_at(x - arm_length, 0, 0.3);
    const double tyre[6] = {0, 0, 0, 0, 0, 2e5}, tread[6] = {0, 0, 0, 0, 0, 100};
    const int arm =
        add_body(m, "arm", chassis, mbsr_joint_revolute(&hinge, NULL, y), mbsr_inertia_zero());
    const int wheel =
        add_body(m, "wheel", arm, mbsr_joint_prismatic(&end, NULL, up), mbsr_inertia_particle(40));
    add_force(m, mbsr_force_point_spring(chassis, above, arm, middle, coil, damper, 0.4));
    add_force(m, mbsr_force_joint_spring(wheel, 0, 5e5, 200.0, 0.0));
    add_force(m, mbsr_force_bushing(MBSR_GROUND, &road, wheel, NULL, tyre, tread));
}

static mbsr_model *vehicle(double front)
{
    const double y[3] = {0, 1, 0}, up[3] = {0, 0, 1};
    const mbsr_frame height = mbsr_frame_at(0, 0, 0.3);
    mbsr_model *m = new_model();
    const int heave = add_body(m, "heave", MBSR_GROUND, mbsr_joint_prismatic(&height, NULL, up),
                               mbsr_inertia_zero());
    const int chassis = add_body(m, "chassis", heave, mbsr_joint_revolute(NULL, NULL, y),
                                 mbsr_inertia_rigid(600.0, (const double[3]){0.1, 0, 0.2},
                                                    (const double[6]){300, 900, 900, 0, 0, 0}));
    add_axle(m, chassis, 1.6, 6.5e4, front);
    add_axle(m, chassis, -0.9, 6.5e4, 6000.0);
    add_force(m, mbsr_force_gravity(0, 0, -g));
    check(mbsr_model_finish(m), mbsr_model_error(m));
    return m;
}

/* At rest, with its modes: how many. */
static int find_modes(const mbsr_model *m, mbsr_data *d, double *q, mbsr_mode *mode, double *wrong)
{
    mbsr_linear *l;
    mbsr_error error;
    mbsr_mode slow[SLOW];
    mbsr_near_opt opt = mbsr_default_near_opt();
    int count, found;
    check(mbsr_equilibrium(m, d, 0.0, q, NULL, q, NULL, NULL, &error), &error);
    check(mbsr_linear_create(m, d, 0.0, q, NULL, NULL, &l, &error), &error);
    check(mbsr_linear_modes(l, mode, &count), &error);
    mbsr_linear_destroy(l);
    opt.count = SLOW;
    check(mbsr_modes_near(m, d, 0.0, q, &opt, slow, &found, NULL, NULL, &error), &error);
    for (int k = 0; k < found; ++k)
        *wrong =
            fmax(*wrong, hypot(slow[k].real - mode[k].real, slow[k].imaginary - mode[k].imaginary));
    return found == SLOW ? count : 0;
}

int main(void)
{
    double q[BODIES] = {0.0}, wrong = 0.0, least = 1.0, best = 0.0;
    FILE *file = csv("root_locus.csv");
    for (int k = 0; k <= POINTS; ++k) {
        const double front = most * k / POINTS;
        mbsr_model *m = vehicle(front);
        mbsr_data *d;
        mbsr_error error;
        mbsr_mode mode[MODES];
        check(mbsr_data_create(m, &d, &error), &error);
        const int count = find_modes(m, d, q, mode, &wrong);
        double damping = 1.0; /* of what swings, the least */
        for (int i = 0; i < count; ++i) {
            fprintf(file, "%g,%.10g,%.10g\n", front, mode[i].real, mode[i].imaginary);
            if (mode[i].imaginary > 0.0) damping = fmin(damping, mode[i].damping);
        }
        if (damping > least || k == 0) best = front;
        if (damping > least || k == 0) least = damping;
        if (k == 0)
            printf("at rest: heave %.4f m, pitch %.4f deg, arms %.2f and %.2f deg\n", q[0],
                   q[1] * 180.0 / acos(-1.0), q[2] * 180.0 / acos(-1.0), q[4] * 180.0 / acos(-1.0));
        if (k % 60 == 0) {
            printf("%.0f N s/m in front:\n        Hz   damping %%\n", front);
            for (int i = 0; i < count; ++i)
                printf("%10.4f %11.3f\n", mode[i].frequency, 100.0 * mode[i].damping);
        }
        mbsr_data_destroy(d);
        mbsr_model_destroy(m);
    }
    fclose(file);
    printf("the least damping is largest, %.1f %%, at %.0f N s/m\n", 100.0 * least, best);
    printf("slow modes without matrices differ by %.1e 1/s\n", wrong);
    return wrong < 1e-7 && best > 0.0 && best < most ? 0 : 1;
}
