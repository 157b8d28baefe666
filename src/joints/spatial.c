/* Joints in space: constructors, validation, tables. chain.c moves them.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "algebra/frames.h"
#include "algebra/space3.h"
#include "base/error.h"
#include "joints/chain.h"
#include "tables/table.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>

/* ---- what is refused ---- */

static int refuse_joint(char text[MBSR_TEXT_SIZE], int status, const char *format, int number,
                        double value)
{
    mbsri_print(text, MBSR_TEXT_SIZE, format, number, value);
    return status;
}

static const char *parameter(int k)
{
    static const char *const names[] = {
        " (frame A, x[0])",    " (frame A, x[1])",    " (frame A, x[2])",    " (frame A, R[0])",
        " (frame A, R[1])",    " (frame A, R[2])",    " (frame A, R[3])",    " (frame A, R[4])",
        " (frame A, R[5])",    " (frame A, R[6])",    " (frame A, R[7])",    " (frame A, R[8])",
        " (frame B, x[0])",    " (frame B, x[1])",    " (frame B, x[2])",    " (frame B, R[0])",
        " (frame B, R[1])",    " (frame B, R[2])",    " (frame B, R[3])",    " (frame B, R[4])",
        " (frame B, R[5])",    " (frame B, R[6])",    " (frame B, R[7])",    " (frame B, R[8])",
        " (axis direction x)", " (axis direction y)", " (axis direction z)", " (pitch)"};
    return names[k < MBSRI_AXES ? k : MBSRI_AXES + (k - MBSRI_AXES) % MBSRI_AXIS_SIZE];
}

static int check_frames(const mbsr_joint *joint, char text[MBSR_TEXT_SIZE])
{
    for (int k = 0; k < 2; ++k) {
        const double defect = mbsri_frame_defect(joint->param + (k ? MBSRI_B : MBSRI_A) + 3);
        if (defect <= 1e-9) continue;
        if (isinf(defect)) {
            mbsri_print(text, MBSR_TEXT_SIZE,
                        "the axes of frame %c are left-handed or lie in a plane", k ? 'B' : 'A');
        } else {
            mbsri_print(text, MBSR_TEXT_SIZE,
                        "the axes of frame %c are not orthonormal: R^T R differs from 1 by %g",
                        k ? 'B' : 'A', defect);
        }
        return MBSR_ERR_VALUE;
    }
    return MBSR_OK;
}

static bool parallel(const double a[3], const double b[3])
{
    double c[3];
    mbsri_cross3(a, b, c);
    return mbsri_norm3(c) < 1e-6;
}

/* Directions of unit length, and no two equal axes in a row, which are one. */
static int check_axes(const mbsr_joint *joint, char text[MBSR_TEXT_SIZE])
{
    for (int k = 0; k < joint->option[0]; ++k) {
        const double *a = joint->param + MBSRI_AXES + MBSRI_AXIS_SIZE * k;
        const int kind = joint->option[1 + k] & MBSRI_STEP_KIND;
        if (kind == MBSRI_QUATERNION) continue;
        const double length = mbsri_norm3(a);
        if (!(fabs(length - 1.0) < 1e-9)) {
            return refuse_joint(text, MBSR_ERR_VALUE, "the direction of axis %d has length %g", k,
                                length);
        }
        if (kind != MBSRI_SCREW && a[3] != 0.0) {
            return refuse_joint(text, MBSR_ERR_VALUE, "axis %d is no screw, but its pitch is %g", k,
                                a[3]);
        }
        if (k > 0 && (joint->option[k] & MBSRI_STEP_KIND) == kind && kind != MBSRI_SCREW &&
            !((joint->option[k] | joint->option[1 + k]) & MBSRI_DRIVEN) &&
            parallel(a, a - MBSRI_AXIS_SIZE)) {
            return refuse_joint(text, MBSR_ERR_VALUE, "axis %d is parallel to the one before", k,
                                0.0);
        }
    }
    return MBSR_OK;
}

/* Three translations of a joint that promises a regular J span the space. */
static int check_translations(const mbsr_joint *joint, char text[MBSR_TEXT_SIZE])
{
    const double *a = joint->param + MBSRI_AXES;
    double c[3];
    if (joint->n < 3 || (joint->option[3] & MBSRI_STEP_KIND) != MBSRI_TRANSLATION) return MBSR_OK;
    mbsri_cross3(a, a + MBSRI_AXIS_SIZE, c);
    if (fabs(mbsri_dot3(c, a + 2 * MBSRI_AXIS_SIZE)) > 1e-6) return MBSR_OK;
    return refuse_joint(text, MBSR_ERR_VALUE,
                        "the directions of its first three axes lie in a plane", 0, 0.0);
}

static int check_predecessor(const mbsr_joint *joint, mbsr_space pred_space, int pred_d,
                             char text[MBSR_TEXT_SIZE])
{
    (void)joint, (void)pred_d;
    if (pred_space == MBSR_SPACE_FLEXIBLE)
        return refuse_joint(text, MBSR_ERR_SPACE,
                            "the predecessor is FLEXIBLE; put the joint on a marker of it", 0, 0.0);
    if (pred_space != MBSR_SPACE_GENERAL) return MBSR_OK;
    return refuse_joint(
        text, MBSR_ERR_SPACE,
        "the predecessor is in GENERAL space; it must be SPATIAL, PLANAR, POINT or a "
        "root",
        0, 0.0);
}

static int check_fields(const mbsr_joint *joint, char text[MBSR_TEXT_SIZE]);

/* ---- tables: they differ in the name, in what is promised of J, and in q' ---- */

#define CHAIN(promise, label)                                                                      \
    .version = MBSR_JOINT_TABLE_VERSION, .flags = MBSR_JOINT_UNIT_K | (promise), .name = (label),  \
    .position = mbsri_chain_position, .jacobians = mbsri_chain_jacobians,                          \
    .bias = mbsri_chain_bias, .rates = mbsri_chain_rates, .check = check_predecessor,              \
    .check_fields = check_fields, .parameter = parameter, .tangent = mbsri_chain_tangent,          \
    .rate_tangent = mbsri_chain_rate_tangent
#define QUATERNION                                                                                 \
    .coordinate_rates = mbsri_chain_coordinate_rates, .normalise = mbsri_chain_normalise

static const mbsr_joint_table weld = {CHAIN(MBSR_JOINT_REGULAR_J, "weld")};
static const mbsr_joint_table revolute = {CHAIN(MBSR_JOINT_REGULAR_J, "revolute")};
static const mbsr_joint_table prismatic = {CHAIN(MBSR_JOINT_REGULAR_J, "prismatic")};
static const mbsr_joint_table screw = {CHAIN(MBSR_JOINT_REGULAR_J, "screw")};
static const mbsr_joint_table cylindrical = {CHAIN(MBSR_JOINT_REGULAR_J, "cylindrical")};
static const mbsr_joint_table universal = {CHAIN(MBSR_JOINT_REGULAR_J, "universal")};
static const mbsr_joint_table in_plane = {CHAIN(MBSR_JOINT_REGULAR_J, "in-plane")};
static const mbsr_joint_table translational = {CHAIN(MBSR_JOINT_REGULAR_J, "translational")};
static const mbsr_joint_table compound = {CHAIN(0u, "compound")};
static const mbsr_joint_table spherical = {CHAIN(MBSR_JOINT_REGULAR_J, "spherical"), QUATERNION};
static const mbsr_joint_table free_joint = {CHAIN(MBSR_JOINT_REGULAR_J, "free"), QUATERNION};

/* ---- the shape of each joint ---- */

/* The code of a step in option, see chain.h. */
#define STEP(kind, place) ((int)(kind) | (place) << MBSRI_PLACE_SHIFT)

/* Stands for the number of axes where they were given as NULL. */
enum { AXES_NULL = INT_MIN };

/* The steps of a joint by its constructor; those of a compound joint are told by their own. */
typedef struct shape {
    const mbsr_joint_table *table;
    int steps, code[4];
} shape;

static const shape shapes[] = {
    {&weld, 0, {0}},
    {&revolute, 1, {STEP(MBSRI_ROTATION, 0)}},
    {&prismatic, 1, {STEP(MBSRI_TRANSLATION, 0)}},
    {&screw, 1, {STEP(MBSRI_SCREW, 0)}},
    {&cylindrical, 2, {STEP(MBSRI_ROTATION, 0), STEP(MBSRI_TRANSLATION, 1)}},
    {&universal, 2, {STEP(MBSRI_ROTATION, 0), STEP(MBSRI_ROTATION, 1)}},
    {&in_plane,
     3,
     {STEP(MBSRI_TRANSLATION, 0), STEP(MBSRI_TRANSLATION, 1), STEP(MBSRI_ROTATION, 2)}},
    {&translational,
     3,
     {STEP(MBSRI_TRANSLATION, 0), STEP(MBSRI_TRANSLATION, 1), STEP(MBSRI_TRANSLATION, 2)}},
    {&spherical, 1, {STEP(MBSRI_QUATERNION, 0)}},
    {&free_joint,
     4,
     {STEP(MBSRI_TRANSLATION, 3), STEP(MBSRI_TRANSLATION, 4), STEP(MBSRI_TRANSLATION, 5),
      STEP(MBSRI_QUATERNION, 0)}}};

static int changed(char text[MBSR_TEXT_SIZE], const char *field, int k, int value, int right)
{
    char index[16] = "";
    if (k >= 0) mbsri_print(index, sizeof index, "[%d]", k);
    mbsri_print(text, MBSR_TEXT_SIZE, "%s%s is %d, must be %d as the constructor made it", field,
                index, value, right);
    return MBSR_ERR_VALUE;
}

/* Of a compound joint and of a table of the caller's that uses these functions: coordinates are
 * counted as in chain.h. */
static int check_any_steps(const mbsr_joint *joint, int *free, char text[MBSR_TEXT_SIZE])
{
    int driven = 0, quaternions = 0;
    for (int k = 0; k < joint->option[0]; ++k)
        quaternions += (joint->option[1 + k] & MBSRI_STEP_KIND) == MBSRI_QUATERNION;
    *free = 3 * quaternions;
    for (int k = 0; k < joint->option[0]; ++k) {
        const int code = joint->option[1 + k];
        const int kind = code & MBSRI_STEP_KIND, is_driven = code & MBSRI_DRIVEN;
        const bool turns = kind == MBSRI_QUATERNION;
        if (kind < MBSRI_ROTATION || kind > MBSRI_QUATERNION ||
            (turns && (quaternions > 1 || joint->table == &compound))) {
            return refuse_joint(text, MBSR_ERR_VALUE,
                                "the kind of axis %d is none of mbsr_axis_kind", k, 0.0);
        }
        const int right =
            turns ? STEP(kind, 0) : STEP(kind | is_driven, is_driven ? driven : *free);
        if (code != right) return changed(text, "option", 1 + k, code, right);
        driven += is_driven != 0;
        *free += is_driven == 0 && !turns;
    }
    if (joint->motion == mbsr_table_motion && mbsri_table_columns(joint->user) != driven)
        return mbsri_table_refuse(joint->user, driven, text);
    if (driven == 0 || joint->motion) return MBSR_OK;
    return refuse_joint(text, MBSR_ERR_VALUE, "%d of its axes are driven, but motion is NULL",
                        driven, 0.0);
}

/* The shape of a table by which a constructor made the joint; NULL: another one. */
static const shape *find_shape(const mbsr_joint_table *table)
{
    for (size_t k = 0; k < sizeof shapes / sizeof *shapes; ++k) {
        if (shapes[k].table == table) return shapes + k;
    }
    return NULL;
}

static int check_steps(const mbsr_joint *joint, int *free, char text[MBSR_TEXT_SIZE])
{
    const shape *s = find_shape(joint->table);
    if (!s) return check_any_steps(joint, free, text);
    *free = 0;
    if (joint->option[0] != s->steps) return changed(text, "option", 0, joint->option[0], s->steps);
    for (int k = 0; k < s->steps; ++k) {
        const int code = joint->option[1 + k];
        if (code != s->code[k]) return changed(text, "option", 1 + k, code, s->code[k]);
        *free += code == STEP(MBSRI_QUATERNION, 0) ? 3 : 1;
    }
    return MBSR_OK;
}

static int check_fields(const mbsr_joint *joint, char text[MBSR_TEXT_SIZE])
{
    const int steps = joint->option[0];
    if (steps == AXES_NULL) return refuse_joint(text, MBSR_ERR_NULL, "axes is NULL", 0, 0.0);
    if (steps < 0 || steps > MBSRI_MAX_STEPS)
        return refuse_joint(text, MBSR_ERR_VALUE, "it has %d axes, which must be 0 .. 6", steps,
                            0.0);
    int free = 0, status = check_steps(joint, &free, text);
    if (status) return status;
    for (int k = 1 + steps; k < MBSR_JOINT_OPTIONS; ++k) {
        if (joint->option[k] != 0) return changed(text, "option", k, joint->option[k], 0);
    }
    int quaternions = 0;
    for (int k = 0; k < steps; ++k)
        quaternions += (joint->option[1 + k] & MBSRI_STEP_KIND) == MBSRI_QUATERNION;
    const int nq = free + quaternions, params = MBSRI_AXES + MBSRI_AXIS_SIZE * steps;
    if (joint->space != MBSR_SPACE_SPATIAL)
        return changed(text, "space", -1, (int)joint->space, MBSR_SPACE_SPATIAL);
    if (joint->n != free) return changed(text, "n", -1, joint->n, free);
    if (joint->nq != nq) return changed(text, "nq", -1, joint->nq, nq);
    if (quaternions == 0 && (joint->table->coordinate_rates == mbsri_chain_coordinate_rates ||
                             joint->table->normalise == mbsri_chain_normalise)) {
        return refuse_joint(text, MBSR_ERR_VALUE, "its table is of a joint with a quaternion", 0,
                            0.0);
    }
    if (joint->params != params) return changed(text, "params", -1, joint->params, params);
    status = check_frames(joint, text);
    if (!status) status = check_axes(joint, text);
    if (!status && joint->table->flags & MBSR_JOINT_REGULAR_J)
        status = check_translations(joint, text);
    return status;
}

/* ---- constructors ---- */

static const double e_x[3] = {1.0, 0.0, 0.0}, e_y[3] = {0.0, 1.0, 0.0}, e_z[3] = {0.0, 0.0, 1.0};

static mbsr_joint spatial_joint(const mbsr_joint_table *table, const mbsr_frame *A,
                                const mbsr_frame *B)
{
    mbsr_joint joint = {.table = table,
                        .space = MBSR_SPACE_SPATIAL,
                        .d = 6,
                        .np = MBSR_POSE_SIZE,
                        .params = MBSRI_AXES};
    mbsri_store_frame(A, joint.param + MBSRI_A);
    mbsri_store_frame(B, joint.param + MBSRI_B);
    return joint;
}

/* One more step; a direction of length zero, as NULL is, is kept for the check to find. `place` is
 * that of its coordinate. */
static void add_step(mbsr_joint *joint, int kind, const double direction[3], double pitch,
                     bool driven, int place)
{
    const int step = joint->option[0]++;
    double *axis = joint->param + MBSRI_AXES + MBSRI_AXIS_SIZE * step;
    if (direction) mbsri_direction3(direction, axis);
    axis[3] = pitch;
    joint->params += MBSRI_AXIS_SIZE;
    joint->option[1 + step] = kind | (driven ? MBSRI_DRIVEN : 0) | place << MBSRI_PLACE_SHIFT;
    if (driven) return;
    joint->n += kind == MBSRI_QUATERNION ? 3 : 1;
    joint->nq += kind == MBSRI_QUATERNION ? 4 : 1;
}

static mbsr_joint one_axis(const mbsr_joint_table *table, const mbsr_frame *A, const mbsr_frame *B,
                           int kind, const double axis[3], double pitch)
{
    mbsr_joint joint = spatial_joint(table, A, B);
    add_step(&joint, kind, axis, pitch, false, 0);
    return joint;
}

static mbsr_joint two_axes(const mbsr_joint_table *table, const mbsr_frame *A, const mbsr_frame *B,
                           const double first[3], int second_kind, const double second[3])
{
    mbsr_joint joint = one_axis(table, A, B, MBSRI_ROTATION, first, 0.0);
    add_step(&joint, second_kind, second, 0.0, false, 1);
    return joint;
}

mbsr_joint mbsr_joint_compound(const mbsr_frame *A, const mbsr_frame *B, int count,
                               const mbsr_axis *axes, mbsr_motion_fn motion, void *user)
{
    mbsr_joint joint = spatial_joint(&compound, A, B);
    int driven = 0;
    if (count < 0 || count > MBSRI_MAX_STEPS) {
        joint.option[0] = count != AXES_NULL ? count : -1;
        return joint;
    }
    if (count > 0 && !axes) {
        joint.option[0] = AXES_NULL;
        return joint;
    }
    for (int k = 0; k < count; ++k) {
        const bool is_driven = axes[k].driven != 0;
        const int kind = axes[k].kind >= MBSR_AXIS_ROTATION && axes[k].kind <= MBSR_AXIS_SCREW
                             ? (int)axes[k].kind
                             : 0;
        add_step(&joint, kind, axes[k].direction, axes[k].pitch, is_driven,
                 is_driven ? driven++ : joint.n);
    }
    joint.motion = driven > 0 ? motion : NULL;
    joint.user = user;
    return joint;
}

mbsr_joint mbsr_joint_weld(const mbsr_frame *A, const mbsr_frame *B)
{
    return spatial_joint(&weld, A, B);
}

mbsr_joint mbsr_joint_revolute(const mbsr_frame *A, const mbsr_frame *B, const double axis[3])
{
    return one_axis(&revolute, A, B, MBSRI_ROTATION, axis, 0.0);
}

mbsr_joint mbsr_joint_prismatic(const mbsr_frame *A, const mbsr_frame *B, const double axis[3])
{
    return one_axis(&prismatic, A, B, MBSRI_TRANSLATION, axis, 0.0);
}

mbsr_joint mbsr_joint_screw(const mbsr_frame *A, const mbsr_frame *B, const double axis[3],
                            double pitch)
{
    return one_axis(&screw, A, B, MBSRI_SCREW, axis, pitch);
}

mbsr_joint mbsr_joint_cylindrical(const mbsr_frame *A, const mbsr_frame *B, const double axis[3])
{
    return two_axes(&cylindrical, A, B, axis, MBSRI_TRANSLATION, axis);
}

mbsr_joint mbsr_joint_universal(const mbsr_frame *A, const mbsr_frame *B, const double first[3],
                                const double second[3])
{
    return two_axes(&universal, A, B, first, MBSRI_ROTATION, second);
}

static void add_translations(mbsr_joint *joint, int count, int place)
{
    const double *const axes[3] = {e_x, e_y, e_z};
    for (int k = 0; k < count; ++k)
        add_step(joint, MBSRI_TRANSLATION, axes[k], 0.0, false, place + k);
}

mbsr_joint mbsr_joint_in_plane(const mbsr_frame *A, const mbsr_frame *B)
{
    mbsr_joint joint = spatial_joint(&in_plane, A, B);
    add_translations(&joint, 2, 0);
    add_step(&joint, MBSRI_ROTATION, e_z, 0.0, false, 2);
    return joint;
}

mbsr_joint mbsr_joint_translational(const mbsr_frame *A, const mbsr_frame *B)
{
    mbsr_joint joint = spatial_joint(&translational, A, B);
    add_translations(&joint, 3, 0);
    return joint;
}

mbsr_joint mbsr_joint_spherical(const mbsr_frame *A, const mbsr_frame *B)
{
    return one_axis(&spherical, A, B, MBSRI_QUATERNION, e_z, 0.0);
}

mbsr_joint mbsr_joint_free(const mbsr_frame *A, const mbsr_frame *B)
{
    mbsr_joint joint = spatial_joint(&free_joint, A, B);
    add_translations(&joint, 3, 3);
    add_step(&joint, MBSRI_QUATERNION, e_z, 0.0, false, 0);
    return joint;
}
