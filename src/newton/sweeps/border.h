/* Where the Newton sweeps meet bodies of another kind, whose joints newton/blocks eliminates: what
 * is handed over there.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A block (sweeps/block.h) counts its perturbation x in its own coordinates, the changes of its pose
 * and of V, and y as those of (m, sigma) and, where deep, of mu. The sweeps have (dtheta, nu, xi)
 * and (chi, phi, psi) instead (perturbation.h, reaction.h). About the origin of the body that stands
 * between them, with its omega and v and the sums (L, p), (N, F), W over what is handed on,
 *
 *   d(pose) = (dtheta, xi)           d(omega) = nu_w + dtheta x omega,  dv = nu_v + dtheta x v
 *   m = -(L, p)                      d(L, p) = chi + dtheta x (L, p)
 *   sigma = -(N - v x p, F)          d(N, F) = phi
 *   mu = -W                          dW = psi + dtheta x W
 *
 * where dtheta x (L, p) is (dtheta x L, dtheta x p). A body in the plane has some of these numbers.
 *
 * A, which the blocks perturb where deep, does not pass: to a block behind the sweeps dA = 0 is
 * given, and what the sweeps hand to a block leaves out M x for some x. Neither is seen in a row
 * that counts, by the argument in reaction.h; mu of a block over its own A is -Mbar as always. */
#ifndef MBSRI_NEWTON_BORDER_H
#define MBSRI_NEWTON_BORDER_H

#include "newton/sweeps/record.h"

/* ---- factoring ---- */

/* After the backward sweep: what newton/blocks needs to know of all bodies, and what its loops are at
 * theirs. A status. */
int mbsri_border_open(const mbsri_sweep_run *run, mbsri_newton_sweeps *newton);

/* Instead, before the sweep of looped.h: loops alone, of a tree without blocks. */
int mbsri_border_open_loops(const mbsri_sweep_run *run, mbsri_newton_sweeps *newton);

/* The joint of block i, when the loops that close on it are done. Where its predecessor is in the sweeps, what it hands on goes to `carry`,
 * about the origin of that body's own frame. A status. */
int mbsri_border_eliminate(const mbsri_sweep_run *run, mbsri_newton_sweeps *newton, int i,
                           mbsri_newton_carry *carry);

/* To the block before body i what that hands on about its origin; the carry is used up. */
void mbsri_border_give(const mbsri_sweep_run *run, mbsri_newton_sweeps *newton, int i,
                       mbsri_newton_carry *carry);

/* ---- solving ---- */

/* Before the first body. */
void mbsri_border_load(mbsri_newton_sweeps *newton, const double *r, const double *load);

/* As above, of what is handed on at no perturbation. */
void mbsri_border_reduce(mbsri_newton_sweeps *newton, int i, const double *tau,
                         mbsri_newton_flow *flow);
void mbsri_border_give_flow(mbsri_newton_sweeps *newton, int i, const mbsri_newton_flow *flow);

/* At the root. */
void mbsri_border_turn(mbsri_newton_sweeps *newton);

/* Block i, whose predecessor has told its motion if it is in the sweeps: 12 numbers, see
 * mbsri_border_room. */
void mbsri_border_substitute(mbsri_newton_sweeps *newton, int i, const double *tau, double *delta);
double *mbsri_border_room(mbsri_newton_sweeps *newton, int i);

/* Leaves body i, which is in the sweeps, without dA there. */
void mbsri_border_still(mbsri_newton_sweeps *newton, int i);

/* After the last body: the multipliers' part of delta. */
void mbsri_border_finish(mbsri_newton_sweeps *newton, const double *r, double *delta);

/* Of a block: rotation, nu angular and linear, displacement. */
void mbsri_border_motion(const mbsri_newton_sweeps *newton, int block, double x[16]);

#endif
