/* Linear equations about a state: what the object holds.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_LINEAR_RECORD_H
#define MBSRI_LINEAR_RECORD_H

#include "files/arena.h"

#include <mbsrank/linear.h>

struct mbsr_linear {
    mbsri_arena arena;
    mbsr_linear_info info;
    int nu, inputs, outputs;
    double *part[MBSR_LINEAR_PARTS];
    int rows[MBSR_LINEAR_PARTS], columns[MBSR_LINEAR_PARTS];
    double *shapes;  /* nu x states: dq of z */
    mbsr_mode *mode; /* once they have been asked for */
    int modes;
    double *vectors; /* states x states: of the modes, real parts and imaginary parts of pairs in
                        two columns */
    int *column;     /* of each mode */
};

/* E, A and B in the coordinates dq, dp, du, forces; Newton's matrices by products. A status. */
int mbsri_pencil_assemble(mbsr_linear *l, const mbsr_model *model, mbsr_data *data, double t,
                          const double *y, const double *yp, const mbsr_linear_opt *opt,
                          mbsr_error *error);

/* Ar, Br, Cr, Dr from these; rank: of the mass matrix of the tree. A status. */
int mbsri_pencil_reduce(mbsr_linear *l, int rank, const mbsr_linear_opt *opt, mbsr_error *error);

#endif
