/* The functions of a closure's table, with its rows combined where it has a compliance matrix.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The position rows are then T times those of the table. Outputs arrive as zero, as the table's
 * functions expect them. */
#ifndef MBSRI_CLOSURE_ROWS_H
#define MBSRI_CLOSURE_ROWS_H

#include "model/record.h"

int mbsri_closure_position(const mbsri_closure *c, const mbsr_closure_args *args, double *g);

/* These only where the table has them. */
int mbsri_closure_jacobian(const mbsri_closure *c, const mbsr_closure_args *args,
                           const mbsr_closure_jacobian *out);
int mbsri_closure_table_tangent(const mbsri_closure *c, const mbsr_closure_args *args,
                                const double *lambda, const mbsr_closure_tangent *out);
int mbsri_closure_table_drift(const mbsri_closure *c, const mbsr_closure_args *args, double *gt);
int mbsri_closure_table_bias(const mbsri_closure *c, const mbsr_closure_args *args, double *bias);

#endif
