/* Kinematics of the stock joints in space: a chain of steps from frame A to frame B.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Frame A stands on the predecessor, frame B on the body. Steps move a running frame from A to B:
 * rotations about and translations along an axis, screws, and a rotation by a quaternion. Each step
 * is one column or three of the body's velocity: with the axis a and the origin c of the running
 * frame before the step, r the body's origin, both from the predecessor's origin (arms lose nothing
 * where the world's is far),
 *
 *   rotation      S = (a, a x (r - c))      screw   rotation + pitch (0, a)
 *   translation   S = (0, a)                quaternion: rotations about the frame's three axes
 *
 * V_i = X V_pi + sum of S s',  X = [1 0; -[rho]x 1],  rho = r. So K = I, H = -X, J = -S of
 * the free coordinates, kI = -S s' of the driven ones, and
 *
 *   kII = H' V_pi - sum of S' s' - sum of S s'' of the driven ones
 *
 * S' follows from a' = omega x a and the velocities of c and r, where omega is the angular velocity
 * of the running frame before the step.
 *
 * Derivatives along `by`: what moves the chain w also moves its change dw, by the same lines
 * differentiated, where dw is not NULL. The change of R is told by the small rotation `turn`, along
 * the world's axes: dR = turn x R, so that an axis a at rest in the frame has da = turn x a. */
#include "joints/chain.h"

#include "algebra/space3.h"

#include <math.h>
#include <string.h>

typedef struct column {
    double a[3], ad[3]; /* axis, and its rate */
    double c[3], cd[3]; /* a point of it, and that point's velocity */
    double turn, pitch; /* S = turn (a, a x (r - c)) + pitch (0, a) */
    bool driven, ball;  /* ball: one of a quaternion's */
    int place;          /* index of its coordinate in u, or in the motion's outputs */
    double s, sd, sdd;  /* coordinate and rates; sdd of driven ones only */
} column;

typedef struct chain {
    double R_pred[9], r_pred[3], omega_pred[3], v_pred[3];
    double R[9], c[3], omega[3],
        cd[3]; /* the running frame, from the predecessor, and its motion */
    int columns;
    column column[MBSRI_MAX_STEPS];
    double Ri[9], r[3], v[3]; /* the body */
    const double *known;      /* its R, where that is known; NULL: to be found */
} chain;

/* Changes of a chain, under the names of what changes; `turn` is the small rotation of R. */
typedef struct column_change {
    double a[3], ad[3], c[3], cd[3], sd;
} column_change;

typedef struct chain_change {
    double turn_pred[3], r_pred[3], omega_pred[3], v_pred[3];
    double turn[3], c[3], omega[3], cd[3];
    column_change column[MBSRI_MAX_STEPS];
    double r[3], v[3]; /* the body, which turns with the running frame at its end */
} chain_change;

/* dc += d(a x b) */
static void add_change_of_cross(const double a[3], const double da[3], const double b[3],
                                const double db[3], double dc[3])
{
    mbsri_add_cross3(da, b, dc);
    mbsri_add_cross3(a, db, dc);
}

/* dR = turn x R */
static void turned_rotation(const double turn[3], const double R[9], double dR[9])
{
    for (int k = 0; k < 3; ++k) mbsri_cross3(turn, R + 3 * k, dR + 3 * k);
}

/* The turn of dR = turn x R: half the sum of R_k x dR_k over the columns. */
static void turn_of_change(const double R[9], const double dR[9], double turn[3])
{
    for (int k = 0; k < 3; ++k) turn[k] = 0.0;
    for (int k = 0; k < 3; ++k) mbsri_add_cross3(R + 3 * k, dR + 3 * k, turn);
    for (int k = 0; k < 3; ++k) turn[k] *= 0.5;
}

/* The predecessor as a body in space: what lies in the plane stands at z = 0 and turns about z. */
static void place_predecessor(const mbsr_joint_args *args, chain *w)
{
    static const double unit[9] = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0};
    const double *p = args->p_pred, *V = args->V_pred;
    memcpy(w->R_pred, unit, sizeof unit);
    memset(w->r_pred, 0, sizeof w->r_pred);
    memset(w->omega_pred, 0, sizeof w->omega_pred);
    memset(w->v_pred, 0, sizeof w->v_pred);
    if (args->pred_space == MBSR_SPACE_SPATIAL) {
        memcpy(w->R_pred, p + MBSR_POSE_R, sizeof w->R_pred);
        memcpy(w->r_pred, p + MBSR_POSE_X, sizeof w->r_pred);
        if (V) memcpy(w->omega_pred, V, sizeof w->omega_pred);
        if (V) memcpy(w->v_pred, V + 3, sizeof w->v_pred);
    } else if (args->pred_space != MBSR_SPACE_FIXED) {
        for (int k = 0; k < 2; ++k) w->r_pred[k] = p[k];
        for (int k = 0; k < 2 && V; ++k) w->v_pred[k] = V[k];
    }
    if (args->pred_space == MBSR_SPACE_PLANAR) {
        w->R_pred[0] = w->R_pred[4] = cos(p[2]);
        w->R_pred[1] = sin(p[2]);
        w->R_pred[3] = -w->R_pred[1];
        if (V) w->omega_pred[2] = V[2];
    }
}

static void change_predecessor(const mbsr_joint_args *args, const mbsr_joint_change *by,
                               const chain *w, chain_change *dw)
{
    const double *dp = by->p_pred, *dV = by->V_pred;
    memset(dw->turn_pred, 0, sizeof dw->turn_pred);
    memset(dw->r_pred, 0, sizeof dw->r_pred);
    memset(dw->omega_pred, 0, sizeof dw->omega_pred);
    memset(dw->v_pred, 0, sizeof dw->v_pred);
    if (args->pred_space == MBSR_SPACE_SPATIAL) {
        turn_of_change(w->R_pred, dp + MBSR_POSE_R, dw->turn_pred);
        memcpy(dw->r_pred, dp + MBSR_POSE_X, sizeof dw->r_pred);
        if (dV) memcpy(dw->omega_pred, dV, sizeof dw->omega_pred);
        if (dV) memcpy(dw->v_pred, dV + 3, sizeof dw->v_pred);
    } else if (args->pred_space != MBSR_SPACE_FIXED) {
        for (int k = 0; k < 2; ++k) dw->r_pred[k] = dp[k];
        for (int k = 0; k < 2 && dV; ++k) dw->v_pred[k] = dV[k];
    }
    if (args->pred_space == MBSR_SPACE_PLANAR) {
        dw->turn_pred[2] = dp[2];
        if (dV) dw->omega_pred[2] = dV[2];
    }
}

/* R <- R (rotation by angle s about the unit vector n) */
static void turn_about(double R[9], const double n[3], double s)
{
    const double sine = sin(s), h = sin(0.5 * s), versine = 2.0 * h * h;
    double N[9], T[9], product[9];
    mbsri_cross_matrix3(n, N);
    for (int j = 0; j < 3; ++j) {
        for (int k = 0; k < 3; ++k)
            T[3 * j + k] = sine * N[3 * j + k] + versine * (n[j] * n[k] - (j == k ? 1.0 : 0.0));
        T[4 * j] += 1.0;
    }
    mbsri_multiply3(R, T, product);
    memcpy(R, product, sizeof product);
}

/* A new column along axis a (world) through the running frame's origin. */
static column *add_axis_column(chain *w, chain_change *dw, const double a[3])
{
    const int k = w->columns++;
    column *col = w->column + k;
    memcpy(col->a, a, sizeof col->a);
    mbsri_cross3(w->omega, a, col->ad);
    memcpy(col->c, w->c, sizeof col->c);
    memcpy(col->cd, w->cd, sizeof col->cd);
    col->s = col->sd = col->sdd = 0.0;
    col->ball = false;
    if (!dw) return col;
    column_change *dcol = dw->column + k;
    mbsri_cross3(dw->turn, a, dcol->a);
    mbsri_cross3(dw->omega, a, dcol->ad);
    mbsri_add_cross3(w->omega, dcol->a, dcol->ad);
    memcpy(dcol->c, dw->c, sizeof dcol->c);
    memcpy(dcol->cd, dw->cd, sizeof dcol->cd);
    dcol->sd = 0.0;
    return col;
}

/* The origin of the running frame moves by x along a, which turns with omega, at the rate xd. */
static void slide(chain *w, const column *col, double x, double xd)
{
    mbsri_add3(x, col->a, w->c);
    mbsri_add3(x, col->ad, w->cd);
    mbsri_add3(xd, col->a, w->cd);
}

/* The change of `slide` by pitch s at the rate pitch s', and of the turn by s about a. */
static void change_along(const mbsr_joint_args *args, const mbsr_joint_change *by, chain_change *dw,
                         const column *col, column_change *dcol)
{
    double ds = 0.0;
    if (!col->driven) {
        ds = by->q[col->place + (args->nq - args->n)];
        dcol->sd = by->u ? by->u[col->place] : 0.0;
    }
    const double x = col->pitch * col->s, dx = col->pitch * ds;
    const double xd = col->pitch * col->sd, dxd = col->pitch * dcol->sd;
    mbsri_add3(dx, col->a, dw->c);
    mbsri_add3(x, dcol->a, dw->c);
    mbsri_add3(dx, col->ad, dw->cd);
    mbsri_add3(x, dcol->ad, dw->cd);
    mbsri_add3(dxd, col->a, dw->cd);
    mbsri_add3(xd, dcol->a, dw->cd);
    if (col->turn == 0.0) return;
    mbsri_add3(ds, col->a, dw->turn);
    mbsri_add3(dcol->sd, col->a, dw->omega);
    mbsri_add3(col->sd, dcol->a, dw->omega);
}

/* Whether the frame behind the step is that of a body whose R is known. */
static bool is_last_turn(const mbsr_joint_args *args, const chain *w, int step)
{
    return w->known && step + 1 == args->option[0];
}

/* A step with one coordinate. */
static void step_along(const mbsr_joint_args *args, const mbsr_joint_change *by, chain *w,
                       chain_change *dw, int step, const double *driven)
{
    const int code = args->option[1 + step], kind = code & MBSRI_STEP_KIND;
    const double *axis = args->param + MBSRI_AXES + MBSRI_AXIS_SIZE * step;
    double a[3];
    mbsri_rotate3(w->R, axis, a);
    column *col = add_axis_column(w, dw, a);
    col->driven = (code & MBSRI_DRIVEN) != 0;
    col->place = code >> MBSRI_PLACE_SHIFT;
    col->turn = kind == MBSRI_TRANSLATION ? 0.0 : 1.0;
    col->pitch = kind == MBSRI_ROTATION ? 0.0 : kind == MBSRI_SCREW ? axis[3] : 1.0;
    if (col->driven) {
        col->s = driven[col->place];
        col->sd = driven[MBSRI_MAX_STEPS + col->place];
        col->sdd = driven[2 * MBSRI_MAX_STEPS + col->place];
    } else {
        col->s = args->q[col->place + (args->nq - args->n)];
        col->sd = args->u ? args->u[col->place] : 0.0;
    }
    if (dw) change_along(args, by, dw, col, dw->column + (col - w->column));
    slide(w, col, col->pitch * col->s, col->pitch * col->sd);
    if (col->turn == 0.0) return;
    if (!is_last_turn(args, w, step)) turn_about(w->R, axis, col->s);
    mbsri_add3(col->sd, a, w->omega);
}

void mbsri_chain_turn(const double q[4], const double n[4], const double dq[4], double turn[3])
{
    const double scale = 2.0 / (n[0] * q[0] + mbsri_dot3(n + 1, q + 1));
    mbsri_cross3(n + 1, dq + 1, turn);
    for (int k = 0; k < 3; ++k) turn[k] = scale * (turn[k] + n[0] * dq[1 + k] - dq[0] * n[1 + k]);
}

/* The change of a rotation by the quaternion q, n along q. Its columns are `first` and the next
 * two. */
static void change_quaternion(const mbsr_joint_args *args, const mbsr_joint_change *by,
                              const double n[4], const chain *w, chain_change *dw, int first)
{
    double turn[3];
    mbsri_chain_turn(args->q, n, by->q, turn);
    for (int k = 0; k < 3; ++k) {
        const column *col = w->column + first + k;
        column_change *dcol = dw->column + first + k;
        dcol->sd = by->u ? by->u[k] : 0.0;
        mbsri_add3(turn[k], col->a, dw->turn);
        mbsri_add3(dcol->sd, col->a, dw->omega);
        mbsri_add3(col->sd, dcol->a, dw->omega);
    }
}

/* A rotation by the quaternion q / |q|. */
static int step_quaternion(const mbsr_joint_args *args, const mbsr_joint_change *by, chain *w,
                           chain_change *dw)
{
    double T[9], product[9], axes[9], q[4];
    if (!mbsri_scale4(args->q, q)) return MBSR_ZERO_QUATERNION;
    memcpy(axes, w->R, sizeof axes);
    const int first = w->columns;
    for (int k = 0; k < 3; ++k) {
        column *col = add_axis_column(w, dw, axes + 3 * k);
        col->driven = false;
        col->ball = true;
        col->place = k;
        col->turn = 1.0;
        col->pitch = 0.0;
        col->sd = args->u ? args->u[k] : 0.0;
    }
    for (int k = first; k < w->columns; ++k) mbsri_add3(w->column[k].sd, w->column[k].a, w->omega);
    if (dw) change_quaternion(args, by, q, w, dw, first);
    mbsr_quaternion_rotation(q, T);
    mbsri_multiply3(w->R, T, product);
    memcpy(w->R, product, sizeof product);
    return MBSR_OK;
}

/* Frame A: the running frame before the first step. */
static void place_A(const double A[12], chain *w)
{
    double arm[3];
    mbsri_rotate3(w->R_pred, A, arm);
    memcpy(w->c, arm, sizeof w->c);
    mbsri_cross3(w->omega_pred, arm, w->cd);
    mbsri_add3(1.0, w->v_pred, w->cd);
    memcpy(w->omega, w->omega_pred, sizeof w->omega);
    mbsri_multiply3(w->R_pred, A + 3, w->R);
}

static void change_A(const double A[12], const chain *w, chain_change *dw)
{
    double arm[3], darm[3];
    mbsri_rotate3(w->R_pred, A, arm);
    mbsri_cross3(dw->turn_pred, arm, darm);
    memcpy(dw->c, darm, sizeof dw->c);
    memcpy(dw->cd, dw->v_pred, sizeof dw->cd);
    add_change_of_cross(w->omega_pred, dw->omega_pred, arm, darm, dw->cd);
    memcpy(dw->omega, dw->omega_pred, sizeof dw->omega);
    memcpy(dw->turn, dw->turn_pred, sizeof dw->turn);
}

/* The body, on which the running frame now is frame B. */
static void place_body(const double B[12], chain *w)
{
    double arm[3];
    if (w->known)
        memcpy(w->Ri, w->known, sizeof w->Ri);
    else
        mbsri_multiply_transposed3(w->R, B + 3, w->Ri);
    mbsri_rotate3(w->Ri, B, arm);
    for (int k = 0; k < 3; ++k) arm[k] = -arm[k];
    mbsri_cross3(w->omega, arm, w->v);
    for (int k = 0; k < 3; ++k) {
        w->r[k] = w->c[k] + arm[k];
        w->v[k] += w->cd[k];
    }
}

static void change_body(const chain *w, chain_change *dw)
{
    double arm[3], darm[3];
    for (int k = 0; k < 3; ++k) arm[k] = w->r[k] - w->c[k];
    mbsri_cross3(dw->turn, arm, darm);
    memcpy(dw->v, dw->cd, sizeof dw->v);
    add_change_of_cross(w->omega, dw->omega, arm, darm, dw->v);
    for (int k = 0; k < 3; ++k) dw->r[k] = dw->c[k] + darm[k];
}

/* From the predecessor through all steps to the body, and its change along `by` (both NULL: not
 * wanted). known: R of the body, or NULL. Velocities are zero where args, or `by`, has none. */
static int walk_both(const mbsr_joint_args *args, const mbsr_joint_change *by, const double *known,
                     chain *w, chain_change *dw)
{
    const double *A = args->param + MBSRI_A, *B = args->param + MBSRI_B;
    double driven[3 * MBSRI_MAX_STEPS];
    if (args->motion) {
        memset(driven, 0, sizeof driven);
        const int status = args->motion(args->user, args->t, driven, driven + MBSRI_MAX_STEPS,
                                        driven + 2 * MBSRI_MAX_STEPS);
        if (status) return status;
    }
    w->columns = 0;
    w->known = known;
    place_predecessor(args, w);
    if (dw) change_predecessor(args, by, w, dw);
    place_A(A, w);
    if (dw) change_A(A, w, dw);
    for (int step = 0; step < args->option[0]; ++step) {
        if ((args->option[1 + step] & MBSRI_STEP_KIND) == MBSRI_QUATERNION) {
            const int status = step_quaternion(args, by, w, dw);
            if (status) return status;
        } else {
            step_along(args, by, w, dw, step, driven);
        }
    }
    place_body(B, w);
    if (dw) change_body(w, dw);
    return MBSR_OK;
}

static int walk(const mbsr_joint_args *args, chain *w)
{
    return walk_both(args, NULL, NULL, w, NULL);
}

/* To a body whose pose is known. */
static int walk_to(const mbsr_joint_args *args, chain *w)
{
    return walk_both(args, NULL, args->p ? args->p + MBSR_POSE_R : NULL, w, NULL);
}

/* S and S' of a column; rate may be NULL. */
static void motion_of(const chain *w, const column *col, double S[6], double rate[6])
{
    double arm[3], armd[3];
    for (int k = 0; k < 3; ++k) {
        arm[k] = w->r[k] - col->c[k];
        armd[k] = w->v[k] - col->cd[k];
        S[k] = col->turn * col->a[k];
        S[3 + k] = col->pitch * col->a[k];
    }
    if (col->turn != 0.0) mbsri_add_cross3(col->a, arm, S + 3);
    if (!rate) return;
    for (int k = 0; k < 3; ++k) {
        rate[k] = col->turn * col->ad[k];
        rate[3 + k] = col->pitch * col->ad[k];
    }
    if (col->turn == 0.0) return;
    mbsri_add_cross3(col->ad, arm, rate + 3);
    mbsri_add_cross3(col->a, armd, rate + 3);
}

static void change_of_motion(const chain *w, const chain_change *dw, int c, double dS[6],
                             double drate[6])
{
    const column *col = w->column + c;
    const column_change *dcol = dw->column + c;
    double arm[3], armd[3], darm[3], darmd[3];
    for (int k = 0; k < 3; ++k) {
        arm[k] = w->r[k] - col->c[k];
        armd[k] = w->v[k] - col->cd[k];
        darm[k] = dw->r[k] - dcol->c[k];
        darmd[k] = dw->v[k] - dcol->cd[k];
        dS[k] = col->turn * dcol->a[k];
        dS[3 + k] = col->pitch * dcol->a[k];
    }
    if (col->turn != 0.0) add_change_of_cross(col->a, dcol->a, arm, darm, dS + 3);
    if (!drate) return;
    for (int k = 0; k < 3; ++k) {
        drate[k] = col->turn * dcol->ad[k];
        drate[3 + k] = col->pitch * dcol->ad[k];
    }
    if (col->turn == 0.0) return;
    add_change_of_cross(col->ad, dcol->ad, arm, darm, drate + 3);
    add_change_of_cross(col->a, dcol->a, armd, darmd, drate + 3);
}

static void see_pose(const chain *w, double *p)
{
    memcpy(p + MBSR_POSE_R, w->Ri, sizeof w->Ri);
    for (int k = 0; k < 3; ++k) p[MBSR_POSE_X + k] = w->r_pred[k] + w->r[k];
}

int mbsri_chain_position(const mbsr_joint_args *args, double *p)
{
    chain w;
    const int status = walk(args, &w);
    if (!status) see_pose(&w, p);
    return status;
}

/* H = unit X for a predecessor in space; of a body in the plane the columns that it has.
 * lower: the block [rho]x or its rate. */
static void fill_H(mbsr_space space, double unit, const double lower[9], double *H)
{
    static const int spatial[] = {0, 1, 2, 3, 4, 5}, planar[] = {3, 4, 2};
    const int *which = space == MBSR_SPACE_SPATIAL ? spatial : planar;
    const int columns = space == MBSR_SPACE_SPATIAL  ? 6
                        : space == MBSR_SPACE_PLANAR ? 3
                        : space == MBSR_SPACE_POINT  ? 2
                                                     : 0;
    for (int k = 0; k < columns; ++k) {
        double *h = H + 6 * k;
        h[which[k]] = -unit;
        for (int l = 0; l < 3 && which[k] < 3; ++l) h[3 + l] = lower[3 * which[k] + l];
    }
}

static void see_jacobians(const mbsr_joint_args *args, const chain *w, double *H, double *J,
                          double *kI)
{
    double lower[9];
    mbsri_cross_matrix3(w->r, lower);
    fill_H(args->pred_space, 1.0, lower, H);
    for (int c = 0; c < w->columns; ++c) {
        const column *col = w->column + c;
        double S[6];
        motion_of(w, col, S, NULL);
        for (int k = 0; k < 6; ++k) {
            if (col->driven)
                kI[k] -= S[k] * col->sd;
            else
                J[6 * col->place + k] = -S[k];
        }
    }
}

int mbsri_chain_jacobians(const mbsr_joint_args *args, double *K, double *H, double *J, double *kI)
{
    (void)K;
    chain w;
    const int status = walk_to(args, &w);
    if (!status) see_jacobians(args, &w, H, J, kI);
    return status;
}

bool mbsri_chain_is_steady(mbsr_space pred_space, const double *param, const int *option)
{
    const double *B = param + MBSRI_B;
    const int last = option[0] - 1;
    bool steady = pred_space == MBSR_SPACE_FIXED && last >= 0 &&
                  (option[1 + last] & MBSRI_STEP_KIND) == MBSRI_QUATERNION && B[0] == 0.0 &&
                  B[1] == 0.0 && B[2] == 0.0;
    for (int step = 0; step < last && steady; ++step)
        steady = (option[1 + step] & (MBSRI_STEP_KIND | MBSRI_DRIVEN)) == MBSRI_TRANSLATION;
    return steady;
}

/* Whether the joint is: its rates and biases, which arrive as zero, stay so. */
static bool stays(const mbsr_joint_args *args)
{
    return mbsri_chain_is_steady(args->pred_space, args->param, args->option);
}

/* Pose and J of a joint that is steady, behind a root at rest. */
static int place_steady(const mbsr_joint_args *args, double *p, double *J)
{
    const double *A = args->param + MBSRI_A, *B = args->param + MBSRI_B;
    double q[4], T[9], R[9], a[3];
    if (!mbsri_scale4(args->q, q)) return MBSR_ZERO_QUATERNION;
    mbsr_quaternion_rotation(q, T);
    mbsri_multiply3(A + 3, T, R);
    mbsri_multiply_transposed3(R, B + 3, p + MBSR_POSE_R);
    memcpy(p + MBSR_POSE_X, A, 3 * sizeof *A);
    for (int k = 0; k < 9; ++k) J[6 * (k / 3) + k % 3] = -A[3 + k];
    for (int step = 0; step + 1 < args->option[0]; ++step) {
        const int place = args->option[1 + step] >> MBSRI_PLACE_SHIFT;
        mbsri_rotate3(A + 3, args->param + MBSRI_AXES + MBSRI_AXIS_SIZE * step, a);
        mbsri_add3(args->q[place + 1], a, p + MBSR_POSE_X);
        for (int k = 0; k < 3; ++k) J[6 * place + 3 + k] = -a[k];
    }
    return MBSR_OK;
}

int mbsri_chain_place(const mbsr_joint_args *args, double *p, double *H, double *J, double *kI)
{
    chain w;
    if (stays(args)) return place_steady(args, p, J);
    const int status = walk(args, &w);
    if (status) return status;
    see_pose(&w, p);
    see_jacobians(args, &w, H, J, kI);
    return MBSR_OK;
}

int mbsri_chain_bias(const mbsr_joint_args *args, double *kII)
{
    chain w;
    if (stays(args)) return MBSR_OK;
    const int status = walk_to(args, &w);
    if (status) return status;
    /* -H' V_pi = omega_pi x rho' */
    double rhod[3];
    for (int k = 0; k < 3; ++k) rhod[k] = w.v_pred[k] - w.v[k];
    mbsri_add_cross3(w.omega_pred, rhod, kII + 3);
    for (int c = 0; c < w.columns; ++c) {
        const column *col = w.column + c;
        double S[6], rate[6];
        motion_of(&w, col, S, rate);
        for (int k = 0; k < 6; ++k) kII[k] -= rate[k] * col->sd + S[k] * col->sdd;
    }
    return MBSR_OK;
}

int mbsri_chain_rates(const mbsr_joint_args *args, double *Kdot, double *Hdot, double *Jdot)
{
    (void)Kdot;
    chain w;
    if (stays(args)) return MBSR_OK;
    const int status = walk_to(args, &w);
    if (status) return status;
    double rhod[3], lower[9];
    for (int k = 0; k < 3; ++k) rhod[k] = w.v[k] - w.v_pred[k];
    mbsri_cross_matrix3(rhod, lower);
    fill_H(args->pred_space, 0.0, lower, Hdot);
    for (int c = 0; c < w.columns; ++c) {
        const column *col = w.column + c;
        double S[6], rate[6];
        if (col->driven) continue;
        motion_of(&w, col, S, rate);
        for (int k = 0; k < 6; ++k) Jdot[6 * col->place + k] = -rate[k];
    }
    return MBSR_OK;
}

int mbsri_chain_motion(const mbsr_joint_args *args, double *p, double *S, double *drive,
                       double *bias, double *Sdot)
{
    chain w;
    const int status = walk(args, &w);
    if (status) return status;
    see_pose(&w, p);
    double rhod[3];
    for (int k = 0; k < 3; ++k) rhod[k] = w.v[k] - w.v_pred[k];
    for (int k = 0; k < 6; ++k) drive[k] = bias[k] = 0.0;
    mbsri_cross3(w.omega_pred, rhod, bias + 3);
    for (int c = 0; c < w.columns; ++c) {
        const column *col = w.column + c;
        double own[6], rate[6];
        motion_of(&w, col, own, rate);
        for (int k = 0; k < 6; ++k) {
            bias[k] += rate[k] * col->sd + own[k] * col->sdd;
            if (col->driven) {
                drive[k] += own[k] * col->sd;
                continue;
            }
            S[6 * col->place + k] = own[k];
            if (Sdot) Sdot[6 * col->place + k] = rate[k];
        }
    }
    return MBSR_OK;
}

int mbsri_chain_axes(const mbsr_joint_args *args, mbsri_chain_axis *axes, int *count)
{
    chain w;
    const int status = walk(args, &w);
    if (status) return status;
    for (int c = 0; c < w.columns; ++c) {
        const column *col = w.column + c;
        axes[c] = (mbsri_chain_axis){.place = col->driven ? -1 : col->place,
                                     .ball = col->ball,
                                     .rate = col->sd,
                                     .acceleration = col->sdd};
        motion_of(&w, col, axes[c].S, NULL);
    }
    *count = w.columns;
    return MBSR_OK;
}

void mbsri_chain_quaternion_rate(const double q[4], const double u[3], double qdot[4])
{
    qdot[0] = -0.5 * mbsri_dot3(u, q + 1);
    mbsri_cross3(u, q + 1, qdot + 1);
    for (int k = 0; k < 3; ++k) qdot[1 + k] = 0.5 * (qdot[1 + k] + q[0] * u[k]);
}

/* For joints whose first coordinates are a quaternion; q' = u of all others. */
int mbsri_chain_coordinate_rates(const mbsr_joint_args *args, double *qdot)
{
    mbsri_chain_quaternion_rate(args->q, args->u, qdot);
    for (int k = 3; k < args->n; ++k) qdot[k + 1] = args->u[k];
    return MBSR_OK;
}

static void change_coordinate_rates(const mbsr_joint_args *args, const mbsr_joint_change *by,
                                    double *dqdot)
{
    double of_u[4];
    mbsri_chain_quaternion_rate(by->q, args->u, dqdot);
    mbsri_chain_quaternion_rate(args->q, by->u, of_u);
    for (int k = 0; k < 4; ++k) dqdot[k] += of_u[k];
    for (int k = 3; k < args->n; ++k) dqdot[k + 1] = by->u[k];
}

/* The changes of what mbsri_chain_position and _jacobians write. */
int mbsri_chain_tangent(const mbsr_joint_args *args, const mbsr_joint_change *by, double *dp,
                        double *dK, double *dH, double *dJ, double *dkI)
{
    (void)dK;
    chain w;
    chain_change dw;
    const int status = walk_both(args, by, NULL, &w, &dw);
    if (status) return status;
    turned_rotation(dw.turn, w.Ri, dp + MBSR_POSE_R);
    for (int k = 0; k < 3; ++k) dp[MBSR_POSE_X + k] = dw.r_pred[k] + dw.r[k];
    double lower[9];
    mbsri_cross_matrix3(dw.r, lower);
    fill_H(args->pred_space, 0.0, lower, dH);
    for (int c = 0; c < w.columns; ++c) {
        const column *col = w.column + c;
        double dS[6];
        change_of_motion(&w, &dw, c, dS, NULL);
        for (int k = 0; k < 6; ++k) {
            if (col->driven)
                dkI[k] -= dS[k] * col->sd;
            else
                dJ[6 * col->place + k] = -dS[k];
        }
    }
    return MBSR_OK;
}

/* The changes of what mbsri_chain_bias, _rates and _coordinate_rates write. */
int mbsri_chain_rate_tangent(const mbsr_joint_args *args, const mbsr_joint_change *by, double *dkII,
                             double *dKdot, double *dHdot, double *dJdot, double *dqdot)
{
    (void)dKdot;
    chain w;
    chain_change dw;
    const int status = walk_both(args, by, NULL, &w, &dw);
    if (status) return status;
    double rhod[3], drhod[3], lower[9];
    for (int k = 0; k < 3; ++k) {
        rhod[k] = w.v[k] - w.v_pred[k];
        drhod[k] = dw.v[k] - dw.v_pred[k];
    }
    mbsri_cross_matrix3(drhod, lower);
    fill_H(args->pred_space, 0.0, lower, dHdot);
    /* -H' V_pi = omega_pi x rho' */
    mbsri_add_cross3(rhod, dw.omega_pred, dkII + 3);
    mbsri_add_cross3(drhod, w.omega_pred, dkII + 3);
    for (int c = 0; c < w.columns; ++c) {
        const column *col = w.column + c;
        double S[6], rate[6], dS[6], drate[6];
        motion_of(&w, col, S, rate);
        change_of_motion(&w, &dw, c, dS, drate);
        for (int k = 0; k < 6; ++k) {
            dkII[k] -= drate[k] * col->sd + rate[k] * dw.column[c].sd + dS[k] * col->sdd;
            if (!col->driven) dJdot[6 * col->place + k] = -drate[k];
        }
    }
    if (dqdot) change_coordinate_rates(args, by, dqdot);
    return MBSR_OK;
}

int mbsri_chain_normalise(const mbsr_joint_args *args, double *q)
{
    (void)args;
    double n[4];
    if (!mbsri_scale4(q, n)) return MBSR_ZERO_QUATERNION;
    const double size = sqrt(n[0] * n[0] + mbsri_dot3(n + 1, n + 1));
    for (int k = 0; k < 4; ++k) q[k] = n[k] / size;
    return MBSR_OK;
}
