/* Fronts: joints and closing loops with what is carried past them (carried.h).
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FRONT_H
#define MBSRI_FRONT_H

#include "newton/blocks/carried.h"
#include "newton/blocks/joint.h"

/* Of the unknowns that go, `LU` of a front keeps the columns of L (all rows: those of the front, then
 * what it adds to y of the body above), and then the rows of U (its columns, then x of that body), by
 * the order of the exchanges. */

/* A joint of a front; of a group, its members with the head first. */
typedef struct mbsri_front_joint {
    mbsri_block_joint *j;
    int above; /* the member it hangs on; -1: none */
    int q, u;  /* first of its coordinates and rates among those of the group */
} mbsri_front_joint;

/* Instead of mbsri_block_finish, for a joint that something is carried past, or a group of joints:
 * `all` has what is of the group. */
int mbsri_front_finish(mbsri_block_joint *all, int members, const mbsri_front_joint *member,
                       double c);

/* The loops that close on a body, when all behind it is done: those of a member of a group that is
 * eliminated in one piece go with that. */
int mbsri_front_close(mbsr_newton *w, mbsr_data *d, int body);

/* Those of one front. P: the matrix of a body in vector code, mbsri_carried_motions columns of
 * mbsri_carried_actions; NULL: that of a block. */
int mbsri_front_close_one(mbsr_newton *w, mbsr_data *d, int k, double *P);

#endif
