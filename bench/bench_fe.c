/* Reduction of solid bars and cubes from finite elements: time by stage, memory, and what the modes
 * are worth.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   bench_fe [largest number of dofs]     CSV on standard output; default 110000
 *
 * 20 normal modes of the body held at one end, and static modes for all loads of the other.
 * `frequency_error`: largest relative difference of the first ten frequencies from a reduction to
 * tolerance 1e-13 that seeks four modes more; `tip_error`: of the flexibility at the tip, six by
 * six, from the static solution alone (no normal modes). Memory is the most that the process had up
 * to then; sizes ascend, bars before cubes. */
#include "bench.h"
#include "hex8.h"

#include <mbsrank/fe.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

enum { CASES = 6, MODES = 20, STAGES = 5 };

static const struct {
    const char *shape;
    int elements[3];
    double size[3];
} cases[CASES] = {
    {"bar", {20, 4, 3}, {1.0, 0.1, 0.08}},    {"cube", {6, 6, 6}, {1.0, 1.0, 1.0}},
    {"bar", {66, 7, 5}, {1.0, 0.1, 0.08}},    {"cube", {14, 14, 14}, {1.0, 1.0, 1.0}},
    {"bar", {150, 16, 12}, {1.0, 0.1, 0.08}}, {"cube", {31, 31, 31}, {1.0, 1.0, 1.0}},
};

static const char *const stages[STAGES] = {"checks", "factorisation", "normal modes",
                                           "static modes", "integrals"};

typedef struct clock_of_stages {
    int stage;
    double since, spent[STAGES];
} clock_of_stages;

static int note(void *user, const char *stage, double done)
{
    clock_of_stages *c = user;
    const double now = bench_now();
    (void)done;
    c->spent[c->stage] += now - c->since;
    c->since = now;
    for (int k = 0; k < STAGES; ++k) {
        if (strcmp(stage, stages[k]) == 0) c->stage = k;
    }
    return 0;
}

static mbsr_fe_report *reduce(const mbsr_fe_def *def, mbsr_flex **flex)
{
    mbsr_fe_report *report;
    mbsr_error error;
    bench_check(mbsr_fe_reduce(def, flex, &report, &error), "reduction", error.text);
    return report;
}

/* F (6 x 6): motion of the tip under unit loads there, of modes with K diagonal. */
static void flexibility(const mbsr_flex *flex, double F[36])
{
    mbsr_flex_def data;
    bench_check(mbsr_flex_definition(flex, &data), "data", NULL);
    memset(F, 0, 36 * sizeof *F);
    for (int a = 0; a < data.modes; ++a) {
        const double *Phi = data.marker[1].Phi + 3 * a, *Psi = data.marker[1].Psi + 3 * a;
        const double motion[6] = {Psi[0], Psi[1], Psi[2], Phi[0], Phi[1], Phi[2]};
        for (int k = 0; k < 36; ++k)
            F[k] += motion[k / 6] * motion[k % 6] / data.K[a * (data.modes + 1)];
    }
}

static double tip_error(const mbsr_flex *flex, const mbsr_flex *whole)
{
    double F[36], exact[36], worst = 0.0;
    flexibility(flex, F);
    flexibility(whole, exact);
    for (int k = 0; k < 36; ++k)
        worst = fmax(worst, fabs(F[k] - exact[k]) / sqrt(exact[7 * (k / 6)] * exact[7 * (k % 6)]));
    return worst;
}

static void print(const char *shape, const hex8_mesh *mesh, const mbsr_fe_def *given)
{
    clock_of_stages c = {.since = bench_now()};
    mbsr_flex *flex, *whole, *exact;
    struct rusage usage;
    mbsr_fe_def def = *given;
    def.modes = MODES;
    def.progress = note, def.user = &c;
    mbsr_fe_report *report = reduce(&def, &flex);
    (void)note(&c, stages[0], 1.0);
    getrusage(RUSAGE_SELF, &usage);
    def.progress = NULL;
    def.modes = MODES + 4, def.tolerance = 1e-13;
    mbsr_fe_report *tight = reduce(&def, &exact);
    def.modes = 0;
    mbsr_fe_report *still = reduce(&def, &whole);
    double worst = 0.0, all = 0.0;
    for (int k = 0; k < 10; ++k)
        worst = fmax(worst, fabs(report->omega[k] / tight->omega[k] - 1.0));
    for (int k = 0; k < STAGES; ++k) all += c.spent[k];
    printf("%s,%d,%s,%.4g,%d,%.3f,%.3f,%.3f,%.3f,%.3f,%.3f,%.0f,%.1e,%.1e\n", shape, mesh->dofs,
           report->solver == MBSR_FE_DENSE ? "LAPACK" : "CHOLMOD", report->entries, report->solves,
           all, c.spent[0], c.spent[1], c.spent[2], c.spent[3], c.spent[4],
           (double)usage.ru_maxrss / 1024.0, worst, tip_error(flex, whole));
    fflush(stdout);
    mbsr_fe_report_destroy(report);
    mbsr_fe_report_destroy(tight);
    mbsr_fe_report_destroy(still);
    mbsr_flex_destroy(flex);
    mbsr_flex_destroy(exact);
    mbsr_flex_destroy(whole);
}

static void measure(int which)
{
    const int *n = cases[which].elements, face = (n[1] + 1) * (n[2] + 1);
    hex8_block block = {.E = 2.1e11, .nu = 0.3, .rho = 7800.0, .incompatible = 1};
    hex8_mesh mesh;
    int *node[2];
    mbsr_fe_marker marker[2];
    memcpy(block.elements, n, sizeof block.elements);
    memcpy(block.size, cases[which].size, sizeof block.size);
    bench_check(hex8_make(&block, &mesh), "mesh", NULL);
    for (int end = 0; end < 2; ++end) {
        node[end] = bench_allocate((size_t)face, sizeof *node[end]);
        for (int k = 0; k < face; ++k)
            node[end][k] = hex8_node(&block, end * n[0], k / (n[2] + 1), k % (n[2] + 1));
        marker[end] = (mbsr_fe_marker){.nodes = face, .node = node[end], .loaded = end};
    }
    mbsr_fe_def def = mbsr_default_fe_def();
    def.K = (mbsr_fe_matrix){.rows = mesh.dofs,
                             .entries = (size_t)mesh.entries,
                             .row = mesh.row,
                             .column = mesh.column,
                             .value = mesh.K};
    def.M = def.K;
    def.M.value = mesh.M;
    def.nodes = mesh.nodes, def.x = mesh.x;
    def.markers = 2, def.marker = marker;
    print(cases[which].shape, &mesh, &def);
    free(node[0]);
    free(node[1]);
    hex8_destroy(&mesh);
}

int main(int argc, char **argv)
{
    const int largest = argc > 1 ? atoi(argv[1]) : 110000;
    bench_header(stdout, "reduction of solids from finite elements");
    printf("shape,dofs,factor,entries,solves,s,checks,factorisation,normal_modes,static_modes,"
           "integrals,MB,frequency_error,tip_error\n");
    for (int k = 0; k < CASES; ++k) {
        const int *n = cases[k].elements;
        if (3 * (n[0] + 1) * (n[1] + 1) * (n[2] + 1) <= largest) measure(k);
    }
    return 0;
}
