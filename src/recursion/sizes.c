/* Sizes of what is added up to forces.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * What the successors add to a body is found by sending errors of random signs, as large as the
 * forces they are in, through the recursion itself, three times: their mean square is that of the
 * sums. Sums of absolute values would grow with a power of the number of links, as the recursion
 * does not: its projections P = 1 - J G^T are no larger behind a long chain than behind a short
 * one, |1| + |J| |G|^T is. */
#include "recursion/sizes.h"

#include "algebra/dense.h"

#include <math.h>
#include <stdint.h>

/* own (d) += sizes of M V and V x M V, which make up the gyroscopic force h: |M_ab| is at most
 * sqrt(M_aa M_bb). A rigid body's h does not depend on the velocity of its origin; nothing is known
 * of an inertia by function, or in GENERAL space, but h itself, which is in f. */
static void add_gyration(const mbsri_body *b, const mbsr_data *d, double *own)
{
    if (b->joint.space != MBSR_SPACE_SPATIAL || b->inertia.kind == MBSR_INERTIA_FUNCTION) return;
    const bool rigid = b->inertia.kind != MBSR_INERTIA_MATRIX && !b->mass.added;
    const double *M = d->M + b->dd, *V = d->V + b->v;
    double spin = 0.0, sweep = 0.0, size[6];
    for (int k = 0; k < 6; ++k) size[k] = sqrt(fabs(M[7 * k]));
    for (int k = 0; k < 3; ++k) {
        spin += fabs(V[k]);
        sweep += rigid ? 0.0 : fabs(V[3 + k]);
    }
    double energy = 0.0; /* its square root, twice */
    for (int k = 0; k < 3; ++k)
        energy += size[k] * fabs(V[k]) + (rigid ? 0.0 : size[3 + k] * fabs(V[3 + k]));
    const double turn = fmax(size[0], fmax(size[1], size[2])),
                 slide = fmax(size[3], fmax(size[4], size[5]));
    for (int k = 0; k < 3; ++k) {
        own[k] += (spin * turn + sweep * slide) * energy;
        own[3 + k] += spin * slide * energy;
    }
}

/* Arrays of the data that are free between evaluations, one a sample. */
enum { SAMPLES = 3 };

static double *sample_of(const mbsr_data *d, int sample)
{
    return sample == 0 ? d->imp : sample == 1 ? d->sigma : d->Y;
}

double mbsri_sign(int sample, size_t place)
{
    uint32_t x = (uint32_t)place * 2654435761u + (uint32_t)sample * 40503u + 12345u;
    x ^= x >> 16;
    x *= 2246822519u;
    x ^= x >> 13;
    x *= 3266489917u;
    x ^= x >> 16;
    return x & 1u ? 1.0 : -1.0;
}

/* reads f, fbar, mu, M, V, W, kII. */
void mbsri_own_sizes(const mbsr_model *m, const mbsr_data *d, int i, double *own)
{
    const mbsri_body *b = m->body + i;
    const size_t dim = (size_t)b->d;
    const double *W = d->W + b->dd;
    double bias = 0.0;
    for (size_t k = b->v; k < b->v + dim; ++k)
        own[k - b->v] = fabs(d->f[k]) + fabs(d->fbar[k]) + fabs(d->mu[k]);
    add_gyration(b, d, own);
    for (size_t c = 0; c < dim; ++c) bias += sqrt(fabs(W[c * (dim + 1)])) * fabs(d->kII[b->v + c]);
    for (size_t r = 0; r < dim; ++r) own[r] += sqrt(fabs(W[r * (dim + 1)])) * bias;
}

double mbsri_joint_size(const mbsri_body *b, const mbsr_data *d, int k, const double *own)
{
    double size = fabs(d->tau[b->iu + k]);
    for (int r = 0; r < b->d; ++r) size += fabs(d->J[b->dn + (size_t)(k * b->d + r)]) * own[r];
    return size;
}

/* mu of one sample, with what body i makes itself. */
static void sample_force(const mbsri_body *b, const mbsr_data *d, int sample, double *mu)
{
    const double *change = sample_of(d, sample) + b->v, *own = d->Az + b->v;
    for (int r = 0; r < b->d; ++r)
        mu[r] = change[r] + mbsri_sign(sample, b->v + (size_t)r) * own[r];
}

/* G e of the group of one sample, added to mu of its head. */
static void take_up(const mbsr_model *m, const mbsr_data *d, const mbsri_group *g, int sample,
                    double *mu, double *work)
{
    double *e = work, *force = e + g->n;
    for (int k = 0; k < g->members; ++k) {
        const mbsri_body *b = m->body + g->member[k];
        double *own = e + b->group.iu - g->ig;
        for (int l = 0; l < b->n; ++l)
            own[l] = mbsri_sign(sample + SAMPLES, (size_t)(b->iu + l)) *
                     mbsri_joint_size(b, d, l, d->Az + b->v);
        sample_force(b, d, sample, force);
        mbsri_atx(b->d, b->n, -1.0, d->J + b->dn, force, own);
    }
    const mbsri_body *head = m->body + g->member[0];
    mbsri_ax(head->d, g->n, 1.0, d->G + head->dg, e, mu);
}

/* One sample through body i to its predecessor, as mbsri_backward_loads would take it. */
static void pass_sample(const mbsr_model *m, const mbsr_data *d, int i, int sample)
{
    const mbsri_body *b = m->body + i;
    double *mu = d->scratch;
    sample_force(b, d, sample, mu);
    if (mbsri_heads(m, d, i)) {
        const mbsri_group g = mbsri_group_of(m, d, i);
        take_up(m, d, &g, sample, mu, mu + b->d);
    }
    mbsri_atx(b->d, b->pred.d, -1.0, d->H + b->dp, mu, sample_of(d, sample) + b->pred.v);
}

void mbsri_gross_forces(const mbsr_model *m, mbsr_data *d)
{
    for (int l = 0; l < SAMPLES; ++l) mbsri_zero(m->size.v, sample_of(d, l));
    for (int i = m->bodies; i >= 1; --i) {
        mbsri_own_sizes(m, d, i, d->Az + m->body[i].v);
        for (int l = 0; l < SAMPLES; ++l) pass_sample(m, d, i, l);
    }
}

double mbsri_gross_load(const mbsr_model *m, const mbsr_data *d, const mbsri_group *g,
                        const double *x)
{
    double size = 0.0, square = 0.0, load[SAMPLES] = {0.0};
    for (int i = 0; i < g->members; ++i) {
        const mbsri_body *b = m->body + g->member[i];
        const double *own = x + b->group.iu - g->ig;
        for (int k = 0; k < b->n; ++k) {
            size += fabs(own[k]) * mbsri_joint_size(b, d, k, d->Az + b->v);
            const double *J = d->J + b->dn + (size_t)k * (size_t)b->d;
            for (int l = 0; l < SAMPLES; ++l)
                load[l] += own[k] * mbsri_dot(b->d, J, sample_of(d, l) + b->v);
        }
    }
    for (int l = 0; l < SAMPLES; ++l) square += load[l] * load[l] / SAMPLES;
    return size + sqrt(square);
}
