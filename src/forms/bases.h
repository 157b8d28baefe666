/* Smooth bases of the range and null space of every joint block.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Eigenvectors flip sign and turn within repeated eigenvalues. A frame remembers S and X = [R N] of
 * one state; elsewhere R and N are turned, each within itself, as close to the remembered ones as
 * can be (orthogonal Procrustes problem): with the projections Pi on the range,
 *
 *   R = polar factor of Pi R_ref,     N = polar factor of (I - Pi) N_ref
 *
 * both smooth as long as no angle to the reference reaches 90 degrees. */
#ifndef MBSRI_FRAME_H
#define MBSRI_FRAME_H

#include "recursion/data.h"

/* Takes the frame at a state: S, X and the ranks. */
int mbsri_frame_renew(const mbsr_model *m, mbsr_data *d, double t, const double *q,
                      const double *u);

/* X of the state at mbsr_stage_backward becomes the aligned one; `alignment` of the data the cosine
 * of the largest angle. MBSR_RANK_CHANGED, MBSR_FRAME_TURNED. */
int mbsri_frame_align(const mbsr_model *m, mbsr_data *d);

/* Xdot, Gdot, Mbardot along the motion, at an aligned state with mbsri_rates. */
int mbsri_frame_rates(const mbsr_model *m, mbsr_data *d);

#endif
