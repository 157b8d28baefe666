/* Where a run goes: CSV, or HDF5 where the name of the file ends in .h5 or .hdf5.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRANK_OUTPUT_H
#define MBSRANK_OUTPUT_H

#include "program/columns.h"

struct hdf5_run;

typedef struct output {
    const char *path; /* NULL: standard output */
    const columns *columns;
    double *row;          /* t, then the columns */
    FILE *text;           /* CSV; NULL: HDF5 */
    struct hdf5_run *run; /* HDF5; NULL: CSV */
    long lines;           /* written */
} output;

/* lines: how many there will be, or so. A code. The output is closed in any case. */
int output_open(const char *path, const columns *c, double lines, output *o);

/* Columns at this state, at which the data is at mbsr_stage_velocities. A code. */
int output_state(output *o, const mbsr_model *model, mbsr_data *data, double t, const double *q,
                 const double *u);

/* Something about the run as a whole; CSV has no place for it. */
void output_text(output *o, const char *name, const char *text);
void output_number(output *o, const char *name, double number);

/* A code: FAILED where something has not been written. */
int output_close(output *o);

#endif
