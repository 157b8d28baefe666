/* Force elements and closures that files need: see elements.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/elements.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* ---- laws ----
 *
 * param: gain, bias (3), rest (2), range of the control (2), of the force (2). option: which ranges
 * hold. */
enum { GAIN, BIAS, REST = 4, CONTROL = 6, FORCE = 8, TERMS = MBSRI_LAW_PARAMS };
enum { CONTROL_HOLDS = 1, FORCE_HOLDS = 2 };

void mbsri_law_put(const mbsri_file_law *law, mbsr_force_def *def)
{
    def->param[GAIN] = law->gain;
    memcpy(def->param + BIAS, law->bias, sizeof law->bias);
    memcpy(def->param + REST, law->rest, sizeof law->rest);
    memcpy(def->param + CONTROL, law->control_range, sizeof law->control_range);
    memcpy(def->param + FORCE, law->force_range, sizeof law->force_range);
    def->option[0] =
        (law->control_limited ? CONTROL_HOLDS : 0) + (law->force_limited ? FORCE_HOLDS : 0);
    def->user = (void *)law->control;
}

void mbsri_law_get(const mbsr_force_def *def, mbsri_file_law *law)
{
    *law = (mbsri_file_law){.gain = def->param[GAIN],
                            .control_limited = (def->option[0] & CONTROL_HOLDS) != 0,
                            .force_limited = (def->option[0] & FORCE_HOLDS) != 0,
                            .control = def->user};
    memcpy(law->bias, def->param + BIAS, sizeof law->bias);
    memcpy(law->rest, def->param + REST, sizeof law->rest);
    memcpy(law->control_range, def->param + CONTROL, sizeof law->control_range);
    memcpy(law->force_range, def->param + FORCE, sizeof law->force_range);
}

/* l beyond what is at rest; *slack: it is within. */
static double beyond(const mbsr_force_def *def, double l, bool *slack)
{
    const double *rest = def->param + REST;
    *slack = rest[0] < rest[1] && l > rest[0] && l < rest[1];
    return *slack ? 0.0 : l <= rest[0] ? l - rest[0] : l - rest[1];
}

double mbsri_law_force(const mbsr_force_def *def, double l, double rate, double slope[2])
{
    const double *param = def->param, *control = def->user;
    double w = control ? *control : 0.0;
    bool slack;
    if (def->option[0] & CONTROL_HOLDS) w = fmin(fmax(w, param[CONTROL]), param[CONTROL + 1]);
    const double x = beyond(def, l, &slack),
                 F = param[GAIN] * w + param[BIAS] + param[BIAS + 1] * x + param[BIAS + 2] * rate;
    slope[0] = slack ? 0.0 : param[BIAS + 1];
    slope[1] = param[BIAS + 2];
    if (!(def->option[0] & FORCE_HOLDS)) return F;
    if (F < param[FORCE] || F > param[FORCE + 1]) slope[0] = slope[1] = 0.0;
    return fmin(fmax(F, param[FORCE]), param[FORCE + 1]);
}

/* ---- transmissions ----
 *
 * param: a law, then factor and coordinate of each body. */

static double factor_of(const mbsr_force_args *args, int k)
{
    return args->force->param[TERMS + 2 * k];
}

/* Place of a coordinate, as its joint was given, among those left; -1: it is locked. */
static int place_left(const mbsr_force_body *b, int coordinate)
{
    int place = 0;
    if (!b->locked_at) return coordinate;
    if (!isnan(b->locked_at[coordinate])) return -1;
    for (int k = 0; k < coordinate; ++k) place += isnan(b->locked_at[k]);
    return place;
}

static int coordinate_of(const mbsr_force_args *args, int k)
{
    return (int)args->force->param[TERMS + 2 * k + 1];
}

static int place_of_term(const mbsr_force_args *args, int k)
{
    return place_left(args->body + k, coordinate_of(args, k));
}

static double tendon_length(const mbsr_force_args *args)
{
    double l = 0.0;
    for (int k = 0; k < args->bodies; ++k) {
        const int at = place_of_term(args, k);
        const mbsr_force_body *b = args->body + k;
        l += factor_of(args, k) * (at < 0 ? b->locked_at[coordinate_of(args, k)] : b->q[at]);
    }
    return l;
}

static double rate_of(const mbsr_force_args *args)
{
    double rate = 0.0;
    for (int k = 0; k < args->bodies; ++k) {
        const int at = place_of_term(args, k);
        if (at >= 0) rate += factor_of(args, k) * args->body[k].u[at];
    }
    return rate;
}

static int evaluate(const mbsr_force_args *args)
{
    double slope[2];
    const double F = mbsri_law_force(args->force, tendon_length(args), rate_of(args), slope);
    for (int k = 0; k < args->bodies; ++k) {
        const int at = place_of_term(args, k);
        if (at >= 0) args->body[k].tau[at] += factor_of(args, k) * F;
    }
    return 0;
}

static int energy(const mbsr_force_args *args, double *E)
{
    bool slack;
    const double x = beyond(args->force, tendon_length(args), &slack);
    if (!args->force->user) *E += -0.5 * args->force->param[BIAS + 1] * x * x;
    return 0;
}

static int dissipation(const mbsr_force_args *args, double *power)
{
    const double rate = rate_of(args);
    if (!args->force->user) *power += -args->force->param[BIAS + 2] * rate * rate;
    return 0;
}

/* Those of tau of term k, in its row. */
static void add_slopes(const mbsr_force_args *args, const mbsr_force_derivatives *out, int k,
                       double *row, const double slope[2])
{
    for (int l = 0; l < args->bodies; ++l) {
        const mbsr_force_body *b = args->body + l;
        const int at = place_of_term(args, l), pose = b->space == MBSR_SPACE_SPATIAL ? 6 : b->np;
        if (at < 0) continue;
        const int q = out->column[l] + pose + b->d + at;
        const double both = factor_of(args, k) * factor_of(args, l);
        row[out->rows * q] += both * slope[0];
        row[out->rows * (q + b->nq)] += both * slope[1];
    }
}

static int derivatives(const mbsr_force_args *args, const mbsr_force_derivatives *out)
{
    double slope[2];
    (void)mbsri_law_force(args->force, tendon_length(args), rate_of(args), slope);
    for (int k = 0; k < args->bodies; ++k) {
        const int at = place_of_term(args, k);
        if (at >= 0)
            add_slopes(args, out, k, out->matrix + out->row[k] + args->body[k].d + at, slope);
    }
    return 0;
}

static const mbsr_force_table transmission = {
    .version = MBSR_FORCE_TABLE_VERSION,
    .flags = MBSR_FORCE_JOINT_ONLY | MBSR_FORCE_NO_MASS,
    .name = "transmission",
    .evaluate = evaluate,
    .energy = energy,
    .dissipation = dissipation,
    .derivatives = derivatives,
};

mbsr_force_def mbsri_force_transmission(const mbsri_transmission *t)
{
    mbsr_force_def def = mbsr_force_custom(&transmission, t->count, t->body, NULL);
    mbsri_law_put(&t->law, &def);
    for (int k = 0; k < t->count; ++k) {
        def.param[TERMS + 2 * k] = t->factor[k];
        def.param[TERMS + 2 * k + 1] = t->coordinate[k];
    }
    return def;
}

bool mbsri_transmission_of(const mbsr_force_def *def, mbsri_transmission *t, int *coordinate,
                           double *factor)
{
    if (def->table != &transmission) return false;
    *t = (mbsri_transmission){.count = def->bodies,
                              .body = def->body_list ? def->body_list : def->body,
                              .coordinate = coordinate,
                              .factor = factor};
    mbsri_law_get(def, &t->law);
    for (int k = 0; k < def->bodies; ++k) {
        factor[k] = def->param[TERMS + 2 * k];
        coordinate[k] = (int)def->param[TERMS + 2 * k + 1];
    }
    return true;
}

/* ---- polynomials between two joint coordinates ----
 *
 * param: the polynomial (5), both refs. option: coordinates; whether both are of one body. */
enum { REFS = 5 };

static double value_of(const double *a, double x, double *slope, double *curvature)
{
    *slope = a[1] + x * (2.0 * a[2] + x * (3.0 * a[3] + x * 4.0 * a[4]));
    *curvature = 2.0 * a[2] + x * (6.0 * a[3] + x * 12.0 * a[4]);
    return a[0] + x * (a[1] + x * (a[2] + x * (a[3] + x * a[4])));
}

/* Coordinate k among those left. */
static int option_at(const mbsr_closure_args *args, int k)
{
    const mbsr_force_body *b = args->body + (k > 0 && args->closure->bodies > 1);
    return place_left(b, args->closure->option[k]);
}

static int check_polynomial(const mbsr_closure_args *args, char text[MBSR_TEXT_SIZE])
{
    for (int k = 0; k < 2; ++k) {
        if (option_at(args, k) >= 0) continue;
        snprintf(text, MBSR_TEXT_SIZE,
                 "coordinate %d of body %d is locked, and the other is not free",
                 args->closure->option[k], args->body[k > 0 && args->closure->bodies > 1].id);
        return MBSR_ERR_VALUE;
    }
    return 0;
}

static const mbsr_force_body *second(const mbsr_closure_args *args)
{
    return args->body + (args->closure->bodies > 1);
}

static double argument(const mbsr_closure_args *args)
{
    return second(args)->q[option_at(args, 1)] - args->closure->param[REFS + 1];
}

static int position(const mbsr_closure_args *args, double *g)
{
    double slope, curvature;
    const double *a = args->closure->param;
    g[0] = args->body[0].q[option_at(args, 0)] - a[REFS] -
           value_of(a, argument(args), &slope, &curvature);
    return 0;
}

static int jacobian(const mbsr_closure_args *args, const mbsr_closure_jacobian *out)
{
    double slope, curvature;
    const int both = args->closure->bodies > 1;
    const mbsr_force_body *b = args->body, *other = second(args);
    (void)value_of(args->closure->param, argument(args), &slope, &curvature);
    const int one = out->column[0] + b->d + option_at(args, 0),
              two = out->column[both] + other->d + option_at(args, 1);
    out->matrix[(size_t)one * (size_t)out->rows] += 1.0;
    out->matrix[(size_t)two * (size_t)out->rows] -= slope;
    return 0;
}

static int bias(const mbsr_closure_args *args, double *result)
{
    double slope, curvature;
    const double rate = second(args)->u[option_at(args, 1)];
    (void)value_of(args->closure->param, argument(args), &slope, &curvature);
    result[0] = -curvature * rate * rate;
    return 0;
}

static int no_drift(const mbsr_closure_args *args, double *gt)
{
    (void)args, (void)gt;
    return 0;
}

/* Only the column of the second coordinate turns, by P''. */
static int tangent(const mbsr_closure_args *args, const double *lambda,
                   const mbsr_closure_tangent *out)
{
    double slope, curvature;
    const mbsr_force_body *other = second(args);
    const int coordinate = option_at(args, 1),
              two = out->column[args->closure->bodies > 1] + other->d + coordinate;
    (void)value_of(args->closure->param, argument(args), &slope, &curvature);
    out->force[(size_t)two * (size_t)out->columns + (size_t)two] -= curvature * lambda[0];
    out->rate[(size_t)two * (size_t)out->rows] -= curvature * other->u[coordinate];
    return 0;
}

static const mbsr_closure_table polynomial = {
    .version = MBSR_CLOSURE_TABLE_VERSION,
    .flags = MBSR_CLOSURE_JOINTS | MBSR_CLOSURE_COORDINATES | MBSR_CLOSURE_PLAIN | MBSR_CLOSURE_OWN,
    .name = "polynomial",
    .position = position,
    .jacobian = jacobian,
    .drift = no_drift,
    .bias = bias,
    .tangent = tangent,
    .check = check_polynomial,
};

mbsr_closure_def mbsri_closure_polynomial(const int body[2], const int coordinate[2],
                                          const double ref[2], const double power[5])
{
    mbsr_closure_def def =
        mbsr_closure_custom(&polynomial, body[0] == body[1] ? 1 : 2, body, 1, 1, NULL);
    memcpy(def.param, power, 5 * sizeof *power);
    memcpy(def.param + REFS, ref, 2 * sizeof *ref);
    def.option[0] = coordinate[0];
    def.option[1] = coordinate[1];
    return def;
}

bool mbsri_polynomial_of(const mbsr_closure_def *def, int coordinate[2], double ref[2],
                         double power[5])
{
    if (def->table != &polynomial) return false;
    memcpy(power, def->param, 5 * sizeof *power);
    memcpy(ref, def->param + REFS, 2 * sizeof *ref);
    memcpy(coordinate, def->option, 2 * sizeof *coordinate);
    return true;
}
