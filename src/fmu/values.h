/* Values of variables, states of an instance as a whole, derivatives of variables.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FMU_VALUES_H
#define MBSRI_FMU_VALUES_H

#include "fmu/instance.h"

/* By value references; `function` is the caller's name, for messages. */
mbsri_result mbsri_get(mbsri_instance *in, const char *function, const unsigned *reference,
                       size_t count, double *value);
mbsri_result mbsri_set(mbsri_instance *in, const char *function, const unsigned *reference,
                       size_t count, const double *value);

/* sensitivity = (d unknowns / d knowns) seed. adjoint: its transpose times a seed of the unknowns.
 * Knowns are inputs, parameters (by_parameters.h) and, in model exchange, states. */
mbsri_result mbsri_differentiate(mbsri_instance *in, const char *function, bool adjoint,
                                 const unsigned *unknown, size_t unknowns, const unsigned *known,
                                 size_t knowns, const double *seed, double *sensitivity);

#endif
