/* What a force element exerts along a motion, and what that is compared with.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * All but mbsri_element_resists and mbsri_element_moves read the derivatives of one element,
 * w->element.slope; `rows` are those of its forces, of `bodies` bodies. */
#ifndef MBSRI_ELEMENT_REACTION_H
#define MBSRI_ELEMENT_REACTION_H

#include "massless/null_space.h"

/* Motion of what an element sees: size_v, size_v, nq, nu in the caller's order; NULL: zero. */
typedef struct mbsri_element_motion {
    const double *pose, *V, *q, *u;
} mbsri_element_motion;

/* y (rows) = change of the forces with a motion, and gross (rows) the sum of the sizes of its
 * terms, with `arms` by the sizes of vectors; false where the element does not move. */
bool mbsri_element_react(const mbsri_null_space *w, int bodies, mbsri_element_motion x, bool arms,
                         double *y, double *gross);

/* gross (rows) = |F_x| |x| for positions x of typical sizes, or with `velocity` |F_V| |V| for
 * velocities of typical sizes per unit of time. */
void mbsri_element_strain(const mbsri_null_space *w, int bodies, bool velocity, double *gross);

/* The largest of forces (rows) by what they do along typical sizes. */
double mbsri_element_work(const mbsri_null_space *w, int bodies, const double *gross);

/* Whether forces y (rows) are more than this share of `gross`: those of a rigid body by the sizes
 * of moment and force, others one by one beside a trace of the largest, by what they do: of
 * products with quaternions some are rounding alone. */
bool mbsri_element_stands_out(const mbsri_null_space *w, int bodies, double least, const double *y,
                              const double *gross);

/* Whether a motion of joint rates a (nu) and twists (size_v) moves an element, or, one that acts on
 * every body, what it sees of body `every`. */
bool mbsri_element_moves(const mbsri_null_space *w, const mbsri_force *force, int every,
                         const double *a, const double *twist);

/* Whether an element's forces change along a direction a (nu) with its twist (size_v) and q' (nq),
 * with the rates (velocity) or with the positions: by more than the largest that one number of this
 * motion, times `share`, or one typical rate, times `least`, changes them by. The data is at
 * mbsri_velocities of the state; writes w->element.slope. */
int mbsri_element_resists(mbsri_null_space *w, const mbsri_force *force, const double *a,
                          const double *twist, const double *q_rate, bool velocity, double share,
                          double least, bool *resists);

#endif
