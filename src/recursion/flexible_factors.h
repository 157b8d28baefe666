/* Joint blocks of flexible bodies with many modes, in factors: Woodbury's formula, with square
 * roots.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * In the sweeps a body that these serve has of Mbar and W (backward.c) the first six columns alone,
 * and of what its markers hand on the 6 x 6 matrices themselves; D, D^+, U and G are never there.
 */
#ifndef MBSRI_FLEXIBLE_FACTORS_H
#define MBSRI_FLEXIBLE_FACTORS_H

#include "recursion/group.h"

/* Whether a body has its block in factors at present. */
static inline bool mbsri_in_factors(const mbsr_data *d, int i)
{
    return d->factors.allowed && d->factors.rows[i] >= 0;
}

/* Marks the bodies that may have; once a model is built. */
void mbsri_factors_find(mbsr_model *m);

/* Before the recursion: Mbar = M and W = 0, and body i is in factors; false where it may not be. */
bool mbsri_factors_open(const mbsr_model *m, mbsr_data *d, int i);

/* Mbar^a = T and its errors E (6 x 6) of a marker i, whose predecessor is in factors. */
void mbsri_factors_take(const mbsr_model *m, mbsr_data *d, int i, const double T[36],
                        const double E[36]);

/* The rank of D and its factors. False where bounds do not tell the rank, or where there is nothing
 * to gain: then Mbar and W are whole, and the body is in factors no more.
 *
 * reads Mbar, W, H of its markers;  writes s, scale, rank; where some is lacking the columns of X
 * that are dropped and the first lambda. cost: n (6 r^2 + 36 m) for m markers of r directions in
 * all, n^2 / 2 (2 r) for modal masses off the diagonal. */
bool mbsri_factors_eliminate(const mbsr_model *m, mbsr_data *d, int i);

/* T = Mbar^a and its errors E, upper 6 x 6. */
void mbsri_factors_reduce(const mbsr_model *m, mbsr_data *d, int i, double T[36], double E[36]);

/* x (n) = D^+ b */
void mbsri_factors_solve(const mbsr_model *m, mbsr_data *d, int i, const double *b, double *x);

/* y (n) += D u */
void mbsri_factors_multiply(const mbsr_model *m, const mbsr_data *d, int i, const double *u,
                            double *y);

/* e (n) -= J^T sum,  sum (d) += G e */
void mbsri_factors_load(const mbsr_model *m, mbsr_data *d, int i, double *e, double *sum);

/* y (n) += factor U^T a for an `a` (6) of the frame alone. */
void mbsri_factors_see(const mbsr_model *m, const mbsr_data *d, int i, double factor,
                       const double a[6], double *y);

#endif
