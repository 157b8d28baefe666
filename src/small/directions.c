/* Directions: what the model does against a force on one joint rate, as a function of c.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The Newton matrix is that of motions that change as exp(c t). A joint force f on a coordinate
 * moves it by f / Z(c); for a c far beyond the rates of the slow motion the rest of the model stays
 * where it is, and
 *
 *   Z(c) = k + d c + m c^2.
 *
 * Three values of c give k, d and what inertia there is without the candidates, and Z of the model
 * with them the m that they add. */
#include "small/directions.h"

#include "algebra/dense.h"
#include "small/errors.h"
#include "small/loads.h"
#include "small/twins.h"

#include <math.h>

enum { PROBES = 3 };
static const double probe[PROBES] = {300.0, 3000.0, 30000.0}; /* c times the slow time scale */
static const double largest_ratio = 1e6;

/* Changes of q and u that go with a unit of the coordinate, of s->total that has the rate. */
static void set_pattern(const mbsr_small_masses *s, double c, double rate, double *pattern)
{
    const mbsr_model *m = s->given;
    for (int k = 0; k < s->size; ++k) pattern[k] = -s->work.total[k] / rate;
    for (int k = 0; k < m->nq; ++k) pattern[k] *= c;
}

/* Z of every direction at the factorisation that the twin's solver has, and, unless it is NULL, the
 * pattern that goes with it. */
static int impedances(mbsr_small_masses *s, const mbsri_twin *twin, const double *y,
                      const double *yp, double c, double *Z, int stride, double *pattern)
{
    const mbsr_model *m = s->given;
    int status = mbsri_small_unloaded(s, twin, s->start.t, y, yp), l = 0;
    for (int k = 0; k < s->pushes && !status; ++k) {
        mbsri_pushed *pushed = s->pushed + k;
        const mbsri_body *b = m->body + pushed->i;
        for (int j = 0; j < b->n && !status; ++j, ++l) {
            double *unit = s->work.load;
            mbsri_zero((size_t)b->n, unit);
            unit[j] = 1.0;
            status =
                mbsri_small_column(s, twin, s->start.t, y, yp, &pushed->push, unit, s->work.rhs);
            if (status) return status;
            status = mbsr_newton_solve(twin->newton, s->work.rhs, s->work.total);
            if (status) return mbsri_small_failed(s, status, mbsr_newton_error(twin->newton));
            const double rate =
                -s->work.total[m->nq + m->nu + b->u + j]; /* c times the displacement */
            Z[l * stride] = rate != 0.0 ? c / rate : 0.0;
            if (pattern && rate != 0.0) set_pattern(s, c, rate, pattern + l * s->size);
        }
    }
    return status;
}

static int factor_full(mbsr_small_masses *s, double c)
{
    ++s->factorised.count;
    const int status =
        mbsr_newton_factor(s->full.newton, s->full.data, s->start.t, s->y_full, s->yp_full, c);
    return mbsri_small_failed(s, status, mbsr_newton_error(s->full.newton));
}

/* m, d and k from Z at three c and from that with the masses at the last. */
static void fit_impedance(const double c[PROBES], const double Z[PROBES + 1],
                          mbsr_small_direction *x)
{
    const double slope0 = (Z[1] - Z[0]) / (c[1] - c[0]), slope1 = (Z[2] - Z[1]) / (c[2] - c[1]);
    double rest = (slope1 - slope0) / (c[2] - c[0]);
    if (rest * c[2] * c[2] < 1e-9 * fabs(Z[2])) rest = 0.0; /* rounding, or a k that changes */
    double d = slope0 - rest * (c[0] + c[1]);
    if (d * c[0] < 1e-9 * fabs(Z[0])) d = 0.0;
    const double k = Z[0] - c[0] * (d + c[0] * rest), added = (Z[PROBES] - Z[2]) / (c[2] * c[2]);
    if (!(added > rest)) return; /* the mass is not what the direction has its inertia from */
    x->inertia = added + rest;
    x->damping = d;
    x->stiffness = fabs(k) < 1e-9 * (fabs(Z[0]) + c[0] * d) ? 0.0 : k;
}

/* The fast pair: lambda^2 m + lambda d + k = 0. */
static void roots(double scale, mbsr_small_direction *x)
{
    const double m = x->inertia, d = x->damping, k = fmax(x->stiffness, 0.0);
    if (!(m > 0.0)) return;
    const double square = d * d - 4.0 * k * m, root = sqrt(k * m);
    x->frequency = sqrt(k / m);
    x->damping_ratio = d > 2.0 * largest_ratio * root ? largest_ratio
                       : root > 0.0                   ? d / (2.0 * root)
                                                      : 0.0;
    x->rate = square > 0.0 ? (d + sqrt(square)) / (2.0 * m) : x->frequency;
    x->decay = square > 0.0 ? x->rate : d / (2.0 * m);
    x->fastness = x->rate * scale;
}

int mbsri_small_measure(mbsr_small_masses *s)
{
    const double scale = s->opt.time_scale;
    double c[PROBES];
    int status = MBSR_OK;
    for (int p = PROBES - 1; p >= 0 && !status; --p) {
        c[p] = probe[p] / scale;
        status = mbsri_small_factor(s, s->start.t, s->y, s->yp, c[p]);
        if (!status)
            status = impedances(s, &s->reduced, s->y, s->yp, c[p], s->swings.impedance + p,
                                PROBES + 1, p == PROBES - 1 ? s->swings.pattern : NULL);
    }
    s->slow.c = c[0];
    if (!status) status = factor_full(s, c[PROBES - 1]);
    if (!status)
        status = impedances(s, &s->full, s->y_full, s->yp_full, c[PROBES - 1],
                            s->swings.impedance + PROBES, PROBES + 1, NULL);
    for (int l = 0; l < s->directions && !status; ++l) {
        mbsr_small_direction *x = s->direction + l;
        *x = (mbsr_small_direction){.body = x->body, .coordinate = x->coordinate, .mass = x->mass};
        if (s->candidate[x->mass].keeps_mass) continue;
        fit_impedance(c, s->swings.impedance + l * (PROBES + 1), x);
        roots(scale, x);
    }
    return status;
}

int mbsri_small_displace(mbsr_small_masses *s)
{
    const mbsri_small_formula still = {s->slow.c, {0.0, 0.0}, 0.0};
    const int status = mbsri_small_solve(s, s->start.t, s->y, s->yp, &still);
    for (int k = 0; k < s->candidates && !status; ++k)
        mbsri_copy((size_t)s->size, s->candidate[k].error[0], s->candidate[k].offset);
    return status;
}

/* From where the smooth motion is, the reduced start and what the neglected forces displace. */
void mbsri_small_amplitudes(mbsr_small_masses *s)
{
    const mbsr_model *m = s->given;
    const int nq = m->nq, u = nq + m->nu;
    for (int l = 0; l < s->directions; ++l) {
        mbsr_small_direction *x = s->direction + l;
        const mbsri_body *b = m->body + m->index[x->body];
        const int at = b->u + x->coordinate;
        double position = 0.0, velocity = s->start.u[at] - s->y[u + at];
        const bool plain = b->nq == b->n;
        if (plain) position = s->start.q[b->q + x->coordinate] - s->y[b->q + x->coordinate];
        for (int k = 0; k < s->candidates; ++k) {
            const mbsri_candidate *c = s->candidate + k;
            if (c->keeps_mass) continue;
            if (plain) position -= c->offset[b->q + x->coordinate];
        }
        x->amplitude = x->rate > 0.0 ? hypot(position, velocity / x->rate) : 0.0;
    }
}
