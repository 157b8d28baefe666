/* The benchmark bicycle of Meijaard, Papadopoulos, Ruina and Schwab (Proc. R. Soc. A 463, 2007,
 * 1955-1982): x ahead, y to the right, z down, origin where the rear wheel touches.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_BICYCLE_H
#define TEST_BICYCLE_H

#include "expect.h"

enum {
    BICYCLE_RATES = 9
}; /* x, y, z, yaw, roll, pitch of the frame; rear wheel, steering, front wheel */

static const double bicycle_base = 1.02, bicycle_trail = 0.08,
                    bicycle_tilt = 3.14159265358979323846 / 10.0, bicycle_rear = 0.3,
                    bicycle_front = 0.35, bicycle_gravity = 9.81;

static inline mbsr_model *bicycle_make(void)
{
    const mbsr_axis free[6] = {
        {MBSR_AXIS_TRANSLATION, {1, 0, 0}, 0, 0}, {MBSR_AXIS_TRANSLATION, {0, 1, 0}, 0, 0},
        {MBSR_AXIS_TRANSLATION, {0, 0, 1}, 0, 0}, {MBSR_AXIS_ROTATION, {0, 0, 1}, 0, 0},
        {MBSR_AXIS_ROTATION, {1, 0, 0}, 0, 0},    {MBSR_AXIS_ROTATION, {0, 1, 0}, 0, 0}};
    const double across[3] = {0, 1, 0}, ahead[3] = {1, 0, 0},
                 steer[3] = {sin(bicycle_tilt), 0, cos(bicycle_tilt)},
                 foot = bicycle_base + bicycle_trail;
    const mbsr_frame hub = mbsr_frame_at(0, 0, -bicycle_rear), head = mbsr_frame_at(foot, 0, 0),
                     front = mbsr_frame_at(-bicycle_trail, 0, -bicycle_front),
                     disc = mbsr_frame_rotated(NULL, ahead, -0.5 * 3.14159265358979323846),
                     ground = mbsr_frame_rotated(NULL, ahead, 3.14159265358979323846);
    mbsr_body_def body[4];
    for (int k = 0; k < 4; ++k) body[k] = mbsr_default_body_def();
    body[0].name = "frame";
    body[0].joint = mbsr_joint_compound(NULL, NULL, 6, free, NULL, NULL);
    body[0].inertia = mbsr_inertia_rigid(85.0, (const double[3]){0.3, 0, -0.9},
                                         (const double[6]){9.2, 11.0, 2.8, 0, 2.4, 0});
    body[1].name = "rear wheel";
    body[1].parent = 0;
    body[1].joint = mbsr_joint_revolute(&hub, NULL, across);
    body[1].inertia =
        mbsr_inertia_rigid(2.0, NULL, (const double[6]){0.0603, 0.12, 0.0603, 0, 0, 0});
    body[2].name = "fork";
    body[2].parent = 0;
    body[2].joint = mbsr_joint_revolute(&head, NULL, steer);
    body[2].inertia = mbsr_inertia_rigid(4.0, (const double[3]){0.9 - foot, 0, -0.7},
                                         (const double[6]){0.05892, 0.06, 0.00708, 0, -0.00756, 0});
    body[3].name = "front wheel";
    body[3].parent = 2;
    body[3].joint = mbsr_joint_revolute(&front, NULL, across);
    body[3].inertia =
        mbsr_inertia_rigid(3.0, NULL, (const double[6]){0.1405, 0.28, 0.1405, 0, 0, 0});
    mbsr_model *m;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    for (int k = 0; k < 4; ++k)
        assert_ok(mbsr_model_add_body(m, body + k, NULL), mbsr_model_error(m));
    const mbsr_force_def weight = mbsr_force_gravity(0, 0, bicycle_gravity);
    assert_ok(mbsr_model_add_force(m, &weight, NULL), mbsr_model_error(m));
    const mbsr_closure_def rear = mbsr_closure_rolling_disc(1, &disc, bicycle_rear, MBSR_GROUND,
                                                            &ground),
                           fore = mbsr_closure_rolling_disc(3, &disc, bicycle_front, MBSR_GROUND,
                                                            &ground);
    assert_ok(mbsr_model_add_closure(m, &rear, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_add_closure(m, &fore, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    return m;
}

/* Upright at speed v. */
static inline void bicycle_ride(double v, double *q, double *u)
{
    for (int k = 0; k < BICYCLE_RATES; ++k) q[k] = u[k] = 0.0;
    u[0] = v;
    u[6] = -v / bicycle_rear;
    u[8] = -v / bicycle_front;
}

#endif
