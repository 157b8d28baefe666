/* What happens where a rank changes, and how to go on.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Two pendulums hang on one bead without mass. Each gives the bead mass along its rod only: as long
 * as they swing side by side the bead has one massless direction, when they part it has none. A
 * torque on the second parts them at t = 0.5 s. The momentum form holds between rank changes and
 * the driver stops there, naming body and time; the inverse-dynamics form decides no ranks and
 * passes through. */
#include <mbsrank/ida.h>
#include <mbsrank/mbsrank.h>

#include <stdio.h>
#include <stdlib.h>

static void check(int status, const mbsr_error *error)
{
    if (status == MBSR_OK) return;
    fprintf(stderr, "%s: %s\n", mbsr_status_name(status), error->text);
    exit(1);
}

static int torque(void *user, double t, int n, double *value)
{
    (void)user, (void)n;
    value[0] = t > 0.5 ? 20.0 * (t - 0.5) : 0.0;
    return MBSR_OK;
}

static mbsr_model *twins(void)
{
    mbsr_model *m;
    check(mbsr_model_create(NULL, &m, NULL), mbsr_model_error(NULL));
    mbsr_body_def body = mbsr_default_body_def();
    body.name = "bead";
    body.joint = mbsr_joint_point_free();
    check(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    body.name = "pendulum";
    body.parent = 0;
    body.joint = mbsr_joint_planar_revolute((mbsr_planar_frame){0}, (mbsr_planar_frame){0, 1, 0});
    body.inertia = mbsr_inertia_particle(1.0);
    for (int k = 0; k < 2; ++k) check(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    const mbsr_force_def forces[] = {mbsr_force_axis_spring(0, MBSR_GROUND, 0, 100.0, 5.0, 0.0),
                                     mbsr_force_axis_spring(0, MBSR_GROUND, 1, 100.0, 5.0, 0.0),
                                     mbsr_force_gravity(0.0, -9.81, 0.0),
                                     mbsr_force_joint_applied(2, torque, NULL)};
    for (int k = 0; k < 4; ++k)
        check(mbsr_model_add_force(m, &forces[k], NULL), mbsr_model_error(m));
    check(mbsr_model_finish(m), mbsr_model_error(m));
    return m;
}

/* Integrates to 0.8 s in one form; returns the driver's status, *angle the angle between the rods.
 * */
static int swing(mbsr_dae_form form, double *angle)
{
    mbsr_model *m = twins();
    mbsr_data *d;
    mbsr_ida *ida;
    const double q[4] = {0.0, 0.0, 1.0, 1.0}, u[4] = {0.0, 0.0, 2.0, 2.0};
    double y[12] = {0.0}, yp[12];
    check(mbsr_data_create(m, &d, NULL), mbsr_data_error(NULL));
    check(mbsr_dae_pack(m, d, form, 0.0, q, u, y), mbsr_data_error(d));
    check(mbsr_dae_consistent(m, d, form, 0.0, y, yp, NULL, NULL), mbsr_data_error(d));
    mbsr_ida_opt opt = mbsr_default_ida_opt();
    opt.form = form;
    check(mbsr_ida_create(m, d, &opt, &ida, NULL), mbsr_ida_error(NULL));
    check(mbsr_ida_start(ida, 0.0, y, yp), mbsr_ida_error(ida));
    const int status = mbsr_ida_advance(ida, 0.8, NULL, y, NULL);
    if (status) printf("%s: %s\n", mbsr_status_name(status), mbsr_ida_error(ida)->text);
    *angle = y[3] - y[2];
    mbsr_ida_destroy(ida);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
    return status;
}

int main(void)
{
    double angle;
    if (swing(MBSR_DAE_MOMENTUM, &angle) != MBSR_RANK_CHANGED) return 1;
    if (swing(MBSR_DAE_INVERSE_DYNAMICS, &angle) != MBSR_OK) return 1;
    printf("inverse dynamics: passes; the rods are %.4f rad apart at t = 0.8 s\n", angle);
    return angle > 0.01 || angle < -0.01 ? 0 : 1;
}
