/* A robot arm with two flexible links, and four ways to treat their static modes.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Drives hold the shoulder and the elbow while a tool at the tip pushes sideways, 1 N within 0.2 s.
 * Either link has two normal modes; what else the tip gives way under the tool is in static modes.
 * They may be left out, kept with their mass and its high frequencies, or kept without mass, with
 * damping (index 1) or without (index 2). The tip is compared with a forearm of six normal modes
 * and the static ones. flexible_arm.csv has its path for flexible_arm.gp. */
#include "run.h"

#include <mbsrank/simulation.h>

#include <math.h>
#include <string.h>

enum { TIP = 15, SAMPLES = 200, MOST = 20 };
static const double T = 2.0; /* s */

typedef enum treatment { LEFT_OUT, WITH_MASS, MASSLESS, UNDAMPED } treatment;

/* The tool's push along y at the tip, N. */
static int push(void *user, double t, int n, double *value)
{
    const double pi = acos(-1.0);
    (void)user;
    for (int k = 0; k < n; ++k) value[k] = 0.0;
    value[4] = t < 0.2 ? 0.5 * (1.0 - cos(pi * t / 0.2)) : 1.0;
    return MBSR_OK;
}

static mbsr_flex *beam(mbsr_beam_def def)
{
    mbsr_flex *flex;
    mbsr_error error;
    check(mbsr_flex_beam(&def, &flex, &error), &error);
    return flex;
}

/* The same without the damping of its massless modes. */
static mbsr_flex *undamped(mbsr_flex *flex)
{
    mbsr_flex_def data;
    mbsr_flex *bare;
    mbsr_error error;
    double D[MOST * MOST];
    mbsr_flex_definition(flex, &data);
    const int next = data.modes + 1;
    memcpy(D, data.D, (size_t)data.modes * (size_t)data.modes * sizeof *D);
    for (int k = 0; k < data.modes; ++k) {
        if (data.Mf[k * next] == 0.0) D[k * next] = 0.0;
    }
    data.D = D;
    check(mbsr_flex_create(&data, &bare, &error), &error);
    mbsr_flex_destroy(flex);
    return bare;
}

/* Links of aluminium, 1 m of 20 mm x 5 mm, upright: they bend in the plane of the arm. */
static void make_links(int modes, treatment how, mbsr_flex *link[2])
{
    static const int tip = TIP;
    mbsr_beam_def def = mbsr_default_beam_def();
    def.length = 1.0, def.density = 0.27, def.EI_z = 14.6;
    def.modes = 2;
    def.damping = 0.01;
    def.tip_mass = 1.0; /* as much as rides on the first link */
    link[0] = beam(def);
    def.tip_mass = 0.0;
    def.modes = modes;
    if (how != LEFT_OUT) def.loaded = 1, def.node = &tip;
    if (how == WITH_MASS) def.cutoff = INFINITY;
    link[1] = beam(def);
    if (how == UNDAMPED) link[1] = undamped(link[1]);
}

static int add_link(mbsr_model *m, int parent, const char *name, const mbsr_flex *link)
{
    static const double axis[3] = {0.0, 0.0, 1.0};
    const mbsr_servo servo = {.kp = 400.0, .kd = 40.0};
    mbsr_flexible_def def = mbsr_default_flexible_def();
    int body, tip;
    def.name = name, def.parent = parent, def.flex = link;
    def.joint = mbsr_joint_revolute(NULL, NULL, axis);
    check(mbsr_model_add_flexible(m, &def, &body), mbsr_model_error(m));
    check(mbsr_model_add_marker(m, body, TIP, NULL, &tip), mbsr_model_error(m));
    add_force(m, mbsr_force_joint_servo(body - 1, 0, &servo));
    return tip;
}

/* The tip's y over time, m; steps. */
static long run(int modes, treatment how, double tolerance, double y[SAMPLES])
{
    double zero[3 * MOST] = {0.0}, pose[MBSR_POSE_SIZE];
    mbsr_flex *link[2];
    make_links(modes, how, link);
    mbsr_model *m = new_model();
    const int elbow = add_link(m, MBSR_GROUND, "upper arm", link[0]),
              tip = add_link(m, elbow, "forearm", link[1]);
    add_force(m, mbsr_force_wrench(tip, NULL, 0, push, NULL));
    mbsr_simulation s = run_start(m, zero, zero, tolerance);
    for (int k = 0; k < SAMPLES; ++k) {
        run_to(&s, T * (k + 1) / SAMPLES);
        check(mbsr_body_pose(s.model, s.data, tip, pose), mbsr_data_error(s.data));
        y[k] = pose[MBSR_POSE_X + 1];
    }
    const long steps = run_steps(&s);
    mbsr_simulation_end(&s);
    for (int k = 0; k < 2; ++k) mbsr_flex_destroy(link[k]);
    return steps;
}

int main(void)
{
    static const char *const name[] = {"left out", "with mass", "massless", "massless, undamped"};
    double reference[SAMPLES], y[4][SAMPLES], error[4] = {0.0}, size = 0.0;
    long steps[4];
    run(6, MASSLESS, 1e-7, reference);
    printf("static modes          steps   tip off by [mm]\n");
    for (int how = LEFT_OUT; how <= UNDAMPED; ++how) {
        steps[how] = run(2, (treatment)how, 1e-6, y[how]);
        for (int k = 0; k < SAMPLES; ++k) {
            error[how] = fmax(error[how], fabs(y[how][k] - reference[k]));
            size = fmax(size, fabs(reference[k]));
        }
        printf("%-18s   %6ld   %15.4f\n", name[how], steps[how], 1e3 * error[how]);
    }
    printf("the tip gives way by %.1f mm\n", 1e3 * size);
    FILE *file = csv("flexible_arm.csv");
    for (int k = 0; k < SAMPLES; ++k) {
        fprintf(file, "%g,%g", T * (k + 1) / SAMPLES, reference[k]);
        for (int how = 0; how < 4; ++how) fprintf(file, ",%g", y[how][k] - reference[k]);
        fprintf(file, "\n");
    }
    fclose(file);
    return 5 * steps[MASSLESS] < 6 * steps[LEFT_OUT] && 2 * steps[MASSLESS] < steps[WITH_MASS] &&
                   5.0 * error[MASSLESS] < error[LEFT_OUT]
               ? 0
               : 1;
}
