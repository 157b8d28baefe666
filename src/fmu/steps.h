/* Steps of co-simulation.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FMU_STEPS_H
#define MBSRI_FMU_STEPS_H

#include "fmu/instance.h"

/* From the present to t_end, or to an event or where the importer wants control back: in->t is what
 * was reached, *event whether a stop is hit there. MBSRI_DISCARD: a fixed step was refused, and the
 * state is as it was. */
mbsri_result mbsri_step(mbsri_instance *in, double t_end, bool *event);

#endif
