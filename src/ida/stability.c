/* Vibrations that BDF of order 3 and more keeps alive.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Near the imaginary axis BDF of order 3 to 5 is unstable: a vibration of frequency w that the
 * mechanism has damped out long ago grows from rounding where h w is between about 0.1 and 1.5,
 * until the error test shortens the step, and stays so for good. BDF of order 2 damps it, by (h
 * w)^4 / 4 in a step.
 *
 * What an error test measures for orders k and k - 1 are differences of the solution of order k + 1
 * and k, and each difference makes a vibration 2 sin(h w / 2) times as large. So over the last
 * steps
 *
 *   (h w)^2 = sum |e_p,k|^2 / sum |e_p,k-1|^2,     A^2 = mean of |e_p,k-1|^2 / (h w)^2k,
 *       Q^2 the same of e_q,k-1
 *
 * tell its frequency and its amplitudes in momenta and coordinates, in tolerances. Q of a motion is
 * thousands; a vibration of `many` tolerances in momenta, of which coordinates show less than
 * `unseen` and `little` of that, or next to nothing, is nobody's motion. (Order 2 follows what else
 * moves less well: with a Q up to 0.3 and any A an arm with elastic gears lost 17 000 tolerances;
 * with `little` alone a tyre that had come to rest after its bounces vibrated for ever; with 0.004
 * of a tolerance as next to nothing a flexible arm lost four times as much.) It takes
 * some A^(4/3) steps at most to go, as (h w)^3 A is about 1. As many are waited for: the attempt
 * costs no more than what the vibration has cost. It ends when a step takes two periods, beyond
 * which orders above 2 are stable again. */
#include "ida/control.h"

#include <math.h>

void mbsri_control_note_errors(mbsri_control *c, long step, double h, int order,
                               const mbsri_errors *e)
{
    static const double fade = 0.99, slow = 0.1, fast = 1.5, unseen = 0.02, nothing = 0.001,
                        many = 3.0, little = 4e-5, turn = 6.28318530717958648;
    enum { LEAST = 500 };
    mbsri_vibration *v = &c->vibration;
    v->higher = fade * v->higher + e->momenta * e->momenta;
    v->lower = fade * v->lower + e->momenta_below * e->momenta_below;
    const double angle = fmax(slow, sqrt(v->higher / fmax(v->lower, 0.1 * v->higher))),
                 size = pow(angle, -2.0 * order) * (1.0 - fade);
    v->momenta = fade * v->momenta + size * e->momenta_below * e->momenta_below;
    v->coordinates = fade * v->coordinates + size * e->coordinates_below * e->coordinates_below;
    const double enough = fmin(unseen * unseen, little * little * v->momenta);
    const bool there = angle > slow && angle < fast && v->momenta > many * many,
               seen = !(v->coordinates < fmax(nothing * nothing, enough));
    v->steps = there && !seen ? v->steps + 1 : 0;
    const double steps = fmax(LEAST, pow(v->momenta, 2.0 / 3.0));
    if ((double)v->steps < steps) return;
    c->low_until = step + (long)(4.0 * steps);
    c->long_enough = 2.0 * turn * h / angle;
    *v = (mbsri_vibration){0};
}

bool mbsri_control_low_order(mbsri_control *c, long step, double h)
{
    if (h > c->long_enough) c->low_until = 0;
    return step < c->low_until;
}
