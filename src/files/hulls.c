/* Convex hulls of meshes that touch: see hulls.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/hulls.h"

#include "files/mesh.h"
#include "files/mesh_hull.h"

#include <string.h>

/* What has been made, for other shapes of the same mesh. */
typedef struct hull {
    const char *mesh;
    const double *triangle;
    double scale[3];
    int corners, sides;
    const double *corner;
    const int *side;
    const char *wrong; /* why there is none */
    int reason;        /* of load */
} hull;

static bool is_hull_of(const hull *h, const mbsr_file_shape *shape)
{
    const bool same = h->mesh && shape->mesh
                          ? strcmp(h->mesh, shape->mesh) == 0
                          : h->triangle == shape->triangle && !h->mesh && !shape->mesh;
    return same && memcmp(h->scale, shape->size, sizeof h->scale) == 0;
}

/* The triangles of the file of a mesh: beside the model, or as it stands. */
static const char *load_triangles(mbsri_scene *s, const char *mesh, mbsri_arena *arena,
                                  mbsri_list *triangles, int *reason)
{
    const mbsr_file_opt *opt = s->opt;
    const char *text, *path = mbsri_arena_join(arena, mesh[0] == '/' ? "" : s->home, mesh, "");
    size_t size;
    if (!path) return "there is no memory for it";
    *reason = opt->load ? opt->load(opt->user, path, &text, &size) : 1;
    if (*reason && opt->load && strcmp(path, mesh) != 0 &&
        opt->load(opt->user, mesh, &text, &size) == 0)
        *reason = 0;
    return *reason ? "there is no such file" : mbsri_mesh_read(arena, text, size, mesh, triangles);
}

/* The corners of all triangles, scaled; *count of them. */
static const char *take_points(mbsri_scene *s, const mbsr_file_shape *shape, mbsri_arena *arena,
                               double **points, int *count, int *reason)
{
    const double *from = shape->triangle;
    int triangles = shape->triangles;
    if (shape->mesh) {
        mbsri_list list = {.count = 0};
        const char *wrong = load_triangles(s, shape->mesh, arena, &list, reason);
        if (wrong) return wrong;
        triangles = list.count;
        from = list.count > 0 ? ((const mbsri_triangle *)list.items)->corner[0] : NULL;
    }
    if (triangles == 0) return "it has no triangles";
    if (triangles > 1 << 24) return "it has too many triangles";
    *count = 3 * triangles;
    *points = mbsri_arena_take(arena, 3 * (size_t)*count * sizeof **points);
    if (!*points) return "there is no memory for it";
    for (int k = 0; k < 3 * *count; ++k) (*points)[k] = shape->size[k % 3] * from[k];
    return NULL;
}

/* Keeps the corners that sides have, numbered anew. */
static const char *keep_hull(mbsri_scene *s, mbsri_arena *arena, const double *points, int count,
                             const mbsri_list *sides, hull *h)
{
    int *number = mbsri_arena_take(arena, (size_t)count * sizeof *number);
    int *side = mbsri_arena_take(s->arena, 3 * (size_t)sides->count * sizeof *side);
    double *corner = mbsri_arena_take(s->arena, 9 * (size_t)sides->count * sizeof *corner);
    if (!number || !side || !corner) return "there is no memory for it";
    for (int k = 0; k < 3 * sides->count; ++k) {
        const int point = ((const mbsri_hull_side *)sides->items)[k / 3].corner[k % 3];
        if (number[point] == 0) {
            memcpy(corner + 3 * (ptrdiff_t)h->corners, points + 3 * (ptrdiff_t)point,
                   3 * sizeof *corner);
            number[point] = ++h->corners;
        }
        side[k] = number[point] - 1;
    }
    h->sides = sides->count;
    h->corner = corner;
    h->side = side;
    return NULL;
}

static hull make_hull(mbsri_scene *s, const mbsr_file_shape *shape)
{
    hull h = {.mesh = shape->mesh, .triangle = shape->triangle};
    mbsri_arena arena;
    mbsri_list sides = {.count = 0};
    double *points = NULL;
    int count = 0;
    memcpy(h.scale, shape->size, sizeof h.scale);
    mbsri_arena_open(&arena, &s->opt->model.allocator);
    h.wrong = take_points(s, shape, &arena, &points, &count, &h.reason);
    if (!h.wrong) h.wrong = mbsri_hull(&arena, points, count, s->opt->hull_corners, &sides);
    if (!h.wrong) h.wrong = keep_hull(s, &arena, points, count, &sides, &h);
    if (arena.failed) s->arena->failed = true;
    mbsri_arena_close(&arena);
    return h;
}

bool mbsri_hull_shape(mbsri_scene *s, const mbsri_element *e, mbsr_file_shape *shape)
{
    const hull *h = s->hulls.items;
    int at = 0;
    if (s->opt->hull_corners == 0 || !shape->contact || shape->kind != MBSR_SHAPE_MESH) return true;
    while (at < s->hulls.count && !is_hull_of(h + at, shape)) ++at;
    if (at == s->hulls.count) {
        const hull made = make_hull(s, shape);
        hull *to = mbsri_list_add(s->arena, &s->hulls, sizeof *to);
        if (!to) return false;
        *to = made;
    }
    h = (const hull *)s->hulls.items + at;
    if (h->wrong)
        mbsri_file_find(s, e, "it touches nothing: its mesh '%.60s': %s%s%s",
                        shape->mesh ? shape->mesh : "", h->wrong, h->reason > 1 ? ": " : "",
                        mbsri_file_why(h->reason));
    shape->hull_corners = h->corners;
    shape->hull_corner = h->corner;
    shape->hull_sides = h->sides;
    shape->hull_side = h->side;
    return !s->arena->failed;
}
