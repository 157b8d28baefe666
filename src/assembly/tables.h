/* Tables that a model reads, and those that it owns.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_ASSEMBLY_TABLES_H
#define MBSRI_ASSEMBLY_TABLES_H

#include "forces/drive.h"
#include "model/record.h"

/* The table that a part reads; NULL: none. */
static inline const mbsr_table *mbsri_joint_table_of(const mbsri_joint *joint)
{
    return joint->motion == mbsr_table_motion ? joint->user : NULL;
}

static inline const mbsr_table *mbsri_force_table_of(const mbsr_force_def *def)
{
    return mbsri_reads_table(def) ? def->user : NULL;
}

static inline const mbsr_table *mbsri_closure_table_of(const mbsr_closure_def *def)
{
    return def->motion == mbsr_table_motion ? def->user : NULL;
}

/* Makes a table that the model, which is not finished, owns, and puts it in the place of `old`
 * everywhere. Statuses of mbsr_table_create. */
int mbsri_table_replace(mbsr_model *m, const mbsr_table *old, const mbsr_table_def *def,
                        mbsr_error *error);

#endif
