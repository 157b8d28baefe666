/* One step: substeps, as many as it takes.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_STEPPER_STEP_H
#define MBSRI_STEPPER_STEP_H

#include "stepper/record.h"

/* Most of each that one step can take. */
mbsr_stepper_work mbsri_stepper_bound(const mbsr_stepper *s);

/* Goes from s->t to t_end, which is h later. On failure all is as it was, with the reason in
 * s->error. */
int mbsri_stepper_advance(mbsr_stepper *s, double t_end, double h);

#endif
