/* The error test where forces jump.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A servo that comes out of its saturation, a stop that is hit: p' changes within a step by as much
 * as it likes. Two things that are right for smooth motions let such a step pass.
 *
 * The constants of IDA's test. With h over the time that the last j steps and the present one have
 * taken together,
 *
 *   error = C |e|,   C = max(a_k, |a_k + a_0 + .. + a_(k-1) - 1 - 1/2 - .. - 1/k|),
 *       a_j = h / (h + h_1 + .. + h_j),
 *
 * 1 / (k + 1) for equal steps. After large steps have failed and a small one is tried C may be a
 * thousandth of that: what a smooth solution would do there. What jumps does not get smaller by the
 * length of steps before it. So an error of momenta that is large by the constant of equal steps is
 * tested by that, and as it is, with C = 1, where the step is less than half as long as one of
 * those before: something has made it so. By 20 times C if that is less: noise that no step makes
 * smaller must not end a run.
 *
 * The filter (filter.c). It says that the next step forgets an error along a direction in which
 * something stiff acts: an offset. That holds if it has acted before as well. What a stop takes in
 * the step in which it is hit is no offset but the impact, and the velocity with which it was hit
 * is gone. So a large error is filtered only where its direction v was stiff at the end of the last
 * step, too:
 *
 *   v_u . K_last v > v_u . K v / 2,     K v = (0, c e_p, 0),
 *       K_last v a difference of two residuals. */
#include "ida/stiff.h"

#include <ida/ida.h>

#include <math.h>

void mbsri_stiff_note_step(mbsri_stiff *s, long before)
{
    mbsri_past *past = &s->past;
    if (s->now.steps == before) return;
    const bool next = s->now.steps == before + 1;
    for (int j = MBSRI_PAST_STEPS - 1; j > 0; --j) past->step[j] = past->step[j - 1];
    IDAGetLastStep(s->memory, &past->step[0]);
    past->known = !next ? 0 : past->known < MBSRI_PAST_STEPS ? past->known + 1 : past->known;
    N_Vector y = past->y;
    past->y = past->attempt;
    past->attempt = y;
}

void mbsri_stiff_note_attempt(mbsri_stiff *s)
{
    N_Vector y = NULL;
    if (IDAGetCurrentY(s->memory, &y) >= 0) N_VScale(1.0, y, s->past.attempt);
}

double mbsri_stiff_unequal(const mbsri_stiff *s)
{
    static const double most = 20.0, shorter = 2.0;
    double h = 0.0, last = 0.0, sum = 0.0, longest = 0.0;
    if (s->past.known < s->now.order || IDAGetCurrentStep(s->memory, &h) < 0) return 1.0;
    double time = h;
    for (int j = 0; j <= s->now.order; ++j) {
        if (j > 0) time += s->past.step[j - 1];
        if (j > 0) longest = fmax(longest, fabs(s->past.step[j - 1]));
        last = h / time;
        if (j < s->now.order) sum += last - 1.0 / (j + 1);
    }
    const bool shrunk = shorter * fabs(h) < longest;
    const double constant = fmax(last, fabs(last + sum)),
                 wanted = shrunk ? 1.0 : 1.0 / (s->now.order + 1);
    return fmin(most, fmax(1.0, wanted / constant));
}

bool mbsri_stiff_acted(mbsri_stiff *s, N_Vector x)
{
    static const double least = 0.5;
    N_Vector v = s->filtered, y = NULL;
    if (s->past.known == 0 || IDAGetCurrentY(s->memory, &y) < 0) return true;
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
