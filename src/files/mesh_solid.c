/* What surfaces of triangles enclose: see mesh.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Over pyramids from a point P to the triangles (a, b, c) seen from there, with the volume V = a .
 * (b x c) / 6 each,
 *
 *   volume V,   first moment V / 4 (a + b + c),
 *   second moments V / 20 ((a + b + c)(a + b + c)^T + a a^T + b b^T + c c^T)
 *
 * Of a closed surface the sums do not depend on P. The kind "legacy" of MuJoCo takes |V|: first
 * with P at the centroid of the surface, which gives the centre, then with P at that centre, which
 * gives volume and tensor. Of a shell V is the area, and the divisors are 3 and 12. */
#include "files/mesh.h"
#include "algebra/space3.h"

#include <math.h>
#include <string.h>

static const int row[6] = {0, 1, 2, 0, 0, 1}, column[6] = {0, 1, 2, 1, 2, 2};

typedef struct sums {
    double volume, first[3], second[6];
} sums;

/* Twice the area, along the normal. */
static void normal_of(const mbsri_triangle *t, double n[3])
{
    double side[2][3];
    for (int k = 0; k < 6; ++k)
        side[k / 3][k % 3] = t->corner[1 + k / 3][k % 3] - t->corner[0][k % 3];
    mbsri_cross3(side[0], side[1], n);
}

static double weight_of(mbsri_mesh_inertia kind, const mbsri_triangle *t, double x[3][3])
{
    double n[3];
    normal_of(t, n);
    if (kind == MBSRI_MESH_SHELL) return 0.5 * sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    const double V = (x[0][0] * n[0] + x[0][1] * n[1] + x[0][2] * n[2]) / 6.0;
    return kind == MBSRI_MESH_LEGACY ? fabs(V) : V;
}

static sums sum_from(const mbsri_list *triangles, mbsri_mesh_inertia kind, const double P[3])
{
    const double one = kind == MBSRI_MESH_SHELL ? 3.0 : 4.0,
                 two = kind == MBSRI_MESH_SHELL ? 12.0 : 20.0;
    sums s = {.volume = 0.0};
    for (int k = 0; k < triangles->count; ++k) {
        const mbsri_triangle *t = (const mbsri_triangle *)triangles->items + k;
        double x[3][3], sum[3];
        for (int l = 0; l < 9; ++l) x[l / 3][l % 3] = t->corner[l / 3][l % 3] - P[l % 3];
        for (int l = 0; l < 3; ++l) sum[l] = x[0][l] + x[1][l] + x[2][l];
        const double V = weight_of(kind, t, x);
        s.volume += V;
        for (int l = 0; l < 3; ++l) s.first[l] += V / one * sum[l];
        for (int l = 0; l < 6; ++l) {
            const int i = row[l], j = column[l];
            s.second[l] +=
                V / two *
                (sum[i] * sum[j] + x[0][i] * x[0][j] + x[1][i] * x[1][j] + x[2][i] * x[2][j]);
        }
    }
    return s;
}

static const char *move_to_centre(const sums *s, double P[3])
{
    if (!isfinite(s->volume) || s->volume == 0.0) return "it encloses no volume";
    for (int k = 0; k < 3; ++k) P[k] += s->first[k] / s->volume;
    return NULL;
}

const char *mbsri_mesh_measure(const mbsri_list *triangles, mbsri_mesh_inertia kind,
                               mbsri_mesh_solid *solid)
{
    double P[3];
    if (triangles->count == 0) return "it has no triangles";
    memcpy(P, ((const mbsri_triangle *)triangles->items)->corner[0], sizeof P);
    sums s = sum_from(triangles, MBSRI_MESH_SHELL, P);
    const char *wrong = move_to_centre(&s, P);
    if (wrong) return wrong;
    s = sum_from(triangles, kind, P);
    wrong = move_to_centre(&s, P);
    if (wrong) return wrong;
    s = sum_from(triangles, kind, P);
    const double side = s.volume < 0.0 ? -1.0 : 1.0; /* normals inwards */
    const double trace = side * (s.second[0] + s.second[1] + s.second[2]);
    solid->volume = side * s.volume;
    memcpy(solid->centre, P, sizeof P);
    for (int k = 0; k < 6; ++k) {
        solid->tensor[k] = (k < 3 ? trace : 0.0) - side * s.second[k];
        if (!isfinite(solid->tensor[k])) return "its moments are not finite";
    }
    return NULL;
}

void mbsri_mesh_move(const mbsri_list *triangles, const mbsri_mesh_place *place)
{
    const double *scale = place->scale, *R = place->reference.R, *origin = place->reference.x;
    const bool mirrored = scale[0] * scale[1] * scale[2] < 0.0;
    for (int k = 0; k < triangles->count; ++k) {
        mbsri_triangle *t = (mbsri_triangle *)triangles->items + k, old = *t;
        for (int c = 0; c < 3; ++c) {
            double *to = t->corner[mirrored && c > 0 ? 3 - c : c];
            for (int l = 0; l < 3; ++l) {
                to[l] = 0.0;
                for (int i = 0; i < 3; ++i) to[l] += R[3 * l + i] * (old.corner[c][i] - origin[i]);
                to[l] *= scale[l];
            }
        }
    }
}

void mbsri_mesh_bounds(const mbsri_list *triangles, const mbsr_frame *frame, double lower[3],
                       double upper[3])
{
    for (int l = 0; l < 3; ++l) lower[l] = INFINITY, upper[l] = -INFINITY;
    for (int k = 0; k < 3 * triangles->count; ++k) {
        const double *x = ((const mbsri_triangle *)triangles->items)[k / 3].corner[k % 3];
        for (int l = 0; l < 3; ++l) {
            double along = 0.0;
            for (int i = 0; i < 3; ++i) along += frame->R[3 * l + i] * (x[i] - frame->x[i]);
            lower[l] = fmin(lower[l], along);
            upper[l] = fmax(upper[l], along);
        }
    }
}
