/* Forces of files that act at a point of one body: see thrust.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/thrust.h"
#include "algebra/space3.h"

#include <string.h>

/* ---- thrust ----
 *
 * param: the law, where the force acts (3), force (3) and moment (3) of F = 1 along the axes of the
 * body, then for reading back the quaternion of the frame (4). */
enum { POINT = MBSRI_LAW_PARAMS, ALONG = POINT + 3, ABOUT = ALONG + 3, QUATERNION = ABOUT + 3 };

/* The wrench of F = 1 at the origin of the body, moment first: what moves l. */
static void unit_wrench(const mbsr_force_args *args, double w[6])
{
    const double *param = args->force->param, *R = args->body[0].p + MBSR_POSE_R;
    double arm[3], moment[3], about[3];
    mbsri_rotate3(R, param + POINT, arm);
    mbsri_rotate3(R, param + ALONG, w + 3);
    mbsri_rotate3(R, param + ABOUT, about);
    mbsri_cross3(arm, w + 3, moment);
    for (int k = 0; k < 3; ++k) w[k] = about[k] + moment[k];
}

static int thrust_evaluate(const mbsr_force_args *args)
{
    const mbsr_force_body *b = args->body;
    double w[6], rate = 0.0, slope[2];
    unit_wrench(args, w);
    for (int k = 0; k < 6; ++k) rate += w[k] * b->V[k];
    const double F = mbsri_law_force(args->force, 0.0, rate, slope);
    for (int k = 0; k < 6; ++k) b->f[k] += F * w[k];
    return 0;
}

static const mbsr_force_table thrust = {
    .version = MBSR_FORCE_TABLE_VERSION,
    .flags = MBSR_FORCE_NO_JOINT | MBSR_FORCE_NO_MASS,
    .name = "thrust",
    .evaluate = thrust_evaluate,
};

mbsr_force_def mbsri_force_thrust(const mbsri_thrust *t)
{
    mbsr_force_def def = mbsr_force_custom(&thrust, 1, NULL, NULL);
    def.body[0] = t->body;
    mbsri_law_put(&t->law, &def);
    memcpy(def.param + POINT, t->frame.x, 3 * sizeof(double));
    mbsri_rotate3(t->frame.R, t->gear, def.param + ALONG);
    mbsri_rotate3(t->frame.R, t->gear + 3, def.param + ABOUT);
    mbsr_rotation_quaternion(t->frame.R, def.param + QUATERNION);
    return def;
}

bool mbsri_thrust_of(const mbsr_force_def *def, mbsri_thrust *t)
{
    if (def->table != &thrust) return false;
    t->body = def->body[0];
    t->frame = mbsr_frame_quaternion(def->param + POINT, def->param + QUATERNION);
    const mbsr_frame back = mbsr_frame_inverse(&t->frame);
    mbsri_rotate3(back.R, def->param + ALONG, t->gear);
    mbsri_rotate3(back.R, def->param + ABOUT, t->gear + 3);
    mbsri_law_get(def, &t->law);
    return true;
}

/* ---- lift ----
 *
 * param: point (3), force (3) */

static int lift_evaluate(const mbsr_force_args *args)
{
    const double *param = args->force->param;
    double arm[3], moment[3];
    mbsri_rotate3(args->body[0].p + MBSR_POSE_R, param, arm);
    mbsri_cross3(arm, param + 3, moment);
    for (int k = 0; k < 3; ++k) {
        args->body[0].f[k] += moment[k];
        args->body[0].f[3 + k] += param[3 + k];
    }
    return 0;
}

static int lift_energy(const mbsr_force_args *args, double *energy)
{
    const double *param = args->force->param, *p = args->body[0].p;
    double arm[3];
    mbsri_rotate3(p + MBSR_POSE_R, param, arm);
    for (int k = 0; k < 3; ++k) *energy -= param[3 + k] * (p[MBSR_POSE_X + k] + arm[k]);
    return 0;
}

static const mbsr_force_table lift = {
    .version = MBSR_FORCE_TABLE_VERSION,
    .flags = MBSR_FORCE_NO_JOINT | MBSR_FORCE_NO_MASS,
    .name = "lift",
    .evaluate = lift_evaluate,
    .energy = lift_energy,
};

mbsr_force_def mbsri_force_lift(int body, const double point[3], const double force[3])
{
    mbsr_force_def def = mbsr_force_custom(&lift, 1, NULL, NULL);
    def.body[0] = body;
    memcpy(def.param, point, 3 * sizeof *point);
    memcpy(def.param + 3, force, 3 * sizeof *force);
    return def;
}

bool mbsri_lift_of(const mbsr_force_def *def, double force[3])
{
    if (def->table != &lift) return false;
    memcpy(force, def->param + 3, 3 * sizeof *force);
    return true;
}
