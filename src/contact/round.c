/* Ellipsoids against convex cores: see round.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The distance from an ellipsoid is a convex function of the place, negative inside. Where it is
 * least on a core, it is so on a face, where the ellipsoid lies lowest over it; along an edge; or
 * at a corner. Two ellipsoids touch along the normal n for which the distance between their planes
 * of support is largest. */
#include "contact/round.h"

#include "algebra/space3.h"

#include <string.h>

void mbsri_support_ellipsoid(const double half[3], const double R[9], const double n[3],
                             double at[3], double K[9])
{
    double m[3], local[3], size = 0.0;
    mbsri_unrotate3(R, n, m);
    for (int k = 0; k < 3; ++k) size += half[k] * half[k] * m[k] * m[k];
    size = sqrt(size);
    for (int k = 0; k < 3; ++k) local[k] = half[k] * half[k] * m[k] / size;
    mbsri_rotate3(R, local, at);
    if (!K) return;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            double sum = 0.0;
            for (int k = 0; k < 3; ++k) sum += R[3 * k + i] * half[k] * half[k] * R[3 * k + j];
            K[3 * j + i] = (sum - at[i] * at[j]) / size;
        }
    }
}

/* The distance of y from an ellipsoid, the nearest point p of its surface and the unit normal m
 * there, in its axes: p = S^2 y / (t + S^2) with |p / S| = 1 (Eberly, Distance from a Point to an
 * Ellipse). |p / S| falls as t grows and is convex, so Newton's method from below does not pass the
 * root. */
static double distance_from(const double half[3], const double y[3], double p[3], double m[3])
{
    double t = -INFINITY, excess = 0.0;
    int least = 0;
    for (int k = 0; k < 3; ++k) {
        t = fmax(t, half[k] * (fabs(y[k]) - half[k]));
        if (half[k] < half[least]) least = k;
    }
    for (int round = 0; round < 100; ++round) {
        double slope = 0.0;
        excess = -1.0;
        for (int k = 0; k < 3; ++k) {
            const double under = t + half[k] * half[k];
            if (!(under > 0.0)) continue;
            const double part = half[k] * y[k] / under;
            excess += part * part;
            slope += 2.0 * part * part / under;
        }
        if (!(excess > 4e-16)) break;
        t += excess / slope;
    }
    for (int k = 0; k < 3; ++k) {
        const double under = t + half[k] * half[k];
        p[k] = under > 0.0 ? half[k] * half[k] * y[k] / under : 0.0;
    }
    /* in the disk from which both sides are as near */
    if (excess < -1e-12) p[least] = half[least] * sqrt(-excess) * (y[least] < 0.0 ? -1.0 : 1.0);
    for (int k = 0; k < 3; ++k) m[k] = p[k] / (half[k] * half[k]);
    const double size = mbsri_norm3(m);
    for (int k = 0; k < 3; ++k) m[k] /= size;
    return t * size;
}

/* What was found so far, t.s being the distance. */
typedef struct found {
    const mbsri_placed *a, *b;
    mbsri_touch *t;
} found;

static void keep_place(const found *f, mbsri_features features, double s, const double y[3],
                       const double p[3], const double m[3])
{
    mbsri_touch *t = f->t;
    t->features = features;
    t->s = s;
    mbsri_rotate3(f->a->R, p, t->pa);
    mbsri_rotate3(f->a->R, y, t->pb);
    mbsri_rotate3(f->a->R, m, t->n);
    for (int k = 0; k < 3; ++k) {
        t->pa[k] += f->a->x[k];
        t->pb[k] += f->a->x[k];
        t->n[k] = -t->n[k];
    }
}

/* ---- faces ---- */

/* Where the ellipsoid lies lowest over a face with the normal n: in b's frame. */
static void lowest(const found *f, const double n[3], double pa[3], double local[3])
{
    double down[3], arm[3];
    mbsri_support_ellipsoid(f->t->half, f->a->R, n, down, NULL);
    for (int k = 0; k < 3; ++k) {
        pa[k] = f->a->x[k] - down[k];
        arm[k] = pa[k] - f->b->x[k];
    }
    mbsri_unrotate3(f->b->R, arm, local);
}

static void keep_face(const found *f, const double n[3], const double pa[3], double s)
{
    mbsri_touch *t = f->t;
    t->features = MBSRI_ELLIPSOID_PLANE;
    t->s = s;
    memcpy(t->n, n, sizeof t->n);
    memcpy(t->pa, pa, sizeof t->pa);
    for (int k = 0; k < 3; ++k) t->pb[k] = pa[k] - s * n[k];
}

/* Whether a point lies over a triangle. */
static bool is_over(const mbsri_core *core, int face, const double x[3])
{
    bool over = true;
    for (int k = 0; k < 3; ++k) {
        const double *from = core->corner[core->triangle[face][k]],
                     *to = core->corner[core->triangle[face][(k + 1) % 3]];
        double along[3], arm[3], cross[3];
        for (int l = 0; l < 3; ++l) along[l] = to[l] - from[l], arm[l] = x[l] - from[l];
        mbsri_cross3(along, arm, cross);
        over = over && mbsri_dot3(cross, core->face[face]) >= 0.0;
    }
    return over;
}

static bool over_faces(const found *f)
{
    const mbsri_core *core = &f->b->shape->core;
    const bool box = f->b->shape->kind == MBSR_SHAPE_BOX;
    double most = -INFINITY, n[3], pa[3], local[3];
    for (int k = 0; k < (box ? 6 : core->faces); ++k) {
        const double sign = k % 2 ? -1.0 : 1.0;
        double s;
        bool over = true;
        if (box) {
            for (int l = 0; l < 3; ++l) n[l] = sign * f->b->R[3 * (k / 2) + l];
            lowest(f, n, pa, local);
            s = sign * local[k / 2] - core->half[k / 2];
            for (int l = 0; l < 3; ++l)
                over = over && (l == k / 2 || fabs(local[l]) <= core->half[l]);
        } else {
            mbsri_rotate3(f->b->R, core->face[k], n);
            lowest(f, n, pa, local);
            s = mbsri_dot3(core->face[k], local) - core->face[k][3];
            over = is_over(core, k, local);
        }
        if (!over || s <= most) continue;
        most = s;
        keep_face(f, n, pa, s);
    }
    return most > -INFINITY;
}

/* ---- edges and corners ---- */

/* Where the distance is least on an edge, by false position (Illinois) on its slope; places of
 * edges in a's axes. */
static void along_edge(const found *f, const double from[3], const double along[3])
{
    const double *half = f->t->half;
    double y[3], p[3], m[3], u = 0.5, ends[2] = {0.0, 1.0}, slope[2], s;
    for (int k = 0; k < 3; ++k) y[k] = from[k] + 0.5 * along[k];
    s = distance_from(half, y, p, m);
    if (s - 0.5 * fabs(mbsri_dot3(m, along)) >= f->t->s) return; /* it is convex */
    for (int e = 0; e < 2; ++e) {
        for (int k = 0; k < 3; ++k) y[k] = from[k] + ends[e] * along[k];
        s = distance_from(half, y, p, m);
        slope[e] = mbsri_dot3(m, along);
        if (e ? slope[1] > 0.0 : slope[0] < 0.0) continue;
        if (s < f->t->s) keep_place(f, MBSRI_ELLIPSOID_POINT, s, y, p, m);
        return;
    }
    const double length = mbsri_norm3(along);
    for (int round = 0, side = -1; round < 100; ++round) {
        u = (ends[0] * slope[1] - ends[1] * slope[0]) / (slope[1] - slope[0]);
        for (int k = 0; k < 3; ++k) y[k] = from[k] + u * along[k];
        s = distance_from(half, y, p, m);
        const double now = mbsri_dot3(m, along);
        const int end = now > 0.0;
        if (fabs(now) <= 1e-15 * length || !(ends[1] - ends[0] > 1e-15)) break;
        ends[end] = u;
        slope[end] = now;
        if (side == end) slope[1 - end] *= 0.5;
        side = end;
    }
    if (!(s < f->t->s)) return;
    double line[3], unit[3];
    keep_place(f, MBSRI_ELLIPSOID_LINE, s, y, p, m);
    (void)mbsri_direction3(along, unit);
    mbsri_rotate3(f->a->R, unit, line);
    memcpy(f->t->tb, line, sizeof line);
}

static void corner_to_ellipsoid(const found *f, int k, double y[3])
{
    double x[3];
    mbsri_rotate3(f->b->R, f->b->shape->core.corner[k], x);
    for (int l = 0; l < 3; ++l) x[l] += f->b->x[l] - f->a->x[l];
    mbsri_unrotate3(f->a->R, x, y);
}

static void over_edges(const found *f)
{
    const mbsri_core *core = &f->b->shape->core;
    double from[3], to[3], p[3], m[3];
    for (int k = 0; k < core->edges; ++k) {
        corner_to_ellipsoid(f, core->edge[k][0], from);
        corner_to_ellipsoid(f, core->edge[k][1], to);
        for (int l = 0; l < 3; ++l) to[l] -= from[l];
        along_edge(f, from, to);
    }
    if (core->edges > 0) return;
    corner_to_ellipsoid(f, 0, from);
    const double s = distance_from(f->t->half, from, p, m);
    if (s < f->t->s) keep_place(f, MBSRI_ELLIPSOID_POINT, s, from, p, m);
}

/* Whether the plane at pb across n has all of b below it. */
static bool supports(const found *f)
{
    const mbsri_core *core = &f->b->shape->core;
    const double slack = 1e-9 * mbsri_norm3(f->b->shape->extent);
    bool below = true;
    for (int k = 0; k < core->corners; ++k) {
        double x[3];
        mbsri_rotate3(f->b->R, core->corner[k], x);
        for (int l = 0; l < 3; ++l) x[l] += f->b->x[l] - f->t->pb[l];
        below = below && mbsri_dot3(f->t->n, x) <= slack;
    }
    return below;
}

/* ---- two ellipsoids ---- */

/* The distance of the planes of support along n, the points there, and the sum of K of both. */
static double support_both(const found *f, const double n[3], double pa[3], double pb[3],
                           double K[9])
{
    double Kb[9], s = 0.0;
    mbsri_support_ellipsoid(f->t->half, f->a->R, n, pa, K);
    mbsri_support_ellipsoid(f->t->half_b, f->b->R, n, pb, Kb);
    for (int k = 0; k < 9; ++k) K[k] += Kb[k];
    for (int k = 0; k < 3; ++k) {
        pa[k] = f->a->x[k] - pa[k];
        pb[k] += f->b->x[k];
        s += n[k] * (pa[k] - pb[k]);
    }
    return s;
}

void mbsri_solve_across(const double K[9], double s, const double n[3], const double right[3],
                        double x[3])
{
    const int up = fabs(n[0]) < 0.6 ? 0 : 1;
    double axis[3] = {up == 0, up == 1, 0.0}, e[2][3], A[3], b[2];
    mbsri_cross3(n, axis, e[0]);
    (void)mbsri_direction3(e[0], e[0]);
    mbsri_cross3(n, e[0], e[1]);
    for (int i = 0; i < 2; ++i) {
        double Ke[3];
        for (int k = 0; k < 3; ++k)
            Ke[k] = K[k] * e[i][0] + K[3 + k] * e[i][1] + K[6 + k] * e[i][2];
        A[i] = mbsri_dot3(e[i], Ke) + s;
        A[2] = mbsri_dot3(e[0], Ke); /* of the last */
        b[i] = mbsri_dot3(e[i], right);
    }
    const double det = A[0] * A[1] - A[2] * A[2], u = (A[1] * b[0] - A[2] * b[1]) / det,
                 v = (A[0] * b[1] - A[2] * b[0]) / det;
    for (int k = 0; k < 3; ++k) x[k] = u * e[0][k] + v * e[1][k];
}

/* Newton's method for the largest distance of support, on the sphere of all n; s stands in the
 * matrix only where that makes it larger, so that every step goes upwards. */
static void over_ellipsoid(const found *f)
{
    mbsri_touch *t = f->t;
    const double size = fmin(t->half[0], fmin(t->half[1], t->half[2])),
                 start[3] = {f->b->x[0] - f->a->x[0], f->b->x[1] - f->a->x[1],
                             f->b->x[2] - f->a->x[2]};
    double y[3], p[3], m[3], K[9];
    mbsri_unrotate3(f->a->R, start, y);
    keep_place(f, MBSRI_ELLIPSOID_ELLIPSOID, distance_from(t->half, y, p, m), y, p, m);
    t->s = support_both(f, t->n, t->pa, t->pb, K);
    for (int round = 0; round < 60; ++round) {
        double across[3], step[3], n[3], pa[3], pb[3], Kn[9], s = -INFINITY, part = 1.0;
        for (int k = 0; k < 3; ++k) across[k] = t->pa[k] - t->pb[k];
        mbsri_add3(-t->s, t->n, across);
        mbsri_solve_across(K, round < 8 ? fmax(t->s, 0.0) : t->s, t->n, across, step);
        if (mbsri_norm3(step) < 1e-15) return;
        for (; part > 1e-6; part *= 0.5) {
            for (int k = 0; k < 3; ++k) n[k] = t->n[k] + part * step[k];
            (void)mbsri_direction3(n, n);
            s = support_both(f, n, pa, pb, Kn);
            if (s >= t->s - 1e-15 * size) break;
        }
        if (!(part > 1e-6)) return;
        t->s = s;
        memcpy(t->n, n, sizeof n);
        memcpy(t->pa, pa, sizeof pa);
        memcpy(t->pb, pb, sizeof pb);
        memcpy(K, Kn, sizeof K);
    }
}

bool mbsri_ellipsoid_over(const mbsri_placed *a, const mbsri_placed *b, double margin,
                          mbsri_touch *t)
{
    const found f = {a, b, t};
    *t = (mbsri_touch){.rb = b->shape->core.radius, .weight = 1.0};
    memcpy(t->half, a->shape->core.half, sizeof t->half);
    memcpy(t->Ra, a->R, sizeof t->Ra);
    if (b->shape->kind == MBSR_SHAPE_ELLIPSOID) {
        memcpy(t->half_b, b->shape->core.half, sizeof t->half_b);
        memcpy(t->Rb, b->R, sizeof t->Rb);
        over_ellipsoid(&f);
        return true;
    }
    const bool face = over_faces(&f);
    if (face && t->s >= 0.0) return true;
    const mbsri_touch of_face = *t;
    t->s = face ? INFINITY : t->rb + margin;
    over_edges(&f);
    /* behind a face: farther than from the plane of support at the edge, or within */
    if (face && !(supports(&f) && t->s > of_face.s)) *t = of_face;
    return t->s < t->rb + margin;
}
