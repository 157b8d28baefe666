/* Numbers by name over time.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRANK_PROGRAM_TABLE_H
#define MBSRANK_PROGRAM_TABLE_H

#include "program/program.h"

typedef struct table {
    char *text;            /* where the names stand */
    int columns, lines;    /* the first column is t, and t ascends */
    char **name;           /* columns */
    double *value;         /* lines x columns, line by line */
    char hash[MODEL_HASH]; /* hash of the model that has run; "": not known */
} table;

/* Reads CSV, a line of names and then lines of numbers; a code. The table is freed in any case. */
int table_read_csv(const char *path, table *t);
void table_free(table *t);

/* Cuts the next line off a text, the next cell off a line, without its quotes; NULL: none is left.
 */
char *table_line(char **text);
char *table_cell(char **line);

/* Takes the names of columns off a line, up to `stop` (NULL: all of them), into t. A code. */
int table_names(char **line, const char *stop, table *t);

/* Of column k. */
static inline double table_at(const table *t, int line, int k)
{
    return t->value[(long)line * t->columns + k];
}

/* The column of that name from column `from` on, round to those before it; -1: there is none. */
int table_find(const table *t, const char *name, int from);

#endif
