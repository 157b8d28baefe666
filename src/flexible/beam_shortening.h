/* How a beam gets shorter when it bends: dependent shapes (flex.h) of its modes.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_BEAM_SHORTENING_H
#define MBSRI_BEAM_SHORTENING_H

#include "flexible/beam_elements.h"
#include "flexible/beam_modes.h"

/* In each element the five points of quadrature and its end. */
enum { MBSRI_BEAM_SAMPLES = MBSRI_BEAM_POINTS + 1 };

/* Displacements along x: shape k at sample j of element e is at[samples k + MBSRI_BEAM_SAMPLES e +
 * j]. */
typedef struct mbsri_beam_shortening {
    int count, samples;
    double *at;
    double *Y; /* modes x modes x count */
} mbsri_beam_shortening;

/* Doubles for the samples of most shapes there can be, their Y aside, and what it takes to find
 * them. */
size_t mbsri_beam_shortening_size(const mbsri_beam *b);

/* count and `at`, in memory of that size. MBSR_ERR_NUMERICS. */
int mbsri_beam_shorten(const mbsri_beam *b, double *memory, mbsri_beam_shortening *by);

/* Y (modes x modes x count), whose place is set, after mbsri_beam_shorten with the same memory. */
void mbsri_beam_dependences(const mbsri_beam *b, const double *memory, mbsri_beam_shortening *by);

#endif
