/* Twenty doubtful moments of inertia in a drive train: which may be zero, and what that costs.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   engine - 20 flanges, hubs, gears and shafts - load
 *
 * All turn about one axis, each on the one before, with a spring and a damper in between. Nobody
 * has measured the moments of inertia of the small parts: from 5e-7 to 2e-2 kg m^2, beside 0.4 kg
 * m^2 of the engine and 3 kg m^2 of the load. The torque of the engine rises within 0.1 s and
 * ripples. The report says which of them may be zero if the twist of no joint is to be wrong by
 * more than 1e-4 rad; these are neglected, the others kept, and both models are run. They take
 * about as many steps, as all that is fast is damped. */
#include <mbsrank/ida.h>

#include "run.h"

#include <math.h>
#include <string.h>

enum { PARTS = 20, BODIES = PARTS + 2, POINTS = 200 };

static const double T = 0.2, allowed = 1e-4, pi = 3.14159265358979323846;

/* kg m^2; N m/rad and N m s/rad of the joint in front. */
static const struct {
    const char *name;
    double moment, stiffness, damping;
} part[PARTS] = {{"flywheel ring", 2e-2, 4e4, 5.0}, {"ring screws", 3e-5, 2e5, 3.0},
                 {"clutch cover", 6e-3, 8e4, 6.0},  {"pressure plate", 9e-4, 3e4, 8.0},
                 {"clutch disc", 2e-4, 6e3, 10.0},  {"disc hub", 5e-5, 9e3, 4.0},
                 {"input shaft", 8e-5, 5e4, 1.0},   {"input bearing", 5e-7, 8e4, 1.0},
                 {"sleeve", 4e-6, 6e4, 2.0},        {"first gear", 3e-4, 4e4, 2.0},
                 {"gear rim", 2e-6, 9e4, 1.0},      {"output shaft", 4e-5, 3e4, 1.0},
                 {"joint cross", 7e-6, 2e4, 3.0},   {"tube, front", 2e-4, 2e4, 2.0},
                 {"tube, rear", 2e-4, 2e4, 2.0},    {"joint yoke", 9e-6, 2e4, 3.0},
                 {"pinion", 1e-4, 5e4, 2.0},        {"spacer", 8e-7, 9e4, 1.0},
                 {"side shaft", 6e-5, 8e3, 5.0},    {"wheel hub", 1e-2, 9e3, 9.0}};

/* 60 N m that rise within 0.1 s, and a ripple of a tenth at 25 Hz. */
static int engine(void *user, double t, int n, double *torque)
{
    const double rise = t < 0.1 ? 0.5 - 0.5 * cos(pi * t / 0.1) : 1.0;
    (void)user, (void)n;
    torque[0] = 60.0 * rise * (1.0 + 0.1 * sin(2.0 * pi * 25.0 * t));
    return MBSR_OK;
}

static mbsr_inertia disc(double moment)
{
    const double tensor[6] = {moment, moment, moment, 0.0, 0.0, 0.0};
    return mbsr_inertia_rigid(0.0, NULL, tensor);
}

static mbsr_model *drive_train(void)
{
    const mbsr_joint turn = mbsr_joint_revolute(NULL, NULL, (const double[3]){0.0, 0.0, 1.0});
    mbsr_model *m = new_model();
    int body = add_body(m, "engine", MBSR_GROUND, turn, disc(0.4));
    add_force(m, mbsr_force_joint_applied(body, engine, NULL));
    for (int k = 0; k < PARTS; ++k) {
        body = add_body(m, part[k].name, body, turn, disc(part[k].moment));
        add_force(m, mbsr_force_joint_spring(body, 0, part[k].stiffness, part[k].damping, 0.0));
    }
    body = add_body(m, "load", body, turn, disc(3.0));
    add_force(m, mbsr_force_joint_spring(body, 0, 2e4, 5.0, 0.0));
    check(mbsr_model_finish(m), mbsr_model_error(m));
    return m;
}

/* Twists at POINTS times; returns the steps. */
static long drive(mbsr_model *m, double tolerance, double (*q)[BODIES])
{
    const double zero[BODIES] = {0.0};
    mbsr_simulation s = run_start(m, zero, zero, tolerance);
    for (int i = 0; i < POINTS; ++i) {
        run_to(&s, T * (i + 1) / POINTS);
        for (int k = 0; k < BODIES; ++k) q[i][k] = s.q[k];
    }
    const long steps = run_steps(&s);
    mbsr_simulation_end(&s);
    return steps;
}

/* A report on these masses along a run of the model without them. */
static mbsr_small_masses *report_on(const mbsr_model *m, const mbsr_small_part *doubtful, int count,
                                    mbsr_small_masses_report *report)
{
    const double zero[BODIES] = {0.0};
    mbsr_small_masses_opt opt = mbsr_default_small_masses_opt();
    mbsr_small_masses *small;
    mbsr_error error;
    opt.part = doubtful;
    opt.parts = count;
    opt.duration = T;
    opt.time_scale = 0.01; /* s: a ripple of 25 Hz is 0.0064 s from its slope to its size */
    opt.tolerance = allowed;
    check(mbsr_small_masses_create(m, &opt, &small, &error), &error);
    check(mbsr_small_masses_start(small, 0.0, zero, zero), mbsr_small_masses_error(small));
    check(mbsr_small_masses_run(small, NULL, T, NULL, &error), &error);
    check(mbsr_small_masses_get_report(small, report), mbsr_small_masses_error(small));
    return small;
}

static double largest(double (*a)[BODIES], double (*b)[BODIES])
{
    double most = 0.0;
    for (int i = 0; i < POINTS; ++i)
        for (int k = 0; k < BODIES; ++k) most = fmax(most, fabs(a[i][k] - b[i][k]));
    return most;
}

/* The model without these masses, run with both tolerances: steps, and the error against `full`. */
static long without(const mbsr_model *m, const mbsr_small_part *zero, int count,
                    double (*full)[BODIES], double *error)
{
    static double q[POINTS][BODIES];
    mbsr_model *copy[2];
    mbsr_error failure;
    for (int c = 0; c < 2; ++c) {
        check(mbsr_model_copy(m, &copy[c], &failure), &failure);
        for (int k = 0; k < count; ++k)
            check(mbsr_model_neglect(copy[c], zero[k].body, zero[k].parts),
                  mbsr_model_error(copy[c]));
    }
    drive(copy[0], 1e-7, q);
    *error = largest(q, full);
    return drive(copy[1], 1e-6, q);
}

/* The masses with the smallest errors, as many as together stay within what is allowed; how many.
 */
static int decide(const mbsr_small_masses_report *report, mbsr_small_part zero[PARTS])
{
    int count = 0, taken[PARTS] = {0};
    double sum = 0.0;
    for (;;) {
        const mbsr_small_mass *next = NULL;
        for (int k = 0; k < report->masses; ++k) {
            const mbsr_small_mass *mass = report->mass + k;
            if (taken[k] || mass->verdict != MBSR_SMALL_MAY_BE_ZERO) continue;
            if (!next || mass->share < next->share) next = mass;
        }
        if (!next || sum + next->share > 1.0) return count;
        sum += next->share;
        taken[next - report->mass] = 1;
        zero[count++] = (mbsr_small_part){next->body, next->parts};
    }
}

/* Each fourth alone is run against its prediction, and all of them with the argument "all", for the
 * picture of doubtful_masses.gp. */
int main(int argc, char **argv)
{
    const int step = argc > 1 && strcmp(argv[1], "all") == 0 ? 1 : 4;
    static double full[POINTS][BODIES], scratch[POINTS][BODIES];
    mbsr_small_part doubtful[PARTS], zero[PARTS];
    mbsr_small_masses_report report;
    mbsr_model *m = drive_train();
    for (int k = 0; k < PARTS; ++k) doubtful[k] = (mbsr_small_part){k + 1, MBSR_MOMENT};
    mbsr_small_masses *small = report_on(m, doubtful, PARTS, &report);
    printf("%s\n", report.text);
    drive(drive_train(), 1e-7, full);
    const long steps = drive(drive_train(), 1e-6, scratch);

    FILE *file = csv("doubtful_masses.csv");
    fprintf(file, "name,moment,predicted,measured,may\n");
    int wrong = 0;
    for (int k = 0; k < PARTS; ++k) {
        const mbsr_small_mass *mass = report.mass + k;
        const int may = mass->verdict == MBSR_SMALL_MAY_BE_ZERO;
        double measured;
        if (k % step > 0) continue;
        without(m, doubtful + k, 1, full, &measured);
        fprintf(file, "\"%s\",%g,%g,%g,%d\n", part[k].name, part[k].moment, mass->error, measured,
                may);
        wrong += measured > 3.0 * mass->error + 1e-6; /* that of the runs */
    }
    fclose(file);
    const int zeros = decide(&report, zero);
    mbsr_small_masses_destroy(small);

    small = report_on(m, zero, zeros, &report);
    double error;
    const long left = without(m, zero, zeros, full, &error);
    printf("%d of %d are zero: twists wrong by %.1e rad, predicted %.1e, %.1e allowed; %ld steps, "
           "%ld with all masses\n",
           zeros, PARTS, error, report.error, allowed, left, steps);
    file = csv("doubtful_masses_steps.csv");
    fprintf(file, "model,steps\n\"all masses\",%ld\n\"%d zeros\",%ld\n", steps, zeros, left);
    fclose(file);
    wrong += error > 3.0 * report.error + 1e-6 || 4 * left > 5 * steps;
    mbsr_small_masses_destroy(small);
    mbsr_model_destroy(m);
    return wrong;
}
