/* Height fields of files.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FILES_HEIGHTS_H
#define MBSRI_FILES_HEIGHTS_H

#include "files/scene.h"

/* Triangles of its cells, at most 2 x 256 x 256, for what draws a height field whose size and
 * samples stand. False: no memory. */
bool mbsri_heights_drawn(mbsri_scene *s, mbsr_file_shape *shape);

/* Samples of a file in the folder `home`, or as its path stands: a PNG, from 0 to 1, or a binary
 * file as MuJoCo has it, two 32-bit numbers, rows and columns, and float numbers. The first row has
 * the smallest y. NULL, or why it cannot be read. */
const char *mbsri_heights_load(mbsri_scene *s, const char *home, const char *path, int *rows,
                               int *columns, double **height);

/* Makes them heights: the largest becomes `size` and `low` zero, all of them where none is larger
 * than that. */
void mbsri_heights_scale(double *height, int count, double low, double size);

#endif
