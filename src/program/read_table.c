/* Tables from files: see read_table.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "program/read_table.h"

#include "program/hdf5.h"

#include <math.h>

/* What is checked of CSV line by line. */
static int check_lines(const char *path, const table *t)
{
    for (int line = 0; line < t->lines; ++line) {
        for (int k = 0; k < t->columns; ++k)
            if (!isfinite(table_at(t, line, k)))
                return complain(NOT_READ, "%s: '%s'[%d] is no number", path, t->name[k], line);
        if (line > 0 && !(table_at(t, line, 0) > table_at(t, line - 1, 0)))
            return complain(NOT_READ, "%s: t[%d]: times must ascend", path, line);
    }
    return DONE;
}

int table_read(const char *path, table *t)
{
    if (!names_hdf5(path)) return table_read_csv(path, t);
    const int code = hdf5_read(path, t);
    return code ? code : check_lines(path, t);
}
