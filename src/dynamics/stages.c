/* The stages of the recursion, one call each.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "dynamics/entry.h"
#include "recursion/backward.h"
#include "recursion/elements.h"
#include "recursion/forward.h"
#include "recursion/inverse.h"
#include "recursion/kinematics.h"
#include "recursion/not_finite.h"

#include <mbsrank/dynamics.h>

int mbsr_stage_positions(const mbsr_model *model, mbsr_data *data, double t, const double *q)
{
    const int status =
        mbsri_enter(model, data, q != NULL, MBSRI_STAGE_NONE, "mbsr_stage_positions");
    return status ? status : mbsri_positions(model, data, t, q);
}

int mbsr_stage_velocities(const mbsr_model *model, mbsr_data *data, const double *u)
{
    const int status =
        mbsri_enter(model, data, u != NULL, MBSRI_STAGE_POSITIONS, "mbsr_stage_velocities");
    return status ? status : mbsri_velocities(model, data, u);
}

int mbsr_coordinate_rates(const mbsr_model *model, mbsr_data *data, double *qdot)
{
    const int status =
        mbsri_enter(model, data, qdot != NULL, MBSRI_STAGE_VELOCITIES, "mbsr_coordinate_rates");
    if (status) return status;
    const int failed = mbsri_coordinate_rates(model, data, qdot);
    return failed
               ? failed
               : mbsri_check_result(model, data, (size_t)model->nq, qdot, "mbsr_coordinate_rates");
}

int mbsr_normalise(const mbsr_model *model, mbsr_data *data, double *q)
{
    static const char name[] = "mbsr_normalise";
    int status = mbsri_enter(model, data, q != NULL, MBSRI_STAGE_NONE, name);
    if (!status) status = mbsri_check_input(data, (size_t)model->nq, q, name, "q");
    if (!status) status = mbsri_normalise(model, data, q);
    return status ? status : mbsri_check_result(model, data, (size_t)model->nq, q, name);
}

int mbsr_stage_forces(const mbsr_model *model, mbsr_data *data, const double *tau)
{
    const int status = mbsri_enter(model, data, true, MBSRI_STAGE_VELOCITIES, "mbsr_stage_forces");
    return status ? status
                  : mbsri_forces(model, data, tau, data->lambda_known ? data->loop_lambda : NULL);
}

int mbsr_stage_backward(const mbsr_model *model, mbsr_data *data)
{
    const int status = mbsri_enter(model, data, true, MBSRI_STAGE_FORCES, "mbsr_stage_backward");
    return status ? status : mbsri_backward(model, data);
}

static int forward(const mbsr_model *m, mbsr_data *d, const double *udot, double *residual,
                   const char *function)
{
    const size_t nu = (size_t)m->nu;
    const int status = mbsri_check_input(d, nu, udot, function, "udot");
    if (status) return status;
    mbsri_forward(m, d, udot, residual);
    return mbsri_check_result(m, d, nu, residual, function);
}

int mbsr_stage_forward(const mbsr_model *model, mbsr_data *data, const double *udot,
                       double *residual)
{
    const int status =
        mbsri_enter_tree(model, data, udot && residual, MBSRI_STAGE_BACKWARD, "mbsr_stage_forward");
    return status ? status : forward(model, data, udot, residual, "mbsr_stage_forward");
}

int mbsr_recursive_residual(const mbsr_model *model, mbsr_data *data, double t, const double *q,
                            const double *u, const double *udot, const double *tau,
                            double *residual)
{
    int status = mbsri_enter_tree(model, data, q && u && udot && residual, MBSRI_STAGE_NONE,
                                  "mbsr_recursive_residual");
    if (!status) status = mbsri_positions(model, data, t, q);
    if (!status) status = mbsri_velocities(model, data, u);
    if (!status) status = mbsri_forces(model, data, tau, NULL);
    if (!status) status = mbsri_backward(model, data);
    return status ? status : forward(model, data, udot, residual, "mbsr_recursive_residual");
}

int mbsr_stage_accelerations(const mbsr_model *model, mbsr_data *data, const double *udot)
{
    static const char name[] = "mbsr_stage_accelerations";
    const mbsr_model *m = model;
    mbsr_data *d = data;
    int status = mbsri_enter(m, d, udot != NULL, MBSRI_STAGE_FORCES, name);
    if (!status) status = mbsri_check_input(d, (size_t)m->nu, udot, name, "udot");
    if (status) return status;
    mbsri_inverse(m, d, udot);
    status = mbsri_check_result(m, d, m->size.v, d->A, name);
    if (!status) status = mbsri_check_result(m, d, m->size.v, d->mu, name);
    if (status) d->accelerated = false;
    return status;
}
