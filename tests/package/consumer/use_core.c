/* Two bodies on the ground, the second without mass: builds the tree and evaluates the residual.
 * SPDX-License-Identifier: BSD-3-Clause */
#include <mbsrank/mbsrank.h>
#include <mbsrank/driver.h>

#include <math.h>
#include <stdio.h>

static int build(mbsr_model **model)
{
    int status = mbsr_model_create(NULL, model, NULL);
    if (status != MBSR_OK) return status;
    mbsr_body_def body = mbsr_default_body_def();
    body.name = "mass";
    body.joint = mbsr_joint_point_free();
    body.inertia = mbsr_inertia_particle(2.0);
    status = mbsr_model_add_body(*model, &body, &body.parent);
    if (status != MBSR_OK) return status;
    body.name = "marker";
    body.inertia = mbsr_inertia_zero();
    status = mbsr_model_add_body(*model, &body, NULL);
    if (status != MBSR_OK) return status;
    mbsr_force_def gravity = mbsr_force_gravity(0.0, -10.0, 0.0);
    status = mbsr_model_add_force(*model, &gravity, NULL);
    if (status != MBSR_OK) return status;
    return mbsr_model_finish(*model);
}

/* The free fall of the first body satisfies the equations; a body at rest lacks 2 kg 10 m/s^2. */
static int evaluate(const mbsr_model *model, mbsr_data *data)
{
    const double y[8] = {0.0};
    double yp[8] = {0.0}, F[8];
    if (mbsr_dae_size(model, MBSR_DAE_RECURSIVE) != 8) return 1;
    if (mbsr_dae_residual(model, data, MBSR_DAE_RECURSIVE, 0.0, y, yp, F) != MBSR_OK) return 2;
    if (fabs(fabs(F[5]) - 20.0) > 1e-12) return 3;
    yp[5] = -10.0;
    if (mbsr_dae_residual(model, data, MBSR_DAE_RECURSIVE, 0.0, y, yp, F) != MBSR_OK) return 4;
    for (int i = 0; i < 8; ++i) {
        if (fabs(F[i]) > 1e-12) return 5;
    }
    return mbsr_total_rank(model, data) == 2 ? 0 : 6;
}

int main(void)
{
    mbsr_model *model = NULL;
    mbsr_data *data = NULL;
    int result = build(&model);
    if (result == MBSR_OK) result = mbsr_data_create(model, &data, NULL);
    if (result == MBSR_OK) result = evaluate(model, data);
    mbsr_data_destroy(data);
    mbsr_model_destroy(model);
    if (result != 0) fprintf(stderr, "use_core: failed with %d\n", result);
    printf("mbsrank %s\n", mbsr_version());
    return result == 0 ? 0 : 1;
}
