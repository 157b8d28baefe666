/* The residual and the event functions as IDA calls them.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_IDA_CALLBACKS_H
#define MBSRI_IDA_CALLBACKS_H

#include "ida/record.h"

int mbsri_ida_residual(sunrealtype t, N_Vector y, N_Vector yp, N_Vector F, void *user);
int mbsri_ida_events(sunrealtype t, N_Vector y, N_Vector yp, sunrealtype *value, void *user);

/* Notes the failure of an evaluation at t; what the callback has to return to IDA. */
int mbsri_ida_failed(mbsr_ida *ida, double t, int status, const mbsr_error *error,
                     const char *what);

#endif
