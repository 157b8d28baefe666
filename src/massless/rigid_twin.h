/* A copy of a model in which stiff rows are rigid.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_RIGID_TWIN_H
#define MBSRI_RIGID_TWIN_H

#include "recursion/data.h"

typedef struct mbsri_rigid_twin {
    mbsr_model *model;
    mbsr_data *data;
} mbsri_rigid_twin;

/* springs (rows; NULL: none): stiff rows that stay springs. Statuses of mbsr_model_copy,
 * mbsr_model_finish and mbsr_data_create, reported in d; what has been made is to be closed after a
 * failure too. */
int mbsri_rigid_twin_open(const mbsr_model *m, mbsr_data *d, const bool *springs,
                          mbsri_rigid_twin *twin);
void mbsri_rigid_twin_close(mbsri_rigid_twin *twin);

/* To be called once other rows of the twin are springs than when it was finished: the vectorised
 * sweeps have planned which are rigid, and leave dynamics to loops/. */
void mbsri_rigid_twin_forget_plan(const mbsri_rigid_twin *twin);

#endif
