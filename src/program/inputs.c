/* Inputs of actuators: see inputs.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "program/inputs.h"

#include "program/read_table.h"

#include <math.h>
#include <stdlib.h>

int inputs_read(const program_model *m, const char *path, inputs *in)
{
    *in = (inputs){.actuator = NULL};
    const int code = table_read(path, &in->table);
    if (code) return code;
    in->actuator = calloc((size_t)in->table.columns, sizeof *in->actuator);
    if (!in->actuator) return complain(FAILED, "no memory");
    for (int k = 1; k < in->table.columns; ++k) {
        in->actuator[k] = mbsr_file_find_actuator(m->file, in->table.name[k]);
        if (in->actuator[k] < 0)
            return complain(NOT_READ, "%s:1: there is no actuator '%s'", path, in->table.name[k]);
    }
    return DONE;
}

void inputs_free(inputs *in)
{
    table_free(&in->table);
    free(in->actuator);
}

double inputs_next(const inputs *in)
{
    return in->next < in->table.lines ? table_at(&in->table, in->next, 0) : INFINITY;
}

void inputs_set(inputs *in, double t, double *control)
{
    for (; inputs_next(in) <= t; ++in->next) {
        for (int k = 1; k < in->table.columns; ++k)
            control[in->actuator[k]] = table_at(&in->table, in->next, k);
    }
}
