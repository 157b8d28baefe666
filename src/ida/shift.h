/* y - c in the place of y: see kinks.h. The memory of kinks.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_IDA_SHIFT_H
#define MBSRI_IDA_SHIFT_H

#include "ida/record.h"

/* What of the driver's memory belongs to kinks; false without memory. */
bool mbsri_ida_make_kinks(mbsr_ida *ida);
void mbsri_ida_free_kinks(mbsr_ida *ida);

/* For a new start. */
void mbsri_ida_forget_kinks(mbsr_ida *ida);

/* y, y' of z, z' at t, for a callback: they are z, z' themselves or vectors of the driver. yp may
 * be NULL. */
void mbsri_ida_shift_back(mbsr_ida *ida, double t, N_Vector *y, N_Vector *yp);

/* y += n-th derivative of c at t */
void mbsri_ida_add_shift(const mbsr_ida *ida, double t, int n, N_Vector y);

/* Lets IDA integrate y itself from now on; called before it starts anew. */
void mbsri_ida_end_shift(mbsr_ida *ida);

/* Noted for the next restart: the first step since the last one. Called between steps. */
void mbsri_ida_note_step(mbsr_ida *ida);

#endif
