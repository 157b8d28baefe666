/* A beam spun up on a hub: why a flexible body that turns fast needs geometric stiffening.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Data of Simo and Vu-Quoc: 10 m long, EI = 14 kN m^2, 1.2 kg/m; the hub reaches 6 rad/s after 15
 * s. Turning at 6 rad/s the beam stands straight, since the centrifugal force pulls it taut. Modes
 * that are linear move points across the beam only; so the force pushes along with the deflection,
 * and the beam breaks away. With dependent shapes the beam gets shorter as it bends, in second
 * order, and the pull stiffens it. Compared is the elastica, whose tangent angle is a series of its
 * own. spin_up_beam.csv has deflections for spin_up_beam.gp. */
#include <mbsrank/simulation.h>

#include "run.h"

#include <math.h>

enum { SAMPLES = 400, TIMES = 8, WAYS = 4 };
static const double L = 10.0, T = 15.0, omega = 6.0, end = 20.0;

/* Deflections of the elastica's tip. */
static const double times[TIMES] = {2.5, 5.0, 6.5, 7.5, 10.0, 12.5, 15.0, 20.0},
                    elastica[TIMES] = {-0.151274, -0.468436, -0.569876, -0.558985,
                                       -0.362672, -0.112644, 0.001275,  0.000768};

static int turn(void *user, double t, double *angle, double *rate, double *second)
{
    const double k = 2.0 * acos(-1.0) / T;
    (void)user;
    *angle =
        t < T ? omega / T * (0.5 * t * t + (cos(k * t) - 1.0) / (k * k)) : omega * (t - 0.5 * T);
    *rate = t < T ? omega / T * (t - sin(k * t) / k) : omega;
    *second = t < T ? omega / T * (1.0 - cos(k * t)) : 0.0;
    return MBSR_OK;
}

typedef struct result {
    double deflection[SAMPLES]; /* NAN from where it breaks away on */
    double until, lowest, off;  /* off: largest distance from the elastica where both are known */
    long steps;
} result;

static void look(mbsr_simulation *s, int tip, int k, result *r)
{
    double pose[MBSR_POSE_SIZE], angle, rate, second;
    check(mbsr_body_pose(s->model, s->data, tip, pose), mbsr_data_error(s->data));
    turn(NULL, s->t, &angle, &rate, &second);
    const double *x = pose + MBSR_POSE_X, v = cos(angle) * x[1] - sin(angle) * x[0];
    r->deflection[k] = v;
    r->until = s->t;
    r->lowest = fmin(r->lowest, v);
    for (int l = 0; l < TIMES; ++l) {
        if (s->t == times[l]) r->off = fmax(r->off, fabs(v - elastica[l]));
    }
}

static result run(int modes, int stiffening)
{
    static const double rest[8] = {0.0};
    const mbsr_axis axis = {.kind = MBSR_AXIS_ROTATION, .direction = {0.0, 0.0, 1.0}, .driven = 1};
    mbsr_beam_def beam = mbsr_default_beam_def();
    mbsr_flexible_def def = mbsr_default_flexible_def();
    mbsr_flex *flex;
    mbsr_error error;
    int body, tip;
    result r = {.until = 0.0};
    beam.length = L, beam.density = 1.2, beam.EI_z = 1.4e4;
    beam.modes = modes, beam.stiffening = stiffening;
    check(mbsr_flex_beam(&beam, &flex, &error), &error);
    mbsr_model *m = new_model();
    def.flex = flex, def.joint = mbsr_joint_compound(NULL, NULL, 1, &axis, turn, NULL);
    check(mbsr_model_add_flexible(m, &def, &body), mbsr_model_error(m));
    check(mbsr_model_add_marker(m, body, beam.elements, "tip", &tip), mbsr_model_error(m));
    mbsr_simulation s = run_start(m, rest, rest, 1e-6);
    int k = 0;
    do {
        run_to(&s, end * (k + 1) / SAMPLES);
        look(&s, tip, k, &r);
    } while (fabs(r.deflection[k++]) < L && k < SAMPLES);
    for (; k < SAMPLES; ++k) r.deflection[k] = NAN;
    r.steps = run_steps(&s);
    mbsr_simulation_end(&s);
    mbsr_flex_destroy(flex);
    return r;
}

int main(void)
{
    static const struct {
        const char *name;
        int modes, stiffening;
    } way[WAYS] = {
        {"2 modes, linear", 2, 0}, {"1 mode", 1, 1}, {"2 modes", 2, 1}, {"3 modes", 3, 1}};
    result r[WAYS];
    printf("                  until   lowest    off by   steps\n");
    for (int k = 0; k < WAYS; ++k) {
        r[k] = run(way[k].modes, way[k].stiffening);
        printf("%-16s %4.1f s %7.4f %9.4f  %6ld\n", way[k].name, r[k].until, r[k].lowest, r[k].off,
               r[k].steps);
    }
    printf("elastica         20.0 s -0.5737\n");
    FILE *file = csv("spin_up_beam.csv");
    for (int k = 0; k < SAMPLES; ++k) {
        fprintf(file, "%g", end * (k + 1) / SAMPLES);
        for (int l = 0; l < WAYS; ++l) fprintf(file, ",%g", r[l].deflection[k]);
        fprintf(file, "\n");
    }
    fclose(file);
    file = csv("elastica.csv");
    for (int k = 0; k < TIMES; ++k) fprintf(file, "%g,%g\n", times[k], elastica[k]);
    fclose(file);
    return r[0].until < 10.0 && r[2].until == end && r[3].off < 0.0022 ? 0 : 1;
}
