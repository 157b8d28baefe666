/* The Newton matrix of a completion, on the tree or dense, and sizes of motions: see completion.c.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "massless/completion_matrix.h"

#include "algebra/dense.h"
#include "algebra/differences.h"
#include "algebra/lapack.h"
#include "base/error.h"
#include "recursion/spans.h"

#include <math.h>

int mbsri_completion_fail(mbsr_completion *w, int status, const char *text)
{
    return mbsri_fail(&w->error, status, MBSR_NONE, MBSR_NONE, "mbsr_complete: %s", text);
}

double mbsri_completion_speed(const mbsr_completion *w, const double *x)
{
    const mbsr_model *m = w->m;
    const mbsri_spans s = mbsri_spans_of(m, NULL);
    double largest = 0.0;
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        for (int k = 0; k < b->n; ++k) {
            largest = fmax(largest, fabs(x[b->u + k]) / mbsri_coordinate_span(&s, m, b, true, k));
        }
    }
    return largest;
}

double mbsri_completion_time(const mbsr_completion *w)
{
    const mbsri_spans s = mbsri_spans_of(w->m, NULL);
    const double rate = fmax(mbsri_span_rate(&s), mbsri_completion_speed(w, w->y + w->rates));
    return w->times.scale > 0.0 ? fmin(w->times.scale, 1.0 / rate) : 1.0 / rate;
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
    const double here = w->ahead[k], rate = w->ahead_rate[k], h = mbsri_difference_step(here, 1.0);
    int status = MBSR_OK;
    mbsri_zero((size_t)w->size, column);
    for (int l = 0; l < 4 && !status; ++l) {
        const double step = mbsri_difference_place(l) * h;
        w->ahead[k] = here + step;
        w->ahead_rate[k] = rate + c * step;
        status = mbsri_completion_residual(w, w->t, w->ahead, w->ahead_rate);
        for (int j = 0; j < w->size; ++j)
            column[j] += mbsri_difference_weight(l) / (12.0 * h) * w->F[j];
    }
    w->ahead[k] = here;
    w->ahead_rate[k] = rate;
    return status;
}

static int factor_dense(mbsr_completion *w, double c)
{
    const size_t size = (size_t)w->size;
    mbsri_copy(size, w->y, w->ahead);
    mbsri_copy(size, w->yp, w->ahead_rate);
    for (int k = 0; k < w->size; ++k) {
        const int status = difference_column(w, c, k, w->inverse + (size_t)k * size);
        if (status) return status;
    }
    if (mbsri_lapack_inverse(w->size, w->inverse, w->pivots, w->work) > 0.0)
        return mbsri_completion_residual(w, w->t, w->y, w->yp);
    return mbsri_completion_fail(w, MBSR_SINGULAR_BLOCK,
                                 "the Newton matrix is singular: some joint rate moves no mass, "
                                 "and no force or closure determines it");
}

int mbsri_completion_factor(mbsr_completion *w, double c)
{
    ++w->info.factorisations;
    w->factored = c;
    if (!w->newton) return factor_dense(w, c);
    const int status = mbsr_newton_factor(w->newton, w->d, w->t, w->y, w->yp, c);
    if (status) w->error = *mbsr_newton_error(w->newton);
    return status;
}

int mbsri_completion_solve(mbsr_completion *w, const double *r, double *x)
{
    ++w->info.solves;
    if (w->newton) {
        const int status = mbsr_newton_solve(w->newton, r, x);
        if (status) w->error = *mbsr_newton_error(w->newton);
        return status;
    }
    mbsri_zero((size_t)w->size, x);
    for (int k = 0; k < w->size; ++k) {
        const double *column = w->inverse + (size_t)k * (size_t)w->size;
        for (int j = 0; j < w->size; ++j) x[j] += column[j] * r[k];
    }
    for (int k = 0; k < w->size; ++k) {
        if (!isfinite(x[k]))
            return mbsri_completion_fail(w, MBSR_NOT_FINITE, "a correction is not finite");
    }
    return MBSR_OK;
}
