/* Inputs of actuators from CSV: a line of names, then lines of numbers.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRANK_INPUTS_H
#define MBSRANK_INPUTS_H

#include "program/program.h"

typedef struct inputs {
    int columns, lines;
    int *actuator; /* of each column behind the time */
    double *value; /* lines x (columns + 1), the time first, ascending */
} inputs;

/* A code. */
int inputs_read(const program_model *m, const char *path, inputs *in);
void inputs_free(inputs *in);

/* Line `line` holds from its time on. */
void inputs_set(const inputs *in, int line, double *control);

#endif
