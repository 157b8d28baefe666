/* Surfaces of triangles: see mesh.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Over the tetrahedra from a point of the surface to its triangles (a, b, c), with D = a . (b x c),
 *
 *   volume D / 6,   first moment D / 24 (a + b + c),
 *   second moments D / 120 ((a + b + c)(a + b + c)^T + a a^T + b b^T + c c^T) */
#include "files/mesh.h"

#include "files/numbers.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

typedef struct sums {
    const double *scale;
    double from[3]; /* the first corner */
    bool some;
    double volume, first[3], second[6];
} sums;

static void add_triangle(void *user, const double corner[9])
{
    sums *s = user;
    static const int row[6] = {0, 1, 2, 0, 0, 1}, column[6] = {0, 1, 2, 1, 2, 2};
    double x[3][3], sum[3];
    if (!s->some) {
        for (int k = 0; k < 3; ++k) s->from[k] = corner[k] * s->scale[k];
        s->some = true;
    }
    for (int k = 0; k < 3; ++k) {
        for (int l = 0; l < 3; ++l) x[l][k] = corner[3 * l + k] * s->scale[k] - s->from[k];
        sum[k] = x[0][k] + x[1][k] + x[2][k];
    }
    const double D = x[0][0] * (x[1][1] * x[2][2] - x[1][2] * x[2][1]) +
                     x[0][1] * (x[1][2] * x[2][0] - x[1][0] * x[2][2]) +
                     x[0][2] * (x[1][0] * x[2][1] - x[1][1] * x[2][0]);
    s->volume += D / 6.0;
    for (int k = 0; k < 3; ++k) s->first[k] += D / 24.0 * sum[k];
    for (int k = 0; k < 6; ++k) {
        const int i = row[k], j = column[k];
        s->second[k] +=
            D / 120.0 *
            (sum[i] * sum[j] + x[0][i] * x[0][j] + x[1][i] * x[1][j] + x[2][i] * x[2][j]);
    }
}

/* Who gets the triangles of a file. */
typedef struct taker {
    mbsr_triangle_fn take;
    void *user;
} taker;

/* ---- STL ---- */

static double float_at(const unsigned char *b)
{
    const uint32_t bits =
        (uint32_t)b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
    float value;
    memcpy(&value, &bits, sizeof value);
    return (double)value;
}

/* 80 bytes, the number of triangles, and 50 bytes each. */
static bool is_binary(const char *text, size_t size)
{
    const unsigned char *b = (const unsigned char *)text;
    if (size < 84) return false;
    const uint32_t count =
        (uint32_t)b[80] | (uint32_t)b[81] << 8 | (uint32_t)b[82] << 16 | (uint32_t)b[83] << 24;
    return (size - 84) / 50 == count && (size - 84) % 50 == 0;
}

static void read_binary(const char *text, size_t size, const taker *to)
{
    const unsigned char *b = (const unsigned char *)text + 84;
    for (size_t left = (size - 84) / 50; left > 0; --left, b += 50) {
        double corner[9];
        for (int k = 0; k < 9; ++k) corner[k] = float_at(b + 12 + 4 * k);
        to->take(to->user, corner);
    }
}

/* ---- lines of text ---- */

/* The next line without its end, in a buffer of its own; false: none is left. Longer ones are cut. */
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

static const char *read_lines(const char *text, const char *end, const taker *to)
{
    char line[512];
    double corner[9];
    int count = 0;
    while (next_line(&text, end, line)) {
        const char *numbers = after(line, "vertex");
        if (!numbers) continue;
        if (mbsri_read_numbers(numbers, 3, 3, corner + 3 * count) != 3)
            return "a vertex is not 3 numbers";
        if (++count < 3) continue;
        to->take(to->user, corner);
        count = 0;
    }
    return NULL;
}

/* ---- OBJ ---- */

typedef struct point {
    double x[3];
} point;

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

static const char *add_face(const mbsri_list *points, const char *text, const taker *to)
{
    double corner[9];
    for (int k = 0;; ++k) {
        text += strspn(text, " \t\r");
        if (!*text) return k < 3 ? "a face has less than 3 corners" : NULL;
        const double *x = corner_of(points, &text);
        if (!x) return "a face has a corner that is none";
        if (k > 2) memcpy(corner + 3, corner + 6, 3 * sizeof *corner);
        memcpy(corner + 3 * (k < 2 ? k : 2), x, 3 * sizeof *corner);
        if (k >= 2) to->take(to->user, corner);
    }
}

static const char *read_obj(mbsri_arena *arena, const char *text, const char *end, const taker *to)
{
    mbsri_list points = {.count = 0};
    char line[512];
    while (next_line(&text, end, line)) {
        const char *numbers = after(line, "v"), *face = after(line, "f"), *wrong = NULL;
        double x[6];
        if (numbers) {
            if (mbsri_read_numbers(numbers, 3, 6, x) < 3) return "a vertex is not 3 numbers";
            point *p = mbsri_list_add(arena, &points, sizeof *p);
            if (!p) return "there is no memory for it";
            memcpy(p->x, x, sizeof p->x);
        }
        if (face) wrong = add_face(&points, face, to);
        if (wrong) return wrong;
    }
    return NULL;
}

const char *mbsri_mesh_read(mbsri_arena *arena, const char *text, size_t size,
                            mbsr_triangle_fn take, void *user)
{
    const taker to = {take, user};
    if (is_binary(text, size)) {
        read_binary(text, size, &to);
        return NULL;
    }
    if (size > 5 && memcmp(text, "solid", 5) == 0) return read_lines(text, text + size, &to);
    return read_obj(arena, text, text + size, &to);
}

const char *mbsri_mesh_solid(mbsri_arena *arena, const char *text, size_t size,
                             const double scale[3], double *volume, double centre[3],
                             double tensor[6])
{
    sums s = {.scale = scale};
    const char *wrong = mbsri_mesh_read(arena, text, size, add_triangle, &s);
    if (wrong) return wrong;
    if (!s.some) return "it has no triangles";
    if (!isfinite(s.volume) || s.volume == 0.0) return "it encloses no volume";
    const double side = s.volume < 0.0 ? -1.0 : 1.0; /* normals inwards */
    double mean[3], second[6];
    *volume = side * s.volume;
    for (int k = 0; k < 3; ++k) {
        mean[k] = side * s.first[k] / *volume;
        centre[k] = s.from[k] + mean[k];
    }
    for (int k = 0; k < 6; ++k) {
        static const int row[6] = {0, 1, 2, 0, 0, 1}, column[6] = {0, 1, 2, 1, 2, 2};
        second[k] = side * s.second[k] - *volume * mean[row[k]] * mean[column[k]];
    }
    const double trace = second[0] + second[1] + second[2];
    for (int k = 0; k < 6; ++k) tensor[k] = k < 3 ? trace - second[k] : -second[k];
    for (int k = 0; k < 6; ++k) {
        if (!isfinite(tensor[k])) return "its moments are not finite";
    }
    return NULL;
}
