/* Slopes of force elements for the Newton sweeps.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_NEWTON_ELEMENTS_H
#define MBSRI_NEWTON_ELEMENTS_H

#include "newton/sweeps/record.h"

/* How many bodies there are with elements, and pairs of a body and its predecessor between which
 * some act (at most); into the arrays, which may be NULL: their numbers, or -1. */
void mbsri_newton_count(const mbsr_model *m, const mbsri_sweeps *tree, size_t *loaded,
                        size_t *pairs, int *number, int *pair);

/* Slopes at the state of the data, but for gravity: joint forces, forces on bodies and between a
 * body and its predecessor. Returns a status, or MBSRI_NOT_SERVED where a joint's force depends on
 * the motion of its bodies or the other way round. */
int mbsri_newton_slopes_at(mbsri_newton_sweeps *newton, mbsr_data *d);

/* Whether there are couplings of joint coordinates whose forces change with these. */
bool mbsri_newton_has_joint_slopes(const mbsr_model *m);

/* Adds what each of their forces changes with the coordinates of its own joint, when loops are
 * open; once a factorisation. */
void mbsri_newton_add_joint_slopes(mbsri_newton_sweeps *newton);

#endif
