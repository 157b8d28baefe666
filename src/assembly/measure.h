/* Sizes typical of a tree, for the steps of differences.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_MEASURE_H
#define MBSRI_MEASURE_H

#include "model/record.h"

/* Sets length, frequency, mass and span of a model that is finished but for that. False: no
 * memory. */
bool mbsri_measure(mbsr_model *m);

/* The largest coordinate of the points that a stock element acts at, by the names of its
 * parameters. */
double mbsri_force_length(const mbsr_force_def *def);

#endif
