/* The parameters of a model, and where each is in a definition.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_ASSEMBLY_PARAMETERS_H
#define MBSRI_ASSEMBLY_PARAMETERS_H

#include "model/record.h"

#include <mbsrank/parameters.h>

/* One of the list; texts by their offsets in `text`. */
typedef struct mbsri_parameter {
    mbsr_parameter info; /* name is not used */
    size_t name;
    int place; /* in the array where it stands, such as param of its joint */
} mbsri_parameter;

struct mbsr_parameters {
    mbsr_model *base;  /* the definition, not finished */
    mbsri_array all;   /* mbsri_parameter */
    mbsri_array text;  /* char */
    mbsri_array table; /* const mbsr_table *, as they are found */
};

/* Where a parameter of a body, a force element or a closure stands in a definition, a copy of the
 * base; NULL: an armature where none was given. */
double *mbsri_parameter_place(mbsr_model *m, const mbsri_parameter *p);

#endif
