/* Power of a force element along the directions that move no mass: of forces in the order of its
 * derivatives' rows, those in w->element.slope.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_ELEMENT_POWER_H
#define MBSRI_ELEMENT_POWER_H

#include "massless/null_lift.h"
#include "massless/null_space.h"

#include <float.h>

/* Of directions and products with them, relative. */
#define MBSRI_ELEMENT_ROUNDING (16.0 * DBL_EPSILON)

/* Bodies of the element whose derivatives were taken last: number k of the call. */
int mbsri_element_body(const mbsri_null_space *w, int k);

/* Power of forces y (rows) along a direction, and the sum of the sizes of its terms; gross (rows):
 * the sizes of what y was added up from. */
double mbsri_element_power(const mbsri_null_space *w, int bodies, const double *a,
                           const double *twist, const double *y, const double *gross, double *size);

/* What rounding of the axes and lever arms of an element makes power of y uncertain by, over
 * machine precision: |omega| (|moment| + length |force|) + |v| |force|. Where a line of action
 * meets the axis of a rotation, nothing else is left of its moment. */
double mbsri_element_doubt(const mbsri_null_space *w, int bodies, const double *twist,
                           const double *y);

/* What direction l may be wrong by makes of power of y: |dV| |f| + |da| |tau|. */
double mbsri_element_error(const mbsri_null_space *w, int bodies, int l, const double *y);

#endif
