/* The Newton matrix of a completion, on the tree or dense, and sizes of motions: see completion.c.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "massless/completion_matrix.h"

#include "algebra/dense.h"
#include "algebra/differences.h"
#include "algebra/lapack.h"
#include "base/error.h"
#include "recursion/closures.h"

#include <math.h>

int mbsri_completion_fail(mbsr_completion *w, int status, const char *text)
{
    return mbsri_fail(&w->error, status, MBSR_NONE, MBSR_NONE, "mbsr_completion_solve: %s", text);
}

bool mbsri_completion_converged(double change, double last, double enough, double near)
{
    if (change <= enough || last == INFINITY) return change <= enough;
    return change * (change / last) <= enough || (change > 0.25 * last && change <= near);
}

double mbsri_completion_speed(const mbsr_completion *w, const double *x)
{
    double largest = 0.0;
    for (int k = 0; k < w->m->nu; ++k) largest = fmax(largest, fabs(x[k]) * w->span.per[k]);
    return largest;
}

double mbsri_completion_time(const mbsr_completion *w)
{
    const double own = 1.0 / fmax(w->span.least, mbsri_completion_speed(w, w->y + w->rates));
    return w->times.scale > 0.0 ? fmin(w->times.scale, own) : own;
}

double mbsri_completion_size(const mbsr_completion *w, const double *udot)
{
    const double time = mbsri_completion_time(w);
    return mbsri_completion_speed(w, udot) + 1e-3 / (time * time);
}

double mbsri_completion_load(const mbsr_completion *w, const double *load)
{
    double largest = 0.0;
    for (int k = 0; k < w->m->nu; ++k) largest = fmax(largest, fabs(load[k]) / w->span.per[k]);
    return largest;
}

double mbsri_completion_force(mbsr_completion *w, const double *lambda)
{
    const mbsri_closure *closure = w->m->closures.data;
    if (w->m->rows == 0) return 0.0;
    for (size_t id = 0; id < w->m->closures.count; ++id, ++closure) {
        for (int k = closure->row; k < closure->row + closure->rows; ++k)
            w->span.loop[k] = mbsri_is_stiff(closure, k - closure->row) ? 0.0 : lambda[k];
    }
    mbsri_closure_transpose(w->m, w->d, w->span.loop, w->form.q);
    return mbsri_completion_load(w, w->form.q);
}

int mbsri_completion_residual(mbsr_completion *w, double t, const double *y, const double *yp)
{
    ++w->info.residuals;
    const int status = mbsr_dae_residual(w->m, w->d, MBSR_DAE_MOMENTUM, t, y, yp, w->F);
    if (status) w->error = *mbsr_data_error(w->d);
    return status;
}

/* Column k of K: the residual along (e_k, c e_k), by four points. */
static int difference_column(mbsr_completion *w, double c, int k, double *column)
{
    const double here = w->ahead.y[k], rate = w->ahead.yp[k], h = mbsri_difference_step(here, 1.0);
    int status = MBSR_OK;
    mbsri_zero((size_t)w->size, column);
    for (int l = 0; l < 4 && !status; ++l) {
        const double step = mbsri_difference_place(l) * h;
        w->ahead.y[k] = here + step;
        w->ahead.yp[k] = rate + c * step;
        status = mbsri_completion_residual(w, w->t, w->ahead.y, w->ahead.yp);
        for (int j = 0; j < w->size; ++j)
            column[j] += mbsri_difference_weight(l) / (12.0 * h) * w->F[j];
    }
    w->ahead.y[k] = here;
    w->ahead.yp[k] = rate;
    return status;
}

static int factor_dense(mbsr_completion *w, double *inverse, double c)
{
    const size_t size = (size_t)w->size;
    mbsri_copy(size, w->y, w->ahead.y);
    mbsri_copy(size, w->yp, w->ahead.yp);
    for (int k = 0; k < w->size; ++k) {
        const int status = difference_column(w, c, k, inverse + (size_t)k * size);
        if (status) return status;
    }
    if (mbsri_lapack_inverse(w->size, inverse, w->solver.pivots, w->solver.work) > 0.0)
        return mbsri_completion_residual(w, w->t, w->y, w->yp);
    return mbsri_completion_fail(w, MBSR_SINGULAR_BLOCK,
                                 "the Newton matrix is singular: some joint rate moves no mass, "
                                 "and no force or closure determines it");
}

static mbsri_completion_matrix *matrix_of(mbsr_completion *w, int which)
{
    return &w->solver.matrix[w->solver.pair ? which : MBSRI_NEAR];
}

bool mbsri_completion_has(const mbsr_completion *w, int which)
{
    return w->solver.matrix[w->solver.pair ? which : MBSRI_NEAR].c == mbsri_completion_c(w, which);
}

void mbsri_completion_forget(mbsr_completion *w)
{
    for (int j = 0; j < MBSRI_MATRICES; ++j) w->solver.matrix[j].c = 0.0;
}

int mbsri_completion_factor(mbsr_completion *w, int which)
{
    mbsri_completion_matrix *matrix = matrix_of(w, which);
    const double c = mbsri_completion_c(w, which);
    ++w->info.factorisations;
    matrix->c = 0.0;
    int status = MBSR_OK;
    if (matrix->newton) {
        status = mbsr_newton_factor(matrix->newton, w->d, w->t, w->y, w->yp, c);
        if (status) w->error = *mbsr_newton_error(matrix->newton);
    } else {
        status = factor_dense(w, matrix->inverse, c);
    }
    if (!status) matrix->c = c;
    return status;
}

static int solve_dense(mbsr_completion *w, const double *inverse, const double *r, double *x)
{
    mbsri_zero((size_t)w->size, x);
    for (int k = 0; k < w->size; ++k) {
        const double *column = inverse + (size_t)k * (size_t)w->size;
        for (int j = 0; j < w->size; ++j) x[j] += column[j] * r[k];
    }
    for (int k = 0; k < w->size; ++k) {
        if (!isfinite(x[k]))
            return mbsri_completion_fail(w, MBSR_NOT_FINITE, "a correction is not finite");
    }
    return MBSR_OK;
}

int mbsri_completion_solve(mbsr_completion *w, int which, const double *r, double *x)
{
    const mbsri_completion_matrix *matrix = matrix_of(w, which);
    int status = mbsri_completion_has(w, which) ? MBSR_OK : mbsri_completion_factor(w, which);
    if (status) return status;
    ++w->info.solves;
    if (!matrix->newton) return solve_dense(w, matrix->inverse, r, x);
    status = mbsr_newton_solve(matrix->newton, r, x);
    if (status) w->error = *mbsr_newton_error(matrix->newton);
    return status;
}
