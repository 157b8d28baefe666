/* States and derivatives of model exchange, event indicators.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FMU_EXCHANGE_H
#define MBSRI_FMU_EXCHANGE_H

#include "fmu/instance.h"

/* x = (q, p), nq + nu numbers, and their derivatives. */
mbsri_result mbsri_get_states(mbsri_instance *in, const char *function, double *x, size_t count);
mbsri_result mbsri_set_states(mbsri_instance *in, const char *function, const double *x,
                              size_t count);
mbsri_result mbsri_get_derivatives(mbsri_instance *in, const char *function, double *xdot,
                                   size_t count);
mbsri_result mbsri_get_nominals(mbsri_instance *in, const char *function, double *x, size_t count);
mbsri_result mbsri_get_indicators(mbsri_instance *in, const char *function, double *value,
                                  size_t count);
mbsri_result mbsri_set_time(mbsri_instance *in, const char *function, double t);

/* The next time event beyond t, a kink of a table; false: there is none. */
bool mbsri_next_event(const mbsri_instance *in, double *t);

/* p, q' or p' of the evaluated state. A status of the library. */
int mbsri_state_value(mbsri_instance *in, const mbsri_variable *v, double *value);

#endif
