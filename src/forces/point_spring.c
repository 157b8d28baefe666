/* Spring-damper along the line between two points: linear, cubic, one-sided, or by a function.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "algebra/differences.h"
#include "algebra/space3.h"
#include "forces/marker.h"
#include "forces/slopes.h"
#include "forces/springs.h"
#include "forces/stock.h"

#include <float.h>
#include <math.h>

/* RATE, of a law by function: typical of the length in the model, m/s (mbsri_spring_set_rate). */
enum { STIFFNESS, DAMPING, REST, CUBIC, POINT_A, POINT_B = POINT_A + 3, RATE = POINT_B + 3 };

/* The line from point b to point a. */
typedef struct line {
    mbsri_marker a, b;
    double e[3], length;
} line;

static void find_line(const mbsr_force_args *args, line *w)
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

/* Whether the line has a direction. Where force is left as the length goes to zero that is rounding
 * of the ends, for a line no longer than this. */
static bool has_direction(const mbsr_force_def *def, const line *w)
{
    static const double rounding = 8.0 * DBL_EPSILON;
    double size = 0.0;
    for (int k = 0; k < 3; ++k) {
        size += fabs(w->a.x[k]) + fabs(w->b.x[k]);
        size += fabs(w->a.arm[k]) + fabs(w->b.arm[k]);
    }
    return w->length > (def->spring || def->param[REST] > 0.0 ? rounding * size : 0.0);
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
    if (!has_direction(def, w)) {
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
    find_line(args, &w);
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

/* ---- derivatives ---- */

/* Force F pulling together and its derivatives with respect to the length x and the rate v. */
typedef struct tangent {
    double F, by_x, by_v;
} tangent;

static int add_law_sample(const mbsr_force_def *def, double x, double v, double factor, double *sum)
{
    double force = 0.0;
    const int status = law(def, x, v, &force, NULL, NULL);
    *sum += factor * force;
    return status;
}

/* What the rate of the length changes by where the law does: without gravity the points' velocity,
 * and at rest nothing tells. */
static double rate_span(const mbsr_force_def *def, const line *w)
{
    const double rate = def->param[RATE], speed = fmax(mbsri_norm3(w->a.v), mbsri_norm3(w->b.v));
    return rate > 0.0 ? rate : speed > 0.0 ? speed : 1.0;
}

/* Of a law by function: differences, over a part of the length, and of v. */
static int function_tangent(const mbsr_force_def *def, const line *w, double v, tangent *at)
{
    const double x = w->length, hx = 0x1p-10 * x, hv = mbsri_difference_step(v, rate_span(def, w));
    int status = add_law_sample(def, x, v, 1.0, &at->F);
    for (int l = 0; l < 4 && !status; ++l) {
        const double place = mbsri_difference_place(l), weight = mbsri_difference_weight(l) / 12.0;
        status = add_law_sample(def, x + place * hx, v, weight / hx, &at->by_x);
        if (!status) status = add_law_sample(def, x, v + place * hv, weight / hv, &at->by_v);
    }
    return status;
}

static int law_tangent(const mbsr_force_def *def, const line *w, double v, tangent *at)
{
    const double *param = def->param;
    *at = (tangent){0.0, 0.0, 0.0};
    if (def->spring) return function_tangent(def, w, v, at);
    const bool one_sided = def->option[0] != 0;
    const double x = w->length, s = x - param[REST], square = s * s,
                 stiffness = param[STIFFNESS] + 3.0 * param[CUBIC] * square;
    if (one_sided && s <= 0.0) return MBSR_OK;
    double by_elastic = 1.0, by_damping = 1.0;
    if (one_sided) {
        mbsri_one_sided_slopes((param[STIFFNESS] + param[CUBIC] * square) * s, param[DAMPING] * v,
                               &by_elastic, &by_damping);
    }
    at->by_x = by_elastic * stiffness;
    at->by_v = by_damping * param[DAMPING];
    return add_law_sample(def, x, v, 1.0, &at->F);
}

/* The force factor e that pulls together changes with e and the velocity v of a against b by
 *
 *   factor de + along (by_e . de + by_v . dv) */
typedef struct pull {
    double factor, along[3], by_e[3], by_v[3];
} pull;

/* factor = c + c3 l^2 */
static void smooth_pull(const mbsr_force_def *def, const line *w, pull *f)
{
    const double cubic = def->param[CUBIC];
    f->factor = def->param[STIFFNESS] + cubic * w->length * w->length;
    for (int r = 0; r < 3; ++r) {
        f->along[r] = w->e[r];
        f->by_e[r] = 2.0 * cubic * w->e[r];
        f->by_v[r] = 0.0;
    }
}

/* factor = F / l.  With n = e / l:  dl = n . de,  dl' = n . dv + v . dn,  dn = (de - n dl) / l, so
 *
 *   d(F n) = (F_x n . de + F_v (n . dv + (v - n l') . de / l)) n + F / l (de - n n . de) */
static int directed_pull(const mbsr_force_def *def, const line *w, pull *f)
{
    const double inverse = 1.0 / w->length;
    double v[3];
    for (int r = 0; r < 3; ++r) {
        f->along[r] = w->e[r] * inverse;
        v[r] = w->a.v[r] - w->b.v[r];
    }
    tangent at;
    const double rate = mbsri_dot3(f->along, v);
    const int status = law_tangent(def, w, rate, &at);
    if (status) return status;
    f->factor = at.F * inverse;
    for (int r = 0; r < 3; ++r) {
        const double n = f->along[r];
        f->by_e[r] = (at.by_x - f->factor) * n + at.by_v * inverse * (v[r] - rate * n);
        f->by_v[r] = at.by_v * n;
    }
    return MBSR_OK;
}

/* Derivatives of the force with respect to the pose and V of body k, whose point moves e and v by
 * `sign` times its own motion. */
static void pull_slopes(const mbsri_columns *c, int k, double sign, const double arm[3],
                        const pull *f, mbsri_vector *dforce)
{
    double omega[3];
    mbsri_body_spin(c->body + k, omega);
    mbsri_vector *by_pose = dforce + c->first[k], *by_rate = by_pose + c->size[k];
    for (int r = 0; r < c->size[k]; ++r) {
        double de[3], dv[3] = {0.0, 0.0, 0.0};
        /* dx = phi x arm or rho, and dv = omega x (phi x arm); for V the same dx as dv */
        if (mbsri_point_motion(c, k, r, arm, de)) mbsri_cross3(omega, de, dv);
        const double by_e = sign * (mbsri_dot3(f->by_e, de) + mbsri_dot3(f->by_v, dv)),
                     by_v = sign * mbsri_dot3(f->by_v, de), factor = sign * f->factor;
        for (int l = 0; l < 3; ++l) {
            by_pose[r].x[l] = factor * de[l] + by_e * f->along[l];
            by_rate[r].x[l] = by_v * f->along[l];
        }
    }
}

static int derivatives(const mbsr_force_args *args, const mbsr_force_derivatives *out)
{
    const mbsri_columns c = mbsri_make_columns(args, out);
    mbsri_vector dforce[MBSRI_MAX_COLUMNS];
    double force[3];
    line w;
    pull f;
    find_line(args, &w);
    if (needs_no_direction(args->force)) {
        smooth_pull(args->force, &w, &f);
    } else {
        double none = 0.0;
        if (!has_direction(args->force, &w)) return tension(args, &w, &none, NULL);
        const int status = directed_pull(args->force, &w, &f);
        if (status) return status;
    }
    for (int r = 0; r < 3; ++r) force[r] = f.factor * w.e[r];
    pull_slopes(&c, 0, 1.0, w.a.arm, &f, dforce);
    pull_slopes(&c, 1, -1.0, w.b.arm, &f, dforce);
    mbsri_push_slopes(&c, 0, -1.0, w.a.arm, force, NULL, dforce, NULL);
    mbsri_push_slopes(&c, 1, 1.0, w.b.arm, force, NULL, dforce, NULL);
    return MBSR_OK;
}

/* ---- energies and the rest ---- */

static int energy(const mbsr_force_args *args, double *energy_out)
{
    double force = 0.0;
    line w;
    find_line(args, &w);
    return law(args->force, w.length, 0.0, &force, energy_out, NULL);
}

static int dissipation(const mbsr_force_args *args, double *power)
{
    double force = 0.0;
    line w;
    if (needs_no_direction(args->force)) return MBSR_OK;
    find_line(args, &w);
    return tension(args, &w, &force, power);
}

/* Of a cable. */
static double cable_side(const mbsr_force_args *args)
{
    const mbsr_force_def *def = args->force;
    const double *param = def->param;
    line w;
    if (def->spring || def->option[0] == 0) return 0.0;
    find_line(args, &w);
    const double s = w.length - param[REST];
    if (!(s > 0.0) || !(w.length > 0.0)) return 0.0;
    double v[3];
    for (int k = 0; k < 3; ++k) v[k] = w.a.v[k] - w.b.v[k];
    return mbsri_one_sided_branch((param[STIFFNESS] + param[CUBIC] * s * s) * s,
                                  param[DAMPING] * mbsri_dot3(w.e, v) / w.length);
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

static int check_fields(const mbsr_force_def *def, char text[MBSR_TEXT_SIZE])
{
    return mbsri_check_shape(def, 2, 1, text);
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
    .flags = MBSR_FORCE_NO_MASS | MBSR_FORCE_NO_JOINT,
    .name = "point spring-damper",
    .evaluate = evaluate,
    .energy = energy,
    .dissipation = dissipation,
    .check = check,
    .check_fields = check_fields,
    .parameter = parameter,
    .derivatives = derivatives,
    .side = cable_side,
};

mbsr_force_def mbsr_force_spring(int a, const double point_a[3], int b, const double point_b[3],
                                 const mbsr_spring *spring)
{
    mbsr_force_def def = mbsri_stock_force(&point_table, 2, a, b);
    if (!spring) return mbsri_given_null(def);
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

bool mbsri_read_point_spring(const mbsr_force_def *def, mbsri_spring *spring)
{
    if (def->table != &point_table) return false;
    spring->kind = MBSRI_POINT_SPRING;
    for (int k = 0; k < 3; ++k) {
        spring->a[k] = def->param[POINT_A + k];
        spring->b[k] = def->param[POINT_B + k];
    }
    spring->stiffness[0] = def->param[STIFFNESS];
    spring->damping[0] = def->param[DAMPING];
    spring->rest = def->param[REST];
    spring->beyond = def->spring                ? "its law is a function"
                     : def->option[0] != 0      ? "it is one-sided"
                     : def->param[CUBIC] != 0.0 ? "it has a cubic term"
                                                : NULL;
    return true;
}

void mbsri_spring_set_rate(mbsr_force_def *def, double rate)
{
    if (def->table == &point_table && def->spring) def->param[RATE] = rate;
}
