/* The stages of the recursion, one call each.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "algebra/numbers.h"
#include "dynamics/entry.h"
#include "recursion/backward.h"
#include "recursion/elements.h"
#include "recursion/forward.h"
#include "recursion/inverse.h"
#include "recursion/kinematics.h"
#include "recursion/not_finite.h"

#include <mbsrank/dynamics.h>

int mbsr_positions(const mbsr_model *model, mbsr_data *data, double t, const double *q)
{
    const int status = mbsri_enter(model, data, q != NULL, MBSRI_STAGE_NONE, "mbsr_positions");
    return status ? status : mbsri_positions(model, data, t, q);
}

int mbsr_velocities(const mbsr_model *model, mbsr_data *data, const double *u)
{
    const int status =
        mbsri_enter(model, data, u != NULL, MBSRI_STAGE_POSITIONS, "mbsr_velocities");
    return status ? status : mbsri_velocities(model, data, u);
}

int mbsr_coordinate_rates(const mbsr_model *model, mbsr_data *data, double *qdot)
{
    const int status =
        mbsri_enter(model, data, qdot != NULL, MBSRI_STAGE_VELOCITIES, "mbsr_coordinate_rates");
    return status ? status : mbsri_coordinate_rates(model, data, qdot);
}

int mbsr_normalise(const mbsr_model *model, mbsr_data *data, double *q)
{
    const int status = mbsri_enter(model, data, q != NULL, MBSRI_STAGE_NONE, "mbsr_normalise");
    return status ? status : mbsri_normalise(model, data, q);
}

int mbsr_forces(const mbsr_model *model, mbsr_data *data, const double *tau)
{
    const int status = mbsri_enter(model, data, true, MBSRI_STAGE_VELOCITIES, "mbsr_forces");
    return status ? status : mbsri_forces(model, data, tau);
}

int mbsr_backward(const mbsr_model *model, mbsr_data *data)
{
    const int status = mbsri_enter(model, data, true, MBSRI_STAGE_FORCES, "mbsr_backward");
    return status ? status : mbsri_backward(model, data);
}

int mbsr_forward(const mbsr_model *model, mbsr_data *data, const double *udot, double *residual)
{
    const int status =
        mbsri_enter(model, data, udot && residual, MBSRI_STAGE_BACKWARD, "mbsr_forward");
    if (!status) mbsri_forward(model, data, udot, residual);
    return status;
}

int mbsr_recursive_residual(const mbsr_model *model, mbsr_data *data, double t, const double *q,
                            const double *u, const double *udot, const double *tau,
                            double *residual)
{
    int status = mbsri_enter(model, data, q && u && udot && residual, MBSRI_STAGE_NONE,
                             "mbsr_recursive_residual");
    if (!status) status = mbsri_positions(model, data, t, q);
    if (!status) status = mbsri_velocities(model, data, u);
    if (!status) status = mbsri_forces(model, data, tau);
    if (!status) status = mbsri_backward(model, data);
    if (!status) mbsri_forward(model, data, udot, residual);
    return status;
}

int mbsr_accelerations(const mbsr_model *model, mbsr_data *data, const double *udot)
{
    const int status =
        mbsri_enter(model, data, udot != NULL, MBSRI_STAGE_FORCES, "mbsr_accelerations");
    if (status) return status;
    mbsri_inverse(model, data, udot);
    return mbsri_finite((size_t)model->nu, data->out) ? MBSR_OK
                                                      : mbsri_report_not_finite(model, data);
}
