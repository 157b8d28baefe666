/* Spring-damper along the line between two points: linear, cubic, one-sided, or by a function.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "stock.h"

#include "../space3.h"
#include "marker.h"

enum { STIFFNESS, DAMPING, REST, CUBIC, POINT_A, POINT_B = POINT_A + 3 };

/* The line from point b to point a. */
typedef struct line {
    mbsri_marker a, b;
    double e[3], length;
} line;

static void locate(const mbsr_force_args *args, line *w)
{
    const double *param = args->force->param;
    mbsri_marker_on(args->body, param + POINT_A, &w->a);
    mbsri_marker_on(args->body + 1, param + POINT_B, &w->b);
    for (int k = 0; k < 3; ++k) w->e[k] = w->a.x[k] - w->b.x[k];
    w->length = mbsri_norm3(w->e);
}

/* Force pulling together, energy and power turned into heat at length x and rate v. With s = x - l0
 * the elastic force is c s + c3 s^3 and the damping force d v. */
static int law(const mbsr_force_def *def, double x, double v, double *force, double *energy,
               double *power)
{
    const double *param = def->param;
    if (def->spring) return def->spring(def->user, x, v, force, energy, power);
    const bool one_sided = def->option[0] != 0;
    const double s = x - param[REST], square = s * s;
    if (one_sided && s <= 0.0) return MBSR_OK;
    const double elastic = (param[STIFFNESS] + param[CUBIC] * square) * s,
                 damping = param[DAMPING] * v;
    *force = one_sided ? mbsri_one_sided(elastic, damping) : elastic + damping;
    if (energy) *energy = (0.5 * param[STIFFNESS] + 0.25 * param[CUBIC] * square) * square;
    if (power) *power = one_sided ? (*force - elastic) * v : damping * v;
    return MBSR_OK;
}

/* The force may be written as a smooth factor times e, without the line's direction. */
static bool needs_no_direction(const mbsr_force_def *def)
{
    return !def->spring && def->param[REST] == 0.0 && def->param[DAMPING] == 0.0;
}

/* The law at the line's length and rate. Two points that coincide have neither direction nor rate;
 * a cable is slack there. */
static int tension(const mbsr_force_args *args, const line *w, double *force, double *power)
{
    const mbsr_force_def *def = args->force;
    if (!(w->length > 0.0)) {
        return !def->spring && def->option[0] != 0 ? MBSR_OK : MBSR_DEGENERATE_FORCE;
    }
    double v[3];
    for (int k = 0; k < 3; ++k) v[k] = w->a.v[k] - w->b.v[k];
    return law(def, w->length, mbsri_dot3(w->e, v) / w->length, force, NULL, power);
}

static int evaluate(const mbsr_force_args *args)
{
    const double *param = args->force->param;
    line w;
    locate(args, &w);
    double factor = param[STIFFNESS] + param[CUBIC] * w.length * w.length;
    if (!needs_no_direction(args->force)) {
        double force = 0.0;
        const int status = tension(args, &w, &force, NULL);
        if (status) return status;
        factor = w.length > 0.0 ? force / w.length : 0.0;
    }
    for (int k = 0; k < 3; ++k) w.e[k] *= factor;
    mbsri_push(args->body, &w.a, -1.0, w.e, NULL);
    mbsri_push(args->body + 1, &w.b, 1.0, w.e, NULL);
    return MBSR_OK;
}

static int energy(const mbsr_force_args *args, double *energy_out)
{
    double force = 0.0;
    line w;
    locate(args, &w);
    return law(args->force, w.length, 0.0, &force, energy_out, NULL);
}

static int dissipation(const mbsr_force_args *args, double *power)
{
    double force = 0.0;
    line w;
    if (needs_no_direction(args->force)) return MBSR_OK;
    locate(args, &w);
    return tension(args, &w, &force, power);
}

static int check(const mbsr_force_args *args, char text[MBSR_TEXT_SIZE])
{
    const mbsr_force_def *def = args->force;
    int status = mbsri_check_markers(args, POINT_A, text);
    if (status || def->spring) return status;
    status = mbsri_check_not_negative(args, STIFFNESS, 4, text);
    if (status) return status;
    if (def->option[0] != 0 && def->param[DAMPING] > 0.0 && def->param[STIFFNESS] == 0.0 &&
        def->param[CUBIC] == 0.0) {
        return mbsri_refuse_parameter(text, args, DAMPING,
                                      "but a cable without stiffness has no force");
    }
    return MBSR_OK;
}

static const char *parameter(int k)
{
    static const char *const names[] = {
        " (stiffness)",  " (damping)",    " (free_length)", " (cubic)",      " (point_a[0])",
        " (point_a[1])", " (point_a[2])", " (point_b[0])",  " (point_b[1])", " (point_b[2])"};
    return MBSRI_PARAMETER(names, k);
}

static const mbsr_force_table point_table = {
    .version = MBSR_FORCE_TABLE_VERSION,
    .flags = MBSR_FORCE_NO_MASS,
    .name = "point spring-damper",
    .evaluate = evaluate,
    .energy = energy,
    .dissipation = dissipation,
    .check = check,
    .parameter = parameter,
};

mbsr_force_def mbsr_force_spring(int a, const double point_a[3], int b, const double point_b[3],
                                 const mbsr_spring *spring)
{
    mbsr_force_def def = mbsri_stock_force(&point_table, 2, a, b);
    def.param[STIFFNESS] = spring->stiffness;
    def.param[DAMPING] = spring->damping;
    def.param[REST] = spring->free_length;
    def.param[CUBIC] = spring->cubic;
    mbsri_store_point(point_a, def.param + POINT_A);
    mbsri_store_point(point_b, def.param + POINT_B);
    def.option[0] = spring->one_sided;
    def.spring = spring->function;
    def.user = spring->user;
    return def;
}

mbsr_force_def mbsr_force_point_spring(int a, const double point_a[3], int b,
                                       const double point_b[3], double stiffness, double damping,
                                       double free_length)
{
    const mbsr_spring spring = {
        .stiffness = stiffness, .damping = damping, .free_length = free_length};
    return mbsr_force_spring(a, point_a, b, point_b, &spring);
}
