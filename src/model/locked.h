/* Joint coordinates that are locked, and what refers to them.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_LOCKED_H
#define MBSRI_LOCKED_H

#include "model/record.h"

/* The values of locked coordinates, NaN for the others, as many as the joint has as it was given;
 * NULL: none is locked, or the ground. */
const double *mbsri_locked_values(const mbsr_model *m, int id);

/* Whether an element acts on joint coordinates all of which are locked; body: its ids. */
bool mbsri_force_rests(const mbsr_model *m, const mbsr_force_def *def, const int *body);

/* Coordinates of an element as they are left, and as they were given. */
void mbsri_force_hold(const mbsr_model *m, mbsri_force *force, const int *body);
void mbsri_force_as_given(const mbsri_force *force, mbsr_force_def *def);

/* Whether the coordinate of term k of a closure, a coupling, is locked. */
bool mbsri_term_is_held(const mbsr_model *m, const mbsr_closure_def *def, int k);

/* A coupling without its terms that are locked, and as it was given. Status: MBSR_ERR_VALUE where
 * no term is left and the others contradict it; MBSR_ERR_NO_MEMORY; the reason in text. */
int mbsri_coupling_left(mbsr_model *m, mbsri_closure *closure, char text[MBSR_TEXT_SIZE]);
const mbsr_closure_def *mbsri_closure_as_given(const mbsr_model *m, const mbsri_closure *closure);

/* The potential energy of a resting element, which is constant: 0 where it is dropped. */
int mbsri_resting_energy(const mbsr_model *m, const mbsri_force *force, double *energy);

#endif
