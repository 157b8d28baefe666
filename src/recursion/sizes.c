/* Sizes of what is added up to forces.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "recursion/sizes.h"

#include <math.h>

/* own (d) += sizes of M V and V x M V, which make up the gyroscopic force h: |M_ab| is at most
 * sqrt(M_aa M_bb). A rigid body's h does not depend on the velocity of its origin; nothing is known of
 * an inertia by function, or in GENERAL space, but h itself, which is in f. */
static void add_gyration(const mbsri_body *b, const mbsr_data *d, double *own)
{
    if (b->joint.space != MBSR_SPACE_SPATIAL || b->inertia.kind == MBSR_INERTIA_FUNCTION) return;
    const bool rigid = b->inertia.kind != MBSR_INERTIA_MATRIX && !b->added;
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

/* |f|, the bias forces with what was added up to Mbar (W, backward.c), and what successors pass on.
 * reads f, tau, V, M, kII, W, J, G, H;  writes Az. */
void mbsri_gross_forces(const mbsr_model *m, mbsr_data *d)
{
    double *gross = d->Az;
    for (size_t k = 0; k < m->size_v; ++k) gross[k] = fabs(d->f[k]);
    for (int i = m->bodies; i >= 1; --i) {
        const mbsri_body *b = m->body + i;
        const size_t dim = (size_t)b->d, columns = (size_t)b->d_pred;
        double *own = gross + b->v, *pred = gross + b->pred_v;
        const double *W = d->W + b->dd;
        double bias = 0.0;
        add_gyration(b, d, own);
        for (size_t c = 0; c < dim; ++c)
            bias += sqrt(fabs(W[c * (dim + 1)])) * fabs(d->kII[b->v + c]);
        for (size_t r = 0; r < dim; ++r) own[r] += sqrt(fabs(W[r * (dim + 1)])) * bias;
        for (size_t r = 0; r < dim; ++r) d->scratch[r] = own[r];
        for (size_t l = 0; l < (size_t)b->n; ++l) {
            const double *J = d->J + b->dn + l * dim, *G = d->G + b->dn + l * dim;
            double joint = fabs(d->tau[(size_t)b->iu + l]);
            for (size_t r = 0; r < dim; ++r) joint += fabs(J[r]) * own[r];
            for (size_t r = 0; r < dim; ++r) d->scratch[r] += fabs(G[r]) * joint;
        }
        for (size_t c = 0; c < columns; ++c) {
            for (size_t r = 0; r < dim; ++r)
                pred[c] += fabs(d->H[b->dp + c * dim + r]) * d->scratch[r];
        }
    }
}

double mbsri_gross_load(const mbsr_model *m, const mbsr_data *d, int i, const double *x)
{
    const mbsri_body *b = m->body + i;
    double size = 0.0;
    for (int k = 0; k < b->n; ++k) {
        double force = fabs(d->tau[b->iu + k]);
        for (int r = 0; r < b->d; ++r)
            force += fabs(d->J[b->dn + (size_t)(k * b->d + r)] * d->Az[b->v + (size_t)r]);
        size += fabs(x[k]) * force;
    }
    return size;
}
