/* The front of one step while it is made.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FRONT_ASSEMBLE_H
#define MBSRI_FRONT_ASSEMBLE_H

#include "newton/front/front.h"

/* The front of step k in f->now.M before its body is passed (pass.h): `size` unknowns and
 * equations, then the border (`rows`, `columns` in all), then what the step takes away: y and loads
 * of the joint, x, and what is pending of a group that closes. */
typedef struct mbsri_front_build {
    mbsri_front *f;
    mbsr_data *d;
    const mbsri_front_step *step;
    int k, i;
    const mbsri_body *b;
    mbsri_front_names at; /* of the body */
    mbsri_terms terms;
    bool below_massless, closes; /* closes: the joint, or its group, is complete, and lacks rank or
                                    is below a massless one */
    bool lacks_mass;             /* it closes, and elements alone determine some of its rates */
    bool watched; /* more than the joint's own unknowns, or lacks mass: what dampers leave
                     of themselves by rounding would determine directions of predecessors */
    bool plain;   /* nothing but y over x, with the joint's own unknowns */
    int own, size, rows, columns, all_rows, all_columns; /* own: unknowns of the joint */
    int *row, *column;                                   /* numbers */
    double *M, *N;
} mbsri_front_build;

/* watched: with the sizes of what is added up beyond the unknowns, where not anyway: some of these
 * will be left. A status of what elements return. */
int mbsri_front_assemble(mbsri_front *f, mbsr_data *d, int k, bool watched, mbsri_front_build *b);

#endif
