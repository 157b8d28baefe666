/* In what measure loops are closed: which joint coordinates give way, and how gaps compare.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_CLOSING_H
#define MBSRI_CLOSING_H

#include "recursion/closures.h"
#include "recursion/data.h"

#include <mbsrank/closure.h>

/* Of joint rate k and of a gap. */
typedef struct mbsri_closing {
    double lever; /* m: the longest of the mechanism */
    double *give; /* nu, the caller's order: span / sqrt(weight), 0 where the coordinate stays */
    double *gap;  /* position rows: what gaps are compared to */
} mbsri_closing;

/* Fills c, whose arrays are there, at the positions of the data; finds the derivatives of the
 * closures. */
int mbsri_closing_measure(const mbsr_model *m, mbsr_data *d, const mbsr_assembly_opt *opt,
                          mbsri_closing *c);

/* The share, 1 at most, of the step x (nu) that turns by 1 rad and moves by the lever, times `far`
 * if that is more than 1, at most. */
double mbsri_closing_share(const mbsr_model *m, const mbsri_closing *c, const double *x,
                           double far);

/* What rounding in gaps is relative to: the largest place of a body at the positions of the data
 * over the lever, 1 at least. */
double mbsri_closing_size(const mbsr_model *m, const mbsr_data *d, const mbsri_closing *c);

/* The Euclidean norm of gaps g (position rows) in this measure. */
double mbsri_closing_norm(const mbsr_model *m, const mbsri_closing *c, const double *g);

/* The squared lengths of rows (rows) over all joint rates, each times what it gives (nu, the
 * caller's order), from the ends to the body where these meet; after the derivatives. In O(bodies +
 * rows) where ends meet at the ground or at bodies that no loop moves; overwrites Mbar and
 * closure_V, which is zero afterwards. */
void mbsri_row_squares(const mbsr_model *m, mbsr_data *d, const double *give, double *square);

/* Refuses weights that are not positive, and quaternions kept in part; either may be NULL. */
int mbsri_closing_check(const mbsr_model *m, mbsr_data *d, const double *weight, const int *keep,
                        const char *function);

#endif
