/* The model with and without the candidates' masses, and loads on both.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_SMALL_TWINS_H
#define MBSRI_SMALL_TWINS_H

#include "small/record.h"

/* Makes both twins, with the masses of candidates that keep them, and the clean reduced model. */
int mbsri_small_twins(mbsr_small_masses *s);
void mbsri_small_twins_release(mbsr_small_masses *s);

/* Keeps the error of a model, data or solver as the object's; returns the status. */
int mbsri_small_failed(mbsr_small_masses *s, int status, const mbsr_error *error);

#endif
