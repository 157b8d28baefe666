/* Operations on vectors: those of SUNDIALS, also where the output is one of the inputs; to the last
 * bit unless one of both multiplies and adds with one rounding.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"
#include "samples.h"

#include "ida/compat.h"
#include "ida/vectors.h"

#include <nvector/nvector_serial.h>

#include <math.h>
#include <stdbool.h>
#include <string.h>

enum { MOST = 7, LENGTHS = 9 };
static const int length[LENGTHS] = {1, 2, 3, 4, 5, 8, 17, 90, 1001};

/* Vectors with operations of SUNDIALS and of the library, filled alike. */
typedef struct pair {
    SUNContext context;
    N_Vector theirs[MOST], ours[MOST];
    int n;
    bool fused;
} pair;

static void ignore(void *user, int code, const char *message)
{
    (void)user, (void)code, (void)message;
}

static void fill(pair *p, test_rng *rng)
{
    for (int k = 0; k < MOST; ++k) {
        test_fill(rng, p->n, NV_DATA_S(p->theirs[k]));
        memcpy(NV_DATA_S(p->ours[k]), NV_DATA_S(p->theirs[k]), (size_t)p->n * sizeof(double));
    }
}

/* a x + b y = 2^-60 with one rounding, 0 with two. */
static bool fused(N_Vector x, N_Vector y)
{
    const double a = 1.0 + 0x1p-30;
    N_VConst(a, x);
    N_VConst(1.0 + 0x1p-29, y);
    N_VLinearSum(a, x, -1.0, y, x);
    return NV_DATA_S(x)[0] != 0.0;
}

static void open_pair(pair *p, mbsri_ida_messages *messages, int n)
{
    p->n = n;
    assert_true(mbsri_ida_context(&p->context, messages));
    for (int k = 0; k < MOST; ++k) {
        p->theirs[k] = N_VNew_Serial(n, p->context);
        p->ours[k] = k > 0 ? N_VClone(p->ours[0]) : N_VNew_Serial(n, p->context);
        if (k == 0) mbsri_ida_use_own_operations(p->ours[0]);
    }
    p->fused = fused(p->theirs[0], p->theirs[1]) || fused(p->ours[0], p->ours[1]);
    assert_true(p->ours[MOST - 1]->ops->nvscale != N_VScale_Serial); /* clones have them, too */
}

static void close_pair(pair *p)
{
    for (int k = 0; k < MOST; ++k) {
        N_VDestroy(p->theirs[k]);
        N_VDestroy(p->ours[k]);
    }
    SUNContext_Free(&p->context);
}

static void expect_same(const pair *p, double theirs, double ours)
{
    if (isnan(theirs) && isnan(ours)) return;
    const double most = p->fused ? 1e-13 * (1.0 + fabs(theirs)) : 0.0;
    if (!(fabs(theirs - ours) <= most)) fail_msg("%.17g instead of %.17g", ours, theirs);
}

static void expect_equal(const pair *p)
{
    for (int k = 0; k < MOST; ++k) {
        const double *theirs = NV_DATA_S(p->theirs[k]), *ours = NV_DATA_S(p->ours[k]);
        for (int l = 0; l < p->n; ++l) expect_same(p, theirs[l], ours[l]);
    }
}

/* Sums of two vectors with all factors that SUNDIALS treats apart, into a third and in place. */
static void try_sums(pair *p, test_rng *rng)
{
    static const double factor[] = {0.0, 1.0, -1.0, 0.3, -0.3, 7.1};
    enum { FACTORS = sizeof factor / sizeof factor[0] };
    static const int to[] = {0, 1, 2};
    for (int a = 0; a < FACTORS; ++a) {
        for (int b = 0; b < FACTORS; ++b) {
            for (int k = 0; k < 3; ++k) {
                N_Vector *const x = p->theirs, *const y = p->ours;
                fill(p, rng);
                N_VLinearSum(factor[a], x[0], factor[b], x[1], x[to[k]]);
                N_VLinearSum(factor[a], y[0], factor[b], y[1], y[to[k]]);
                expect_equal(p);
            }
            fill(p, rng);
            N_VScale(factor[a], p->theirs[0], p->theirs[b % 2]);
            N_VScale(factor[a], p->ours[0], p->ours[b % 2]);
            N_VConst(factor[b], p->theirs[3]);
            N_VConst(factor[b], p->ours[3]);
            expect_equal(p);
        }
    }
}

/* Combinations of one to MOST - 1 vectors, into another vector and into the first of them. */
static void try_combinations(pair *p, test_rng *rng)
{
    double factor[MOST];
    for (int count = 1; count < MOST; ++count) {
        for (int in_place = 0; in_place < 2; ++in_place) {
            const int to = in_place ? 0 : MOST - 1;
            fill(p, rng);
            test_fill(rng, MOST, factor);
            assert_int_equal(N_VLinearCombination(count, factor, p->theirs, p->theirs[to]), 0);
            assert_int_equal(N_VLinearCombination(count, factor, p->ours, p->ours[to]), 0);
            expect_equal(p);
            fill(p, rng);
            assert_int_equal(
                N_VScaleAddMulti(count, factor, p->theirs[MOST - 1], p->theirs, p->theirs), 0);
            assert_int_equal(N_VScaleAddMulti(count, factor, p->ours[MOST - 1], p->ours, p->ours),
                             0);
            expect_equal(p);
        }
    }
    assert_int_not_equal(N_VLinearCombination(0, factor, p->ours, p->ours[0]), 0);
}

static void try_norms(pair *p, test_rng *rng)
{
    N_Vector *const x = p->theirs, *const y = p->ours;
    fill(p, rng);
    for (int k = 0; k < p->n; k += 3) NV_DATA_S(x[2])[k] = NV_DATA_S(y[2])[k] = 0.0;
    expect_same(p, N_VDotProd(x[0], x[1]), N_VDotProd(y[0], y[1]));
    expect_same(p, N_VWrmsNorm(x[0], x[1]), N_VWrmsNorm(y[0], y[1]));
    expect_same(p, N_VWrmsNormMask(x[0], x[1], x[2]), N_VWrmsNormMask(y[0], y[1], y[2]));
    NV_DATA_S(x[0])[0] = NV_DATA_S(y[0])[0] = NAN; /* masked, id 0 */
    expect_same(p, N_VWrmsNormMask(x[0], x[1], x[2]), N_VWrmsNormMask(y[0], y[1], y[2]));
    assert_true(isnan(N_VWrmsNorm(y[0], y[1])));
}

static void results_are_those_of_sundials(void **state)
{
    (void)state;
    mbsri_ida_messages messages = {ignore, NULL};
    test_rng rng = test_seed(90);
    for (int k = 0; k < LENGTHS; ++k) {
        pair p;
        open_pair(&p, &messages, length[k]);
        try_sums(&p, &rng);
        try_combinations(&p, &rng);
        try_norms(&p, &rng);
        close_pair(&p);
    }
}

static double one(N_Vector x, N_Vector w)
{
    (void)x, (void)w;
    return 1.0;
}

static void what_somebody_has_replaced_stays(void **state)
{
    (void)state;
    mbsri_ida_messages messages = {ignore, NULL};
    SUNContext context;
    assert_true(mbsri_ida_context(&context, &messages));
    N_Vector v = N_VNew_Serial(3, context);
    v->ops->nvwrmsnorm = one;
    mbsri_ida_use_own_operations(v);
    assert_true(v->ops->nvwrmsnorm == one && v->ops->nvscale != N_VScale_Serial);
    N_VDestroy(v);
    SUNContext_Free(&context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(results_are_those_of_sundials),
        cmocka_unit_test(what_somebody_has_replaced_stays),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
