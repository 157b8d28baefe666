/* Shortening of beams: see beam_shortening.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * With deflections v, w that are linear in the modes, in second order the beam moves along x by
 *
 *   -1/2 sum_ab s_a s_b g_ab,     g_ab = int_0^x v_a' v_b' + w_a' w_b'
 *
 * All g_ab, each relative to those of a and of b alone, are combinations of few functions chi_k:
 * the eigenvectors of sum_ab g_ab g_ab^T over sampled places. Then Y_k,ab = -chi_k . g_ab. Only
 * modes with mass shorten: those without stay without. */
#include "flexible/beam_shortening.h"

#include "algebra/lapack.h"

#include <math.h>

enum { POINTS = MBSRI_BEAM_POINTS, SAMPLES = MBSRI_BEAM_SAMPLES };

static const double negligible = 1e-12; /* beside the largest eigenvalue, of a square */

/* Where in the scratch what is: shapes, slopes in two directions at the points of quadrature below
 * each sample of each mode, sizes of g_aa. */
typedef struct room {
    double *at, *slope, *size, *g, *lambda, *work;
} room;

static size_t lay_out_room(const mbsri_beam *b, double *memory, room *w)
{
    const size_t samples = SAMPLES * (size_t)b->def->elements, n = (size_t)b->modes,
                 work = (size_t)mbsri_lapack_syev_work((int)samples),
                 length[] = {
                     samples * samples, 2 * POINTS * samples * n, n, samples, samples, work};
    double **const array[] = {&w->at, &w->slope, &w->size, &w->g, &w->lambda, &w->work};
    size_t used = 0;
    for (size_t k = 0; k < sizeof length / sizeof *length; ++k) {
        *array[k] = memory ? memory + used : NULL;
        used += length[k];
    }
    return used;
}

size_t mbsri_beam_shortening_size(const mbsri_beam *b)
{
    room w;
    return lay_out_room(b, NULL, &w);
}

/* Where a sample is in its element, and what counts as its share of the beam. */
static double sample_place(int j, double *share)
{
    if (j < POINTS) return mbsri_gauss(j, share);
    *share = 1.0;
    return 1.0;
}

/* v', w' of mode a in element e at z. */
static void slopes(const mbsri_beam *b, int a, int e, double z, double slope[2])
{
    const double *dofs = b->mode + (size_t)b->dofs * (size_t)a + MBSRI_BEAM_NODE * e;
    double N[4];
    mbsri_hermite(z, b->def->length / b->def->elements, 1, N);
    slope[0] = slope[1] = 0.0;
    for (int l = 0; l < 4; ++l) {
        slope[0] += N[l] * dofs[mbsri_bends_z[l]];
        slope[1] += mbsri_bends_y_sign[l] * N[l] * dofs[mbsri_bends_y[l]];
    }
}

static void fill_slopes(const mbsri_beam *b, double *slope)
{
    double weight, share;
    for (int a = 0; a < b->modes; ++a) {
        for (int e = 0; e < b->def->elements; ++e) {
            for (int j = 0; j < SAMPLES; ++j) {
                const double z = sample_place(j, &share);
                for (int k = 0; k < POINTS; ++k, slope += 2)
                    slopes(b, a, e, z * mbsri_gauss(k, &weight), slope);
            }
        }
    }
}

/* g_ab at all samples, times the roots of their shares; returns its size. */
static double pair(const mbsri_beam *b, const room *w, int a, int c, double *g)
{
    const int elements = b->def->elements;
    const double h = b->def->length / elements;
    const size_t each = 2 * (size_t)(POINTS * SAMPLES * elements);
    const double *x = w->slope + each * (size_t)a, *y = w->slope + each * (size_t)c;
    double before = 0.0, size = 0.0;
    for (int e = 0; e < elements; ++e) {
        double sum = 0.0;
        for (int j = 0; j < SAMPLES; ++j, ++g) {
            double weight, share;
            const double z = sample_place(j, &share);
            sum = before;
            for (int k = 0; k < POINTS; ++k, x += 2, y += 2) {
                mbsri_gauss(k, &weight);
                sum += h * z * weight * (x[0] * y[0] + x[1] * y[1]);
            }
            *g = sqrt(share) * sum;
            size += *g * *g;
        }
        before = sum;
    }
    return sqrt(size);
}

int mbsri_beam_shorten(const mbsri_beam *b, double *memory, mbsri_beam_shortening *by)
{
    room w;
    lay_out_room(b, memory, &w);
    const int samples = by->samples = SAMPLES * b->def->elements;
    by->at = w.at;
    by->count = 0;
    fill_slopes(b, w.slope);
    for (int a = 0; a < b->modes; ++a)
        w.size[a] = b->flexibility[a] > 0.0 ? pair(b, &w, a, a, w.g) : 0.0;
    mbsri_zero((size_t)samples * (size_t)samples, w.at);
    for (int a = 0; a < b->modes; ++a) {
        for (int c = 0; c <= a; ++c) {
            if (w.size[a] == 0.0 || w.size[c] == 0.0) continue;
            pair(b, &w, a, c, w.g);
            const double scale = 1.0 / (w.size[a] * w.size[c]);
            for (int j = 0; j < samples; ++j)
                mbsri_ax(samples, 1, scale * w.g[j], w.g, &(double){1.0}, w.at + samples * j);
        }
    }
    if (mbsri_lapack_syev(samples, w.at, w.lambda, w.work, mbsri_lapack_syev_work(samples)) != 0)
        return MBSR_ERR_NUMERICS;
    /* the last ones are the largest: they come first */
    while (by->count < samples &&
           w.lambda[samples - 1 - by->count] > negligible * w.lambda[samples - 1])
        ++by->count;
    by->at = w.at + (size_t)samples * (size_t)(samples - by->count);
    return MBSR_OK;
}

void mbsri_beam_dependences(const mbsri_beam *b, const double *memory, mbsri_beam_shortening *by)
{
    const int n = b->modes, samples = by->samples;
    room w;
    lay_out_room(b, (double *)memory, &w);
    for (int a = 0; a < n; ++a) {
        for (int c = 0; c <= a; ++c) {
            const int bends = w.size[a] > 0.0 && w.size[c] > 0.0;
            pair(b, &w, a, c, w.g);
            for (int k = 0; k < by->count; ++k)
                by->Y[n * (n * k + a) + c] = by->Y[n * (n * k + c) + a] =
                    bends ? -mbsri_dot(samples, by->at + samples * k, w.g) : 0.0;
        }
    }
    for (int j = 0; j < samples; ++j) {
        double share;
        sample_place(j % SAMPLES, &share);
        for (int k = 0; k < by->count; ++k) by->at[samples * k + j] /= sqrt(share);
    }
}
