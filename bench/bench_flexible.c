/* Chains of flexible bodies with massless modes in each: time per body, steps of the driver, and
 * how both grow with bodies and modes.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   bench_flexible [samples [links]]     CSV on standard output; of chains of so many links alone
 *
 * Beams of 1 m on hinges whose axes take turns, with a spring and a damper at the middle of each.
 * `chain`: two normal modes and the four static ones of the middle, without mass, 1 to 1000 links.
 * `modes`: ten links of 4 to 128 normal modes; `waves`: of 249 modes, sines along all axes, with
 * diagonal modal masses; `.._blocks`: the same with joint blocks in one piece. `steps`: 0.2 s of
 * the fall of such a `chain` from rest along x, 0.02 s of 1000 links; tolerance 1e-6. */
#include "bench.h"

#include <mbsrank/ida.h>
#include <mbsrank/mbsrank.h>

#include "model/record.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

enum { SAMPLES = 11, TASKS = 3, ELEMENTS = 20, CASES = 19 };

static const double sample_time = 5e-3;
static const char *const task_name[TASKS] = {"forward", "residual", "factor_solve"};
static const struct bench_case {
    const char *name;
    int links, modes;
} cases[CASES] = {{"chain", 1, 2},          {"chain", 10, 2},         {"chain", 100, 2},
                  {"chain", 1000, 2},       {"modes", 10, 4},         {"modes", 10, 8},
                  {"modes", 10, 12},        {"modes", 10, 16},        {"modes", 10, 24},
                  {"modes", 10, 32},        {"modes", 10, 64},        {"modes", 10, 128},
                  {"waves", 10, 249},       {"modes_blocks", 10, 16}, {"modes_blocks", 10, 24},
                  {"modes_blocks", 10, 32}, {"modes_blocks", 10, 64}, {"modes_blocks", 10, 128},
                  {"waves_blocks", 10, 249}};

typedef struct chain {
    int links, last; /* marker at the end */
    mbsr_flex *beam;
    mbsr_model *model;
    mbsr_data *data;
    mbsr_newton *newton;
    double *q, *u, *udot, *y, *yp, *F, *x;
    int repeats[TASKS];
} chain;

static mbsr_flex *make_beam(const struct bench_case *of, int elements)
{
    const int middle = elements / 2;
    mbsr_beam_def beam = mbsr_default_beam_def();
    mbsr_error error = {0};
    mbsr_flex *flex;
    beam.length = beam.density = 1.0, beam.EI_y = 70.0, beam.EI_z = 50.0;
    beam.elements = elements, beam.modes = of->modes, beam.loaded = strcmp(of->name, "chain") == 0;
    beam.node = &middle;
    beam.damping = 0.02;
    bench_check(mbsr_flex_beam(&beam, &flex, &error), "beam", error.text);
    return flex;
}

/* Phi = e_axis sin(k x), k = pi/2, 3 pi/2, .., with markers at root, middle and end. */
static mbsr_flex *make_waves(int modes)
{
    const size_t n = (size_t)modes;
    double *Ct0 = bench_allocate((12 + 9 * n + n + 9) * n, sizeof *Ct0), *P0 = Ct0 + 3 * n,
           *P = P0 + 9 * n, *K = P + 9 * n * n, *Phi = K + n * n;
    mbsr_flex_def def = mbsr_default_flex_def();
    mbsr_flex_marker marker[3];
    mbsr_error error = {0};
    mbsr_flex *flex;
    memset(Ct0, 0, (12 + 9 * n + n + 9) * n * sizeof *Ct0);
    def.mass = 1.0, def.c0[0] = 0.5, def.N0[0] = 1.0 / 3.0, def.N0[4] = def.N0[8] = 1e-3;
    for (size_t a = 0; a < n; ++a) {
        const size_t axis = a % 3;
        const double k = (0.5 + (double)(a / 3)) * acos(-1.0), end = a / 3 % 2 == 0 ? 1.0 : -1.0;
        Ct0[3 * a + axis] = 1.0 / k;
        P0[9 * a + 3 * axis] = end / (k * k);
        for (size_t b = a - axis; b < a - axis + 3; ++b)
            P[3 * n * (3 * b + b % 3) + 3 * a + axis] = 0.5;
        K[a * (n + 1)] = 50.0 * k * k * k * k;
        Phi[3 * n + 3 * a + axis] = sin(0.5 * k);
        Phi[6 * n + 3 * a + axis] = end;
    }
    for (int k = 0; k < 3; ++k) {
        marker[k] = (mbsr_flex_marker){.frame = mbsr_frame_identity(), .Phi = Phi + 3 * modes * k};
        marker[k].frame.x[0] = 0.5 * k;
    }
    def.modes = modes, def.Ct0 = Ct0, def.P0 = P0, def.P = P, def.K = K;
    def.markers = 3, def.marker = marker;
    bench_check(mbsr_flex_create(&def, &flex, &error), "waves", error.text);
    free(Ct0);
    return flex;
}

static int add_link(chain *c, int parent, int k)
{
    static const double axes[2][3] = {{0.0, 0.0, 1.0}, {0.0, 1.0, 0.0}};
    const double there[3] = {k + 0.5, -1.0, 0.0};
    mbsr_flexible_def def = mbsr_default_flexible_def();
    int body, middle, end;
    def.parent = parent, def.flex = c->beam;
    def.joint = mbsr_joint_revolute(NULL, NULL, axes[k % 2]);
    const mbsr_error *error = mbsr_model_error(c->model);
    bench_check(mbsr_model_add_flexible(c->model, &def, &body), "link", error->text);
    bench_check(mbsr_model_add_marker(c->model, body, c->last / 2, NULL, &middle), "marker",
                error->text);
    bench_check(mbsr_model_add_marker(c->model, body, c->last, NULL, &end), "marker", error->text);
    const mbsr_force_def spring =
        mbsr_force_point_spring(middle, NULL, MBSR_GROUND, there, 10.0, 0.5, 1.0);
    bench_check(mbsr_model_add_force(c->model, &spring, NULL), "spring", error->text);
    return end;
}

static void make_chain(chain *c, const struct bench_case *of)
{
    const mbsr_force_def gravity = mbsr_force_gravity(0.0, -9.81, 0.0);
    const bool waves = strncmp(of->name, "waves", 5) == 0;
    c->last = waves ? 2 : strcmp(of->name, "chain") == 0 ? ELEMENTS : 2 * ELEMENTS;
    c->beam = waves ? make_waves(of->modes) : make_beam(of, c->last);
    bench_check(mbsr_model_create(NULL, &c->model, NULL), "model", NULL);
    c->links = of->links;
    int end = MBSR_GROUND;
    for (int k = 0; k < c->links; ++k) end = add_link(c, end, k);
    const mbsr_error *e = mbsr_model_error(c->model);
    bench_check(mbsr_model_add_force(c->model, &gravity, NULL), "gravity", e->text);
    bench_check(mbsr_model_finish(c->model), "finish", e->text);
    for (int i = 1; i <= c->model->bodies && strstr(of->name, "_blocks"); ++i)
        c->model->body[i].flexible.factored = false;
    bench_check(mbsr_data_create(c->model, &c->data, NULL), "data", NULL);
    bench_check(mbsr_newton_create(c->model, MBSR_DAE_MOMENTUM, NULL, &c->newton, NULL), "newton",
                NULL);
    const size_t n = (size_t)mbsr_model_nu(c->model);
    c->q = bench_allocate(15 * n, sizeof *c->q);
    c->u = c->q + n, c->udot = c->u + n, c->y = c->udot + n;
    c->yp = c->y + 3 * n, c->F = c->yp + 3 * n, c->x = c->F + 3 * n;
    for (size_t k = 0; k < n; ++k) {
        c->q[k] = 0.01 * sin(1.0 + (double)k);
        c->u[k] = 0.1 * cos((double)k);
    }
    bench_check(mbsr_dae_pack(c->model, c->data, MBSR_DAE_MOMENTUM, 0.0, c->q, c->u, c->y), "pack",
                mbsr_data_error(c->data)->text);
    for (int task = 0; task < TASKS; ++task) c->repeats[task] = 1;
}

static void free_chain(chain *c)
{
    mbsr_newton_destroy(c->newton);
    mbsr_data_destroy(c->data);
    mbsr_model_destroy(c->model);
    mbsr_flex_destroy(c->beam);
    free(c->q);
}

static int run(chain *c, int task)
{
    if (task == 0) {
        const int status = mbsr_forward_dynamics(c->model, c->data, 0.0, c->q, c->u, NULL, c->udot);
        return status == MBSR_UNDETERMINED ? MBSR_OK : status;
    }
    if (task == 1)
        return mbsr_dae_residual(c->model, c->data, MBSR_DAE_MOMENTUM, 0.0, c->y, c->yp, c->F);
    const int status = mbsr_newton_factor(c->newton, c->data, 0.0, c->y, c->yp, 1000.0);
    return status ? status : mbsr_newton_solve(c->newton, c->F, c->x);
}

/* Nanoseconds per link of a call, the mean over as many as last 5 ms. */
static double measure(void *context, int which)
{
    chain *c = (chain *)context + which / TASKS;
    const int task = which % TASKS;
    bench_check(run(c, task), task_name[task], mbsr_data_error(c->data)->text);
    for (;;) {
        const double start = bench_now();
        for (int k = 0; k < c->repeats[task]; ++k) run(c, task);
        const double time = bench_now() - start;
        if (time >= sample_time) return 1e9 * time / c->repeats[task] / c->links;
        c->repeats[task] *= 2;
    }
}

/* Steps of the driver from rest; *seconds: what they take. */
static long fall(chain *c, double *seconds)
{
    const size_t n = (size_t)mbsr_model_nu(c->model);
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    mbsr_consistent_info info;
    mbsr_ida_stats stats;
    mbsr_error error = {0};
    mbsr_ida *ida;
    double t;
    const mbsr_error *e = mbsr_data_error(c->data);
    for (size_t k = 0; k < n; ++k) c->q[k] = c->u[k] = 0.0;
    for (size_t k = 0; k < 3 * n; ++k) c->yp[k] = 0.0;
    bench_check(mbsr_dae_pack(c->model, c->data, MBSR_DAE_MOMENTUM, 0.0, c->q, c->u, c->y), "pack",
                e->text);
    bench_check(
        mbsr_dae_consistent(c->model, c->data, MBSR_DAE_MOMENTUM, 0.0, c->y, c->yp, NULL, &info),
        "start", e->text);
    opt.rtol = opt.atol = 1e-6;
    bench_check(mbsr_ida_create(c->model, c->data, &opt, &ida, &error), "ida", error.text);
    bench_check(mbsr_ida_start(ida, 0.0, c->y, c->yp), "ida start", mbsr_ida_error(ida)->text);
    const double start = bench_now();
    bench_check(mbsr_ida_advance(ida, c->links > 100 ? 0.02 : 0.2, &t, c->y, c->yp), "run",
                mbsr_ida_error(ida)->text);
    *seconds = bench_now() - start;
    mbsr_ida_get_stats(ida, &stats);
    mbsr_ida_destroy(ida);
    return stats.steps;
}

int main(int argc, char **argv)
{
    const int samples = argc > 1 ? atoi(argv[1]) : SAMPLES, links = argc > 2 ? atoi(argv[2]) : 0;
    const struct bench_case *wanted[CASES];
    chain chains[CASES] = {0};
    int count = 0;
    for (int k = 0; k < CASES; ++k) {
        if (links == 0 || links == cases[k].links) wanted[count++] = cases + k;
    }
    if (samples < 1 || count == 0) {
        fprintf(stderr, "usage: bench_flexible [samples [links]]\n");
        return EXIT_FAILURE;
    }
    for (int k = 0; k < count; ++k) make_chain(chains + k, wanted[k]);
    double *sample = bench_allocate((size_t)(count * TASKS * samples), sizeof *sample);
    bench_sample_all(count * TASKS, samples, measure, chains, sample);
    bench_header(stdout, "libmbsrank: time per flexible body of chains with massless modes");
    printf("chain,links,modes,task,value,min,q1,q3,samples\n");
    for (int k = 0; k < count * TASKS; ++k) {
        const struct bench_case *of = wanted[k / TASKS];
        const bench_quartiles time = bench_statistics(samples, sample + k * samples);
        printf("%s,%d,%d,%s,%.0f,%.0f,%.0f,%.0f,%d\n", of->name, of->links, of->modes,
               task_name[k % TASKS], time.median, time.min, time.q1, time.q3, samples);
    }
    free(sample);
    for (int k = 0; k < count; ++k) {
        double seconds;
        const long steps = strcmp(wanted[k]->name, "chain") == 0 ? fall(chains + k, &seconds) : 0;
        if (steps > 0)
            printf("steps,%d,%d,us_per_step,%ld,%.1f,,,\n", wanted[k]->links, wanted[k]->modes,
                   steps, 1e6 * seconds / (double)steps);
        free_chain(chains + k);
    }
    return EXIT_SUCCESS;
}
