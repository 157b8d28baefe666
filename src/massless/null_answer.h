/* How a direction that moves no mass answers to rounding behind the joints where it begins.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_NULL_ANSWER_H
#define MBSRI_NULL_ANSWER_H

#include "massless/null_lift.h"

/* Adds to the errors of a direction that begins at body j what rates and twists become where
 * rounding moves bodies behind joints; what is no more than errors is zero. After mbsri_null_lift;
 * the data's loads are lost. */
void mbsri_null_answer(const mbsr_model *m, mbsr_data *d, int j, const mbsri_lifted *out);

#endif
