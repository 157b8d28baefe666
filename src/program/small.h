/* Small masses of a model: which may be zero.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRANK_PROGRAM_SMALL_H
#define MBSRANK_PROGRAM_SMALL_H

#include "program/program.h"

typedef struct small_options {
    bool wanted;
    double time, tolerance; /* s; in each joint coordinate */
} small_options;

/* The report from the start q, u over the time; a code, and *small NULL, after a complaint. */
int small_make(const program_model *m, const small_options *o, const double *q, const double *u,
               mbsr_small_masses **small);

/* As a table or as a value of JSON, null where there is none. */
void small_write(FILE *to, const program_model *m, mbsr_small_masses *small, bool json);

#endif
