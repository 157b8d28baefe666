/* The order of the force elements in a finished model.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_ORDER_FORCES_H
#define MBSRI_ORDER_FORCES_H

#include "model/record.h"

/* Force elements in the order of the sweeps, by the first body they act on, those on one coordinate
 * last, law by law and with their numbers in m->along; behind the last of m->forces those that are
 * closures, m->carried. count: N + 1 ints. The old array goes, so nothing may fail after this.
 * MBSR_ERR_NO_MEMORY. */
int mbsri_order_forces(mbsr_model *m, int N, int *count);

#endif
