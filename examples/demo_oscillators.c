/* The demo: two coupled oscillators in relative coordinates, the first mass getting smaller and
 * then zero.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   ground --- c1, d1 --- m1 --- c2, d2 --- m2      q1 = p1, q2 = p2 - p1, constant force F on m1
 *
 * M. Arnold, Mech. Sci. 4 (2013), doi:10.5194/ms-4-221-2013, Sect. 2.2, shows how a small m1
 * costs an integrator its step size and how m1 = 0 gives it back. The parameters of the paper are
 * not printed; these show the same pattern: m2 = c1 = c2 = 1, d1 = d2 = 1e-5, F = 1, 0 <= t <= 2.
 * Writes a table, and CSV files for oscillators.gp into the folder given as argument. */
#include <mbsrank/ida.h>
#include <mbsrank/mbsrank.h>

#include "expm.h"

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

static const double m2 = 1.0, c1 = 1.0, c2 = 1.0, d1 = 1e-5, d2 = 1e-5, F = 1.0, T = 2.0,
                    tolerance = 1e-4;
enum { POINTS = 2000 };

typedef struct run {
    mbsr_ida_stats stats;
    double seconds, error;
} run;

static void check(int status, const mbsr_error *error)
{
    if (status == MBSR_OK) return;
    fprintf(stderr, "%s: %s\n", mbsr_status_name(status), error->text);
    exit(1);
}

static int force(void *user, double t, int n, double *value)
{
    (void)user, (void)t, (void)n;
    value[0] = F;
    return MBSR_OK;
}

static mbsr_model *build(double m1)
{
    mbsr_model *m;
    mbsr_error error;
    int first, second;
    check(mbsr_model_create(NULL, &m, &error), &error);
    mbsr_body_def body = mbsr_default_body_def();
    body.name = "m1";
    body.joint = mbsr_joint_point((mbsr_planar_frame){0}, MBSR_X, 0, NULL, NULL);
    body.inertia = mbsr_inertia_particle(m1);
    check(mbsr_model_add_body(m, &body, &first), mbsr_model_error(m));
    body.name = "m2";
    body.parent = first;
    body.inertia = mbsr_inertia_particle(m2);
    check(mbsr_model_add_body(m, &body, &second), mbsr_model_error(m));
    const mbsr_force_def forces[] = {mbsr_force_axis_spring(first, MBSR_GROUND, 0, c1, d1, 0.0),
                                     mbsr_force_axis_spring(second, first, 0, c2, d2, 0.0),
                                     mbsr_force_applied(first, force, NULL)};
    for (int k = 0; k < 3; ++k)
        check(mbsr_model_add_force(m, &forces[k], NULL), mbsr_model_error(m));
    check(mbsr_model_finish(m), mbsr_model_error(m));
    return m;
}

/* (p1, p2, v2) without m1, (p1, p2, v2, v1) with it: equations (6) and (5). */
static expm_system exact_system(double m1)
{
    expm_system s = {.n = m1 > 0.0 ? 4 : 3};
    const double row[EXPM_MOST] = {-(c1 + c2), c2, d2, -(d1 + d2)}; /* force on m1 but for F */
    if (m1 > 0.0) {
        s.A[0][3] = 1.0;
        for (int k = 0; k < 4; ++k) s.A[3][k] = row[k] / m1;
        s.b[3] = F / m1;
    } else {
        for (int k = 0; k < 3; ++k) s.A[0][k] = row[k] / (d1 + d2);
        s.b[0] = F / (d1 + d2);
    }
    s.A[1][2] = 1.0;
    /* m2 v2' = c2 (p1 - p2) + d2 (v1 - v2), with v1 from the row above */
    s.A[2][0] = c2 / m2, s.A[2][1] = -c2 / m2, s.A[2][2] = -d2 / m2;
    if (m1 > 0.0) {
        s.A[2][3] = d2 / m2;
    } else {
        for (int k = 0; k < 3; ++k) s.A[2][k] += d2 / m2 * s.A[0][k];
        s.b[2] = d2 / m2 * s.b[0];
    }
    return s;
}

/* Steps through the output times, writes t, p1, p2, exact p1, p2 and returns the largest error. */
static double record(mbsr_ida *ida, double m1, double p1_start, FILE *file)
{
    const expm_system system = exact_system(m1);
    double y[4], x[EXPM_MOST] = {p1_start}, error = 0.0;
    for (int k = 1; k <= POINTS; ++k) {
        check(mbsr_ida_advance(ida, T * k / POINTS, NULL, y, NULL), mbsr_ida_error(ida));
        expm_solve(&system, T / POINTS, x, x);
        const double p1 = y[0], p2 = y[0] + y[1];
        fprintf(file, "%.6f,%.9f,%.9f,%.9f,%.9f\n", T * k / POINTS, p1, p2, x[0], x[1]);
        error = fmax(error, fmax(fabs(p1 - x[0]), fabs(p2 - x[1])));
    }
    return error;
}

/* Integrates from p1 = p1_start, at rest; with a file, records the motion there. Output does not
 * change the steps. */
static run integrate(double m1, double p1_start, FILE *file)
{
    mbsr_model *m = build(m1);
    mbsr_data *d;
    mbsr_ida *ida;
    mbsr_error error;
    run result = {.error = 0.0};
    double y[4] = {p1_start, -p1_start, 0.0, 0.0}, yp[4];
    check(mbsr_data_create(m, &d, &error), &error);
    check(mbsr_dae_consistent(m, d, MBSR_DAE_RECURSIVE, 0.0, y, yp, NULL, NULL),
          mbsr_data_error(d));

    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.form = MBSR_DAE_RECURSIVE;
    opt.rtol = opt.atol = tolerance;
    check(mbsr_ida_create(m, d, &opt, &ida, &error), &error);
    check(mbsr_ida_start(ida, 0.0, y, yp), mbsr_ida_error(ida));
    const clock_t begin = clock();
    if (file) {
        result.error = record(ida, m1, p1_start, file);
    } else {
        check(mbsr_ida_advance(ida, T, NULL, NULL, NULL), mbsr_ida_error(ida));
    }
    result.seconds = (double)(clock() - begin) / CLOCKS_PER_SEC;
    check(mbsr_ida_get_stats(ida, &result.stats), mbsr_ida_error(ida));
    mbsr_ida_destroy(ida);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
    return result;
}

static FILE *create(const char *folder, const char *name)
{
    char path[4096];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "w");
    if (!file) {
        fprintf(stderr, "cannot write %s\n", path);
        exit(1);
    }
    return file;
}

int main(int count, char **arguments)
{
    const char *folder = count > 1 ? arguments[1] : ".";
    const double ratio[] = {1e-3, 1e-4, 1e-5, 1e-6, 0.0};
    const char *const name[] = {"1e-3", "1e-4", "1e-5", "1e-6", "0"};
    const double quasi_static = F / (c1 + c2);
    FILE *summary = create(folder, "oscillators.csv");
    fprintf(summary,
            "# m1/m2,start p1,steps,residual evaluations,Newton iterations,CPU s,largest error\n");
    printf("Two coupled oscillators in relative coordinates, t = 0 .. %g, rtol = atol = %g, IDA "
           "with a dense matrix.\n"
           "Start at rest: for m1 > 0 at p1 = 0; for m1 = 0 on its smooth solution, p1 = "
           "F/(c1+c2).\n\n"
           "  m1/m2   steps  residuals  Newton it.    CPU ms  largest error   steps if started at "
           "p1 = F/(c1+c2)\n",
           T, tolerance);
    long first = 0, last = 0;
    for (int k = 0; k < 5; ++k) {
        char file_name[64];
        snprintf(file_name, sizeof file_name, "oscillators_%s.csv", name[k]);
        FILE *file = create(folder, file_name);
        const double start = ratio[k] > 0.0 ? 0.0 : quasi_static;
        const run shown = integrate(ratio[k] * m2, start, file),
                  timed = integrate(ratio[k] * m2, start, NULL);
        const run smooth = integrate(ratio[k] * m2, quasi_static, NULL);
        fclose(file);
        printf("  %-5s  %6ld  %9ld  %10ld  %8.2f  %13.1e   %6ld\n", name[k], shown.stats.steps,
               shown.stats.residuals, shown.stats.newton_iterations, 1e3 * timed.seconds,
               shown.error, smooth.stats.steps);
        fprintf(summary, "%s,%g,%ld,%ld,%ld,%.6f,%.3e\n", name[k], start, shown.stats.steps,
                shown.stats.residuals, shown.stats.newton_iterations, timed.seconds, shown.error);
        first = k == 1 ? shown.stats.steps : first;
        last = shown.stats.steps;
    }
    fclose(summary);
    printf("\nA mass of 1e-4 costs %ld steps, a mass of zero %ld: stating the zero is %.0f times "
           "cheaper than inventing a small "
           "mass.\n",
           first, last, (double)first / (double)last);
    return 50 * last <= first ? 0 : 1;
}
