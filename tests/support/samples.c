/* The stock joints in space as sequences of elementary motions.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "samples.h"

#include <string.h>

double sample_wave(int k, double t, int derivative)
{
    const double a = 0.5 + 0.2 * k, w = 1.1 + 0.4 * k, phase = 0.5 * k + 0.2;
    if (derivative == 0) return a * sin(w * t + phase);
    return derivative == 1 ? a * w * cos(w * t + phase) : -a * w * w * sin(w * t + phase);
}

static int drive(void *user, double t, double *s, double *sdot, double *sddot)
{
    const int count = *(const int *)user;
    for (int k = 0; k < count; ++k) {
        s[k] = sample_wave(SAMPLE_DRIVEN + k, t, 0);
        sdot[k] = sample_wave(SAMPLE_DRIVEN + k, t, 1);
        sddot[k] = sample_wave(SAMPLE_DRIVEN + k, t, 2);
    }
    return 0;
}

static void add(sample *s, const double *turn, const double *shift, double pitch, int coordinate)
{
    elementary *e = s->step + s->steps++;
    *e = (elementary){.coordinate = coordinate};
    const double *axis = turn ? turn : shift;
    const double length =
        axis ? sqrt(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]) : 1.0;
    for (int k = 0; k < 3; ++k) {
        e->w[k] = turn ? turn[k] / length : 0.0;
        e->v[k] = turn ? pitch * turn[k] / length : shift ? shift[k] / length : 0.0;
    }
    e->quaternion = !turn && !shift;
}

static const double e_x[3] = {1, 0, 0}, e_y[3] = {0, 1, 0}, e_z[3] = {0, 0, 1};
static int two = 2;

/* Rotation a, driven shift b, screw c, driven screw d, shift e, in this order. */
static void make_compound(sample *s, double dir[5][3])
{
    mbsr_axis axes[5] = {{.kind = MBSR_AXIS_ROTATION},
                         {.kind = MBSR_AXIS_TRANSLATION, .driven = 1},
                         {.kind = MBSR_AXIS_SCREW, .pitch = 0.7},
                         {.kind = MBSR_AXIS_SCREW, .pitch = -0.4, .driven = 1},
                         {.kind = MBSR_AXIS_TRANSLATION}};
    for (int k = 0; k < 5; ++k) memcpy(axes[k].direction, dir[k], sizeof axes[k].direction);
    s->joint = mbsr_joint_compound(&s->A, &s->B, 5, axes, drive, &two);
    add(s, dir[0], NULL, 0.0, 0);
    add(s, NULL, dir[1], 0.0, 0), s->step[1].driven = true;
    add(s, dir[2], NULL, 0.7, 1);
    add(s, dir[3], NULL, -0.4, 1), s->step[3].driven = true;
    add(s, NULL, dir[4], 0.0, 2);
}

sample sample_make(int k, test_rng *rng)
{
    double dir[5][3];
    sample s = {.A = test_frame(rng, 1.0), .B = test_frame(rng, 1.0)};
    for (int l = 0; l < 5; ++l) test_fill(rng, 3, dir[l]);
    switch (k) {
    case 0: s.joint = mbsr_joint_weld(&s.A, &s.B); break;
    case 1: s.joint = mbsr_joint_revolute(&s.A, &s.B, dir[0]), add(&s, dir[0], NULL, 0, 0); break;
    case 2: s.joint = mbsr_joint_prismatic(&s.A, &s.B, dir[0]), add(&s, NULL, dir[0], 0, 0); break;
    case 3:
        s.joint = mbsr_joint_screw(&s.A, &s.B, dir[0], -0.6);
        add(&s, dir[0], NULL, -0.6, 0);
        break;
    case 4:
        s.joint = mbsr_joint_cylindrical(&s.A, &s.B, dir[0]);
        add(&s, NULL, dir[0], 0.0, 1), add(&s, dir[0], NULL, 0.0, 0);
        break;
    case 5:
        s.joint = mbsr_joint_universal(&s.A, &s.B, dir[0], dir[1]);
        add(&s, dir[0], NULL, 0.0, 0), add(&s, dir[1], NULL, 0.0, 1);
        break;
    case 6:
        s.joint = mbsr_joint_in_plane(&s.A, &s.B);
        add(&s, NULL, e_x, 0, 0), add(&s, NULL, e_y, 0, 1), add(&s, e_z, NULL, 0, 2);
        break;
    case 7:
        s.joint = mbsr_joint_translational(&s.A, &s.B);
        add(&s, NULL, e_x, 0, 0), add(&s, NULL, e_y, 0, 1), add(&s, NULL, e_z, 0, 2);
        break;
    case 8: s.joint = mbsr_joint_spherical(&s.A, &s.B), add(&s, NULL, NULL, 0, 0); break;
    case 9:
        s.joint = mbsr_joint_free(&s.A, &s.B);
        add(&s, NULL, e_x, 0, 4), add(&s, NULL, e_y, 0, 5), add(&s, NULL, e_z, 0, 6);
        add(&s, NULL, NULL, 0, 0);
        break;
    default: make_compound(&s, dir); break;
    }
    return s;
}

transform sample_pose(const sample *s, const double *q, double t)
{
    transform T = transform_of(s->A.R, s->A.x);
    for (int k = 0; k < s->steps; ++k) {
        const elementary *e = s->step + k;
        const double x =
            e->driven ? sample_wave(SAMPLE_DRIVEN + e->coordinate, t, 0) : q[e->coordinate];
        double w[3], v[3];
        for (int l = 0; l < 3; ++l) w[l] = x * e->w[l], v[l] = x * e->v[l];
        T = transform_product(T, e->quaternion ? transform_quaternion(q) : transform_exp(w, v));
    }
    return transform_product(T, transform_inverse(transform_of(s->B.R, s->B.x)));
}

/* R = R1 R2. */
int sample_root(void *user, double t, double *p, double *V, double *A)
{
    (void)user;
    const double a[3] = {0.36, 0.48, 0.8}, b[3] = {0.6, -0.8, 0.0}, none[3] = {0, 0, 0};
    double w[3], Rb[3];
    for (int k = 0; k < 3; ++k) w[k] = a[k] * sample_wave(1, t, 0);
    const transform R1 = transform_exp(w, none);
    for (int k = 0; k < 3; ++k) w[k] = b[k] * sample_wave(2, t, 0);
    transform T = transform_product(R1, transform_exp(w, none));
    for (int k = 0; k < 3; ++k) {
        Rb[k] = R1.m[k][0] * b[0] + R1.m[k][1] * b[1] + R1.m[k][2] * b[2];
        T.m[k][3] = sample_wave(3 + k, t, 0);
    }
    transform_pose(&T, p);
    const double f = sample_wave(1, t, 1) * sample_wave(2, t, 1);
    for (int k = 0; k < 3; ++k) {
        const int l = (k + 1) % 3, m = (k + 2) % 3;
        V[k] = a[k] * sample_wave(1, t, 1) + Rb[k] * sample_wave(2, t, 1);
        V[3 + k] = sample_wave(3 + k, t, 1);
        A[k] = a[k] * sample_wave(1, t, 2) + Rb[k] * sample_wave(2, t, 2) +
               f * (a[l] * Rb[m] - a[m] * Rb[l]);
        A[3 + k] = sample_wave(3 + k, t, 2);
    }
    return 0;
}
