/* What is to be said of each candidate.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "small/verdicts.h"

#include <math.h>

static const double slowest = 10.0; /* rate times slow time scale of what counts as fast */

/* The tolerance of the coordinate of a direction, where all q are the outputs; 0: there is none. */
static double tolerance_of(const mbsr_small_masses *s, const mbsr_small_direction *x)
{
    const mbsri_body *b = s->given->body + s->given->index[x->body];
    if (s->opt.output || b->nq != b->n) return s->opt.tolerance;
    return s->tolerance[b->q + x->coordinate];
}

/* Steps of BDF of order 5 through the fast motion of a direction. An error of the size `size` in
 * tolerances allows steps of a phase (4.5 / size)^(1/6), and the size dies out:
 *
 *   integral of rate / phase dt  while the size is above 1.
 *
 * Positions and momenta are tested, and momenta in tolerances of the inertia that the joint moves with
 * its masses (mbsr_momentum_scales); the numbers 4.5 and 4 are those of the driver, as measured. */
static double steps_of(const mbsr_small_masses *s, int l, double span)
{
    const mbsr_small_direction *x = s->direction + l;
    const mbsr_small_masses_opt *o = &s->opt;
    const double swing = x->amplitude, speed = x->amplitude * x->rate;
    const double velocity = o->atol_velocity > 0.0 ? o->atol_velocity : o->atol;
    if (!(x->rate > 0.0)) return 0.0;
    const double in_q = swing / (o->atol + o->rtol * swing),
                 in_p = x->inertia / fmax(s->scale[l], x->inertia) * speed /
                        (velocity + o->rtol * speed),
                 size = fmax(in_q, 4.0 * in_p);
    if (!(size > 1.0)) return 0.0;
    const double first = pow(size / 4.5, 1.0 / 6.0), died = x->decay * span;
    if (died < 1e-3) return span * x->rate * first;
    const double last = pow(fmax(1.0, size * exp(-died)) / 4.5, 1.0 / 6.0);
    return 6.0 * x->rate / x->decay * (first - last);
}

static void judge(mbsr_small_masses *s, int k, double span)
{
    const mbsri_candidate *c = s->candidate + k;
    mbsr_small_mass *x = s->mass + k;
    *x = (mbsr_small_mass){.body = c->body,
                           .parts = c->parts,
                           .ratio = c->ratio,
                           .direction = MBSR_NONE,
                           .verdict = MBSR_SMALL_UNDETERMINED};
    if (c->held) return;
    x->error = c->worst.error;
    x->share = c->worst.share;
    x->time = c->worst.time;
    x->output = c->worst.output;
    double lasting = 0.0, slow = 0.0; /* shares of motions that do not die out, that are not fast */
    for (int l = 0; l < s->directions; ++l) {
        const mbsr_small_direction *y = s->direction + l;
        if (y->mass != k || !(y->rate > 0.0)) continue;
        if (x->direction == MBSR_NONE || y->rate > s->direction[x->direction].rate)
            x->direction = l;
        const double share = y->amplitude / tolerance_of(s, y);
        x->amplitude = fmax(x->amplitude, share);
        if (y->fastness < slowest)
            slow = fmax(slow, share);
        else if (y->decay * span < 3.0)
            lasting = fmax(lasting, share);
        x->steps = fmax(x->steps, steps_of(s, l, span));
    }
    if (x->share + slow > 1.0)
        x->verdict = MBSR_SMALL_MAY_NOT_BE_ZERO;
    else
        x->verdict = lasting > 1.0 ? MBSR_SMALL_UNDAMPED : MBSR_SMALL_MAY_BE_ZERO;
}

double mbsri_small_judge(mbsr_small_masses *s)
{
    const double span = s->states > 1 ? s->t[0] - s->from : s->opt.duration;
    double steps = 0.0;
    for (int k = 0; k < s->candidates; ++k) {
        judge(s, k, span);
        steps = fmax(steps, s->mass[k].steps);
    }
    return steps;
}

const char *mbsr_small_verdict_text(mbsr_small_verdict verdict)
{
    static const char *const text[] = {"may be zero", "undamped: the mean is right",
                                       "may not be zero", "would be undetermined"};
    const int k = (int)verdict;
    return k >= 0 && k < 4 ? text[k] : "";
}
