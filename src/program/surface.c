/* Meshes in a page: see surface.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Corners are rounded to 2^16 places along each edge of the mesh's box (an arm of 1 m: by 8 um at
 * most), and those at one place become one vertex. Vertices are numbered as triangles first name
 * them. What is written:
 *
 *   6 planes of bytes, each with one byte of every vertex: along x, y and z the lower and the upper
 *       byte of the
 *   difference d to the vertex before, folded (0, -1, 1, -2 ... -> 0, 1, 2, 3 ...), modulo 2^16;
 *   for each corner of a triangle, how far its vertex is before the next new one (0: it is new), 7
 *       bits a
 *   byte, the lowest first, the eighth bit where more follow.
 *
 * Both are small numbers on meshes as programs write them, which deflate to a tenth of a text. */
#include "program/surface.h"

#include "program/bytes.h"

#include <mbsrank/files.h>

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* ---- corners as read ---- */

typedef struct corners {
    float *x; /* 9 a triangle */
    size_t count, room;
    double low[3], high[3];
    bool failed;
} corners;

static void take_corner(void *user, const double corner[9])
{
    corners *c = user;
    if (c->count + 9 > c->room && !c->failed) {
        const size_t room = c->room > 0 ? 2 * c->room : 9 * 1024;
        float *larger = realloc(c->x, room * sizeof *larger);
        c->failed = !larger;
        if (larger) c->x = larger, c->room = room;
    }
    if (c->failed) return;
    for (int k = 0; k < 9; ++k) {
        const int axis = k % 3;
        const bool first = c->count == 0 && k < 3;
        if (first || corner[k] < c->low[axis]) c->low[axis] = corner[k];
        if (first || corner[k] > c->high[axis]) c->high[axis] = corner[k];
        c->x[c->count + (size_t)k] = (float)corner[k];
    }
    c->count += 9;
}

/* The place of a corner, 16 bits along each axis. */
static uint64_t grid_place(const corners *c, const float x[3])
{
    uint64_t place = 0;
    for (int k = 0; k < 3; ++k) {
        const double edge = c->high[k] - c->low[k];
        const double part = edge > 0.0 ? ((double)x[k] - c->low[k]) / edge : 0.0;
        place |= (uint64_t)(65535.0 * fmin(1.0, fmax(0.0, part)) + 0.5) << 16 * k;
    }
    return place;
}

/* ---- vertices and triangles ---- */

typedef struct surface {
    uint64_t *place; /* grid place of each vertex */
    uint32_t *slot;  /* open addressing by place: vertex + 1; 0: free */
    size_t vertices, triangles, slots;
    unsigned char *steps; /* bytes of the steps between corners */
    size_t size;          /* bytes in `steps` */
} surface;

static bool allocate_surface(const corners *c, surface *s)
{
    const size_t most = c->count / 3;
    for (s->slots = 64; s->slots < 2 * most;) s->slots *= 2;
    s->place = malloc((most + 1) * sizeof *s->place);
    s->slot = calloc(s->slots, sizeof *s->slot);
    s->steps = malloc(5 * most + 1);
    return s->place && s->slot && s->steps;
}

static void release_surface(surface *s)
{
    free(s->place);
    free(s->slot);
    free(s->steps);
}

static size_t vertex_at(surface *s, uint64_t place)
{
    uint64_t at = place * UINT64_C(0x9e3779b97f4a7c15) >> 20;
    for (;; ++at) {
        uint32_t *slot = s->slot + (at & (s->slots - 1));
        if (*slot == 0) {
            s->place[s->vertices] = place;
            *slot = (uint32_t)++s->vertices;
            return s->vertices - 1;
        }
        if (s->place[*slot - 1] == place) return *slot - 1;
    }
}

/* Triangles whose corners fall together are left out. */
static void add_triangle(surface *s, const uint64_t place[3])
{
    if (place[0] == place[1] || place[1] == place[2] || place[2] == place[0]) return;
    for (int k = 0; k < 3; ++k) {
        const size_t next = s->vertices;
        size_t step = next - vertex_at(s, place[k]);
        for (; step > 127; step >>= 7) s->steps[s->size++] = (unsigned char)(step | 128);
        s->steps[s->size++] = (unsigned char)step;
    }
    ++s->triangles;
}

/* The planes of the vertices, and the steps behind them. NULL: no memory. */
static unsigned char *join_planes(const surface *s, size_t *size)
{
    const size_t n = s->vertices;
    *size = 6 * n + s->size;
    unsigned char *bytes = malloc(*size + 1);
    if (!bytes) return NULL;
    uint64_t before = 0;
    for (size_t k = 0; k < n; before = s->place[k++]) {
        for (int axis = 0; axis < 3; ++axis) {
            const unsigned d = (unsigned)(s->place[k] >> 16 * axis) -
                               (unsigned)(before >> 16 * axis),
                           folded = d << 1 ^ (d & 0x8000U ? 0xffffU : 0U);
            bytes[2 * (size_t)axis * n + k] = (unsigned char)folded;
            bytes[(2 * (size_t)axis + 1) * n + k] = (unsigned char)(folded >> 8);
        }
    }
    memcpy(bytes + 6 * n, s->steps, s->size);
    return bytes;
}

static bool write_surface(FILE *to, const corners *c, const surface *s)
{
    size_t size;
    unsigned char *bytes = join_planes(s, &size);
    if (!bytes) return false;
    fprintf(to, "\"vertices\": %zu, \"triangles\": %zu, \"low\": [%.9g, %.9g, %.9g], ", s->vertices,
            s->triangles, c->low[0], c->low[1], c->low[2]);
    fprintf(to, "\"high\": [%.9g, %.9g, %.9g], \"surface\": ", c->high[0], c->high[1], c->high[2]);
    const bool good = put_bytes(to, bytes, size);
    free(bytes);
    return good;
}

/* ---- a mesh ---- */

static int no_memory_for_mesh(const char *name, mbsr_error *error)
{
    *error = (mbsr_error){.status = MBSR_ERR_NO_MEMORY};
    snprintf(error->text, sizeof error->text, "mesh '%.150s': there is no memory", name);
    return error->status;
}

/* Takes the corners away. */
static bool write_corners(FILE *to, corners *c)
{
    surface s = {.place = NULL};
    bool good = !c->failed && allocate_surface(c, &s);
    for (size_t k = 0; k < c->count && good; k += 9) {
        const uint64_t place[3] = {grid_place(c, c->x + k), grid_place(c, c->x + k + 3),
                                   grid_place(c, c->x + k + 6)};
        add_triangle(&s, place);
    }
    if (good) good = write_surface(to, c, &s);
    release_surface(&s);
    free(c->x);
    return good;
}

static int put_surface(FILE *to, const char *name, const char *text, size_t size, mbsr_error *error)
{
    corners c = {.x = NULL};
    const int status = mbsr_mesh_triangles(text, size, name, take_corner, &c, error);
    if (!status) return write_corners(to, &c) ? MBSR_OK : no_memory_for_mesh(name, error);
    free(c.x);
    return status;
}

int put_triangles(FILE *to, const char *name, int count, const double *triangle, mbsr_error *error)
{
    corners c = {.x = NULL};
    for (int k = 0; k < count; ++k) take_corner(&c, triangle + 9 * (size_t)k);
    fputc('{', to);
    const int status = write_corners(to, &c) ? MBSR_OK : no_memory_for_mesh(name, error);
    fputc('}', to);
    return status;
}

/* Its root element stands near the beginning. */
static bool is_collada(const char *text, size_t size)
{
    static const char root[] = "<COLLADA";
    const size_t length = sizeof root - 1;
    for (size_t k = 0; k + length <= size && k < 4096; ++k)
        if (memcmp(text + k, root, length) == 0) return true;
    return false;
}

int put_mesh(FILE *to, const char *name, const char *text, size_t size, mbsr_error *error)
{
    int status = MBSR_OK;
    fputc('{', to);
    if (!is_collada(text, size)) {
        status = put_surface(to, name, text, size, error);
    } else {
        fputs("\"collada\": ", to);
        if (!put_bytes(to, text, size)) status = no_memory_for_mesh(name, error);
    }
    fputc('}', to);
    return status;
}
