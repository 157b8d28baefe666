/* The error test where a stop is hit.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The filter (filter.c) says that the next step forgets an error along a direction in which something stiff acts: an offset. That
 * holds if it has acted before as well. What a stop takes in the step in which it is hit is no offset but the impact, and the velocity
 * with which it was hit is gone. So a large error is filtered only where its direction v was stiff at the end of the last step, too:
 *
 *   v_u . K_last v > v_u . K v / 2,     K v = (0, c e_p, 0),     K_last v a difference of two residuals. */
#include "ida/stiff.h"

#include <ida/ida.h>

void mbsri_stiff_note_step(mbsri_stiff *s, long before)
{
    mbsri_past *past = &s->past;
    if (s->steps == before) return;
    N_Vector y = past->y;
    past->y = past->attempt;
    past->attempt = y;
    past->known = s->steps == before + 1;
}

void mbsri_stiff_note_attempt(mbsri_stiff *s)
{
    N_Vector y = NULL;
    if (IDAGetCurrentY(s->memory, &y) >= 0) N_VScale(1.0, y, s->past.attempt);
}

bool mbsri_stiff_acted(mbsri_stiff *s, N_Vector x)
{
    static const double least = 0.5;
    N_Vector v = s->filtered, y = NULL;
    if (!s->past.known || IDAGetCurrentY(s->memory, &y) < 0) return true;
    const double now = mbsri_stiff_power(s, v, s->error);
    N_VLinearSum(1.0, s->past.y, -1.0, y, s->trial);
    N_VLinearSum(1.0, s->trial, 1.0, x, s->trial);
    int status = s->system(s->trial, s->change, s->memory);
    N_VLinearSum(1.0, s->trial, 1.0, v, s->trial);
    if (!status) status = s->system(s->trial, s->error, s->memory);
    N_VLinearSum(1.0, s->error, -1.0, s->change, s->error);
    const double before = mbsri_stiff_power(s, v, s->error);
    s->system(x, s->change, s->memory); /* IDA's y and y' are what they were */
    return status || before > least * now;
}
