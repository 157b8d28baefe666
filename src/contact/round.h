/* Ellipsoids against convex cores.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_CONTACT_ROUND_H
#define MBSRI_CONTACT_ROUND_H

#include "contact/point.h"

/* The point of an ellipsoid a and a shape b that is no plane; false: they are farther apart than
 * the margin. */
bool mbsri_ellipsoid_over(const mbsri_placed *a, const mbsri_placed *b, double margin,
                          mbsri_touch *t);

/* Where an ellipsoid reaches farthest along n, from its middle; K (may be NULL), 3 x 3: how that
 * moves with n. */
void mbsri_support_ellipsoid(const double half[3], const double R[9], const double n[3],
                             double at[3], double K[9]);

/* x normal to n with (K + s) x = right, across n. */
void mbsri_solve_across(const double K[9], double s, const double n[3], const double right[3],
                        double x[3]);

#endif
