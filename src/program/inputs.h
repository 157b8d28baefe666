/* Inputs of actuators over time, from a table.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRANK_INPUTS_H
#define MBSRANK_INPUTS_H

#include "program/program.h"
#include "program/table.h"

typedef struct inputs {
    table table;   /* without lines: no inputs */
    int *actuator; /* actuator of each column but the first, t */
    int next;      /* the next line to hold */
} inputs;

/* A code. The inputs are freed in any case. */
int inputs_read(const program_model *m, const char *path, inputs *in);
void inputs_free(inputs *in);

/* When the next line begins to hold, s; infinite behind the last. */
double inputs_next(const inputs *in);

/* Sets what holds at t from the lines that have not held yet. */
void inputs_set(inputs *in, double t, double *control);

#endif
