/* A figure of eleven bodies jumps, tumbles and lies down, in steps of fixed size and bounded
 * work (stepper.h).
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Muscles drive its knees and elbows towards angles that are set before each step and held over
 * it: the drives are part of the model, so that the steps damp them, however stiff. (Torques
 * that a program computes from q and u and holds are stable only where its samples are fast
 * enough.) The muscles give way after 1 s. Steps of 1/60 s, as a game takes them, and of 1 ms,
 * as hardware in the loop does; steps that meet contacts are divided by themselves. The table
 * shows what steps take, real_time.csv has the figure at some times for real_time.gp. */
#include "build.h"

#include <math.h>

enum { LIMBS = 10, BODIES = LIMBS + 1, MUSCLES = 4 };

static const double limp = 1.0, T = 6.0; /* s */

/* A rod from the joint at `from` of its predecessor; bends 0: ball joint, else a hinge that
 * bends this way. */
static const struct limb {
    const char *name;
    int parent;
    double from[3], along[3], mass, radius; /* m, m, kg, m */
    int bends;
} limbs[LIMBS] = {{"chest", 0, {0, 0, 0.08}, {0, 0, 0.45}, 24.0, 0.12, 0},
                  {"head", 1, {0, 0, 0.45}, {0, 0, 0.28}, 5.0, 0.1, 0},
                  {"upper arm l", 1, {0, 0.18, 0.4}, {0, 0.05, -0.28}, 2.0, 0.05, 0},
                  {"forearm l", 3, {0, 0.05, -0.28}, {0, 0, -0.35}, 1.5, 0.04, -1},
                  {"upper arm r", 1, {0, -0.18, 0.4}, {0, -0.05, -0.28}, 2.0, 0.05, 0},
                  {"forearm r", 5, {0, -0.05, -0.28}, {0, 0, -0.35}, 1.5, 0.04, -1},
                  {"thigh l", 0, {0, 0.1, -0.05}, {0, 0, -0.42}, 8.0, 0.07, 0},
                  {"shin l", 7, {0, 0, -0.42}, {0, 0, -0.46}, 5.0, 0.06, 1},
                  {"thigh r", 0, {0, -0.1, -0.05}, {0, 0, -0.42}, 8.0, 0.07, 0},
                  {"shin r", 9, {0, 0, -0.42}, {0, 0, -0.46}, 5.0, 0.06, 1}};

static const int muscle[MUSCLES] = {4, 6, 8, 10}; /* ids of forearms and shins */

static void add_contact(mbsr_model *m, int body, const double *centre, double radius)
{
    const mbsr_contact contact = {.centre = {centre[0], centre[1], centre[2]},
                                  .radius = radius,
                                  .normal = {0, 0, 1},
                                  .stiffness = 4e5,
                                  .exponent = 1.5,
                                  .damping = 0.5,
                                  .friction = 0.7,
                                  .slip = 0.02};
    add_force(m, mbsr_force_contact(body, MBSR_GROUND, &contact));
}

static void add_limb(mbsr_model *m, const struct limb *l)
{
    const double zero[3] = {0, 0, 0}, y[3] = {0, 1, 0}, spring[3] = {10, 10, 10},
                 damper[3] = {2, 2, 2};
    const double i = 0.1 * l->mass * l->radius * l->radius, tensor[6] = {i, i, i, 0, 0, 0};
    const mbsr_frame at = mbsr_frame_at(l->from[0], l->from[1], l->from[2]);
    const mbsr_inertia inertia = mbsr_inertia_sum(mbsr_inertia_rod(0.8 * l->mass, zero, l->along),
                                                  mbsr_inertia_rigid(0.2 * l->mass, zero, tensor));
    const int id = add_body(
        m, l->name, l->parent,
        l->bends ? mbsr_joint_revolute(&at, NULL, y) : mbsr_joint_spherical(&at, NULL), inertia);
    if (l->bends) {
        const double lower = l->bends > 0 ? 0.0 : -2.4;
        add_force(m, mbsr_force_joint_stop(id, 0, lower, lower + 2.4, 500.0, 5.0));
        add_force(m, mbsr_force_joint_spring(id, 0, 0.0, 0.5, 0.0));
    } else {
        add_force(m, mbsr_force_joint_rotation_spring(id, spring, damper, NULL));
    }
    add_contact(m, id, l->along, l->radius);
}

/* Of a drive: an angle that is held, and its rate. */
static int held_angle(void *angle, double t, int n, double *value)
{
    (void)t, (void)n;
    value[0] = *(const double *)angle;
    value[1] = 0.0;
    return MBSR_OK;
}

/* angle: of the muscles; drive: their ids. */
static mbsr_model *build(double *angle, int *drive)
{
    const double edges[3] = {0.2, 0.3, 0.16}, centre[3] = {0, 0, 0};
    mbsr_model *m = new_model();
    add_force(m, mbsr_force_gravity(0, 0, -9.81));
    add_body(m, "pelvis", MBSR_GROUND, mbsr_joint_free(NULL, NULL),
             mbsr_inertia_box(1200.0, edges));
    add_contact(m, 0, centre, 0.1);
    for (int k = 0; k < LIMBS; ++k) add_limb(m, limbs + k);
    for (int k = 0; k < MUSCLES; ++k) {
        const mbsr_servo servo = {
            .kp = 200.0, .kd = 5.0, .limit = 80.0, .function = held_angle, .user = angle + k};
        const mbsr_force_def def = mbsr_force_joint_servo(muscle[k], 0, &servo);
        check(mbsr_model_add_force(m, &def, drive + k), mbsr_model_error(m));
    }
    check(mbsr_model_finish(m), mbsr_model_error(m));
    return m;
}

/* What the muscles aim at: legs that run, bent arms; from `limp` on nothing. */
static void control(const mbsr_model *m, mbsr_data *d, double t, double *angle, const int *drive)
{
    for (int k = 0; k < MUSCLES; ++k) {
        const double phase = 12.0 * t + (k % 2 ? 3.14159 : 0.0);
        angle[k] = k < 2 ? -1.2 : 0.9 + 0.7 * sin(phase);
        if (t >= limp) check(mbsr_force_switch(m, d, drive[k], 0), mbsr_data_error(d));
    }
}

/* Ends of all limbs, where data is; a line each. */
static void draw(FILE *file, const mbsr_model *m, mbsr_data *d)
{
    for (int k = 0; k < LIMBS; ++k) {
        double p[MBSR_POSE_SIZE];
        check(mbsr_body_pose(m, d, k + 1, p), mbsr_data_error(d));
        const double *R = p + MBSR_POSE_R, *x = p + MBSR_POSE_X, *a = limbs[k].along;
        for (int end = 0; end < 2; ++end)
            fprintf(file, "%g,%g,%g\n", x[0] + end * (R[0] * a[0] + R[3] * a[1] + R[6] * a[2]),
                    x[1] + end * (R[1] * a[0] + R[4] * a[1] + R[7] * a[2]),
                    x[2] + end * (R[2] * a[0] + R[5] * a[1] + R[8] * a[2]));
        fprintf(file, "\n");
    }
    fprintf(file, "\n");
}

/* Runs for T; returns the kinetic energy at the end, J. */
static double run(double h, int order, FILE *file)
{
    static const int frames[] = {0, 12, 24, 36, 60, 360}; /* of 60 a second */
    int drive[MUSCLES];
    double angle[MUSCLES] = {0}, q[64] = {0}, u[64] = {0}, t = 0.0, kinetic, potential;
    mbsr_model *m = build(angle, drive);
    mbsr_data *d;
    mbsr_stepper *stepper;
    mbsr_error error;
    mbsr_stepper_opt opt = mbsr_default_stepper_opt();
    opt.h = h;
    opt.order = order;
    check(mbsr_data_create(m, &d, &error), &error);
    check(mbsr_stepper_create(m, d, &opt, &stepper, &error), &error);
    for (int k = 0; k < BODIES; ++k) { /* quaternions */
        int at, nq, nu;
        mbsr_body_coordinates(m, k, &at, &nq, NULL, &nu);
        if (nq > nu) q[at] = 1.0;
    }
    q[6] = 1.5, u[1] = 4.0, u[3] = 2.5; /* 1.5 m high, forward at 2.5 m/s and turning at 4 rad/s */
    check(mbsr_stepper_start(stepper, t, q, u), mbsr_stepper_error(stepper));
    const int steps = (int)(T / h + 0.5), every = (int)(1.0 / (60.0 * h) + 0.5);
    long residuals = 0, substeps = 0;
    mbsr_stepper_info info;
    for (int n = 0, next = 0; n <= steps; ++n) {
        if (file && next < 6 && n == frames[next] * every) draw(file, m, d), ++next;
        if (n == steps) break;
        control(m, d, t, angle, drive);
        check(mbsr_stepper_step(stepper), mbsr_stepper_error(stepper));
        mbsr_stepper_motion(stepper, &t, q, u);
        mbsr_stepper_get_info(stepper, &info);
        residuals += info.last.residuals;
        substeps += info.last.substeps;
    }
    check(mbsr_energy(m, d, &kinetic, &potential), mbsr_data_error(d));
    printf("%7.2f ms %6d %8d %9.2f %9.1f %12d %15.1e\n", 1e3 * h, order, steps,
           (double)substeps / steps, (double)residuals / steps, info.most.residuals, kinetic);
    mbsr_stepper_destroy(stepper);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
    return kinetic;
}

int main(void)
{
    FILE *file = csv("real_time.csv");
    double most = 0.0;
    printf("      step  order    steps  substeps  residuals  at most  kinetic energy [J]\n");
    for (int order = 1; order <= 2; ++order) {
        most = fmax(most, run(1.0 / 60.0, order, order == 2 ? file : NULL));
        most = fmax(most, run(1e-3, order, NULL));
    }
    fclose(file);
    return most < 0.1 ? 0 : 1;
}
