/* Which of the directions of a kind a report shows.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "massless/report_parts.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "massless/element_reaction.h"
#include "massless/scales.h"

#include <math.h>

/* weights (k) of the component's directions with weights x (c), but for those that add less than
 * 1e-6 of the largest joint rate: reports leave such rates out, and list no elements for them. */
static void spread(mbsri_report *r, int c, const double *x, double *weights)
{
    const mbsri_null_space *w = &r->w;
    double *size = r->sizes, largest = 0.0;
    mbsri_zero((size_t)w->k, weights);
    for (int a = 0; a < c; ++a) {
        const int l = r->member[a];
        const double *u = w->direction + (size_t)l * (size_t)w->m->nu;
        size[a] = 0.0;
        for (int k = w->from[l]; k < w->to[l] && x[a] != 0.0; ++k)
            size[a] = fmax(size[a], fabs(x[a] * u[k]) / w->scale.span[k]);
        largest = fmax(largest, size[a]);
    }
    for (int a = 0; a < c; ++a) {
        if (size[a] >= 1e-6 * largest) weights[r->member[a]] = x[a];
    }
}

/* What rates of a direction, in r->u, count from: 1e-6 of the largest, velocities compared with
 * angular rates times the typical length. */
static double report_least(const mbsri_report *r)
{
    double size = 0.0;
    for (int k = 0; k < r->w.m->nu; ++k) size = fmax(size, fabs(r->u[k]) / r->w.scale.span[k]);
    return 1e-6 * size;
}

/* Clears u and q_rate at joints whose rates do not count, and the twists of bodies that move as
 * little. */
static void drop_rates(mbsri_report *r)
{
    const mbsr_model *m = r->w.m;
    const double least = report_least(r);
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        double size = 0.0;
        for (int k = b->u; k < b->u + b->n; ++k)
            size = fmax(size, fabs(r->u[k]) / r->w.scale.span[k]);
        if (mbsri_twist_size(&r->w, i, r->twist) < least) mbsri_zero((size_t)b->d, r->twist + b->v);
        if (size >= least) continue;
        mbsri_zero((size_t)b->n, r->u + b->u);
        mbsri_zero((size_t)b->nq, r->q_rate + b->q);
    }
}

void mbsri_report_combine(mbsri_report *r, const double *weights)
{
    mbsri_null_mix(&r->w, MBSRI_NULL_RATES, weights, r->u, r->size);
    mbsri_null_mix(&r->w, MBSRI_NULL_TWISTS, weights, r->twist, r->size);
    mbsri_null_mix(&r->w, MBSRI_NULL_SHIFTS, weights, r->q_rate, r->size);
    drop_rates(r);
}

/* Notes in `seen` which elements determine the direction of this kind in u, twist and q_rate,
 * `share` and `least` as in mbsri_element_resists; their number in *count. */
static int find_seen(mbsri_report *r, mbsr_direction_kind kind, double share, double least,
                     int *count)
{
    const mbsr_model *m = r->w.m;
    const mbsri_force *force = m->forces.data;
    int status = MBSR_OK;
    *count = 0;
    for (size_t k = 0; k < m->forces.count && !status; ++k) {
        r->determining[k] = false;
        if (kind != MBSR_DIRECTION_UNDETERMINED)
            status = mbsri_element_resists(&r->w, force + k, r->u, r->twist, r->q_rate,
                                           kind == MBSR_DIRECTION_DAMPED, share, least,
                                           r->determining + k);
        *count += r->determining[k];
    }
    return status;
}

int mbsri_report_see(mbsri_report *r, mbsr_direction_kind kind, int *count)
{
    static const double some = 1e-6, any = 1e-11;
    r->least = report_least(r);
    int status = find_seen(r, kind, some, r->least, count);
    if (status || *count > 0) return status;
    status = find_seen(r, kind, any, 0.0, count);
    if (*count > 0) r->least *= any / some;
    return status;
}

/* listed: the bodies on which elements act that determine the direction of this kind in u, twist
 * and q_rate; the number of these elements. */
static int list_bodies(mbsri_report *r, mbsr_direction_kind kind, int *elements)
{
    const mbsr_model *m = r->w.m;
    const mbsri_force *force = m->forces.data;
    const int status = mbsri_report_see(r, kind, elements);
    for (int i = 0; i <= m->bodies; ++i) r->listed[i] = false;
    for (size_t k = 0; k < m->forces.count; ++k) {
        for (int l = 0; l < force[k].def.bodies && r->determining[k]; ++l)
            r->listed[m->stored.list_index[force[k].list + (size_t)l]] = true;
    }
    return status;
}

/* How many of the bodies listed have rates in u (nu). */
static int count_listed(const mbsri_report *r, const double *u)
{
    int count = 0;
    for (int i = 1; i <= r->w.m->bodies; ++i) {
        const mbsri_body *b = r->w.m->body + i;
        count += r->listed[i] && mbsri_largest(b->n, u + b->u) > 0.0;
    }
    return count;
}

static int count_terms(const mbsr_model *m, const double *u)
{
    int count = 0;
    for (int k = 0; k < m->nu; ++k) count += u[k] != 0.0;
    return count;
}

int mbsri_report_add_shorter(mbsri_report *r, int c, const double *x, const double *sparse,
                             mbsr_direction_kind kind)
{
    const mbsr_model *m = r->w.m;
    double *weights = r->weights + (size_t)r->found * (size_t)r->w.k;
    r->kind[r->found++] = kind;
    spread(r, c, x, weights);
    mbsri_report_combine(r, weights);
    const int terms = count_terms(m, r->u);
    if (!sparse || terms <= 2) return MBSR_OK;
    int elements = 0;
    const int status = list_bodies(r, kind, &elements);
    if (status) return status;
    const int moved = count_listed(r, r->u);
    spread(r, c, sparse, weights);
    mbsri_null_mix(&r->w, MBSRI_NULL_RATES, weights, r->other, r->size);
    if (count_terms(m, r->other) >= terms || count_listed(r, r->other) < moved)
        spread(r, c, x, weights);
    return MBSR_OK;
}

void mbsri_report_add(mbsri_report *r, int c, const double *x, mbsr_direction_kind kind)
{
    r->kind[r->found] = kind;
    spread(r, c, x, r->weights + (size_t)r->found++ * (size_t)r->w.k);
}

/* y (c) less its share in the first n columns of r->Y. */
static void take_out(const mbsri_report *r, int c, int n, double *y)
{
    for (int turn = 0; turn < 2; ++turn) {
        for (int l = 0; l < n; ++l) {
            const double *Q = r->Y + l * c, share = mbsri_dot(c, Q, y);
            for (int a = 0; a < c; ++a) y[a] -= share * Q[a];
        }
    }
}

void mbsri_report_unseen(mbsri_report *r, int c, int n, const double *N)
{
    for (int a = 0; a < c; ++a) r->span[a] = mbsri_direction_size(&r->w, r->member[a]);
    for (int l = 0; l < n; ++l) {
        double *y = r->Y + l * c;
        for (int a = 0; a < c; ++a) y[a] = N[l * c + a] * r->span[a];
        take_out(r, c, l, y);
        const double length = sqrt(mbsri_dot(c, y, y));
        for (int a = 0; a < c && length > 0.0; ++a) y[a] /= length;
    }
}

void mbsri_report_part(mbsri_report *r, int c, int n, int shown, double *x)
{
    static const double little = 1e-4;
    double *y = r->Y + (n + shown) * c;
    for (int a = 0; a < c; ++a) y[a] = x[a] * r->span[a];
    take_out(r, c, n, y);
    const double all = sqrt(mbsri_dot(c, y, y));
    take_out(r, c, n + shown, y);
    const double left = sqrt(mbsri_dot(c, y, y));
    for (int a = 0; a < c && left > 0.0; ++a) {
        if (left < little * all) x[a] = y[a] / r->span[a];
        y[a] /= left;
    }
}

/* How much of what determines a direction with these weights is seen in it: elements, and bodies of
 * theirs that it moves. */
static int count_seen(mbsri_report *r, const double *weights, mbsr_direction_kind kind, int *seen)
{
    mbsri_report_combine(r, weights);
    int elements = 0;
    const int status = list_bodies(r, kind, &elements);
    *seen = elements * (r->w.m->bodies + 1) + count_listed(r, r->u);
    return status;
}

int mbsri_report_choose(mbsri_report *r, int c, const double *x, int n, mbsr_direction_kind kind)
{
    double *weights = r->weights + (size_t)r->found * (size_t)r->w.k, *other = r->other_x;
    int seen, seen_in_other;
    r->kind[r->found++] = kind;
    spread(r, c, x, weights);
    if (n == 0) return MBSR_OK;
    int status = count_seen(r, weights, kind, &seen);
    if (status) return status;
    for (int a = 0; a < c; ++a) other[a] = x[a] * r->span[a];
    take_out(r, c, n, other);
    const double least = 1e-10 * mbsri_largest(c, other);
    for (int a = 0; a < c; ++a) other[a] = fabs(other[a]) > least ? other[a] / r->span[a] : 0.0;
    spread(r, c, other, weights);
    status = count_seen(r, weights, kind, &seen_in_other);
    if (!status && seen_in_other <= seen) spread(r, c, x, weights);
    return status;
}
