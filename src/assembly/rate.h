/* A rate typical of a tree without gravity.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_RATE_H
#define MBSRI_RATE_H

#include "model/record.h"

/* 1/s: of the model's mass at the springs of its stock elements, else of that at its dampers, else
 * of springs at dampers; 0: none is known. */
double mbsri_elements_rate(const mbsr_model *m);

/* kg m^2: what the springs and dampers of a model without mass would swing at its rate, once that
 * is known; 0: there are none. */
double mbsri_elements_inertia(const mbsr_model *m);

/* Whether entry k of `count` of an element's parameters is of a turn. */
bool mbsri_is_of_turn(const mbsr_model *m, const mbsri_force *force, int count, int k);

#endif
