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
 * tell its frequency and its amplitudes in momenta and coordinates, in tolerances. What a run loses
 * where it is let go is Q, and, if it would have been cut loose while it moves, A for each second
 * after. So it goes where A Q, what it carries, is `little`: that leaves Q below a hundredth and A
 * below a hundred where A is 1e4 Q. (An arm with elastic gears lost 17 000 tolerances where any A
 * would do, with a Q up to 0.3; a belt with play 10 000 where A Q was up to 6.) One of less than
 * `few` holds steps back by the third root of that, and order 2 does so too, for what else moves:
 * of the real vibrations of a flexible arm, A of 3 to 5 tolerances are left where order 5 follows
 * them, and order 2 makes the arm err four times as much. It takes some A^(4/3) steps at most to
 * go, as (h w)^3 A is about 1. As many are waited for: the attempt costs no more than what the
 * vibration has cost. It ends when a step takes two periods, beyond which orders above 2 are stable
 * again. */
#include "ida/control.h"

#include <math.h>

void mbsri_control_note_errors(mbsri_control *c, long step, double h, int order,
                               const mbsri_errors *e)
{
    static const double fade = 0.99, slow = 0.1, fast = 1.5, little = 0.1, few = 10.0,
                        turn = 6.28318530717958648;
    enum { LEAST = 200 };
    mbsri_vibration *v = &c->vibration;
    v->higher = fade * v->higher + e->momenta * e->momenta;
    v->lower = fade * v->lower + e->momenta_below * e->momenta_below;
    const double angle = fmax(slow, sqrt(v->higher / fmax(v->lower, 0.1 * v->higher))),
                 size = pow(angle, -2.0 * order) * (1.0 - fade);
    v->momenta = fade * v->momenta + size * e->momenta_below * e->momenta_below;
    v->coordinates = fade * v->coordinates + size * e->coordinates_below * e->coordinates_below;
    const bool there = angle > slow && angle < fast && v->momenta > few * few,
               goes = v->momenta * v->coordinates < little * little;
    v->steps = there && goes ? v->steps + 1 : 0;
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
