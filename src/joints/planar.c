/* Planar joints: every stock joint between bodies in the plane, as one joint with free, driven and
 * locked coordinates.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Frame A sits on the predecessor at a with angle alpha, frame B on the body at b with angle beta.
 * s = (sx, sy, phi) is the pose of B in A. With R(x) the rotation by x and r, theta the pose of a
 * body:
 *
 *   theta_i = theta_pi + alpha + phi - beta
 *   r_i     = r_pi + R(theta_pi) a + R(theta_pi + alpha) (sx, sy) - R(theta_i) b           (7)
 *
 * so k = p_i - (right-hand side) and K = I. A POINT has no angle, and no frame B: the second line
 * with b = 0. A predecessor without angle (POINT, or a root at rest) counts as theta_pi = 0, one at
 * rest also as r_pi = 0.
 *
 * Derivatives along `by`: the change dw of the struct w below, and of each function the same lines
 * differentiated. */
#include "joints/planar.h"

#include "base/error.h"
#include "tables/table.h"

#include <math.h>
#include <stdlib.h>

enum { A_X, A_Y, A_ANGLE, B_X, B_Y, B_ANGLE, PARAMS };
enum { FREE, DRIVEN };

/* Everything the four functions need, computed anew in each: a few products beside two to six
 * trigonometric functions, as many as the frames ask for. */
typedef struct planar {
    double s[3], sdot[3], sddot[3]; /* relative pose and its rates; rates only where asked for */
    double omega_pred;              /* angular velocity of the predecessor */
    double ex[2];                   /* A's x axis in the world; its y axis is (-ex[1], ex[0]) */
    double arm[2];                  /* from r_pi to the origin of B */
    double b[2];                    /* R(theta_i) b */
    double theta;                   /* theta_i */
} planar;

static bool predecessor_turns(const mbsr_joint_args *args)
{
    return args->pred_space == MBSR_SPACE_PLANAR;
}

/* The relative coordinates: free ones from q (and u), driven ones from the motion, the others
 * zero. */
static int relative(const mbsr_joint_args *args, planar *w)
{
    double value[3] = {0.0}, rate[3] = {0.0}, acceleration[3] = {0.0};
    if (args->option[DRIVEN]) {
        const int status = args->motion(args->user, args->t, value, rate, acceleration);
        if (status) return status;
    }
    for (int k = 0, free = 0, driven = 0; k < 3; ++k) {
        w->s[k] = w->sdot[k] = w->sddot[k] = 0.0;
        if (args->option[FREE] & (1 << k)) {
            w->s[k] = args->q[free];
            w->sdot[k] = args->u ? args->u[free] : 0.0;
            ++free;
        } else if (args->option[DRIVEN] & (1 << k)) {
            w->s[k] = value[driven];
            w->sdot[k] = rate[driven];
            w->sddot[k] = acceleration[driven];
            ++driven;
        }
    }
    return MBSR_OK;
}

static int prepare_planar(const mbsr_joint_args *args, planar *w)
{
    const double *param = args->param;
    const int status = relative(args, w);
    if (status) return status;
    const double theta_pred = predecessor_turns(args) ? args->p_pred[2] : 0.0;
    const double angle = theta_pred + param[A_ANGLE];
    w->omega_pred = predecessor_turns(args) && args->V_pred ? args->V_pred[2] : 0.0;
    const double cosine = cos(theta_pred), sine = sin(theta_pred);
    const bool turned = angle != theta_pred;
    w->ex[0] = turned ? cos(angle) : cosine;
    w->ex[1] = turned ? sin(angle) : sine;
    w->arm[0] = cosine * param[A_X] - sine * param[A_Y] + w->ex[0] * w->s[0] - w->ex[1] * w->s[1];
    w->arm[1] = sine * param[A_X] + cosine * param[A_Y] + w->ex[1] * w->s[0] + w->ex[0] * w->s[1];
    w->theta = angle + w->s[2] - param[B_ANGLE];
    w->b[0] = w->b[1] = 0.0;
    if (param[B_X] == 0.0 && param[B_Y] == 0.0) return MBSR_OK;
    const double cosine_i = cos(w->theta), sine_i = sin(w->theta);
    w->b[0] = cosine_i * param[B_X] - sine_i * param[B_Y];
    w->b[1] = sine_i * param[B_X] + cosine_i * param[B_Y];
    return MBSR_OK;
}

/* The change of w along `by`, field by field; s'', the motion's, stays and is not written. */
static void change(const mbsr_joint_args *args, const mbsr_joint_change *by, const planar *w,
                   planar *dw)
{
    for (int k = 0, free = 0; k < 3; ++k) {
        const bool is_free = (args->option[FREE] & (1 << k)) != 0;
        dw->s[k] = is_free ? by->q[free] : 0.0;
        dw->sdot[k] = is_free && by->u ? by->u[free] : 0.0;
        free += is_free;
    }
    const double turn = predecessor_turns(args) ? by->p_pred[2] : 0.0;
    dw->omega_pred = predecessor_turns(args) && by->V_pred ? by->V_pred[2] : 0.0;
    dw->ex[0] = -turn * w->ex[1];
    dw->ex[1] = turn * w->ex[0];
    /* the arm turns with the predecessor, and B slides along the axes of A */
    dw->arm[0] = -turn * w->arm[1] + w->ex[0] * dw->s[0] - w->ex[1] * dw->s[1];
    dw->arm[1] = turn * w->arm[0] + w->ex[1] * dw->s[0] + w->ex[0] * dw->s[1];
    dw->theta = turn + dw->s[2];
    dw->b[0] = -dw->theta * w->b[1];
    dw->b[1] = dw->theta * w->b[0];
}

/* Column of -dk/ds for relative coordinate k: the velocity of the body for unit rate. */
static void direction(const planar *w, int d, int k, double *column)
{
    switch (k) {
    case 0: column[0] = w->ex[0], column[1] = w->ex[1]; break;
    case 1: column[0] = -w->ex[1], column[1] = w->ex[0]; break;
    default: column[0] = w->b[1], column[1] = -w->b[0]; break;
    }
    if (d == 3) column[2] = k == 2 ? 1.0 : 0.0;
}

/* Its change: the first two entries are linear in w, the third is constant. */
static void change_direction(const planar *dw, int k, double *column)
{
    direction(dw, 2, k, column);
}

static int position(const mbsr_joint_args *args, double *p)
{
    planar w;
    const int status = prepare_planar(args, &w);
    if (status) return status;
    const bool moves = args->pred_space != MBSR_SPACE_FIXED;
    for (int k = 0; k < 2; ++k) p[k] = (moves ? args->p_pred[k] : 0.0) + w.arm[k] - w.b[k];
    if (args->d == 3) p[2] = w.theta;
    return MBSR_OK;
}

/* H = -[I, e_z x (r_i - r_pi); 0, 1], J and kI from the columns of `direction`. */
static int jacobians(const mbsr_joint_args *args, double *K, double *H, double *J, double *kI)
{
    (void)K;
    planar w;
    const int status = prepare_planar(args, &w), d = args->d;
    if (status) return status;
    if (args->pred_space != MBSR_SPACE_FIXED) {
        H[0] = H[d + 1] = -1.0;
        if (predecessor_turns(args)) {
            H[2 * d] = w.arm[1] - w.b[1];
            H[2 * d + 1] = -(w.arm[0] - w.b[0]);
            if (d == 3) H[8] = -1.0;
        }
    }
    for (int k = 0, column = 0; k < 3; ++k) {
        double v[3] = {0.0};
        direction(&w, d, k, v);
        if (args->option[FREE] & (1 << k)) {
            for (int l = 0; l < d; ++l) J[column * d + l] = -v[l];
            ++column;
        } else if (args->option[DRIVEN] & (1 << k)) {
            for (int l = 0; l < d; ++l) kI[l] -= v[l] * w.sdot[k];
        }
    }
    return MBSR_OK;
}

/* += ex sx' + ey sy' */
static void add_slide(const double ex[2], const double sdot[2], double slide[2])
{
    slide[0] += ex[0] * sdot[0] - ex[1] * sdot[1];
    slide[1] += ex[1] * sdot[0] + ex[0] * sdot[1];
}

/* += rates of the first two entries of the columns of `direction`, with the angular velocities op
 * of the predecessor and oi of the body */
static void add_direction_rates(double op, double oi, const planar *w, double slope[3][2])
{
    slope[0][0] -= op * w->ex[1], slope[0][1] += op * w->ex[0];
    slope[1][0] -= op * w->ex[0], slope[1][1] -= op * w->ex[1];
    slope[2][0] += oi * w->b[0], slope[2][1] += oi * w->b[1];
}

/* -kII = centripetal and Coriolis terms of r_i'', plus the driven accelerations:
 *   -omega_pi^2 arm + 2 omega_pi e_z x (ex sx' + ey sy') + omega_i^2 R(theta_i) b */
static int bias(const mbsr_joint_args *args, double *kII)
{
    planar w;
    const int status = prepare_planar(args, &w), d = args->d;
    if (status) return status;
    const double op = w.omega_pred, oi = op + w.sdot[2];
    double slide[2] = {0.0};
    add_slide(w.ex, w.sdot, slide);
    kII[0] = op * op * w.arm[0] + 2.0 * op * slide[1] - oi * oi * w.b[0];
    kII[1] = op * op * w.arm[1] - 2.0 * op * slide[0] - oi * oi * w.b[1];
    for (int k = 0; k < 3; ++k) {
        if (!(args->option[DRIVEN] & (1 << k))) continue;
        double v[3] = {0.0};
        direction(&w, d, k, v);
        for (int l = 0; l < d; ++l) kII[l] -= v[l] * w.sddot[k];
    }
    return MBSR_OK;
}

static int rates(const mbsr_joint_args *args, double *Kdot, double *Hdot, double *Jdot)
{
    (void)Kdot;
    planar w;
    const int status = prepare_planar(args, &w), d = args->d;
    if (status) return status;
    const double op = w.omega_pred, oi = op + w.sdot[2];
    if (predecessor_turns(args)) {
        Hdot[2 * d] = args->V[1] - args->V_pred[1];
        Hdot[2 * d + 1] = -(args->V[0] - args->V_pred[0]);
    }
    double slope[3][2] = {{0.0}};
    add_direction_rates(op, oi, &w, slope);
    for (int k = 0, column = 0; k < 3; ++k) {
        if (!(args->option[FREE] & (1 << k))) continue;
        Jdot[column * d] = -slope[k][0];
        Jdot[column * d + 1] = -slope[k][1];
        ++column;
    }
    return MBSR_OK;
}

/* The changes of what `position` and `jacobians` write. */
static int tangent(const mbsr_joint_args *args, const mbsr_joint_change *by, double *dp, double *dK,
                   double *dH, double *dJ, double *dkI)
{
    (void)dK;
    planar w, dw;
    const int status = prepare_planar(args, &w), d = args->d;
    if (status) return status;
    change(args, by, &w, &dw);
    const bool moves = args->pred_space != MBSR_SPACE_FIXED;
    for (int k = 0; k < 2; ++k) dp[k] = (moves ? by->p_pred[k] : 0.0) + dw.arm[k] - dw.b[k];
    if (d == 3) dp[2] = dw.theta;
    if (predecessor_turns(args)) {
        dH[2 * d] = dw.arm[1] - dw.b[1];
        dH[2 * d + 1] = -(dw.arm[0] - dw.b[0]);
    }
    for (int k = 0, column = 0; k < 3; ++k) {
        double dv[2];
        change_direction(&dw, k, dv);
        if (args->option[FREE] & (1 << k)) {
            for (int l = 0; l < 2; ++l) dJ[column * d + l] = -dv[l];
            ++column;
        } else if (args->option[DRIVEN] & (1 << k)) {
            for (int l = 0; l < 2; ++l) dkI[l] -= dv[l] * w.sdot[k];
        }
    }
    return MBSR_OK;
}

/* The changes of what `bias` and `rates` write. */
static int rate_tangent(const mbsr_joint_args *args, const mbsr_joint_change *by, double *dkII,
                        double *dKdot, double *dHdot, double *dJdot, double *dqdot)
{
    (void)dKdot, (void)dqdot;
    planar w, dw;
    const int status = prepare_planar(args, &w), d = args->d;
    if (status) return status;
    change(args, by, &w, &dw);
    const double op = w.omega_pred, oi = op + w.sdot[2];
    const double dop = dw.omega_pred, doi = dop + dw.sdot[2];
    double slide[2] = {0.0}, dslide[2] = {0.0};
    add_slide(w.ex, w.sdot, slide);
    add_slide(dw.ex, w.sdot, dslide);
    add_slide(w.ex, dw.sdot, dslide);
    dkII[0] = 2.0 * op * dop * w.arm[0] + op * op * dw.arm[0];
    dkII[1] = 2.0 * op * dop * w.arm[1] + op * op * dw.arm[1];
    dkII[0] += 2.0 * (dop * slide[1] + op * dslide[1]);
    dkII[1] -= 2.0 * (dop * slide[0] + op * dslide[0]);
    dkII[0] -= 2.0 * oi * doi * w.b[0] + oi * oi * dw.b[0];
    dkII[1] -= 2.0 * oi * doi * w.b[1] + oi * oi * dw.b[1];
    if (predecessor_turns(args)) {
        dHdot[2 * d] = by->V[1] - by->V_pred[1];
        dHdot[2 * d + 1] = -(by->V[0] - by->V_pred[0]);
    }
    double dslope[3][2] = {{0.0}};
    add_direction_rates(dop, doi, &w, dslope);
    add_direction_rates(op, oi, &dw, dslope);
    for (int k = 0, column = 0; k < 3; ++k) {
        double dv[2];
        change_direction(&dw, k, dv);
        for (int l = 0; l < 2; ++l) dkII[l] -= dv[l] * w.sddot[k]; /* 0 unless driven */
        if (!(args->option[FREE] & (1 << k))) continue;
        for (int l = 0; l < 2; ++l) dJdot[column * d + l] = -dslope[k][l];
        ++column;
    }
    return MBSR_OK;
}

static int count_coordinates(int mask)
{
    return (mask & 1) + (mask >> 1 & 1) + (mask >> 2 & 1);
}

static int check(const mbsr_joint *joint, mbsr_space pred_space, int pred_d,
                 char text[MBSR_TEXT_SIZE])
{
    (void)joint, (void)pred_d;
    if (pred_space != MBSR_SPACE_GENERAL && pred_space != MBSR_SPACE_SPATIAL) return MBSR_OK;
    mbsri_print(text, MBSR_TEXT_SIZE,
                "the predecessor is in %s space; it must be PLANAR, POINT or a root at rest",
                pred_space == MBSR_SPACE_GENERAL ? "GENERAL" : "SPATIAL");
    return MBSR_ERR_SPACE;
}

static int check_fields(const mbsr_joint *joint, char text[MBSR_TEXT_SIZE])
{
    const int all = joint->d == 3 ? 7 : 3, free = joint->option[FREE],
              driven = joint->option[DRIVEN];
    if (joint->space == MBSR_SPACE_SPATIAL || joint->np != joint->d || joint->d < 2 ||
        joint->d > 3) {
        mbsri_print(text, MBSR_TEXT_SIZE, "space is %d, d is %d, np is %d; it is for the plane",
                    (int)joint->space, joint->d, joint->np);
    } else if (free < 0 || free & ~all || driven < 0 || driven & ~all || free & driven) {
        mbsri_print(text, MBSR_TEXT_SIZE,
                    "free is %d and driven is %d; they must be disjoint subsets of %d", free,
                    driven, all);
    } else if (count_coordinates(free) != joint->n) {
        mbsri_print(text, MBSR_TEXT_SIZE, "free is %d, which has not n = %d coordinates", free,
                    joint->n);
    } else if (joint->params != PARAMS) {
        mbsri_print(text, MBSR_TEXT_SIZE, "params is %d, must be %d", joint->params, PARAMS);
    } else if (driven && !joint->motion) {
        mbsri_print(text, MBSR_TEXT_SIZE, "driven is %d, but motion is NULL", driven);
    } else if (joint->motion == mbsr_table_motion &&
               mbsri_table_columns(joint->user) != count_coordinates(driven)) {
        return mbsri_table_refuse(joint->user, count_coordinates(driven), text);
    } else {
        int k = DRIVEN + 1;
        while (k < MBSR_JOINT_OPTIONS && joint->option[k] == 0) ++k;
        if (k == MBSR_JOINT_OPTIONS) return MBSR_OK;
        mbsri_print(text, MBSR_TEXT_SIZE, "option[%d] is %d, must be 0", k, joint->option[k]);
    }
    return MBSR_ERR_VALUE;
}

static const mbsr_joint_table planar_table = {
    .version = MBSR_JOINT_TABLE_VERSION,
    .flags = MBSR_JOINT_UNIT_K | MBSR_JOINT_REGULAR_J,
    .name = "planar",
    .position = position,
    .jacobians = jacobians,
    .bias = bias,
    .rates = rates,
    .check = check,
    .check_fields = check_fields,
    .tangent = tangent,
    .rate_tangent = rate_tangent,
};

bool mbsri_planar_coordinates(const mbsr_joint_table *table, const int *option, int *free)
{
    *free = option[FREE];
    return table == &planar_table;
}

static mbsr_joint make_planar(mbsr_space space, mbsr_planar_frame A, mbsr_planar_frame B, int free,
                              int driven, mbsr_motion_fn motion, void *user)
{
    const int d = space == MBSR_SPACE_PLANAR ? 3 : 2, n = count_coordinates(free & 7);
    return (mbsr_joint){.table = &planar_table,
                        .space = space,
                        .d = d,
                        .np = d,
                        .n = n,
                        .nq = n,
                        .params = PARAMS,
                        .param = {A.x, A.y, A.angle, B.x, B.y, B.angle},
                        .option = {free, driven},
                        .motion = motion,
                        .user = user};
}

mbsr_joint mbsr_joint_planar(mbsr_planar_frame A, mbsr_planar_frame B, int free, int driven,
                             mbsr_motion_fn motion, void *user)
{
    return make_planar(MBSR_SPACE_PLANAR, A, B, free, driven, motion, user);
}

mbsr_joint mbsr_joint_planar_weld(mbsr_planar_frame A, mbsr_planar_frame B)
{
    return make_planar(MBSR_SPACE_PLANAR, A, B, 0, 0, NULL, NULL);
}

mbsr_joint mbsr_joint_planar_revolute(mbsr_planar_frame A, mbsr_planar_frame B)
{
    return make_planar(MBSR_SPACE_PLANAR, A, B, MBSR_ANGLE, 0, NULL, NULL);
}

mbsr_joint mbsr_joint_planar_prismatic(mbsr_planar_frame A, mbsr_planar_frame B)
{
    return make_planar(MBSR_SPACE_PLANAR, A, B, MBSR_X, 0, NULL, NULL);
}

mbsr_joint mbsr_joint_planar_pin_slot(mbsr_planar_frame A, mbsr_planar_frame B)
{
    return make_planar(MBSR_SPACE_PLANAR, A, B, MBSR_X | MBSR_ANGLE, 0, NULL, NULL);
}

mbsr_joint mbsr_joint_planar_free(mbsr_planar_frame A, mbsr_planar_frame B)
{
    return make_planar(MBSR_SPACE_PLANAR, A, B, MBSR_X | MBSR_Y | MBSR_ANGLE, 0, NULL, NULL);
}

mbsr_joint mbsr_joint_point(mbsr_planar_frame A, int free, int driven, mbsr_motion_fn motion,
                            void *user)
{
    return make_planar(MBSR_SPACE_POINT, A, (mbsr_planar_frame){0}, free, driven, motion, user);
}

mbsr_joint mbsr_joint_point_free(void)
{
    return make_planar(MBSR_SPACE_POINT, (mbsr_planar_frame){0}, (mbsr_planar_frame){0},
                       MBSR_X | MBSR_Y, 0, NULL, NULL);
}

mbsr_joint mbsr_joint_custom(const mbsr_joint_table *table, int d, int n, void *user)
{
    return (mbsr_joint){.table = table,
                        .space = MBSR_SPACE_GENERAL,
                        .d = d,
                        .np = d,
                        .n = n,
                        .nq = n,
                        .params = 8,
                        .user = user};
}
