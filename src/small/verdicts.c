/* What is to be said of each candidate.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "small/verdicts.h"

#include "small/swings.h"

#include <math.h>

/* The tolerance of the coordinate of a direction, where all q are the outputs; 0: there is none. */
static double tolerance_of(const mbsr_small_masses *s, const mbsr_small_direction *x)
{
    const mbsri_body *b = s->given->body + s->given->index[x->body];
    if (s->opt.output || b->nq != b->n) return s->opt.tolerance;
    return s->tolerance[b->q + x->coordinate];
}

/* Of the start's swing. */
static double steps_of(const mbsr_small_masses *s, int l, double span)
{
    const mbsr_small_direction *x = s->direction + l;
    return mbsri_small_swing_steps(x, mbsri_small_swing_size(s, l, x->amplitude), 0.0, span);
}

static void judge(mbsr_small_masses *s, int k, double span)
{
    const mbsri_candidate *c = s->candidate + k;
    mbsr_small_mass *x = s->report.mass + k;
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
    x->steps = c->steps;
    double lasting = 0.0, slow = 0.0; /* shares of motions that do not die out, that are not fast */
    for (int l = 0; l < s->directions; ++l) {
        const mbsr_small_direction *y = s->direction + l;
        if (y->mass != k || !(y->rate > 0.0)) continue;
        if (x->direction == MBSR_NONE || y->rate > s->direction[x->direction].rate)
            x->direction = l;
        const double share = y->amplitude / tolerance_of(s, y);
        x->amplitude = fmax(x->amplitude, share);
        if (!mbsri_small_is_fast(y))
            slow = fmax(slow, share);
        else if (y->decay * span < 3.0)
            lasting = fmax(lasting, share);
        if (s->run.states == 1) x->steps = fmax(x->steps, steps_of(s, l, span));
    }
    if (x->share + slow > 1.0)
        x->verdict = MBSR_SMALL_MAY_NOT_BE_ZERO;
    else
        x->verdict = lasting > 1.0 ? MBSR_SMALL_UNDAMPED : MBSR_SMALL_MAY_BE_ZERO;
}

double mbsri_small_judge(mbsr_small_masses *s)
{
    const double span = s->run.states > 1 ? s->run.t[0] - s->start.t : s->opt.duration;
    double steps = s->zeros.saved;
    for (int k = 0; k < s->candidates; ++k) {
        judge(s, k, span);
        steps = fmax(steps, s->report.mass[k].steps);
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
