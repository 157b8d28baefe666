/* Problems in which no stiff spring closes a loop.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef ORDINARY_H
#define ORDINARY_H

#include <mbsrank/mbsrank.h>

enum { ORDINARY_MOST = 40 }; /* joint coordinates */

typedef struct ordinary {
    const char *name;
    void (*build)(mbsr_model *model, double *q, double *u); /* fills an empty model; start */
    double T;                                               /* s */
} ordinary;

extern const ordinary ordinary_problems[]; /* ends with a name of NULL */

#endif
