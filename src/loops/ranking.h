/* Workspace of ranks of the rows of closures.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_LOOPS_RANKING_H
#define MBSRI_LOOPS_RANKING_H

#include "loops/assemble.h"
#include "recursion/closures.h"
#include "recursion/data.h"

/* For one model; n = nu, m = rows. */
typedef struct mbsri_ranking {
    const mbsr_model *m;
    mbsr_data *d;
    const char *function; /* for messages */
    int n, rows, position_rows;
    bool springs;     /* stiff rows come after rigid ones, and are counted apart */
    double *span;     /* n: of what joint rates move (spans.h) */
    double *x;        /* n */
    double *g, *y;    /* rows */
    double *q;        /* nq */
    double *q_beside; /* nq: near a singular position (ranks.c) */
    double *free;     /* 8 n: directions that loops leave free (ranks.c) */
    double *out;      /* n + rows: for results */
    mbsri_closer closer;
    int *late;      /* rows: their order where there are springs (row_fronts.h) */
    bool *other;    /* rows: flags for a short time */
    bool *apart;    /* rows: likewise */
    bool *left_out; /* rows: without a part in equations */
    bool *shared;   /* rows: whose forces are not determined one by one */
    bool *beside;   /* 2 rows: that depend on others near a singular position (ranks.c) */
    struct mbsri_row_fronts *fronts;
    void *memory;
} mbsri_ranking;

/* Takes memory from the model's allocator; mbsri_ranking_close gives it back, after a failure too.
 * rigid: stiff rows count as rigid ones. */
int mbsri_ranking_open(mbsri_ranking *w, const mbsr_model *m, mbsr_data *d, bool rigid,
                       const char *function);
void mbsri_ranking_close(mbsri_ranking *w);

#endif
