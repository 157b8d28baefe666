/* Joints of flexible bodies: the mount that holds one at a marker, and the marker as a body of its
 * own.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * With the marker's twist V_k = B V (flexible/marker.h), its predecessor's or its own V = (omega,
 * v, s'),
 *
 *   marker   0 = V_i - B V_pi                                  H = -B,  kII = -B' V_pi
 *   mount    0 = V_i - X^-1 (V_pi - (G Psi, L Phi) u),  X^-1 = [1 0; [a]x 1];   0 = s' - u
 *
 * The mount's pose follows from that of the predecessor, which is the marker's:
 * R = R_pi E^T, r = r_pi - a, E the marker's axes in the body. */
#include "algebra/dense.h"
#include "algebra/space3.h"
#include "base/error.h"
#include "flexible/marker.h"
#include "joints/flexible.h"

#include <stdbool.h>

enum { MODAL = MBSR_POSE_SIZE }; /* where s stands in the pose */

static const double unit[9] = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0};

/* What turns R into R + dR = R + [x]x R. */
static void small_turn(const double R[9], const double dR[9], double x[3])
{
    double W[9];
    mbsri_multiply_transposed3(dR, R, W);
    x[0] = 0.5 * (W[5] - W[7]);
    x[1] = 0.5 * (W[6] - W[2]);
    x[2] = 0.5 * (W[1] - W[3]);
}

/* dR = [x]x R */
static void cross_matrix_times(const double x[3], const double R[9], double dR[9])
{
    for (int k = 0; k < 9; k += 3) mbsri_cross3(x, R + k, dR + k);
}

/* A block [x]x, rows 3 .. 5 of the columns 0 .. 2 of H (d rows). */
static void fill_arm(int d, double sign, const double x[3], double *H)
{
    double X[9];
    mbsri_cross_matrix3(x, X);
    for (int j = 0; j < 3; ++j) {
        for (int k = 0; k < 3; ++k) H[d * j + 3 + k] = sign * X[3 * j + k];
    }
}

/* ---- the marker as a body ---- */

static void see_marker(const mbsr_joint_args *args, mbsri_flex_view *view)
{
    mbsri_flex_see(args->user, args->option[0], args->p_pred, args->p_pred + MODAL, view);
}

static void see_marker_rate(const mbsr_joint_args *args, mbsri_flex_view *view)
{
    see_marker(args, view);
    mbsri_flex_see_rate(view, args->V_pred, args->V_pred + 6);
}

static int marker_position(const mbsr_joint_args *args, double *p)
{
    mbsri_flex_view view;
    double E[9];
    see_marker(args, &view);
    mbsri_flex_axes(&view, E);
    mbsri_multiply3(args->p_pred, E, p + MBSR_POSE_R);
    for (int k = 0; k < 3; ++k) p[MBSR_POSE_X + k] = args->p_pred[MBSR_POSE_X + k] + view.at.a[k];
    return MBSR_OK;
}

/* a or a derivative of it. */
static const double *arm_or_derivative(const mbsri_flex_view *view, mbsri_flex_part part)
{
    const double *const a[] = {view->at.a, view->rate.a, view->change.a, view->rate_change.a};
    return a[part];
}

/* H = -B or a derivative of it. */
static void fill_B(const mbsri_flex_view *view, mbsri_flex_part part, double *H)
{
    for (int k = 0; k < 6; ++k) H[7 * k] = part == MBSRI_FLEX_AT ? -1.0 : 0.0;
    fill_arm(6, 1.0, arm_or_derivative(view, part), H);
    for (int k = 0; k < view->flex->n; ++k) {
        double *column = H + 6 * (6 + k);
        mbsri_flex_column(view, part, k, column, column + 3);
        for (int l = 0; l < 6; ++l) column[l] = -column[l];
    }
}

static int marker_jacobians(const mbsr_joint_args *args, double *K, double *H, double *J,
                            double *kI)
{
    mbsri_flex_view view;
    (void)K, (void)J, (void)kI;
    see_marker(args, &view);
    fill_B(&view, MBSRI_FLEX_AT, H);
    return MBSR_OK;
}

static int marker_bias(const mbsr_joint_args *args, double *kII)
{
    mbsri_flex_view view;
    see_marker_rate(args, &view);
    for (int k = 0; k < 6; ++k) kII[k] = -view.bias[k];
    return MBSR_OK;
}

static int marker_rates(const mbsr_joint_args *args, double *Kdot, double *Hdot, double *Jdot)
{
    mbsri_flex_view view;
    (void)Kdot, (void)Jdot;
    see_marker_rate(args, &view);
    fill_B(&view, MBSRI_FLEX_RATE, Hdot);
    return MBSR_OK;
}

static void change_marker(const mbsr_joint_args *args, const mbsr_joint_change *by,
                          mbsri_flex_view *view)
{
    double x[3];
    small_turn(args->p_pred, by->p_pred, x);
    mbsri_flex_see_change(view, x, by->p_pred + MODAL);
}

void mbsri_marker_see(const mbsr_joint_args *args, mbsri_flex_view *view)
{
    see_marker_rate(args, view);
}

void mbsri_marker_change(const mbsr_joint_args *args, const mbsr_joint_change *by,
                         mbsri_flex_view *view, double *dp, double *dH)
{
    double x[3];
    change_marker(args, by, view);
    mbsri_rotate3(view->at.G, view->dpsi, x);
    mbsri_add3(1.0, view->turn, x);
    cross_matrix_times(x, args->p + MBSR_POSE_R, dp + MBSR_POSE_R);
    for (int k = 0; k < 3; ++k)
        dp[MBSR_POSE_X + k] = by->p_pred[MBSR_POSE_X + k] + view->change.a[k];
    fill_B(view, MBSRI_FLEX_CHANGE, dH);
}

void mbsri_marker_rate_change(const mbsr_joint_args *args, const mbsr_joint_change *by,
                              mbsri_flex_view *view, double *dkII, double *dHdot)
{
    change_marker(args, by, view);
    mbsri_flex_see_rate_change(view, by->V_pred, by->V_pred + 6);
    for (int k = 0; k < 6; ++k) dkII[k] = -view->bias_change[k];
    fill_B(view, MBSRI_FLEX_RATE_CHANGE, dHdot);
}

static int marker_tangent(const mbsr_joint_args *args, const mbsr_joint_change *by, double *dp,
                          double *dK, double *dH, double *dJ, double *dkI)
{
    mbsri_flex_view view;
    (void)dK, (void)dJ, (void)dkI;
    see_marker(args, &view);
    mbsri_marker_change(args, by, &view, dp, dH);
    return MBSR_OK;
}

static int marker_rate_tangent(const mbsr_joint_args *args, const mbsr_joint_change *by,
                               double *dkII, double *dKdot, double *dHdot, double *dJdot,
                               double *dqdot)
{
    mbsri_flex_view view;
    (void)dKdot, (void)dJdot, (void)dqdot;
    see_marker_rate(args, &view);
    mbsri_marker_rate_change(args, by, &view, dkII, dHdot);
    return MBSR_OK;
}

/* ---- the mount ---- */

static void see_mount(const mbsr_joint_args *args, mbsri_flex_view *view)
{
    mbsri_flex_see(args->user, args->option[0], args->p + MBSR_POSE_R, args->q, view);
}

static void see_mount_rate(const mbsr_joint_args *args, mbsri_flex_view *view)
{
    see_mount(args, view);
    mbsri_flex_see_rate(view, args->V, args->u);
}

static int mount_position(const mbsr_joint_args *args, double *p)
{
    const bool rests = args->pred_space == MBSR_SPACE_FIXED;
    const double *R_pred = rests ? unit : args->p_pred + MBSR_POSE_R;
    mbsri_flex_view view;
    double E[9];
    mbsri_flex_see(args->user, args->option[0], unit, args->q, &view);
    mbsri_flex_axes(&view, E);
    mbsri_multiply_transposed3(R_pred, E, p + MBSR_POSE_R);
    mbsri_rotate3(p + MBSR_POSE_R, view.rho, view.at.a);
    for (int k = 0; k < 3; ++k)
        p[MBSR_POSE_X + k] = (rests ? 0.0 : args->p_pred[MBSR_POSE_X + k]) - view.at.a[k];
    mbsri_copy((size_t)args->nq, args->q, p + MODAL);
    return MBSR_OK;
}

/* H = -[X^-1; 0], nothing on the ground. */
static void fill_mount_H(const mbsr_joint_args *args, const double a[3], double one, double *H)
{
    if (args->pred_d == 0) return;
    for (int k = 0; k < 6; ++k) H[(args->d + 1) * k] = -one;
    fill_arm(args->d, -1.0, a, H);
}

static int mount_jacobians(const mbsr_joint_args *args, double *K, double *H, double *J, double *kI)
{
    mbsri_flex_view view;
    (void)K, (void)kI;
    see_mount(args, &view);
    fill_mount_H(args, view.at.a, 1.0, H);
    for (int k = 0; k < args->n; ++k) { /* (G Psi, L Phi + a x G Psi, -1) */
        double *column = J + args->d * k;
        mbsri_flex_column(&view, MBSRI_FLEX_AT, k, column, column + 3);
        mbsri_add_cross3(view.at.a, column, column + 3);
        column[6 + k] = -1.0;
    }
    return MBSR_OK;
}

static int mount_bias(const mbsr_joint_args *args, double *kII)
{
    mbsri_flex_view view;
    see_mount_rate(args, &view);
    mbsri_copy(6, view.bias, kII);
    mbsri_add_cross3(view.at.a, kII, kII + 3);
    return MBSR_OK;
}

/* Column k of a derivative of J. */
static void fill_mount_dJ(const mbsri_flex_view *view, mbsri_flex_part derivative, int k,
                          double *column)
{
    double angular[3], linear[3];
    mbsri_flex_column(view, derivative, k, column, column + 3);
    mbsri_add_cross3(view->at.a, column, column + 3);
    mbsri_flex_column(view, MBSRI_FLEX_AT, k, angular, linear);
    mbsri_add_cross3(arm_or_derivative(view, derivative), angular, column + 3);
}

static int mount_rates(const mbsr_joint_args *args, double *Kdot, double *Hdot, double *Jdot)
{
    mbsri_flex_view view;
    (void)Kdot;
    see_mount_rate(args, &view);
    fill_mount_H(args, view.rate.a, 0.0, Hdot);
    for (int k = 0; k < args->n && !view.rests; ++k)
        fill_mount_dJ(&view, MBSRI_FLEX_RATE, k, Jdot + args->d * k);
    return MBSR_OK;
}

/* The body's own turn is the predecessor's less that of the marker in it, G dpsi. */
static void change_mount(const mbsr_joint_args *args, const mbsr_joint_change *by,
                         mbsri_flex_view *view)
{
    double x[3] = {0.0, 0.0, 0.0}, own[3];
    if (args->pred_space != MBSR_SPACE_FIXED)
        small_turn(args->p_pred + MBSR_POSE_R, by->p_pred + MBSR_POSE_R, x);
    mbsri_flex_turn(view, by->q, own);
    mbsri_add3(-1.0, own, x);
    mbsri_flex_see_change(view, x, by->q);
}

static int mount_tangent(const mbsr_joint_args *args, const mbsr_joint_change *by, double *dp,
                         double *dK, double *dH, double *dJ, double *dkI)
{
    mbsri_flex_view view;
    (void)dK, (void)dkI;
    see_mount(args, &view);
    change_mount(args, by, &view);
    cross_matrix_times(view.turn, args->p + MBSR_POSE_R, dp + MBSR_POSE_R);
    for (int k = 0; k < 3; ++k) {
        const bool rests = args->pred_space == MBSR_SPACE_FIXED;
        dp[MBSR_POSE_X + k] = (rests ? 0.0 : by->p_pred[MBSR_POSE_X + k]) - view.change.a[k];
    }
    mbsri_copy((size_t)args->nq, by->q, dp + MODAL);
    fill_mount_H(args, view.change.a, 0.0, dH);
    for (int k = 0; k < args->n && !view.rests; ++k)
        fill_mount_dJ(&view, MBSRI_FLEX_CHANGE, k, dJ + args->d * k);
    return MBSR_OK;
}

/* Second derivatives of (G Psi, L Phi + a x G Psi). */
static void fill_mount_ddJ(const mbsri_flex_view *view, int k, double *column)
{
    double angular[3], linear[3];
    fill_mount_dJ(view, MBSRI_FLEX_RATE_CHANGE, k, column);
    mbsri_flex_column(view, MBSRI_FLEX_RATE, k, angular, linear);
    mbsri_add_cross3(view->change.a, angular, column + 3);
    mbsri_flex_column(view, MBSRI_FLEX_CHANGE, k, angular, linear);
    mbsri_add_cross3(view->rate.a, angular, column + 3);
}

static int mount_rate_tangent(const mbsr_joint_args *args, const mbsr_joint_change *by,
                              double *dkII, double *dKdot, double *dHdot, double *dJdot,
                              double *dqdot)
{
    mbsri_flex_view view;
    (void)dKdot, (void)dqdot;
    see_mount_rate(args, &view);
    change_mount(args, by, &view);
    mbsri_flex_see_rate_change(&view, by->V, by->u);
    mbsri_copy(6, view.bias_change, dkII);
    mbsri_add_cross3(view.at.a, view.bias_change, dkII + 3);
    mbsri_add_cross3(view.change.a, view.bias, dkII + 3);
    fill_mount_H(args, view.rate_change.a, 0.0, dHdot);
    for (int k = 0; k < args->n && !view.rests; ++k) fill_mount_ddJ(&view, k, dJdot + args->d * k);
    return MBSR_OK;
}

/* ---- tables ---- */

static int check_fields(const mbsr_joint *joint, char text[MBSR_TEXT_SIZE])
{
    const mbsr_flex *flex = joint->user;
    if (!flex) {
        mbsri_print(text, MBSR_TEXT_SIZE, "flex is NULL");
        return MBSR_ERR_NULL;
    }
    const bool mount = joint->space == MBSR_SPACE_FLEXIBLE;
    const int n = mount ? flex->n : 0, d = 6 + n;
    if (joint->option[0] < 0 || joint->option[0] >= flex->markers) {
        mbsri_print(text, MBSR_TEXT_SIZE, "marker is %d, must be 0 .. %d", joint->option[0],
                    flex->markers - 1);
        return MBSR_ERR_ID;
    }
    if (joint->d == d && joint->n == n && joint->nq == n && joint->params == 0 && !joint->motion)
        return MBSR_OK;
    mbsri_print(text, MBSR_TEXT_SIZE, "d, n, nq, params or motion have been changed");
    return MBSR_ERR_VALUE;
}

static int check_marker(const mbsr_joint *joint, mbsr_space pred_space, int pred_d,
                        char text[MBSR_TEXT_SIZE])
{
    const mbsr_flex *flex = joint->user;
    if (pred_space == MBSR_SPACE_FLEXIBLE && pred_d == 6 + flex->n) return MBSR_OK;
    mbsri_print(text, MBSR_TEXT_SIZE,
                "the predecessor is not a flexible body with the marker's %d modes", flex->n);
    return MBSR_ERR_SPACE;
}

static int check_mount(const mbsr_joint *joint, mbsr_space pred_space, int pred_d,
                       char text[MBSR_TEXT_SIZE])
{
    (void)joint, (void)pred_d;
    if (pred_space == MBSR_SPACE_SPATIAL || pred_space == MBSR_SPACE_FIXED) return MBSR_OK;
    mbsri_print(text, MBSR_TEXT_SIZE,
                "the predecessor must be SPATIAL or the root at rest; on a flexible body, "
                "add a marker of it first");
    return MBSR_ERR_SPACE;
}

static const mbsr_joint_table marker_table = {
    .version = MBSR_JOINT_TABLE_VERSION,
    .flags = MBSR_JOINT_UNIT_K | MBSR_JOINT_REGULAR_J,
    .name = "marker",
    .position = marker_position,
    .jacobians = marker_jacobians,
    .bias = marker_bias,
    .rates = marker_rates,
    .tangent = marker_tangent,
    .rate_tangent = marker_rate_tangent,
    .check = check_marker,
    .check_fields = check_fields,
};

static const mbsr_joint_table mount_table = {
    .version = MBSR_JOINT_TABLE_VERSION,
    .flags = MBSR_JOINT_UNIT_K | MBSR_JOINT_REGULAR_J,
    .name = "mount",
    .position = mount_position,
    .jacobians = mount_jacobians,
    .bias = mount_bias,
    .rates = mount_rates,
    .tangent = mount_tangent,
    .rate_tangent = mount_rate_tangent,
    .check = check_mount,
    .check_fields = check_fields,
};

mbsr_joint mbsr_joint_mount(const mbsr_flex *flex, int marker)
{
    const int n = flex ? flex->n : 0;
    return (mbsr_joint){.table = &mount_table,
                        .space = MBSR_SPACE_FLEXIBLE,
                        .d = 6 + n,
                        .np = MBSR_POSE_SIZE + n,
                        .n = n,
                        .nq = n,
                        .option = {marker},
                        .user = (void *)flex};
}

mbsr_joint mbsr_joint_marker(const mbsr_flex *flex, int marker)
{
    return (mbsr_joint){.table = &marker_table,
                        .space = MBSR_SPACE_SPATIAL,
                        .d = 6,
                        .np = MBSR_POSE_SIZE,
                        .option = {marker},
                        .user = (void *)flex};
}

const mbsr_flex *mbsri_marker_of(const mbsr_joint_table *table, const void *user)
{
    return table == &marker_table ? user : NULL;
}

bool mbsri_mount_rests(const mbsr_flex *flex, int marker)
{
    return flex->rests[marker];
}

const mbsr_flex *mbsri_mount_of(const mbsr_joint_table *table, const void *user)
{
    return table == &mount_table ? user : NULL;
}
