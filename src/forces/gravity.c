/* Uniform gravity: f = M g in the directions of translation, energy -g . (m r + first moment).
 * SPDX-License-Identifier: BSD-3-Clause */
#include "forces/gravity.h"

#include "algebra/space3.h"
#include "flexible/data.h"
#include "forces/stock.h"

#include <math.h>

/* ---- in the plane ---- */

static void planar_force(const mbsr_force_body *body, const double *g)
{
    for (int k = 0; k < body->d; ++k) body->f[k] += body->M[k] * g[0] + body->M[body->d + k] * g[1];
}

/* A constant M pulls with the same force everywhere: -g . (M p). A rigid body's first moment
 * turns. */
static double planar_energy(const mbsr_force_body *body, const double *g)
{
    const double *M = body->M;
    const int d = body->d;
    const bool constant = body->inertia->kind == MBSR_INERTIA_MATRIX;
    double energy = 0.0;
    for (int j = 0; j < (constant ? d : 2); ++j) {
        for (int k = 0; k < 2; ++k) energy -= g[k] * M[j * d + k] * body->p[j];
    }
    if (d == 3 && !constant) energy -= g[0] * M[7] - g[1] * M[6];
    return energy;
}

/* ---- in space ----
 *
 * The matrix of a rigid body in (omega, v) is [I, [h]x; -[h]x, m 1] with the first moment h in
 * world axes. Of any other matrix the weight is that of m, a third of the trace of its block of v,
 * with the h of the antisymmetric part of its block of (omega, v). */

static double spatial_mass(const double *M, double h[3])
{
    h[0] = 0.5 * (M[26] - M[31]);
    h[1] = 0.5 * (M[30] - M[20]);
    h[2] = 0.5 * (M[19] - M[24]);
    return (M[21] + M[28] + M[35]) / 3.0;
}

/* moment h x g, force m g */
static void spatial_force(const mbsr_force_body *body, const double *g)
{
    double h[3];
    const double m = spatial_mass(body->M, h);
    mbsri_add_cross3(h, g, body->f);
    mbsri_add3(m, g, body->f + 3);
}

static double spatial_energy(const mbsr_force_body *body, const double *g)
{
    double h[3];
    const double m = spatial_mass(body->M, h);
    mbsri_add3(m, body->p + MBSR_POSE_X, h);
    return -mbsri_dot3(g, h);
}

/* ---- on a flexible body ---- */

static const double *translation(const mbsr_force_body *body, int column)
{
    return body->M + (ptrdiff_t)column * body->d + 3;
}

/* f = M (0, g, 0), with modal forces Ct_a . g */
static void flexible_force(const mbsr_force_body *body, const double *g)
{
    for (int k = 0; k < body->d; ++k) body->f[k] += mbsri_dot3(translation(body, k), g);
}

/* First moment c: [c]x in the rows of omega, columns of v. */
static void first_moment(const mbsr_force_body *body, double c[3])
{
    const int d = body->d;
    c[0] = body->M[4 * d + 2], c[1] = body->M[5 * d], c[2] = body->M[3 * d + 1];
}

static double flexible_energy(const mbsr_force_body *body, const double *g)
{
    double c[3];
    first_moment(body, c);
    mbsri_add3(body->M[3 * (body->d + 1)], body->p + MBSR_POSE_X, c);
    return -mbsri_dot3(g, c);
}

/* Modal forces along modes: what dependent shapes move, Y_ab (int chi . g) */
static void dependent_derivatives(const mbsr_force_body *body, const double *g,
                                  const mbsr_force_derivatives *out)
{
    const mbsr_flex *f = body->inertia->flex;
    const int row = out->row[0] + 6, column = out->column[0] + 6;
    for (int k = 0; k < f->r; ++k) {
        const double *Y = f->Y + f->n * f->n * k;
        double first[3];
        mbsri_rotate3(body->p + MBSR_POSE_R, f->Ct0 + 3 * (f->n + k), first);
        const double pull = mbsri_dot3(first, g);
        for (int b = 0; b < f->n; ++b) {
            for (int a = 0; a < f->n; ++a)
                mbsri_add_slope(out, row + a, column + b, pull * Y[f->n * b + a]);
        }
    }
}

/* Moment c x g along a turn x and modes: (x x c) x g, Ct_a x g; modal forces along a turn: (x x
 * Ct_a) . g */
static void flexible_derivatives(const mbsr_force_body *body, const double *g,
                                 const mbsr_force_derivatives *out)
{
    const int row = out->row[0], column = out->column[0];
    double c[3], moment[3];
    first_moment(body, c);
    for (int k = 0; k < 3; ++k) {
        double x[3] = {0.0}, turned[3];
        x[k] = 1.0;
        mbsri_cross3(x, c, turned);
        mbsri_cross3(turned, g, moment);
        for (int r = 0; r < 3; ++r) mbsri_add_slope(out, row + r, column + k, moment[r]);
    }
    for (int a = 6; a < body->d; ++a) {
        mbsri_cross3(translation(body, a), g, moment);
        for (int r = 0; r < 3; ++r) {
            mbsri_add_slope(out, row + r, column + a, moment[r]);
            mbsri_add_slope(out, row + a, column + r, moment[r]);
        }
    }
    if (body->inertia->kind == MBSR_INERTIA_FLEXIBLE) dependent_derivatives(body, g, out);
}

static int evaluate(const mbsr_force_args *args)
{
    const mbsr_force_body *body = args->body;
    if (body->space == MBSR_SPACE_POINT || body->space == MBSR_SPACE_PLANAR)
        planar_force(body, args->force->param);
    else if (body->space == MBSR_SPACE_SPATIAL)
        spatial_force(body, args->force->param);
    else if (body->space == MBSR_SPACE_FLEXIBLE)
        flexible_force(body, args->force->param);
    return MBSR_OK;
}

/* A rigid body's first moment c turns: its rows and columns of M hold (-c_y, c_x). A constant
 * matrix does not turn. */
static void planar_derivatives(const mbsr_force_body *body, const double *g,
                               const mbsr_force_derivatives *out)
{
    const mbsr_inertia *inertia = body->inertia;
    if (inertia->kind != MBSR_INERTIA_PLANAR) return;
    const double cosine = cos(body->p[2]), sine = sin(body->p[2]);
    const double x = inertia->mass * (cosine * inertia->com[0] - sine * inertia->com[1]),
                 y = inertia->mass * (sine * inertia->com[0] + cosine * inertia->com[1]);
    mbsri_add_slope(out, out->row[0] + 2, out->column[0] + 2, -x * g[0] - y * g[1]);
}

/* The first moment turns, whatever M is made of: d(h x g) = (phi x h) x g = (phi.g) h - (h.g) phi
 */
void mbsri_gravity_turn(const mbsr_force_def *def, const double M[36], double moment[9])
{
    const double *g = def->param;
    double h[3];
    spatial_mass(M, h);
    const double both = mbsri_dot3(h, g);
    for (int k = 0; k < 3; ++k) {
        for (int r = 0; r < 3; ++r) moment[3 * k + r] = g[k] * h[r];
        moment[4 * k] -= both;
    }
}

static void spatial_derivatives(const mbsr_force_body *body, const mbsr_force_def *def,
                                const mbsr_force_derivatives *out)
{
    double moment[9];
    mbsri_gravity_turn(def, body->M, moment);
    for (int k = 0; k < 3; ++k) {
        for (int r = 0; r < 3; ++r)
            mbsri_add_slope(out, out->row[0] + r, out->column[0] + k, moment[3 * k + r]);
    }
}

/* Masses by function are differenced. */
static int derivatives(const mbsr_force_args *args, const mbsr_force_derivatives *out)
{
    const mbsr_force_body *body = args->body;
    if (body->space == MBSR_SPACE_PLANAR)
        planar_derivatives(body, args->force->param, out);
    else if (body->space == MBSR_SPACE_SPATIAL)
        spatial_derivatives(body, args->force, out);
    else if (body->space == MBSR_SPACE_FLEXIBLE)
        flexible_derivatives(body, args->force->param, out);
    return MBSR_OK;
}

static int energy(const mbsr_force_args *args, double *energy_out)
{
    const mbsr_force_body *body = args->body;
    if (body->space == MBSR_SPACE_POINT || body->space == MBSR_SPACE_PLANAR)
        *energy_out += planar_energy(body, args->force->param);
    else if (body->space == MBSR_SPACE_SPATIAL)
        *energy_out += spatial_energy(body, args->force->param);
    else if (body->space == MBSR_SPACE_FLEXIBLE)
        *energy_out += flexible_energy(body, args->force->param);
    return MBSR_OK;
}

static int check_fields(const mbsr_force_def *def, char text[MBSR_TEXT_SIZE])
{
    return mbsri_check_shape(def, 0, 0, text);
}

static const char *parameter(int k)
{
    static const char *const names[] = {" (gx)", " (gy)", " (gz)"};
    return MBSRI_PARAMETER(names, k);
}

static const mbsr_force_table gravity_table = {
    .version = MBSR_FORCE_TABLE_VERSION,
    .flags = MBSR_FORCE_EVERY_BODY | MBSR_FORCE_NO_JOINT,
    .name = "gravity",
    .evaluate = evaluate,
    .energy = energy,
    .check_fields = check_fields,
    .parameter = parameter,
    .derivatives = derivatives,
};

bool mbsri_is_gravity(const mbsr_force_def *def)
{
    return def->table == &gravity_table;
}

mbsr_force_def mbsr_force_gravity(double gx, double gy, double gz)
{
    mbsr_force_def def = mbsri_stock_force(&gravity_table, 0, MBSR_GROUND, MBSR_GROUND);
    def.param[0] = gx;
    def.param[1] = gy;
    def.param[2] = gz;
    return def;
}
