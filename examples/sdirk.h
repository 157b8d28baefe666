/* A solver of one's own for F(t, y, y') = 0 in the momentum form, with steps in O(N), from
 * mbsr_dae_residual, mbsr_newton_factor and mbsr_newton_solve. To be read, and copied.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Method: the SDIRK of three stages, order 3 and L-stable (R. Alexander, SIAM J. Numer. Anal. 14,
 * 1977, 1006-1021)
 *
 *   Y_i = y_n + h sum_j a_ij K_j,   F(t_n + c_i h, Y_i, K_i) = 0,   y_n+1 = Y_3
 *
 *   c_i            a_ij
 *   g              g                           g^3 - 3 g^2 + 3/2 g - 1/6 = 0, g = 0.43587
 *   (1 + g) / 2    (1 - g) / 2   g             b_1 = -(6 g^2 - 16 g + 1) / 4
 *   1              b_1           b_2    g      b_2 =  (6 g^2 - 20 g + 5) / 4
 *
 * The last stage is the result, so the algebraic equations hold in it as in every stage. F does not
 * contain u', hence the u of a stage do not depend on earlier ones: velocities without mass have no
 * history, and where dampers determine them (index 1) they need no consistent start.
 *
 * Newton's method: K_i = (Y_i - what is known) / (h g), so dK/dY = c = 1 / (h g) in every stage.
 * One factorisation serves the three stages and all steps of that size; it is made anew when h has
 * changed and after iterations that converged slowly. Methods with coupled stages (Radau IIA) have
 * complex c as well; mbsr_newton_factor takes real ones.
 *
 * Error: the weights w = (g, 1 - 2 g, 0) / (1 - g) give order 2, and e = h sum (b_i - w_i) K_i the
 * error of that. Stiff components are far too large in it. With c dF/dy' e on its right-hand side
 * the Newton system gives (1 - h g df/dy)^-1 e for y' = f(y), which they do not dominate (L. F.
 * Shampine's filter). u is algebraic and left out of the test. The next step is
 *
 *   h <- h min(4, max(0.2, 0.9 |e|^(-1/3)))
 *
 * but stays where it would grow by less than a fifth, which spares a factorisation.
 *
 * Norm: the largest of |e_k| / tolerance_k. With the root of the mean square one body among N could
 * be wrong by sqrt(N) tolerances. The tolerance is rtol |q| + atol, likewise for u, and for a
 * momentum that of its velocity times the mass on the joint. */
#ifndef EXAMPLES_SDIRK_H
#define EXAMPLES_SDIRK_H

#include "build.h"

#include <mbsrank/driver.h>

#include <math.h>
#include <stdbool.h>
#include <string.h>

enum { SDIRK_STAGES = 3, SDIRK_ITERATIONS = 8 };

typedef struct sdirk {
    const mbsr_model *m;
    mbsr_data *d;
    mbsr_newton *newton;
    int nq, nu, size;
    double rtol, atol;
    double *memory, *mass;                     /* nu: on the joint of each velocity */
    double t, h;                               /* h: the next step's */
    double *y, *yp;                            /* the present state */
    double *Y[SDIRK_STAGES], *K[SDIRK_STAGES]; /* stages of the last step */
    double a[SDIRK_STAGES][SDIRK_STAGES], at[SDIRK_STAGES], error[SDIRK_STAGES];
    double *F, *delta;
    double factored; /* c of the factorisation; 0: make a new one */
    long steps, rejected, failures, residuals;
} sdirk;

static inline void sdirk_coefficients(sdirk *s)
{
    const double g = 0.43586652150845899942, w = (1.0 - 2.0 * g) / (1.0 - g);
    const double b1 = -(6.0 * g * g - 16.0 * g + 1.0) / 4.0,
                 b2 = (6.0 * g * g - 20.0 * g + 5.0) / 4.0;
    const double a[SDIRK_STAGES][SDIRK_STAGES] = {{g}, {0.5 * (1.0 - g), g}, {b1, b2, g}};
    const double at[] = {g, 0.5 * (1.0 + g), 1.0}, error[] = {b1 - g / (1.0 - g), b2 - w, g};
    memcpy(s->a, a, sizeof a);
    memcpy(s->at, at, sizeof at);
    memcpy(s->error, error, sizeof error);
}

/* The mass on each joint, at the present state. */
static inline void sdirk_masses(sdirk *s)
{
    check(mbsr_stage_positions(s->m, s->d, s->t, s->y), mbsr_data_error(s->d));
    check(mbsr_stage_velocities(s->m, s->d, s->y + s->nq + s->nu), mbsr_data_error(s->d));
    check(mbsr_stage_forces(s->m, s->d, NULL), mbsr_data_error(s->d));
    check(mbsr_stage_backward(s->m, s->d), mbsr_data_error(s->d));
    check(mbsr_momentum_scales(s->m, s->d, s->mass), mbsr_data_error(s->d));
}

/* Starts at y (momentum form) with a guess of the first step. */
static inline sdirk sdirk_start(const mbsr_model *m, mbsr_data *d, double t, const double *y,
                                double h, double tolerance)
{
    sdirk s = {.m = m, .d = d, .rtol = tolerance, .atol = tolerance, .t = t, .h = h};
    mbsr_error error;
    check(mbsr_newton_create(m, MBSR_DAE_MOMENTUM, NULL, &s.newton, &error), &error);
    s.nq = mbsr_model_nq(m);
    s.nu = mbsr_model_nu(m);
    s.size = mbsr_dae_size(m, MBSR_DAE_MOMENTUM);
    double **const vector[] = {&s.y,    &s.yp,   &s.F,    &s.delta, &s.Y[0],
                               &s.Y[1], &s.Y[2], &s.K[0], &s.K[1],  &s.K[2]};
    const size_t count = sizeof vector / sizeof vector[0];
    s.memory = calloc(count * (size_t)s.size + (size_t)s.nu, sizeof *s.memory);
    if (!s.memory) exit(1);
    for (size_t k = 0; k < count; ++k) *vector[k] = s.memory + k * (size_t)s.size;
    s.mass = s.memory + count * (size_t)s.size;
    sdirk_coefficients(&s);
    memcpy(s.y, y, (size_t)s.size * sizeof *y);
    sdirk_masses(&s);
    /* F = y' - f in q and p */
    check(mbsr_dae_residual(m, d, MBSR_DAE_MOMENTUM, t, s.y, s.yp, s.F), mbsr_data_error(d));
    for (int k = 0; k < s.nq + s.nu; ++k) s.yp[k] = -s.F[k];
    return s;
}

static inline void sdirk_end(sdirk *s)
{
    mbsr_newton_destroy(s->newton);
    free(s->memory);
}

/* The largest of the first `count` entries of e, over their tolerances. */
static inline double sdirk_norm(const sdirk *s, int count, const double *e)
{
    double largest = 0.0;
    for (int k = 0; k < count; ++k) {
        const bool momentum = k >= s->nq && k < s->nq + s->nu;
        const double mass = momentum ? s->mass[k - s->nq] : 1.0;
        const double size = fabs(s->y[momentum ? k + s->nu : k]);
        largest = fmax(largest, fabs(e[k]) / (mass * (s->rtol * size + s->atol)));
    }
    return largest;
}

/* Newton's iterations of stage i, from a guess in Y_i and K_i: 0 or a recoverable status;
 * MBSR_NO_CONVERGENCE. */
static inline int sdirk_iterate(sdirk *s, int i, double c)
{
    double last = 0.0, *Y = s->Y[i], *K = s->K[i];
    for (int k = 0; k < SDIRK_ITERATIONS; ++k) {
        int status =
            mbsr_dae_residual(s->m, s->d, MBSR_DAE_MOMENTUM, s->t + s->at[i] * s->h, Y, K, s->F);
        ++s->residuals;
        if (!status) status = mbsr_newton_solve(s->newton, s->F, s->delta);
        if (status) return status;
        for (int l = 0; l < s->size; ++l) {
            Y[l] -= s->delta[l];
            K[l] -= c * s->delta[l];
        }
        const double norm = sdirk_norm(s, s->size, s->delta), rate = k ? norm / last : 0.5;
        if (k && rate > 0.2) s->factored = 0.0; /* slow: a new one next time */
        if (norm * rate <= 0.02 * (1.0 - rate)) return MBSR_OK;
        if (rate >= 1.0) return MBSR_NO_CONVERGENCE;
        last = norm;
    }
    return MBSR_NO_CONVERGENCE;
}

/* The stages of a step: slopes are guessed on the line through the last two known. */
static inline int sdirk_stages(sdirk *s)
{
    const double g = s->a[0][0], c = 1.0 / (g * s->h);
    if (s->factored != c) {
        s->factored = 0.0;
        const int status = mbsr_newton_factor(s->newton, s->d, s->t, s->y, s->yp, c);
        if (status) return status;
        s->factored = c;
    }
    for (int i = 0; i < SDIRK_STAGES; ++i) {
        const double *now = i > 0 ? s->K[i - 1] : s->yp, *before = i > 1 ? s->K[i - 2] : s->yp;
        const double line = i > 1   ? (s->at[i] - s->at[i - 1]) / (s->at[i - 1] - s->at[i - 2])
                            : i > 0 ? (s->at[1] - s->at[0]) / s->at[0]
                                    : 0.0;
        for (int k = 0; k < s->size; ++k) {
            s->K[i][k] = now[k] + line * (now[k] - before[k]);
            s->Y[i][k] = s->y[k];
            for (int j = 0; j <= i; ++j) s->Y[i][k] += s->h * s->a[i][j] * s->K[j][k];
        }
        const int status = sdirk_iterate(s, i, c);
        if (status) return status;
    }
    return MBSR_OK;
}

/* |e|: the right-hand side is c dF/dy' e, with dF/dy' = 1 for q and p and 0 for u. */
static inline double sdirk_error(sdirk *s)
{
    const double c = 1.0 / (s->a[0][0] * s->h);
    memset(s->F, 0, (size_t)s->size * sizeof *s->F);
    for (int k = 0; k < s->nq + s->nu; ++k) {
        for (int i = 0; i < SDIRK_STAGES; ++i) s->F[k] += c * s->h * s->error[i] * s->K[i][k];
    }
    check(mbsr_newton_solve(s->newton, s->F, s->delta), mbsr_newton_error(s->newton));
    return sdirk_norm(s, s->nq + s->nu, s->delta);
}

/* One step, which ends at t_end at the latest; returns its size. Its stages stay in Y and K. */
static inline double sdirk_step(sdirk *s, double t_end)
{
    for (int tries = 0; tries < 50; ++tries) {
        if (s->t + 1.01 * s->h > t_end) s->h = t_end - s->t;
        const bool fresh = s->factored == 0.0 || s->factored != 1.0 / (s->a[0][0] * s->h);
        const int status = sdirk_stages(s);
        if (status < 0) check(status, mbsr_data_error(s->d));
        if (status > 0) { /* first try a new factorisation, then a smaller step */
            ++s->failures;
            s->factored = 0.0;
            if (fresh) s->h *= 0.25;
            continue;
        }
        const double error = sdirk_error(s), h = s->h;
        const double factor = fmin(4.0, fmax(0.2, 0.9 / cbrt(error)));
        if (factor < 1.0 || factor > 1.2) s->h *= factor;
        if (error > 1.0) {
            ++s->rejected;
            continue;
        }
        memcpy(s->y, s->Y[SDIRK_STAGES - 1], (size_t)s->size * sizeof *s->y);
        memcpy(s->yp, s->K[SDIRK_STAGES - 1], (size_t)s->size * sizeof *s->yp);
        s->t += h;
        ++s->steps;
        return h;
    }
    fprintf(stderr, "sdirk_step: no step at t = %g, h = %g\n", s->t, s->h);
    exit(1);
}

#endif
