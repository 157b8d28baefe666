/* Over what size functions change, for the steps of differences (assembly/measure.h).
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_SPANS_H
#define MBSRI_SPANS_H

#include "model/record.h"

/* Of lengths (m), angles (rad), coordinates of kinds not known (0: each its own), and the rate
 * (1/s; 0: not known) that makes spans of velocities of them. */
typedef struct mbsri_spans {
    double length, angle, other, rate;
} mbsri_spans;

/* What a table states, and of the rest what is typical of the tree; stated may be NULL. */
mbsri_spans mbsri_spans_of(const mbsr_model *m, const mbsr_scales *stated);

/* Of perturbation c of a body's pose, and of entry c of V but for the rate. */
double mbsri_pose_span(const mbsri_spans *s, const mbsri_body *b, int c);

/* Of free coordinate k of a body's joint: one of q, or of u but for the rate. */
double mbsri_coordinate_span(const mbsri_spans *s, const mbsr_model *m, const mbsri_body *b,
                             bool velocity, int k);

/* Largest of V (d) over their spans, 1/s. */
double mbsri_twist_rate(const mbsri_spans *s, const mbsri_body *b, const double *V);

/* Of free rate k of a body's joint; with 1/s where no rate is known. */
double mbsri_rate_span(const mbsri_spans *s, const mbsr_model *m, const mbsri_body *b, int k);

/* The least multiple of x (nu) that changes one of the rates u (nu) by its size or its span. */
double mbsri_rate_step(const mbsr_model *m, const double *x, const double *u);

/* The largest of joint rates x (nu, by the caller's order) over their spans; likewise of
 * accelerations. */
double mbsri_largest_rate(const mbsr_model *m, const double *x);

/* The largest of a joint's forces tau (n) times the spans of its rates. */
double mbsri_joint_load(const mbsri_spans *s, const mbsr_model *m, const mbsri_body *b,
                        const double *tau);

/* The longest way between the origins of a body and of its predecessor along an axis, H (d x
 * d_pred) being what turning the one moves of the other. */
double mbsri_lever_of(const mbsri_body *b, const double *H);

/* The largest component of the way from the predecessor's origin, or from that of a fixed root, to
 * the body's. */
double mbsri_way_of(const mbsr_data *d, const mbsri_body *b);

/* The rate, 1 a unit of time where none is known. */
double mbsri_span_rate(const mbsri_spans *s);

#endif
