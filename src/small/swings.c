/* The fast motion along a run, and the steps that masses cost.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Beside the smooth motion a direction moves by x, with w the neglected force along it,
 *
 *   m x'' + d x' + k x = w(t),    x = a + conj a (or a + a2),    a' = L a + g w,
 *       g = 1 / (m (L - L2))
 *
 * L, L2 the fast pair. What of a follows w slowly is no swing: -g w / L, and so on with w' / L^2.
 * For b = a + g w / L, and w over a step of length h the parabola from w0 to w1 with the mean w1/2
 * + w0/2 + e, which is that of the mean acceleration, so that jumps of rates count,
 *
 *   b' = L b + (g / L) w',   b1 = exp(z) b0 + (g / L) ((w1 - w0) f1 + 6 e (f1 - 2 f2)),   z = L h,
 *   f1 = (exp(z) - 1) / z,   f2 = (f1 - 1) / z.
 *
 * The swing is the smaller of b and b + g w' / L^2: an asymptotic series as far as it gets smaller.
 */
#include "small/swings.h"

#include "algebra/dense.h"
#include "base/error.h"
#include "recursion/data.h"
#include "small/loads.h"
#include "small/twins.h"

#include <complex.h>
#include <math.h>

bool mbsri_small_is_fast(const mbsr_small_direction *x)
{
    static const double slowest = 10.0; /* rate times slow time scale */
    return x->fastness >= slowest;
}

/* ---- steps ---- */

/* Positions and momenta are tested, and momenta in tolerances of the inertia that the joint moves
 * with its masses (mbsr_momentum_scales); 4 and the 4.5 below are the driver's numbers, as
 * measured. */
double mbsri_small_swing_size(const mbsr_small_masses *s, int l, double amplitude)
{
    const mbsr_small_direction *x = s->direction + l;
    const mbsr_small_masses_opt *o = &s->opt;
    const double speed = amplitude * x->rate,
                 velocity = o->atol_velocity > 0.0 ? o->atol_velocity : o->atol,
                 in_q = amplitude / (o->atol + o->rtol * amplitude),
                 in_p = x->inertia / fmax(s->swings.scale[l], x->inertia) * speed /
                        (velocity + o->rtol * speed);
    return fmax(in_q, 4.0 * in_p);
}

/* An error of a size in tolerances allows steps of a phase (4.5 / size)^(1/6):
 *
 *   integral of rate / phase dt    while the size is above 1. */
double mbsri_small_swing_steps(const mbsr_small_direction *x, double first, double last,
                               double time)
{
    static const double order = 6.0;
    double steps = 0.0, dying = 0.0;
    last = fmax(last, first * exp(-x->decay * time));
    if (first > 1.0 && x->decay * time > 1e-3 && first > last) {
        const double end = fmax(last, 1.0);
        dying = fmin(time, log(first / end) / x->decay);
        steps = order * x->rate / x->decay *
                (pow(first / 4.5, 1.0 / order) - pow(end / 4.5, 1.0 / order));
    }
    if (last > 1.0) steps += x->rate * (time - dying) * pow(last / 4.5, 1.0 / order);
    return steps;
}

/* ---- forces along directions ---- */

/* out (nu): generalised forces of the loads -force, -rest or -mean on the candidates. */
static void along_joints(mbsr_small_masses *s, int which, double *out)
{
    const mbsr_model *m = s->reduced.model;
    mbsr_data *d = s->reduced.data;
    d->accelerated = false; /* mu is scratch */
    mbsri_zero((size_t)m->root.d, d->mu);
    for (int i = 1; i <= m->bodies; ++i) mbsri_zero((size_t)m->body[i].d, d->mu + m->body[i].v);
    for (int k = 0; k < s->candidates; ++k) {
        const mbsri_candidate *c = s->candidate + k;
        const mbsri_body *b = m->body + c->i;
        const double *const load[] = {c->force, c->rest, c->mean};
        if (!c->keeps_mass) mbsri_copy((size_t)b->d, load[which], d->mu + b->v);
    }
    mbsri_zero((size_t)m->nu, out);
    for (int i = m->bodies; i >= 1; --i) {
        const mbsri_body *b = m->body + i;
        mbsri_atx(b->d, b->n, 1.0, d->J + b->dn, d->mu + b->v, out + b->u);
        mbsri_atx(b->d, b->pred.d, -1.0, d->H + b->dp, d->mu + b->v, d->mu + b->pred.v);
    }
}

static void all_along_joints(mbsr_small_masses *s)
{
    for (int k = 0; k < 3; ++k) along_joints(s, k, s->rates.along[k]);
}

/* What acts along a direction: by the motion that goes with it while all masses stay. */
static double swing_force_along(const mbsr_small_masses *s, int l, const double *forces)
{
    const mbsr_model *m = s->given;
    const double *pattern = s->swings.pattern + (size_t)l * (size_t)s->size + m->nq + m->nu;
    double sum = 0.0;
    for (int k = 0; k < m->nu; ++k) sum += pattern[k] * forces[k];
    return sum;
}

/* ---- the fast motion ---- */

typedef struct pair {
    double complex first, gain; /* L, g */
    double parts;               /* x = parts Re a, in amplitude */
} pair;

/* g is bounded where the two are close: there it stands for what both do together. */
static pair pair_of(const mbsr_small_direction *x)
{
    static const double apart = 0.5;
    const double half = 0.5 * x->damping / x->inertia,
                 square = half * half - fmax(x->stiffness, 0.0) / x->inertia,
                 root = fmax(sqrt(fabs(square)), 0.5 * apart * x->rate);
    if (square > 0.0) return (pair){-x->rate, -1.0 / (2.0 * x->inertia * root), 1.0};
    return (pair){-half + I * sqrt(-square), 1.0 / (2.0 * I * x->inertia * root), 2.0};
}

/* f1, f2 */
static void growth(double complex z, double complex f[2])
{
    if (cabs(z) < 1e-3) {
        f[0] = 1.0 + z * (0.5 + z / 6.0);
        f[1] = 0.5 + z * (1.0 / 6.0 + z / 24.0);
        return;
    }
    f[0] = (cexp(z) - 1.0) / z;
    f[1] = (f[0] - 1.0) / z;
}

/* Over a step to the load w, with the mean load; the amplitude of the swing. What is not fast
 * swings as it starts: what drives it cannot be told from the slow motion. */
static double swing_on(mbsri_swing *y, const mbsr_small_direction *x, double w, double mean,
                       double h)
{
    const pair p = pair_of(x);
    const double complex z = p.first * h, lag = mbsri_small_is_fast(x) ? p.gain / p.first : 0.0;
    const double rise = w - y->load, more = mean - 0.5 * (w + y->load);
    double complex f[2];
    growth(z, f);
    const double complex b =
        cexp(z) * (y->re + I * y->im) + lag * (rise * f[0] + 6.0 * more * (f[0] - 2.0 * f[1]));
    const double complex late = lag / z * (rise - 6.0 * more);
    y->re = creal(b);
    y->im = cimag(b);
    y->load = w;
    return p.parts * fmin(cabs(b), cabs(b + late));
}

/* ---- what smooth momenta cost ---- */

/* By how many more steps than without the masses the momentum of each direction, whose change over
 * a step is the same, asks for: it is tested in tolerances of its own joint's scale. */
static void test_momenta(mbsr_small_masses *s, const double *y)
{
    const mbsr_model *m = s->given;
    const mbsr_small_masses_opt *o = &s->opt;
    const double velocity = o->atol_velocity > 0.0 ? o->atol_velocity : o->atol;
    double most = 0.0;
    for (int k = 0; k < m->nu; ++k) {
        const double change = fabs(y[m->nq + k] - s->rates.momentum[k]);
        s->rates.tested[k] = change / (velocity + o->rtol * fabs(y[m->nq + m->nu + k]));
        most = fmax(most, s->rates.tested[k] / s->rates.scale[k]);
        s->rates.momentum[k] = y[m->nq + k];
    }
    for (int k = 0; k < m->nu; ++k)
        s->rates.tested[k] = most > 0.0 ? s->rates.tested[k] / most : 0.0;
}

/* ---- along the run ---- */

/* Into the steps of each mass, and of all. */
static void count(mbsr_small_masses *s, double time)
{
    const mbsr_model *m = s->given;
    double most = 0.0;
    for (int k = 0; k < s->candidates; ++k) s->candidate[k].now = 0.0;
    for (int l = 0; l < s->directions; ++l) {
        const mbsr_small_direction *x = s->direction + l;
        mbsri_swing *y = s->swings.each + l;
        double *now = &s->candidate[x->mass].now;
        if (!(x->rate > 0.0)) continue;
        const mbsri_body *b = m->body + m->index[x->body];
        const double share = s->rates.tested[b->u + x->coordinate] / s->swings.scale[l];
        *now = fmax(*now, mbsri_small_swing_steps(x, y->before, y->size, time));
        if (share > 1.0) *now = fmax(*now, pow(share, 1.0 / 6.0) - 1.0);
    }
    for (int k = 0; k < s->candidates; ++k) {
        mbsri_candidate *c = s->candidate + k;
        c->steps += c->now;
        most = fmax(most, c->now);
    }
    s->zeros.saved += most;
}

int mbsri_small_swings_begin(mbsr_small_masses *s)
{
    const mbsr_model *m = s->given;
    int status = mbsri_small_forces(s, s->start.t, s->y, s->yp);
    if (!status) status = mbsri_small_split(s, s->start.t, s->y, 0.0);
    if (status) return status;
    all_along_joints(s);
    for (int l = 0; l < s->directions; ++l) {
        const mbsr_small_direction *x = s->direction + l;
        mbsri_swing *y = s->swings.each + l;
        *y = (mbsri_swing){.load = swing_force_along(s, l, s->rates.along[0]),
                           .rest = swing_force_along(s, l, s->rates.along[1])};
        if (!(x->rate > 0.0)) continue;
        y->re = x->amplitude / pair_of(x).parts;
        y->size = mbsri_small_swing_size(s, l, x->amplitude);
    }
    for (int k = 0; k < s->candidates; ++k) s->candidate[k].steps = 0.0;
    mbsri_copy((size_t)m->nu, s->y + m->nq, s->rates.momentum);
    s->zeros.saved = 0.0;
    return MBSR_OK;
}

int mbsri_small_swings_follow(mbsr_small_masses *s, double t, const double *y)
{
    const double h = t - s->run.t[0];
    const int status = mbsri_small_split(s, t, y, h);
    if (status) return status;
    all_along_joints(s);
    for (int l = 0; l < s->directions; ++l) {
        mbsr_small_direction *x = s->direction + l;
        mbsri_swing *z = s->swings.each + l;
        const double rest = swing_force_along(s, l, s->rates.along[1]);
        z->before = z->size;
        if (x->rate > 0.0) {
            const double mean = 0.5 * (z->rest + rest) + swing_force_along(s, l, s->rates.along[2]),
                         swing =
                             swing_on(z, x, swing_force_along(s, l, s->rates.along[0]), mean, h);
            if (!isfinite(swing))
                return mbsri_fail(&s->error, MBSR_NOT_FINITE, x->body, MBSR_NONE,
                                  "body %d: its fast motion is not finite at t = %g", x->body, t);
            x->amplitude = fmax(x->amplitude, swing);
            z->size = mbsri_small_swing_size(s, l, swing);
        }
        z->rest = rest;
    }
    test_momenta(s, y);
    count(s, h);
    return MBSR_OK;
}
