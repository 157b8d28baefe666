/* Eigenvalues of largest size of an operator that is known by its products.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Krylov-Schur iteration (Stewart, SIAM J. Matrix Anal. Appl. 23, 2001) in real numbers:
 *
 *   S V = V H + v b^T        V orthonormal, n x k;  v the next vector
 *
 * H is brought to Schur form, sorted by size; its leading part is kept, and the space grows again.
 * One start sees one vector of an eigenvalue that comes several times, as in a model with equal
 * parts: a space goes on from random vectors (mbsri_krylov_begin) until that shows nothing new. */
#ifndef MBSRI_KRYLOV_H
#define MBSRI_KRYLOV_H

#include "files/arena.h"

typedef int (*mbsri_operator)(void *context, const double *x, double *y); /* a status */

typedef struct mbsri_krylov {
    int n, m;  /* of S; vectors at most */
    int k;     /* vectors that are there, beside the next */
    int limit; /* to how many it grows, m at most */
    mbsri_operator apply;
    void *context;
    double *V;      /* n x (m + 1) */
    double *H;      /* (m + 1) x m: with b in row k */
    double *T, *Q;  /* m x m, once sorted: Schur form of H, and its vectors */
    double *b;      /* m: of them */
    double *work;   /* of LAPACK, and blocks of rows of V */
    unsigned state; /* of random numbers */
    bool exhausted; /* S has no others than the k */
} mbsri_krylov;

void mbsri_krylov_open(mbsri_krylov *z, mbsri_arena *arena, int n, int m);

/* The next vector is random in the complement of V, and b zero. A status of S. */
int mbsri_krylov_begin(mbsri_krylov *z);

/* Grows to `limit` vectors, or until there are no others. A status of S. */
int mbsri_krylov_grow(mbsri_krylov *z);

/* T, Q and b of H, the largest first; false: LAPACK failed. */
bool mbsri_krylov_sort(mbsri_krylov *z);

/* Where the block at k ends: 1 or 2 behind it; its eigenvalue, and what is left of it in b. */
int mbsri_krylov_block(const mbsri_krylov *z, int k, double *re, double *im, double *left);

/* Keeps k vectors of those sorted. */
void mbsri_krylov_keep(mbsri_krylov *z, int k);

/* Eigenvectors of the k that are kept, k x k in the basis V, into X; of pairs real and imaginary
 * part; false: LAPACK failed. */
bool mbsri_krylov_vectors(mbsri_krylov *z, double *X);

#endif
