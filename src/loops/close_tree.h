/* Positions that close loops, along the tree.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_CLOSE_TREE_H
#define MBSRI_CLOSE_TREE_H

#include "recursion/data.h"

#include <mbsrank/closure.h>

/* Closes loops from q (nq) in O(bodies + loops) by Gauss-Newton steps, without the rows that the
 * data leaves out; offset (held): what gaps are to be, NULL: zero. *closed: whether it did, q is
 * then closed and *iterations higher by the steps. Negative statuses alone. */
int mbsri_close_on_tree(const mbsr_model *m, mbsr_data *d, double t, const mbsr_assembly_opt *opt,
                        const double *offset, double *q, int *iterations, bool *closed);

#endif
