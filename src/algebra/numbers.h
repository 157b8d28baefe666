/* Finiteness and size of vectors.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_NUMBERS_H
#define MBSRI_NUMBERS_H

#include <stdbool.h>
#include <stddef.h>

bool mbsri_finite(size_t n, const double *x);

/* Largest absolute value of n numbers. */
double mbsri_largest(int n, const double *x);

#endif
