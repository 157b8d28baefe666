/* The classical Runge-Kutta method of order 4, as 07_explicit.c writes it out.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef EXAMPLES_RK4_H
#define EXAMPLES_RK4_H

enum { RK4_MOST = 512 };

typedef void (*rk4_slope)(void *user, double t, const double *x, double *xdot);

/* One step h of x' = slope(t, x) with n <= RK4_MOST numbers. */
static inline void rk4_step(rk4_slope slope, void *user, int n, double t, double h, double *x)
{
    const double at[4] = {0.0, 0.5, 0.5, 1.0}, weight[4] = {1.0, 2.0, 2.0, 1.0};
    double k[RK4_MOST] = {0.0}, sum[RK4_MOST] = {0.0}, y[RK4_MOST] = {0.0};
    for (int stage = 0; stage < 4; ++stage) {
        for (int i = 0; i < n; ++i) y[i] = x[i] + at[stage] * h * k[i];
        slope(user, t + at[stage] * h, y, k);
        for (int i = 0; i < n; ++i) sum[i] += weight[stage] * k[i];
    }
    for (int i = 0; i < n; ++i) x[i] += h / 6.0 * sum[i];
}

#endif
