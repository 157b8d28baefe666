/* A falling particle, integrated by the component ida.
 * SPDX-License-Identifier: BSD-3-Clause */
#include <mbsrank/ida.h>
#include <mbsrank/mbsrank.h>

#include <math.h>
#include <stdio.h>

static int build(mbsr_model **model)
{
    int status = mbsr_model_create(NULL, model, NULL);
    if (status != MBSR_OK) return status;
    mbsr_body_def body = mbsr_default_body_def();
    body.joint = mbsr_joint_point_free();
    body.inertia = mbsr_inertia_particle(2.0);
    status = mbsr_model_add_body(*model, &body, NULL);
    if (status != MBSR_OK) return status;
    mbsr_force_def gravity = mbsr_force_gravity(0.0, -10.0, 0.0);
    status = mbsr_model_add_force(*model, &gravity, NULL);
    if (status != MBSR_OK) return status;
    return mbsr_model_finish(*model);
}

/* One second of free fall from rest: 5 m, 10 m/s. */
static int integrate(const mbsr_model *model, mbsr_data *data)
{
    mbsr_ida *ida = NULL;
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.form = MBSR_DAE_RECURSIVE;
    int status = mbsr_ida_create(model, data, &opt, &ida, NULL);
    if (status != MBSR_OK) return status;
    const double start[4] = {0.0}, slope[4] = {0.0, 0.0, 0.0, -10.0};
    double y[4] = {0.0};
    status = mbsr_ida_start(ida, 0.0, start, slope);
    if (status == MBSR_OK) status = mbsr_ida_advance(ida, 1.0, NULL, y, NULL);
    mbsr_ida_destroy(ida);
    if (status != MBSR_OK) return status;
    return fabs(y[1] + 5.0) < 1e-3 && fabs(y[3] + 10.0) < 1e-3 ? 0 : 1;
}

int main(void)
{
    mbsr_model *model = NULL;
    mbsr_data *data = NULL;
    int result = build(&model);
    if (result == MBSR_OK) result = mbsr_data_create(model, &data, NULL);
    if (result == MBSR_OK) result = integrate(model, data);
    mbsr_data_destroy(data);
    mbsr_model_destroy(model);
    if (result != 0) fprintf(stderr, "use_ida: failed with %d\n", result);
    return result == 0 ? 0 : 1;
}
