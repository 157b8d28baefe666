/* Newton systems against differences of the residual.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_NEWTON_ALONG_H
#define TEST_NEWTON_ALONG_H

#include "expect.h"

#include <mbsrank/dae.h>

/* Fails unless K delta = r, with K = dF/dy + c dF/dy' by central differences of F, momentum form,
 * along delta. */
static inline void test_newton_along(const mbsr_model *m, mbsr_data *d, double t, const double *y,
                                     const double *yp, double c, const double *r,
                                     const double *delta)
{
    enum { MOST = 64 };
    static const double h = 1e-5;
    const int n = mbsr_dae_size(m, MBSR_DAE_MOMENTUM);
    double F[2][MOST], z[MOST], zp[MOST];
    assert_in_range(n, 1, MOST);
    for (int side = 0; side < 2; ++side) {
        for (int k = 0; k < n; ++k) {
            const double step = (side ? -h : h) * delta[k];
            z[k] = y[k] + step;
            zp[k] = yp[k] + c * step;
        }
        assert_ok(mbsr_dae_residual(m, d, MBSR_DAE_MOMENTUM, t, z, zp, F[side]),
                  mbsr_data_error(d));
    }
    for (int k = 0; k < n; ++k) assert_close((F[0][k] - F[1][k]) / (2.0 * h), r[k], 1e-6);
}

#endif
