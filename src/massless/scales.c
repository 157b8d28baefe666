/* Typical sizes of coordinates and of their rates: see scales.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "massless/scales.h"

#include "algebra/numbers.h"
#include "assembly/measure.h"
#include "model/query.h"
#include "recursion/pose.h"

#include <math.h>
#include <string.h>

enum { MOST_KINDS = 64 };

/* Distance of body i's origin from the predecessor's; its centre of mass and radius of gyration,
 * from M = [J, m cx; -m cx, m] or the like. */
static double body_length(const mbsr_model *m, const mbsr_data *d, int i)
{
    const mbsri_body *b = m->body + i;
    const double *M = d->M + b->dd;
    int at, V, count;
    double largest = b->pred.space == MBSR_SPACE_FIXED ? 0.0 : mbsri_way_of(d, b);
    if (!mbsri_translations(b->joint.space, &at, &V, &count)) return 0.0;
    const double mass = M[(V + 1) * b->d + V + 1];
    for (int k = 0; k < b->d && mass > 0.0; ++k) {
        if (k >= V && k < V + count) continue;
        largest = fmax(largest, sqrt(fabs(M[k * b->d + k]) / mass));
    }
    return largest;
}

/* force / mass of body i, along its translations. */
static double body_acceleration(const mbsr_model *m, const mbsr_data *d, int i)
{
    const mbsri_body *b = m->body + i;
    int at, V, count;
    double largest = 0.0;
    if (!mbsri_translations(b->joint.space, &at, &V, &count)) return 0.0;
    for (int k = V; k < V + count && k < b->d; ++k) {
        const double mass = d->M[b->dd + (size_t)(k * b->d + k)];
        if (mass > 0.0) largest = fmax(largest, fabs(d->f[b->v + (size_t)k]) / mass);
    }
    return largest;
}

/* Kinds of the coordinates of body i. */
static void kinds_of(const mbsr_model *m, int i, mbsr_coordinate_kind *q, mbsr_coordinate_kind *u)
{
    const mbsri_body *b = m->body + i;
    for (int k = 0; k < MOST_KINDS; ++k) q[k] = u[k] = MBSR_COORDINATE_OTHER;
    if (b->nq <= MOST_KINDS && b->n <= MOST_KINDS) mbsr_body_coordinate_kinds(m, b->id, q, u);
}

/* Largest of the coordinates x of one kind. */
static double largest_of(int n, const double *x, const mbsr_coordinate_kind *kind,
                         mbsr_coordinate_kind wanted)
{
    double largest = 0.0;
    for (int k = 0; k < n && k < MOST_KINDS; ++k) {
        if (kind[k] == wanted) largest = fmax(largest, fabs(x[k]));
    }
    return largest;
}

mbsri_spans mbsri_null_spans(const mbsri_null_space *w)
{
    return (mbsri_spans){.length = w->size, .angle = 1.0};
}

void mbsri_null_scales(mbsri_null_space *w, const double *q, const double *u)
{
    const mbsr_model *m = w->m;
    mbsr_coordinate_kind kq[MOST_KINDS], ku[MOST_KINDS];
    double length = 0.0, spin = 0.0, speed = 0.0, acceleration = 0.0;
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        kinds_of(m, i, kq, ku);
        length = fmax(length, body_length(m, w->d, i));
        length = fmax(length, largest_of(b->nq, q + b->q, kq, MBSR_COORDINATE_TRANSLATION));
        spin = fmax(spin, largest_of(b->n, u + b->u, ku, MBSR_COORDINATE_ROTATION));
        speed = fmax(speed, largest_of(b->n, u + b->u, ku, MBSR_COORDINATE_TRANSLATION));
        acceleration = fmax(acceleration, body_acceleration(m, w->d, i));
    }
    const mbsri_force *force = m->forces.data;
    for (size_t k = 0; k < m->forces.count; ++k)
        length = fmax(length, mbsri_force_length(&force[k].def));
    w->size = length > 1e-12 ? length : 1.0; /* less is what rounding leaves of zero */
    w->rate_of_tree = fmax(spin, fmax(speed / w->size, sqrt(acceleration / w->size)));
    if (!isfinite(w->rate_of_tree)) w->rate_of_tree = 0.0;
    const mbsri_spans spans = mbsri_null_spans(w);
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        for (int k = 0; k < b->nq; ++k)
            w->scale.q[b->q + k] = mbsri_coordinate_span(&spans, m, b, false, k);
        for (int k = 0; k < b->n; ++k)
            w->scale.span[b->u + k] = mbsri_coordinate_span(&spans, m, b, true, k);
    }
}

void mbsri_null_rate_scales(mbsri_null_space *w, double natural)
{
    const mbsr_model *m = w->m;
    if (!(w->rate_of_tree > 1e-6 * (natural > 0.0 ? natural : 1.0))) w->rate_of_tree = natural;
    const bool known = w->rate_of_tree > 0.0;
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        for (int k = 0; k < b->n; ++k) {
            const bool moves = mbsri_coordinate_kind(b, true, k) == MBSR_COORDINATE_TRANSLATION;
            const double span = w->scale.span[b->u + k];
            w->scale.u[b->u + k] = known ? w->rate_of_tree * span : moves ? 1.0 : span;
        }
    }
}

double mbsri_direction_size(const mbsri_null_space *w, int l)
{
    const size_t nu = (size_t)w->m->nu;
    const double *u = w->direction + (size_t)l * nu;
    double largest = 0.0;
    for (size_t k = 0; k < nu; ++k) largest = fmax(largest, fabs(u[k]) / w->scale.span[k]);
    return largest;
}

double mbsri_twist_size(const mbsri_null_space *w, int i, const double *twist)
{
    const mbsri_body *b = w->m->body + i;
    const mbsri_spans spans = mbsri_null_spans(w);
    double largest = 0.0;
    for (int c = 0; c < b->d; ++c)
        largest = fmax(largest, fabs(twist[b->v + (size_t)c]) / mbsri_pose_span(&spans, b, c));
    return largest;
}

double mbsri_unit_step(int n, const double *x, const double *y, const double *scale)
{
    double unit = INFINITY;
    for (int k = 0; k < n; ++k) unit = fmin(unit, fmax(scale[k], fabs(y[k])) / fabs(x[k]));
    return isfinite(unit) && unit > 0.0 ? unit : 1.0;
}
