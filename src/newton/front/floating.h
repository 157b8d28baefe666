/* The step of a body that floats: see floating.c.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FRONT_FLOATING_H
#define MBSRI_FRONT_FLOATING_H

#include "newton/front/front.h"

/* Bytes for a front with elements by pairs, in memory (NULL: none). */
size_t mbsri_floating_place(mbsri_front *f, unsigned char *memory);

/* Whether the body of step k floats by its model: behind a root at rest, by a ball about its origin
 * and three translations, and nothing acts on it but gravity, elements between it and the root, and
 * pairs that read no joints. */
bool mbsri_front_may_float(const mbsri_front *f, int k);

/* Marks the steps whose bodies float at the present ranks, as all do that are eliminated with them;
 * what their joints make of motions. */
void mbsri_floating_begin(mbsri_front *f, const mbsr_data *d);

/* Passes the body of step k; *done: its pivots are good. A status of what elements return. */
int mbsri_floating_pass(mbsri_front *f, mbsr_data *d, int k, bool *done);

/* A solution: before all others, what right-hand sides r alone move; the two sweeps; the unknowns
 * of body i, of which the sweeps have left the rates. */
void mbsri_floating_displace(mbsri_front *f, const double *r);
void mbsri_floating_reduce(mbsri_front *f, int k, const double *r);
void mbsri_floating_substitute(mbsri_front *f, int k, const double *r);

/* Motion of the body of step k, which is alone, by forces 1 on it: 12 x 6. */
void mbsri_floating_response(const mbsri_front *f, int k, double *motion);

#endif
