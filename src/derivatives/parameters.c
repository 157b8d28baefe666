/* Derivatives in parameters of the model: entries.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "derivatives/record.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "base/error.h"

static int refuse_seeds(mbsr_derivatives *w, int status, const char *function, const char *text)
{
    return mbsri_fail(&w->error, status, MBSR_NONE, MBSR_NONE, "%s: %s", function, text);
}

int mbsr_derivatives_parameters(mbsr_derivatives *derivatives, const mbsr_parameters *list,
                                int count, const int *which)
{
    static const char name[] = "mbsr_derivatives_parameters";
    mbsr_derivatives *w = derivatives;
    if (!w) return MBSR_ERR_NULL;
    if (count < 0) return refuse_seeds(w, MBSR_ERR_VALUE, name, "count is negative");
    if (count > 0 && (!list || !which))
        return refuse_seeds(w, MBSR_ERR_NULL, name, "list or which is NULL");
    for (int k = 0; k < count; ++k)
        if (which[k] < 0 || which[k] >= mbsr_parameters_count(list))
            return mbsri_fail(&w->error, MBSR_ERR_ID, MBSR_NONE, MBSR_NONE,
                              "%s: which[%d] is %d, but there are %d parameters", name, k, which[k],
                              mbsr_parameters_count(list));
    mbsri_seeds made = {.count = 0};
    const int status =
        count == 0 ? MBSR_OK
                   : mbsri_seeds_create(&made, w->linear, list, count, which, name, &w->error);
    if (status) return status;
    mbsri_derivatives_forget(w);
    mbsri_seeds_destroy(&w->seeds, w->model);
    w->seeds = made;
    return MBSR_OK;
}

static int check_seeds(mbsr_derivatives *w, const char *name)
{
    if (w->seeds.count == 0)
        return refuse_seeds(w, MBSR_ERR_SEQUENCE, name, "call mbsr_derivatives_parameters first");
    if (w->at == MBSRI_LINEARISED_NOT)
        return refuse_seeds(w, MBSR_ERR_SEQUENCE, name,
                            "call mbsr_derivatives_inverse or mbsr_derivatives_forward first");
    return MBSR_OK;
}

/* ---- seeds that are forces, by the stages' H and J ---- */

/* What they add to J^T mu - tau. */
static void sum_seed_loads(mbsr_derivatives *w, double *load)
{
    const mbsr_model *m = w->model;
    const mbsr_data *d = w->data;
    double *const *sum = w->seeds.sum;
    mbsri_copy(m->size.v, sum[MBSRI_SEED_REACTION], w->mu);
    for (int i = m->bodies; i >= 1; --i) {
        const mbsri_body *b = m->body + i;
        const double *mu = w->mu + b->v;
        for (int k = 0; k < b->n; ++k)
            load[b->u + k] = sum[MBSRI_SEED_LOAD][b->u + k] - sum[MBSRI_SEED_TORQUE][b->iu + k];
        mbsri_atx(b->d, b->n, 1.0, d->J + b->dn, mu, load + b->u);
        mbsri_atx(b->d, b->pred.d, -1.0, d->H + b->dp, mu, w->mu + b->pred.v);
    }
}

/* The gradient of mu, of weights of the load. */
static void spread_weights(mbsr_derivatives *w, const double *load)
{
    const mbsr_model *m = w->model;
    const mbsr_data *d = w->data;
    mbsri_zero((size_t)m->root.d, w->mu);
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        double *mu = w->mu + b->v;
        mbsri_zero((size_t)b->d, mu);
        mbsri_ax(b->d, b->n, 1.0, d->J + b->dn, load + b->u, mu);
        mbsri_ax(b->d, b->pred.d, -1.0, d->H + b->dp, w->mu + b->pred.v, mu);
    }
}

/* The tangent of a tree of rigid bodies: the load, or what it accelerates. */
static int seed_tangent_by_sweeps(mbsr_derivatives *w, double *out, double *dlambda)
{
    const size_t nu = (size_t)w->model->nu;
    double *load = w->right;
    sum_seed_loads(w, load);
    if (w->at == MBSRI_LINEARISED_FORWARD) {
        for (size_t k = 0; k < nu; ++k) load[k] = -load[k];
        return mbsr_derivatives_tangent(w, NULL, NULL, load, out, dlambda);
    }
    if (!mbsri_finite(nu, load))
        return refuse_seeds(w, MBSR_NOT_FINITE, "mbsr_derivatives_parameter_tangent",
                            "it overflows");
    mbsri_copy(nu, load, out);
    return MBSR_OK;
}

int mbsr_derivatives_parameter_tangent(mbsr_derivatives *derivatives, const double *dtheta,
                                       double *out, double *dlambda)
{
    static const char name[] = "mbsr_derivatives_parameter_tangent";
    mbsr_derivatives *w = derivatives;
    if (!w) return MBSR_ERR_NULL;
    if (!dtheta || !out) return refuse_seeds(w, MBSR_ERR_NULL, name, "dtheta or out is NULL");
    int status = check_seeds(w, name);
    if (status) return status;
    if (!mbsri_finite((size_t)w->seeds.count, dtheta))
        return refuse_seeds(w, MBSR_NOT_FINITE, name, "dtheta is not finite");
    mbsri_seeds_along(&w->seeds, dtheta);
    if (w->by_sweeps && !dlambda) return seed_tangent_by_sweeps(w, out, dlambda);
    w->seeds.active = true;
    status = mbsr_derivatives_tangent(w, NULL, NULL, NULL, out, dlambda);
    w->seeds.active = false;
    return status;
}

int mbsr_derivatives_parameter_adjoint(mbsr_derivatives *derivatives, const double *w_out,
                                       const double *w_lambda, double *by_theta)
{
    static const char name[] = "mbsr_derivatives_parameter_adjoint";
    mbsr_derivatives *w = derivatives;
    if (!w) return MBSR_ERR_NULL;
    if (!by_theta) return refuse_seeds(w, MBSR_ERR_NULL, name, "by_theta is NULL");
    int status = check_seeds(w, name);
    if (!status) status = mbsr_derivatives_adjoint(w, w_out, w_lambda, NULL, NULL, NULL);
    if (status) return status;
    const int *place = w->model->order.u_of;
    double *load = w->load; /* the weights, as the adjoint has left them */
    if (w->by_sweeps) {
        for (int k = 0; k < w->model->nu && w->at == MBSRI_LINEARISED_FORWARD; ++k)
            load[k] = -w->right[k];
        spread_weights(w, load);
    }
    for (int k = 0; k < w->model->nu; ++k) w->torque[k] = -load[place[k]];
    const double *const gradient[MBSRI_SEED_PLACES] = {w->motion, w->mu, w->torque, load,
                                                       w->lambda};
    mbsri_seeds_back(&w->seeds, gradient, by_theta);
    return MBSR_OK;
}
