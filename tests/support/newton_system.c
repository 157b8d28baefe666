/* The Newton matrix of a DAE form by differences: see newton_system.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "newton_system.h"

#include "oracle.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

int test_newton_matrix(const mbsr_model *model, mbsr_data *data, mbsr_dae_form form, double t,
                       const double *y, const double *yp, double c, double step, double *A)
{
    static const double place[4] = {2.0, 1.0, -1.0, -2.0},
                        weight[4] = {-1.0 / 12.0, 8.0 / 12.0, -8.0 / 12.0, 1.0 / 12.0};
    const int n = mbsr_dae_size(model, form);
    double *at = calloc((size_t)n, sizeof *at), *slope = calloc((size_t)n, sizeof *slope),
           *F = calloc((size_t)n, sizeof *F);
    int status = MBSR_OK;
    memset(A, 0, (size_t)n * (size_t)n * sizeof *A);
    for (int k = 0; k < n && !status; ++k) {
        const double size = fmax(1.0, fabs(y[k])), h = step * size;
        for (int l = 0; l < 4 && !status; ++l) {
            memcpy(at, y, (size_t)n * sizeof *at);
            memcpy(slope, yp, (size_t)n * sizeof *slope);
            at[k] += place[l] * h;
            slope[k] += c * place[l] * h;
            status = mbsr_dae_residual(model, data, form, t, at, slope, F);
            for (int j = 0; j < n; ++j) A[k * n + j] += weight[l] * F[j] / h;
        }
    }
    free(at), free(slope), free(F);
    return status;
}

double test_newton_error(int nq, int nu, double *A, const double *r, const double *x)
{
    const int n = nq + 2 * nu, first[] = {0, nq, nq + nu, n};
    double *expected = calloc((size_t)n, sizeof *expected), worst = 0.0;
    memcpy(expected, r, (size_t)n * sizeof *expected);
    test_solve(n, A, expected);
    for (int kind = 0; kind < 3; ++kind) {
        double size = 0.0, error = 0.0;
        for (int k = first[kind]; k < first[kind + 1]; ++k) {
            size = fmax(size, fabs(expected[k]));
            error = fmax(error, fabs(x[k] - expected[k]));
        }
        if (size > 0.0) worst = fmax(worst, error / size);
    }
    free(expected);
    return worst;
}
