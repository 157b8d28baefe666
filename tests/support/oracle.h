/* Dense oracle: the equations (8)-(12) of a random tree as one system over all bodies, O(N^3),
 * written without the recursions, without the library's numbering and without its linear algebra
 * for small blocks.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_ORACLE_H
#define TEST_ORACLE_H

#include "tree.h"

/* Everything at one state. v: sum of d over the bodies, n: number of joint velocities. All
 * column-major. */
typedef struct test_oracle {
    int v, n;
    double *B;    /* v x n  dV/du */
    double *bI;   /* v      V = B u + bI */
    double *bII;  /* v      A = B u' + bII */
    double *M;    /* v x v  block diagonal of the body masses */
    double *mass; /* n x n  B^T M B */
    int *row;     /* id -> first row */
} test_oracle;

/* Reads poses and velocities from the tree's data, which must be at mbsr_stage_velocities. */
void test_oracle_make(test_oracle *o, const test_tree *tree, const double *u);
void test_oracle_free(test_oracle *o);

/* Rank of the rows and columns `use` (count of them) of the mass matrix, by the eigenvalues of the
 * selection scaled to unit diagonal (diagonal entries that are only rounding count as zero), those
 * above 1e-9 counted; *gap gets the ratio of the smallest counted to the largest not counted, a
 * measure of how clear the verdict is. */
int test_rank(const test_oracle *o, int count, const int *use, double *gap);

/* Replaces z by its projection on the null space of a symmetric n x n matrix of known rank. */
void test_null_projection(int n, const double *matrix, int rank, double *z);

/* Singular values of A (n x n, columns and rows scaled to about 1) above 1e-9 of the largest. */
int test_singular_rank(int n, const double *A);

/* x with A x = b, A n x n (overwritten), by LAPACK. */
void test_solve(int n, double *A, double *b);

#endif
