/* What of C is nothing but rounding.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Where such an entry is the largest of its row, scaling makes it as large as all others, and a
 * direction counts as held that is not. */
#ifndef MBSRI_ROUNDING_H
#define MBSRI_ROUNDING_H

#include "recursion/data.h"

/* The longest lever in the mechanism: between origins of neighbours, and of rows about origins;
 * after the derivatives of the closures. */
double mbsri_longest_lever(const mbsr_model *m, const mbsr_data *d);

/* What row k of closure c has of the turning and of the moving of its body l, as lengths. */
void mbsri_row_parts(const mbsr_model *m, const mbsr_data *d, const mbsri_closure *c, int l, int k,
                     double *turn, double *move);

/* What row k of a closure measures, by its C: turns of bodies, places, or joint coordinates. */
mbsr_coordinate_kind mbsri_row_kind(const mbsr_model *m, const mbsr_data *d, const mbsri_closure *c,
                                    int k);

/* *share (algebra/pivots.h) of a row that has C on joint rate j of body b. */
void mbsri_share_of_joint(const mbsr_model *m, const mbsri_body *b, int j, double C, double *share);

/* Below this share of what is added up in it an entry of row k of closure c is rounding. */
double mbsri_row_rounding(const mbsri_closure *c);

#endif
