/* A consistent start in O(N) where dampers fix all massless rates.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_NEWTON_START_H
#define MBSRI_NEWTON_START_H

#include "recursion/data.h"

#include <mbsrank/dae.h>

/* Changes u (nu, the caller's order) along the massless directions until the forces balance, with q
 * and the momenta held, and finds u' (nu). *served: false where springs alone, or nothing, fix some
 * direction, elements across the tree are too many, or the iteration does not converge: the caller
 * has to try otherwise, and u and the error of the data are as they were. Of info, writes
 * iterations. Takes memory from the model's allocator. Returns MBSR_ERR_NO_MEMORY, what callbacks
 * returned, and the like. */
int mbsri_damped_start(const mbsr_model *m, mbsr_data *d, double t, const double *q, double *u,
                       double *udot, const mbsr_consistent_opt *opt, mbsr_consistent_info *info,
                       bool *served);

/* Forces along the massless directions alone, in no special proportion, into force (nu). The data is at
 * mbsr_backward. */
void mbsri_damped_push(const mbsr_model *m, mbsr_data *d, double *force);

#endif
