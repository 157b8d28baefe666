/* Over what size functions change: see spans.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "recursion/spans.h"

#include "joints/flexible.h"
#include "model/query.h"
#include "recursion/data.h"
#include "recursion/pose.h"

#include <math.h>

static double first_of(double stated, double typical, double otherwise)
{
    return stated > 0.0 ? stated : typical > 0.0 ? typical : otherwise;
}

mbsri_spans mbsri_spans_of(const mbsr_model *m, const mbsr_scales *stated)
{
    static const mbsr_scales none = {0.0, 0.0, 0.0, 0.0};
    const mbsr_scales *own = stated ? stated : &none;
    return (mbsri_spans){.length = first_of(own->length, m->typical.length, 1.0),
                         .angle = first_of(own->angle, 1.0, 1.0),
                         .other = own->other,
                         .rate = own->time > 0.0 ? 1.0 / own->time : m->typical.frequency};
}

double mbsri_pose_span(const mbsri_spans *s, const mbsri_body *b, int c)
{
    const bool modal = b->joint.space == MBSR_SPACE_FLEXIBLE && c >= 6,
               known = modal && b->inertia.kind == MBSR_INERTIA_FLEXIBLE;
    if (b->joint.space == MBSR_SPACE_GENERAL || modal)
        return first_of(s->other, b->joint.table ? b->joint.table->scales.other : 0.0,
                        known ? mbsr_flex_span(b->inertia.flex, c - 6, s->length) : 1.0);
    return mbsri_is_angle(b->joint.space, c) ? s->angle : s->length;
}

double mbsri_coordinate_span(const mbsri_spans *s, const mbsr_model *m, const mbsri_body *b,
                             bool velocity, int k)
{
    switch (mbsri_coordinate_kind(b, velocity, k)) {
    case MBSR_COORDINATE_ROTATION: return s->angle;
    case MBSR_COORDINATE_TRANSLATION: return s->length;
    case MBSR_COORDINATE_OTHER: break;
    }
    const mbsr_flex *modes = mbsri_mount_of(b->joint.table, b->joint.user);
    const double own = modes ? mbsr_flex_span(modes, mbsri_place_of_free(b, k), s->length)
                       : m->typical.span ? m->typical.span[velocity ? m->nq + b->u + k : b->q + k]
                                         : 1.0;
    return first_of(s->other, b->joint.table->scales.other, own);
}

double mbsri_twist_rate(const mbsri_spans *s, const mbsri_body *b, const double *V)
{
    double rate = 0.0;
    for (int c = 0; c < b->d; ++c) rate = fmax(rate, fabs(V[c]) / mbsri_pose_span(s, b, c));
    return rate;
}

double mbsri_largest_rate(const mbsr_model *m, const double *x)
{
    const mbsri_spans s = mbsri_spans_of(m, NULL);
    double largest = 0.0;
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        for (int k = 0; k < b->n; ++k)
            largest = fmax(largest, fabs(x[b->u + k]) / mbsri_coordinate_span(&s, m, b, true, k));
    }
    return largest;
}

double mbsri_joint_load(const mbsri_spans *s, const mbsr_model *m, const mbsri_body *b,
                        const double *tau)
{
    double largest = 0.0;
    for (int k = 0; k < b->n; ++k)
        largest = fmax(largest, fabs(tau[k]) * mbsri_coordinate_span(s, m, b, true, k));
    return largest;
}

double mbsri_lever_of(const mbsri_body *b, const double *H)
{
    double lever = 0.0;
    for (int c = 0; c < b->pred.d; ++c, H += b->d) {
        for (int r = 0; r < b->d && mbsri_is_angle(b->pred.space, c); ++r)
            lever = fmax(lever, mbsri_is_angle(b->joint.space, r) ? 0.0 : fabs(H[r]));
    }
    return lever;
}

double mbsri_way_of(const mbsr_data *d, const mbsri_body *b)
{
    const bool fixed = b->pred.space == MBSR_SPACE_FIXED;
    const double *p = d->p + b->p, *from = d->p + b->pred.p;
    int at, V, count, at_pred = 0, count_pred = 3;
    double largest = 0.0;
    if (!mbsri_translations(b->joint.space, &at, &V, &count)) return 0.0;
    if (!fixed && !mbsri_translations(b->pred.space, &at_pred, &V, &count_pred)) return 0.0;
    for (int k = 0; k < count && k < count_pred; ++k)
        largest = fmax(largest, fabs(p[at + k] - (fixed ? 0.0 : from[at_pred + k])));
    return largest;
}

double mbsri_span_rate(const mbsri_spans *s)
{
    return s->rate > 0.0 ? s->rate : 1.0;
}

double mbsri_rate_span(const mbsri_spans *s, const mbsr_model *m, const mbsri_body *b, int k)
{
    return mbsri_span_rate(s) * mbsri_coordinate_span(s, m, b, true, k);
}

double mbsri_rate_step(const mbsr_model *m, const double *x, const double *u)
{
    const mbsri_spans s = mbsri_spans_of(m, NULL);
    double least = INFINITY;
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        for (int k = 0; k < b->n; ++k) {
            const double span = mbsri_rate_span(&s, m, b, k);
            least = fmin(least, fmax(span, fabs(u[b->u + k])) / fabs(x[b->u + k]));
        }
    }
    return isfinite(least) && least > 0.0 ? least : 1.0;
}
