/* Forces along directions without mass at a state.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_IMBALANCE_H
#define MBSRI_IMBALANCE_H

#include "recursion/group.h"

/* The largest |gamma| of all null vectors of joint blocks at mbsri_backward, `relative`: beside
 * what was added up to it, of those that do more work than `least`, J, over the span of a rate;
 * *head, unless NULL: of whose group, 0: there is none. Overwrites vec and scratch, and where
 * relative what mbsri_gross_forces does. */
double mbsri_largest_defect(const mbsr_model *m, mbsr_data *d, bool relative, double least,
                            int *head);

/* The largest work of a force on a body or in a joint over the span of what it acts on, J. */
double mbsri_work_of_forces(const mbsr_model *m, const mbsr_data *d);

/* The largest of what was added up to these. Overwrites the same. */
double mbsri_largest_load(const mbsr_model *m, mbsr_data *d);

/* For each group, at the place of its head in list (bodies + 1), the largest work of a
 * gamma that is more than `share` of what was added up to it, J, or 0. Overwrites the same. */
void mbsri_defects(const mbsr_model *m, mbsr_data *d, double share, double *list);

#endif
