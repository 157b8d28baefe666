/* The Newton system by the vectorised sweeps: memory and calls.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_NEWTON_SWEEPS_H
#define MBSRI_NEWTON_SWEEPS_H

#include "newton/sweeps/elements.h"

/* Bytes of a solver of the model, 0 if it is never served. It is placed in memory aligned to
 * MBSR_DATA_ALIGNMENT. */
size_t mbsri_newton_sweeps_size(const mbsr_model *m, bool lean);
/* alone: there is no front to turn to with all bodies. blocks: has that of the bodies of other
 * kinds, where the tree has some, and what loops carry; or NULL. */
mbsri_newton_sweeps *mbsri_newton_sweeps_place(const mbsr_model *m, bool alone, void *memory,
                                               struct mbsr_newton *blocks);

/* Linearises and eliminates at (t, q, u), given in the caller's order, with the data's loop forces.
 * 0: there is a factorisation, and the data is as after mbsri_sweeps_momentum_residual.
 * MBSRI_NOT_SERVED: it is for the general version. Else a status, with its text in d->error. */
int mbsri_newton_sweeps_factor(mbsri_newton_sweeps *newton, mbsr_data *d, double t, const double *q,
                               const double *u, double c);

/* delta from r = (r_q, r_p, r_u), both in the caller's order and perhaps the same; r == NULL: zero.
 * load: NULL, or perturbations of the forces on the bodies, at offset body.v, and from
 * size_v on of the joint forces in the order of the sweeps. motion: NULL, or where the
 * perturbations of body i's pose (in space: rotation, displacement of its origin) and V go, at
 * 12 i. Without elements on bodies (tree->body_forces) nobody asks for forces on bodies
 * and for motions: load counts for the joints only and motion is not written. */
void mbsri_newton_sweeps_solve(mbsri_newton_sweeps *newton, const double *r, const double *load,
                               double *delta, double *motion);

/* x with the transposed matrix from v, not the same; trees without blocks and loops. tau: NULL, or
 * what is said of changes of joint forces, as in load (nu, in the caller's order). */
void mbsri_newton_sweeps_solve_transposed(mbsri_newton_sweeps *newton, const double *v, double *x,
                                          double *tau);

#endif
