/* In the place of hdf5_read.c and hdf5_write.c where the build has no HDF5: what opens a file says
 * so, and the rest is not reached.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "program/hdf5.h"

static const char missing[] =
    "%s: this mbsrank was built without HDF5 (CMake option MBSR_HDF5); other names are CSV";

int hdf5_create(const char *path, const columns *c, double lines, hdf5_run **run)
{
    (void)c, (void)lines;
    *run = NULL;
    return complain(FAILED, missing, path);
}

int hdf5_matrices(const char *path, int count, const hdf5_matrix *list)
{
    (void)count, (void)list;
    return complain(FAILED, missing, path);
}

int hdf5_read(const char *path, table *t)
{
    *t = (table){.text = NULL};
    return complain(FAILED, missing, path);
}

int hdf5_line(hdf5_run *run, const double *row)
{
    (void)run, (void)row;
    return FAILED;
}

void hdf5_text(hdf5_run *run, const char *name, const char *text)
{
    (void)run, (void)name, (void)text;
}

void hdf5_number(hdf5_run *run, const char *name, double number)
{
    (void)run, (void)name, (void)number;
}

int hdf5_close(hdf5_run *run)
{
    (void)run;
    return FAILED;
}

bool hdf5_is_study(const char *path)
{
    (void)path;
    return false;
}

int hdf5_read_study(const char *path, struct study_data *d)
{
    (void)d;
    return complain(FAILED, missing, path);
}

struct study_results;
int hdf5_write_study(const struct study_results *r, const char *path);
int hdf5_write_study(const struct study_results *r, const char *path)
{
    (void)r;
    return complain(FAILED, missing, path);
}
