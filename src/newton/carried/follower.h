/* Closures whose forces turn with one of their bodies (newton/slopes/closure_turn.h), where
 * looped.h eliminates.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FOLLOWER_H
#define MBSRI_FOLLOWER_H

#include "newton/carried/record.h"
#include "newton/slopes/closure_turn.h"

static inline mbsri_closure_turn mbsri_turn_of(const mbsri_carried *v, const mbsri_closure *c,
                                               const mbsri_loop *loop)
{
    return mbsri_closure_turn_at(c, v->store + loop->turn);
}

/* Whether closure k, whose derivatives are there, is of this kind; then all that is needed is
 * found. */
bool mbsri_follower_open(mbsr_newton *w, const mbsr_data *d, int k, double c);

/* Of a solution: loads on second bodies, when the right-hand sides of the rows are there; and what
 * the multipliers are, when `shift` is. */
void mbsri_follower_load(mbsr_newton *w);
void mbsri_follower_finish(mbsr_newton *w);

/* The same transposed: right-hand sides of the rows from the loads; shifts from the multipliers. */
void mbsri_follower_load_transposed(mbsr_newton *w);
void mbsri_follower_finish_transposed(mbsr_newton *w);

#endif
