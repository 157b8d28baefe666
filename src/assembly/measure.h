/* Sizes typical of a tree, for the steps of differences.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_MEASURE_H
#define MBSRI_MEASURE_H

#include "model/record.h"

/* Sets length, frequency, mass and span of a model that is finished but for that. False: no
 * memory. */
bool mbsri_measure(mbsr_model *m);

#endif
