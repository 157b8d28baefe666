/* Inverse dynamics (recursive Newton-Euler): by the vectorised sweeps, or by the stages.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "dynamics/entry.h"
#include "loops/forward.h"
#include "model/query.h"
#include "recursion/elements.h"
#include "recursion/inverse.h"
#include "recursion/kinematics.h"
#include "recursion/not_finite.h"
#include "sweeps/dynamics.h"

#include <mbsrank/dynamics.h>

static const char name[] = "mbsr_inverse_dynamics";

/* (11), tau = J^T mu: every joint rate has a motor, and rigid rows exert nothing. */
static int drive_all(const mbsr_model *model, mbsr_data *data, double t, const double *q,
                     const double *u, const double *udot, double *tau)
{
    int status;
    if (mbsri_finite((size_t)model->nu, udot)) {
        status = mbsri_sweeps_inverse_dynamics(model, data, t, q, u, udot, tau);
        if (!status) mbsri_remember(model, data, MBSRI_PENDING_INVERSE, q, u, udot);
        if (status != MBSRI_NOT_SERVED) return status;
    }
    status = mbsri_check_input(data, (size_t)model->nu, udot, name, "udot");
    if (!status) status = mbsri_positions(model, data, t, q);
    if (!status) status = mbsri_velocities(model, data, u);
    if (!status) status = mbsri_forces(model, data, NULL, NULL);
    if (status) return status;
    mbsri_inverse(model, data, udot);
    mbsri_scatter(model, data->out, tau);
    return mbsri_check_result(model, data, (size_t)model->nu, tau, name);
}

/* 1 in `mark` (nu) at the rates that have a motor. */
static int mark_driven(const mbsr_model *m, mbsr_data *d, const mbsr_motors *motors, double *mark)
{
    mbsri_zero((size_t)m->nu, mark);
    for (int k = 0; k < motors->count; ++k) {
        const int rate = motors->rate[k];
        const bool outside = rate < 0 || rate >= m->nu;
        if (outside || mark[rate] > 0.0)
            return mbsri_fail(&d->error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                              "%s: motors->rate[%d] is %d, %s", name, k, rate,
                              outside ? "not an index of u" : "as another is");
        mark[rate] = 1.0;
    }
    return MBSR_OK;
}

/* tau + C^T lambda = need, where vector code does not serve. */
static int drive_by_fronts(const mbsr_model *model, mbsr_data *data, double t, const double *q,
                           const double *u, const double *udot, const mbsr_motors *motors,
                           double *tau)
{
    double *need = data->u_given; /* the marks have been read */
    int status = drive_all(model, data, t, q, u, udot, need);
    if (!status) status = mbsri_enter(model, data, true, MBSRI_STAGE_FORCES, name);
    return status ? status : mbsri_loops_actuate(model, data, motors, need, tau, name);
}

/* Leaves lambda in loop_lambda, for the stages that are asked for afterwards. */
static int drive_some(const mbsr_model *model, mbsr_data *data, double t, const double *q,
                      const double *u, const double *udot, const mbsr_motors *motors, double *tau)
{
    double *mark = data->u_given, *motor = data->vec; /* which other evaluations do not leave */
    int status = mark_driven(model, data, motors, mark);
    if (status) return status;
    mbsri_gather(model, mark, motor);
    status = mbsri_sweeps_loops_inverse(model, data, t, q, u, udot, motor, tau, data->loop_lambda);
    if (status == MBSRI_NOT_SERVED)
        status = drive_by_fronts(model, data, t, q, u, udot, motors, tau);
    if (status) return status;
    mbsri_remember(model, data, MBSRI_PENDING_INVERSE, q, u, udot);
    data->stage = MBSRI_STAGE_NONE;
    return MBSR_OK;
}

int mbsr_inverse_dynamics(const mbsr_model *model, mbsr_data *data, double t, const double *q,
                          const double *u, const double *udot, const mbsr_motors *motors,
                          double *tau)
{
    const bool there = q && u && udot && tau && (!motors || motors->rate || motors->count == 0);
    const int status = mbsri_enter(model, data, there, MBSRI_STAGE_NONE, name);
    if (status) return status;
    return motors ? drive_some(model, data, t, q, u, udot, motors, tau)
                  : drive_all(model, data, t, q, u, udot, tau);
}

int mbsr_bias_forces(const mbsr_model *model, mbsr_data *data, double t, const double *q,
                     const double *u, double *bias)
{
    const int status =
        mbsri_enter(model, data, q && u && bias, MBSRI_STAGE_NONE, "mbsr_bias_forces");
    if (status) return status;
    double *none = data->u_given; /* the index-1 form's, between whose calls this is free */
    mbsri_zero((size_t)model->nu, none);
    return drive_all(model, data, t, q, u, none, bias);
}
