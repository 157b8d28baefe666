/* Parameters from data: published values, noise, bounds, what data cannot tell apart.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "close.h"

#include <mbsrank/fit.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* y = b0 (1 - exp(-b1 x)), which two of NIST's problems have. */
typedef struct curve {
    int n;
    const double *x, *y;
} curve;

static int saturate(void *user, const double *b, double *r)
{
    const curve *c = user;
    for (int k = 0; k < c->n; ++k) r[k] = b[0] * (1.0 - exp(-b[1] * c->x[k])) - c->y[k];
    return 0;
}

static mbsr_fit *fit_curve(curve *c, const double *start)
{
    mbsr_fit *f;
    mbsr_error error;
    mbsr_fit_opt opt = mbsr_default_fit_opt();
    opt.parameters = 2;
    opt.residuals = c->n;
    opt.start = start;
    opt.residual = saturate;
    opt.user = c;
    opt.tolerance = 1e-10;
    opt.step = 1e-4; /* the error of differences is that of its square */
    if (mbsr_fit_create(&opt, &f, &error)) fail_msg("%s", error.text);
    return f;
}

static void close_to(double x, double wanted, double relative)
{
    if (!(fabs(x - wanted) <= relative * fabs(wanted))) fail_msg("%.12g, not %.12g", x, wanted);
}

/* StRD, https://www.itl.nist.gov/div898/strd/nls/data/misra1a.shtml and boxbod.shtml: certified
 * values, deviations and sums of squares. */
static void published_values_and_deviations_come_out(void **state)
{
    static const double x1[] = {77.6,  114.9, 141.1, 190.8, 239.9, 289.0, 332.8,
                                378.4, 434.8, 477.3, 536.8, 593.1, 689.1, 760.0},
                        y1[] = {10.07, 14.73, 17.94, 23.93, 29.61, 35.18, 40.02,
                                44.82, 50.76, 55.05, 61.01, 66.40, 75.47, 81.78},
                        x2[] = {1, 2, 3, 5, 7, 10}, y2[] = {109, 149, 149, 191, 213, 224},
                        start1[2][2] = {{500, 1e-4}, {250, 5e-4}}, start2[2] = {100, 0.75};
    (void)state;
    curve misra = {14, x1, y1}, box = {6, x2, y2};
    for (int k = 0; k < 2; ++k) {
        mbsr_fit *f = fit_curve(&misra, start1[k]);
        close_to(f->value[0], 2.3894212918e+02, 1e-8);
        close_to(f->value[1], 5.5015643181e-04, 1e-8);
        close_to(f->deviation[0], 2.7070075241, 1e-5);
        close_to(f->deviation[1], 7.2668688436e-06, 1e-5);
        close_to(f->sum, 1.2455138894e-01, 1e-9);
        assert_int_equal(f->freedoms, 12);
        /* Student's 97.5 % for 12 freedoms: 2.178813 */
        close_to(f->high[0] - f->value[0], 2.178813 * 2.7070075241, 1e-5);
        mbsr_fit_destroy(f);
    }
    mbsr_fit *f = fit_curve(&box, start2);
    close_to(f->value[0], 2.1380940889e+02, 1e-8);
    close_to(f->value[1], 5.4723748542e-01, 1e-8);
    close_to(f->deviation[0], 1.2354515176e+01, 1e-5);
    close_to(f->deviation[1], 1.0455993237e-01, 1e-5);
    close_to(f->sum, 1.1680088766e+03, 1e-9);
    close_to(f->high[1] - f->value[1], 2.776445 * 1.0455993237e-01, 1e-3); /* 4 freedoms */
    mbsr_fit_destroy(f);
    mbsr_fit_destroy(NULL);
}

/* ---- a damped oscillation with noise ---- */

enum { SAMPLES = 60, PARAMETERS = 4 };
static const double truth[PARAMETERS] = {1.5, 0.3, 4.0, -0.2};

static double oscillate(const double *p, double t)
{
    return p[0] * exp(-p[1] * t) * cos(p[2] * t) + p[3];
}

static int compare(void *user, const double *p, double *r)
{
    const double *y = user;
    if (p[1] < 0.0) return 1; /* none that is asked for */
    for (int k = 0; k < SAMPLES; ++k) r[k] = (oscillate(p, 0.1 * k) - y[k]) / 0.05;
    return 0;
}

static double normal(test_rng *rng)
{
    double sum = 0.0;
    for (int k = 0; k < 12; ++k) sum += 0.5 * test_uniform(rng);
    return sum; /* twelve uniform numbers of variance 1 / 12 */
}

static void measure(test_rng *rng, double *y)
{
    for (int k = 0; k < SAMPLES; ++k) y[k] = oscillate(truth, 0.1 * k) + 0.05 * normal(rng);
}

static mbsr_fit_opt oscillation(double *y)
{
    static const double start[PARAMETERS] = {1.0, 0.1, 4.2, 0.0};
    mbsr_fit_opt opt = mbsr_default_fit_opt();
    opt.parameters = PARAMETERS;
    opt.residuals = SAMPLES;
    opt.start = start;
    opt.residual = compare;
    opt.user = y;
    return opt;
}

/* 2000 intervals, each to hold the truth in 95 %: between 93 and 97 % over all. */
static void intervals_hold_the_truth_as_often_as_they_say(void **state)
{
    (void)state;
    for (int known = 0; known < 2; ++known) {
        int inside = 0, all = 0;
        test_rng rng = test_seed(11);
        for (int k = 0; k < 500; ++k) {
            double y[SAMPLES];
            mbsr_fit *f;
            mbsr_error error;
            measure(&rng, y);
            mbsr_fit_opt opt = oscillation(y);
            opt.known_noise = known;
            if (mbsr_fit_create(&opt, &f, &error)) fail_msg("%s", error.text);
            for (int l = 0; l < PARAMETERS; ++l, ++all)
                inside += f->low[l] <= truth[l] && truth[l] <= f->high[l];
            assert_true(f->noise > 0.6 && f->noise < 1.4);
            mbsr_fit_destroy(f);
        }
        assert_in_range(1000 * inside / all, 930, 970);
    }
}

static void a_bound_holds_a_parameter_and_the_others_are_fitted(void **state)
{
    double y[SAMPLES];
    mbsr_fit *f, *other;
    mbsr_error error;
    (void)state;
    test_rng rng = test_seed(12);
    measure(&rng, y);
    const double low[PARAMETERS] = {-10, 0.0, 0.0, -10}, high[PARAMETERS] = {10, 0.2, 10, 10};
    mbsr_fit_opt opt = oscillation(y);
    opt.low = low;
    opt.high = high;
    if (mbsr_fit_create(&opt, &f, &error)) fail_msg("%s", error.text);
    assert_true(f->value[1] == 0.2);
    assert_int_equal(f->at_bound[1], 1);
    assert_int_equal(f->at_bound[0], 0);
    assert_true(f->deviation[1] == 0.0);
    assert_int_equal(f->freedoms, SAMPLES - 3);
    assert_true(isinf(f->direction_deviation[3]) && f->direction[3 * PARAMETERS + 1] == 1.0);
    /* no step of the others makes the sum less */
    for (int k = 0; k < PARAMETERS; ++k) {
        double slope = 0.0;
        for (int i = 0; i < SAMPLES; ++i) slope += f->jacobian[k * SAMPLES + i] * f->residual[i];
        if (k == 1)
            assert_true(slope < 0.0);
        else
            assert_true(fabs(slope) < 1e-3);
    }
    /* the same from elsewhere */
    const double start[PARAMETERS] = {2.0, 0.2, 3.8, 0.3};
    opt.start = start;
    if (mbsr_fit_create(&opt, &other, &error)) fail_msg("%s", error.text);
    for (int k = 0; k < PARAMETERS; ++k) assert_true(fabs(f->value[k] - other->value[k]) < 1e-6);
    mbsr_fit_destroy(other);
    mbsr_fit_destroy(f);
}

/* Student's 97.5 %: 2.228139 for 10 freedoms, 1.959964 where noise is known. */
static void intervals_have_the_freedoms_of_the_noise(void **state)
{
    static const double times[] = {2.228139, 1.959964};
    double y[SAMPLES];
    (void)state;
    test_rng rng = test_seed(14);
    measure(&rng, y);
    for (int known = 0; known < 2; ++known) {
        mbsr_fit *f;
        mbsr_fit_opt opt = oscillation(y);
        opt.noise_freedoms = 10;
        opt.known_noise = known;
        assert_int_equal(mbsr_fit_create(&opt, &f, NULL), MBSR_OK);
        close_to(f->high[2] - f->value[2], times[known] * f->deviation[2], 1e-5);
        close_to(f->value[2] - f->low[2], times[known] * f->deviation[2], 1e-5);
        mbsr_fit_destroy(f);
    }
}

/* Derivatives of `compare`; none where p1 is larger. */
static int slopes_of_oscillation(void *user, const double *p, double *J)
{
    (void)user;
    if (p[1] > 0.4) return 1;
    for (int k = 0; k < SAMPLES; ++k) {
        const double t = 0.1 * k, e = exp(-p[1] * t) / 0.05, c = cos(p[2] * t), s = sin(p[2] * t);
        J[k] = e * c;
        J[SAMPLES + k] = -t * p[0] * e * c;
        J[2 * SAMPLES + k] = -t * p[0] * e * s;
        J[3 * SAMPLES + k] = 1.0 / 0.05;
    }
    return 0;
}

/* The caller's derivatives save the differences, and give the same; where there are none it is
 * differences. */
static void derivatives_are_taken(void **state)
{
    double y[SAMPLES];
    mbsr_fit *f, *other;
    mbsr_error error;
    (void)state;
    test_rng rng = test_seed(14);
    measure(&rng, y);
    mbsr_fit_opt opt = oscillation(y);
    if (mbsr_fit_create(&opt, &f, &error)) fail_msg("%s", error.text);
    opt.slopes = slopes_of_oscillation;
    if (mbsr_fit_create(&opt, &other, &error)) fail_msg("%s", error.text);
    assert_true(other->evaluations < f->evaluations / 4);
    for (int k = 0; k < PARAMETERS; ++k) {
        assert_true(fabs(f->value[k] - other->value[k]) < 1e-7);
        close_to(other->deviation[k], f->deviation[k], 1e-4);
    }
    mbsr_fit_destroy(other);
    const double start[PARAMETERS] = {1.0, 0.5, 4.2, 0.0};
    opt.start = start;
    if (mbsr_fit_create(&opt, &other, &error)) fail_msg("%s", error.text);
    for (int k = 0; k < PARAMETERS; ++k) assert_true(fabs(f->value[k] - other->value[k]) < 1e-7);
    mbsr_fit_destroy(other);
    mbsr_fit_destroy(f);
}

/* r depends on p0 p1 and p2 alone. */
static int product(void *user, const double *p, double *r)
{
    (void)user;
    for (int k = 0; k < 20; ++k)
        r[k] = p[0] * p[1] * sin(k) + p[2] * cos(2 * k) - 6.0 * sin(k) - cos(2 * k) +
               0.01 * sin(7 * k * k);
    return 0;
}

static void what_data_cannot_tell_apart_is_named(void **state)
{
    const double start[] = {1.0, 5.0, 0.5};
    mbsr_fit *f;
    mbsr_error error;
    (void)state;
    mbsr_fit_opt opt = mbsr_default_fit_opt();
    opt.parameters = 3;
    opt.residuals = 20;
    opt.start = start;
    opt.residual = product;
    if (mbsr_fit_create(&opt, &f, &error)) fail_msg("%s", error.text);
    close_to(f->value[0] * f->value[1], 6.0, 1e-2);
    close_to(f->value[2], 1.0, 2e-2);
    assert_true(f->direction_deviation[0] < 0.01 && f->direction_deviation[1] < 0.02);
    assert_true(f->direction_deviation[2] > 100.0);
    /* along it the product stays: d0 scale0 / p0 + d1 scale1 / p1 = 0 */
    const double *d = f->direction + 6;
    assert_true(fabs(d[0] * f->scale[0] / f->value[0] + d[1] * f->scale[1] / f->value[1]) < 1e-4);
    assert_true(fabs(d[2]) < 1e-4 && hypot(d[0], d[1]) > 0.999);
    assert_true(f->deviation[0] > 1.0 && f->deviation[1] > 1.0);
    assert_true(f->deviation[2] < 0.01);
    mbsr_fit_destroy(f);
}

static int refuse_all(void *user, const double *p, double *r)
{
    (void)p, (void)r;
    return *(int *)user;
}

static int stop_at_once(void *user, const mbsr_fit_progress *now)
{
    (void)user;
    return now->iteration == 1 ? 77 : 0;
}

static void wrong_use_is_refused(void **state)
{
    double y[SAMPLES], wrong[PARAMETERS] = {1, NAN, 1, 1}, ok[PARAMETERS] = {2, 0.1, 4, 0};
    mbsr_fit *f;
    mbsr_error error;
    (void)state;
    test_rng rng = test_seed(13);
    measure(&rng, y);
    mbsr_fit_opt opt = {0};
    assert_int_equal(mbsr_fit_create(&opt, &f, &error), MBSR_ERR_NO_DEFAULT);
    assert_int_equal(mbsr_fit_create(NULL, &f, NULL), MBSR_ERR_NULL);
    opt = oscillation(y);
    assert_int_equal(mbsr_fit_create(&opt, NULL, NULL), MBSR_ERR_NULL);
    opt.start = NULL;
    assert_int_equal(mbsr_fit_create(&opt, &f, &error), MBSR_ERR_NULL);
    opt = oscillation(y);
    opt.residual = NULL;
    assert_int_equal(mbsr_fit_create(&opt, &f, &error), MBSR_ERR_NULL);
    opt = oscillation(y);
    opt.residuals = PARAMETERS;
    assert_int_equal(mbsr_fit_create(&opt, &f, &error), MBSR_ERR_VALUE);
    opt = oscillation(y);
    opt.start = wrong;
    assert_int_equal(mbsr_fit_create(&opt, &f, &error), MBSR_NOT_FINITE);
    assert_non_null(strstr(error.text, "start[1] is nan"));
    opt = oscillation(y);
    opt.low = ok;
    assert_int_equal(mbsr_fit_create(&opt, &f, &error), MBSR_ERR_VALUE);
    opt = oscillation(y);
    opt.high = opt.low = ok;
    assert_int_equal(mbsr_fit_create(&opt, &f, &error), MBSR_ERR_VALUE);
    opt = oscillation(y);
    opt.scale = wrong;
    assert_int_equal(mbsr_fit_create(&opt, &f, &error), MBSR_ERR_VALUE);
    opt = oscillation(y);
    opt.confidence = 1.0;
    assert_int_equal(mbsr_fit_create(&opt, &f, &error), MBSR_ERR_VALUE);
    opt = oscillation(y);
    opt.noise_freedoms = -1;
    assert_int_equal(mbsr_fit_create(&opt, &f, &error), MBSR_ERR_VALUE);
    opt = oscillation(y);
    opt.step = 0.0;
    assert_int_equal(mbsr_fit_create(&opt, &f, &error), MBSR_ERR_VALUE);
    opt.step = 1.0;
    assert_int_equal(mbsr_fit_create(&opt, &f, &error), MBSR_ERR_VALUE);
    opt = oscillation(y);
    opt.tolerance = 0.0;
    assert_int_equal(mbsr_fit_create(&opt, &f, &error), MBSR_ERR_VALUE);
    opt = oscillation(y);
    opt.max_iterations = 0;
    assert_int_equal(mbsr_fit_create(&opt, &f, &error), MBSR_ERR_VALUE);
    opt = oscillation(y);
    opt.confidence = 0.0;
    assert_int_equal(mbsr_fit_create(&opt, &f, &error), MBSR_ERR_VALUE);
    opt = oscillation(y);
    opt.parameters = 0;
    assert_int_equal(mbsr_fit_create(&opt, &f, &error), MBSR_ERR_VALUE);
    opt.parameters = 1 << 12, opt.residuals = 1 << 20;
    assert_int_equal(mbsr_fit_create(&opt, &f, &error), MBSR_ERR_VALUE);
    const double below[PARAMETERS] = {-1e9, -1e9, -1e9, -1e9}, lower[PARAMETERS] = {-1, 9, 9, 9};
    opt = oscillation(y);
    opt.low = below, opt.high = lower;
    assert_int_equal(mbsr_fit_create(&opt, &f, &error), MBSR_ERR_VALUE);
    assert_non_null(strstr(error.text, "is not in -1e+09 .. -1"));
    opt = oscillation(y);
    opt.max_iterations = 1;
    assert_int_equal(mbsr_fit_create(&opt, &f, &error), MBSR_NO_CONVERGENCE);
    assert_null(f);
    opt = oscillation(y);
    opt.progress = stop_at_once;
    assert_int_equal(mbsr_fit_create(&opt, &f, &error), 77);
    int status = -5;
    opt = oscillation(y);
    opt.residual = refuse_all;
    opt.user = &status;
    assert_int_equal(mbsr_fit_create(&opt, &f, &error), -5);
    y[3] = NAN;
    opt = oscillation(y);
    assert_int_equal(mbsr_fit_create(&opt, &f, &error), MBSR_NOT_FINITE);
}

/* ---- residuals that are not finite ---- */

static long compared, odd_at;

static int compare_oddly(void *user, const double *p, double *r)
{
    const int status = compare(user, p, r);
    if (++compared == odd_at) r[odd_at % SAMPLES] = odd_at % 2 ? NAN : INFINITY;
    return status;
}

/* At each call in turn: another step is taken, or the fit says so. */
static void no_fit_is_not_finite(void **state)
{
    (void)state;
    double y[SAMPLES];
    test_rng rng = test_seed(5);
    measure(&rng, y);
    mbsr_fit_opt opt = oscillation(y);
    opt.residual = compare_oddly;
    long calls = 1;
    for (odd_at = 0; odd_at <= calls; ++odd_at) {
        mbsr_fit *f = NULL;
        mbsr_error error = {.text = ""};
        compared = 0;
        const int status = mbsr_fit_create(&opt, &f, &error);
        if (odd_at == 0) calls = compared;
        if (odd_at == 1) assert_int_equal(status, MBSR_NOT_FINITE); /* at the start */
        if (status) assert_true(odd_at > 0 && !f && error.text[0]);
        for (int k = 0; k < PARAMETERS && !status; ++k)
            assert_true(isfinite(f->value[k]) && isfinite(f->deviation[k]));
        for (int k = 0; k < SAMPLES && !status; ++k) assert_true(isfinite(f->residual[k]));
        mbsr_fit_destroy(f);
    }
    assert_in_range(calls, 10, 1000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(published_values_and_deviations_come_out),
        cmocka_unit_test(intervals_hold_the_truth_as_often_as_they_say),
        cmocka_unit_test(a_bound_holds_a_parameter_and_the_others_are_fitted),
        cmocka_unit_test(intervals_have_the_freedoms_of_the_noise),
        cmocka_unit_test(derivatives_are_taken),
        cmocka_unit_test(what_data_cannot_tell_apart_is_named),
        cmocka_unit_test(wrong_use_is_refused),
        cmocka_unit_test(no_fit_is_not_finite),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
