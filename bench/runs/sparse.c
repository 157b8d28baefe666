/* Newton's systems in sparse augmented form and KLU: see sparse.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "sparse.h"

#ifdef BENCH_KLU

#include "augmented.h"
#include "bench.h"

#include <ida/ida.h>
#include <klu.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_linearsolver.h>
#include <sundials/sundials_matrix.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct sparse {
    augmented system;
    long slots, *slot; /* of each entry in value, or -1: zero */
    int *from, *row;   /* compressed columns */
    double *value, *right;
    klu_common common;
    klu_symbolic *symbolic;
    klu_numeric *numeric;
    SUNContext context;
    SUNMatrix matrix;
    SUNLinearSolver solver;
    sparse_info info;
};

/* ---- the matrix ---- */

static const augmented_entry *sorted; /* for qsort */

static int by_place(const void *a, const void *b)
{
    const augmented_entry *x = sorted + *(const long *)a, *y = sorted + *(const long *)b;
    return x->column != y->column ? x->column - y->column : x->row - y->row;
}

/* Bodies from the leaves to the root, and of each what the others are made of first; with elements
 * across the tree in the order that KLU chooses (approximate minimum degree), which costs chains
 * half as much fill again. */
static void analyse(sparse *s)
{
    static const int kinds[5] = {AUGMENTED_CHI, AUGMENTED_PHI, AUGMENTED_XI, AUGMENTED_NU,
                                 AUGMENTED_RATES};
    const augmented *a = &s->system;
    if (a->linear.stiff->balls > 0) {
        s->symbolic = klu_analyze(a->size, s->from, s->row, &s->common);
        return;
    }
    int *order = bench_allocate((size_t)a->size, sizeof *order), count = 0;
    for (int i = a->linear.stiff->bodies - 1; i >= 0; --i) {
        for (int k = 0; k < 5; ++k) {
            const int n = kinds[k] == AUGMENTED_RATES ? a->linear.body[i].axes : a->dim;
            for (int l = 0; l < n; ++l) order[count++] = augmented_place(a, i, kinds[k]) + l;
        }
    }
    s->common.btf = 0;
    s->symbolic = klu_analyze_given(a->size, s->from, s->row, order, order, &s->common);
    free(order);
}

/* The pattern of the entries that are not zero, or have not been before. */
static void find_pattern(sparse *s)
{
    const long count = s->system.entries.count;
    const augmented_entry *at = s->system.entries.at;
    long *order = bench_allocate((size_t)count, sizeof *order), kept = 0, last = -1;
    long *slot = bench_allocate((size_t)count, sizeof *slot);
    const int same = s->slot && count == s->slots;
    for (long k = 0; k < count; ++k) {
        slot[k] = -1;
        if (at[k].value != 0.0 || (same && s->slot[k] >= 0)) order[kept++] = k;
    }
    free(s->slot), free(s->row), free(s->value);
    s->slot = slot;
    s->slots = count;
    s->row = bench_allocate((size_t)kept, sizeof *s->row);
    s->value = bench_allocate((size_t)kept, sizeof *s->value);
    sorted = at;
    qsort(order, (size_t)kept, sizeof *order, by_place);
    memset(s->from, 0, ((size_t)s->system.size + 1) * sizeof *s->from);
    long entries = 0;
    for (long k = 0; k < kept; last = order[k++]) {
        const augmented_entry *e = at + order[k];
        if (last < 0 || e->row != at[last].row || e->column != at[last].column) {
            s->row[entries++] = e->row;
            ++s->from[e->column + 1];
        }
        slot[order[k]] = entries - 1;
    }
    free(order);
    for (int k = 0; k < s->system.size; ++k) s->from[k + 1] += s->from[k];
    s->info.entries = entries;
    if (s->symbolic) klu_free_symbolic(&s->symbolic, &s->common);
    if (s->numeric) klu_free_numeric(&s->numeric, &s->common);
    analyse(s);
    if (!s->symbolic) bench_check(MBSR_ERR_VALUE, "klu_analyze", NULL);
}

/* Writes the entries; 0 if one of them has no place in the pattern. */
static int fill(sparse *s)
{
    memset(s->value, 0, (size_t)s->info.entries * sizeof *s->value);
    for (long k = 0; k < s->system.entries.count; ++k) {
        if (s->slot[k] >= 0)
            s->value[s->slot[k]] += s->system.entries.at[k].value;
        else if (s->system.entries.at[k].value != 0.0)
            return 0;
    }
    return 1;
}

/* With the pivots of before where they are still good, as SUNDIALS does it. */
static int refactor(sparse *s)
{
    const double least = 1e-10; /* about eps^(2/3) */
    if (s->numeric) {
        if (klu_refactor(s->from, s->row, s->value, s->symbolic, s->numeric, &s->common) &&
            klu_rcond(s->symbolic, s->numeric, &s->common) && s->common.rcond > least)
            return 0;
        klu_free_numeric(&s->numeric, &s->common);
    }
    s->numeric = klu_factor(s->from, s->row, s->value, s->symbolic, &s->common);
    if (!s->numeric) return 1;
    s->info.factors = s->numeric->lnz + s->numeric->unz;
    return 0;
}

static int factor(sparse *s, double t, const double *y, double c)
{
    const int status = augmented_at(&s->system, t, y, c);
    ++s->info.factorisations;
    if (status) return status;
    if (!s->slot || s->system.entries.count != s->slots || !fill(s)) {
        find_pattern(s);
        fill(s);
    }
    return refactor(s);
}

static int solve(sparse *s, const double *r, double *delta)
{
    augmented_right(&s->system, r, s->right);
    if (!klu_solve(s->symbolic, s->numeric, s->system.size, 1, s->right, &s->common)) return 1;
    augmented_delta(&s->system, r, s->right, delta);
    return 0;
}

/* ---- as IDA sees it ---- */

static SUNMatrix_ID matrix_id(SUNMatrix A)
{
    (void)A;
    return SUNMATRIX_CUSTOM;
}

static int matrix_zero(SUNMatrix A)
{
    (void)A;
    return 0;
}

static SUNLinearSolver_Type solver_type(SUNLinearSolver solver)
{
    (void)solver;
    return SUNLINEARSOLVER_DIRECT;
}

static SUNLinearSolver_ID solver_id(SUNLinearSolver solver)
{
    (void)solver;
    return SUNLINEARSOLVER_CUSTOM;
}

static int jacobian(sunrealtype t, sunrealtype cj, N_Vector y, N_Vector yp, N_Vector F,
                    SUNMatrix matrix, void *user, N_Vector a, N_Vector b, N_Vector c)
{
    (void)yp, (void)F, (void)user, (void)a, (void)b, (void)c;
    return factor(matrix->content, t, N_VGetArrayPointer(y), cj);
}

static int solver_solve(SUNLinearSolver solver, SUNMatrix A, N_Vector x, N_Vector b,
                        sunrealtype tolerance)
{
    (void)A, (void)tolerance;
    return solve(solver->content, N_VGetArrayPointer(b), N_VGetArrayPointer(x))
               ? SUNLS_PACKAGE_FAIL_REC
               : 0;
}

sparse *sparse_open(const stiff_model *stiff, const mbsr_model *model, mbsr_data *data)
{
    sparse *s = bench_allocate(1, sizeof *s);
    augmented_open(&s->system, stiff, model, data);
    const size_t size = (size_t)s->system.size;
    s->info.unknowns = s->system.size;
    s->from = bench_allocate(size + 1, sizeof *s->from);
    s->right = bench_allocate(size, sizeof *s->right);
    klu_defaults(&s->common);
    return s;
}

void sparse_attach(sparse *s, mbsr_ida *ida)
{
    void *const memory = mbsr_ida_memory(ida);
    bench_check(SUNContext_Create(NULL, &s->context), "SUNContext_Create", NULL);
    s->matrix = SUNMatNewEmpty(s->context);
    s->solver = SUNLinSolNewEmpty(s->context);
    if (!s->matrix || !s->solver) bench_check(MBSR_ERR_NO_MEMORY, "a linear solver", NULL);
    s->matrix->content = s->solver->content = s;
    s->matrix->ops->getid = matrix_id;
    s->matrix->ops->zero = matrix_zero;
    s->solver->ops->gettype = solver_type;
    s->solver->ops->getid = solver_id;
    s->solver->ops->solve = solver_solve;
    bench_check(IDASetLinearSolver(memory, s->solver, s->matrix), "IDASetLinearSolver", NULL);
    bench_check(IDASetJacFn(memory, jacobian), "IDASetJacFn", NULL);
}

/* Seconds a call, the least of some. */
static double time_of(sparse *s, mbsr_newton *newton, const double *y, const double *yp, double c,
                      const double *r, double *delta, int solving)
{
    double least = INFINITY;
    for (int k = 0; k < 20; ++k) {
        int status;
        const double begin = bench_now();
        if (newton && solving)
            status = mbsr_newton_solve(newton, r, delta);
        else if (newton)
            status = mbsr_newton_factor(newton, s->system.data, 0.0, y, yp, c);
        else
            status = solving ? solve(s, r, delta) : factor(s, 0.0, y, c);
        least = fmin(least, bench_now() - begin);
        bench_check(status, newton ? "on the tree" : "by KLU", NULL);
    }
    return least;
}

sparse_comparison sparse_compare(sparse *s, const double *y, const double *yp)
{
    const double c = 1e3;
    const int n = mbsr_dae_size(s->system.model, MBSR_DAE_MOMENTUM),
              ties = s->system.linear.stiff->balls;
    const int tested = ties > 0 ? n - mbsr_model_nu(s->system.model) : n;
    mbsr_newton_opt opt = mbsr_default_newton_opt();
    mbsr_newton *newton = NULL;
    double *r = bench_allocate(3 * (size_t)n, sizeof *r), *delta = r + n, *other = delta + n,
           most = 0.0;
    uint64_t seed = 1;
    sparse_comparison to = {0};
    bench_check(mbsr_newton_create(s->system.model, MBSR_DAE_MOMENTUM, &opt, &newton, NULL),
                "mbsr_newton_create", NULL);
    for (int k = 0; k < tested; ++k) r[k] = bench_uniform(&seed, -1.0, 1.0);
    to.tree_factor = time_of(s, newton, y, yp, c, r, delta, 0);
    to.tree_solve = time_of(s, newton, y, yp, c, r, delta, 1);
    to.factor = time_of(s, NULL, y, yp, c, r, other, 0);
    to.solve = time_of(s, NULL, y, yp, c, r, other, 1);
    for (int k = 0; k < n; ++k) {
        most = fmax(most, fabs(delta[k]));
        to.difference = fmax(to.difference, fabs(delta[k] - other[k]));
    }
    to.difference /= most;
    mbsr_newton_destroy(newton);
    free(r);
    return to;
}

void sparse_destroy(sparse *s)
{
    if (!s) return;
    if (s->solver) SUNLinSolFreeEmpty(s->solver);
    if (s->matrix) SUNMatFreeEmpty(s->matrix);
    if (s->context) SUNContext_Free(&s->context);
    if (s->symbolic) klu_free_symbolic(&s->symbolic, &s->common);
    if (s->numeric) klu_free_numeric(&s->numeric, &s->common);
    augmented_close(&s->system);
    void *const owned[] = {s->slot, s->from, s->row, s->value, s->right};
    for (size_t k = 0; k < sizeof owned / sizeof owned[0]; ++k) free(owned[k]);
    free(s);
}

sparse_info sparse_get_info(const sparse *s)
{
    return s->info;
}

#else

sparse *sparse_open(const stiff_model *stiff, const mbsr_model *model, mbsr_data *data)
{
    (void)stiff, (void)model, (void)data;
    return NULL;
}

void sparse_attach(sparse *s, mbsr_ida *ida)
{
    (void)s, (void)ida;
}

sparse_comparison sparse_compare(sparse *s, const double *y, const double *yp)
{
    (void)s, (void)y, (void)yp;
    return (sparse_comparison){0};
}

void sparse_destroy(sparse *s)
{
    (void)s;
}

sparse_info sparse_get_info(const sparse *s)
{
    (void)s;
    return (sparse_info){0};
}

#endif
