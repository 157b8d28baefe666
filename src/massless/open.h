/* Whether a state has directions without mass that nothing determines, as its index report has it.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_OPEN_H
#define MBSRI_OPEN_H

#include "recursion/data.h"

/* What the report of a state says. */
typedef struct mbsri_verdict {
    int directions, elastic;
    bool made;  /* false: no report can be made there, and the rest is zero */
    bool still; /* the bodies rest, and nothing acts on them but rounding of springs */
} mbsri_verdict;

/* MBSR_UNDETERMINED, with the name of a joint, where a direction is not determined; MBSR_OK too
 * where no report can be made, but MBSR_RANK_CHANGED of trees. Watching of ranks is off. */
int mbsri_refuse_open(const mbsr_model *m, mbsr_data *d, double t, const double *q, const double *u,
                      const char *function, mbsri_verdict *verdict);

/* MBSR_NO_CONVERGENCE of a start that met directions which nothing determines, though forces do at
 * the state given. */
int mbsri_refuse_elsewhere(mbsr_data *d, const char *function);

#endif
