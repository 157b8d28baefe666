/* Reading surfaces of triangles: see mesh.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Coordinates are rounded to 32 bits, as STL has them and MuJoCo keeps them. */
#include "files/mesh.h"

#include "files/mesh_hull.h"
#include "files/numbers.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

static const char no_memory[] = "there is no memory for it";

static const char *add_triangle(mbsri_arena *arena, mbsri_list *triangles, double corner[3][3])
{
    mbsri_triangle *t = mbsri_list_add(arena, triangles, sizeof *t);
    if (!t) return no_memory;
    for (int k = 0; k < 9; ++k) {
        t->corner[k / 3][k % 3] = (double)(float)corner[k / 3][k % 3];
        if (!isfinite(t->corner[k / 3][k % 3])) return "a corner is not finite";
    }
    return NULL;
}

const char *mbsri_mesh_hull(mbsri_arena *arena, const double *points, int count,
                            mbsri_list *triangles)
{
    mbsri_list sides = {.count = 0};
    const char *wrong = mbsri_hull(arena, points, count, 0, &sides);
    for (int k = 0; k < sides.count && !wrong; ++k) {
        const int *corner = ((const mbsri_hull_side *)sides.items)[k].corner;
        double x[3][3];
        for (int l = 0; l < 3; ++l) memcpy(x[l], points + 3 * corner[l], sizeof x[l]);
        wrong = add_triangle(arena, triangles, x);
    }
    return wrong;
}

/* ---- STL ---- */

static uint32_t whole_at(const unsigned char *b)
{
    return (uint32_t)b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

static double float_at(const unsigned char *b)
{
    const uint32_t bits = whole_at(b);
    float value;
    memcpy(&value, &bits, sizeof value);
    return (double)value;
}

/* 80 bytes, the number of triangles, and 50 bytes each. */
static bool is_binary(const char *text, size_t size)
{
    const unsigned char *b = (const unsigned char *)text;
    if (size < 84) return false;
    const uint32_t count = whole_at(b + 80);
    return (size - 84) / 50 == count && (size - 84) % 50 == 0;
}

static const char *read_binary(mbsri_arena *arena, const char *text, size_t size,
                               mbsri_list *triangles)
{
    const unsigned char *b = (const unsigned char *)text + 84;
    for (size_t left = (size - 84) / 50; left > 0; --left, b += 50) {
        double corner[3][3];
        for (int k = 0; k < 9; ++k) corner[k / 3][k % 3] = float_at(b + 12 + 4 * k);
        const char *wrong = add_triangle(arena, triangles, corner);
        if (wrong) return wrong;
    }
    return NULL;
}

/* ---- lines of text ---- */

/* The next line without its end, in a buffer of its own; false: none is left. Longer ones are cut.
 */
static bool next_line(const char **text, const char *end, char line[512])
{
    if (*text >= end) return false;
    const char *stop = memchr(*text, '\n', (size_t)(end - *text));
    const size_t length = (size_t)((stop ? stop : end) - *text), kept = length < 511 ? length : 511;
    memcpy(line, *text, kept);
    line[kept] = '\0';
    *text = stop ? stop + 1 : end;
    return true;
}

static const char *after(const char *line, const char *word)
{
    const size_t length = strlen(word);
    while (*line == ' ' || *line == '\t') ++line;
    return strncmp(line, word, length) == 0 && (line[length] == ' ' || line[length] == '\t')
               ? line + length
               : NULL;
}

static const char *read_lines(mbsri_arena *arena, const char *text, const char *end,
                              mbsri_list *triangles)
{
    char line[512];
    double corner[3][3];
    int count = 0;
    while (next_line(&text, end, line)) {
        const char *numbers = after(line, "vertex");
        if (!numbers) continue;
        if (mbsri_read_numbers(numbers, 3, 3, corner[count]) != 3)
            return "a vertex is not 3 numbers";
        if (++count < 3) continue;
        const char *wrong = add_triangle(arena, triangles, corner);
        if (wrong) return wrong;
        count = 0;
    }
    return NULL;
}

/* ---- OBJ ---- */

typedef struct point {
    double x[3];
} point;

/* Of points without faces. */
static const char *add_hull(mbsri_arena *arena, const mbsri_list *points, mbsri_list *triangles)
{
    point *p = points->items;
    for (int k = 0; k < 3 * points->count; ++k) {
        p[k / 3].x[k % 3] = (double)(float)p[k / 3].x[k % 3];
        if (!isfinite(p[k / 3].x[k % 3])) return "a corner is not finite";
    }
    if (points->count == 0) return NULL;
    return mbsri_mesh_hull(arena, p->x, points->count, triangles);
}

/* The corner of "7", "7/1/2" or "-1" at *text, which moves behind it; NULL: there is none. */
static const double *corner_of(const mbsri_list *points, const char **text)
{
    char *end;
    const long number = strtol(*text, &end, 10);
    if (end == *text) return NULL;
    *text = end + strcspn(end, " \t\r");
    const long at = number < 0 ? points->count + number : number - 1;
    return at >= 0 && at < points->count ? ((const point *)points->items)[at].x : NULL;
}

static const char *add_face(mbsri_arena *arena, const mbsri_list *points, const char *text,
                            mbsri_list *triangles)
{
    double corner[3][3];
    for (int k = 0;; ++k) {
        text += strspn(text, " \t\r");
        if (!*text) return k < 3 ? "a face has less than 3 corners" : NULL;
        const double *x = corner_of(points, &text);
        if (!x) return "a face has a corner that is none";
        if (k > 2) memcpy(corner[1], corner[2], sizeof corner[1]);
        memcpy(corner[k < 2 ? k : 2], x, sizeof corner[0]);
        const char *wrong = k >= 2 ? add_triangle(arena, triangles, corner) : NULL;
        if (wrong) return wrong;
    }
}

static const char *read_obj(mbsri_arena *arena, const char *text, const char *end,
                            mbsri_list *triangles)
{
    mbsri_list points = {.count = 0};
    const int before = triangles->count;
    char line[512];
    while (next_line(&text, end, line)) {
        const char *numbers = after(line, "v"), *face = after(line, "f"), *wrong = NULL;
        double x[6];
        if (numbers) {
            if (mbsri_read_numbers(numbers, 3, 6, x) < 3) return "a vertex is not 3 numbers";
            point *p = mbsri_list_add(arena, &points, sizeof *p);
            if (!p) return no_memory;
            memcpy(p->x, x, sizeof p->x);
        }
        if (face) wrong = add_face(arena, &points, face, triangles);
        if (wrong) return wrong;
    }
    return triangles->count == before ? add_hull(arena, &points, triangles) : NULL;
}

/* ---- MSH: counts of points, normals, places in textures and triangles, then all of these ---- */

static const char *read_msh(mbsri_arena *arena, const char *text, size_t size,
                            mbsri_list *triangles)
{
    const unsigned char *b = (const unsigned char *)text;
    uint64_t count[4];
    if (size < 16) return "it has no head";
    for (int k = 0; k < 4; ++k) count[k] = whole_at(b + 4 * k);
    const uint64_t before = 16 + 12 * count[0] + 12 * count[1] + 8 * count[2];
    if (size != before + 12 * count[3]) return "its size is not what its head says";
    for (uint64_t k = 0; k < count[3]; ++k) {
        double corner[3][3];
        for (int l = 0; l < 9; ++l) {
            const uint64_t number = whole_at(b + before + 12 * k + 4 * (uint64_t)(l / 3));
            if (number >= count[0]) return "a face has a corner that is none";
            corner[l / 3][l % 3] = float_at(b + 16 + 12 * number + 4 * (uint64_t)(l % 3));
        }
        const char *wrong = add_triangle(arena, triangles, corner);
        if (wrong) return wrong;
    }
    return NULL;
}

/* ---- all of them ---- */

static bool ends_in(const char *name, const char *ending)
{
    const size_t length = strlen(name), tail = strlen(ending);
    return length > tail && strcmp(name + length - tail, ending) == 0;
}

const char *mbsri_mesh_read(mbsri_arena *arena, const char *text, size_t size, const char *name,
                            mbsri_list *triangles)
{
    if (ends_in(name, ".msh")) return read_msh(arena, text, size, triangles);
    if (is_binary(text, size)) return read_binary(arena, text, size, triangles);
    return size > 5 && memcmp(text, "solid", 5) == 0
               ? read_lines(arena, text, text + size, triangles)
               : read_obj(arena, text, text + size, triangles);
}

const char *mbsri_mesh_of_numbers(mbsri_arena *arena, const char *points, const char *faces,
                                  mbsri_list *triangles)
{
    mbsri_list list = {.count = 0};
    while (*points) {
        point *p = mbsri_list_add(arena, &list, sizeof *p);
        if (!p) return no_memory;
        for (int k = 0; k < 3; ++k)
            if (!mbsri_read_number(&points, p->x + k)) return "a vertex is not 3 numbers";
    }
    if (!faces) return add_hull(arena, &list, triangles);
    while (*faces) {
        double corner[3][3], number;
        for (int k = 0; k < 3; ++k) {
            if (!mbsri_read_number(&faces, &number)) return "a face is not 3 numbers";
            if (!(number >= 0.0 && number < list.count)) return "a face has a corner that is none";
            memcpy(corner[k], ((const point *)list.items)[(int)number].x, sizeof corner[k]);
        }
        const char *wrong = add_triangle(arena, triangles, corner);
        if (wrong) return wrong;
    }
    return NULL;
}
