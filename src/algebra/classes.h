/* Things that belong together, by joining two at a time.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_CLASSES_H
#define MBSRI_CLASSES_H

/* leader: of each thing another of its class, itself at first; the leader of the class of l. */
static inline int mbsri_class_of(int *leader, int l)
{
    while (leader[l] != l) l = leader[l] = leader[leader[l]];
    return l;
}

static inline void mbsri_class_join(int *leader, int a, int b)
{
    leader[mbsri_class_of(leader, a)] = mbsri_class_of(leader, b);
}

#endif
