/* Height fields of files.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FILES_HEIGHTS_H
#define MBSRI_FILES_HEIGHTS_H

#include "files/scene.h"

/* Triangles of its cells, at most 2 x 256 x 256, for what draws a height field whose size and
 * samples stand. False: no memory. */
bool mbsri_heights_drawn(mbsri_scene *s, mbsr_file_shape *shape);

/* Samples of a binary file as MuJoCo has it: two 32-bit numbers, rows and columns, and float
 * numbers. NULL, or why it cannot be read. */
const char *mbsri_heights_read(mbsri_arena *arena, const char *text, size_t size, int *rows,
                               int *columns, double **height);

#endif
