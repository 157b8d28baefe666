/* Heights of PNG pictures, by libpng where the library was built with it.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FILES_PNG_H
#define MBSRI_FILES_PNG_H

#include "files/arena.h"

#include <stdint.h>

/* Whether these bytes begin as those of a PNG do. */
bool mbsri_png_begins(const char *text, size_t size);

/* NULL, or why there cannot be so many rows and columns. */
typedef const char *(*mbsri_png_sizes)(uint32_t rows, uint32_t columns);

/* Its brightness from 0 to 1, or of colours what is red, as MuJoCo and Gazebo read it. All of 16
 * bits count. The first row of the picture is the last one here. NULL, or why it cannot be read. */
const char *mbsri_png_read(mbsri_arena *arena, const char *text, size_t size,
                           mbsri_png_sizes wrong_size, int *rows, int *columns, double **height);

#endif
