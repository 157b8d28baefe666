/* Which joints the recursion eliminates as one block (recursion/group.h).
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_GROUPS_H
#define MBSRI_GROUPS_H

#include "model/record.h"

/* Sets the groups of all bodies and what depends on them: places of vectors by groups, of blocks,
 * the largest of these. Needs a model that is finished but for that, and may ask its
 * joints for a position. False: no memory. */
bool mbsri_groups_build(mbsr_model *m);

/* Sets the places again, those of groups with bodies in the sweeps first. False: no memory. */
bool mbsri_groups_place(mbsr_model *m);

#endif
