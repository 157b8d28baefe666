/* Fronts of the equations of motion with loops: what meets in a step, and its pivots.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FRONTS_ASSEMBLE_H
#define MBSRI_FRONTS_ASSEMBLE_H

#include "fronts/fronts.h"

/* Assembles step k from what it takes, eliminates what is complete, and gives the body whose joint
 * is passed what its motion gets, into Mbar and W. Unknowns of w->pivots[k]: pivots, those with
 * nothing left, those that go on, then motions of other bodies and of its own, by w->pivots[k]->d.
 * Without loops: NULL. False: no memory. */
bool mbsri_fronts_assemble(mbsri_fronts *w, int k);

/* Passes the joint of the body of step k, whose rank has been found, and leaves a part for the next
 * step; without joint, leaves what goes on. False: no memory. */
bool mbsri_fronts_pass(mbsri_fronts *w, int k);
bool mbsri_fronts_leave(mbsri_fronts *w, int k);

#endif
