/* Making the tree that the sweeps run over.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_BUILD_H
#define MBSRI_BUILD_H

#include "sweeps/tree.h"

/* Makes the tree of a model that is otherwise finished. False: no memory, with nothing allocated.
 */
bool mbsri_sweeps_build(mbsr_model *m);

/* The same with whole bodies as blocks, and with users' joints taken as the sweeps' own, if there
 * are any. False: no memory. */
bool mbsri_sweeps_build_others(mbsr_model *m);

void mbsri_sweeps_release(mbsr_model *m);

/* The own origin of body i, from the origin of the frame that the tree has of it, along its axes.
 */
void mbsri_sweeps_own_origin(const mbsri_sweeps *tree, const mbsr_model *m, int i, double x[3]);

/* lambda with M >= lambda Lambda of an inertia in space, Lambda = diag(L^2, L^2, L^2, 1, 1, 1); 0:
 * M is not regular. */
double mbsri_sweeps_regularity(const mbsr_inertia *inertia, double length);

/* Whether V there is six numbers of velocity or fewer, whose directions are known. */
static inline bool mbsri_has_twist(mbsr_space space)
{
    return space != MBSR_SPACE_GENERAL && space != MBSR_SPACE_FLEXIBLE;
}

#endif
