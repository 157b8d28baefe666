/* Operations on serial vectors: see vectors.h. An output may be one of the inputs, as N_Vector
 * allows.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "ida/vectors.h"

#include "ida/compat.h"

#include <nvector/nvector_serial.h>

#include <math.h>

/* In the loops below entry k of the output depends on the entries k of the inputs only: GCC asks to
 * be told, Clang checks at run time. */
#if defined(__GNUC__) && !defined(__clang__)
#define EACH_ALONE _Pragma("GCC ivdep")
#else
#define EACH_ALONE
#endif

static void set(sunrealtype c, N_Vector z)
{
    const sunindextype n = NV_LENGTH_S(z);
    double *to = NV_DATA_S(z);
    for (sunindextype k = 0; k < n; ++k) to[k] = c;
}

static void scale(sunrealtype c, N_Vector x, N_Vector z)
{
    const sunindextype n = NV_LENGTH_S(x);
    const double *from = NV_DATA_S(x);
    double *to = NV_DATA_S(z);
    EACH_ALONE
    for (sunindextype k = 0; k < n; ++k) to[k] = c * from[k];
}

/* z = a (x + y) */
static void scaled_sum(double a, sunindextype n, const double *x, const double *y, double *z)
{
    EACH_ALONE
    for (sunindextype k = 0; k < n; ++k) z[k] = a * (x[k] + y[k]);
}

/* z = a (x - y) */
static void scaled_difference(double a, sunindextype n, const double *x, const double *y, double *z)
{
    EACH_ALONE
    for (sunindextype k = 0; k < n; ++k) z[k] = a * (x[k] - y[k]);
}

/* z = a x + b y; equal factors are taken out, as SUNDIALS does. */
static void linear_sum(sunrealtype a, N_Vector x, sunrealtype b, N_Vector y, N_Vector z)
{
    const sunindextype n = NV_LENGTH_S(x);
    const double *first = NV_DATA_S(x), *second = NV_DATA_S(y);
    double *to = NV_DATA_S(z);
    if (a == b && a != 1.0) {
        scaled_sum(a, n, first, second, to);
    } else if (a == -b && fabs(a) != 1.0) {
        scaled_difference(a, n, first, second, to);
    } else {
        EACH_ALONE
        for (sunindextype k = 0; k < n; ++k) to[k] = a * first[k] + b * second[k];
    }
}

/* z += a x + b y, one after the other */
static void add_two(sunrealtype a, N_Vector x, sunrealtype b, N_Vector y, N_Vector z)
{
    const sunindextype n = NV_LENGTH_S(z);
    const double *first = NV_DATA_S(x), *second = NV_DATA_S(y);
    double *to = NV_DATA_S(z);
    EACH_ALONE
    for (sunindextype k = 0; k < n; ++k) to[k] = (to[k] + a * first[k]) + b * second[k];
}

/* z = sum_k c_k X_k; z may be X_0. */
static int combine(int count, sunrealtype *c, N_Vector *X, N_Vector z)
{
    int next = 2;
    if (count < 1) return -1;
    if (count == 1)
        scale(c[0], X[0], z);
    else
        linear_sum(c[0], X[0], c[1], X[1], z);
    for (; next + 1 < count; next += 2) add_two(c[next], X[next], c[next + 1], X[next + 1], z);
    if (next < count) linear_sum(1.0, z, c[next], X[next], z);
    return 0;
}

/* Z_k = c_k x + Y_k */
static int add_multiples(int count, sunrealtype *c, N_Vector x, N_Vector *Y, N_Vector *Z)
{
    if (count < 1) return -1;
    for (int k = 0; k < count; ++k) linear_sum(c[k], x, 1.0, Y[k], Z[k]);
    return 0;
}

static double dot(N_Vector x, N_Vector y)
{
    const sunindextype n = NV_LENGTH_S(x);
    const double *a = NV_DATA_S(x), *b = NV_DATA_S(y);
    double sum = 0.0;
    for (sunindextype k = 0; k < n; ++k) sum += a[k] * b[k];
    return sum;
}

static double square(double x)
{
    return x * x;
}

/* sqrt(sum_k (x_k w_k)^2 / n) */
static sunrealtype norm(N_Vector x, N_Vector w)
{
    const sunindextype n = NV_LENGTH_S(x);
    const double *value = NV_DATA_S(x), *weight = NV_DATA_S(w);
    double sum = 0.0;
    for (sunindextype k = 0; k < n; ++k) sum += square(value[k] * weight[k]);
    return sqrt(sum / (double)n);
}

/* The same of the entries whose id is positive; the others count in n. */
static sunrealtype masked_norm(N_Vector x, N_Vector w, N_Vector id)
{
    const sunindextype n = NV_LENGTH_S(x);
    const double *value = NV_DATA_S(x), *weight = NV_DATA_S(w), *counts = NV_DATA_S(id);
    double sum = 0.0;
    for (sunindextype k = 0; k < n; ++k)
        sum += counts[k] > 0.0 ? square(value[k] * weight[k]) : 0.0;
    return sqrt(sum / (double)n);
}

void mbsri_ida_use_own_operations(N_Vector v)
{
    struct _generic_N_Vector_Ops *ops = v->ops;
    if (ops->nvconst == N_VConst_Serial) ops->nvconst = set;
    if (ops->nvscale == N_VScale_Serial) ops->nvscale = scale;
    if (ops->nvlinearsum == N_VLinearSum_Serial) ops->nvlinearsum = linear_sum;
    if (!ops->nvlinearcombination) ops->nvlinearcombination = combine;
    if (!ops->nvscaleaddmulti) ops->nvscaleaddmulti = add_multiples;
    if (ops->nvdotprod == N_VDotProd_Serial) ops->nvdotprod = dot;
    if (ops->nvwrmsnorm == N_VWrmsNorm_Serial) ops->nvwrmsnorm = norm;
    if (ops->nvwrmsnormmask == N_VWrmsNormMask_Serial) ops->nvwrmsnormmask = masked_norm;
}
