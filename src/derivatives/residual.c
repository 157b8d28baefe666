/* Derivatives of the residual of the momentum form: products in y, y' and parameters.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Those in y and y' are products with the matrix of the Newton systems (newton/linear/product.h),
 * which is linear in c. Parameters enter where they stand (seed_values.h), on the way. */
#include "derivatives/record.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "dynamics/entry.h"
#include "newton/linear/product_transposed.h"
#include "recursion/backward.h"
#include "recursion/inverse.h"

static size_t length_of_y(const mbsr_derivatives *w)
{
    return (size_t)mbsr_dae_size(w->model, MBSR_DAE_MOMENTUM);
}

/* ---- linearising ---- */

/* Where no reaction is read, A and mu are those of u' = 0. */
static int linearise_residual(mbsr_derivatives *w, double t, const double *y, const double *yp)
{
    const mbsr_model *m = w->model;
    mbsri_linear *l = w->linear;
    mbsr_data *d = w->data;
    mbsri_seeds *seeds = &w->residual.seeds;
    bool below_massless = false;
    int status = mbsri_linear_open(l, d, t, y, yp, 0.0);
    for (int i = 1; i <= m->bodies && !below_massless; ++i) below_massless = l->below_massless[i];
    if (!status && !below_massless) {
        mbsri_zero((size_t)m->nu, w->right);
        mbsri_inverse(m, d, w->right);
    }
    if (!status) status = mbsri_linear_keep(l, d);
    seeds->loops = y + m->nq + 2 * m->nu;
    seeds->loops_rate = yp + m->nq + 2 * m->nu;
    if (!status) status = mbsri_seeds_find(seeds, l, d);
    seeds->loops = seeds->loops_rate = NULL;
    if (!status && m->order.grouped) status = mbsri_backward(m, d);
    return status;
}

int mbsr_derivatives_residual(mbsr_derivatives *derivatives, double t, const double *y,
                              const double *yp, double *F)
{
    static const char name[] = "mbsr_derivatives_residual";
    mbsr_derivatives *w = derivatives;
    if (!w) return MBSR_ERR_NULL;
    mbsri_derivatives_forget(w);
    if (!y || !yp)
        return mbsri_derivatives_refuse(w, MBSR_ERR_NULL, name, "a required pointer is NULL");
    int status =
        mbsr_dae_residual(w->model, w->data, MBSR_DAE_MOMENTUM, t, y, yp, w->residual.result);
    if (!status) status = mbsri_enter(w->model, w->data, true, MBSRI_STAGE_NONE, name);
    if (!status) status = linearise_residual(w, t, y, yp);
    if (status) return mbsri_derivatives_take_error(w, status);
    if (F) mbsri_copy(length_of_y(w), w->residual.result, F);
    w->at = MBSRI_LINEARISED_RESIDUAL;
    return MBSR_OK;
}

/* ---- products ---- */

static int check_residual(mbsr_derivatives *w, const char *name, const double *theta)
{
    if (w->at != MBSRI_LINEARISED_RESIDUAL)
        return mbsri_derivatives_refuse(w, MBSR_ERR_SEQUENCE, name,
                                        "call mbsr_derivatives_residual first");
    if (theta && w->residual.seeds.count == 0)
        return mbsri_derivatives_refuse(w, MBSR_ERR_SEQUENCE, name,
                                        "call mbsr_derivatives_parameters first");
    return MBSR_OK;
}

/* E x of dF/dy' = E, or with the transposed product E^T x, into `result`: with c = 1, less what
 * belongs to c = 0. */
static void multiply_rates(mbsr_derivatives *w, const double *x,
                           void (*product)(const mbsri_linear *, const double *, mbsri_vectors *,
                                           double *))
{
    mbsri_residual *z = &w->residual;
    mbsri_linear *l = w->linear;
    const size_t size = length_of_y(w);
    product(l, x, &z->vectors, z->other);
    l->c = 1.0;
    product(l, x, &z->vectors, z->result);
    l->c = 0.0;
    for (size_t k = 0; k < size; ++k) z->result[k] -= z->other[k];
}

/* A dy of dF/dy = A, and what parameters add along theta, onto `result`. */
static void add_places(mbsr_derivatives *w, const double *dy, const double *theta)
{
    mbsri_residual *z = &w->residual;
    mbsri_seeds *s = &z->seeds;
    const size_t size = length_of_y(w);
    if (theta) mbsri_seeds_along(s, theta);
    const mbsri_sources along = {s->sum[MBSRI_SEED_MOTION], s->sum[MBSRI_SEED_ACTION],
                                 s->sum[MBSRI_SEED_TORQUE], s->sum[MBSRI_SEED_PULSE],
                                 s->sum[MBSRI_SEED_LOAD],   s->sum[MBSRI_SEED_DRIFT],
                                 s->sum[MBSRI_SEED_SPRING], s->sum[MBSRI_SEED_ROW]};
    mbsri_zero(size, z->given);
    if (dy) mbsri_copy(size, dy, z->given);
    mbsri_product_with(w->linear, z->given, theta ? &along : NULL, &z->vectors, z->other);
    for (size_t k = 0; k < size; ++k) z->result[k] += z->other[k];
}

int mbsr_derivatives_residual_tangent(mbsr_derivatives *derivatives, const double *dy,
                                      const double *dyp, const double *dtheta, double *dF)
{
    static const char name[] = "mbsr_derivatives_residual_tangent";
    mbsr_derivatives *w = derivatives;
    if (!w) return MBSR_ERR_NULL;
    if (!dF) return mbsri_derivatives_refuse(w, MBSR_ERR_NULL, name, "dF is NULL");
    const int status = check_residual(w, name, dtheta);
    if (status) return status;
    mbsri_residual *z = &w->residual;
    const size_t size = length_of_y(w);
    if (!mbsri_finite_or_null(size, dy) || !mbsri_finite_or_null(size, dyp) ||
        !mbsri_finite_or_null((size_t)z->seeds.count, dtheta))
        return mbsri_derivatives_refuse(w, MBSR_NOT_FINITE, name,
                                        "dy, dyp or dtheta is not finite");
    if (dyp)
        multiply_rates(w, dyp, mbsri_product);
    else
        mbsri_zero(size, z->result);
    if (dy || dtheta) add_places(w, dy, dtheta);
    if (!mbsri_finite(size, z->result))
        return mbsri_derivatives_refuse(w, MBSR_NOT_FINITE, name, "it overflows");
    mbsri_copy(size, z->result, dF);
    return MBSR_OK;
}

int mbsr_derivatives_residual_adjoint(mbsr_derivatives *derivatives, const double *weights,
                                      double *by_y, double *by_yp, double *by_theta)
{
    static const char name[] = "mbsr_derivatives_residual_adjoint";
    mbsr_derivatives *w = derivatives;
    if (!w) return MBSR_ERR_NULL;
    if (!weights) return mbsri_derivatives_refuse(w, MBSR_ERR_NULL, name, "w is NULL");
    const int status = check_residual(w, name, by_theta);
    if (status) return status;
    mbsri_residual *z = &w->residual;
    mbsri_vectors *v = &z->vectors;
    const size_t size = length_of_y(w);
    if (!mbsri_finite(size, weights))
        return mbsri_derivatives_refuse(w, MBSR_NOT_FINITE, name, "w is not finite");
    mbsri_copy(size, weights, z->given);
    multiply_rates(w, z->given, mbsri_product_transposed);
    mbsri_product_transposed_with(w->linear, z->given, v, z->other, &z->sources);
    if (by_theta) {
        const double *const gradient[MBSRI_SEED_PLACES] = {
            [MBSRI_SEED_MOTION] = v->motion,       [MBSRI_SEED_TORQUE] = v->torque,
            [MBSRI_SEED_LOAD] = z->sources.load,   [MBSRI_SEED_SPRING] = z->sources.lambda,
            [MBSRI_SEED_ACTION] = v->action,       [MBSRI_SEED_PULSE] = z->sources.pulse,
            [MBSRI_SEED_DRIFT] = z->sources.drift, [MBSRI_SEED_ROW] = z->sources.rows};
        mbsri_seeds_back(&z->seeds, gradient);
    }
    if (!mbsri_finite(size, z->other) || !mbsri_finite(size, z->result) ||
        (by_theta && !mbsri_finite((size_t)z->seeds.count, z->seeds.by)))
        return mbsri_derivatives_refuse(w, MBSR_NOT_FINITE, name, "it overflows");
    if (by_theta) mbsri_copy((size_t)z->seeds.count, z->seeds.by, by_theta);
    if (by_y) mbsri_copy(size, z->other, by_y);
    if (by_yp) mbsri_copy(size, z->result, by_yp);
    return MBSR_OK;
}
