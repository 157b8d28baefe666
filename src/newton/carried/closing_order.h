/* Which fronts close the loops that meet on a body, and in what order: see carried.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_CLOSING_ORDER_H
#define MBSRI_CLOSING_ORDER_H

#include "newton/carried/record.h"

/* Fronts, the pools that they hand on to, and where each loop closes. False: there is no memory. */
bool mbsri_closing_order(mbsr_newton *w);

#endif
