/* What an output of a run costs beside a step: completed and as it is interpolated.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   bench_outputs [samples [outputs]]      CSV on standard output; default 5 and 20 000
 *
 * CPU time of whole runs of simulation.h with default options: with one output at the end, with so
 * many, and with so many that are interpolated (`raw_outputs`). An output costs what runs with and
 * without differ by, over the outputs. Medians of the samples, whose runs take turns. */
#include "bench.h"

#include <mbsrank/simulation.h>

#include <math.h>
#include <stdlib.h>

enum { SAMPLES = 5, OUTPUTS = 20000, POINTS = 600, WAYS = 3 };
typedef enum way { ONE, COMPLETED, RAW } way;

typedef struct model {
    const char *name;
    void (*build)(mbsr_simulation *s, const struct model *m);
    int count;
    double damping; /* of mounts without mass; 0: springs alone hold them */
    double coupler; /* kg */
} model;

static const double x[3] = {1.0, 0.0, 0.0}, y[3] = {0.0, 1.0, 0.0}, z[3] = {0.0, 0.0, 1.0},
                    origin[3] = {0.0};

/* A wheel carrier and a quarter of a car, between them a mount without mass, on a road that is a
 * table. */
static void quarter_car(mbsr_simulation *s, const model *m)
{
    static double t[POINTS], height[POINTS];
    const mbsr_axis rise = {MBSR_AXIS_TRANSLATION, {0, 0, 1}, 0, 1};
    for (int k = 0; k < POINTS; ++k) {
        t[k] = 0.01 * k;
        height[k] = 0.02 * sin(7.0 * t[k]) * sin(31.0 * t[k] * t[k]);
    }
    mbsr_table *road = mbsr_simulation_add_table(s, MBSR_TABLE_SPLINE, POINTS, t, height);
    const int patch = mbsr_simulation_add_body(
        s, "patch", MBSR_GROUND, mbsr_joint_compound(NULL, NULL, 1, &rise, mbsr_table_motion, road),
        mbsr_inertia_zero());
    const int carrier = mbsr_simulation_add_body(
        s, "carrier", patch, mbsr_joint_prismatic(NULL, NULL, z), mbsr_inertia_particle(35.0));
    const int mount = mbsr_simulation_add_body(
        s, "mount", carrier, mbsr_joint_prismatic(NULL, NULL, z), mbsr_inertia_zero());
    const int car = mbsr_simulation_add_body(s, "car", mount, mbsr_joint_prismatic(NULL, NULL, z),
                                             mbsr_inertia_particle(357.0));
    mbsr_simulation_add_force(s, mbsr_force_joint_spring(carrier, 0, 1.7e5, 100.0, 0.0));
    mbsr_simulation_add_force(s, mbsr_force_joint_spring(mount, 0, 2e4, m->damping, 0.0));
    mbsr_simulation_add_force(s, mbsr_force_joint_spring(car, 0, 2e5, 0.0, 0.0));
}

/* A chain of rods; with damping >= 0 a mount without mass at each end, and a particle behind it. */
static void chain(mbsr_simulation *s, const model *m)
{
    const mbsr_frame tip = mbsr_frame_at(1.0, 0.0, 0.0);
    int last = MBSR_GROUND;
    for (int k = 0; k < m->count; ++k) {
        const int rod =
            mbsr_simulation_add_body(s, "rod", last, mbsr_joint_revolute(k ? &tip : NULL, NULL, y),
                                     mbsr_inertia_rod(1.0, origin, x));
        mbsr_simulation_add_force(s, mbsr_force_joint_spring(rod, 0, 50.0, 1.0, 0.0));
        last = rod;
        if (m->damping < 0.0) continue;
        const int mount = mbsr_simulation_add_body(
            s, "mount", rod, mbsr_joint_prismatic(&tip, NULL, y), mbsr_inertia_zero());
        const int mass = mbsr_simulation_add_body(
            s, "mass", mount, mbsr_joint_prismatic(NULL, NULL, y), mbsr_inertia_particle(0.2));
        mbsr_simulation_add_force(s, mbsr_force_joint_spring(mount, 0, 2000.0, m->damping, 0.0));
        mbsr_simulation_add_force(s, mbsr_force_joint_spring(mass, 0, 1000.0, 0.0, 0.01));
    }
    mbsr_simulation_add_force(s, mbsr_force_gravity(0.0, 2.0, -9.81));
}

/* Parallelograms side by side. */
static void four_bars(mbsr_simulation *s, const model *m)
{
    const mbsr_frame tip = mbsr_frame_at(0.0, 0.0, 1.0);
    const double rows[6] = {1.0, 0.0, 0.0, 0.0, 0.0, 1.0};
    for (int k = 0; k < m->count; ++k) {
        const mbsr_frame left = mbsr_frame_at(0.0, k, 0.0), right = mbsr_frame_at(1.0, k, 0.0);
        const mbsr_inertia rod = mbsr_inertia_rod(1.0, origin, z);
        const int crank = mbsr_simulation_add_body(s, "crank", MBSR_GROUND,
                                                   mbsr_joint_revolute(&left, NULL, y), rod);
        const int coupler = mbsr_simulation_add_body(
            s, "coupler", crank, mbsr_joint_revolute(&tip, NULL, y),
            m->coupler > 0.0 ? mbsr_inertia_rod(m->coupler, origin, x) : mbsr_inertia_zero());
        const int rocker = mbsr_simulation_add_body(s, "rocker", MBSR_GROUND,
                                                    mbsr_joint_revolute(&right, NULL, y), rod);
        mbsr_simulation_add_closure(s, mbsr_closure_rows(coupler, x, rocker, z, 2, rows));
    }
    mbsr_simulation_add_force(s, mbsr_force_gravity(1.0, 0.0, -9.81));
}

static const model models[] = {{"quarter_car", quarter_car, 1, 2570.0, 0.0},
                               {"quarter_car_on_springs", quarter_car, 1, 0.0, 0.0},
                               {"chain", chain, 20, -1.0, 0.0},
                               {"chain_with_mounts", chain, 10, 20.0, 0.0},
                               {"chain_with_mounts", chain, 100, 20.0, 0.0},
                               {"chain_with_mounts_on_springs", chain, 10, 0.0, 0.0},
                               {"four_bars", four_bars, 1, 0.0, 1.0},
                               {"four_bars", four_bars, 30, 0.0, 1.0},
                               {"four_bars_massless", four_bars, 1, 0.0, 0.0},
                               {"four_bars_massless", four_bars, 30, 0.0, 0.0}};
enum { MODELS = sizeof models / sizeof models[0] };

/* CPU time of a run of 5 s. */
static double run(const model *m, way how, int outputs, mbsr_ida_stats *stats, int *bodies)
{
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    const int count = how == ONE ? 1 : outputs;
    opt.raw_outputs = how == RAW;
    m->build(&s, m);
    mbsr_simulation_start(&s, &opt, 0.0, NULL, NULL);
    const double begin = bench_now();
    for (int k = 1; k <= count; ++k) mbsr_simulation_to(&s, 5.0 * k / count);
    const double time = bench_now() - begin;
    bench_check(s.status, m->name, s.error.text);
    mbsr_simulation_get_stats(&s, stats);
    *bodies = mbsr_model_bodies(s.model);
    mbsr_simulation_end(&s);
    return time;
}

int main(int argc, char **argv)
{
    const int samples = argc > 1 ? atoi(argv[1]) : SAMPLES,
              outputs = argc > 2 ? atoi(argv[2]) : OUTPUTS;
    bench_check(samples < 1 || outputs < 1, "samples and outputs, 1 at least", NULL);
    bench_header(stdout, "outputs of runs over 5 s, default options, CPU time");
    printf("model,bodies,outputs,steps,raw_states,step_us,output_us,raw_us,output_over_step\n");
    for (int k = 0; k < MODELS; ++k) {
        double *time[WAYS], median[WAYS];
        mbsr_ida_stats stats[WAYS];
        int bodies = 0;
        for (int j = 0; j < WAYS; ++j) time[j] = bench_allocate((size_t)samples, sizeof *time[j]);
        for (int n = 0; n < samples; ++n) {
            for (int j = 0; j < WAYS; ++j)
                time[j][n] = run(models + k, (way)j, outputs, stats + j, &bodies);
        }
        for (int j = 0; j < WAYS; ++j) {
            median[j] = bench_statistics(samples, time[j]).median;
            free(time[j]);
        }
        const double step = median[ONE] / (double)stats[ONE].steps,
                     output = (median[COMPLETED] - median[ONE]) / outputs,
                     raw = (median[RAW] - median[ONE]) / outputs;
        printf("%s,%d,%d,%ld,%ld,%.3g,%.3g,%.3g,%.2f\n", models[k].name, bodies, outputs,
               stats[ONE].steps, stats[COMPLETED].raw_states, 1e6 * step, 1e6 * output, 1e6 * raw,
               output / step);
        fflush(stdout);
    }
    return 0;
}
