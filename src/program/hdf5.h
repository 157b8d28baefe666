/* Runs as HDF5 files: docs/program.md has their layout. Where the build has no HDF5, creating and
 * reading complain.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRANK_HDF5_H
#define MBSRANK_HDF5_H

#include "program/columns.h"
#include "program/table.h"

/* What attribute `format` of such files says. */
#define HDF5_FORMAT "mbsrank run 1"
#define HDF5_STUDY_FORMAT "mbsrank study 1" /* and of results of studies */

/* A file that is being written. */
typedef struct hdf5_run hdf5_run;

/* Whether the name ends as those of HDF5 files do. */
static inline bool names_hdf5(const char *path)
{
    return ends_in(path, ".h5") || ends_in(path, ".hdf5");
}

/* lines: how many there will be, or so. A code. Here and below the reason of FAILED is told on
 * closing, which is due in any case. */
int hdf5_create(const char *path, const columns *c, double lines, hdf5_run **run);

/* t and the columns. Lines are collected; every other second all of them are in the file. A code.
 */
int hdf5_line(hdf5_run *run, const double *row);

/* An attribute of the file. */
void hdf5_text(hdf5_run *run, const char *name, const char *text);
void hdf5_number(hdf5_run *run, const char *name, double number);

/* Writes what is left, and frees the run. A code. */
int hdf5_close(hdf5_run *run);

/* Matrices, by columns in memory and rows x columns in the file; each a data set of its name. A
 * code. */
typedef struct hdf5_matrix {
    const char *name;
    int rows, columns;
    const double *x;
} hdf5_matrix;
int hdf5_matrices(const char *path, int count, const hdf5_matrix *list);

/* As table_read_csv. */
int hdf5_read(const char *path, table *t);

/* Whether the file has results of a study, and as study_data_read. */
struct study_data;
bool hdf5_is_study(const char *path);
int hdf5_read_study(const char *path, struct study_data *d);

#endif
