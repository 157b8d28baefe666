/* Calls on an arm of 7 joints whose hand has 12 locked ones, with springs on them, and on the arm
 * built without these 12: dumps and standard output as of count.c, with one body each.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   instructions_locks [unused] */
#include "bench.h"

#include <mbsrank/mbsrank.h>

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { ARM = 7, FINGERS = 4, LINKS = 3, CALLS = 5 };

static const char *const call_name[CALLS] = {"forward", "inverse", "momentum", "factor", "solve"};

typedef struct arm {
    mbsr_model *model;
    mbsr_data *data;
    mbsr_newton *newton;
    double q[ARM], u[ARM], x[ARM], out[ARM], y[3 * ARM], yp[3 * ARM], F[3 * ARM];
} arm;

static int add(mbsr_model *m, int parent, const mbsr_frame *at, const double axis[3],
               mbsr_inertia inertia)
{
    mbsr_body_def body = mbsr_default_body_def();
    int id = -1;
    body.parent = parent;
    body.joint = mbsr_joint_revolute(at, NULL, axis);
    body.inertia = inertia;
    bench_check(mbsr_model_add_body(m, &body, &id), "add_body", mbsr_model_error(m)->text);
    return id;
}

/* The hand: bodies on locked joints of `palm`, if there is one; the inertia of a palm with them. */
static mbsr_inertia add_hand(mbsr_model *m, int palm, mbsr_inertia own)
{
    mbsr_inertia sum = own;
    for (int f = 0; f < FINGERS; ++f) {
        mbsr_frame pose = mbsr_frame_identity();
        int last = palm;
        for (int k = 0; k < LINKS; ++k) {
            const double axis[3] = {1.0, 0.1 * k, 0.0}, q = 0.3 + 0.1 * k + 0.05 * f;
            const mbsr_frame at = mbsr_frame_at(0.02 * f, 0.01, 0.04),
                             turned = mbsr_frame_rotated(NULL, axis, q);
            const mbsr_inertia link = mbsr_inertia_rigid(0.05, (const double[3]){0.0, 0.0, 0.02},
                                                         (const double[6]){1e-5, 2e-5, 2e-5});
            pose = mbsr_frame_product(&pose, &at);
            pose = mbsr_frame_product(&pose, &turned);
            sum = mbsr_inertia_sum(sum, mbsr_inertia_in_frame(&pose, link));
            if (palm < 0) continue;
            last = add(m, last, &at, axis, link);
            const mbsr_force_def spring = mbsr_force_joint_spring(last, 0, 5.0, 0.1, 0.2);
            bench_check(mbsr_model_add_force(m, &spring, NULL), "add_force", NULL);
            bench_check(mbsr_model_lock(m, last, 0, q), "lock", mbsr_model_error(m)->text);
        }
    }
    return sum;
}

static void make(arm *a, int locked)
{
    mbsr_model *m = NULL;
    int last = MBSR_GROUND;
    bench_check(mbsr_model_create(NULL, &m, NULL), "mbsr_model_create", NULL);
    const mbsr_force_def gravity = mbsr_force_gravity(0.0, 0.0, -9.81);
    for (int k = 0; k < ARM; ++k) {
        const double axis[3] = {k % 3 == 0, k % 3 == 1, k % 3 == 2};
        const mbsr_frame at = mbsr_frame_at(0.05, 0.02 * k, 0.3);
        mbsr_inertia link = mbsr_inertia_rigid(2.0, (const double[3]){0.01, 0.02, 0.15},
                                               (const double[6]){0.02, 0.03, 0.02, 0.001});
        if (k == ARM - 1 && !locked) link = add_hand(m, MBSR_GROUND, link);
        last = add(m, last, &at, axis, link);
        a->q[k] = sin(k + 1.0);
        a->u[k] = cos(3.0 * k);
        a->x[k] = sin(5.0 * k);
    }
    if (locked) (void)add_hand(m, last, mbsr_inertia_zero());
    bench_check(mbsr_model_add_force(m, &gravity, NULL), "add_force", NULL);
    bench_check(mbsr_model_finish(m), "mbsr_model_finish", mbsr_model_error(m)->text);
    a->model = m;
    bench_check(mbsr_data_create(m, &a->data, NULL), "mbsr_data_create", NULL);
    bench_check(mbsr_newton_create(m, MBSR_DAE_MOMENTUM, NULL, &a->newton, NULL), "newton", NULL);
    bench_check(mbsr_dae_pack(m, a->data, MBSR_DAE_MOMENTUM, 0.0, a->q, a->u, a->y), "pack", NULL);
    memset(a->yp, 0, sizeof a->yp);
}

static int call(arm *a, int which)
{
    switch (which) {
    case 0: return mbsr_forward_dynamics(a->model, a->data, 0.0, a->q, a->u, a->x, a->out);
    case 1: return mbsr_inverse_dynamics(a->model, a->data, 0.0, a->q, a->u, a->x, NULL, a->out);
    case 2: return mbsr_dae_residual(a->model, a->data, MBSR_DAE_MOMENTUM, 0.0, a->y, a->yp, a->F);
    case 3: return mbsr_newton_factor(a->newton, a->data, 0.0, a->y, a->yp, 100.0);
    default: return mbsr_newton_solve(a->newton, a->y, a->F);
    }
}

/* Known to callgrind by its name; never inlined, as it is called through a pointer. */
int measured(arm *a, int which);

int measured(arm *a, int which)
{
    return call(a, which);
}

static int (*volatile measure)(arm *a, int which) = measured;

int main(void)
{
    for (int locked = 0; locked < 2; ++locked) {
        arm a;
        make(&a, locked);
        for (int which = 0; which < CALLS; ++which) {
            /* the first call finds the functions of shared libraries */
            bench_check(call(&a, which), call_name[which], mbsr_data_error(a.data)->text);
            bench_check(measure(&a, which), call_name[which], mbsr_data_error(a.data)->text);
            printf("arm %s %s 1\n", locked ? "locked" : "built", call_name[which]);
        }
        mbsr_newton_destroy(a.newton);
        mbsr_data_destroy(a.data);
        mbsr_model_destroy(a.model);
    }
    return 0;
}
