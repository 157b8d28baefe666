/* Rows of closures at a state.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "recursion/closures.h"

#include "dynamics/entry.h"
#include "model/query.h"
#include "recursion/not_finite.h"

#include <mbsrank/driver.h>

int mbsr_closures_weight(const mbsr_model *model, double *w)
{
    if (!model || !w) return MBSR_ERR_NULL;
    if (!model->finished) return MBSR_ERR_UNFINISHED;
    if (model->typical.weight)
        mbsri_scatter(model, model->typical.weight, w);
    else
        for (int k = 0; k < model->nu; ++k) w[k] = 1.0;
    return MBSR_OK;
}

int mbsr_closures_gap(const mbsr_model *model, mbsr_data *data, double *g)
{
    const int status =
        mbsri_enter(model, data, g != NULL, MBSRI_STAGE_POSITIONS, "mbsr_closures_gap");
    return status ? status : mbsri_closure_gaps(model, data, g);
}

/* The stage, then the derivatives there. */
static int enter_rows(const mbsr_model *m, mbsr_data *d, bool arguments, mbsri_stage stage,
                      const char *function)
{
    const int status = mbsri_enter(m, d, arguments, stage, function);
    return status ? status : mbsri_closure_jacobians(m, d);
}

int mbsr_closures_rate(const mbsr_model *model, mbsr_data *data, double *rate)
{
    const int status =
        enter_rows(model, data, rate != NULL, MBSRI_STAGE_VELOCITIES, "mbsr_closures_rate");
    return status ? status : mbsri_closure_rates(model, data, rate);
}

int mbsr_closures_bias(const mbsr_model *model, mbsr_data *data, double *bias)
{
    const int status =
        enter_rows(model, data, bias != NULL, MBSRI_STAGE_VELOCITIES, "mbsr_closures_bias");
    return status ? status : mbsri_closure_bias(model, data, bias);
}

int mbsr_closures_apply(const mbsr_model *model, mbsr_data *data, const double *x, double *y)
{
    static const char name[] = "mbsr_closures_apply";
    int status = enter_rows(model, data, x && y, MBSRI_STAGE_POSITIONS, name);
    if (!status) status = mbsri_check_input(data, (size_t)model->nu, x, name, "x");
    if (status) return status;
    mbsri_closure_apply(model, data, x, y);
    return mbsri_check_result(model, data, (size_t)model->rows, y, name);
}

int mbsr_closures_transpose(const mbsr_model *model, mbsr_data *data, const double *x, double *y)
{
    static const char name[] = "mbsr_closures_transpose";
    int status = enter_rows(model, data, x && y, MBSRI_STAGE_POSITIONS, name);
    if (!status) status = mbsri_check_input(data, (size_t)model->rows, x, name, "x");
    if (status) return status;
    mbsri_closure_transpose(model, data, x, y);
    return mbsri_check_result(model, data, (size_t)model->nu, y, name);
}
