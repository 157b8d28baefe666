/* Sizes of what is added up to forces, before anything cancels: the scale of the rounding errors in
 * them.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_SIZES_H
#define MBSRI_SIZES_H

#include "recursion/group.h"

/* Of fbar + Mbar kII of every body. At the state of mbsri_backward; the loads may be newer. Writes
 * Az, imp, sigma and Y of the data. */
void mbsri_gross_forces(const mbsr_model *m, mbsr_data *d);

/* After mbsri_gross_forces: of e = tau - J^T (fbar + Mbar kII) of a group along x (n). */
double mbsri_gross_load(const mbsr_model *m, const mbsr_data *d, const mbsri_group *g,
                        const double *x);

/* The pieces. What body i makes itself, into own (d): |f|, gyroscopic and bias forces (with what
 * was added up to Mbar: W, backward.c), and the sums as they are. */
void mbsri_own_sizes(const mbsr_model *m, const mbsr_data *d, int i, double *own);

/* |tau| + |J|^T own of joint coordinate k */
double mbsri_joint_size(const mbsri_body *b, const mbsr_data *d, int k, const double *own);

/* 1 or -1, without a pattern that a tree could have. */
double mbsri_sign(int sample, size_t place);

#endif
