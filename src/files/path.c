/* Tendons along points of bodies: see path.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * e_k is the unit vector from point k to the next one, L the sum of their distances. With the force
 * f = -k x - d L' on L, x what L is beyond the lengths of rest, point k feels f (e_{k-1} - e_k). */
#include "files/path.h"
#include "algebra/space3.h"

#include <math.h>
#include <string.h>

enum { STIFFNESS, DAMPING, REST, POINTS = 4 }; /* places in param */

typedef struct line {
    double arm[MBSRI_PATH_MOST][3], x[MBSRI_PATH_MOST][3], v[MBSRI_PATH_MOST][3];
    double along[MBSRI_PATH_MOST][3]; /* e */
    double length, rate;
} line;

/* Where point k is, and how fast; the ground at rest has no pose. */
static void see_point(const mbsr_force_args *args, int k, line *w)
{
    const mbsr_force_body *b = args->body + k;
    const double *s = args->force->param + POINTS + 3 * k;
    const bool moves = b->space == MBSR_SPACE_SPATIAL;
    double turning[3] = {0.0};
    for (int l = 0; l < 3; ++l) {
        const double *R = moves ? b->p + MBSR_POSE_R : NULL;
        w->arm[k][l] = R ? R[l] * s[0] + R[3 + l] * s[1] + R[6 + l] * s[2] : s[l];
        w->x[k][l] = w->arm[k][l] + (moves ? b->p[MBSR_POSE_X + l] : 0.0);
    }
    if (moves && b->V) mbsri_cross3(b->V, w->arm[k], turning);
    for (int l = 0; l < 3; ++l) w->v[k][l] = moves && b->V ? b->V[3 + l] + turning[l] : 0.0;
}

static void see(const mbsr_force_args *args, line *w)
{
    memset(w, 0, sizeof *w);
    for (int k = 0; k < args->bodies; ++k) see_point(args, k, w);
    for (int k = 0; k + 1 < args->bodies; ++k) {
        double size = 0.0;
        for (int l = 0; l < 3; ++l) {
            w->along[k][l] = w->x[k + 1][l] - w->x[k][l];
            size += w->along[k][l] * w->along[k][l];
        }
        size = sqrt(size);
        w->length += size;
        for (int l = 0; l < 3 && size > 0.0; ++l) {
            w->along[k][l] /= size;
            w->rate += w->along[k][l] * (w->v[k + 1][l] - w->v[k][l]);
        }
    }
}

static double beyond(const mbsr_force_args *args, double length)
{
    const double *rest = args->force->param + REST;
    return length < rest[0] ? length - rest[0] : length > rest[1] ? length - rest[1] : 0.0;
}

static int evaluate(const mbsr_force_args *args)
{
    const double *param = args->force->param;
    line w;
    see(args, &w);
    const double f = -param[STIFFNESS] * beyond(args, w.length) - param[DAMPING] * w.rate;
    for (int k = 0; k < args->bodies; ++k) {
        double F[3], moment[3], *to = args->body[k].f;
        if (args->body[k].space != MBSR_SPACE_SPATIAL || !to) continue;
        for (int l = 0; l < 3; ++l) F[l] = f * ((k > 0 ? w.along[k - 1][l] : 0.0) - w.along[k][l]);
        mbsri_cross3(w.arm[k], F, moment);
        for (int l = 0; l < 3; ++l) to[l] += moment[l], to[3 + l] += F[l];
    }
    return 0;
}

static int energy(const mbsr_force_args *args, double *sum)
{
    line w;
    see(args, &w);
    const double x = beyond(args, w.length);
    *sum += 0.5 * args->force->param[STIFFNESS] * x * x;
    return 0;
}

static int dissipation(const mbsr_force_args *args, double *power)
{
    line w;
    see(args, &w);
    *power += args->force->param[DAMPING] * w.rate * w.rate;
    return 0;
}

static const mbsr_force_table table = {
    .version = MBSR_FORCE_TABLE_VERSION,
    .flags = MBSR_FORCE_NO_JOINT | MBSR_FORCE_NO_MASS,
    .name = "path",
    .evaluate = evaluate,
    .energy = energy,
    .dissipation = dissipation,
};

mbsr_force_def mbsri_force_path(int count, const int *body, const double (*point)[3],
                                double stiffness, double damping, const double rest[2])
{
    mbsr_force_def def = mbsr_force_custom(&table, count, body, NULL);
    def.param[STIFFNESS] = stiffness;
    def.param[DAMPING] = damping;
    def.param[REST] = rest[0];
    def.param[REST + 1] = rest[1];
    memcpy(def.param + POINTS, point, (size_t)count * sizeof *point);
    return def;
}

const mbsr_force_table *mbsri_path_table(void)
{
    return &table;
}

bool mbsri_path_of(const mbsr_force_def *def, double (*point)[3], double *stiffness,
                   double *damping, double rest[2])
{
    if (def->table != &table) return false;
    *stiffness = def->param[STIFFNESS];
    *damping = def->param[DAMPING];
    memcpy(rest, def->param + REST, 2 * sizeof *rest);
    memcpy(point, def->param + POINTS, (size_t)def->bodies * sizeof *point);
    return true;
}
