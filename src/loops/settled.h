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

/* As mbsri_assemble; where stiff rows are more than the freedoms and do not meet, those that depend
 * on others at the guess are let go. */
int mbsri_assemble_settled(mbsri_closer *w, double t, double *q, const mbsr_assembly_opt *opt,
                           mbsr_assembly_info *info);

/* Lets go of stiff rows that the data leaves out and that do not share what others bear, which K is
 * to have; true where some of them are settled. `apart`: none shares. After mbsri_loops_leave_out,
 * at the C of the workspace. */
bool mbsri_springs_let_go(mbsri_dense *w, bool apart);

/* What the gaps of settled rows in w->offset lack of those at which their springs have the forces
 * lambda (rows), into w->missing; *changed: whether that is more than rounding. `shared`: rows that
 * are let go bear their part. */
int mbsri_springs_load(mbsri_dense *w, double t, const double *q, const double *lambda, bool shared,
                       bool *changed);

/* What is missing beside w->offset, as a root of energies; infinite beside none. */
double mbsri_springs_left(const mbsri_dense *w);

/* Moves w->offset on, to where nothing will be missing. */
void mbsri_springs_move(mbsri_dense *w);

/* Forces of settled springs at the gaps that they have been given, into lambda; refused where
 * others were found. */
int mbsri_springs_take(const mbsri_dense *w, double *lambda);

#endif
