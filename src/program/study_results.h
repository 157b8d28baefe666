/* What all runs of a study have given.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRANK_STUDY_RESULTS_H
#define MBSRANK_STUDY_RESULTS_H

#include "program/statistics.h"
#include "program/study_run.h"

/* A column of the results: a parameter, or a number that is kept. */
typedef struct study_column {
    char name[OUTPUT_NAME];
    const char *unit;
} study_column;

typedef struct study_results {
    const study_work *work;
    long runs;
    long outcomes[MBSR_RUN_MISSING + 1]; /* how many of each */
    int *outcome, *status;               /* runs */
    double *steps;                       /* runs */
    double *parameter;                   /* parameters x runs, one parameter after the other */
    double *value;                       /* numbers x runs, likewise */
    long failures;
    long *failed;                 /* failures: their runs, */
    char (*text)[MBSR_TEXT_SIZE]; /* and texts */
} study_results;

/* Reads the journals in a folder. A code. The results are freed in any case. */
int results_collect(study_work *w, const char *folder, study_results *r);
void results_free(study_results *r);

/* Number k of those that are kept, over the runs that are done and have it. `scratch` has room for
 * all runs. */
study_statistics results_statistics(const study_results *r, int k, double *scratch);

/* Names of numbers: "damper at 0.5" of all times. */
void results_number_name(const study_results *r, int output, int k, char name[OUTPUT_NAME]);

/* Writes them beside the place and renames them into it: HDF5 by its name, else CSV. A code. */
int results_write(const study_results *r, const char *path);

/* HDF5; a code, or FAILED after a complaint where the build has none. */
int hdf5_write_study(const study_results *r, const char *path);

/* A table of the statistics, or JSON. A code. */
int results_tell(const study_results *r, bool json, FILE *to);

#endif
