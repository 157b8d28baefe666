/* Starts on the smooth motion, to second order in the masses.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_SMALL_CORRECT_H
#define MBSRI_SMALL_CORRECT_H

#include "small/record.h"

/* q, u with one correction by the neglected forces and their rates. */
int mbsri_small_correct(mbsr_small_masses *s, double *q, double *u);

#endif
