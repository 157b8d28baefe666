/* Height fields of files: see heights.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/heights.h"

#include "files/mjcf_parts.h"
#include "files/numbers.h"
#include "files/png.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

enum { MOST_SAMPLES = 8192, MOST_IN_ALL = 1 << 22, MOST_DRAWN = 256 };

/* ---- drawing ---- */

static void take_corner(const mbsr_file_shape *s, int row, int column, double x[3])
{
    x[0] = s->size[0] * (2.0 * column / (s->columns - 1) - 1.0);
    x[1] = s->size[1] * (2.0 * row / (s->rows - 1) - 1.0);
    x[2] = s->height[(ptrdiff_t)row * s->columns + column];
}

/* So many cells along one direction are drawn as one. */
static int cells_in_one(int samples)
{
    return 1 + (samples - 2) / MOST_DRAWN;
}

bool mbsri_heights_drawn(mbsri_scene *s, mbsr_file_shape *shape)
{
    static const int corner[6][2] = {{0, 0}, {0, 1}, {1, 0}, {1, 1}, {1, 0}, {0, 1}};
    const int down = cells_in_one(shape->rows), across = cells_in_one(shape->columns),
              last[2] = {shape->rows - 1, shape->columns - 1};
    const int cells = ((last[0] + down - 1) / down) * ((last[1] + across - 1) / across);
    double *x = mbsri_arena_take(s->arena, 18 * (size_t)cells * sizeof *x);
    if (!x) return false;
    shape->triangles = 2 * cells;
    shape->triangle = x;
    for (int j = 0; j < last[0]; j += down) {
        for (int i = 0; i < last[1]; i += across) {
            for (int k = 0; k < 6; ++k, x += 3) {
                const int row = j + corner[k][0] * down, column = i + corner[k][1] * across;
                take_corner(shape, row < last[0] ? row : last[0],
                            column < last[1] ? column : last[1], x);
            }
        }
    }
    return true;
}

/* ---- files ---- */

static uint32_t word_at(const char *text)
{
    uint32_t value = 0;
    for (int k = 3; k >= 0; --k) value = value << 8 | (unsigned char)text[k];
    return value;
}

static const char *wrong_size(uint32_t rows, uint32_t columns)
{
    if (rows < 2 || columns < 2) return "it has less than two rows or columns";
    if (rows > MOST_SAMPLES || columns > MOST_SAMPLES)
        return "it has more than 8192 rows or columns";
    return (size_t)rows * columns > MOST_IN_ALL ? "it has more than 4194304 samples" : NULL;
}

static const char *read_binary(mbsri_arena *arena, const char *text, size_t size, int *rows,
                               int *columns, double **height)
{
    if (size < 8) return "it has no size";
    const uint32_t ny = word_at(text), nx = word_at(text + 4);
    const char *wrong = wrong_size(ny, nx);
    if (wrong && (ny > MOST_SAMPLES || nx > MOST_SAMPLES))
        return "it is neither a PNG nor a binary file of 2 to 8192 rows and columns";
    if (wrong) return wrong;
    const size_t count = (size_t)ny * nx;
    if (size != 8 + 4 * count) return "it has not as many numbers as it says";
    *rows = (int)ny, *columns = (int)nx;
    *height = mbsri_arena_take(arena, count * sizeof **height);
    if (!*height) return "there is no memory for it";
    for (size_t k = 0; k < count; ++k) {
        const uint32_t word = word_at(text + 8 + 4 * k);
        float value;
        memcpy(&value, &word, sizeof value);
        if (!isfinite(value)) return "a height in it is not finite";
        (*height)[k] = (double)value;
    }
    return NULL;
}

const char *mbsri_heights_load(mbsri_scene *s, const char *home, const char *path, int *rows,
                               int *columns, double **height)
{
    const mbsr_file_opt *opt = s->opt;
    const char *full = mbsri_arena_join(s->arena, path[0] == '/' ? "" : home, path, ""), *text;
    size_t size;
    if (!full) return "there is no memory for it";
    if (!opt->load || (opt->load(opt->user, full, &text, &size) &&
                       (strcmp(full, path) == 0 || opt->load(opt->user, path, &text, &size))))
        return "there is no such file";
    return mbsri_png_begins(text, size)
               ? mbsri_png_read(s->arena, text, size, wrong_size, rows, columns, height)
               : read_binary(s->arena, text, size, rows, columns, height);
}

void mbsri_heights_scale(double *height, int count, double low, double size)
{
    double high = low;
    for (int k = 0; k < count; ++k) high = fmax(high, height[k]);
    for (int k = 0; k < count; ++k)
        height[k] = high > low ? size * ((height[k] - low) / (high - low)) : 0.0;
}

/* ---- MJCF ---- */

/* An <hfield> by name, or by that of its file. */
static const mbsri_element *find_field(const mbsri_mjcf *m, const char *name)
{
    for (const mbsri_element *list = m->root ? mbsri_child(m->root, "asset") : NULL; list && name;
         list = mbsri_next(list)) {
        for (const mbsri_element *e = mbsri_child(list, "hfield"); e; e = mbsri_next(e)) {
            const char *own = mbsri_attribute(e, "name"), *file = mbsri_attribute(e, "file");
            if (!own && file) own = mbsri_mjcf_stem(m->s->arena, file);
            if (own && strcmp(own, name) == 0) return e;
        }
    }
    return NULL;
}

/* Numbers that stand in the file: the first row has the largest y. */
static bool take_elevation(mbsri_mjcf *m, const mbsri_element *e, const char *text, int rows,
                           int columns, double **height)
{
    const int count = rows * columns;
    double *given = mbsri_arena_take(m->s->arena, (size_t)count * sizeof *given);
    *height = mbsri_arena_take(m->s->arena, (size_t)count * sizeof **height);
    if (!given || !*height) return false;
    if (mbsri_read_numbers(text, count, count, given) != count)
        return mbsri_file_refuse(m->s, e, "elevation must be nrow times ncol numbers, %d", count);
    for (int j = 0; j < rows; ++j)
        memcpy(*height + (ptrdiff_t)j * columns, given + (ptrdiff_t)(rows - 1 - j) * columns,
               (size_t)columns * sizeof *given);
    return true;
}

/* *wrong: why its samples are not known. */
static bool read_samples(mbsri_mjcf *m, const mbsri_element *e, int *rows, int *columns,
                         double **height, const char **wrong)
{
    const char *elevation = mbsri_attribute(e, "elevation"), *file = mbsri_mjcf_asset_path(m, e);
    double size[2] = {0.0, 0.0};
    if (file) {
        *wrong = mbsri_heights_load(m->s, m->home, file, rows, columns, height);
        return true;
    }
    if (!mbsri_numbers(m->s, e, "nrow", mbsri_attribute(e, "nrow"), 1, 1, size, NULL) ||
        !mbsri_numbers(m->s, e, "ncol", mbsri_attribute(e, "ncol"), 1, 1, size + 1, NULL))
        return false;
    for (int k = 0; k < 2; ++k) {
        if (!(size[k] >= 2.0 && size[k] <= MOST_SAMPLES) || size[k] != floor(size[k]))
            return mbsri_file_refuse(m->s, e, "%s is %g, must be a number between 2 and %d",
                                     k ? "ncol" : "nrow", size[k], MOST_SAMPLES);
    }
    *rows = (int)size[0], *columns = (int)size[1];
    if (size[0] * size[1] > MOST_IN_ALL)
        return mbsri_file_refuse(m->s, e, "it has %g samples, more than 4194304",
                                 size[0] * size[1]);
    if (elevation) return take_elevation(m, e, elevation, *rows, *columns, height);
    *height = mbsri_arena_take(m->s->arena, (size_t)*rows * (size_t)*columns * sizeof **height);
    return *height != NULL;
}

bool mbsri_mjcf_field_shape(mbsri_mjcf *m, const mbsri_mjcf_part *node, mbsr_file_shape *shape,
                            bool *known)
{
    const char *name = mbsri_mjcf_get(node, "hfield"), *wrong = NULL;
    const mbsri_element *e = find_field(m, name);
    double size[4] = {0.0, 0.0, 0.0, 0.0}, *height = NULL;
    *known = false;
    if (!e) return mbsri_file_refuse(m->s, node->e, "there is no hfield '%.40s'", name ? name : "");
    if (!mbsri_numbers(m->s, e, "size", mbsri_attribute(e, "size"), 4, 4, size, NULL)) return false;
    for (int k = 0; k < 3; ++k) {
        if (!(size[k] > 0.0))
            return mbsri_file_refuse(m->s, e, "its size must be four positive numbers");
    }
    if (!read_samples(m, e, &shape->rows, &shape->columns, &height, &wrong)) return false;
    if (wrong) {
        mbsri_file_find(m->s, node->e, "it is left out with hfield '%.40s': %s", name, wrong);
        return true;
    }
    *known = true;
    double low = INFINITY;
    for (int k = 0; k < shape->rows * shape->columns; ++k) low = fmin(low, height[k]);
    mbsri_heights_scale(height, shape->rows * shape->columns, low, size[2]);
    shape->size[0] = size[0], shape->size[1] = size[1], shape->size[2] = 0.0;
    shape->height = height;
    return mbsri_heights_drawn(m->s, shape);
}
