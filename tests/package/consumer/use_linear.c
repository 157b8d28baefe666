/* Uses the component linear: the frequency of a mass on a spring.
 * SPDX-License-Identifier: BSD-3-Clause */
#include <mbsrank/linear.h>
#include <mbsrank/mbsrank.h>

#include <stdio.h>

int main(void)
{
    const double along[3] = {1, 0, 0}, q = 0.0;
    mbsr_model *model;
    mbsr_data *data;
    mbsr_mode mode;
    mbsr_error error;
    int found = 0;
    if (mbsr_model_create(NULL, &model, &error)) return 1;
    mbsr_body_def body = mbsr_default_body_def();
    body.joint = mbsr_joint_prismatic(NULL, NULL, along);
    body.inertia = mbsr_inertia_particle(1.0);
    const mbsr_force_def spring = mbsr_force_joint_spring(0, 0, 9.0, 0.0, 0.0);
    mbsr_model_add_body(model, &body, NULL);
    mbsr_model_add_force(model, &spring, NULL);
    int status = mbsr_model_finish(model);
    if (!status) status = mbsr_data_create(model, &data, &error);
    if (status) return 1;
    status = mbsr_modes_near(model, data, 0.0, &q, NULL, &mode, &found, NULL, NULL, &error);
    printf("%d mode: %.6f 1/s\n", found, mode.imaginary);
    mbsr_data_destroy(data);
    mbsr_model_destroy(model);
    return status || found != 1 || !(mode.imaginary > 2.999999 && mode.imaginary < 3.000001);
}
