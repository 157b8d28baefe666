/* Options of the driver, what they cost, and its progress.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A chain of 20 rods falls for a second. Each line of the table changes one option: the tolerances,
 * for all or by kind of variable; the norm; the solver of the linear systems; the length of the
 * steps and their order. What they buy stands beside: the error of the last joint's place, against
 * a run with a tolerance of 1e-10.
 *
 * A progress function is called between steps. It prints a percentage where somebody watches, and
 * may stop the run, as here after the 100th step of one of the runs; the next call goes on as if
 * nothing had been. Output at given times comes by mbsr_ida_run, and changes no step either. */
#include <mbsrank/simulation.h>

#include "progress.h"

#include <math.h>
#include <stdlib.h>

enum { RODS = 20, OUTPUTS = 10, STOPPED = 4711 };
static const double T = 1.0, length = 0.1; /* s, m */

typedef struct watch {
    long stop; /* after so many steps; 0: never */
    int stops, outputs;
} watch;

/* A status above zero is one of ours; it comes back from mbsr_ida_run as it is. */
static int look(void *user, const mbsr_ida_progress *now)
{
    watch *w = user;
    show_progress(now->t / T);
    if (w->stop == 0 || now->steps < w->stop) return MBSR_OK;
    w->stop = 0;
    return STOPPED;
}

static int output(void *user, int index, double t, const double *y, const double *yp)
{
    watch *w = user;
    (void)t, (void)y, (void)yp;
    if (index == w->outputs) ++w->outputs; /* each once, in their order */
    return MBSR_OK;
}

/* Place of the tip at T; *stats: what it has cost. */
static void fall(const mbsr_ida_opt *opt, watch *w, double tip[3], mbsr_ida_stats *stats)
{
    const double y_axis[3] = {0, 1, 0}, top[3] = {0}, end[3] = {0, 0, -length}, q[RODS] = {0.5};
    const mbsr_frame next = mbsr_frame_at(0.0, 0.0, -length);
    double times[OUTPUTS], pose[MBSR_POSE_SIZE] = {0.0};
    int given = 0, status;
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    for (int i = 0; i < RODS; ++i)
        mbsr_simulation_add_body(&s, NULL, i - 1,
                                 mbsr_joint_revolute(i ? &next : NULL, NULL, y_axis),
                                 mbsr_inertia_rod(0.1, top, end));
    mbsr_simulation_add_force(&s, mbsr_force_gravity(0.0, 0.0, -9.81));
    mbsr_simulation_start(&s, opt, 0.0, q, NULL);
    for (int k = 0; k < OUTPUTS; ++k) times[k] = T * (k + 1) / OUTPUTS;
    if (s.status == MBSR_OK) {
        while ((status = mbsr_ida_run(s.ida, OUTPUTS, times, &given, output, w)) == STOPPED)
            ++w->stops;
        if (status != MBSR_OK) fprintf(stderr, "%s\n", mbsr_ida_error(s.ida)->text);
    }
    mbsr_simulation_to(&s, T); /* where the run is already: the state, evaluated */
    if (s.status == MBSR_OK) mbsr_body_pose(s.model, s.data, RODS - 1, pose);
    if (s.status == MBSR_OK) mbsr_ida_get_stats(s.ida, stats);
    if (s.status != MBSR_OK) fprintf(stderr, "%s\n", s.error.text);
    for (int k = 0; k < 3; ++k) tip[k] = pose[MBSR_POSE_X + k];
    mbsr_simulation_end(&s);
}

typedef struct choice {
    const char *text;
    mbsr_ida_opt opt;
} choice;

enum { RUNS = 9 };

static void choose(choice c[RUNS])
{
    for (int k = 0; k < RUNS; ++k) c[k].opt = mbsr_default_ida_opt();
    c[0].text = "as they are";
    c[1].text = "rtol = atol = 1e-8", c[1].opt.rtol = c[1].opt.atol = 1e-8;
    c[2].text = "atol_angular_velocity = 1e-3", c[2].opt.atol_angular_velocity = 1e-3;
    c[3].text = "max_norm = 1", c[3].opt.max_norm = 1;
    c[4].text = "suppress_algebraic = 0", c[4].opt.suppress_algebraic = 0;
    c[5].text = "linear_solver = DENSE", c[5].opt.linear_solver = MBSR_IDA_DENSE;
    c[6].text = "linear_solver = KRYLOV", c[6].opt.linear_solver = MBSR_IDA_KRYLOV;
    c[7].text = "max_step = 1 ms", c[7].opt.max_step = 1e-3;
    c[8].text = "max_order = 2", c[8].opt.max_order = 2;
}

int main(void)
{
    choice c[RUNS];
    double exact[3], tip[3], error[RUNS];
    mbsr_ida_stats stats = {0};
    watch w = {0};
    mbsr_ida_opt fine = mbsr_default_ida_opt();
    fine.rtol = fine.atol = 1e-11;
    fall(&fine, &w, exact, &stats);
    choose(c);
    printf("%-30s steps   residuals   factorisations   error of the tip [m]\n", "option");
    for (int k = 0; k < RUNS; ++k) {
        w = (watch){.stop = k == 1 ? 100 : 0};
        c[k].opt.progress = look;
        c[k].opt.progress_user = &w;
        fall(&c[k].opt, &w, tip, &stats);
        error[k] = hypot(tip[0] - exact[0], tip[2] - exact[2]);
        printf("%-30s %5ld   %9ld   %14ld   %.1e%s\n", c[k].text, stats.steps, stats.residuals,
               stats.factorisations, error[k], w.stops > 0 ? "   stopped once" : "");
        if (w.outputs != OUTPUTS || w.stops != (k == 1)) return 1;
    }
    return error[0] < 1e-2 && error[1] < 1e-4 ? 0 : 1;
}
