/* How the bodies of a force element stand to each other in the tree.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_RELATION_H
#define MBSRI_RELATION_H

#include "model/record.h"

/* How body i stands to body j. APART too where one is the root, which does not move. */
typedef enum mbsri_relation {
    MBSRI_APART,
    MBSRI_SAME,
    MBSRI_BELOW, /* j is the predecessor of i */
    MBSRI_ABOVE  /* i is the predecessor of j */
} mbsri_relation;

mbsri_relation mbsri_relate(const mbsr_model *m, int i, int j);

/* Whether an element may couple what the elimination does not take in: bodies that are apart, and
 * neighbours by more than their f, pose and V and what concerns the successor's joint. */
bool mbsri_may_cross(const mbsr_model *m, const mbsri_force *force);

/* Numbers of the derivatives of an element: rows, and columns. */
void mbsri_slopes_shape(const mbsr_model *m, const mbsri_force *force, int *rows, int *columns);

#endif
