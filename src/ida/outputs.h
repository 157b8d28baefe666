/* States as they are handed out.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Between steps IDA interpolates all of y. Errors of q and momenta are controlled, and so these are
 * good; u where nothing has mass, loop forces and y' are not. They are found from q and the momenta
 * (mbsr_completion_solve), in vectors of their own: IDA goes on as if nobody had asked. */
#ifndef MBSRI_IDA_OUTPUTS_H
#define MBSRI_IDA_OUTPUTS_H

#include "ida/record.h"

/* What completes states, unless they are to be handed out as they are; a status. */
int mbsri_ida_make_outputs(mbsr_ida *ida, mbsr_error *error);
void mbsri_ida_free_outputs(mbsr_ida *ida);

/* Completes the state at `present`, unless it is; where that fails it stays as it was interpolated,
 * and counts. */
void mbsri_ida_complete(mbsr_ida *ida);

/* It is another one from now on. */
static inline void mbsri_ida_forget_output(mbsr_ida *ida)
{
    ida->output.complete = ida->output.tried = false;
}

/* y and y' to be handed out. */
static inline N_Vector mbsri_ida_output_y(const mbsr_ida *ida)
{
    return ida->output.complete ? ida->output.y : ida->y;
}

static inline N_Vector mbsri_ida_output_yp(const mbsr_ida *ida)
{
    return ida->output.complete ? ida->output.yp : ida->yp;
}

#endif
