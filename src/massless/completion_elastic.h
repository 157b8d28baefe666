/* Directions that springs alone hold, in the completion of a state.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_COMPLETION_ELASTIC_H
#define MBSRI_COMPLETION_ELASTIC_H

#include "massless/completion_matrix.h"

/* Solutions for c and MBSRI_COMPLETION_RATIO c from r: x becomes a and other b of x_u = a + c b,
 * where b is the motion of directions that springs alone hold; the parts before u are limits. */
int mbsri_completion_split(mbsr_completion *w, const double *r);

/* The same of the two solutions in w->x and w->other; without elastic directions x_u becomes its
 * limit, and other zero. */
void mbsri_completion_part(mbsr_completion *w);

/* Which rates (nu) belong to groups of joints some direction of which moves no mass, at the ranks
 * of the data. */
void mbsri_completion_lacking(const mbsr_completion *w, bool *lacks);

/* Forces (nu) of about one over spans, in no special proportion, on these, with w->lacks, without
 * what masses take. */
void mbsri_completion_push(const mbsr_completion *w, double *push);

/* Whether springs alone hold some direction at the state of the last residual: w->kind.elastic. */
int mbsri_completion_find_elastic(mbsr_completion *w);

/* The same where both matrices are needed anyway: also where they have a small part in motions
 * without mass. */
int mbsri_completion_find_growth(mbsr_completion *w);

/* Whether what a push of 1 J moves so far, in spans, is held by no more than rounding of the forces
 * that act: these would move it by far more than all that is there. */
bool mbsri_completion_goes_far(mbsr_completion *w, double way);

/* Whether rounding alone holds some direction: after mbsri_completion_find_elastic. */
bool mbsri_completion_gives_way(mbsr_completion *w);

/* q' = G(q) u. */
int mbsri_completion_moves(mbsr_completion *w, const double *q, const double *u, double *qdot);

/* Velocities of elastic directions: u changes towards dF_u/dt = 0, by *change in the measure of
 * mbsri_completion_speed. The u' of w->rate, zero at first, becomes that with which dampers keep
 * balancing: the part of dF_u/dt that they take falls with 1/c alone. */
int mbsri_completion_drift(mbsr_completion *w, double *change);

/* Their accelerations: w->rate changes until d^2F_u/dt^2 = 0; `exactly`: as nearly as quotients
 * over several steps can tell, at three times the residuals. */
int mbsri_completion_accelerate(mbsr_completion *w, bool exactly);

#endif
