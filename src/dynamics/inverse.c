/* Inverse dynamics (recursive Newton-Euler): by the vectorised sweeps, or by the stages.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "dynamics/entry.h"
#include "model/query.h"
#include "recursion/elements.h"
#include "recursion/inverse.h"
#include "recursion/kinematics.h"
#include "recursion/not_finite.h"
#include "sweeps/dynamics.h"

#include <mbsrank/dynamics.h>

int mbsr_inverse_dynamics(const mbsr_model *model, mbsr_data *data, double t, const double *q,
                          const double *u, const double *udot, double *tau)
{
    int status =
        mbsri_enter(model, data, q && u && udot && tau, MBSRI_STAGE_NONE, "mbsr_inverse_dynamics");
    if (status) return status;
    if (mbsri_finite((size_t)model->nu, udot)) {
        status = mbsri_sweeps_inverse_dynamics(model, data, t, q, u, udot, tau);
        if (!status) mbsri_remember(model, data, MBSRI_PENDING_INVERSE, q, u, udot);
        if (status != MBSRI_NOT_SERVED) return status;
    }
    status = mbsri_check_input(data, (size_t)model->nu, udot, "mbsr_inverse_dynamics", "udot");
    if (!status) status = mbsri_positions(model, data, t, q);
    if (!status) status = mbsri_velocities(model, data, u);
    if (!status) status = mbsri_forces(model, data, NULL);
    if (status) return status;
    mbsri_inverse(model, data, udot);
    mbsri_scatter(model, data->out, tau);
    return mbsri_check_result(model, data, (size_t)model->nu, tau, "mbsr_inverse_dynamics");
}

int mbsr_bias_forces(const mbsr_model *model, mbsr_data *data, double t, const double *q,
                     const double *u, double *bias)
{
    const int status =
        mbsri_enter(model, data, q && u && bias, MBSRI_STAGE_NONE, "mbsr_bias_forces");
    if (status) return status;
    double *none = data->u_given; /* the index-1 form's, between whose calls this is free */
    mbsri_zero((size_t)model->nu, none);
    return mbsr_inverse_dynamics(model, data, t, q, u, none, NULL, bias);
}
