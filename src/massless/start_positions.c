/* Positions of a consistent start: see start.c.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * K(c) x = (0, 0, F_u, 0, g), c -> infinity:  q -= x_q, u -= x_u. Steps along directions that move
 * no mass leave masses where they are to the first order; what they move by is taken back,
 *
 *   K(c) x = (0, c P, 0, 0, 0),  P = sum of J^T M (displacement):  q += G x_u
 *
 * Shortened by Deuflhard's natural monotonicity: with the same matrices the next correction has to
 * be smaller. */
#include "massless/start_positions.h"

#include "massless/start_return.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "model/query.h"
#include "recursion/kinematics.h"

#include <math.h>

/* What is to become zero: forces by what they do along spans, gaps. */
typedef struct defects {
    double force, gap;
} defects;

static defects measure_defects(const mbsri_start *s)
{
    const mbsr_completion *w = s->w;
    double force = 0.0;
    for (int k = 0; k < w->m->nu; ++k)
        force = fmax(force, fabs(w->r[w->rates + k]) / w->span.per[k]);
    return (defects){force, mbsri_largest(w->m->position_rows, w->r + w->places)};
}

/* The correction at w->y, into s->step (q, and u in the place of u); what it is to make zero. */
static int aim(mbsri_start *s, bool fresh, defects *left)
{
    int status = mbsri_start_evaluate(s, true);
    if (!status && fresh) status = mbsri_start_factor(s);
    mbsri_start_rows(s, true, false, true);
    *left = measure_defects(s);
    return status ? status : mbsri_start_solve(s, NULL);
}

/* The largest of rotations in a change of q. */
static double largest_turn(const mbsri_start *s, const double *dq)
{
    const mbsr_model *m = s->w->m;
    double largest = 0.0;
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        for (int k = 0; k < b->nq; ++k) {
            if (mbsri_coordinate_kind(b, false, k) == MBSR_COORDINATE_ROTATION)
                largest = fmax(largest, fabs(dq[b->q + k]));
        }
    }
    return largest;
}

/* Goes along the step as far as it leads on; translations farther each time, as their range is not
 * known. A way that is crawled leads nowhere, or anywhere by rounding. */
static int advance(mbsri_start *s, double change, defects left)
{
    enum { HALVINGS = 12, PATIENT = 4 };
    static const double close = 1e-9, crawl = 1e-3, short_way = 1e-4;
    mbsr_completion *w = s->w;
    const mbsr_model *m = w->m;
    double share = fmin(1.0, fmin(s->longest / change, s->widest / largest_turn(s, s->step)));
    const bool shortened = share < 1.0;
    mbsri_copy((size_t)w->size, w->y, s->before);
    for (int tries = 0; tries < HALVINGS && (share >= crawl || share * change >= short_way);
         ++tries, share *= 0.5) {
        defects now;
        for (int k = 0; k < w->rates; ++k) w->y[k] = s->before[k] - share * s->step[k];
        for (int k = w->rates; k < w->loops; ++k) w->y[k] = s->before[k] - share * s->step[k];
        int status = mbsri_normalise(m, w->d, w->y);
        if (!status) status = mbsri_start_return_masses(s);
        if (!status) status = aim(s, false, &now);
        if (status < 0) return status;
        if (status) continue;
        const double next = mbsri_start_extent(s, w->x);
        const bool smaller = now.force <= (1.0 - 0.1 * share) * left.force &&
                             now.gap <= fmax(left.gap, 1e-10 * w->m->typical.length);
        if (next > (1.0 - 0.5 * share) * change && next >= close && !(tries >= PATIENT && smaller))
            continue;
        if (tries > 0)
            s->longest = share * change;
        else if (shortened)
            s->longest *= 2.0;
        return MBSR_OK;
    }
    mbsri_copy((size_t)w->size, s->before, w->y);
    return MBSR_NO_CONVERGENCE;
}

int mbsri_start_positions(mbsri_start *s)
{
    static const double enough = 1e-13, near = 1e-8, rounding = 1e-5;
    mbsr_completion *w = s->w;
    double last = INFINITY;
    for (int step = 0; step < s->opt->max_iterations; ++step) {
        defects left;
        int status = aim(s, true, &left);
        if (status) return status;
        const double change = mbsri_start_extent(s, w->x);
        mbsri_copy((size_t)w->size, w->x, s->step);
        if (change <= enough || (change > 0.25 * last && change <= near)) {
            for (int k = w->rates; k < w->loops; ++k) w->y[k] -= w->x[k];
            return MBSR_OK;
        }
        ++s->info->iterations;
        status = advance(s, change, left);
        const bool ended = status == MBSR_NO_CONVERGENCE,
                   there = change <= near && left.gap <= enough * w->m->typical.length;
        if (ended && (there || (change <= rounding && mbsri_start_balances(s))))
            return mbsri_start_evaluate(s, true);
        if (ended) break;
        if (status) return status;
        s->displaced = true;
        last = change;
    }
    return mbsri_completion_fail(w, MBSR_NO_CONVERGENCE, "position");
}
