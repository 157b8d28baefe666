/* How a direction that moves no mass answers to rounding: see null_answer.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Rounding of H and J moves body i by a trace delta_i of |H Vz_pi| + |J a|, and the masses behind
 * have to stand still again: the rates of joints before i change, too, those of a joint where the
 * direction begins in what D takes up. A slender body that turns 1e5 times as fast as the joint
 * before it makes its axis matter 1e5 times as much. The changes are those of forward dynamics,
 *
 *   A_i = -H_i A_pi - J_i a_i - delta_i,    a_i of least sum of A^T M A,
 *
 * with random delta, a few times: what cancels for one does not for all. A direction's first rates
 * are rounded apart from the others, though, and these then answer to delta without them, so the
 * joints where it begins are held, too. */
#include "massless/null_answer.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "recursion/backward.h"
#include "recursion/forward.h"
#include "recursion/group.h"

#include <math.h>
#include <stdint.h>

enum { SAMPLES = 4 };

/* Between 1/2 and 1, or the negative of that. */
static double draw(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    const double x = (double)(*state >> 8) / 16777216.0;
    return x < 0.5 ? -1.0 + x : x;
}

/* Whether the direction moves a joint of the group of body i, or what it hangs on. */
static bool takes_part(const mbsr_model *m, const mbsr_data *d, int i, const double *a)
{
    const mbsri_group g = mbsri_group_of(m, d, mbsri_heads(m, d, i) ? i : m->body[i].group.head);
    bool some = d->carries[m->body[g.member[0]].parent];
    for (int k = 0; k < g.members && !some; ++k) {
        const mbsri_body *b = m->body + g.member[k];
        some = mbsri_largest(b->n, a + b->u) > 0.0;
    }
    return some;
}

/* kII = delta, and no forces. */
static void disturb(const mbsr_model *m, mbsr_data *d, int i, const mbsri_lifted *out,
                    uint32_t *state)
{
    const mbsri_body *b = m->body + i;
    double *delta = d->kII + b->v;
    mbsri_zero((size_t)b->d, delta);
    for (int c = 0; c < b->n; ++c) {
        for (int r = 0; r < b->d; ++r)
            delta[r] += fabs(d->J[b->dn + (size_t)(c * b->d + r)] * out->a[b->u + c]);
    }
    for (int c = 0; c < b->pred.d; ++c) {
        for (int r = 0; r < b->d; ++r)
            delta[r] +=
                fabs(d->H[b->dp + (size_t)(c * b->d + r)] * out->twist[b->pred.v + (size_t)c]);
    }
    mbsri_null_spread(b, delta);
    for (int r = 0; r < b->d; ++r) delta[r] *= MBSRI_NULL_ROUNDING * draw(state);
    mbsri_zero((size_t)b->n, d->tau + b->iu);
    mbsri_zero((size_t)b->d, d->fbar + b->v);
    mbsri_zero((size_t)b->pred.d, d->fbar + b->pred.v);
    mbsri_zero((size_t)b->pred.d, d->A + b->pred.v);
}

/* The errors and the changes of a group: the root of the sum of squares. */
static void add(const mbsr_model *m, const mbsr_data *d, const mbsri_group *g, const double *rate,
                const mbsri_lifted *out)
{
    for (int k = 0; k < g->members; ++k) {
        const mbsri_body *b = m->body + g->member[k];
        double *error = out->a_error + b->u, *twist_error = out->twist_error + b->v;
        for (int c = 0; c < b->n; ++c) error[c] = hypot(error[c], rate[b->group.iu - g->ig + c]);
        for (int r = 0; r < b->d && d->carries[g->member[k]]; ++r)
            twist_error[r] = hypot(twist_error[r], d->A[b->v + (size_t)r]);
    }
}

/* The changes of all groups; held: those where the direction begins keep its rates, which may have
 * been rounded, and the joints behind answer as they do in the lift. */
static void add_changes(const mbsr_model *m, mbsr_data *d, int j, bool held,
                        const mbsri_lifted *out)
{
    double *w = d->scratch + m->most.d, *rate = w + m->most.n;
    for (int i = j; i <= m->bodies; ++i) {
        if (!mbsri_heads(m, d, i) || !takes_part(m, d, i, out->a)) continue;
        const mbsri_group g = mbsri_group_of(m, d, i);
        if (held && i == j) mbsri_zero((size_t)g.n, d->e + g.ig);
        mbsri_known_part(m, d, &g, w, rate);
        add(m, d, &g, rate, out);
    }
}

void mbsri_null_answer(const mbsr_model *m, mbsr_data *d, int j, const mbsri_lifted *out)
{
    uint32_t state = 1;
    for (int sample = 0; sample < SAMPLES; ++sample) {
        for (int i = j; i <= m->bodies; ++i) {
            if (takes_part(m, d, i, out->a)) disturb(m, d, i, out, &state);
        }
        for (int i = m->bodies; i >= j; --i) {
            if (takes_part(m, d, i, out->a)) mbsri_load_joint(m, d, i);
        }
        add_changes(m, d, j, false, out);
        add_changes(m, d, j, true, out);
    }
    mbsri_null_drop((size_t)m->nu, out->a, out->a_error);
    mbsri_null_drop(m->size.v, out->twist, out->twist_error);
}
