/* Directions that are lightly damped: where the slow motion is.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Without its mass a direction with a stiffness k and a damping d has a position of its own, which
 * relaxes at the rate k / d. With d^2 << k m that is faster than the oscillation with the mass, and
 * no part of the smooth motion: the position there is the one at which the direction moves with the
 * rate v of its slow motion. v is the derivative of that position in time, which depends on v by a
 * share d / k only: each pass of differences leaves that share of its error. */
#include "small/slow.h"

#include "small/smooth.h"

static const double light = 1.0;   /* damping ratios below are light */
static const double relaxed = 1.0; /* k / d times the slow time scale, beyond which it is fast */
static const double apart = 0.02;  /* times of differences, over the slow time scale */
enum { PASSES = 4 };

static bool is_light(const mbsr_small_masses *s, const mbsr_small_direction *x)
{
    const mbsri_body *b = s->given->body + s->given->index[x->body];
    return x->damping > 0.0 && x->stiffness > 0.0 && x->damping_ratio < light &&
           x->stiffness * s->opt.time_scale > relaxed * x->damping && b->nq == b->n;
}

/* Rates and their derivatives from positions at five times, by central differences. */
static int differentiate(mbsr_small_masses *s)
{
    const double h = apart * s->opt.time_scale;
    int status = MBSR_OK;
    for (int p = -2; p <= 2 && !status; ++p) {
        status = mbsri_small_beside(s, p * h, s->y_full, s->yp_full);
        for (int l = 0; l < s->slow.count && !status; ++l)
            s->slow.each[l].position[p + 2] = s->y_full[s->slow.each[l].q];
    }
    for (int l = 0; l < s->slow.count && !status; ++l) {
        mbsri_light *x = s->slow.each + l;
        const double *z = x->position, even = z[3] + z[1], odd = z[3] - z[1];
        x->rate[0] = (8.0 * odd - (z[4] - z[0])) / (12.0 * h);
        x->rate[1] = (16.0 * even - 30.0 * z[2] - (z[4] + z[0])) / (12.0 * h * h);
        x->rate[2] = ((z[4] - z[0]) - 2.0 * odd) / (2.0 * h * h * h);
        x->rate[3] = ((z[4] + z[0]) - 4.0 * even + 6.0 * z[2]) / (h * h * h * h);
    }
    return status;
}

int mbsri_small_refine(mbsr_small_masses *s)
{
    int status = MBSR_OK;
    for (int pass = 0; pass < PASSES && !status; ++pass) {
        status = differentiate(s);
        if (!status)
            status = mbsri_small_settle(s, s->start.t, s->start.q, s->start.u, s->y, s->yp);
    }
    return status;
}

static void find(mbsr_small_masses *s)
{
    const mbsr_model *m = s->given;
    s->slow.count = 0;
    for (int l = 0; l < s->directions; ++l) {
        const mbsr_small_direction *x = s->direction + l;
        const mbsri_body *b = m->body + m->index[x->body];
        if (!is_light(s, x)) continue;
        s->slow.each[s->slow.count++] =
            (mbsri_light){.q = b->q + x->coordinate,
                          .u = b->u + x->coordinate,
                          .relaxation = x->damping / x->stiffness,
                          .pattern = s->swings.pattern + (size_t)l * (size_t)s->size};
    }
}

int mbsri_small_slow(mbsr_small_masses *s)
{
    const int u = s->given->nq + s->given->nu;
    find(s);
    if (s->slow.count == 0) return MBSR_OK;
    int status = mbsri_small_settle(s, s->start.t, s->start.q, s->start.u, s->y, s->yp);
    if (!status) status = mbsri_small_refine(s);
    if (!status) mbsri_small_impose(s, s->start.t, 1, s->yp + u);
    if (status <= 0) return status;
    /* as for other directions, then: they begin where they are */
    s->slow.count = 0;
    return mbsri_small_settle(s, s->start.t, s->start.q, s->start.u, s->y, s->yp);
}
