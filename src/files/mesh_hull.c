/* Convex hulls of points: see mesh_hull.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * From a tetrahedron on, the point that is farthest outside of a triangle (of several the one
 * farthest from its centre, which is a corner of the hull in any case) takes the place of all
 * triangles that it sees: with the edges where these end it spans new ones. Points within 1e-10 of
 * the size above a plane count as on it. */
#include "files/mesh_hull.h"
#include "algebra/space3.h"

#include <math.h>
#include <string.h>

enum { MOST_WORK = 1 << 30 };

typedef struct facet {
    int corner[3];
    double normal[3], offset; /* outwards; of its plane */
    int farthest;             /* the point farthest outside, -1: none */
    double height;            /* of that */
    bool gone;
} facet;

typedef struct edge {
    int from, to;
} edge;

typedef struct hull {
    mbsri_arena *arena;
    const double *x; /* of all points */
    int count;
    double near;        /* what is nearer to a plane is on it, m */
    double size;        /* distance of the points that are farthest from each other, or so, m */
    mbsri_list facets;  /* facet */
    mbsri_list horizon; /* edge */
    double work;        /* points looked at */
} hull;

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static double above(const facet *f, const double x[3])
{
    return dot(f->normal, x) - f->offset;
}

static double distance(const double a[3], const double b[3])
{
    const double d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    return sqrt(dot(d, d));
}

/* Of the points outside the farthest one; of several that are as far that farthest from the centre.
 */
static void find_farthest(hull *h, facet *f)
{
    double centre[3], most = h->near, away = 0.0;
    for (int k = 0; k < 3; ++k)
        centre[k] =
            (h->x[3 * f->corner[0] + k] + h->x[3 * f->corner[1] + k] + h->x[3 * f->corner[2] + k]) /
            3.0;
    f->farthest = -1;
    f->height = 0.0;
    h->work += h->count;
    for (int k = 0; k < h->count; ++k) {
        const double *x = h->x + 3 * k, height = above(f, x);
        if (!(height > h->near) || height < most - h->near) continue;
        const double far = distance(x, centre);
        if (f->farthest >= 0 && height <= most + h->near && far <= away) continue;
        most = fmax(most, height);
        away = far;
        f->farthest = k;
        f->height = most;
    }
}

static bool add_facet(hull *h, int a, int b, int c)
{
    facet *f = mbsri_list_add(h->arena, &h->facets, sizeof *f);
    double side[2][3];
    if (!f) return false;
    *f = (facet){.corner = {a, b, c}};
    for (int k = 0; k < 3; ++k) {
        side[0][k] = h->x[3 * b + k] - h->x[3 * a + k];
        side[1][k] = h->x[3 * c + k] - h->x[3 * a + k];
    }
    mbsri_cross3(side[0], side[1], f->normal);
    const double size = sqrt(dot(f->normal, f->normal));
    for (int k = 0; k < 3; ++k) f->normal[k] = size > 0.0 ? f->normal[k] / size : 0.0;
    f->offset = dot(f->normal, h->x + 3 * a);
    find_farthest(h, f);
    return true;
}

/* ---- the first four corners ---- */

/* The point with the largest value of something. */
static int extreme_point(const hull *h, double (*of)(const hull *h, const int *given, int point),
                         const int *given, double *value)
{
    int at = 0;
    *value = -1.0;
    for (int k = 0; k < h->count; ++k) {
        const double here = of(h, given, k);
        if (here > *value) *value = here, at = k;
    }
    return at;
}

static double from_point(const hull *h, const int *given, int point)
{
    return distance(h->x + 3 * given[0], h->x + 3 * point);
}

static double from_line(const hull *h, const int *given, int point)
{
    double a[3], b[3], n[3];
    for (int k = 0; k < 3; ++k) {
        a[k] = h->x[3 * given[1] + k] - h->x[3 * given[0] + k];
        b[k] = h->x[3 * point + k] - h->x[3 * given[0] + k];
    }
    mbsri_cross3(a, b, n);
    return sqrt(dot(n, n) / dot(a, a));
}

static double from_plane(const hull *h, const int *given, int point)
{
    double a[3], b[3], c[3], n[3];
    for (int k = 0; k < 3; ++k) {
        a[k] = h->x[3 * given[1] + k] - h->x[3 * given[0] + k];
        b[k] = h->x[3 * given[2] + k] - h->x[3 * given[0] + k];
        c[k] = h->x[3 * point + k] - h->x[3 * given[0] + k];
    }
    mbsri_cross3(a, b, n);
    return fabs(dot(n, c)) / sqrt(dot(n, n));
}

static const char flat[] = "its points lie in a plane";

static const char *find_tetrahedron(hull *h)
{
    static const int faces[4][3] = {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}};
    int corner[4] = {0};
    double size, width, height, a[3], b[3], c[3], n[3];
    if (h->count < 4) return flat;
    corner[0] = extreme_point(h, from_point, corner, &size);
    corner[1] = extreme_point(h, from_point, corner, &size);
    h->near = 1e-10 * size;
    h->size = size;
    if (!(size > 0.0)) return flat;
    corner[2] = extreme_point(h, from_line, corner, &width);
    if (!(width > 1e-9 * size)) return flat;
    corner[3] = extreme_point(h, from_plane, corner, &height);
    if (!(height > 1e-9 * size)) return flat;
    for (int k = 0; k < 3; ++k) {
        a[k] = h->x[3 * corner[1] + k] - h->x[3 * corner[0] + k];
        b[k] = h->x[3 * corner[2] + k] - h->x[3 * corner[0] + k];
        c[k] = h->x[3 * corner[3] + k] - h->x[3 * corner[0] + k];
    }
    mbsri_cross3(a, b, n);
    const bool turned = dot(n, c) > 0.0; /* the first face looks at the fourth corner */
    for (int k = 0; k < 4; ++k) {
        const int *f = faces[k];
        if (!add_facet(h, corner[f[0]], corner[f[turned ? 2 : 1]], corner[f[turned ? 1 : 2]]))
            return "there is no memory for it";
    }
    return NULL;
}

/* ---- one corner more ---- */

/* Edges of triangles that are gone, but for those between two of them. */
static bool add_edge(hull *h, int from, int to)
{
    edge *e = h->horizon.items;
    for (int k = 0; k < h->horizon.count; ++k) {
        if (e[k].from != to || e[k].to != from) continue;
        e[k] = e[--h->horizon.count];
        return true;
    }
    e = mbsri_list_add(h->arena, &h->horizon, sizeof *e);
    if (e) *e = (edge){from, to};
    return e != NULL;
}

static bool add_corner(hull *h, int point)
{
    const int count = h->facets.count;
    h->horizon.count = 0;
    for (int k = 0; k < count; ++k) {
        facet *f = (facet *)h->facets.items + k;
        if (f->gone || !(above(f, h->x + 3 * point) > h->near)) continue;
        f->gone = true;
        for (int l = 0; l < 3; ++l)
            if (!add_edge(h, f->corner[l], f->corner[(l + 1) % 3])) return false;
    }
    for (int k = 0; k < h->horizon.count; ++k) {
        const edge e = ((const edge *)h->horizon.items)[k];
        if (!add_facet(h, e.from, e.to, point)) return false;
    }
    h->work += count;
    return true;
}

/* ---- all of it ---- */

/* The facet with the point that is farthest outside, by more than `least`; -1: there is none. */
static int outmost_facet(const hull *h, double least)
{
    int found = -1;
    for (int k = 0; k < h->facets.count; ++k) {
        const facet *f = (const facet *)h->facets.items + k;
        if (!f->gone && f->farthest >= 0 && f->height > least) found = k, least = f->height;
    }
    return found;
}

static const char *add_most(hull *h, int most)
{
    for (int corners = 4; corners < most; ++corners) {
        const int at = outmost_facet(h, 1e-3 * h->size);
        if (at < 0) break;
        if (h->work > MOST_WORK) return "its convex hull is too large";
        if (!add_corner(h, ((const facet *)h->facets.items)[at].farthest))
            return "there is no memory for it";
    }
    return NULL;
}

const char *mbsri_hull(mbsri_arena *arena, const double *points, int count, int most,
                       mbsri_list *sides)
{
    hull h = {.arena = arena, .x = points, .count = count};
    const char *wrong = find_tetrahedron(&h);
    if (!wrong && most > 0) wrong = add_most(&h, most);
    for (int k = 0; k < h.facets.count && !wrong && most == 0; ++k) {
        const facet *f = (const facet *)h.facets.items + k;
        if (f->gone || f->farthest < 0) continue;
        if (h.work > MOST_WORK) return "its convex hull is too large";
        if (!add_corner(&h, f->farthest)) wrong = "there is no memory for it";
    }
    for (int k = 0; k < h.facets.count && !wrong; ++k) {
        const facet *f = (const facet *)h.facets.items + k;
        mbsri_hull_side *side = f->gone ? NULL : mbsri_list_add(arena, sides, sizeof *side);
        if (side) memcpy(side->corner, f->corner, sizeof side->corner);
        if (!f->gone && !side) wrong = "there is no memory for it";
    }
    return wrong;
}
