/* Typical sizes of coordinates and of their rates: see scales.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "massless/scales.h"

#include "algebra/numbers.h"
#include "assembly/measure.h"
#include "flexible/data.h"
#include "recursion/pose.h"
#include "recursion/spans.h"

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

static void fill_scales(int n, const mbsr_coordinate_kind *kind, double rotation,
                        double translation, double *scale)
{
    for (int k = 0; k < n; ++k) {
        const mbsr_coordinate_kind now = k < MOST_KINDS ? kind[k] : MBSR_COORDINATE_OTHER;
        scale[k] = now == MBSR_COORDINATE_ROTATION      ? rotation
                   : now == MBSR_COORDINATE_TRANSLATION ? translation
                                                        : 1.0;
    }
}

/* Modal coordinates: by which a marker moves by the typical length, or turns by 1. */
static void fill_modes(const mbsri_null_space *w, const mbsri_body *b, double *scale)
{
    const mbsr_flex *flex = b->inertia.flex;
    for (int a = 0; a < b->n && flex; ++a) {
        double largest = 0.0;
        for (int k = 0; k < flex->markers; ++k) {
            const double moved = mbsri_largest(3, flex->marker[k].Phi + 3 * a),
                         turned = mbsri_largest(3, flex->marker[k].Psi + 3 * a);
            largest = fmax(largest, fmax(moved / w->size, turned));
        }
        if (largest > 0.0) scale[a] = 1.0 / largest;
    }
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
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        kinds_of(m, i, kq, ku);
        fill_scales(b->nq, kq, 1.0, w->size, w->scale.q + b->q);
        fill_scales(b->n, ku, 1.0, w->size, w->scale.span + b->u);
        if (!b->flexible.modal) continue;
        fill_modes(w, b, w->scale.q + b->q);
        fill_modes(w, b, w->scale.span + b->u);
    }
}

void mbsri_null_rate_scales(mbsri_null_space *w, double natural)
{
    const mbsr_model *m = w->m;
    mbsr_coordinate_kind kq[MOST_KINDS], ku[MOST_KINDS];
    if (!(w->rate_of_tree > 1e-6 * (natural > 0.0 ? natural : 1.0))) w->rate_of_tree = natural;
    const double turning = w->rate_of_tree > 0.0 ? w->rate_of_tree : 1.0,
                 moving = w->rate_of_tree > 0.0 ? w->size * w->rate_of_tree : 1.0;
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        kinds_of(m, i, kq, ku);
        fill_scales(b->n, ku, turning, moving, w->scale.u + b->u);
        for (int c = b->u; c < b->u + b->n && b->flexible.modal; ++c)
            w->scale.u[c] = turning * w->scale.span[c];
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

/* What velocity coordinate c of body b is compared with: the typical length, or 1. */
static double twist_span(const mbsri_null_space *w, const mbsri_body *b, int c)
{
    int at, V, count;
    const bool known = mbsri_translations(b->joint.space, &at, &V, &count);
    return known && c >= V && c < V + count ? w->size : 1.0;
}

double mbsri_twist_size(const mbsri_null_space *w, int i, const double *twist)
{
    const mbsri_body *b = w->m->body + i;
    double largest = 0.0;
    for (int c = 0; c < b->d; ++c)
        largest = fmax(largest, fabs(twist[b->v + (size_t)c]) / twist_span(w, b, c));
    return largest;
}

double mbsri_unit_step(int n, const double *x, const double *y, const double *scale)
{
    double unit = INFINITY;
    for (int k = 0; k < n; ++k) unit = fmin(unit, fmax(scale[k], fabs(y[k])) / fabs(x[k]));
    return isfinite(unit) && unit > 0.0 ? unit : 1.0;
}
