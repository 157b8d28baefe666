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
 * length of steps before it. So an error of more than 10 tolerances of momenta is tested by the
 * constant of equal steps, and as it is, with C = 1, where the step is less than half as long as
 * one of those before: something has made it so. Smaller ones may be noise that no step makes
 * smaller, which must not end a run: by 20 times C at most.
 *
 * After failures IDA falls to order 1, whose prediction goes on as the whole last step went. Where
 * that was long and smooth a short step errs by h h_last p'' / 2, and no force has jumped. What
 * jumps leaves the tangent p_last + h p'_last as well, by as much: so of either error the smaller
 * is taken.
 *
 * The filter (filter.c). It says that the next step forgets an error along a direction in which
 * something stiff acts: an offset. That holds if it has acted before as well. What a stop takes in
 * the step in which it is hit is no offset but the impact, and the velocity with which it was hit
 * is gone. So a large error e is filtered, to v, only where it met something stiff at the end of
 * the last step, too. It is asked along w, what the filter takes off of e - v,
 *
 *   K w = (0, c (e_p - v_p), 0),   w_u . (K_last w - c w_p) > w_u . (K w - c w_p) / 2,
 *       K_last w a difference of two residuals.
 *
 * Inertia, c w_p, resists before and after. What moves freely is left of e, and is nearly gone from
 * e - v: along v it would pull at a stiff direction that turns, by its angle in one step, as much
 * as that moves itself. What the filter leaves is no offset either, and is tested as that of a
 * jump.
 */
#include "ida/stiff.h"

#include <ida/ida.h>

#include <float.h>
#include <math.h>

void mbsri_stiff_note_step(mbsri_stiff *s, long before)
{
    mbsri_past *past = &s->past;
    if (s->now.steps == before) return;
    const bool next = s->now.steps == before + 1;
    for (int j = MBSRI_PAST_STEPS - 1; j > 0; --j) past->step[j] = past->step[j - 1];
    IDAGetLastStep(s->memory, &past->step[0]);
    past->known = !next ? 0 : past->known < MBSRI_PAST_STEPS ? past->known + 1 : past->known;
    const N_Vector y = past->y, rate = past->rate;
    past->y = past->attempt, past->rate = past->attempt_rate;
    past->attempt = y, past->attempt_rate = rate;
}

void mbsri_stiff_note_attempt(mbsri_stiff *s)
{
    N_Vector y = NULL, rate = NULL;
    if (IDAGetCurrentY(s->memory, &y) < 0 || IDAGetCurrentYp(s->memory, &rate) < 0) return;
    N_VScale(1.0, y, s->past.attempt);
    N_VScale(1.0, rate, s->past.attempt_rate);
}

/* The momenta's distance from where their last rates lead, a step of h on. */
static double from_straight(mbsri_stiff *s, double h)
{
    N_VLinearSum(1.0, s->past.attempt, -1.0, s->past.y, s->trial);
    N_VLinearSum(1.0, s->trial, -h, s->past.rate, s->trial);
    return mbsri_stiff_momentum_norm(s, s->trial);
}

double mbsri_stiff_unequal(mbsri_stiff *s, double momenta)
{
    static const double shorter = 2.0;
    double h = 0.0, last = 0.0, sum = 0.0, longest = 0.0;
    if (s->past.known == 0 || s->past.known < s->now.order || IDAGetCurrentStep(s->memory, &h) < 0)
        return 1.0;
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
    if (!(wanted > constant)) return 1.0;
    return fmax(1.0, fmin(1.0, from_straight(s, h) / momenta) * wanted / constant);
}

/* The power of inertia along v, at the rates of v. */
static int inertia(mbsri_stiff *s, N_Vector v, double *power)
{
    const double *from = N_VGetArrayPointer(v);
    double *to = N_VGetArrayPointer(s->change);
    N_VConst(0.0, s->change);
    for (int k = s->first; k < s->last; ++k) to[k] = s->now.c * from[k];
    const int status = s->weigh ? s->weigh(s->user, s->change) : 0;
    *power = mbsri_stiff_power(s, v, s->change);
    return status;
}

/* By how much w has to be longer to move coordinates by `units` of their rounding, and by `least`
 * tolerances. */
static double above_rounding(const mbsri_stiff *s, N_Vector w, double units, double least)
{
    const double *move = N_VGetArrayPointer(w), *y = N_VGetArrayPointer(s->past.y);
    const double *weight = N_VGetArrayPointer(s->weight);
    double most = 0.0, rounding = 0.0;
    for (int k = 0; k < s->first; ++k) {
        most = fmax(most, fabs(move[k]) * weight[k]);
        rounding = fmax(rounding, DBL_EPSILON * fabs(y[k]) * weight[k]);
    }
    return most > 0.0 ? fmax(least, units * rounding) / most : 1.0;
}

/* The power along w of the change of forces from s->trial, `length` w on, over length; s->trial is
 * left as it was. */
static int difference(mbsri_stiff *s, N_Vector w, double length, double *power)
{
    int status = s->system(s->trial, s->change, s->memory);
    if (status) return status;
    N_VLinearSum(1.0, s->trial, length, w, s->trial);
    status = s->system(s->trial, s->error, s->memory);
    N_VLinearSum(1.0, s->trial, -length, w, s->trial);
    N_VLinearSum(1.0 / length, s->error, -1.0 / length, s->change, s->error);
    *power = mbsri_stiff_power(s, w, s->error);
    return status;
}

/* The same at the end of the last step: the larger one of a difference that is well above rounding
 * and of what acts at that very state, both ways within 64 times its rounding. A cable of 1e14 N/m
 * is stretched by no more than some hundred times that, and lets go in a longer difference. */
static int power_before(mbsri_stiff *s, N_Vector w, double enough, double *power)
{
    double there = 0.0, back = 0.0;
    const double well = fmax(1.0, above_rounding(s, w, 1e4, 1e-5)),
                 little = above_rounding(s, w, 64.0, 1e-11);
    int status = difference(s, w, well, power);
    if (status || *power > enough) return status;
    status = difference(s, w, little, &there);
    if (!status) status = difference(s, w, -little, &back);
    *power = fmax(*power, fmin(there, back));
    return status;
}

bool mbsri_stiff_acted(mbsri_stiff *s, N_Vector x)
{
    static const double least = 0.5;
    N_Vector w = s->filtered, y = NULL;
    double always = 0.0, before = 0.0;
    if (s->past.known == 0 || IDAGetCurrentY(s->memory, &y) < 0) return true;
    N_VLinearSum(1.0, x, -1.0, w, s->trial);
    if (mbsri_stiff_filter(s, s->trial, s->error) || inertia(s, w, &always)) return true;
    const double now = mbsri_stiff_power(s, w, s->error) - always, enough = least * now + always;
    N_VLinearSum(1.0, s->past.y, -1.0, y, s->trial);
    N_VLinearSum(1.0, s->trial, 1.0, x, s->trial);
    const int status = power_before(s, w, enough, &before);
    s->system(x, s->change, s->memory); /* IDA's y and y' are what they were */
    return status || before > enough;
}
