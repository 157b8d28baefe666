/* Matrices in files of MATLAB: see mat.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A head of 128 bytes, then elements: a tag (type, bytes) and what it says, filled up to 8 bytes. A
 * matrix is an element of four: class, sizes, name, numbers. */
#include "program/mat.h"

#include <stdint.h>
#include <string.h>

enum { INT8 = 1, INT32 = 5, UINT32 = 6, DOUBLE = 9, MATRIX = 14 };
enum { CLASS_DOUBLE = 6 };

static uint32_t filled(uint32_t bytes)
{
    return (bytes + 7) / 8 * 8;
}

static void put_element(FILE *to, uint32_t type, uint32_t bytes, const void *data)
{
    static const char none[8] = {0};
    const uint32_t tag[2] = {type, bytes};
    fwrite(tag, sizeof tag, 1, to);
    if (bytes > 0) fwrite(data, bytes, 1, to);
    if (filled(bytes) > bytes) fwrite(none, filled(bytes) - bytes, 1, to);
}

void mat_begin(FILE *to)
{
    char text[124];
    const uint16_t version[2] = {0x0100, 0x4D49}; /* "MI" in the order of bytes of this processor */
    memset(text, ' ', sizeof text);
    memcpy(text, "MATLAB 5.0 MAT-file, mbsrank", 28);
    memset(text + 116, 0, 8);
    fwrite(text, sizeof text, 1, to);
    fwrite(version, sizeof version, 1, to);
}

void mat_put(FILE *to, const char *name, int rows, int columns, const double *x)
{
    const uint32_t flags[2] = {CLASS_DOUBLE, 0}, length = (uint32_t)strlen(name),
                   bytes = 8 * (uint32_t)rows * (uint32_t)columns,
                   tag[2] = {MATRIX, 16 + 16 + 8 + filled(length) + 8 + bytes};
    const int32_t sizes[2] = {rows, columns};
    fwrite(tag, sizeof tag, 1, to);
    put_element(to, UINT32, sizeof flags, flags);
    put_element(to, INT32, sizeof sizes, sizes);
    put_element(to, INT8, length, name);
    put_element(to, DOUBLE, bytes, x);
}
