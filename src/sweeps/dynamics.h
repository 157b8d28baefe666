/* Whole evaluations by the vectorised sweeps.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_DYNAMICS_H
#define MBSRI_DYNAMICS_H

#include "sweeps/tree.h"

/* MBSR_OK; MBSRI_NOT_SERVED where the sweeps do not serve, a rank is not clear or something is not
 * finite: then nothing is changed but the arrays of the sweeps; or what the root's motion or a
 * force element returned, with the data's error set. */
int mbsri_sweeps_forward_dynamics(const mbsr_model *m, mbsr_data *d, double t, const double *q,
                                  const double *u, const double *tau, double *udot);
int mbsri_sweeps_loops_dynamics(const mbsr_model *m, mbsr_data *d, double t, const double *q,
                                const double *u, const double *tau, double *udot);
/* And motor (nu, in the order of the sweeps): 1 for joint rates that have one, else 0. */
int mbsri_sweeps_loops_inverse(const mbsr_model *m, mbsr_data *d, double t, const double *q,
                               const double *u, const double *udot, const double *motor,
                               double *tau, double *lambda);
int mbsri_sweeps_inverse_dynamics(const mbsr_model *m, mbsr_data *d, double t, const double *q,
                                  const double *u, const double *udot, double *tau);

/* A run over that tree of the model with the arrays of d, as that they are in the order of the
 * sweeps; where its root is at the time of d, a status. */
void mbsri_sweeps_attach(mbsri_sweep_run *run, const mbsr_model *m, const mbsri_sweeps *tree,
                         mbsr_data *d);
int mbsri_sweeps_move_root(const mbsri_sweep_run *run);

/* Whether no rank is watched that is another; where one is, the stages say which. */
bool mbsri_sweeps_as_watched(const mbsri_sweep_run *run);

/* Whether there are groups of joints (recursion/group.h) that cannot be eliminated joint by joint.
 */
bool mbsri_sweeps_coupled(const mbsri_sweep_run *run);

/* What the momentum form needs at (q, u) before the backward sweep over that tree of the model:
 * motion and forces. */
int mbsri_sweeps_open(mbsri_sweep_run *run, const mbsr_model *m, const mbsri_sweeps *tree,
                      mbsr_data *d, double t, const double *q, const double *u);

/* The residuals of the inverse-dynamics form and of the momentum form. */
int mbsri_sweeps_inverse_residual(const mbsr_model *m, mbsr_data *d, double t, const double *y,
                                  const double *yp, double *F);
int mbsri_sweeps_momentum_residual(const mbsr_model *m, mbsr_data *d, double t, const double *y,
                                   const double *yp, double *F);

#endif
