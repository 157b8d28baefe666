/* Derivatives of closures for Newton systems.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_CLOSURE_SLOPES_H
#define MBSRI_CLOSURE_SLOPES_H

#include "recursion/data.h"

/* Of a closure with loop forces lambda: S (columns x columns) of C^T lambda and slope (rows x
 * columns) of C (V, u) + g_t along displacements; of mbsri_closure_across: what of S ties different
 * bodies together is left (columns x rank) read (rank x columns, `most` rows). */
typedef struct mbsri_closure_tangents {
    double *S, *slope, *left, *read;
    int most, rank;
} mbsri_closure_tangents;

/* Doubles of scratch. */
size_t mbsri_closure_tangents_work(const mbsri_closure *c);

/* At the velocities, with the data's loop forces. A status of the closure's functions, or
 * MBSR_NOT_FINITE. */
int mbsri_closure_tangents_of(const mbsr_model *m, mbsr_data *d, const mbsri_closure *c,
                              double *work, mbsri_closure_tangents *out);

/* When S is there; `work` as before. */
void mbsri_closure_across(const mbsr_model *m, const mbsri_closure *c, double *work,
                          mbsri_closure_tangents *out);

/* Whether all of them are always zero. */
bool mbsri_closure_is_constant(const mbsri_closure *c);

/* Whether they can be had: joint coordinates that it reads have rates u. */
bool mbsri_closure_tangents_serve(const mbsr_model *m, const mbsri_closure *c);

#endif
