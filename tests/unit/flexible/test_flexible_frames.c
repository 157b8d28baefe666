/* Flexible bodies in turning frames, and in frames fixed to one marker or another.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"

#include <mbsrank/mbsrank.h>

#include <string.h>

static const double pi = 3.14159265358979323846, spin = 3.0;

/* A model of one flexible body that a joint holds at marker 0, with gravity. */
typedef struct held {
    mbsr_flex *flex;
    mbsr_model *model;
    mbsr_data *data;
} held;

static held hold(const mbsr_flex_def *def, mbsr_joint joint, double g)
{
    held w;
    mbsr_error error;
    mbsr_flexible_def body = mbsr_default_flexible_def();
    const mbsr_force_def gravity = mbsr_force_gravity(0.0, -g, 0.0);
    assert_ok(mbsr_flex_create(def, &w.flex, &error), &error);
    assert_ok(mbsr_model_create(NULL, &w.model, &error), &error);
    body.flex = w.flex, body.joint = joint;
    assert_ok(mbsr_model_add_flexible(w.model, &body, NULL), mbsr_model_error(w.model));
    assert_ok(mbsr_model_add_force(w.model, &gravity, NULL), mbsr_model_error(w.model));
    assert_ok(mbsr_model_finish(w.model), mbsr_model_error(w.model));
    assert_ok(mbsr_data_create(w.model, &w.data, &error), &error);
    return w;
}

static void let_go(held *w)
{
    mbsr_data_destroy(w->data);
    mbsr_model_destroy(w->model);
    mbsr_flex_destroy(w->flex);
}

/* ---- a shaft that spins ---- */

static int turn(void *user, double t, double *angle, double *rate, double *second)
{
    (void)user;
    *angle = spin * t, *rate = spin, *second = 0.0;
    return MBSR_OK;
}

/* Simply supported, L = EI = density = 1, first mode along y and z: in the turning frame whirls
 * have pi^2 - spin, in its sense pi^2 + spin against it. */
static void whirls_of_a_shaft(void **state)
{
    (void)state;
    const mbsr_axis axis = {.kind = MBSR_AXIS_ROTATION, .direction = {1.0, 0.0, 0.0}, .driven = 1};
    const mbsr_flex_marker root = {.frame = mbsr_frame_identity()};
    const double first = 2.0 / pi, moment = 1.0 / pi, stiffness = 0.5 * pi * pi * pi * pi;
    const double Ct0[6] = {[1] = first, [5] = first}, K[4] = {stiffness, 0.0, 0.0, stiffness};
    double P0[18] = {0.0}, P[36] = {0.0};
    mbsr_flex_def def = mbsr_default_flex_def();
    def.mass = 1.0, def.c0[0] = 0.5, def.N0[0] = 1.0 / 3.0, def.modes = 2;
    P0[3 * 1] = P0[9 + 3 * 2] = moment; /* int x Phi */
    P[6 * 1 + 1] = P[6 * 5 + 5] = 0.5;
    P[6 * 1 + 5] = P[6 * 5 + 1] = 0.5; /* along y of the one, z of the other */
    def.Ct0 = Ct0, def.P0 = P0, def.P = P, def.K = K, def.markers = 1, def.marker = &root;
    held w = hold(&def, mbsr_joint_compound(NULL, NULL, 1, &axis, turn, NULL), 0.0);
    for (int sense = -1; sense <= 1; sense += 2) {
        const double omega = pi * pi + sense * spin, q[2] = {0.01, 0.0},
                     u[2] = {0.0, -sense * omega * q[0]};
        double udot[2];
        assert_ok(mbsr_forward_dynamics(w.model, w.data, 0.0, q, u, NULL, udot),
                  mbsr_data_error(w.data));
        assert_close(udot[0], -omega * omega * q[0], 1e-13);
        assert_close(udot[1], 0.0, 1e-13);
        assert_close(omega, sense < 0 ? 6.869604 : 12.869604, 1e-6);
    }
    let_go(&w);
}

/* ---- frames ---- */

enum { MODES = 2, POINTS = 5 };

/* Displacement along y and slope at x of a beam of length 1 bent by x^2, x^3, in a frame that moves
 * with the material at `at`. */
static void shape(double at, double x, double y[MODES], double slope[MODES])
{
    for (int a = 0; a < MODES; ++a) {
        const double p = a + 2.0, there = p * pow(at, p - 1.0);
        y[a] = pow(x, p) - pow(at, p) - there * (x - at);
        slope[a] = p * pow(x, p - 1.0) - there;
    }
}

/* The pendulum's accelerations where its frame is at `at`. */
static void accelerate(double at, double bend, double udot[1 + MODES])
{
    static const double z[3] = {0.0, 0.0, 1.0}, K[4] = {400.0, 600.0, 600.0, 1200.0},
                        node[3] = {0.0, 0.5384693101056831, 0.9061798459386640},
                        weight[3] = {0.5688888888888889, 0.4786286704993665, 0.2369268850561891};
    double Ct0[6] = {0.0}, P0[18] = {0.0}, P[36] = {0.0}, Phi[2][6] = {{0.0}}, Psi[2][6] = {{0.0}};
    double y[MODES], slope[MODES];
    mbsr_flex_marker marker[2];
    mbsr_flex_def def = mbsr_default_flex_def();
    def.modes = MODES, def.K = K, def.mass = 1.0, def.c0[0] = 0.5, def.N0[0] = 1.0 / 3.0;
    for (int k = 0; k < POINTS; ++k) { /* Gauss's points, exact to degree 9 */
        const int l = k < 2 ? 2 - k : k - 2;
        const double x = 0.5 + (k < 2 ? -0.5 : 0.5) * node[l], m = 0.5 * weight[l];
        shape(at, x, y, slope);
        for (int a = 0; a < MODES; ++a) {
            Ct0[3 * a + 1] += m * y[a];
            P0[9 * a + 3] += m * x * y[a];
            for (int b = 0; b < MODES; ++b) P[6 * (3 * b + 1) + 3 * a + 1] += m * y[a] * y[b];
        }
    }
    for (int k = 0; k < 2; ++k) {
        shape(at, k, y, slope);
        for (int a = 0; a < MODES; ++a) {
            Phi[k][3 * a + 1] = y[a];
            Psi[k][3 * a + 2] = slope[a];
        }
        marker[k] =
            (mbsr_flex_marker){.frame = mbsr_frame_at(k, 0.0, 0.0), .Phi = Phi[k], .Psi = Psi[k]};
    }
    def.Ct0 = Ct0, def.P0 = P0, def.P = P, def.markers = 2, def.marker = marker;
    held w = hold(&def, mbsr_joint_revolute(NULL, NULL, z), 9.81);
    const double q[3] = {0.3, bend, -0.5 * bend}, u[3] = {1.0, 0.0, 0.0};
    assert_ok(mbsr_forward_dynamics(w.model, w.data, 0.0, q, u, NULL, udot),
              mbsr_data_error(w.data));
    let_go(&w);
}

/* Held at its root in any case. At s = s' = 0 all frames agree, elsewhere to first order in s. */
static void frames_agree_where_nothing_is_bent(void **state)
{
    (void)state;
    double root[3], other[3], off[2] = {0.0};
    for (int k = 0; k < 2; ++k) {
        const double at = (double[2]){1.0, 0.5}[k];
        accelerate(0.0, 0.0, root);
        accelerate(at, 0.0, other);
        for (int l = 0; l < 3; ++l) assert_close(other[l], root[l], 1e-11 * fabs(root[l]));
        for (int l = 0; l < 2; ++l) {
            const double bend = (double[2]){1e-3, 1e-4}[l];
            accelerate(0.0, bend, root);
            accelerate(at, bend, other);
            off[l] = fabs(other[0] - root[0]);
        }
        assert_true(off[1] > 1e-9);
        assert_less(off[1], 0.2 * off[0]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(whirls_of_a_shaft),
        cmocka_unit_test(frames_agree_where_nothing_is_bent),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
