/* Parameters from measured data by nonlinear least squares (component study).
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   mbsr_fit_opt opt = mbsr_default_fit_opt();
 *   opt.parameters = 2, opt.residuals = 100, opt.start = start, opt.residual = compare;
 *   mbsr_fit_create(&opt, &fit, &error);
 *   printf("%g +- %g\n", fit->value[0], fit->deviation[0]);
 *   mbsr_fit_destroy(fit);
 *
 * Looks for p that makes sum r_i(p)^2 / 2 least, r_i = (computed - measured) / noise, by the method
 * of Levenberg and Marquardt in relative coordinates p / scale, between bounds. */
#ifndef MBSRANK_FIT_H
#define MBSRANK_FIT_H

#include <mbsrank/base.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Writes all residuals at p. Returns 0 or a status: a positive one makes the step shorter, a
 * negative one ends the fit. */
typedef int (*mbsr_fit_fn)(void *user, const double *p, double *r);

/* Writes d r / d p at p (residuals x parameters, column-major). Returns as mbsr_fit_fn does, but
 * that after a positive status the derivatives are differences of residuals this time. */
typedef int (*mbsr_fit_slopes_fn)(void *user, const double *p, double *J);

/* How far a fit is, for a progress function. */
typedef struct mbsr_fit_progress {
    int iteration, evaluations;
    double sum;      /* of squares */
    const double *p; /* parameters */
} mbsr_fit_progress;

/* Called after each iteration; another return value than 0 ends the fit with it. */
typedef int (*mbsr_fit_progress_fn)(void *user, const mbsr_fit_progress *now);

typedef struct mbsr_fit_opt {
    int cookie;                /* set by mbsr_default_fit_opt */
    int parameters, residuals; /* how many; residuals > parameters */
    const double *start;       /* parameters */
    const double *low, *high;  /* bounds, low < high; NULL: none */
    const double *scale;       /* of each parameter, > 0; NULL: |start|, or 1 where that is 0 */
    mbsr_fit_fn residual;
    mbsr_fit_slopes_fn slopes; /* NULL (default): central differences */
    void *user;
    double step;        /* of central differences, over scale; default 1e-3 */
    double tolerance;   /* of the last change, over scale; default 1e-8 */
    int max_iterations; /* default 100 */
    int known_noise;    /* 1: residuals have the deviation 1; 0 (default): it is estimated */
    int noise_freedoms; /* of Student's distribution where noise is estimated: residuals behind the
                         * estimate of a single weight; 0 (default): all less parameters */
    double confidence;  /* of the intervals, default 0.95 */
    mbsr_fit_progress_fn progress; /* NULL (default): none */
    void *progress_user;
    mbsr_allocator allocator; /* default: malloc and free (both functions NULL) */
} mbsr_fit_opt;

MBSR_API mbsr_fit_opt mbsr_default_fit_opt(void);

/* What was found. Deviations and intervals are those of the problem linearised there, with
 * Student's distribution where noise is estimated. A parameter at a bound is held there: it has
 * none, and those of the others hold for it as it is. */
typedef struct mbsr_fit {
    int parameters, residuals;
    const double *value;      /* parameters */
    const double *deviation;  /* of them; INFINITY: the data do not tell them */
    const double *low, *high; /* intervals of the confidence asked for, bounds not regarded */
    const int *at_bound;      /* parameters: -1, 1: at the lower, upper one; else 0 */
    const double *residual;   /* at value */
    const double *jacobian;   /* residuals x parameters, column-major: d residual / d value */
    double sum;               /* of squares of the residuals */
    double noise;             /* deviation of the residuals, estimated: sum / freedoms, its root */
    int freedoms;             /* residuals less parameters that are not held */
    /* Directions in p / scale, orthogonal, of length 1, from the best known to the worst:
     * direction k is direction[k * parameters ...]. The data tell p along it up to direction_
     * deviation[k] times it: where that is 1, they do not tell a parameter from 0. Parameters
     * that are held come last, with INFINITY. */
    const double *direction, *direction_deviation;
    const double *scale; /* that was used */
    int iterations, evaluations;
    const struct mbsr_fit_memory *memory; /* its own */
} mbsr_fit;

/* On failure *fit is NULL and the reason in *error (may be NULL). MBSR_ERR_NULL,
 * MBSR_ERR_NO_DEFAULT, MBSR_ERR_VALUE (counts, start, bounds, scale, other options; the text names
 * which), MBSR_NOT_FINITE (a residual at the start), MBSR_NO_CONVERGENCE, MBSR_ERR_NO_MEMORY, what
 * `residual` returned at the start or `progress` at any time. */
MBSR_API int mbsr_fit_create(const mbsr_fit_opt *opt, mbsr_fit **fit, mbsr_error *error);
MBSR_API void mbsr_fit_destroy(mbsr_fit *fit); /* NULL is allowed */

#ifdef __cplusplus
}
#endif

#endif
