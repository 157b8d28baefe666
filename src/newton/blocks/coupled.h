/* The elimination of joints that are one group (recursion/group.h), which factor.c calls.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_COUPLED_H
#define MBSRI_COUPLED_H

#include "newton/blocks/record.h"

/* Doubles of w->work for the group of that head. */
size_t mbsri_coupled_work(const mbsr_newton *w, int head);

/* As mbsri_tree_eliminate, for the group of that head; the successors of all members are done. */
int mbsri_coupled_eliminate(mbsr_newton *w, mbsr_data *d, int head, double c);

#endif
