/* Results of a study as columns of numbers, to be drawn.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRANK_STUDY_DATA_H
#define MBSRANK_STUDY_DATA_H

#include "program/table.h"

typedef struct study_data {
    table t;     /* a line a run; the first column is "run", a time of an output "NAME at T" */
    char **unit; /* columns; NULL: not known */
} study_data;

/* Whether a file has results of a study. */
bool study_data_is(const char *path);

/* Reads HDF5 or CSV; what a run does not have is NaN. A code. The data are freed in any case. */
int study_data_read(const char *path, study_data *d);
void study_data_free(study_data *d);

/* How many columns from column k on are one output at several times, and the name before " at ". */
int study_data_series(const study_data *d, int k, size_t *length);

#endif
