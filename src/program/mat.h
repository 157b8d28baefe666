/* Matrices in files of MATLAB, level 5, as Octave and SciPy read them.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRANK_MAT_H
#define MBSRANK_MAT_H

#include <stdio.h>

/* The beginning of such a file; then a matrix (column-major) by name. What is wrong stays with the
 * stream. */
void mat_begin(FILE *to);
void mat_put(FILE *to, const char *name, int rows, int columns, const double *x);

#endif
