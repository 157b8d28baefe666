/* A dense matrix factored by LAPACK: see lapack.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "lapack.h"

#include "bench.h"

#include <ida/ida.h>
#include <nvector/nvector_serial.h>
#include <stdlib.h>
#include <string.h>
#include <sundials/sundials_linearsolver.h>
#include <sunmatrix/sunmatrix_dense.h>

struct lapack {
    SUNContext context;
    SUNMatrix matrix;
    SUNLinearSolver solver;
    int n, *pivots;
};

void dgetrf_(const int *m, const int *n, double *a, const int *lda, int *pivots, int *info);
void dgetrs_(const char *trans, const int *n, const int *nrhs, const double *a, const int *lda,
             const int *pivots, double *b, const int *ldb, int *info, size_t length);

static SUNLinearSolver_Type type(SUNLinearSolver solver)
{
    (void)solver;
    return SUNLINEARSOLVER_DIRECT;
}

static SUNLinearSolver_ID number(SUNLinearSolver solver)
{
    (void)solver;
    return SUNLINEARSOLVER_CUSTOM;
}

static int factor(SUNLinearSolver solver, SUNMatrix A)
{
    const lapack *l = solver->content;
    int info;
    dgetrf_(&l->n, &l->n, SUNDenseMatrix_Data(A), &l->n, l->pivots, &info);
    return info == 0 ? 0 : SUNLS_PACKAGE_FAIL_REC;
}

static int solve(SUNLinearSolver solver, SUNMatrix A, N_Vector x, N_Vector b, sunrealtype tolerance)
{
    (void)tolerance;
    const lapack *l = solver->content;
    const int one = 1;
    int info;
    double *to = N_VGetArrayPointer(x);
    memcpy(to, N_VGetArrayPointer(b), (size_t)l->n * sizeof *to);
    dgetrs_("N", &l->n, &one, SUNDenseMatrix_Data(A), &l->n, l->pivots, to, &l->n, &info, 1);
    return info == 0 ? 0 : SUNLS_PACKAGE_FAIL_REC;
}

lapack *lapack_attach(mbsr_ida *ida, int size)
{
    lapack *l = bench_allocate(1, sizeof *l);
    l->n = size;
    l->pivots = bench_allocate((size_t)size, sizeof *l->pivots);
    bench_check(SUNContext_Create(NULL, &l->context), "SUNContext_Create", NULL);
    l->matrix = SUNDenseMatrix(size, size, l->context);
    l->solver = SUNLinSolNewEmpty(l->context);
    if (!l->matrix || !l->solver) bench_check(MBSR_ERR_NO_MEMORY, "a dense matrix", NULL);
    l->solver->content = l;
    l->solver->ops->gettype = type;
    l->solver->ops->getid = number;
    l->solver->ops->setup = factor;
    l->solver->ops->solve = solve;
    bench_check(IDASetLinearSolver(mbsr_ida_memory(ida), l->solver, l->matrix),
                "IDASetLinearSolver", NULL);
    return l;
}

void lapack_destroy(lapack *l)
{
    if (!l) return;
    SUNLinSolFreeEmpty(l->solver);
    SUNMatDestroy(l->matrix);
    SUNContext_Free(&l->context);
    free(l->pivots);
    free(l);
}
