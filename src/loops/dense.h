/* Dense matrices of a model with closures, and solutions with them.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_LOOPS_DENSE_H
#define MBSRI_LOOPS_DENSE_H

#include "loops/assemble.h"
#include "recursion/closures.h"
#include "recursion/data.h"

/* K and what is made of it; N = n + rows. */
typedef struct mbsri_dense_factors {
    double *K, *U, *V;             /* N x N */
    double *scale, *sigma, *right; /* N */
    int *pivots;                   /* N */
    int nulls;                     /* dimension of the kernel of K */
    int moving;                    /* of its part in u */
} mbsri_dense_factors;

/* Workspace for one model; n = nu, m = rows, N = n + m. */
typedef struct mbsri_dense {
    const mbsr_model *m;
    mbsr_data *d;
    const char *function; /* for messages */
    int n, rows, position_rows, N;
    double *M; /* n x n; NULL: there are no matrices */
    double *C; /* rows x n */
    mbsri_dense_factors factor;
    double *span;      /* n: of what joint rates move (spans.h) */
    double *g, *x, *y; /* N */
    double *q;         /* nq */
    double *q_beside;  /* nq: near a singular position (ranks.c) */
    double *free;      /* 3 n: directions that loops leave free (ranks.c) */
    double *A, *b;     /* (position_rows + n) x n, and one column: least squares */
    double *work;
    int lwork;
    double *out; /* N: for results */
    mbsri_closer closer;
    bool *other;    /* rows: flags for a short time */
    bool *left_out; /* rows: not in K */
    bool *beside;   /* 2 rows: that depend on others near a singular position (ranks.c) */
    struct mbsri_row_fronts *fronts; /* of ranks, in place of matrices; NULL: there are these */
    void *memory;
} mbsri_dense;

/* Takes memory from the model's allocator; mbsri_dense_close gives it back, after a failure too. */
int mbsri_dense_open(mbsri_dense *w, const mbsr_model *m, mbsr_data *d, const char *function);
void mbsri_dense_close(mbsri_dense *w);

/* Likewise, without matrices where the model has no stiff rows, or these count as rigid
 * (row_fronts.h). */
int mbsri_dense_open_ranks(mbsri_dense *w, const mbsr_model *m, mbsr_data *d, bool rigid,
                           const char *function);

/* Takes the matrices, in place of the fronts, where digits got lost on these. */
int mbsri_dense_leave_fronts(mbsri_dense *w);

/* C of all rows at the positions of the data. */
int mbsri_dense_rows(mbsri_dense *w);

/* Factors K = [M -C^T; C 0] with the rows of `kept` (NULL: all), the others replaced by lambda = 0;
 * at the velocities of the data. Of joint rates j with stays[j] (n, NULL: none) u_j = right_j /
 * M_jj instead. */
int mbsri_dense_factor(mbsri_dense *w, const bool *dropped, const int *stays);

/* (u; lambda) = K^+ right (n + rows), least norm in the scaled unknowns, right to be in the range.
 */
void mbsri_dense_solve(const mbsri_dense *w, const double *right, double *x);

/* Vector l < moving of the kernel of K, in u: n numbers, the largest over its span 1. */
void mbsri_dense_null(const mbsri_dense *w, int l, double *x);

/* Vector l < nulls - moving of the kernel of K, in lambda: rows numbers. */
void mbsri_dense_idle(const mbsri_dense *w, int l, double *x);

#endif
