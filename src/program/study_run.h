/* A study with its model: one run of it at a time.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRANK_STUDY_RUN_H
#define MBSRANK_STUDY_RUN_H

#include "program/columns.h"
#include "program/drive.h"

#include <mbsrank/study.h>

typedef struct study_work {
    const mbsr_study *study;
    mbsr_study *read;    /* from a file, to be freed; NULL: it is the caller's */
    char **word;         /* of its line `run`, and `text` that they are in */
    char *path;          /* of the model */
    run_options options; /* of each run */
    program_model m;     /* with the values of its file and of --set */
    inputs in;
    mbsr_ida_opt opt;
    mbsr_parameters *list;
    int *which;    /* study->parameters: their numbers in the list */
    columns c;     /* study->outputs: the column of each */
    int crossings; /* outputs that are times of crossings */
    bool scanned;  /* some output looks at all states */
    uint64_t key;  /* tells study, model and inputs apart */
    /* of the run at hand: */
    double *parameter, *row, *value; /* of parameters, of columns, kept */
    char text[MBSR_TEXT_SIZE];
} study_work;

/* Reads a study and its model, and checks all that a run needs; findings go to stderr unless
 * `quiet`. A code. The work is closed in any case. */
int study_open(const char *path, bool quiet, study_work *w);
void study_close(study_work *w);

/* The same of a study and options that are given, and outlive the work. Line 0 stands for options.
 */
int study_open_given(const mbsr_study *study, const run_options *options, study_work *w);

/* Does a run; the result points into the work. */
void study_do(study_work *w, long run, mbsr_study_result *result);

/* The same with w->parameter as it stands. */
void study_try(study_work *w, mbsr_study_result *result);

/* Whether a column is known where only positions and velocities are. */
bool study_needs_no_forces(const study_work *w, const column *c);

/* "damper at", "damper max", "damper rises 0.1": what output k is called. */
enum { OUTPUT_NAME = 256 };
void study_output_name(const study_work *w, int k, char name[OUTPUT_NAME]);

/* The unit of its numbers. */
const char *study_output_unit(const study_work *w, int k);

#endif
