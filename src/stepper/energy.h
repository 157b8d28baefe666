/* The account of energy, which keeps steps from making any.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_STEPPER_ENERGY_H
#define MBSRI_STEPPER_ENERGY_H

#include "stepper/record.h"

/* Opens the account at the state of s->y; the data is at mbsr_stage_velocities of it. */
int mbsri_stepper_open_account(mbsr_stepper *s);

/* Looks at a substep of length h that ends in s->Y, the data at mbsr_stage_velocities of it: brakes
 * its velocities where it has made energy; MBSR_NO_CONVERGENCE, with a text in s->cause, where
 * it has made much and is not the smallest (`last` false). */
int mbsri_stepper_settle(mbsr_stepper *s, double h, bool last);

#endif
