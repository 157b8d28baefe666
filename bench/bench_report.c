/* Time of index reports on chains of massless carts.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   bench_report [samples]     CSV on standard output
 *
 * Carts on a line, all but the last without mass. `apart`: each on the one before it, a damper in
 * each joint, so that no direction acts on another. `in_a_row`: each on the ground, and dampers
 * between neighbours, so that all directions hang together; with `springs` in parallel. */
#include "bench.h"

#include <mbsrank/mbsrank.h>

#include <stdlib.h>

enum { SAMPLES = 7, SIZES = 3, KINDS = 3 };

static const int sizes[SIZES] = {75, 150, 300};
static const char *const kind_name[KINDS] = {"apart", "in_a_row", "in_a_row_springs"};

typedef struct chain {
    mbsr_model *model;
    mbsr_data *data;
    double *q, *u;
    int directions;
} chain;

static void add_cart(chain *c, int k, int kind)
{
    static const double line[3] = {1.0, 0.0, 0.0}, centre[3] = {0.0, 0.0, 0.0};
    const double stiffness = kind == 2 ? 3.0 : 0.0, damping = 2.0 + 0.01 * k;
    const mbsr_frame start = mbsr_frame_at(0.0, 0.0, 0.0);
    const mbsr_gear between = {.ratio = 1.0, .stiffness = stiffness, .damping = damping};
    mbsr_body_def def = mbsr_default_body_def();
    def.parent = kind == 0 && k > 0 ? k - 1 : MBSR_GROUND;
    def.joint = mbsr_joint_prismatic(&start, NULL, line);
    if (k == c->directions) def.inertia = mbsr_inertia_point_mass(1.0, centre);
    bench_check(mbsr_model_add_body(c->model, &def, NULL), "body", NULL);
    const mbsr_force_def damper = kind == 0 || k == 0
                                      ? mbsr_force_joint_spring(k, 0, stiffness, damping, 0.0)
                                      : mbsr_force_gear(k - 1, 0, k, 0, &between);
    bench_check(mbsr_model_add_force(c->model, &damper, NULL), "damper", NULL);
}

static void build(chain *c, int directions, int kind)
{
    c->directions = directions;
    bench_check(mbsr_model_create(NULL, &c->model, NULL), "model", NULL);
    for (int k = 0; k <= directions; ++k) add_cart(c, k, kind);
    bench_check(mbsr_model_finish(c->model), "finish", mbsr_model_error(c->model)->text);
    bench_check(mbsr_data_create(c->model, &c->data, NULL), "data", NULL);
    c->q = bench_allocate((size_t)directions + 1, sizeof *c->q);
    c->u = bench_allocate((size_t)directions + 1, sizeof *c->u);
}

static double measure(void *context, int which)
{
    chain *c = (chain *)context + which;
    mbsr_index_report *report = NULL;
    const double start = bench_now();
    const int status = mbsr_index_report_create(c->model, c->data, 0.0, c->q, c->u, &report);
    const double time = bench_now() - start;
    bench_check(status, "report", mbsr_data_error(c->data)->text);
    bench_check(report->damped != c->directions, "verdict", NULL);
    mbsr_index_report_destroy(c->model, report);
    return time;
}

int main(int argc, char **argv)
{
    const int samples = argc > 1 ? atoi(argv[1]) : SAMPLES;
    chain chains[SIZES * KINDS];
    double *time = bench_allocate((size_t)(SIZES * KINDS * samples), sizeof *time);
    for (int k = 0; k < SIZES * KINDS; ++k) build(chains + k, sizes[k % SIZES], k / SIZES);
    bench_sample_all(SIZES * KINDS, samples, measure, chains, time);
    bench_header(stdout, "time of index reports of chains of massless carts");
    printf("chain,directions,ms,min,q1,q3,samples\n");
    for (int k = 0; k < SIZES * KINDS; ++k) {
        const bench_quartiles t = bench_statistics(samples, time + k * samples);
        printf("%s,%d,%.2f,%.2f,%.2f,%.2f,%d\n", kind_name[k / SIZES], sizes[k % SIZES],
               1e3 * t.median, 1e3 * t.min, 1e3 * t.q1, 1e3 * t.q3, samples);
        mbsr_data_destroy(chains[k].data);
        mbsr_model_destroy(chains[k].model);
        free(chains[k].q);
        free(chains[k].u);
    }
    free(time);
    return 0;
}
