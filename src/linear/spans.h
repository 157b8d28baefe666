/* What is far for a model.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_LINEAR_SPANS_H
#define MBSRI_LINEAR_SPANS_H

#include <mbsrank/dynamics.h>
#include <mbsrank/joint.h>

#include <stdbool.h>

/* Coordinates of most bodies are fewer, rates of all are. */
enum { MBSRI_LINEAR_SPANS = 2 * MBSR_MAX_D };

/* The longest way between origins of bodies and the ground's, at the positions of the data. */
double mbsri_linear_length(const mbsr_model *model, mbsr_data *data);

/* What is far along each coordinate of a body, or each rate: 1 rad; that length; of a mode the
 * amplitude at which the body moves by that length. 1 where nothing is known. */
void mbsri_linear_spans(const mbsr_model *model, int body, bool rates, double length, double *span);

#endif
