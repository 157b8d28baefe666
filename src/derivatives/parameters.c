/* Derivatives in parameters of the model: entries.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "derivatives/record.h"

#include "derivatives/rigid_seeds.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "base/error.h"

/* The same parameters as `made`, for the sweeps where these serve them. */
static int choose_rigid_seeds(mbsr_derivatives *w, const mbsri_seeds *made,
                              const mbsr_parameters *list, const int *which, const char *name,
                              mbsri_seeds *rigid_seed, mbsri_rigid_seeds **room)
{
    *room = NULL;
    *rigid_seed = (mbsri_seeds){.count = 0};
    if (!w->rigid || made->count == 0 || !mbsri_rigid_seeds_serve(made, w->model)) return MBSR_OK;
    const int numbers = sizeof(mbsri_rigid_frame) / sizeof(double),
              status = mbsri_seeds_create(rigid_seed, w->linear, numbers, list, made->count, which,
                                          name, &w->error);
    if (status) return status;
    *room = mbsri_rigid_seeds_create(w->model, rigid_seed);
    if (*room) return MBSR_OK;
    mbsri_seeds_destroy(rigid_seed, w->model);
    return mbsri_fail(&w->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                      "%s: no memory for %d parameters", name, made->count);
}

int mbsr_derivatives_parameters(mbsr_derivatives *derivatives, const mbsr_parameters *list,
                                int count, const int *which)
{
    static const char name[] = "mbsr_derivatives_parameters";
    mbsr_derivatives *w = derivatives;
    if (!w) return MBSR_ERR_NULL;
    if (count < 0) return mbsri_derivatives_refuse(w, MBSR_ERR_VALUE, name, "count is negative");
    if (count > 0 && (!list || !which))
        return mbsri_derivatives_refuse(w, MBSR_ERR_NULL, name, "list or which is NULL");
    for (int k = 0; k < count; ++k)
        if (which[k] < 0 || which[k] >= mbsr_parameters_count(list))
            return mbsri_fail(&w->error, MBSR_ERR_ID, MBSR_NONE, MBSR_NONE,
                              "%s: which[%d] is %d, but there are %d parameters", name, k, which[k],
                              mbsr_parameters_count(list));
    mbsri_seeds made = {.count = 0}, rigid_seed = made, residual = made;
    mbsri_rigid_seeds *room = NULL;
    int status = MBSR_OK;
    if (count > 0)
        status = mbsri_seeds_create(&made, w->linear, MBSRI_SEED_PRODUCTS, list, count, which, name,
                                    &w->error);
    if (!status && count > 0)
        status = mbsri_seeds_create(&residual, w->linear, MBSRI_SEED_RESIDUAL, list, count, which,
                                    name, &w->error);
    if (!status) status = choose_rigid_seeds(w, &made, list, which, name, &rigid_seed, &room);
    if (status) {
        mbsri_seeds_destroy(&made, w->model);
        mbsri_seeds_destroy(&residual, w->model);
        return status;
    }
    mbsri_derivatives_forget(w);
    mbsri_derivatives_unchoose(w);
    w->seeds = made;
    w->rigid_seed = rigid_seed;
    w->residual.seeds = residual;
    if (w->rigid) w->rigid->seeds = room;
    return MBSR_OK;
}

static int check_seeds(mbsr_derivatives *w, const char *name)
{
    if (w->seeds.count == 0)
        return mbsri_derivatives_refuse(w, MBSR_ERR_SEQUENCE, name,
                                        "call mbsr_derivatives_parameters first");
    if (w->at != MBSRI_LINEARISED_INVERSE && w->at != MBSRI_LINEARISED_FORWARD)
        return mbsri_derivatives_refuse(
            w, MBSR_ERR_SEQUENCE, name,
            "call mbsr_derivatives_inverse or mbsr_derivatives_forward first");
    return MBSR_OK;
}

int mbsr_derivatives_parameter_tangent(mbsr_derivatives *derivatives, const double *dtheta,
                                       double *out, double *dlambda)
{
    static const char name[] = "mbsr_derivatives_parameter_tangent";
    mbsr_derivatives *w = derivatives;
    if (!w) return MBSR_ERR_NULL;
    if (!dtheta || !out)
        return mbsri_derivatives_refuse(w, MBSR_ERR_NULL, name, "dtheta or out is NULL");
    int status = check_seeds(w, name);
    if (status) return status;
    if (!mbsri_finite((size_t)w->seeds.count, dtheta))
        return mbsri_derivatives_refuse(w, MBSR_NOT_FINITE, name, "dtheta is not finite");
    mbsri_seeds *seeds = w->by_sweeps ? &w->rigid_seed : &w->seeds;
    mbsri_seeds_along(seeds, dtheta);
    seeds->active = true;
    if (w->by_sweeps) w->rigid->seeds->active = true;
    status = mbsr_derivatives_tangent(w, NULL, NULL, NULL, out, dlambda);
    seeds->active = false;
    if (w->by_sweeps) w->rigid->seeds->active = false;
    return status;
}

static int give_gradient(mbsr_derivatives *w, const mbsri_seeds *s, const char *name, double *out)
{
    if (!mbsri_finite((size_t)s->count, s->by))
        return mbsri_derivatives_refuse(w, MBSR_NOT_FINITE, name, "it overflows");
    mbsri_copy((size_t)s->count, s->by, out);
    return MBSR_OK;
}

int mbsr_derivatives_parameter_adjoint(mbsr_derivatives *derivatives, const double *w_out,
                                       const double *w_lambda, double *by_theta)
{
    static const char name[] = "mbsr_derivatives_parameter_adjoint";
    mbsr_derivatives *w = derivatives;
    if (!w) return MBSR_ERR_NULL;
    if (!by_theta) return mbsri_derivatives_refuse(w, MBSR_ERR_NULL, name, "by_theta is NULL");
    int status = check_seeds(w, name);
    if (!status) status = mbsr_derivatives_adjoint(w, w_out, w_lambda, NULL, NULL, NULL);
    if (status) return status;
    const int *place = w->model->order.u_of;
    const double *load = w->load; /* the weights, as the adjoint has left them */
    const bool forward = w->at == MBSRI_LINEARISED_FORWARD;
    if (w->by_sweeps) {
        mbsri_rigid_seeds_back(w, forward ? -1.0 : 1.0, forward ? w->right : load);
        return give_gradient(w, &w->rigid_seed, name, by_theta);
    }
    for (int k = 0; k < w->model->nu; ++k) w->torque[k] = -load[place[k]];
    const double *const gradient[MBSRI_SEED_PLACES] = {w->motion, w->mu, w->torque, load,
                                                       w->lambda};
    mbsri_seeds_back(&w->seeds, gradient);
    return give_gradient(w, &w->seeds, name, by_theta);
}
