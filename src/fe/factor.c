/* Cholesky factors: see factor.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fe/factor.h"

#include "algebra/dense.h"
#include "fe/lapack.h"

#include <limits.h>

#ifdef MBSR_WITH_CHOLMOD
#include <cholmod.h>
#endif

static const double lost = 1e-13; /* a pivot beside the number on the diagonal: rounding */

enum { DENSE_BESIDE_SPARSE = 600, DENSE_ALONE = 5000 };

struct mbsri_factor {
    mbsri_arena arena;
    int n;
    double *L; /* dense: n x n; NULL: sparse */
#ifdef MBSR_WITH_CHOLMOD
    cholmod_common common;
    cholmod_factor *sparse;
#endif
};

mbsr_fe_solver mbsri_factor_choose(mbsr_fe_solver wanted, int n)
{
#ifdef MBSR_WITH_CHOLMOD
    if (wanted != MBSR_FE_AUTO) return wanted;
    return n <= DENSE_BESIDE_SPARSE ? MBSR_FE_DENSE : MBSR_FE_SPARSE;
#else
    return wanted == MBSR_FE_DENSE || (wanted == MBSR_FE_AUTO && n <= DENSE_ALONE) ? MBSR_FE_DENSE
                                                                                   : MBSR_FE_AUTO;
#endif
}

/* ---- dense ---- */

static int make_dense(mbsri_factor *f, const mbsri_sparse *A, const double *shift, int *column)
{
    const size_t n = (size_t)A->n;
    f->L = mbsri_arena_take(&f->arena, n * n * sizeof *f->L);
    if (!f->L) return MBSR_ERR_NO_MEMORY;
    for (int j = 0; j < A->n; ++j) {
        double *to = f->L + n * (size_t)j;
        for (int k = A->start[j]; k < A->start[j + 1]; ++k) to[A->row[k]] = A->value[k];
        to[j] += shift[j];
    }
    *column = mbsri_fe_cholesky(A->n, f->L);
    if (*column >= 0) return MBSR_ERR_VALUE;
    for (int j = 0; j < A->n; ++j) {
        const double pivot = f->L[n * (size_t)j + (size_t)j];
        *column = j;
        if (!(pivot * pivot > lost * (A->value[A->start[j]] + shift[j]))) return MBSR_ERR_VALUE;
    }
    return MBSR_OK;
}

/* ---- sparse ---- */

#ifdef MBSR_WITH_CHOLMOD

/* A with shift, in a matrix of CHOLMOD's own; NULL: no memory. */
static cholmod_sparse *copy_shifted(const mbsri_sparse *A, const double *shift,
                                    cholmod_common *common)
{
    const size_t n = (size_t)A->n, entries = (size_t)A->start[A->n];
    cholmod_sparse *S = cholmod_allocate_sparse(n, n, entries, 1, 1, -1, CHOLMOD_REAL, common);
    if (!S) return NULL;
    memcpy(S->p, A->start, (n + 1) * sizeof *A->start);
    memcpy(S->i, A->row, entries * sizeof *A->row);
    memcpy(S->x, A->value, entries * sizeof *A->value);
    for (int j = 0; j < A->n; ++j) ((double *)S->x)[A->start[j]] += shift[j];
    return S;
}

/* Pivot of column j of the permuted matrix, of a factor by columns or by supernodes. */
static double pivot_of(const cholmod_factor *L, int j, int *super)
{
    const double *x = L->x;
    if (!L->is_super) return x[((const int *)L->p)[j]];
    const int *first = L->super, *rows = L->pi, *values = L->px;
    while (first[*super + 1] <= j) ++*super;
    const size_t height = (size_t)(rows[*super + 1] - rows[*super]),
                 at = (size_t)(j - first[*super]);
    return x[(size_t)values[*super] + at * height + at];
}

static int check_pivots(const mbsri_factor *f, const mbsri_sparse *A, const double *shift,
                        int *column)
{
    const cholmod_factor *L = f->sparse;
    int super = 0;
    for (int j = 0; j < A->n; ++j) {
        const int k = ((const int *)L->Perm)[j];
        *column = k;
        if ((size_t)j >= L->minor) return MBSR_ERR_VALUE;
        const double pivot = pivot_of(L, j, &super);
        if (!(pivot * pivot > lost * (A->value[A->start[k]] + shift[k]))) return MBSR_ERR_VALUE;
    }
    return MBSR_OK;
}

static int make_sparse(mbsri_factor *f, const mbsri_sparse *A, const double *shift, int *column)
{
    cholmod_common *common = &f->common;
    cholmod_sparse *S = copy_shifted(A, shift, common);
    if (S) f->sparse = cholmod_analyze(S, common);
    if (f->sparse) cholmod_factorize(S, f->sparse, common);
    cholmod_free_sparse(&S, common);
    if (!f->sparse || common->status < CHOLMOD_OK || f->sparse->xtype == CHOLMOD_PATTERN)
        return MBSR_ERR_NO_MEMORY;
    return check_pivots(f, A, shift, column);
}

static void start_cholmod(mbsri_factor *f)
{
    cholmod_start(&f->common);
    f->common.print = 0;
    f->common.error_handler = NULL;
    f->common.final_ll = 1;
}

static bool solve_sparse(mbsri_factor *f, int c, double *X)
{
    const size_t n = (size_t)f->n;
    cholmod_dense B = {.nrow = n,
                       .ncol = (size_t)c,
                       .nzmax = n * (size_t)c,
                       .d = n,
                       .x = X,
                       .xtype = CHOLMOD_REAL,
                       .dtype = CHOLMOD_DOUBLE};
    cholmod_dense *Y = cholmod_solve(CHOLMOD_A, f->sparse, &B, &f->common);
    if (!Y) return false;
    mbsri_copy(n * (size_t)c, Y->x, X);
    cholmod_free_dense(&Y, &f->common);
    return true;
}

#endif

/* ---- both ---- */

int mbsri_factor_make(const mbsr_allocator *allocator, mbsr_fe_solver solver, const mbsri_sparse *A,
                      const double *shift, mbsri_factor **factor, int *column)
{
    mbsri_arena arena;
    *factor = NULL;
    *column = -1;
    mbsri_arena_open(&arena, allocator);
    mbsri_factor *f = mbsri_arena_take(&arena, sizeof *f);
    if (!f) return MBSR_ERR_NO_MEMORY;
    f->arena = arena;
    f->n = A->n;
#ifdef MBSR_WITH_CHOLMOD
    start_cholmod(f);
    const int status = solver == MBSR_FE_SPARSE ? make_sparse(f, A, shift, column)
                                                : make_dense(f, A, shift, column);
#else
    const int status =
        solver == MBSR_FE_SPARSE ? MBSR_ERR_UNAVAILABLE : make_dense(f, A, shift, column);
#endif
    if (status)
        mbsri_factor_destroy(f);
    else
        *factor = f;
    return status;
}

void mbsri_factor_destroy(mbsri_factor *f)
{
    if (!f) return;
#ifdef MBSR_WITH_CHOLMOD
    cholmod_free_factor(&f->sparse, &f->common);
    cholmod_finish(&f->common);
#endif
    mbsri_arena arena = f->arena;
    mbsri_arena_close(&arena);
}

bool mbsri_factor_solve(mbsri_factor *f, int c, double *X)
{
#ifdef MBSR_WITH_CHOLMOD
    if (!f->L) return solve_sparse(f, c, X);
#endif
    mbsri_fe_cholesky_solve(f->n, f->L, c, X);
    return true;
}

double mbsri_factor_entries(const mbsri_factor *f)
{
#ifdef MBSR_WITH_CHOLMOD
    if (!f->L) {
        const cholmod_factor *L = f->sparse;
        return (double)(L->is_super ? L->xsize : L->nzmax);
    }
#endif
    return 0.5 * (double)f->n * ((double)f->n + 1.0);
}
