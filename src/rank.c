/* The rank of one joint block D and its pseudo-inverse.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * D = J^T Mbar J may be zero up to rounding, so its eigenvalues are compared with the size of the
 * rounding errors in it, not with each other. W (backward.c) is that size for Mbar: the sum of all
 * that was added up before anything cancelled, carried from body to body as an error would be. With
 * S = diag(J^T W J)^(-1/2)
 *
 *   S D S = X diag(lambda) X^T,  lambda_k > tolerance: kept (R = S X_kept), else dropped (N)
 *   D^+   = S X_kept diag(1/lambda) X_kept^T S
 *
 * S makes the decision the same in all units. D^+ is the Moore-Penrose pseudo-inverse of D in the
 * joint coordinates S^-1 u; the columns of N span the null space of D, and I - D^+ D = S X_dropped
 * X_dropped^T S^-1 projects onto it. */
#include "internal.h"

#include "dense.h"
#include "lapack.h"

#include <math.h>

/* diag(J^T W J)^(-1/2) into s, and the largest entry of diag(J^T W J). A zero entry belongs to a
 * row of D that is zero. */
static double equilibrate(const mbsri_body *b, const mbsr_data *d, double *s)
{
    double *WJ = d->scratch, largest = 0.0;
    for (int k = 0; k < b->n; ++k) {
        const double *column = d->J + b->dn + (size_t)k * (size_t)b->d;
        mbsri_zero((size_t)b->d, WJ);
        mbsri_ax(b->d, b->d, 1.0, d->W + b->dd, column, WJ);
        const double size = mbsri_dot(b->d, column, WJ);
        s[k] = size > 0.0 ? 1.0 / sqrt(size) : 1.0;
        if (size > largest) largest = size;
    }
    return largest;
}

/* Eigenvalues in descending order and their eigenvectors, so that the range comes first. */
static void reverse(int n, double *X, double *lambda)
{
    for (int k = 0, l = n - 1; k < l; ++k, --l) {
        const double value = lambda[k];
        lambda[k] = lambda[l];
        lambda[l] = value;
        for (int j = 0; j < n; ++j) {
            const double entry = X[k * n + j];
            X[k * n + j] = X[l * n + j];
            X[l * n + j] = entry;
        }
    }
}

/* reads D, J, W;  writes s, X, lambda, Dinv, scale, rank.  cost: one symmetric eigenproblem of size
 * n. */
int mbsri_rank_decision(const mbsr_model *m, mbsr_data *d, int i)
{
    const mbsri_body *b = m->body + i;
    const int n = b->n;
    const double *D = d->D + b->nn;
    double *s = d->s + b->u, *X = d->X + b->nn, *lambda = d->lambda + b->u, *Dinv = d->Dinv + b->nn;
    char label[MBSRI_LABEL];

    d->rank[i] = 0;
    d->scale[i] = equilibrate(b, d, s);
    /* S D S */
    for (int j = 0; j < n; ++j) {
        for (int k = 0; k < n; ++k) X[j * n + k] = s[j] * D[j * n + k] * s[k];
    }
    if (!mbsri_finite((size_t)n * (size_t)n, X)) return mbsri_report_not_finite(m, d);
    /* = X diag(lambda) X^T */
    if (n == 1) {
        lambda[0] = X[0];
        X[0] = 1.0;
    } else {
        const int info = mbsri_lapack_syev(n, X, lambda, d->scratch, m->lapack_work);
        if (info != 0) {
            return mbsri_fail(&d->error, MBSR_EIGEN_FAILED, b->id, MBSR_NONE,
                              "%s: the eigenvalues of D did not converge at t = %g (dsyev: %d)",
                              mbsri_body_label(m, i, label), d->t, info);
        }
        reverse(n, X, lambda);
    }
    if (lambda[n - 1] < -m->rank_tolerance) {
        return mbsri_fail(
            &d->error, MBSR_INDEFINITE_MASS, b->id, MBSR_NONE,
            "%s: the mass on its joint is indefinite at t = %g (scaled eigenvalue %g)",
            mbsri_body_label(m, i, label), d->t, lambda[n - 1]);
    }
    while (d->rank[i] < n && lambda[d->rank[i]] > m->rank_tolerance) ++d->rank[i];
    /* D^+ */
    mbsri_zero((size_t)n * (size_t)n, Dinv);
    for (int l = 0; l < d->rank[i]; ++l) {
        for (int j = 0; j < n; ++j) {
            const double factor = s[j] * X[l * n + j] / lambda[l];
            for (int k = 0; k < n; ++k) Dinv[j * n + k] += factor * s[k] * X[l * n + k];
        }
    }
    return MBSR_OK;
}

void mbsri_null_part(const mbsr_model *m, const mbsr_data *d, int i, const double *x, double *y)
{
    const mbsri_body *b = m->body + i;
    const int n = b->n, rank = d->rank[i];
    const double *s = d->s + b->u, *X = d->X + b->nn;
    double *weight = d->scratch;
    /* X_dropped^T S^-1 x */
    for (int l = rank; l < n; ++l) {
        weight[l] = 0.0;
        for (int k = 0; k < n; ++k) weight[l] += X[l * n + k] * x[k] / s[k];
    }
    /* S X_dropped (.) */
    mbsri_zero((size_t)n, y);
    for (int l = rank; l < n; ++l) {
        for (int k = 0; k < n; ++k) y[k] += s[k] * X[l * n + k] * weight[l];
    }
}

/* reads X, s, e;  e = tau - J^T fbar - J^T Mbar kII, and the last term has no part in the null
 * space (Lemma 2). */
void mbsri_null_force(const mbsr_model *m, const mbsr_data *d, int i, double *gamma)
{
    const mbsri_body *b = m->body + i;
    const int n = b->n, rank = d->rank[i];
    const double *s = d->s + b->u, *X = d->X + b->nn, *e = d->e + b->u;
    double *weight = d->scratch;
    /* X_dropped^T S e */
    for (int l = rank; l < n; ++l) {
        weight[l] = 0.0;
        for (int k = 0; k < n; ++k) weight[l] += X[l * n + k] * s[k] * e[k];
    }
    /* S^-1 X_dropped (.) */
    mbsri_zero((size_t)n, gamma);
    for (int l = rank; l < n; ++l) {
        for (int k = 0; k < n; ++k) gamma[k] += X[l * n + k] * weight[l] / s[k];
    }
}

int mbsr_body_rank(const mbsr_model *model, mbsr_data *data, int body, mbsr_rank_info *info)
{
    const int status =
        mbsri_enter(model, data, info != NULL, MBSRI_STAGE_BACKWARD, "mbsr_body_rank");
    if (status) return status;
    const int i = mbsri_index(model, body);
    if (i <= 0) {
        return mbsri_fail(&data->error, MBSR_ERR_ID, MBSR_NONE, MBSR_NONE,
                          "mbsr_body_rank: there is no body %d", body);
    }
    const mbsri_body *b = model->body + i;
    const double *lambda = data->lambda + b->u;
    const int rank = data->rank[i];
    *info = (mbsr_rank_info){
        .n = b->n, .rank = rank, .tolerance = model->rank_tolerance, .scale = data->scale[i]};
    if (rank > 0) info->smallest_kept = lambda[rank - 1];
    for (int k = rank; k < b->n; ++k)
        info->largest_dropped = fmax(info->largest_dropped, fabs(lambda[k]));
    return MBSR_OK;
}

int mbsr_total_rank(const mbsr_model *model, const mbsr_data *data)
{
    return data && data->model == model && data->stage >= MBSRI_STAGE_BACKWARD ? data->total_rank
                                                                               : -1;
}
