/* Derivatives of a body's own momentum and inertia forces.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_BODY_SLOPES_H
#define MBSRI_BODY_SLOPES_H

#include "recursion/data.h"

/* Doubles of scratch for the largest body. */
size_t mbsri_body_slopes_size(const mbsr_model *m);

/* Adds to P (3 d rows, or 2 d unless `accelerated`; columns: pose, V and, where accelerated, A) the
 * derivatives of
 *
 *   -M V,   h - M' V,   -h - M A
 *
 * of body i at the state of mbsr_stage_forces with rates. What an inertia's function returned. */
int mbsri_body_slopes_add(const mbsr_model *m, mbsr_data *d, int i, bool accelerated, double *P,
                          double *work);

/* Whether they can be had: an inertia by function needs V = p' of its body. */
bool mbsri_body_slopes_serve(const mbsri_body *b);

#endif
