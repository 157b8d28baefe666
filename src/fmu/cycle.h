/* From mode to mode: what both versions of the standard have in common.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FMU_CYCLE_H
#define MBSRI_FMU_CYCLE_H

#include "fmu/instance.h"

/* How a run was asked for; tolerance 0: none. */
mbsri_result mbsri_set_up(mbsri_instance *in, const char *function, double tolerance, double start);

/* To initialization mode, and out of it with a consistent start: to `next`. */
mbsri_result mbsri_initialize(mbsri_instance *in);
mbsri_result mbsri_initialized(mbsri_instance *in, const char *function, mbsri_unit_mode next);

/* A communication step. *event: a stop is hit at in->t. */
mbsri_result mbsri_communicate(mbsri_instance *in, const char *function, double t, double h,
                               bool *event);

#endif
