/* Bushing between two frames in space.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Along the axes of A: e the origin of B, theta the rotation vector of B, R_A^T R_B = exp [theta]x,
 * omega the angular velocity relative to A. From theta' = J^-1(theta) omega and the energy
 *
 *   E = 1/2 sum of c theta^2 + 1/2 sum of c e^2
 *
 * moment and force on B:  -J^-T(theta) (c theta) - d omega,   -(c e + d e')
 *
 * (rotation.h) */
#include "algebra/frames.h"
#include "algebra/space3.h"
#include "forces/marker.h"
#include "forces/rotation.h"
#include "forces/slopes.h"
#include "forces/springs.h"
#include "forces/stock.h"

#include <math.h>
#include <string.h>

/* A frame as parameters: origin, x axis, y axis; the z axis is their product. */
enum { ORIGIN, AXES = 3, FRAME_SIZE = 9 };
enum {
    FRAME_A,
    FRAME_B = FRAME_SIZE,
    STIFFNESS = 2 * FRAME_SIZE, /* angular, then of translation */
    DAMPING = STIFFNESS + 6,
    DEFECT_A = DAMPING + 6, /* of the axes that were given */
    DEFECT_B
};

typedef struct bushing {
    mbsri_marker at;            /* A's origin on body a */
    mbsri_marker a, b;          /* the points of both bodies where B's origin is */
    double axes[9];             /* A's, in the world */
    double theta[3], e[3];      /* along them, and so are */
    double omega[3], e_rate[3]; /* zero while the energy is asked for */
    bool half;                  /* theta is one of two (rotation.h) */
} bushing;

/* Axes in the world of the frame that stands at `frame` in the parameters. */
static void frame_axes(const mbsr_force_body *body, const double *frame, double axes[9])
{
    double R[9], in_body[9];
    memcpy(in_body, frame + AXES, 6 * sizeof *in_body);
    mbsri_cross3(in_body, in_body + 3, in_body + 6);
    mbsri_body_axes(body, R);
    mbsri_multiply3(R, in_body, axes);
}

static void relative_pose(const mbsr_force_args *args, bushing *w)
{
    const mbsr_force_body *a = args->body, *b = args->body + 1;
    const double *param = args->force->param;
    double axes_b[9], axes_a_t[9], relative[9], spin[2][3], quaternion[4];
    frame_axes(a, param + FRAME_A, w->axes);
    frame_axes(b, param + FRAME_B, axes_b);
    for (int j = 0; j < 3; ++j) {
        for (int k = 0; k < 3; ++k) axes_a_t[3 * k + j] = w->axes[3 * j + k];
    }
    mbsri_multiply3(axes_a_t, axes_b, relative);
    mbsr_rotation_quaternion(relative, quaternion);
    mbsri_quaternion_vector(quaternion, w->theta);
    w->half = mbsri_turn_is_half(quaternion, w->theta, param + STIFFNESS);
    mbsri_marker_on(a, param + FRAME_A + ORIGIN, &w->at);
    mbsri_marker_on(b, param + FRAME_B + ORIGIN, &w->b);
    mbsri_marker_at(a, w->b.x, &w->a);
    mbsri_body_spin(a, spin[0]);
    mbsri_body_spin(b, spin[1]);
    for (int k = 0; k < 3; ++k) {
        w->e[k] = w->b.x[k] - w->at.x[k];
        w->e_rate[k] = w->b.v[k] - w->a.v[k];
        w->omega[k] = spin[1][k] - spin[0][k];
    }
    mbsri_unrotate3(w->axes, w->e, w->e);
    mbsri_unrotate3(w->axes, w->e_rate, w->e_rate);
    mbsri_unrotate3(w->axes, w->omega, w->omega);
}

/* Force and moment on a, the opposite of those on b, along the world axes. */
static void exert(const mbsr_force_args *args, const bushing *w, double force[3], double moment[3])
{
    const double *stiffness = args->force->param + STIFFNESS,
                 *damping = args->force->param + DAMPING;
    for (int k = 0; k < 3; ++k) moment[k] = stiffness[k] * w->theta[k];
    mbsri_unturn(w->theta, moment, moment);
    for (int k = 0; k < 3; ++k) {
        moment[k] += damping[k] * w->omega[k];
        force[k] = stiffness[3 + k] * w->e[k] + damping[3 + k] * w->e_rate[k];
    }
    mbsri_rotate3(w->axes, moment, moment);
    mbsri_rotate3(w->axes, force, force);
}

static int evaluate(const mbsr_force_args *args)
{
    bushing w;
    double moment[3], force[3];
    relative_pose(args, &w);
    if (w.half) return MBSR_DEGENERATE_FORCE;
    exert(args, &w, force, moment);
    mbsri_push(args->body, &w.a, 1.0, force, moment);
    mbsri_push(args->body + 1, &w.b, -1.0, force, moment);
    return MBSR_OK;
}

/* ---- derivatives ---- */

/* y = R_A diag(c) R_A^T x */
static void along_axes(const bushing *w, const double *c, const double x[3], double y[3])
{
    mbsri_unrotate3(w->axes, x, y);
    for (int k = 0; k < 3; ++k) y[k] *= c[k];
    mbsri_rotate3(w->axes, y, y);
}

/* Derivatives of e, e' and omega, which are R_A times what is seen from A: a vector x in the world
 * changes by dx - phi_a x x there. */
typedef struct seen {
    mbsri_vector e[MBSRI_MAX_COLUMNS], e_rate[MBSRI_MAX_COLUMNS], omega[MBSRI_MAX_COLUMNS];
    mbsri_vector phi[MBSRI_MAX_COLUMNS];                             /* phi_b - phi_a */
    mbsri_vector arm_a[MBSRI_MAX_COLUMNS], arm_b[MBSRI_MAX_COLUMNS]; /* not seen from A */
} seen;

static void see_motion(const mbsri_columns *c, const bushing *w, seen *d)
{
    double e[3], e_rate[3], omega[3];
    mbsri_rotate3(w->axes, w->e, e);
    mbsri_rotate3(w->axes, w->e_rate, e_rate);
    mbsri_rotate3(w->axes, w->omega, omega);
    memset(d, 0, sizeof *d);
    /* the point x where B's origin is */
    mbsri_add_turn(c, 1, MBSRI_POSE, 1.0, w->b.arm, d->arm_b);
    memcpy(d->arm_a, d->arm_b, sizeof d->arm_a);
    mbsri_add_shift(c, 1, MBSRI_POSE, 1.0, d->arm_a);
    memcpy(d->e, d->arm_a, sizeof d->e);
    mbsri_add_shift(c, 0, MBSRI_POSE, -1.0, d->arm_a);
    /* e = x - origin of A */
    mbsri_add_shift(c, 0, MBSRI_POSE, -1.0, d->e);
    mbsri_add_turn(c, 0, MBSRI_POSE, -1.0, w->at.arm, d->e);
    mbsri_add_turn(c, 0, MBSRI_POSE, -1.0, e, d->e);
    mbsri_add_velocity(c, 1, 1.0, w->b.arm, d->arm_b, d->e_rate);
    mbsri_add_velocity(c, 0, -1.0, w->a.arm, d->arm_a, d->e_rate);
    mbsri_add_turn(c, 0, MBSRI_POSE, -1.0, e_rate, d->e_rate);
    mbsri_add_spin(c, 1, MBSRI_RATE, 1.0, d->omega);
    mbsri_add_spin(c, 0, MBSRI_RATE, -1.0, d->omega);
    mbsri_add_turn(c, 0, MBSRI_POSE, -1.0, omega, d->omega);
    mbsri_add_spin(c, 1, MBSRI_POSE, 1.0, d->phi);
    mbsri_add_spin(c, 0, MBSRI_POSE, -1.0, d->phi);
}

static int derivatives(const mbsr_force_args *args, const mbsr_force_derivatives *out)
{
    const mbsri_columns c = mbsri_make_columns(args, out);
    const double *stiffness = args->force->param + STIFFNESS,
                 *damping = args->force->param + DAMPING;
    mbsri_vector dforce[MBSRI_MAX_COLUMNS] = {{{0.0}}}, dmoment[MBSRI_MAX_COLUMNS] = {{{0.0}}};
    double force[3], moment[3], T[9], y[3];
    bushing w;
    seen d;
    relative_pose(args, &w);
    if (w.half) return MBSR_DEGENERATE_FORCE;
    exert(args, &w, force, moment);
    see_motion(&c, &w, &d);
    mbsri_turning_stiffness(w.theta, stiffness, T);
    for (int l = 0; l < c.count; ++l) {
        along_axes(&w, stiffness + 3, d.e[l].x, dforce[l].x);
        along_axes(&w, damping + 3, d.e_rate[l].x, y);
        mbsri_add3(1.0, y, dforce[l].x);
        along_axes(&w, damping, d.omega[l].x, dmoment[l].x);
        mbsri_unrotate3(w.axes, d.phi[l].x, y);
        mbsri_rotate3(T, y, y);
        mbsri_rotate3(w.axes, y, y);
        mbsri_add3(1.0, y, dmoment[l].x);
    }
    mbsri_add_turn(&c, 0, MBSRI_POSE, 1.0, force, dforce);
    mbsri_add_turn(&c, 0, MBSRI_POSE, 1.0, moment, dmoment);
    mbsri_push_slopes(&c, 0, 1.0, w.a.arm, force, d.arm_a, dforce, dmoment);
    mbsri_push_slopes(&c, 1, -1.0, w.b.arm, force, d.arm_b, dforce, dmoment);
    return MBSR_OK;
}

/* ---- energies and the rest ---- */

static int energy(const mbsr_force_args *args, double *energy_out)
{
    const double *stiffness = args->force->param + STIFFNESS;
    bushing w;
    relative_pose(args, &w);
    for (int k = 0; k < 3; ++k) {
        *energy_out +=
            0.5 * (stiffness[k] * w.theta[k] * w.theta[k] + stiffness[3 + k] * w.e[k] * w.e[k]);
    }
    return MBSR_OK;
}

static int dissipation(const mbsr_force_args *args, double *power)
{
    const double *damping = args->force->param + DAMPING;
    bushing w;
    relative_pose(args, &w);
    for (int k = 0; k < 3; ++k) {
        *power += damping[k] * w.omega[k] * w.omega[k] + damping[3 + k] * w.e_rate[k] * w.e_rate[k];
    }
    return MBSR_OK;
}

static int check(const mbsr_force_args *args, char text[MBSR_TEXT_SIZE])
{
    for (int k = 0; k < 2; ++k) {
        const int status = mbsri_check_spatial(args, k, 1, text);
        if (status) return status;
        const double defect = args->force->param[DEFECT_A + k];
        if (!(defect <= 1e-6)) {
            return mbsri_refuse(text, MBSR_ERR_VALUE,
                                "the axes of frame %c are not orthonormal and right-handed: "
                                "R^T R differs from 1 by %g",
                                k ? 'B' : 'A', defect);
        }
    }
    const int status = mbsri_check_not_negative(args, STIFFNESS, 12, text);
    return status ? status : mbsri_check_ends(args, text);
}

/* The axes that are stored are orthonormal, unless those given were not. */
static int check_fields(const mbsr_force_def *def, char text[MBSR_TEXT_SIZE])
{
    const int status = mbsri_check_shape(def, 2, 0, text);
    if (status) return status;
    for (int k = 0; k < 2; ++k) {
        const double *x = def->param + (k ? FRAME_B : FRAME_A) + AXES, *y = x + 3;
        const double defect = fmax(fabs(mbsri_dot3(x, y)), fmax(fabs(mbsri_dot3(x, x) - 1.0),
                                                                fabs(mbsri_dot3(y, y) - 1.0)));
        if (def->param[DEFECT_A + k] <= 1e-6 && !(defect <= 1e-9)) {
            return mbsri_refuse(text, MBSR_ERR_VALUE,
                                "the axes of frame %c are not orthonormal: R^T R differs from 1 "
                                "by %g",
                                k ? 'B' : 'A', defect);
        }
    }
    return MBSR_OK;
}

static const char *parameter(int k)
{
    static const char *const names[] = {
        " (frame A, x[0])", " (frame A, x[1])", " (frame A, x[2])", " (frame A, R[0])",
        " (frame A, R[1])", " (frame A, R[2])", " (frame A, R[3])", " (frame A, R[4])",
        " (frame A, R[5])", " (frame B, x[0])", " (frame B, x[1])", " (frame B, x[2])",
        " (frame B, R[0])", " (frame B, R[1])", " (frame B, R[2])", " (frame B, R[3])",
        " (frame B, R[4])", " (frame B, R[5])", " (stiffness[0])",  " (stiffness[1])",
        " (stiffness[2])",  " (stiffness[3])",  " (stiffness[4])",  " (stiffness[5])",
        " (damping[0])",    " (damping[1])",    " (damping[2])",    " (damping[3])",
        " (damping[4])",    " (damping[5])",    " (frame A, R)",    " (frame B, R)"};
    return MBSRI_PARAMETER(names, k);
}

/* Where the moment jumps, or may. */
static double half_turn_side(const mbsr_force_args *args)
{
    const double *stiffness = args->force->param + STIFFNESS;
    bushing w;
    if (!(stiffness[0] > 0.0 || stiffness[1] > 0.0 || stiffness[2] > 0.0)) return 0.0;
    relative_pose(args, &w);
    return mbsri_turn_side(w.theta);
}

static const mbsr_force_table bushing_table = {
    .version = MBSR_FORCE_TABLE_VERSION,
    .flags = MBSR_FORCE_NO_MASS | MBSR_FORCE_NO_JOINT,
    .name = "bushing",
    .evaluate = evaluate,
    .energy = energy,
    .dissipation = dissipation,
    .check = check,
    .check_fields = check_fields,
    .parameter = parameter,
    .derivatives = derivatives,
    .side = half_turn_side,
};

/* Infinite defects, of left-handed axes and those that are not finite, count as 1. */
static void store_frame(const mbsr_frame *frame, double *param, double *defect)
{
    const mbsr_frame identity = mbsr_frame_identity();
    double stored[12];
    if (!frame) frame = &identity;
    mbsri_store_frame(frame, stored);
    memcpy(param, stored, FRAME_SIZE * sizeof *param);
    *defect = fmin(mbsri_frame_defect(frame->R), 1.0);
}

mbsr_force_def mbsr_force_bushing(int a, const mbsr_frame *A, int b, const mbsr_frame *B,
                                  const double stiffness[6], const double damping[6])
{
    mbsr_force_def def = mbsri_stock_force(&bushing_table, 2, a, b);
    store_frame(A, def.param + FRAME_A, def.param + DEFECT_A);
    store_frame(B, def.param + FRAME_B, def.param + DEFECT_B);
    if (stiffness) memcpy(def.param + STIFFNESS, stiffness, 6 * sizeof *stiffness);
    if (damping) memcpy(def.param + DAMPING, damping, 6 * sizeof *damping);
    return def;
}

/* The frame as mbsri_store_frame writes it. */
static void read_frame(const double *stored, double frame[12])
{
    memcpy(frame, stored, FRAME_SIZE * sizeof *frame);
    mbsri_cross3(frame + AXES, frame + AXES + 3, frame + AXES + 6);
}

bool mbsri_read_bushing(const mbsr_force_def *def, mbsri_spring *spring)
{
    if (def->table != &bushing_table) return false;
    spring->kind = MBSRI_BUSHING;
    read_frame(def->param + FRAME_A, spring->a);
    read_frame(def->param + FRAME_B, spring->b);
    memcpy(spring->stiffness, def->param + STIFFNESS, 6 * sizeof *spring->stiffness);
    memcpy(spring->damping, def->param + DAMPING, 6 * sizeof *spring->damping);
    return true;
}

_Static_assert(DEFECT_B < MBSR_FORCE_PARAMS, "too many parameters");
