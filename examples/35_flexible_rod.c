/* A slider-crank with a flexible connecting rod, and four ways to treat its static modes.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Data of the slider crank in the Test Set for IVP Solvers: crank 0.15 m, steel rod 0.3 m of 8 mm x
 * 8 mm, here brought up to 150 rad/s within 20 ms. The rod is held at the crank pin, and the loop
 * is closed at the marker on its other end: two rows to the piston's pin. Normal modes of a rod
 * clamped at the crank know nothing of the force there; static modes do. They may be left out, kept
 * with their mass and high frequencies, or kept without mass, with damping or without. Looked at is
 * how far the rod's middle leaves the line between the pins, for three normal modes against six and
 * the static ones. flexible_rod.csv has it for flexible_rod.gp. */
#include <mbsrank/simulation.h>

#include "run.h"

#include <math.h>
#include <string.h>

enum { ELEMENTS = 16, SAMPLES = 500, MOST = 12, WAYS = 4 };
static const double r = 0.15, l = 0.3, omega = 150.0, ramp = 0.02; /* m, rad/s, s */
static double T = 0.1;

/* The crank's angle: up to speed by half a wave of a cosine. */
static int turn(void *user, double t, double *angle, double *rate, double *second)
{
    const double k = acos(-1.0) / ramp, s = t < ramp ? t : ramp;
    (void)user;
    *angle = 0.5 * omega * (s - sin(k * s) / k) + omega * (t - s);
    *rate = 0.5 * omega * (1.0 - cos(k * s));
    *second = t < ramp ? 0.5 * omega * k * sin(k * s) : 0.0;
    return MBSR_OK;
}

typedef enum treatment { LEFT_OUT, WITH_MASS, MASSLESS, UNDAMPED } treatment;

static mbsr_flex *make_rod(int modes, treatment how)
{
    static const int end = ELEMENTS;
    mbsr_beam_def def = mbsr_default_beam_def();
    mbsr_flex_def data;
    mbsr_flex *flex, *bare;
    mbsr_error error;
    double D[MOST * MOST];
    def.length = l, def.density = 0.50368, def.EI_z = 68.27; /* kg/m, N m^2 */
    def.elements = ELEMENTS, def.modes = modes, def.damping = 0.02;
    if (how != LEFT_OUT) def.loaded = 1, def.node = &end;
    if (how == WITH_MASS) def.cutoff = INFINITY;
    check(mbsr_flex_beam(&def, &flex, &error), &error);
    if (how != UNDAMPED) return flex;
    mbsr_flex_definition(flex, &data);
    memcpy(D, data.D, (size_t)(data.modes * data.modes) * sizeof *D);
    for (int k = modes; k < data.modes; ++k) D[k * (data.modes + 1)] = 0.0;
    data.D = D;
    check(mbsr_flex_create(&data, &bare, &error), &error);
    mbsr_flex_destroy(flex);
    return bare;
}

/* The ids of what is looked at. */
typedef struct parts {
    int crank, middle, end;
} parts;

static mbsr_model *mechanism(const mbsr_flex *flex, parts *p)
{
    static const double x[3] = {1.0, 0.0, 0.0}, z[3] = {0.0, 0.0, 1.0}, com[3] = {0.075, 0.0, 0.0},
                        none[3] = {0.0, 0.0, 0.0},
                        inertia[6] = {0.0, 0.002727, 0.002727, 0.0, 0.0, 0.0},
                        rows[6] = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0};
    const mbsr_axis axis = {.kind = MBSR_AXIS_ROTATION, .direction = {0.0, 0.0, 1.0}, .driven = 1};
    const mbsr_frame pin = mbsr_frame_at(r, 0.0, 0.0), start = mbsr_frame_at(r + l, 0.0, 0.0);
    mbsr_flexible_def rod = mbsr_default_flexible_def();
    mbsr_model *m = new_model();
    int body;
    p->crank =
        add_body(m, "crank", MBSR_GROUND, mbsr_joint_compound(NULL, NULL, 1, &axis, turn, NULL),
                 mbsr_inertia_rigid(0.36, com, inertia));
    rod.name = "rod", rod.parent = p->crank, rod.flex = flex;
    rod.joint = mbsr_joint_revolute(&pin, NULL, z);
    check(mbsr_model_add_flexible(m, &rod, &body), mbsr_model_error(m));
    check(mbsr_model_add_marker(m, body, ELEMENTS / 2, "middle", &p->middle), mbsr_model_error(m));
    check(mbsr_model_add_marker(m, body, ELEMENTS, "end", &p->end), mbsr_model_error(m));
    const int piston = add_body(m, "piston", MBSR_GROUND, mbsr_joint_prismatic(&start, NULL, x),
                                mbsr_inertia_point_mass(0.075552, none));
    mbsr_closure_def closure = mbsr_closure_rows(p->end, NULL, piston, NULL, 2, rows);
    closure.name = "piston pin";
    check(mbsr_model_add_closure(m, &closure, NULL), mbsr_model_error(m));
    add_force(m, mbsr_force_gravity(0.0, -9.81, 0.0));
    return m;
}

/* How far the middle is from the line between the pins, m. */
static double bend(mbsr_simulation *s, const parts *p)
{
    double crank[MBSR_POSE_SIZE], middle[MBSR_POSE_SIZE], end[MBSR_POSE_SIZE];
    mbsr_simulation_check(s, mbsr_body_pose(s->model, s->data, p->crank, crank));
    mbsr_simulation_check(s, mbsr_body_pose(s->model, s->data, p->middle, middle));
    mbsr_simulation_check(s, mbsr_body_pose(s->model, s->data, p->end, end));
    check(s->status, &s->error);
    const double *R = crank + MBSR_POSE_R, *from = crank + MBSR_POSE_X, *to = end + MBSR_POSE_X;
    const double pin[2] = {from[0] + r * R[0], from[1] + r * R[1]};
    const double dx = to[0] - pin[0], dy = to[1] - pin[1];
    return (dx * (middle[MBSR_POSE_X + 1] - pin[1]) - dy * (middle[MBSR_POSE_X] - pin[0])) /
           hypot(dx, dy);
}

static long run(int modes, treatment how, double tolerance, double y[SAMPLES])
{
    static const double rest[MOST + 4] = {0.0};
    parts p;
    mbsr_flex *flex = make_rod(modes, how);
    mbsr_simulation s = run_start(mechanism(flex, &p), rest, rest, tolerance);
    for (int k = 0; k < SAMPLES; ++k) {
        run_to(&s, T * (k + 1) / SAMPLES);
        y[k] = bend(&s, &p);
    }
    const long steps = run_steps(&s);
    mbsr_simulation_end(&s);
    mbsr_flex_destroy(flex);
    return steps;
}

int main(int argc, char **argv)
{
    (void)argv;
    static const char *const name[WAYS] = {"left out", "with mass", "massless",
                                           "massless, undamped"};
    static double reference[SAMPLES], y[WAYS][SAMPLES];
    double error[WAYS] = {0.0}, size = 0.0;
    long steps[WAYS];
    if (argc > 1) T = 0.04;
    run(6, MASSLESS, 1e-7, reference);
    printf("static modes          steps   middle off by [mm]\n");
    for (int how = LEFT_OUT; how <= UNDAMPED; ++how) {
        steps[how] = run(3, (treatment)how, 1e-6, y[how]);
        for (int k = 0; k < SAMPLES; ++k) {
            error[how] = fmax(error[how], fabs(y[how][k] - reference[k]));
            size = fmax(size, fabs(reference[k]));
        }
        printf("%-18s   %6ld   %18.4f\n", name[how], steps[how], 1e3 * error[how]);
    }
    printf("the middle bends by %.2f mm\n", 1e3 * size);
    FILE *file = csv("flexible_rod.csv");
    for (int k = 0; k < SAMPLES; ++k) {
        fprintf(file, "%g,%g", T * (k + 1) / SAMPLES, reference[k]);
        for (int how = 0; how < WAYS; ++how) fprintf(file, ",%g", y[how][k] - reference[k]);
        fprintf(file, "\n");
    }
    fclose(file);
    return 2 * steps[MASSLESS] < steps[WITH_MASS] && 5.0 * error[MASSLESS] < error[LEFT_OUT] &&
                   error[MASSLESS] < 1.5 * error[WITH_MASS]
               ? 0
               : 1;
}
