/* Modal data of flexible bodies, as they are kept.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FLEX_DATA_H
#define MBSRI_FLEX_DATA_H

#include <mbsrank/flex.h>

#include <stdbool.h>

/* The arrays stand in one piece of memory; those of a body without modes are of length zero. */
struct mbsr_flex {
    mbsr_allocator allocator;
    int n, r, m; /* modes, dependent shapes, both */
    int markers;
    double mass, c0[3], N0[9];
    double *Ct0, *P0, *P, *Mf, *K, *D, *Y; /* as in mbsr_flex_def */
    /* n: how far an amplitude of 1 moves the body, m, in the mean square over its mass or at a
     * marker; how far it turns a marker, rad */
    double *moves, *turns;
    mbsr_flex_marker *marker; /* Phi and Psi are not NULL */
    bool *rests;              /* markers that no mode and no dependent shape moves in the body */
    int massive;              /* modes that have mass */
    /* R with R^T Mf R = 1 for these (n x n, upper triangular, zero for others), or NULL; a bound of
     * the inverse of Mf scaled to unit diagonal; whether Mf is a diagonal matrix (unit_masses.h) */
    double *root, spread;
    bool diagonal;
};

#endif
