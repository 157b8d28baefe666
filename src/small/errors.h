/* First-order errors of zeros: the linearised equations of motion under the neglected forces.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_SMALL_ERRORS_H
#define MBSRI_SMALL_ERRORS_H

#include "small/record.h"

/* y' = c y + b[0] (one state before) + b[1] (two before), and how much of the impulse acts. */
typedef struct mbsri_small_formula {
    double c, b[2], impulse;
} mbsri_small_formula;

/* Factors the reduced model's Newton matrix at a state. */
int mbsri_small_factor(mbsr_small_masses *s, double t, const double *y, const double *yp, double c);

/* error[0] of each candidate at a state of the reduced model, by the formula, from its forces
 * there, with the factorisation for its c. */
int mbsri_small_solve(mbsr_small_masses *s, double t, const double *y, const double *yp,
                      const mbsri_small_formula *formula);

/* Takes the errors at this state into the largest ones. */
int mbsri_small_note(mbsr_small_masses *s, double t, const double *y);

/* The next state of a run: forces, errors, and the largest of them. */
int mbsri_small_follow(mbsr_small_masses *s, double t, const double *y, const double *yp);

#endif
