/* Parameters in derivatives of trees of rigid bodies.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Seeds (seed_values.h) stand in products of the sweeps as they do in those of all models, but for
 * frames of joints. These are axes of rate zero, before those of the joint or behind them: they
 * turn and displace the body, change its motion as seen in the moving body, and C = S x* f. */
#ifndef MBSRI_DERIVATIVES_RIGID_SEEDS_H
#define MBSRI_DERIVATIVES_RIGID_SEEDS_H

#include "derivatives/record.h"

/* Whether sweeps serve these parameters: none belongs to a body that is welded to another. */
bool mbsri_rigid_seeds_serve(const mbsri_seeds *s, const mbsr_model *m);

/* Room for the seeds of a choice, whose frames then stand in it; NULL: there is no memory. */
mbsri_rigid_seeds *mbsri_rigid_seeds_create(const mbsr_model *m, mbsri_seeds *s);
void mbsri_rigid_seeds_destroy(mbsri_rigid_seeds *r, const mbsr_model *m);

/* Values of `rigid_seed` at q, u, u', where the sweeps have been linearised. A status. */
int mbsri_rigid_seeds_find(mbsr_derivatives *w, double t, const double *q, const double *u,
                           const double *udot);

/* The sums of all seeds as loads on bodies; on joints, into `torque` of w, in the order of the
 * sweeps and as what elements exert. */
void mbsri_rigid_seeds_along(mbsr_derivatives *w);

/* `by` of `rigid_seed`: the gradient of an adjoint that had these weights of joint forces. */
void mbsri_rigid_seeds_back(mbsr_derivatives *w, double sign, const double *weights);

#endif
