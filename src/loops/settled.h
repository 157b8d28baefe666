/* Springs of a settled start: gaps at which stiff rows bear what keeps them so.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Stiff rows are closed like rigid ones, and then given the gaps of their forces. Those that depend
 * on others are springs throughout: their gaps follow from the others', and what these bear goes
 * over to them as they give way. */
#ifndef MBSRI_LOOPS_SETTLED_H
#define MBSRI_LOOPS_SETTLED_H

#include "loops/dense.h"

#include <mbsrank/closure.h>

/* mbsri_assemble, in which stiff rows that depend on others at the guess do not count where there
 * are more of them than freedoms and they do not meet. */
int mbsri_assemble_settled(mbsri_closer *w, double t, double *q, const mbsr_assembly_opt *opt,
                           mbsr_assembly_info *info);

/* Takes stiff rows that the data leaves out, and that do not share what others bear, into K as
 * springs; whether some of them are settled. apart: none shares. After mbsri_loops_leave_out, at
 * the C of the workspace. */
bool mbsri_springs_let_go(mbsri_dense *w, bool apart);

/* w->missing (position_rows): gaps at which the springs of settled rows have the forces lambda
 * (rows), less those in w->offset. *changed: whether some is more than rounding. shared: whether
 * rows that are springs throughout bear their part. */
int mbsri_springs_load(mbsri_dense *w, double t, const double *q, const double *lambda, bool shared,
                       bool *changed);

/* What is missing beside w->offset, as a root of energies; infinite beside none. */
double mbsri_springs_left(const mbsri_dense *w);

/* w->offset += a share of w->missing (position_rows) under which the latter goes to zero. */
void mbsri_springs_move(mbsri_dense *w);

/* lambda (rows): forces of settled springs at the gaps in w->offset; MBSR_NO_CONVERGENCE where it
 * had others. */
int mbsri_springs_take(const mbsri_dense *w, double *lambda);

#endif
