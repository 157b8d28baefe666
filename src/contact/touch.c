/* Finding the points at which two shapes touch: see touch.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "contact/touch.h"

#include "algebra/space3.h"
#include "contact/field.h"
#include "contact/round.h"

#include <string.h>

/* Below that part of its length a vector has no direction. */
static const double tiny = 1e-300;

/* A search: a's features over b's, in b's frame. */
typedef struct search {
    const mbsri_placed *a, *b;
    double margin; /* forces begin so far before the surfaces meet, m */
    bool exchanged;
    double weight; /* of points of a */
    mbsri_touch_fn touch;
    void *user;
} search;

/* ---- placing ---- */

void mbsri_place_shape(const mbsri_shape *shape, const double R[9], const double x[3],
                       mbsri_placed *placed)
{
    double middle[3];
    placed->shape = shape;
    mbsri_multiply3(R, shape->R, placed->R);
    mbsri_rotate3(R, shape->x, placed->x);
    mbsri_add3(1.0, x, placed->x);
    mbsri_rotate3(placed->R, shape->middle, middle);
    for (int k = 0; k < 3; ++k) {
        double reach = 0.0;
        for (int l = 0; l < 3; ++l) reach += fabs(placed->R[3 * l + k]) * shape->extent[l];
        if (!mbsri_is_ground(shape->kind)) reach = fmin(reach, shape->ball);
        reach += shape->margin;
        placed->low[k] = placed->x[k] + middle[k] - reach;
        placed->high[k] = placed->x[k] + middle[k] + reach;
    }
}

/* A point or direction of a placed shape, in the world; and the other way. */
static void outward(const mbsri_placed *p, const double in_shape[3], double x[3])
{
    mbsri_rotate3(p->R, in_shape, x);
    mbsri_add3(1.0, p->x, x);
}

static void inward(const mbsri_placed *p, const double x[3], double in_shape[3])
{
    const double arm[3] = {x[0] - p->x[0], x[1] - p->x[1], x[2] - p->x[2]};
    mbsri_unrotate3(p->R, arm, in_shape);
}

/* ---- what is found ---- */

static int give(const search *w, mbsri_touch *t)
{
    t->depth = t->ra + t->rb + w->margin - t->s;
    t->exchanged = w->exchanged;
    return t->depth > 0.0 && t->weight > 0.0 ? w->touch(w->user, t) : 0;
}

/* A point of a over a face of b: unit normal and a point of its plane in the world. */
static int over_plane(const search *w, const double pa[3], const double n[3], const double on[3])
{
    mbsri_touch t = {.features = MBSRI_POINT_PLANE,
                     .ra = w->a->shape->core.radius,
                     .rb = w->b->shape->core.radius,
                     .weight = w->weight};
    memcpy(t.n, n, sizeof t.n);
    memcpy(t.pa, pa, sizeof t.pa);
    for (int k = 0; k < 3; ++k) t.s += n[k] * (pa[k] - on[k]);
    for (int k = 0; k < 3; ++k) t.pb[k] = pa[k] - t.s * n[k];
    return give(w, &t);
}

/* n and s from the points of the cores; where they coincide, from the middle of b to that of a. */
static void find_normal(const search *w, mbsri_touch *t)
{
    double d[3];
    for (int k = 0; k < 3; ++k) d[k] = t->pa[k] - t->pb[k];
    t->s = mbsri_norm3(d);
    if (!(t->s > tiny)) {
        for (int k = 0; k < 3; ++k) d[k] = w->a->x[k] - w->b->x[k];
        if (!mbsri_direction3(d, t->n)) t->n[0] = t->n[1] = 0.0, t->n[2] = 1.0;
        t->s = 0.0;
        return;
    }
    for (int k = 0; k < 3; ++k) t->n[k] = d[k] / t->s;
}

/* A point of a near a point pb, which is a corner of b or on a line along `line` (unit, NULL: a
 * corner). */
static int near_point(const search *w, const double pa[3], const double pb[3], const double *line,
                      double more)
{
    mbsri_touch t = {.features = line ? MBSRI_POINT_LINE : MBSRI_POINT_POINT,
                     .ra = w->a->shape->core.radius,
                     .rb = w->b->shape->core.radius + more,
                     .weight = w->weight};
    memcpy(t.pa, pa, sizeof t.pa);
    memcpy(t.pb, pb, sizeof t.pb);
    if (line) memcpy(t.tb, line, sizeof t.tb);
    find_normal(w, &t);
    return give(w, &t);
}

/* ---- a point over a core ---- */

static int point_over_segment(const search *w, const double pa[3], const double local[3])
{
    const mbsri_placed *b = w->b;
    const double half = b->shape->core.corner[1][2], z = local[2];
    const double end[3] = {0.0, 0.0, fmax(-half, fmin(half, z))};
    double pb[3];
    outward(b, end, pb);
    return near_point(w, pa, pb, fabs(z) < half ? b->R + 6 : NULL, 0.0);
}

/* The face of a box that a point inside is nearest to. */
static int inside_box(const search *w, const double pa[3], const double local[3])
{
    const mbsri_placed *b = w->b;
    const double *half = b->shape->core.half;
    int nearest = 0;
    for (int k = 1; k < 3; ++k) {
        if (half[k] - fabs(local[k]) < half[nearest] - fabs(local[nearest])) nearest = k;
    }
    const double sign = local[nearest] < 0.0 ? -1.0 : 1.0;
    double n[3], on[3] = {0.0, 0.0, 0.0}, at[3];
    on[nearest] = sign * half[nearest];
    outward(b, on, at);
    for (int k = 0; k < 3; ++k) n[k] = sign * b->R[3 * nearest + k];
    return over_plane(w, pa, n, at);
}

static int point_over_box(const search *w, const double pa[3], const double local[3])
{
    const mbsri_placed *b = w->b;
    const double *half = b->shape->core.half;
    double near[3], pb[3], n[3];
    int beyond = 0, out = 0, along = 0;
    for (int k = 0; k < 3; ++k) {
        near[k] = fmax(-half[k], fmin(half[k], local[k]));
        if (fabs(local[k]) > half[k])
            ++beyond, out = k;
        else
            along = k;
    }
    if (beyond == 0) return inside_box(w, pa, local);
    outward(b, near, pb);
    if (beyond > 1)
        return near_point(w, pa, pb, beyond == 2 ? b->R + (ptrdiff_t)(3 * along) : NULL, 0.0);
    for (int k = 0; k < 3; ++k) n[k] = (local[out] < 0.0 ? -1.0 : 1.0) * b->R[3 * out + k];
    return over_plane(w, pa, n, pb);
}

/* Side, end, rim or inside of a cylinder. */
static int point_over_cylinder(const search *w, const double pa[3], const double local[3])
{
    const mbsri_placed *b = w->b;
    const double radius = b->shape->core.half[0], half = b->shape->core.half[1];
    const double rho = hypot(local[0], local[1]), sign = local[2] < 0.0 ? -1.0 : 1.0;
    const bool beside = rho > radius, beyond = fabs(local[2]) > half;
    const double axis[3] = {0.0, 0.0, fmax(-half, fmin(half, local[2]))},
                 end[3] = {0.0, 0.0, sign * half};
    double at[3];
    if (beside && beyond) {
        mbsri_touch t = {.features = MBSRI_POINT_CIRCLE,
                         .ra = w->a->shape->core.radius,
                         .rb = b->shape->core.radius,
                         .weight = w->weight};
        const double rim[3] = {radius * local[0] / rho, radius * local[1] / rho, end[2]};
        memcpy(t.pa, pa, sizeof t.pa);
        outward(b, rim, t.pb);
        outward(b, end, t.tb);
        memcpy(t.ta, b->R + 6, sizeof t.ta);
        t.half[0] = radius;
        find_normal(w, &t);
        return give(w, &t);
    }
    const bool side = beside || (!beyond && radius - rho < half - fabs(local[2]));
    if (side) {
        outward(b, axis, at);
        return near_point(w, pa, at, b->R + 6, radius);
    }
    double n[3];
    outward(b, end, at);
    for (int k = 0; k < 3; ++k) n[k] = sign * b->R[6 + k];
    return over_plane(w, pa, n, at);
}

/* The nearest point of a triangle (Ericson, Real-Time Collision Detection): its place, and what it
 * is on: -1 the face, 0 .. 2 a corner, 3 .. 5 the edge behind corner k - 3. */
static int nearest_of_triangle(const double p[3], const double *const x[3], double at[3])
{
    double ab[3], ac[3], d[3][3];
    for (int k = 0; k < 3; ++k) {
        ab[k] = x[1][k] - x[0][k];
        ac[k] = x[2][k] - x[0][k];
        for (int l = 0; l < 3; ++l) d[l][k] = p[k] - x[l][k];
    }
    double b[3], c[3];
    for (int l = 0; l < 3; ++l) b[l] = mbsri_dot3(ab, d[l]), c[l] = mbsri_dot3(ac, d[l]);
    const double va = b[1] * c[2] - b[2] * c[1], vb = b[2] * c[0] - b[0] * c[2],
                 vc = b[0] * c[1] - b[1] * c[0];
    double v = 0.0, w = 0.0;
    int on;
    if (b[0] <= 0.0 && c[0] <= 0.0)
        on = 0;
    else if (b[1] >= 0.0 && c[1] <= b[1])
        on = 1, v = 1.0;
    else if (c[2] >= 0.0 && b[2] <= c[2])
        on = 2, w = 1.0;
    else if (vc <= 0.0 && b[0] >= 0.0 && b[1] <= 0.0)
        on = 3, v = b[0] / (b[0] - b[1]);
    else if (vb <= 0.0 && c[0] >= 0.0 && c[2] <= 0.0)
        on = 5, w = c[0] / (c[0] - c[2]);
    else if (va <= 0.0 && c[1] - b[1] >= 0.0 && b[2] - c[2] >= 0.0)
        on = 4, w = (c[1] - b[1]) / (c[1] - b[1] + b[2] - c[2]), v = 1.0 - w;
    else
        on = -1, v = vb / (va + vb + vc), w = vc / (va + vb + vc);
    for (int k = 0; k < 3; ++k) at[k] = x[0][k] + v * ab[k] + w * ac[k];
    return on;
}

static int point_over_mesh(const search *w, const double pa[3], const double local[3])
{
    const mbsri_placed *b = w->b;
    const mbsri_core *core = &b->shape->core;
    double most = -INFINITY, least = INFINITY, at[3], best[3] = {0.0, 0.0, 0.0}, pb[3], n[3];
    int face = 0, nearest = 0, on = -1;
    for (int k = 0; k < core->faces; ++k) {
        const double height = mbsri_dot3(core->face[k], local) - core->face[k][3];
        if (height > most) most = height, face = k;
    }
    if (most - core->radius - w->a->shape->core.radius - w->margin > 0.0) return 0;
    for (int k = 0; k < core->faces && most > 0.0; ++k) {
        if (mbsri_dot3(core->face[k], local) < core->face[k][3]) continue;
        const int *corner = core->triangle[k];
        const double *const x[3] = {core->corner[corner[0]], core->corner[corner[1]],
                                    core->corner[corner[2]]};
        const int here = nearest_of_triangle(local, x, at);
        double d[3] = {local[0] - at[0], local[1] - at[1], local[2] - at[2]};
        const double square = mbsri_dot3(d, d);
        if (square >= least) continue;
        least = square, nearest = k, on = here;
        memcpy(best, at, sizeof best);
    }
    const int chosen = most > 0.0 ? nearest : face;
    mbsri_rotate3(b->R, core->face[chosen], n);
    if (most <= 0.0 || on < 0) {
        outward(b, core->corner[core->triangle[chosen][0]], pb);
        return over_plane(w, pa, n, pb);
    }
    outward(b, best, pb);
    if (on < 3) return near_point(w, pa, pb, NULL, 0.0);
    const double *from = core->corner[core->triangle[chosen][on - 3]],
                 *to = core->corner[core->triangle[chosen][(on - 2) % 3]];
    const double edge[3] = {to[0] - from[0], to[1] - from[1], to[2] - from[2]};
    double line[3], unit[3];
    (void)mbsri_direction3(edge, unit);
    mbsri_rotate3(b->R, unit, line);
    return near_point(w, pa, pb, line, 0.0);
}

/* Whether a point is farther from the box around b than both radii. */
static bool is_far(const search *w, const double local[3])
{
    const mbsri_shape *b = w->b->shape;
    const double reach = w->a->shape->core.radius + w->margin;
    for (int k = 0; k < 3; ++k) {
        if (fabs(local[k] - b->middle[k]) > b->extent[k] + reach) return true;
    }
    return false;
}

static int point_over(const search *w, const double pa[3])
{
    double local[3];
    if (w->b->shape->kind == MBSR_SHAPE_PLANE) return over_plane(w, pa, w->b->R + 6, w->b->x);
    inward(w->b, pa, local);
    if (is_far(w, local)) return 0;
    switch (w->b->shape->kind) {
    case MBSR_SHAPE_SPHERE: return near_point(w, pa, w->b->x, NULL, 0.0);
    case MBSR_SHAPE_CAPSULE: return point_over_segment(w, pa, local);
    case MBSR_SHAPE_CYLINDER: return point_over_cylinder(w, pa, local);
    case MBSR_SHAPE_BOX: return point_over_box(w, pa, local);
    case MBSR_SHAPE_MESH: return point_over_mesh(w, pa, local);
    default: return 0;
    }
}

static int corners_over(const search *w)
{
    const mbsri_core *core = &w->a->shape->core;
    int status = 0;
    for (int k = 0; k < core->corners && !status; ++k) {
        double pa[3];
        outward(w->a, core->corner[k], pa);
        status = point_over(w, pa);
    }
    return status;
}

/* ---- edges ---- */

/* 3 x^2 - 2 x^3 of the distance from the nearer end of an edge, in parts of the width. */
static double fade(double u, double length, double width)
{
    const double end = fmin(u, 1.0 - u) * length / width;
    if (end <= 0.0) return 0.0;
    return end >= 1.0 ? 1.0 : end * end * (3.0 - 2.0 * end);
}

typedef struct edge {
    int number;
    double from[3], along[3], length; /* along: unit */
} edge;

/* Whether an edge is near the box around a shape. */
static bool find_edge(const mbsri_placed *p, int k, const mbsri_placed *other, double reach,
                      edge *e)
{
    const mbsri_core *core = &p->shape->core;
    double to[3];
    e->number = k;
    outward(p, core->corner[core->edge[k][0]], e->from);
    outward(p, core->corner[core->edge[k][1]], to);
    for (int l = 0; l < 3; ++l) {
        e->along[l] = to[l] - e->from[l];
        if (fmin(to[l], e->from[l]) > other->high[l] + reach ||
            fmax(to[l], e->from[l]) < other->low[l] - reach)
            return false;
    }
    e->length = mbsri_norm3(e->along);
    for (int l = 0; l < 3; ++l) e->along[l] /= e->length;
    return true;
}

/* 1 up to 0, 0 from `width` on. */
static double fall(double x, double width, double *slope)
{
    const double y = fmin(1.0, fmax(0.0, 1.0 - x / width));
    *slope = -6.0 * y * (1.0 - y) / width;
    return y * y * (3.0 - 2.0 * y);
}

static const double beyond = 0.5; /* the sine of 30 degrees */

/* Whether the normal leans too far over a face beside for any weight. */
static bool leans(const mbsri_touch *t)
{
    bool far = false;
    for (int k = 0; k < 2; ++k)
        far = far || -mbsri_dot3(t->n, t->into_a[k]) >= beyond ||
              mbsri_dot3(t->n, t->into_b[k]) >= beyond;
    return far;
}

double mbsri_edges_weight(const mbsri_touch *t, double *slopes)
{
    static const double last = 0.5, thin = 1e-3; /* parts of both radii */
    const double limit = t->ra + t->rb;
    double part[6], slope[6], all = 1.0;
    for (int k = 0; k < 2; ++k) {
        part[k] = fall(-mbsri_dot3(t->n, t->into_a[k]), beyond, slope + k);
        part[2 + k] = fall(mbsri_dot3(t->n, t->into_b[k]), beyond, slope + 2 + k);
    }
    part[4] = fall(-t->s - (1.0 - last) * limit, last * limit, slope + 4);
    part[5] = fall(t->height, thin * limit, slope + 5);
    slope[4] = -slope[4];
    for (int k = 0; k < 6; ++k) all *= part[k];
    for (int k = 0; k < 6 && slopes; ++k) {
        slopes[k] = slope[k];
        for (int l = 0; l < 6; ++l) slopes[k] *= l == k ? 1.0 : part[l];
    }
    return all;
}

/* How far a point is out of a core with faces, and the normal of the face there. */
static double height_over(const mbsri_placed *p, const double x[3], double out[3])
{
    const mbsri_core *core = &p->shape->core;
    const bool box = p->shape->kind == MBSR_SHAPE_BOX;
    double local[3], most = -INFINITY, normal[3] = {0.0, 0.0, 0.0};
    inward(p, x, local);
    for (int k = 0; k < (box ? 6 : core->faces); ++k) {
        const double sign = k % 2 ? 1.0 : -1.0;
        const double height = box ? sign * local[k / 2] - core->half[k / 2]
                                  : mbsri_dot3(core->face[k], local) - core->face[k][3];
        if (height <= most) continue;
        most = height;
        for (int l = 0; l < 3; ++l) normal[l] = box ? (l == k / 2 ? sign : 0.0) : core->face[k][l];
    }
    mbsri_rotate3(p->R, normal, out);
    return most;
}

/* Where edges have passed each other: of the two points the one that is farther in a core. */
static void find_height(const search *w, mbsri_touch *t)
{
    double out[3];
    t->height = INFINITY;
    if (w->a->shape->core.side) {
        t->height = height_over(w->a, t->pb, t->out);
        t->out_of_a = true;
    }
    const double other = w->b->shape->core.side ? height_over(w->b, t->pa, out) : INFINITY;
    if (!(other < t->height)) return;
    t->height = other;
    t->out_of_a = false;
    memcpy(t->out, out, sizeof t->out);
}

/* Into the faces beside edge k of a core, in the world. */
static void find_sides(const mbsri_placed *p, int k, double into[2][3])
{
    for (int l = 0; l < 2 && p->shape->core.side; ++l)
        mbsri_rotate3(p->R, p->shape->core.side[k][l], into[l]);
}

/* With the normal as it is. */
static int give_edges(const search *w, const mbsri_touch *edges)
{
    if (leans(edges)) return 0;
    mbsri_touch t = *edges;
    if (t.s < 0.0) find_height(w, &t);
    t.weight *= mbsri_edges_weight(&t, NULL);
    return t.weight > 0.0 ? give(w, &t) : 0;
}

/* From b to a: of edges between faces the weight tells which way, of others the points. */
static int order_edges(const search *w, mbsri_touch *t)
{
    const bool faces = w->a->shape->core.side || w->b->shape->core.side;
    t->s = 0.0;
    for (int k = 0; k < 3; ++k) t->s += t->n[k] * (t->pa[k] - t->pb[k]);
    int status = faces || t->s >= 0.0 ? give_edges(w, t) : 0;
    t->s = -t->s;
    for (int k = 0; k < 3; ++k) t->n[k] = -t->n[k];
    if (!status && (faces || t->s > 0.0)) status = give_edges(w, t);
    return status;
}

static int edges_meet(const search *w, const edge *a, const edge *b)
{
    mbsri_touch t = {.features = MBSRI_LINE_LINE,
                     .ra = w->a->shape->core.radius,
                     .rb = w->b->shape->core.radius,
                     .la = a->length,
                     .lb = b->length};
    const double g = mbsri_dot3(a->along, b->along), sine = 1.0 - g * g;
    double d[3], across[3];
    if (!(sine > 1e-12)) return 0;
    for (int k = 0; k < 3; ++k) d[k] = b->from[k] - a->from[k];
    mbsri_cross3(a->along, b->along, across);
    const double volume = mbsri_dot3(across, d), reach = t.ra + t.rb + w->margin;
    if (volume * volume >= reach * reach * sine) return 0; /* the lines are too far apart */
    const double x = mbsri_dot3(d, a->along), y = mbsri_dot3(d, b->along),
                 at_a = (x - g * y) / sine, at_b = (g * x - y) / sine;
    t.ua = at_a / a->length;
    t.ub = at_b / b->length;
    t.window = fmin(t.ra + t.rb, 0.25 * fmin(a->length, b->length));
    t.weight = sine * fade(t.ua, a->length, t.window) * fade(t.ub, b->length, t.window);
    if (!(t.weight > 0.0)) return 0;
    for (int k = 0; k < 3; ++k) {
        t.pa[k] = a->from[k] + at_a * a->along[k];
        t.pb[k] = b->from[k] + at_b * b->along[k];
    }
    memcpy(t.ta, a->along, sizeof t.ta);
    memcpy(t.tb, b->along, sizeof t.tb);
    (void)mbsri_direction3(across, t.n);
    find_sides(w->a, a->number, t.into_a);
    find_sides(w->b, b->number, t.into_b);
    return order_edges(w, &t);
}

static int edges_over(const search *w)
{
    enum { MOST = 64 };
    const mbsri_core *a = &w->a->shape->core, *b = &w->b->shape->core;
    edge near[MOST];
    int status = 0;
    for (int first = 0; first < b->edges; first += MOST) {
        int count = 0;
        for (int k = first; k < b->edges && k < first + MOST; ++k)
            count += find_edge(w->b, k, w->a, b->radius + w->margin, near + count);
        for (int k = 0; k < a->edges && !status && count > 0; ++k) {
            edge e;
            if (!find_edge(w->a, k, w->b, a->radius + w->margin, &e)) continue;
            for (int l = 0; l < count && !status; ++l) status = edges_meet(w, &e, near + l);
        }
    }
    return status;
}

/* ---- cylinders and ellipsoids on planes ---- */

/* Weights of a cylinder's points by c, the cosine of its axis and the normal: c^16 of those fixed
 * to it, which is all where it stands and none where it lies, and 1 - c^16 of the lowest of a rim.
 */
static void share_rim(double c, bool fixed, mbsri_touch *t)
{
    const double sign = fixed ? 1.0 : -1.0;
    t->weight = (fixed ? 0.0 : 1.0) + sign * pow(c, 16.0);
    t->by_cosine = sign * 16.0 * pow(c, 15.0);
    t->curve = sign * 240.0 * pow(c, 14.0);
}

/* Of both rims eight points each, fixed to the cylinder, and the lowest, each with its share. */
static int cylinder_on_plane(const search *w)
{
    const mbsri_placed *a = w->a, *b = w->b;
    const double radius = a->shape->core.half[0], half = a->shape->core.half[1], *n = b->R + 6,
                 *axis = a->R + 6, cosine = mbsri_dot3(n, axis);
    double down[3];
    for (int k = 0; k < 3; ++k) down[k] = cosine * axis[k] - n[k];
    const double sine = mbsri_norm3(down);
    int status = 0;
    for (int k = 0; k < 16 && !status; ++k) {
        static const double c[] = {1.0, 0.70710678118654752, 0.0, -0.70710678118654752, -1.0};
        const int at = k / 2, x = at < 5 ? at : 8 - at,
                  y = at < 2   ? 2 - at
                      : at < 7 ? at - 2
                               : 10 - at;
        const double rim[3] = {radius * c[x], radius * c[y], k % 2 ? half : -half};
        mbsri_touch t = {.features = MBSRI_POINT_PLANE, .ra = a->shape->core.radius};
        share_rim(cosine, true, &t);
        memcpy(t.n, n, sizeof t.n);
        outward(a, rim, t.pa);
        for (int l = 0; l < 3; ++l) t.s += n[l] * (t.pa[l] - b->x[l]);
        for (int l = 0; l < 3; ++l) t.pb[l] = t.pa[l] - t.s * n[l];
        memcpy(t.ta, axis, sizeof t.ta);
        status = give(w, &t);
    }
    for (int k = 0; k < 2 && !status && sine > 1e-8; ++k) {
        mbsri_touch t = {.features = MBSRI_RIM_PLANE, .ra = a->shape->core.radius};
        share_rim(cosine, false, &t);
        const double end[3] = {0.0, 0.0, k ? half : -half};
        memcpy(t.n, n, sizeof t.n);
        memcpy(t.ta, axis, sizeof t.ta);
        outward(a, end, t.tb);
        for (int l = 0; l < 3; ++l) t.pa[l] = t.tb[l] + radius * down[l] / sine;
        for (int l = 0; l < 3; ++l) t.s += n[l] * (t.pa[l] - b->x[l]);
        for (int l = 0; l < 3; ++l) t.pb[l] = t.pa[l] - t.s * n[l];
        t.half[0] = radius;
        status = give(w, &t);
    }
    return status;
}

static int ellipsoid_on_plane(const search *w)
{
    const mbsri_placed *a = w->a, *b = w->b;
    const double *n = b->R + 6, *half = a->shape->core.half;
    mbsri_touch t = {.features = MBSRI_ELLIPSOID_PLANE, .weight = 1.0};
    double local[3], size = 0.0;
    mbsri_unrotate3(a->R, n, local);
    for (int k = 0; k < 3; ++k) size += half[k] * half[k] * local[k] * local[k];
    size = sqrt(size);
    for (int k = 0; k < 3; ++k) local[k] *= -half[k] * half[k] / size;
    memcpy(t.n, n, sizeof t.n);
    outward(a, local, t.pa);
    for (int k = 0; k < 3; ++k) t.s += n[k] * (t.pa[k] - b->x[k]);
    for (int k = 0; k < 3; ++k) t.pb[k] = t.pa[k] - t.s * n[k];
    memcpy(t.half, half, sizeof t.half);
    memcpy(t.Ra, a->R, sizeof t.Ra);
    return give(w, &t);
}

/* ---- planes and ellipsoids ---- */

static int ellipsoid_over(const search *w)
{
    mbsri_touch t;
    return mbsri_ellipsoid_over(w->a, w->b, w->margin, &t) ? give(w, &t) : 0;
}

static int on_plane(const search *w)
{
    switch (w->a->shape->kind) {
    case MBSR_SHAPE_CYLINDER: return cylinder_on_plane(w);
    case MBSR_SHAPE_ELLIPSOID: return ellipsoid_on_plane(w);
    default: return corners_over(w);
    }
}

/* ---- height fields ---- */

static int give_found(const void *user, mbsri_touch *t)
{
    return give(user, t);
}

static int sample_over(const void *user, const double x[3], double weight)
{
    search w = *(const search *)user;
    w.weight = weight;
    return point_over(&w, x);
}

/* Corners of the shape over the field, or the ellipsoid; and where that has edges or faces, samples
 * of the field over it. */
static int on_field(const search *w)
{
    const mbsri_core *core = &w->a->shape->core;
    const search back = {w->b, w->a, w->margin, !w->exchanged, 1.0, w->touch, w->user};
    int status = 0;
    if (w->a->shape->kind == MBSR_SHAPE_ELLIPSOID)
        return mbsri_field_feet(w->a, w->b, w->a->x, w->margin, give_found, w);
    for (int k = 0; k < core->corners && !status; ++k) {
        double pa[3];
        outward(w->a, core->corner[k], pa);
        status = mbsri_field_feet(w->a, w->b, pa, w->margin, give_found, w);
    }
    if (status || core->edges == 0) return status;
    return mbsri_field_samples(w->b, w->a, sample_over, &back);
}

/* ---- all of two shapes ---- */

static void middle_of(const mbsri_placed *p, double x[3])
{
    mbsri_rotate3(p->R, p->shape->middle, x);
    mbsri_add3(1.0, p->x, x);
}

/* Whether along an axis of one of the boxes around them, as they are turned, shapes are farther
 * from each other than the margin. */
static bool are_apart(const mbsri_placed *a, const mbsri_placed *b, double margin)
{
    double from[3], d[3], reach[2][3];
    middle_of(a, from);
    middle_of(b, d);
    mbsri_add3(-1.0, from, d);
    for (int k = 0; k < 3; ++k)
        reach[0][k] = a->shape->extent[k] + margin, reach[1][k] = b->shape->extent[k] + margin;
    for (int k = 0; k < 3; ++k) {
        for (int l = 0; l < 3; ++l) {
            const double along = fabs(mbsri_dot3(a->R + 3 * k, b->R + 3 * l));
            reach[0][k] += along * b->shape->extent[l];
            reach[1][l] += along * a->shape->extent[k];
        }
    }
    bool apart = false;
    for (int k = 0; k < 3; ++k)
        apart = apart || fabs(mbsri_dot3(a->R + 3 * k, d)) > reach[0][k] ||
                fabs(mbsri_dot3(b->R + 3 * k, d)) > reach[1][k];
    return apart;
}

int mbsri_touches(const mbsri_placed *a, const mbsri_placed *b, double margin, mbsri_touch_fn touch,
                  void *user)
{
    const search over = {a, b, margin, false, 1.0, touch, user},
                 under = {b, a, margin, true, 1.0, touch, user};
    const mbsr_shape_kind ka = a->shape->kind, kb = b->shape->kind;
    if (kb == MBSR_SHAPE_PLANE) return on_plane(&over);
    if (ka == MBSR_SHAPE_PLANE) return on_plane(&under);
    if (kb == MBSR_SHAPE_HEIGHTS) return on_field(&over);
    if (ka == MBSR_SHAPE_HEIGHTS) return on_field(&under);
    if (ka != MBSR_SHAPE_SPHERE && kb != MBSR_SHAPE_SPHERE && are_apart(a, b, margin)) return 0;
    if (ka == MBSR_SHAPE_ELLIPSOID) return ellipsoid_over(&over);
    if (kb == MBSR_SHAPE_ELLIPSOID) return ellipsoid_over(&under);
    if (ka == MBSR_SHAPE_SPHERE) return corners_over(&over);
    if (kb == MBSR_SHAPE_SPHERE) return corners_over(&under);
    int status = corners_over(&over);
    if (!status) status = corners_over(&under);
    return status ? status : edges_over(&over);
}

void mbsri_touch_point(const mbsri_touch *t, double p[3])
{
    for (int k = 0; k < 3; ++k)
        p[k] = 0.5 * (t->pa[k] + t->pb[k]) + 0.5 * (t->rb - t->ra) * t->n[k];
}
