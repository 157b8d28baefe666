/* Where the Newton sweeps meet bodies of another kind, whose joints newton/front passes: what
 * is handed over there.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A block (sweeps/block.h) counts its perturbation x in its own coordinates, the changes of its
 * pose and of V, and y as those of (m, sigma) and, below a massless joint of mu. The sweeps have
 * (dtheta, nu, xi) and (chi, phi, psi) instead (perturbation.h, reaction.h). About the origin of
 * the body that stands between them, with its omega and v and the sums (L, p), (N, F), W over what
 * is handed on,
 *
 *   d(pose) = (dtheta, xi)           d(omega) = nu_w + dtheta x omega,  dv = nu_v + dtheta x v
 *   m = -(L, p)                      d(L, p) = chi + dtheta x (L, p)
 *   sigma = -(N - v x p, F)          d(N, F) = phi
 *   mu = -W                          dW = psi + dtheta x W
 *
 * where dtheta x (L, p) is (dtheta x L, dtheta x p). A body in the plane has some of these numbers.
 *
 * A, which the blocks perturb below a massless joint, does not pass: to a block behind the sweeps
 * dA = 0 is given, and what the sweeps hand to a block leaves out M x for some x. Neither is seen
 * in a row that counts, by the argument in reaction.h; mu of a block over its own A is -Mbar as
 * always. */
#ifndef MBSRI_NEWTON_BORDER_H
#define MBSRI_NEWTON_BORDER_H

#include "newton/sweeps/record.h"

/* ---- factoring ---- */

/* After the backward sweep: ranks of all joints. */
void mbsri_border_open(const mbsri_sweep_run *run, mbsri_newton_sweeps *newton);

/* The joint of block i. Where its predecessor is in the sweeps, what it hands on goes to `carry`,
 * about the origin of that body's own frame. A status. */
int mbsri_border_eliminate(const mbsri_sweep_run *run, mbsri_newton_sweeps *newton, int i,
                           mbsri_newton_carry *carry);

/* To the block before body i what that hands on about its origin; the carry is used up. */
void mbsri_border_give(const mbsri_sweep_run *run, mbsri_newton_sweeps *newton, int i,
                       mbsri_newton_carry *carry);

/* ---- solving ---- */

/* As above, of what is handed on at no perturbation; load as in mbsri_newton_sweeps_solve, of joint
 * forces alone. */
void mbsri_border_reduce(mbsri_newton_sweeps *newton, int i, const double *r, const double *load,
                         mbsri_newton_flow *flow);
void mbsri_border_give_flow(mbsri_newton_sweeps *newton, int i, const mbsri_newton_flow *flow);

/* Block i, whose predecessor has told its motion if it is in the sweeps: 12 numbers, see
 * mbsri_border_room. */
void mbsri_border_substitute(mbsri_newton_sweeps *newton, int i);
double *mbsri_border_room(mbsri_newton_sweeps *newton, int i);

/* Of a block: rotation, nu angular and linear, displacement. */
void mbsri_border_motion(const mbsri_newton_sweeps *newton, int block, double x[16]);

#endif
