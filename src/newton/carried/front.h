/* Fronts in which loops close, of bodies in vector code, with what is carried past them
 * (carried.h).
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_CLOSING_FRONT_H
#define MBSRI_CLOSING_FRONT_H

#include "newton/carried/carried.h"

/* Of the unknowns that go, `LU` of a front keeps the columns of L (all rows: those of the front,
 * then what it adds to y of the body above), and then the rows of U (its columns, then x of that
 * body), by the order of the exchanges. */

/* The loops of one front that close on a body, when all behind it is done. P: the matrix of the
 * body, mbsri_carried_motions columns of mbsri_carried_actions. */
int mbsri_front_close_one(mbsr_newton *w, mbsr_data *d, int k, double *P);

#endif
