/* Tables from files: CSV, or HDF5 where the name of the file ends in .h5 or .hdf5.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRANK_READ_TABLE_H
#define MBSRANK_READ_TABLE_H

#include "program/table.h"

/* A code. The table is freed in any case. */
int table_read(const char *path, table *t);

#endif
