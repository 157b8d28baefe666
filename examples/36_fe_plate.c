/* A plate of solid elements becomes a flexible body: frequencies against closed form, and massless
 * static modes at a corner.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Without Poisson's ratio a free plate bends like a beam along either edge, omega = (beta / L)^2 (E
 * h^2 / 12 rho)^1/2, cos beta cosh beta = 1, whatever its width. Meshes of bricks come close with
 * the square of their edges; what remains is shear and rotary inertia, which the theory of thin
 * plates leaves out.
 *
 * Held by a hinge at one edge, a corner is pushed by a tool, 1 N within 0.02 s. With a few normal
 * modes it gives way too little; the rest is in three static modes of the corner, which cost
 * nothing when they have no mass. fe_plate.csv and fe_plate_corner.csv have the numbers for
 * fe_plate.gp. */
#include "hex8.h"
#include "run.h"

#include <mbsrank/fe.h>
#include <mbsrank/simulation.h>

enum { MESHES = 3, BEAMS = 3, SAMPLES = 200, TREATMENTS = 3 };

static const double size[3] = {0.5, 0.25, 0.004}, E = 7e10, rho = 2700.0, T = 0.1; /* m, SI */

static hex8_block plate(int refined)
{
    return (hex8_block){.elements = {4 << refined, 2 << refined, 1},
                        .size = {size[0], size[1], size[2]},
                        .E = E,
                        .rho = rho,
                        .incompatible = 1};
}

/* A model whose root is the edge x = 0 and whose other marker is the corner farthest along x and y.
 */
typedef struct model {
    hex8_block block;
    hex8_mesh mesh;
    int edge[100], corner;
    mbsr_fe_marker marker[2];
    mbsr_fe_def def;
} model;

static void make(int refined, model *m)
{
    m->block = plate(refined);
    if (hex8_make(&m->block, &m->mesh)) exit(1);
    const int *n = m->block.elements, nodes = 2 * (n[1] + 1);
    for (int k = 0; k < nodes; ++k) m->edge[k] = hex8_node(&m->block, 0, k / 2, k % 2);
    m->corner = hex8_node(&m->block, n[0], n[1], 1);
    m->marker[0] = (mbsr_fe_marker){.name = "edge", .nodes = nodes, .node = m->edge};
    m->marker[1] = (mbsr_fe_marker){.name = "corner", .nodes = 1, .node = &m->corner, .loaded = 1};
    m->def = mbsr_default_fe_def();
    m->def.K = (mbsr_fe_matrix){.rows = m->mesh.dofs,
                                .entries = (size_t)m->mesh.entries,
                                .row = m->mesh.row,
                                .column = m->mesh.column,
                                .value = m->mesh.K};
    m->def.M = m->def.K;
    m->def.M.value = m->mesh.M;
    m->def.nodes = m->mesh.nodes, m->def.x = m->mesh.x;
    m->def.markers = 2, m->def.marker = m->marker;
    m->def.damping = 0.02;
}

static mbsr_flex *reduce(const mbsr_fe_def *def, mbsr_fe_report **report)
{
    mbsr_flex *flex;
    mbsr_error error;
    check(mbsr_fe_reduce(def, &flex, report, &error), &error);
    return flex;
}

/* ---- frequencies of the free plate ---- */

/* The first modes that bend like a beam: two along x, one along y. */
static const double beta[BEAMS] = {4.730040744862704, 7.853204624095838, 4.730040744862704};
static const int along[BEAMS] = {0, 0, 1};

/* Largest relative error of the finest mesh. */
static double frequencies(void)
{
    double worst = 0.0;
    FILE *file = csv("fe_plate.csv");
    printf("free plate, frequencies against closed form\n  mesh       dofs");
    for (int b = 0; b < BEAMS; ++b) {
        const double L = size[along[b]], omega = beta[b] * beta[b] / (L * L) *
                                                 sqrt(E * size[2] * size[2] / (12.0 * rho));
        printf("   %8.2f /s", omega);
    }
    printf("\n");
    for (int r = 0; r < MESHES; ++r) {
        model m;
        mbsr_fe_report *report;
        make(r + 1, &m);
        m.def.free = 1, m.def.modes = 14;
        mbsr_flex_destroy(reduce(&m.def, &report));
        printf("%3d x %2d  %8d", m.block.elements[0], m.block.elements[1], report->dofs);
        fprintf(file, "%d", m.block.elements[0]);
        worst = 0.0;
        for (int b = 0; b < BEAMS; ++b) {
            const double L = size[along[b]], omega = beta[b] * beta[b] / (L * L) *
                                                     sqrt(E * size[2] * size[2] / (12.0 * rho));
            double error = 1.0;
            for (int k = 0; k < report->normal; ++k) {
                if (fabs(report->omega[k] / omega - 1.0) < fabs(error))
                    error = report->omega[k] / omega - 1.0;
            }
            printf("  %11.2e", error);
            fprintf(file, ",%g", error);
            worst = fmax(worst, fabs(error));
        }
        printf("\n");
        fprintf(file, "\n");
        mbsr_fe_report_destroy(report);
        hex8_destroy(&m.mesh);
    }
    fclose(file);
    return worst;
}

/* ---- a push at the corner ---- */

static int push(void *user, double t, int n, double *value)
{
    const double pi = acos(-1.0);
    (void)user;
    for (int k = 0; k < n; ++k) value[k] = 0.0;
    value[5] = t < 0.02 ? 0.5 * (1.0 - cos(pi * t / 0.02)) : 1.0;
    return MBSR_OK;
}

/* The corner's z over time, m; steps. */
static long run(const mbsr_flex *flex, double tolerance, double z[SAMPLES])
{
    static const double axis[3] = {0.0, 1.0, 0.0};
    const mbsr_servo servo = {.kp = 400.0, .kd = 4.0};
    double zero[100] = {0.0}, pose[MBSR_POSE_SIZE];
    int body, corner;
    mbsr_model *m = new_model();
    mbsr_flexible_def def = mbsr_default_flexible_def();
    def.name = "plate", def.flex = flex, def.joint = mbsr_joint_revolute(NULL, NULL, axis);
    check(mbsr_model_add_flexible(m, &def, &body), mbsr_model_error(m));
    check(mbsr_model_add_marker(m, body, 1, "corner", &corner), mbsr_model_error(m));
    add_force(m, mbsr_force_joint_servo(body - 1, 0, &servo));
    add_force(m, mbsr_force_wrench(corner, NULL, 0, push, NULL));
    mbsr_simulation s = run_start(m, zero, zero, tolerance);
    for (int k = 0; k < SAMPLES; ++k) {
        run_to(&s, T * (k + 1) / SAMPLES);
        check(mbsr_body_pose(s.model, s.data, corner, pose), mbsr_data_error(s.data));
        z[k] = pose[MBSR_POSE_X + 2];
    }
    const long steps = run_steps(&s);
    mbsr_simulation_end(&s);
    return steps;
}

/* Returns whether massless static modes are worth it. */
static int corner(void)
{
    static const char *const name[TREATMENTS] = {"left out", "with mass", "massless"};
    double reference[SAMPLES], z[TREATMENTS][SAMPLES], error[TREATMENTS] = {0.0}, large = 0.0;
    long steps[TREATMENTS];
    model m;
    mbsr_fe_report *report;
    make(1, &m);
    m.def.modes = 20;
    mbsr_flex *flex = reduce(&m.def, NULL);
    run(flex, 1e-7, reference);
    mbsr_flex_destroy(flex);
    printf("\npush at a corner; static modes    steps   corner off by [mm]\n");
    for (int how = 0; how < TREATMENTS; ++how) {
        m.def.modes = 2;
        m.marker[1].loaded = how > 0;
        m.def.cutoff = how == 1 ? INFINITY : 0.0;
        flex = reduce(&m.def, &report);
        steps[how] = run(flex, 1e-6, z[how]);
        for (int k = 0; k < SAMPLES; ++k) {
            error[how] = fmax(error[how], fabs(z[how][k] - reference[k]));
            large = fmax(large, fabs(reference[k]));
        }
        printf("%-30s   %6ld   %16.4f\n", name[how], steps[how], 1e3 * error[how]);
        if (how == 2) printf("it gives way by %.2f mm\n\n%s", 1e3 * large, report->text);
        mbsr_fe_report_destroy(report);
        mbsr_flex_destroy(flex);
    }
    hex8_destroy(&m.mesh);
    FILE *file = csv("fe_plate_corner.csv");
    for (int k = 0; k < SAMPLES; ++k) {
        fprintf(file, "%g,%g", T * (k + 1) / SAMPLES, reference[k]);
        for (int how = 0; how < TREATMENTS; ++how) fprintf(file, ",%g", z[how][k] - reference[k]);
        fprintf(file, "\n");
    }
    fclose(file);
    return 2 * steps[2] < 3 * steps[0] && 5.0 * error[2] < error[0];
}

int main(void)
{
    const double worst = frequencies();
    return corner() && worst < 1e-2 ? 0 : 1;
}
