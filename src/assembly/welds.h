/* Bodies that are welded to others, which the sweeps take as one body with these.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A body whose joint has no coordinates left moves with its predecessor. Where nothing but weight
 * acts on it, and all that stands on it can stand on the predecessor, it is taken out of the tree:
 * its inertia counts as the predecessor's, in the sweeps, and the joints on it become joints on
 * that. The steps of recursion/ still pass all bodies, those welded as leaves, so that every result
 * is there. */
#ifndef MBSRI_WELDS_H
#define MBSRI_WELDS_H

#include "model/record.h"

/* Joints as they are, and who is welded to whom, by id: N each. */
typedef struct mbsri_welds {
    mbsri_joint *joint;
    mbsri_stand *stand; /* host: the body that it is welded to; itself: to none */
    bool *left;         /* some coordinates of `joint` are still to be locked */
} mbsri_welds;

/* first, next: children as in finish.c; order: ids in depth-first order, of which those welded are
 * moved to the end. weld: whether any is. Sets m->live, m->stand, m->stored.joint_param, m->index
 * and which elements rest. False: no memory. */
bool mbsri_welds_find(mbsr_model *m, int N, const int *first, const int *next, int *order,
                      bool weld, mbsri_welds *w);
void mbsri_welds_release(const mbsr_model *m, mbsri_welds *w);

/* Lists them at the bodies that carry them, which are there. */
void mbsri_welds_list(mbsr_model *m);

/* Whether the sweeps of a model that is finished but for this pass all bodies that have others
 * welded to them by themselves. */
bool mbsri_welds_served(const mbsr_model *m);

/* Predecessor of a body in the tree, by index. */
int mbsri_welds_parent(const mbsr_model *m, const mbsri_welds *w, int id);

#endif
