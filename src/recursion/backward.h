/* The backward recursion (17): articulated-body inertia Mbar and bias force fbar, leaves to root.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_BACKWARD_H
#define MBSRI_BACKWARD_H

#include "recursion/data.h"

/* The stage: both halves below. */
int mbsri_backward(const mbsr_model *m, mbsr_data *d);

/* Mbar, D and what follows from masses alone (needs mbsri_velocities); then fbar, e, mu from
 * forces. */
int mbsri_backward_masses(const mbsr_model *m, mbsr_data *d);
void mbsri_backward_loads(const mbsr_model *m, mbsr_data *d);

#endif
