/* Parts of an inertia.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_NEGLECT_H
#define MBSRI_NEGLECT_H

#include "model/record.h"

/* MBSR_MASS, MBSR_MOMENT: what of it is not zero. */
int mbsri_inertia_parts(const mbsr_inertia *inertia);

/* What is left without these parts. */
mbsr_inertia mbsri_inertia_without(const mbsr_inertia *inertia, int parts);

#endif
