/* Andrews' squeezer, with the data of the Test Set for IVP Solvers: K1 - K2, K3, K5 - K4 and K7 -
 * K6 on the ground, three pins at the end of K2, a motor at K1 and a spring at K3.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_SQUEEZER_H
#define TEST_SQUEEZER_H

#include "expect.h"

enum {
    SQUEEZER_K1,
    SQUEEZER_K2,
    SQUEEZER_K3,
    SQUEEZER_K5,
    SQUEEZER_K4,
    SQUEEZER_K7,
    SQUEEZER_K6,
    SQUEEZER_BODIES
};

/* beta, Theta, gamma, delta, epsilon, Phi, Omega, in the order of the bodies: at the start, and as
 * published for 0.03 s. */
static const double squeezer_start[SQUEEZER_BODIES] = {
    -0.0617138900142764496358948458001, 0,
    0.455279819163070380255912382449,   0.487364979543842550225598953530,
    0.222668390165885884674473185609,   1.23054744454982119249735015568,
    -0.222668390165885884674473185609};
static const double squeezer_end[SQUEEZER_BODIES] = {
    15.81077119629904,  -15.75637105984298, .04082224013073101, .5244099658805304,
    -.5347301163226948, 1.048080741042263,  .5347301163226948};

static inline int squeezer_torque(void *user, double t, int n, double *value)
{
    (void)user, (void)t, (void)n;
    value[0] = 0.033;
    return MBSR_OK;
}

static inline void squeezer_link(mbsr_model *m, const char *name, int parent, double x, double y,
                                 double mass, double moment, double cx, double cy)
{
    mbsr_body_def body = mbsr_default_body_def();
    body.name = name;
    body.parent = parent;
    body.joint = mbsr_joint_planar_revolute((mbsr_planar_frame){x, y, 0.0},
                                            (mbsr_planar_frame){0.0, 0.0, 0.0});
    body.inertia = mbsr_inertia_planar(mass, (double[2]){cx, cy}, moment);
    assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
}

static inline void squeezer_pin(mbsr_model *m, const char *name, int body, double x, double y)
{
    mbsr_closure_def pin =
        mbsr_closure_ball(SQUEEZER_K2, (double[3]){-28e-3, 0.0, 0.0}, body, (double[3]){x, y, 0.0});
    pin.name = name;
    assert_ok(mbsr_model_add_closure(m, &pin, NULL), mbsr_model_error(m));
}

/* Adds all of it to an empty model. */
static inline void squeezer_add(mbsr_model *m)
{
    const double xa = -.06934, ya = -.00227, xb = -.03635, yb = .03273, short_way = 2e-2 - 1421e-5;
    squeezer_link(m, "K1", MBSR_GROUND, 0, 0, .04325, 2.194e-6, 92e-5, 0);
    squeezer_link(m, "K2", SQUEEZER_K1, 7e-3, 0, .00365, 4.410e-7, -115e-4, 0);
    squeezer_link(m, "K3", MBSR_GROUND, xb, yb, .02373, 5.255e-6, 1874e-5, 1043e-5);
    squeezer_link(m, "K5", MBSR_GROUND, xa, ya, .07050, 1.169e-5, 2308e-5, 916e-5);
    squeezer_link(m, "K4", SQUEEZER_K5, 4e-2, 0, .00706, 5.667e-7, 0, -short_way);
    squeezer_link(m, "K7", MBSR_GROUND, xa, ya, .05498, 1.912e-5, 1228e-5, 449e-5);
    squeezer_link(m, "K6", SQUEEZER_K7, 0, -4e-2, .00706, 5.667e-7, short_way, 0);
    const mbsr_force_def spring = mbsr_force_point_spring(
                             SQUEEZER_K3, (double[3]){2e-2, -18e-3, 0.0}, MBSR_GROUND,
                             (double[3]){.014, .072, 0.0}, 4530.0, 0.0, .07785),
                         motor = mbsr_force_joint_applied(SQUEEZER_K1, squeezer_torque, NULL);
    assert_ok(mbsr_model_add_force(m, &motor, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_add_force(m, &spring, NULL), mbsr_model_error(m));
    squeezer_pin(m, "K2-K3", SQUEEZER_K3, 0, -35e-3);
    squeezer_pin(m, "K2-K4", SQUEEZER_K4, 0, -2e-2);
    squeezer_pin(m, "K2-K6", SQUEEZER_K6, 2e-2, 0);
}

#endif
