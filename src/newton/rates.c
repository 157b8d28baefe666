/* Products with parts of the Newton matrix: with dF/dy' alone, and with the transpose of dF/dtau.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "base/error.h"
#include "newton/carried/record.h"
#include "newton/linear/product_transposed.h"

static int refuse_product(mbsr_newton *w, int status, const char *function, const char *text)
{
    return mbsri_fail(&w->error, status, MBSR_NONE, MBSR_NONE, "%s: %s", function, text);
}

static int check_product(mbsr_newton *w, const char *function, const double *in, const double *out,
                         size_t length)
{
    if (!in || !out) return refuse_product(w, MBSR_ERR_NULL, function, "a vector is NULL");
    if (!w->linearised)
        return refuse_product(w, MBSR_ERR_SEQUENCE, function,
                              "mbsr_newton_linearise has not run or has failed");
    if (!mbsri_finite(length, in))
        return refuse_product(w, MBSR_NOT_FINITE, function, "its argument is not finite");
    return MBSR_OK;
}

static size_t whole(const mbsr_newton *w)
{
    return (size_t)mbsr_dae_size(w->model, MBSR_DAE_MOMENTUM);
}

/* Hands out the result, which is in w->solution. */
static int hand_out(mbsr_newton *w, const char *function, double *out, size_t length)
{
    if (!mbsri_finite(length, w->solution))
        return refuse_product(w, MBSR_NOT_FINITE, function, "the product is not finite");
    mbsri_copy(length, w->solution, out);
    return MBSR_OK;
}

/* The matrix is dF/dy + c dF/dy': its product with c = 1, less that with c = 0. */
static int multiply_rate(mbsr_newton *w, const char *function, const double *in, double *out,
                         void (*product)(const mbsri_linear *, const double *, mbsri_vectors *,
                                         double *))
{
    const size_t size = whole(w);
    const int status = check_product(w, function, in, out, size);
    if (status) return status;
    mbsri_linear *linear = w->linear;
    const double c = linear->c;
    double *without = w->other;
    linear->c = 0.0;
    product(linear, in, &w->vectors, without);
    linear->c = 1.0;
    product(linear, in, &w->vectors, w->solution);
    linear->c = c;
    for (size_t k = 0; k < size; ++k) w->solution[k] -= without[k];
    return hand_out(w, function, out, size);
}

int mbsr_newton_multiply_rate(mbsr_newton *newton, const double *x, double *r)
{
    if (!newton) return MBSR_ERR_NULL;
    return multiply_rate(newton, "mbsr_newton_multiply_rate", x, r, mbsri_product);
}

int mbsr_newton_multiply_rate_transposed(mbsr_newton *newton, const double *r, double *x)
{
    if (!newton) return MBSR_ERR_NULL;
    return multiply_rate(newton, "mbsr_newton_multiply_rate_transposed", r, x,
                         mbsri_product_transposed);
}

int mbsr_newton_multiply_torque_transposed(mbsr_newton *newton, const double *r, double *tau)
{
    static const char name[] = "mbsr_newton_multiply_torque_transposed";
    if (!newton) return MBSR_ERR_NULL;
    const int status = check_product(newton, name, r, tau, whole(newton));
    if (status) return status;
    mbsri_product_of_torque_transposed(newton->linear, r, &newton->vectors, newton->solution);
    return hand_out(newton, name, tau, (size_t)newton->model->nu);
}
