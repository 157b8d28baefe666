/* Heights of PNG pictures: see png.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/png.h"

#include <string.h>

bool mbsri_png_begins(const char *text, size_t size)
{
    static const char first[8] = "\211PNG\r\n\032\n";
    return size >= sizeof first && memcmp(text, first, sizeof first) == 0;
}

#if !defined(MBSR_WITH_PNG)

const char *mbsri_png_read(mbsri_arena *arena, const char *text, size_t size,
                           mbsri_png_sizes wrong_size, int *rows, int *columns, double **height)
{
    (void)arena, (void)text, (void)size, (void)wrong_size, (void)rows, (void)columns, (void)height;
    return "pictures are not read: the library was built without libpng";
}

#else

#include <png.h>
#include <setjmp.h>

typedef struct picture {
    mbsri_arena memory; /* while it is read */
    mbsri_arena *arena; /* of what stays */
    const char *text;
    size_t size, used;
    png_structp png;
    png_infop info;
    int rows, columns, depth, channels;
    png_bytep *row;
    mbsri_png_sizes wrong_size;
    const char *wrong;
} picture;

/* ---- what libpng calls ---- */

static void *png_memory(png_structp png, png_alloc_size_t size)
{
    return mbsri_arena_take(png_get_mem_ptr(png), size);
}

static void png_release(png_structp png, void *memory)
{
    (void)png, (void)memory; /* all of an arena at once */
}

static PNG_NORETURN void png_stop(png_structp png, const char *text)
{
    picture *p = png_get_error_ptr(png);
    const char *why = mbsri_arena_join(p->arena, "it is no whole PNG: ", text, "");
    p->wrong = why ? why : "there is no memory for it";
    png_longjmp(png, 1);
}

static void png_quiet(png_structp png, const char *text)
{
    (void)png, (void)text;
}

static void png_bytes(png_structp png, png_bytep to, size_t count)
{
    picture *p = png_get_io_ptr(png);
    if (count > p->size - p->used) png_error(png, "it ends too early");
    memcpy(to, p->text + p->used, count);
    p->used += count;
}

/* ---- a picture ---- */

/* Whether so many rows and columns are taken. */
static bool take_size(picture *p)
{
    const png_uint_32 rows = png_get_image_height(p->png, p->info),
                      columns = png_get_image_width(p->png, p->info);
    p->wrong = p->wrong_size(rows, columns);
    if (p->wrong) return false;
    p->rows = (int)rows, p->columns = (int)columns;
    return true;
}

/* One sample a pixel and more behind it, of 8 or 16 bits. */
static void choose_form(picture *p)
{
    const int kind = png_get_color_type(p->png, p->info);
    if (kind == PNG_COLOR_TYPE_PALETTE) png_set_palette_to_rgb(p->png);
    if (kind == PNG_COLOR_TYPE_GRAY && png_get_bit_depth(p->png, p->info) < 8)
        png_set_expand_gray_1_2_4_to_8(p->png);
    png_set_interlace_handling(p->png);
    png_read_update_info(p->png, p->info);
    p->depth = png_get_bit_depth(p->png, p->info);
    p->channels = png_get_channels(p->png, p->info);
}

static bool take_rows(picture *p)
{
    const size_t bytes = png_get_rowbytes(p->png, p->info);
    png_bytep all = mbsri_arena_take(&p->memory, bytes * (size_t)p->rows);
    p->row = mbsri_arena_take(&p->memory, (size_t)p->rows * sizeof *p->row);
    p->wrong = all && p->row ? NULL : "there is no memory for it";
    for (int k = 0; k < p->rows && !p->wrong; ++k) p->row[k] = all + (size_t)k * bytes;
    return !p->wrong;
}

static bool read_picture(picture *p)
{
    if (setjmp(png_jmpbuf(p->png))) return false;
    p->info = png_create_info_struct(p->png);
    if (!p->info) png_error(p->png, "there is no memory for it");
    png_set_read_fn(p->png, p, png_bytes);
    png_read_info(p->png, p->info);
    if (!take_size(p)) return false;
    choose_form(p);
    if (!take_rows(p)) return false;
    png_read_image(p->png, p->row);
    png_read_end(p->png, NULL);
    return true;
}

static double sample_of(const picture *p, int row, int column)
{
    const png_byte *at = p->row[row] + (size_t)(column * p->channels) * (p->depth == 16 ? 2 : 1);
    return p->depth == 16 ? (256 * at[0] + at[1]) / 65535.0 : at[0] / 255.0;
}

static const char *keep_samples(const picture *p, double *height)
{
    for (int j = 0; j < p->rows && height; ++j) {
        for (int k = 0; k < p->columns; ++k)
            height[(ptrdiff_t)(p->rows - 1 - j) * p->columns + k] = sample_of(p, j, k);
    }
    return height ? NULL : "there is no memory for it";
}

const char *mbsri_png_read(mbsri_arena *arena, const char *text, size_t size,
                           mbsri_png_sizes wrong_size, int *rows, int *columns, double **height)
{
    picture p = {.arena = arena,
                 .text = text,
                 .size = size,
                 .wrong_size = wrong_size,
                 .wrong = "there is no memory for it"};
    mbsri_arena_open(&p.memory, &arena->allocator);
    p.png = png_create_read_struct_2(PNG_LIBPNG_VER_STRING, &p, png_stop, png_quiet, &p.memory,
                                     png_memory, png_release);
    if (p.png && read_picture(&p)) {
        *rows = p.rows, *columns = p.columns;
        *height = mbsri_arena_take(arena, (size_t)p.rows * (size_t)p.columns * sizeof **height);
        p.wrong = keep_samples(&p, *height);
    }
    png_destroy_read_struct(&p.png, &p.info, NULL);
    arena->failed = arena->failed || p.memory.failed;
    mbsri_arena_close(&p.memory);
    return p.wrong;
}

#endif
