/* The cores of shapes: see core.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "contact/core.h"

#include "algebra/space3.h"
#include "contact/error.h"
#include "contact/field.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>

/* Parts of a mesh's size within which it has to be flat or convex. */
static const double slack = 1e-6;

static int refuse_core(char text[MBSR_TEXT_SIZE], int status, const char *what, double value)
{
    mbsri_contact_print(text, MBSR_TEXT_SIZE, what, value);
    return status;
}

static void set_bounds(mbsri_shape *s, double x, double y, double z, double ball)
{
    s->extent[0] = x, s->extent[1] = y, s->extent[2] = z;
    s->ball = ball;
}

/* ---- points and segments ---- */

static int make_points(mbsri_shape *s, int corners, double half)
{
    static const int edge[1][2] = {{0, 1}};
    double(*x)[3] = calloc((size_t)corners, sizeof *x);
    if (!x) return MBSR_ERR_NO_MEMORY;
    s->memory = x;
    if (corners == 2) x[0][2] = -half, x[1][2] = half;
    s->core.corners = corners;
    s->core.corner = (const double(*)[3])x;
    s->core.edges = corners - 1;
    s->core.edge = edge;
    return MBSR_OK;
}

/* ---- boxes ---- */

static int make_box(mbsri_shape *s, const double half[3])
{
    static const int edge[12][2] = {{0, 1}, {2, 3}, {4, 5}, {6, 7}, {0, 2}, {1, 3},
                                    {4, 6}, {5, 7}, {0, 4}, {1, 5}, {2, 6}, {3, 7}};
    double(*x)[3] = calloc(8 + 24, sizeof *x), (*side)[2][3] = (double(*)[2][3])(x + 8);
    if (!x) return MBSR_ERR_NO_MEMORY;
    s->memory = x;
    for (int k = 0; k < 8; ++k) {
        for (int l = 0; l < 3; ++l) x[k][l] = k >> l & 1 ? half[l] : -half[l];
    }
    for (int k = 0; k < 12; ++k) {
        for (int l = 0; l < 2; ++l) {
            const int across = (k / 4 + 1 + l) % 3;
            side[k][l][across] = edge[k][0] >> across & 1 ? -1.0 : 1.0;
        }
    }
    memcpy(s->core.half, half, sizeof s->core.half);
    s->core.corners = 8;
    s->core.corner = (const double(*)[3])x;
    s->core.edges = 12;
    s->core.edge = edge;
    s->core.side = (const double(*)[2][3])side;
    return MBSR_OK;
}

/* ---- meshes ---- */

/* Of a mesh that is made. */
typedef struct mesh {
    double (*corner)[3];
    int (*triangle)[3];
    double (*face)[4];
    double (*side)[2][3];
    int (*edge)[2];
    int corners, faces, edges;
    double size; /* distance of the farthest corner from the middle of all */
} mesh;

static bool allocate_mesh(const mbsr_shape *from, mbsri_shape *s, mesh *m)
{
    const size_t corners = (size_t)from->vertices, faces = (size_t)from->triangles,
                 edges = 3 * faces / 2 + 1;
    const size_t doubles = 3 * corners + 4 * faces + 6 * edges, ints = 3 * faces + 2 * edges;
    double *memory = calloc(1, doubles * sizeof *memory + ints * sizeof(int));
    if (!memory) return false;
    s->memory = memory;
    m->corner = (double(*)[3])memory;
    m->face = (double(*)[4])(memory + 3 * corners);
    m->side = (double(*)[2][3])(memory + 3 * corners + 4 * faces);
    m->triangle = (int(*)[3])(void *)(memory + doubles);
    m->edge = (int(*)[2])(m->triangle + faces);
    m->corners = from->vertices;
    m->faces = from->triangles;
    return true;
}

static bool find_faces(mesh *m)
{
    for (int k = 0; k < m->faces; ++k) {
        const double *a = m->corner[m->triangle[k][0]], *b = m->corner[m->triangle[k][1]],
                     *c = m->corner[m->triangle[k][2]];
        const double ab[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]},
                     ac[3] = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};
        double n[3];
        mbsri_cross3(ab, ac, n);
        if (!(mbsri_norm3(n) > slack * slack * m->size * m->size)) return false;
        (void)mbsri_direction3(n, m->face[k]);
        m->face[k][3] = mbsri_dot3(m->face[k], a);
    }
    return true;
}

/* The triangle on the other side of an edge from corner a to b; -1: there is none, or several. */
static int behind_edge(const mesh *m, int a, int b)
{
    int found = -1;
    for (int k = 0; k < m->faces; ++k) {
        for (int l = 0; l < 3; ++l) {
            if (m->triangle[k][l] != b || m->triangle[k][(l + 1) % 3] != a) continue;
            if (found >= 0) return -1;
            found = k;
        }
    }
    return found;
}

/* Into two faces from the edge between them, from corner a to b, which is on the left of `here`. */
static void find_sides(const mesh *m, int a, int b, const double *here, const double *there,
                       double side[2][3])
{
    double along[3], into[2][3];
    for (int k = 0; k < 3; ++k) along[k] = m->corner[b][k] - m->corner[a][k];
    mbsri_cross3(here, along, into[0]);
    mbsri_cross3(along, there, into[1]);
    for (int l = 0; l < 2; ++l) (void)mbsri_direction3(into[l], side[l]);
}

/* Edges between faces that are not in one plane. False: the mesh is open. */
static bool find_edges(mesh *m)
{
    for (int k = 0; k < m->faces; ++k) {
        for (int l = 0; l < 3; ++l) {
            const int a = m->triangle[k][l], b = m->triangle[k][(l + 1) % 3],
                      other = behind_edge(m, a, b);
            if (other < 0) return false;
            if (a > b || mbsri_dot3(m->face[k], m->face[other]) > 1.0 - 1e-9) continue;
            find_sides(m, a, b, m->face[k], m->face[other], m->side[m->edges]);
            m->edge[m->edges][0] = a;
            m->edge[m->edges++][1] = b;
        }
    }
    return true;
}

static bool is_convex(const mesh *m)
{
    double below = 0.0;
    for (int k = 0; k < m->faces; ++k) {
        for (int l = 0; l < m->corners; ++l) {
            const double height = mbsri_dot3(m->face[k], m->corner[l]) - m->face[k][3];
            if (height > slack * m->size) return false;
            below = fmin(below, height);
        }
    }
    return below < -slack * m->size;
}

/* The box and the ball around a mesh, and its size. */
static void measure_mesh(mbsri_shape *s, mesh *m)
{
    double low[3], high[3];
    for (int k = 0; k < 3; ++k) {
        low[k] = high[k] = m->corner[0][k];
        for (int l = 1; l < m->corners; ++l) {
            low[k] = fmin(low[k], m->corner[l][k]);
            high[k] = fmax(high[k], m->corner[l][k]);
        }
        s->middle[k] = 0.5 * (low[k] + high[k]);
        s->extent[k] = 0.5 * (high[k] - low[k]);
    }
    m->size = 0.0;
    for (int l = 0; l < m->corners; ++l) {
        double arm[3];
        for (int k = 0; k < 3; ++k) arm[k] = m->corner[l][k] - s->middle[k];
        m->size = fmax(m->size, mbsri_norm3(arm));
    }
}

static int make_mesh(const mbsr_shape *from, mbsri_shape *s, char text[MBSR_TEXT_SIZE])
{
    mesh m = {0};
    if (!from->vertex || !from->triangle)
        return refuse_core(text, MBSR_ERR_NULL, "vertex or triangle is NULL", 0.0);
    if (from->vertices < 4 || from->triangles < 4 || from->vertices > 1 << 16 ||
        from->triangles > 1 << 16)
        return refuse_core(text, MBSR_ERR_VALUE,
                           "vertices and triangles must be between 4 and 65536, not %g",
                           from->vertices < 4 ? from->vertices : from->triangles);
    if (!allocate_mesh(from, s, &m)) return MBSR_ERR_NO_MEMORY;
    for (int k = 0; k < 3 * m.corners; ++k) {
        if (!isfinite(from->vertex[k]))
            return refuse_core(text, MBSR_ERR_VALUE, "vertex has the number %g", from->vertex[k]);
    }
    for (int k = 0; k < 3 * m.faces; ++k) {
        if (from->triangle[k] < 0 || from->triangle[k] >= m.corners)
            return refuse_core(text, MBSR_ERR_VALUE, "triangle has the vertex %g",
                               from->triangle[k]);
    }
    memcpy(m.corner, from->vertex, (size_t)m.corners * sizeof *m.corner);
    memcpy(m.triangle, from->triangle, (size_t)m.faces * sizeof *m.triangle);
    measure_mesh(s, &m);
    if (!(m.size > 0.0))
        return refuse_core(text, MBSR_ERR_VALUE, "the mesh has the size %g", m.size);
    if (!find_faces(&m)) return refuse_core(text, MBSR_ERR_VALUE, "a triangle has no area", 0.0);
    if (!find_edges(&m)) return refuse_core(text, MBSR_ERR_VALUE, "the mesh is open", 0.0);
    if (!is_convex(&m))
        return refuse_core(text, MBSR_ERR_VALUE, "the mesh is flat or not convex", 0.0);
    s->core.radius = from->rounding > 0.0 ? from->rounding : m.size / 50.0;
    s->core.corners = m.corners;
    s->core.corner = (const double(*)[3])m.corner;
    s->core.edges = m.edges;
    s->core.edge = (const int(*)[2])m.edge;
    s->core.side = (const double(*)[2][3])m.side;
    s->core.faces = m.faces;
    s->core.face = (const double(*)[4])m.face;
    s->core.triangle = (const int(*)[3])m.triangle;
    for (int k = 0; k < 3; ++k) s->extent[k] += s->core.radius;
    s->ball = m.size + s->core.radius;
    return MBSR_OK;
}

/* ---- cylinders ---- */

/* A prism whose sides are as far out of round inwards as outwards, for corners and edges over other
 * shapes; planes and points meet the cylinder itself. */
static int make_cylinder(const mbsr_shape *from, mbsri_shape *s, char text[MBSR_TEXT_SIZE])
{
    enum { SIDES = 24 };
    const double pi = 3.14159265358979323846, least = fmin(from->size[0], from->size[1]),
                 r = from->rounding > 0.0 ? from->rounding : least / 20.0,
                 radius = from->size[0] - r, half = from->size[1] - r,
                 corner = 2.0 * radius / (1.0 + cos(pi / SIDES));
    double vertex[2 * SIDES][3];
    int triangle[4 * SIDES - 4][3], used = 0;
    for (int k = 0; k < SIDES; ++k) {
        const int next = (k + 1) % SIDES;
        for (int end = 0; end < 2; ++end) {
            vertex[k + end * SIDES][0] = corner * cos(2.0 * pi * k / SIDES);
            vertex[k + end * SIDES][1] = corner * sin(2.0 * pi * k / SIDES);
            vertex[k + end * SIDES][2] = end ? half : -half;
        }
        const int sides[2][3] = {{k, next, next + SIDES}, {k, next + SIDES, k + SIDES}};
        for (int l = 0; l < 2; ++l) memcpy(triangle[used++], sides[l], sizeof sides[l]);
        if (k < 1 || k > SIDES - 2) continue;
        const int ends[2][3] = {{0, k + 1, k}, {SIDES, k + SIDES, k + 1 + SIDES}};
        for (int l = 0; l < 2; ++l) memcpy(triangle[used++], ends[l], sizeof ends[l]);
    }
    mbsr_shape prism = *from;
    prism.vertices = 2 * SIDES;
    prism.triangles = used;
    prism.vertex = vertex[0];
    prism.triangle = triangle[0];
    prism.rounding = r;
    s->core.half[0] = radius;
    s->core.half[1] = half;
    return make_mesh(&prism, s, text);
}

/* ---- height fields ---- */

static int make_heights(const mbsr_shape *from, mbsri_shape *s, char text[MBSR_TEXT_SIZE])
{
    size_t bytes;
    const int status = mbsri_field_check(from, text, &bytes);
    if (status) return status;
    s->memory = calloc(1, bytes);
    if (!s->memory) return MBSR_ERR_NO_MEMORY;
    mbsri_field_make(from, s->memory, s);
    return MBSR_OK;
}

/* ---- all ---- */

/* How many of the sizes a kind has. */
static int sizes_of(mbsr_shape_kind kind)
{
    static const int count[] = {
        [MBSR_SHAPE_BOX] = 3,     [MBSR_SHAPE_SPHERE] = 1,    [MBSR_SHAPE_CYLINDER] = 2,
        [MBSR_SHAPE_CAPSULE] = 2, [MBSR_SHAPE_ELLIPSOID] = 3, [MBSR_SHAPE_MESH] = 0,
        [MBSR_SHAPE_HEIGHTS] = 2};
    return count[kind];
}

bool mbsri_core_has_size(mbsr_shape_kind kind, const double size[3])
{
    for (int k = 0; k < sizes_of(kind); ++k)
        if (!(size[k] > 0.0 && isfinite(size[k]))) return false;
    return true;
}

static int check_sizes(const mbsr_shape *from, char text[MBSR_TEXT_SIZE])
{
    double least = INFINITY;
    for (int k = 0; k < sizes_of(from->kind); ++k) {
        const double size = from->size[k];
        least = fmin(least, size);
        if (size > 0.0 && isfinite(size)) continue;
        mbsri_contact_print(text, MBSR_TEXT_SIZE, "size[%d] is %g, must be positive and finite", k,
                            size);
        return MBSR_ERR_VALUE;
    }
    if (!(from->rounding >= 0.0) || !isfinite(from->rounding))
        return refuse_core(text, MBSR_ERR_VALUE, "rounding is %g", from->rounding);
    const bool edged = from->kind == MBSR_SHAPE_BOX || from->kind == MBSR_SHAPE_CYLINDER;
    if (edged && !(from->rounding < least))
        return refuse_core(text, MBSR_ERR_VALUE, "rounding is %g, not below the least size",
                           from->rounding);
    return MBSR_OK;
}

int mbsri_core_make(const mbsr_shape *from, mbsri_shape *s, char text[MBSR_TEXT_SIZE])
{
    const double *size = from->size;
    const int status = check_sizes(from, text);
    if (status) return status;
    switch (from->kind) {
    case MBSR_SHAPE_SPHERE:
        s->core.radius = size[0];
        set_bounds(s, size[0], size[0], size[0], size[0]);
        return make_points(s, 1, 0.0);
    case MBSR_SHAPE_CAPSULE:
        s->core.radius = size[0];
        set_bounds(s, size[0], size[0], size[0] + size[1], size[0] + size[1]);
        return make_points(s, 2, size[1]);
    case MBSR_SHAPE_CYLINDER: return make_cylinder(from, s, text);
    case MBSR_SHAPE_ELLIPSOID:
        memcpy(s->core.half, size, sizeof s->core.half);
        set_bounds(s, size[0], size[1], size[2], fmax(size[0], fmax(size[1], size[2])));
        return MBSR_OK;
    case MBSR_SHAPE_BOX: {
        const double least = fmin(size[0], fmin(size[1], size[2])),
                     r = from->rounding > 0.0 ? from->rounding : least / 20.0;
        const double half[3] = {size[0] - r, size[1] - r, size[2] - r};
        s->core.radius = r;
        set_bounds(s, size[0], size[1], size[2], mbsri_norm3(size));
        return make_box(s, half);
    }
    case MBSR_SHAPE_MESH: return make_mesh(from, s, text);
    case MBSR_SHAPE_HEIGHTS: return make_heights(from, s, text);
    default: return MBSR_OK; /* a plane has none */
    }
}
