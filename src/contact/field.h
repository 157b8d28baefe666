/* Height fields.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The surface is a cubic spline near the samples, with continuous curvature: it has polynomials of
 * degree two exactly, of degree three away from the border. All below it is solid. It goes on for
 * one cell beyond the border, where forces fade. */
#ifndef MBSRI_CONTACT_FIELD_H
#define MBSRI_CONTACT_FIELD_H

#include "contact/point.h"

struct mbsri_field {
    int nx, ny;              /* samples along x and y */
    double half[2], cell[2]; /* of the rectangle, m; of a cell */
    double *control;         /* (ny + 4) x (nx + 4), x first */
    double *high;   /* (ny + 1) x (nx + 1): no height of a cell is above; those beyond, too */
    double *steep;  /* as many: no slope is steeper */
    double *sticks; /* ny x nx: weights of samples that stick out, over other shapes */
};

/* A status, with a text that begins behind the shape's name; else how much memory it takes. */
int mbsri_field_check(const mbsr_shape *from, char text[MBSR_TEXT_SIZE], size_t *bytes);

/* Makes the field of a shape in memory of zeros. */
void mbsri_field_make(const mbsr_shape *from, void *memory, mbsri_shape *shape);

/* Whether a shape's box may reach down to a field. */
bool mbsri_field_reached(const mbsri_placed *field, const mbsri_placed *s);

/* Points of a over a field b where the distance from a point pa of its core, or from an ellipsoid,
 * is least nearby; each goes to `found`, its depth unset. MBSR_ERR_MEMORY_SIZE: there are too many.
 */
typedef int (*mbsri_found_fn)(const void *user, mbsri_touch *t);
int mbsri_field_feet(const mbsri_placed *a, const mbsri_placed *b, const double *pa, double margin,
                     mbsri_found_fn found, const void *user);

/* Samples of a field that stick out, near the box around s: their places in the world. */
typedef int (*mbsri_sample_fn)(const void *user, const double x[3], double weight);
int mbsri_field_samples(const mbsri_placed *field, const mbsri_placed *s, mbsri_sample_fn sample,
                        const void *user);

#endif
