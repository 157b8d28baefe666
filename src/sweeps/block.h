/* Bodies of any kind among those of the vectorised sweeps: the steps of the recursion as they are
 * (recursion/), and what is handed over where the two kinds meet.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A body of this kind, a block, has its pose, V, A, forces and Mbar in the arrays of the stages,
 * about its own origin, in its own coordinates. To and from a neighbour that the sweeps keep in
 * space (embed.h), everything goes about the neighbour's own origin as six numbers or 6 x 6, with
 *
 *   A    there less gravity
 *   p    -fbar, and Mbar times what A there has less: gravity, the swing of the origin
 *   W    exact, or the bound kappa Mbar + spread Lambda, which is more
 *   m = -(L, p),  sigma = -(N - v x p, F),  mbar = -(L_bar, p_bar)
 *
 * (forms/momentum.c, sweeps/momentum.h). A block is in GENERAL space, or has a joint or an inertia
 * that embed.h does not take; its neighbours in the sweeps are in space or in the plane. */
#ifndef MBSRI_BLOCK_STEPS_H
#define MBSRI_BLOCK_STEPS_H

#include "recursion/group.h"
#include "sweeps/tree.h"

/* ---- root to leaves ---- */

/* The pose and the velocity of body i, whose predecessor is done; a status. */
int mbsri_block_move(const mbsri_sweep_run *run, int i);

/* Before u' and A are found in the forward sweep, A of the predecessor, and after that, A where its
 * neighbours look; in inverse dynamics A and mu from u' in `tau`. */
void mbsri_block_open_forward(const mbsri_sweep_run *run, int i);
void mbsri_block_close_forward(const mbsri_sweep_run *run, int i);
void mbsri_block_accelerate(const mbsri_sweep_run *run, int i);

/* The algebraic equations of the momentum form: at the head of a group, of all of it. */
void mbsri_block_balance(const mbsri_sweep_run *run, int i);

/* x by the order of a group's rates, to their places in the order of the sweeps. */
void mbsri_block_rates(const mbsri_sweep_run *run, const mbsri_group *g, const double *x,
                       double *out);

/* ---- leaves to root: first for all blocks, then body by body ---- */

/* f = -h and the weight of all blocks; elements add to it. */
int mbsri_block_forces(const mbsri_sweep_run *run);

void mbsri_block_open(const mbsri_sweep_run *run);
/* With the rates of H, J and M; a status. */
int mbsri_block_open_momentum(const mbsri_sweep_run *run);

/* Body i; with a predecessor in the sweeps, what it hands on about that one's point goes to c, and
 * to W where `exact`. False: its rank is not clear, or a failure that the stages tell. */
bool mbsri_block_backward(const mbsri_sweep_run *run, int i, bool exact, mbsri_carry *c,
                          mbsri_carry *W);

/* Before and after the step by the bound (block_bound.h), of a block that is MBSRI_BOUNDED. */
void mbsri_block_before_bound(const mbsri_sweep_run *run, int i);
void mbsri_block_after_bound(const mbsri_sweep_run *run, int i, mbsri_carry *c);

/* The same of inverse dynamics: joint forces to `out`, wrench (L, p); and of the momentum form,
 * where momenta are given or (run->p == NULL) without them. */
void mbsri_block_react(const mbsri_sweep_run *run, int i, double L[4], double p[4]);
/* f - M A of all blocks, with which that begins, where A is that of the forward recursion. */
void mbsri_block_open_reaction(const mbsri_sweep_run *run);
void mbsri_block_momentum(const mbsri_sweep_run *run, int i, mbsri_flow *flow);

/* A block takes what a body in the sweeps hands on about its point; W: NULL for the bound. */
void mbsri_block_receive(const mbsri_sweep_run *run, int block, const mbsri_carry *c,
                         const mbsri_carry *W);
void mbsri_block_receive_force(const mbsri_sweep_run *run, int block, const double L[4],
                               const double p[4]);
void mbsri_block_receive_flow(const mbsri_sweep_run *run, int block, const mbsri_flow *flow);

#endif
