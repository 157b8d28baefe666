/* Stock joints of which coordinates are locked: see locked_joints.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A chain of steps (joints/chain.c) takes frame A to frame B by A T_1 T_2 .. = X B. A step that is
 * locked is a constant T. Those before the first free one become part of A. What is left stands
 * before another step as C = (x, R) and passes it,
 *
 *   C Rot(a, q) = Rot(R a, q) C   where x is along R a        C Trans(a q) = Trans(R a q) C
 *
 * so that at the end B <- B C^-1. Where C does not pass there is no such chain.
 *
 * In the plane (joints/planar.c) both translations come before the rotation: x and y that are
 * locked move frame A, an angle that is locked turns frame B back. */
#include "assembly/locked_joints.h"

#include "algebra/space3.h"
#include "joints/planar.h"

#include <math.h>
#include <string.h>

enum { A_X, A_Y, A_ANGLE, B_X, B_Y, B_ANGLE }; /* param of a joint in the plane */
enum { FREE, DRIVEN };                         /* its options */

/* All of whose functions are those of a chain, of as many steps as its options say. */
static bool is_chain(const mbsri_joint *joint)
{
    const mbsr_joint_table *table = joint->table;
    return table->position == mbsri_chain_position && table->jacobians == mbsri_chain_jacobians &&
           table->bias == mbsri_chain_bias &&
           (!table->normalise || table->normalise == mbsri_chain_normalise);
}

static bool is_planar(const mbsri_joint *joint)
{
    int free;
    return mbsri_planar_coordinates(joint->table, joint->option, &free);
}

bool mbsri_joint_has_frames(const mbsri_joint *joint)
{
    return is_chain(joint) || is_planar(joint);
}

static mbsr_frame frame_from(const double param[12])
{
    mbsr_frame frame;
    memcpy(frame.x, param, sizeof frame.x);
    memcpy(frame.R, param + 3, sizeof frame.R);
    return frame;
}

static void frame_to(const mbsr_frame *frame, double param[12])
{
    memcpy(param, frame->x, sizeof frame->x);
    memcpy(param + 3, frame->R, sizeof frame->R);
}

/* ---- chains ---- */

/* T of a step of this kind by s. */
static mbsr_frame step_by(int kind, const double axis[4], double s)
{
    const double pitch = kind == MBSRI_TRANSLATION ? 1.0
                         : kind == MBSRI_SCREW     ? axis[3]
                                                   : 0.0,
                 x[3] = {pitch * s * axis[0], pitch * s * axis[1], pitch * s * axis[2]};
    if (kind == MBSRI_TRANSLATION) return mbsr_frame_at(x[0], x[1], x[2]);
    return mbsr_frame_rotated(x, axis, s);
}

/* Whether C passes a step about or along `axis`, which becomes R axis. */
static bool passes(const mbsr_frame *C, int kind, double axis[4])
{
    double turned[3], off[3];
    mbsri_rotate3(C->R, axis, turned);
    mbsri_cross3(C->x, turned, off);
    const bool along = mbsri_norm3(off) <= 1e-15 * mbsri_norm3(C->x);
    memcpy(axis, turned, sizeof turned);
    return kind == MBSRI_TRANSLATION || (kind != MBSRI_QUATERNION && along);
}

static bool lock_chain(const mbsri_joint *joint, const double *locked_at, double *param,
                       mbsri_joint *left)
{
    mbsr_frame A = frame_from(param + MBSRI_A), B = frame_from(param + MBSRI_B),
               C = mbsr_frame_identity();
    int steps = 0, below[MBSRI_MAX_STEPS] = {0};
    bool waits = false; /* C is none */
    for (int k = 1; k < joint->n && k < MBSRI_MAX_STEPS; ++k)
        below[k] = below[k - 1] + !isnan(locked_at[k - 1]);
    for (int k = 0; k < joint->option[0]; ++k) {
        const int code = joint->option[1 + k], kind = code & MBSRI_STEP_KIND,
                  place = code >> MBSRI_PLACE_SHIFT;
        double axis[MBSRI_AXIS_SIZE];
        memcpy(axis, joint->param + MBSRI_AXES + MBSRI_AXIS_SIZE * k, sizeof axis);
        if (!(code & MBSRI_DRIVEN) && !isnan(locked_at[place])) {
            const mbsr_frame T = step_by(kind, axis, locked_at[place]);
            C = mbsr_frame_product(&C, &T);
            waits = true;
            continue;
        }
        if (waits && steps == 0) {
            A = mbsr_frame_product(&A, &C);
            C = mbsr_frame_identity();
            waits = false;
        }
        if (waits && !passes(&C, kind, axis)) return false;
        left->option[1 + steps] = code;
        if (!(code & MBSRI_DRIVEN)) left->option[1 + steps] -= below[place] << MBSRI_PLACE_SHIFT;
        memcpy(param + MBSRI_AXES + MBSRI_AXIS_SIZE * steps++, axis, sizeof axis);
    }
    if (waits) {
        const mbsr_frame back = mbsr_frame_inverse(&C);
        B = mbsr_frame_product(&B, &back);
    }
    frame_to(&A, param + MBSRI_A);
    frame_to(&B, param + MBSRI_B);
    left->option[0] = steps;
    return true;
}

/* ---- in the plane ---- */

static void lock_planar(const mbsri_joint *joint, const double *locked_at, double *param,
                        mbsri_joint *left)
{
    const double c = cos(param[A_ANGLE]), s = sin(param[A_ANGLE]);
    double by[3] = {0.0, 0.0, 0.0};
    for (int k = 0, place = 0; k < 3; ++k) {
        if (!(joint->option[FREE] & 1 << k)) continue;
        if (!isnan(locked_at[place])) {
            by[k] = locked_at[place];
            left->option[FREE] &= ~(1 << k);
        }
        ++place;
    }
    param[A_X] += c * by[0] - s * by[1];
    param[A_Y] += s * by[0] + c * by[1];
    param[B_ANGLE] -= by[2];
}

/* ---- both ---- */

bool mbsri_lock_joint(const mbsri_joint *joint, const double *locked_at, double *param,
                      mbsri_joint *left)
{
    if (!mbsri_joint_has_frames(joint)) return false;
    *left = *joint;
    left->param = param;
    memcpy(param, joint->param, (size_t)joint->params * sizeof *param);
    for (int k = 0; k < joint->n; ++k) {
        left->n -= !isnan(locked_at[k]);
        left->nq -= !isnan(locked_at[k]);
    }
    if (is_chain(joint)) return lock_chain(joint, locked_at, param, left);
    lock_planar(joint, locked_at, param, left);
    return true;
}

void mbsri_carry_joint(const mbsri_joint *joint, const mbsri_stand *pred, double *param)
{
    const mbsr_frame *frame = &pred->frame;
    if (is_chain(joint)) {
        const mbsr_frame A = frame_from(param + MBSRI_A), carried = mbsr_frame_product(frame, &A);
        frame_to(&carried, param + MBSRI_A);
        return;
    }
    const double a[3] = {param[A_X], param[A_Y], 0.0};
    double arm[3];
    mbsri_rotate3(frame->R, a, arm);
    param[A_X] = frame->x[0] + arm[0];
    param[A_Y] = frame->x[1] + arm[1];
    param[A_ANGLE] += pred->angle;
}

bool mbsri_rigid_joint(const mbsri_joint *joint, mbsri_stand *stand)
{
    static const double z[3] = {0.0, 0.0, 1.0};
    const double *p = joint->param;
    mbsr_frame A, B;
    stand->angle = 0.0;
    if (is_chain(joint)) {
        if (joint->option[0] > 0) return false;
        A = frame_from(p + MBSRI_A);
        B = frame_from(p + MBSRI_B);
    } else {
        if (!is_planar(joint) || joint->option[FREE] | joint->option[DRIVEN]) return false;
        A = mbsr_frame_rotated((const double[3]){p[A_X], p[A_Y], 0.0}, z, p[A_ANGLE]);
        B = mbsr_frame_rotated((const double[3]){p[B_X], p[B_Y], 0.0}, z, p[B_ANGLE]);
        stand->angle = p[A_ANGLE] - p[B_ANGLE];
    }
    const mbsr_frame back = mbsr_frame_inverse(&B);
    stand->frame = mbsr_frame_product(&A, &back);
    return true;
}
