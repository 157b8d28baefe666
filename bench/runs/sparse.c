/* A sparse Jacobian by differences and KLU, in place of the linear solver of an IDA driver.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "sparse.h"

#ifdef BENCH_KLU

#include "bench.h"

#include <ida/ida.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_klu.h>
#include <sunmatrix/sunmatrix_sparse.h>

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

struct sparse {
    const mbsr_model *model;
    mbsr_data *data;
    void *memory; /* IDA's */
    int n;
    sunindextype *column, *row; /* compressed columns: n + 1, entries */
    int *group;                 /* columns by groups: group[first[g] .. first[g+1]) */
    int *first;
    double *y, *yp, *F, *F0, *step;
    SUNContext context;
    SUNMatrix matrix;
    SUNLinearSolver solver;
    sparse_info info;
};

static int residual(sparse *s, double t, const double *y, const double *yp, double *F)
{
    ++s->info.residuals;
    return mbsr_dae_residual(s->model, s->data, MBSR_DAE_MOMENTUM, t, y, yp, F);
}

/* ---- pattern ----------------------------------------------------------------------------------
 * */

/* Rows of F that change with column k of y and y', in row[at ..); their number, or -1 if there is
 * no room. The state is one without zeros, so that no product vanishes by accident. */
static long find_rows(sparse *s, int k, long at, long most)
{
    const double y = s->y[k], yp = s->yp[k];
    long count = 0;
    s->y[k] += 1e-3 * (1.0 + fabs(y));
    s->yp[k] += 1e-3 * (1.0 + fabs(yp));
    bench_check(residual(s, 0.0, s->y, s->yp, s->F), "pattern", mbsr_data_error(s->data)->text);
    for (int i = 0; i < s->n; ++i) {
        if (s->F[i] == s->F0[i] && i != k) continue;
        if (at + count >= most) return -1;
        s->row[at + count++] = i;
    }
    s->y[k] = y;
    s->yp[k] = yp;
    return count;
}

static int find_pattern(sparse *s, const double *y, const double *yp, long most)
{
    uint64_t seed = 1;
    long at = 0;
    for (int k = 0; k < s->n; ++k) {
        s->y[k] = y[k] + bench_uniform(&seed, 0.01, 0.02);
        s->yp[k] = yp[k] + bench_uniform(&seed, 0.01, 0.02);
    }
    bench_check(residual(s, 0.0, s->y, s->yp, s->F0), "pattern", mbsr_data_error(s->data)->text);
    for (int k = 0; k < s->n; ++k) {
        const long count = find_rows(s, k, at, most);
        if (count < 0) return 0;
        s->column[k] = (sunindextype)at;
        at += count;
    }
    s->column[s->n] = (sunindextype)at;
    s->info.entries = at;
    return 1;
}

/* Whether column k has no row that the group has (mark[row] == group). */
static int fits(const sparse *s, int k, const int *mark, int group)
{
    for (sunindextype e = s->column[k]; e < s->column[k + 1]; ++e) {
        if (mark[s->row[e]] == group) return 0;
    }
    return 1;
}

/* Each group takes every column still free that fits, in their order. */
static void find_groups(sparse *s)
{
    int *mark = bench_allocate((size_t)s->n, sizeof *mark), placed = 0, group = 0;
    char *taken = bench_allocate((size_t)s->n, 1);
    while (placed < s->n) {
        s->first[group++] = placed;
        for (int k = 0; k < s->n; ++k) {
            if (taken[k] || !fits(s, k, mark, group)) continue;
            for (sunindextype e = s->column[k]; e < s->column[k + 1]; ++e) mark[s->row[e]] = group;
            taken[k] = 1;
            s->group[placed++] = k;
        }
    }
    s->first[group] = placed;
    s->info.groups = group;
    free(mark);
    free(taken);
}

/* ---- Jacobian ---------------------------------------------------------------------------------
 * */

/* As IDA's own differences: a step of sqrt(eps) of the entry or of its change in a step, at least
 * its tolerance, in the direction of its rate. */
static void choose_steps(sparse *s, const double *y, const double *yp)
{
    double h = 0.0;
    N_Vector weights = N_VNew_Serial(s->n, s->context);
    IDAGetCurrentStep(s->memory, &h);
    IDAGetErrWeights(s->memory, weights);
    const double *weight = N_VGetArrayPointer(weights), root = sqrt(DBL_EPSILON);
    for (int k = 0; k < s->n; ++k) {
        double step = fmax(root * fmax(fabs(y[k]), fabs(h * yp[k])), 1.0 / weight[k]);
        if (h * yp[k] < 0.0) step = -step;
        s->step[k] = y[k] + step - y[k];
    }
    N_VDestroy(weights);
}

static sparse *active; /* the driver keeps the user data for itself */

static int jacobian(sunrealtype t, sunrealtype cj, N_Vector y_vector, N_Vector yp_vector,
                    N_Vector F_vector, SUNMatrix matrix, void *user, N_Vector a, N_Vector b,
                    N_Vector c)
{
    sparse *s = active;
    const double *y = N_VGetArrayPointer(y_vector), *yp = N_VGetArrayPointer(yp_vector),
                 *F = N_VGetArrayPointer(F_vector);
    double *value = SUNSparseMatrix_Data(matrix);
    const size_t bytes = (size_t)s->n * sizeof *y;
    (void)user, (void)a, (void)b, (void)c;
    ++s->info.jacobians;
    choose_steps(s, y, yp);
    memcpy(s->y, y, bytes);
    memcpy(s->yp, yp, bytes);
    memcpy(SUNSparseMatrix_IndexPointers(matrix), s->column,
           ((size_t)s->n + 1) * sizeof *s->column);
    memcpy(SUNSparseMatrix_IndexValues(matrix), s->row, (size_t)s->info.entries * sizeof *s->row);
    for (int g = 0; g < s->info.groups; ++g) {
        for (int i = s->first[g]; i < s->first[g + 1]; ++i) {
            const int k = s->group[i];
            s->y[k] += s->step[k];
            s->yp[k] += cj * s->step[k];
        }
        const int status = residual(s, t, s->y, s->yp, s->F);
        if (status) return status;
        for (int i = s->first[g]; i < s->first[g + 1]; ++i) {
            const int k = s->group[i];
            for (sunindextype e = s->column[k]; e < s->column[k + 1]; ++e)
                value[e] = (s->F[s->row[e]] - F[s->row[e]]) / s->step[k];
            s->y[k] = y[k];
            s->yp[k] = yp[k];
        }
    }
    return 0;
}

/* ---- creation ---------------------------------------------------------------------------------
 * */

sparse *sparse_attach(mbsr_ida *ida, const mbsr_model *model, mbsr_data *data, const double *y,
                      const double *yp, long most)
{
    sparse *s = bench_allocate(1, sizeof *s);
    const size_t n = (size_t)mbsr_dae_size(model, MBSR_DAE_MOMENTUM);
    s->model = model;
    s->data = data;
    s->memory = mbsr_ida_memory(ida);
    s->n = (int)n;
    s->column = bench_allocate(n + 1, sizeof *s->column);
    s->row = bench_allocate((size_t)most, sizeof *s->row);
    s->group = bench_allocate(n, sizeof *s->group);
    s->first = bench_allocate(n + 1, sizeof *s->first);
    double **const numbers[] = {&s->y, &s->yp, &s->F, &s->F0, &s->step};
    for (int k = 0; k < 5; ++k) *numbers[k] = bench_allocate(n, sizeof(double));
    if (!find_pattern(s, y, yp, most)) {
        sparse_destroy(s);
        return NULL;
    }
    find_groups(s);
    bench_check(SUNContext_Create(NULL, &s->context), "SUNContext_Create", NULL);
    N_Vector vector = N_VNew_Serial(s->n, s->context);
    s->matrix = SUNSparseMatrix(s->n, s->n, (sunindextype)s->info.entries, CSC_MAT, s->context);
    s->solver = SUNLinSol_KLU(vector, s->matrix, s->context);
    N_VDestroy(vector);
    bench_check(IDASetLinearSolver(s->memory, s->solver, s->matrix), "IDASetLinearSolver", NULL);
    bench_check(IDASetJacFn(s->memory, jacobian), "IDASetJacFn", NULL);
    active = s;
    return s;
}

void sparse_destroy(sparse *s)
{
    if (!s) return;
    if (s->solver) SUNLinSolFree(s->solver);
    if (s->matrix) SUNMatDestroy(s->matrix);
    if (s->context) SUNContext_Free(&s->context);
    void *const owned[] = {s->column, s->row, s->group, s->first, s->y,
                           s->yp,     s->F,   s->F0,    s->step};
    for (size_t k = 0; k < sizeof owned / sizeof owned[0]; ++k) free(owned[k]);
    free(s);
}

sparse_info sparse_get_info(const sparse *s)
{
    return s->info;
}

#else

sparse *sparse_attach(mbsr_ida *ida, const mbsr_model *model, mbsr_data *data, const double *y,
                      const double *yp, long most)
{
    (void)ida, (void)model, (void)data, (void)y, (void)yp, (void)most;
    return NULL;
}

void sparse_destroy(sparse *s)
{
    (void)s;
}

sparse_info sparse_get_info(const sparse *s)
{
    (void)s;
    return (sparse_info){0, 0, 0, 0};
}

#endif
