/* What stands at the door of every call on a data object: checks, and the stages run on demand.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The vectorised sweeps evaluate as a whole and leave none of what the stages hold. They remember
 * their inputs, and the first call that asks for a stage runs the stages for these. */
#ifndef MBSRI_ENTRY_H
#define MBSRI_ENTRY_H

#include "recursion/data.h"

/* Checks NULL, another model's data, a missing stage; runs the stages of a pending evaluation up to
 * the one that is needed. `arguments` false: a required pointer is NULL. */
int mbsri_enter(const mbsr_model *m, mbsr_data *d, bool arguments, mbsri_stage needed,
                const char *function);

/* The same for what serves trees alone: MBSR_ERR_CLOSURES for a model with closures. */
int mbsri_enter_tree(const mbsr_model *m, mbsr_data *d, bool arguments, mbsri_stage needed,
                     const char *function);

/* Keeps the caller's inputs of an evaluation by the sweeps; load may be NULL for zero. */
void mbsri_remember(const mbsr_model *m, mbsr_data *d, mbsri_pending pending, const double *q,
                    const double *u, const double *load);

#endif
