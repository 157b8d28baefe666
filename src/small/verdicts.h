/* Verdicts and the steps that zeros save.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_SMALL_VERDICTS_H
#define MBSRI_SMALL_VERDICTS_H

#include "small/record.h"

/* s->mass, from the candidates and directions; returns the steps saved together. */
double mbsri_small_judge(mbsr_small_masses *s);

#endif
