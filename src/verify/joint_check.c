/* A test of a joint's functions against differences of its positions; the test of its derivatives
 * is in joint_check_tangents.c.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A pose near another is told by d numbers x: p less the other p, or of a SPATIAL body the
 * difference of r and twice the vector part of the quaternion from one R to the other, which is the
 * rotation vector but for terms of third order. Along a motion through the other pose x' is V there
 * and x'' is A. With four samples at -2h, -h, h, 2h
 *
 *   x'  = (x(-2h) - 8 x(-h) + 8 x(h) - x(2h)) / 12 h
 *   x'' = (-x(-2h) + 16 x(-h) - 30 x(0) + 16 x(h) - x(2h)) / 12 h^2
 *
 * up to h^4. Column c of H or J is then -K x' of the motion with the one rate c, kI is -K x' of
 * time alone, kII is -K x'' of the motion with all rates constant; H' and J' are such differences
 * of those columns. */
#include "algebra/dense.h"
#include "algebra/frames.h"
#include "algebra/numbers.h"
#include "algebra/space3.h"
#include "base/cookie.h"
#include "base/error.h"
#include "base/memory.h"
#include "model/check.h"
#include "recursion/pose.h"
#include "verify/joint_check_tangents.h"
#include "verify/verifier.h"

#include <mbsrank/verify.h>

#include <math.h>

static const double weight1[4] = {1.0 / 12.0, -8.0 / 12.0, 8.0 / 12.0, -1.0 / 12.0},
                    weight2[4] = {-1.0 / 12.0, 16.0 / 12.0, 16.0 / 12.0, -1.0 / 12.0},
                    sample[4] = {-2.0, -1.0, 1.0, 2.0};

mbsr_joint_test mbsr_default_joint_test(void)
{
    return (mbsr_joint_test){.cookie = MBSRI_COOKIE, .pred_space = MBSR_SPACE_FIXED, .step = 0.004};
}

/* ---- memory ---- */

/* Places all arrays in the memory (NULL: none yet); returns the number of doubles. */
static size_t lay_out_verifier(mbsri_verifier *w, double *memory)
{
    size_t used = 0;
    mbsri_place *const places[] = {&w->base, &w->on, &w->by};
    mbsri_jacobians *const sets[] = {&w->jacobians.given, &w->jacobians.passing,
                                     &w->jacobians.truth, &w->jacobians.slope};
    for (int k = 0; k < 3; ++k) mbsri_verifier_lay_out_place(w, places[k], memory, &used);
    for (int k = 0; k < 4; ++k) mbsri_verifier_lay_out_jacobians(w, sets[k], memory, &used);
    w->unit = mbsri_verifier_take(memory, &used, w->n > w->d_pred ? w->n : w->d_pred, 1);
    w->x = mbsri_verifier_take(memory, &used, w->d, 4);
    w->jacobians.row = mbsri_verifier_take(memory, &used, w->d, 1);
    w->V = mbsri_verifier_take(memory, &used, w->d, 1);
    w->A = mbsri_verifier_take(memory, &used, w->d, 1);
    w->kII = mbsri_verifier_take(memory, &used, w->d, 1);
    w->V_pred = mbsri_verifier_take(memory, &used, w->d_pred, 1);
    w->qdot = mbsri_verifier_take(memory, &used, w->nq, 1);
    w->flow = mbsri_verifier_take(memory, &used, w->nq, 2);
    w->inverse.K = mbsri_verifier_take(memory, &used, w->d, w->d);
    w->inverse.work = mbsri_verifier_take(memory, &used, w->d, 4);
    mbsri_verifier_lay_out_tangents(w, memory, &used);
    return used;
}

/* ---- motions ---- */

/* q of `to` moves on for s seconds with u constant: Runge-Kutta, four steps. */
static int flow(mbsri_verifier *w, mbsri_place *to, const double *u, double s)
{
    enum { STEPS = 4 };
    static const double share[4] = {1.0, 2.0, 2.0, 1.0}, ahead[4] = {0.5, 0.5, 1.0, 0.0};
    const double step = s / STEPS;
    const size_t nq = (size_t)w->nq;
    double *start = w->flow, *end = w->flow + nq;
    for (int k = 0; k < STEPS; ++k) {
        mbsri_copy(nq, to->q, start);
        mbsri_copy(nq, to->q, end);
        for (int stage = 0; stage < 4; ++stage) {
            const int status = mbsri_verifier_qdot(w, to, u);
            if (status) return status;
            for (size_t l = 0; l < nq; ++l) {
                end[l] += share[stage] / 6.0 * step * w->qdot[l];
                to->q[l] = start[l] + ahead[stage] * step * w->qdot[l];
            }
        }
        mbsri_copy(nq, end, to->q);
    }
    return MBSR_OK;
}

/* The state s seconds after `from`; u and V_pred may be NULL: at rest. time: t runs too. */
static int pass_time(mbsri_verifier *w, const mbsri_place *from, const double *u,
                     const double *V_pred, bool time, double s, mbsri_place *to)
{
    to->t = from->t + (time ? s : 0.0);
    mbsri_copy((size_t)w->nq, from->q, to->q);
    mbsri_copy((size_t)w->np_pred, from->p_pred, to->p_pred);
    if (V_pred) mbsri_verifier_move(w, V_pred, s, to->p_pred);
    const int status = u && w->n > 0 ? flow(w, to, u, s) : MBSR_OK;
    return status ? status : mbsri_verifier_pose(w, to);
}

/* x of pose p seen from pose o. */
static void pose_difference(const mbsri_verifier *w, const double *o, const double *p, double *x)
{
    if (!mbsri_turns(w->joint->space)) {
        for (int k = 0; k < w->d; ++k) x[k] = p[k] - o[k];
        return;
    }
    double R[9], quaternion[4];
    mbsri_multiply_transposed3(p + MBSR_POSE_R, o + MBSR_POSE_R, R);
    mbsr_rotation_quaternion(R, quaternion);
    for (int k = 0; k < 3; ++k) x[k] = 2.0 * quaternion[1 + k];
    for (int k = 3; k < w->d; ++k) x[k] = p[MBSR_POSE_X + k - 3] - o[MBSR_POSE_X + k - 3];
}

/* V = x' and A = x'' (NULL: not wanted) at `from`, along a motion as in `pass`; h: step in s. */
static int slopes(mbsri_verifier *w, const mbsri_place *from, const double *u, const double *V_pred,
                  bool time, double h, double *V, double *A)
{
    for (int k = 0; k < 4; ++k) {
        const int status = pass_time(w, from, u, V_pred, time, sample[k] * h, &w->by);
        if (status) return status;
        pose_difference(w, from->p, w->by.p, w->x + k * w->d);
    }
    mbsri_zero((size_t)w->d, V);
    mbsri_ax(w->d, 4, 1.0 / h, w->x, weight1, V);
    if (!A) return MBSR_OK;
    mbsri_zero((size_t)w->d, A);
    mbsri_ax(w->d, 4, 1.0 / (h * h), w->x, weight2, A);
    return MBSR_OK;
}

/* ---- what K, H, J and kI should be ---- */

/* column = -K x' of the motion with rate `c` of `count` alone. */
static int column_by_differences(mbsri_verifier *w, const mbsri_place *at, const double *K,
                                 bool of_pred, int c, double *column)
{
    double *V = w->inverse.work;
    mbsri_zero((size_t)(of_pred ? w->d_pred : w->n), w->unit);
    w->unit[c] = 1.0;
    const int status = slopes(w, at, of_pred ? NULL : w->unit, of_pred ? w->unit : NULL, false,
                              w->at->step, V, NULL);
    mbsri_zero((size_t)w->d, column);
    mbsri_ax(w->d, w->d, -1.0, K, V, column);
    return status;
}

/* K, H, J, kI at a state: as written into `x`, and in `truth` by differences; K, and what
 * differences cannot tell, as written. */
static int find_truth(mbsri_verifier *w, const mbsri_place *at, mbsri_jacobians *x,
                      mbsri_jacobians *truth)
{
    const size_t d = (size_t)w->d;
    int status = mbsri_verifier_jacobians(w, at, x);
    if (status) return status;
    mbsri_copy(d * (size_t)(w->d + w->d_pred + w->n + 1), x->K, truth->K);
    if (!w->own) return MBSR_OK;
    for (int c = 0; c < w->d_pred && w->pred && !status; ++c)
        status = column_by_differences(w, at, x->K, true, c, truth->H + (size_t)c * d);
    for (int c = 0; c < w->n && !status; ++c)
        status = column_by_differences(w, at, x->K, false, c, truth->J + (size_t)c * d);
    return status;
}

/* ---- the verdicts ---- */

static void compare_rows(mbsri_verifier *w)
{
    for (int r = 0; r < w->d; ++r) {
        w->jacobians.row[r] = 0.0;
        for (int c = 0; c < w->d + w->d_pred + w->n; ++c)
            w->jacobians.row[r] =
                fmax(w->jacobians.row[r], fabs(w->jacobians.given.K[c * w->d + r]));
        if (!(w->jacobians.row[r] > 0.0)) w->jacobians.row[r] = 1.0;
    }
}

/* position, H, J, kI */
static int verify_jacobians(mbsri_verifier *w)
{
    mbsr_joint_errors *errors = w->errors;
    if (mbsri_turns(w->joint->space)) {
        errors->position = 0.0;
        const double defect = mbsri_frame_defect(w->base.p + MBSR_POSE_R);
        mbsri_verifier_note(w, &errors->position, isinf(defect) ? 2.0 : defect,
                            "position: R of the pose is no rotation");
    }
    int status = find_truth(w, &w->base, &w->jacobians.given, &w->jacobians.truth);
    if (status) return status;
    compare_rows(w);
    if (!w->own) return MBSR_OK;
    if (w->pred)
        mbsri_verifier_compare(w, &errors->H, "H", w->d_pred, w->jacobians.given.H,
                               w->jacobians.truth.H, 1.0);
    mbsri_verifier_compare(w, &errors->J, "J", w->n, w->jacobians.given.J, w->jacobians.truth.J,
                           1.0);
    /* time alone; again with shorter steps where much moves */
    status = slopes(w, &w->base, NULL, NULL, true, w->at->step, w->V, NULL);
    const double drive = fmax(1.0, mbsri_largest(w->d, w->V));
    if (!status && drive > 1.0)
        status = slopes(w, &w->base, NULL, NULL, true, w->at->step / drive, w->V, NULL);
    w->speed = fmax(w->speed, drive);
    mbsri_zero((size_t)w->d, w->jacobians.truth.kI);
    mbsri_ax(w->d, w->d, -1.0, w->jacobians.given.K, w->V, w->jacobians.truth.kI);
    if (!status)
        mbsri_verifier_compare(w, &errors->kI, "kI", 1, w->jacobians.given.kI,
                               w->jacobians.truth.kI, 0.0);
    return status;
}

/* The rates of K, H, J, and without poses to read A from, A = V' with V from (8). */
static int find_joint_rates(mbsri_verifier *w)
{
    const int d = w->d;
    const size_t size = (size_t)d * (size_t)(d + w->d_pred + w->n);
    mbsri_zero(size, w->jacobians.slope.K);
    if (!w->own) mbsri_zero((size_t)d, w->A);
    for (int k = 0; k < 4; ++k) {
        int status = pass_time(w, &w->base, w->at->u, w->V_pred, true, sample[k] * w->h, &w->on);
        if (!status) status = find_truth(w, &w->on, &w->jacobians.passing, &w->jacobians.truth);
        if (!status && !w->own)
            status = mbsri_verifier_velocity(w, &w->jacobians.passing, w->at->u, w->V_pred, w->V);
        if (status) return status;
        for (size_t l = 0; l < size; ++l)
            w->jacobians.slope.K[l] += weight1[k] / w->h * w->jacobians.truth.K[l];
        for (int l = 0; l < d && !w->own; ++l) w->A[l] += weight1[k] / w->h * w->V[l];
    }
    return MBSR_OK;
}

/* kII = -K A along the motion, and the rates of K, H, J. */
static int verify_motion(mbsri_verifier *w)
{
    mbsr_joint_errors *errors = w->errors;
    const mbsr_joint_table *table = w->joint->table;
    const size_t d = (size_t)w->d;
    int status = table->rates || !w->own ? find_joint_rates(w) : MBSR_OK;
    if (!status)
        status = w->own
                     ? slopes(w, &w->base, w->at->u, w->V_pred, true, w->h, w->V, w->A)
                     : mbsri_verifier_velocity(w, &w->jacobians.given, w->at->u, w->V_pred, w->V);
    if (status) return status;
    const mbsr_joint_args args = mbsri_verifier_args(w, &w->base, w->at->u, w->V_pred, w->V);

    mbsri_zero(d, w->kII);
    status = mbsri_verifier_settle(w, table->bias(&args, w->kII), "bias", d, w->kII);
    if (status) return status;
    mbsri_zero(d, w->jacobians.truth.kI);
    mbsri_ax(w->d, w->d, -1.0, w->jacobians.given.K, w->A, w->jacobians.truth.kI);
    mbsri_verifier_compare(w, &errors->kII, "kII", 1, w->kII, w->jacobians.truth.kI,
                           w->speed * mbsri_largest(w->d, w->V));

    if (!table->rates) return MBSR_OK;
    mbsri_jacobians *rates = &w->jacobians.passing;
    const size_t size = d * (size_t)(w->d + w->d_pred + w->n);
    mbsri_zero(size, rates->K);
    status = table->rates(&args, mbsri_verifier_unit_K(w) ? NULL : rates->K, rates->H, rates->J);
    status = mbsri_verifier_settle(w, status, "rates", size, rates->K);
    if (status) return status;
    if (!mbsri_verifier_unit_K(w))
        mbsri_verifier_compare(w, &errors->Kdot, "Kdot", w->d, rates->K, w->jacobians.slope.K,
                               w->speed);
    mbsri_verifier_compare(w, &errors->Hdot, "Hdot", w->d_pred, rates->H, w->jacobians.slope.H,
                           w->speed);
    mbsri_verifier_compare(w, &errors->Jdot, "Jdot", w->n, rates->J, w->jacobians.slope.J,
                           w->speed);
    return MBSR_OK;
}

/* G u against the sum of its columns times u. */
static int verify_coordinate_rates(mbsri_verifier *w)
{
    const size_t nq = (size_t)w->nq;
    double *sum = w->flow, *whole = w->flow + nq, *field = &w->errors->coordinate_rates;
    if (!w->joint->table->coordinate_rates || w->n == 0) return MBSR_OK;
    int status = mbsri_verifier_qdot(w, &w->base, w->at->u);
    mbsri_copy(nq, w->qdot, whole);
    mbsri_zero(nq, sum);
    double size = mbsri_largest(w->nq, whole);
    for (int k = 0; k < w->n && !status; ++k) {
        mbsri_zero((size_t)w->n, w->unit);
        w->unit[k] = 1.0;
        status = mbsri_verifier_qdot(w, &w->base, w->unit);
        for (size_t l = 0; l < nq; ++l) {
            sum[l] += w->at->u[k] * w->qdot[l];
            size = fmax(size, fabs(w->at->u[k] * w->qdot[l]));
        }
    }
    *field = 0.0;
    for (size_t l = 0; l < nq && size > 0.0 && !status; ++l) {
        mbsri_verifier_note(w, field, fabs(whole[l] - sum[l]) / size,
                            "coordinate_rates: qdot(%d) is %.9g, by the columns of G %.9g", (int)l,
                            whole[l], sum[l]);
    }
    return status;
}

static int verify_normalise(mbsri_verifier *w)
{
    if (!w->joint->table->normalise) return MBSR_OK;
    mbsri_copy((size_t)w->nq, w->base.q, w->by.q);
    mbsri_copy((size_t)w->np_pred, w->base.p_pred, w->by.p_pred);
    w->by.t = w->base.t;
    mbsr_joint_args args = mbsri_verifier_args(w, &w->base, NULL, NULL, NULL);
    args.p = NULL;
    int status = w->joint->table->normalise(&args, w->by.q);
    status = mbsri_verifier_settle(w, status, "normalise", (size_t)w->nq, w->by.q);
    if (!status) status = mbsri_verifier_pose(w, &w->by);
    if (status) return status;
    for (int k = 0; k < w->np; ++k) w->by.p[k] -= w->base.p[k];
    w->errors->normalise = 0.0;
    mbsri_verifier_note(w, &w->errors->normalise, mbsri_largest(w->np, w->by.p),
                        "normalise: the pose changes by %.3g", mbsri_largest(w->np, w->by.p));
    return MBSR_OK;
}

/* ---- the whole ---- */

#define REFUSE(status, ...) mbsri_fail(error, status, MBSR_NONE, MBSR_NONE, __VA_ARGS__)

/* Sizes of the predecessor, and what the library refuses of the joint. */
static int check_joint(mbsri_verifier *w)
{
    static const int space_d[] = {
        [MBSR_SPACE_POINT] = 2, [MBSR_SPACE_PLANAR] = 3, [MBSR_SPACE_SPATIAL] = 6};
    static const int space_np[] = {
        [MBSR_SPACE_POINT] = 2, [MBSR_SPACE_PLANAR] = 3, [MBSR_SPACE_SPATIAL] = MBSR_POSE_SIZE};
    const mbsr_joint *joint = w->joint;
    const mbsr_joint_test *at = w->at;
    mbsr_error *error = w->error;
    mbsr_model none = {.bodies = 0};
    const int refused = mbsri_check_joint(&none, joint, MBSR_NONE, "mbsr_joint_verify");
    if (refused && error) *error = none.error;
    if (refused) return refused;
    const bool general = at->pred_space == MBSR_SPACE_GENERAL;
    const bool flexible = at->pred_space == MBSR_SPACE_FLEXIBLE;
    if ((int)at->pred_space < MBSR_SPACE_FIXED || (int)at->pred_space > MBSR_SPACE_FLEXIBLE ||
        (flexible &&
         (at->pred_d < 6 || at->pred_d > MBSR_MAX_D || at->pred_np != at->pred_d + 6)) ||
        (general && (at->pred_d < 1 || at->pred_d > MBSR_MAX_D || at->pred_np < 0 ||
                     at->pred_np > 4 * MBSR_MAX_D))) {
        return REFUSE(MBSR_ERR_VALUE,
                      "mbsr_joint_verify: pred_space = %d with pred_d = %d, pred_np = %d is no "
                      "predecessor",
                      (int)at->pred_space, at->pred_d, at->pred_np);
    }
    w->d = joint->d, w->np = joint->np, w->n = joint->n, w->nq = joint->nq;
    w->d_pred = general || flexible ? at->pred_d : space_d[at->pred_space];
    w->np_pred = general || flexible ? at->pred_np : space_np[at->pred_space];
    const bool rate = !at->V_is_not_rate;
    w->own = joint->space != MBSR_SPACE_GENERAL || (w->np == w->d && rate);
    w->pred = !general || (w->np_pred == w->d_pred && rate);
    char text[MBSR_TEXT_SIZE] = "";
    if (!joint->table->check) return MBSR_OK;
    const int status = joint->table->check(joint, at->pred_space, w->d_pred, text);
    return status ? REFUSE(status, "mbsr_joint_verify: joint '%s': %.150s", joint->table->name,
                           text[0] ? text : mbsr_status_text(status))
                  : MBSR_OK;
}

static int check_state(const mbsri_verifier *w)
{
    const mbsr_joint_test *at = w->at;
    mbsr_error *error = w->error;
    const struct {
        const char *name;
        int count;
        const double *x;
    } list[] = {{"q", w->nq, at->q},
                {"u", w->n, at->u},
                {"p_pred", w->np_pred, at->p_pred},
                {"V_pred", w->d_pred, at->V_pred}};
    for (int k = 0; k < 4; ++k) {
        if (list[k].count > 0 && !list[k].x)
            return REFUSE(MBSR_ERR_NULL, "mbsr_joint_verify: %s is NULL", list[k].name);
        if (!mbsri_finite((size_t)list[k].count, list[k].x))
            return REFUSE(MBSR_ERR_VALUE, "mbsr_joint_verify: %s is not finite", list[k].name);
    }
    if (!isfinite(at->t) || !(at->step > 0.0) || !isfinite(at->step)) {
        return REFUSE(MBSR_ERR_VALUE, "mbsr_joint_verify: t is %g, step is %g", at->t, at->step);
    }
    if (!w->pred && mbsri_largest(w->d_pred, at->V_pred) > 0.0) {
        return REFUSE(MBSR_ERR_SPACE,
                      "mbsr_joint_verify: the predecessor's V is not p', so that its pose cannot "
                      "be moved: V_pred must be zero");
    }
    return MBSR_OK;
}

static int verify_joint(mbsri_verifier *w)
{
    const mbsr_joint_test *at = w->at;
    w->base.t = at->t;
    mbsri_copy((size_t)w->nq, at->q, w->base.q);
    mbsri_copy((size_t)w->np_pred, at->p_pred, w->base.p_pred);
    mbsri_copy((size_t)w->d_pred, at->V_pred, w->V_pred);
    mbsri_zero((size_t)w->d, w->V);
    w->speed = fmax(1.0, fmax(mbsri_largest(w->n, at->u), mbsri_largest(w->d_pred, w->V_pred)));
    int status = mbsri_verifier_pose(w, &w->base);
    if (!status) status = verify_jacobians(w);
    w->h = at->step / w->speed;
    if (!status) status = verify_motion(w);
    if (!status) status = verify_coordinate_rates(w);
    if (!status) status = mbsri_verify_tangents(w);
    return status ? status : verify_normalise(w);
}

static bool finite_errors(const mbsr_joint_errors *e)
{
    const double all[] = {e->position,  e->H,       e->J,
                          e->kI,        e->kII,     e->Kdot,
                          e->Hdot,      e->Jdot,    e->coordinate_rates,
                          e->normalise, e->tangent, e->rate_tangent,
                          e->largest};
    return mbsri_finite(sizeof all / sizeof *all, all);
}

int mbsr_joint_verify(const mbsr_joint *joint, const mbsr_joint_test *at, mbsr_joint_errors *errors,
                      mbsr_error *error)
{
    if (!joint || !at || !errors)
        return REFUSE(MBSR_ERR_NULL, "mbsr_joint_verify: a required pointer is NULL");
    if (at->cookie != MBSRI_COOKIE) {
        return REFUSE(MBSR_ERR_NO_DEFAULT,
                      "mbsr_joint_verify: the test was not made by mbsr_default_joint_test");
    }
    *errors = (mbsr_joint_errors){-1.0, -1.0, -1.0, -1.0, -1.0, -1.0, -1.0,
                                  -1.0, -1.0, -1.0, -1.0, -1.0, 0.0,  ""};
    mbsri_verifier w = {.joint = joint, .at = at, .errors = errors, .error = error};
    int status = check_joint(&w);
    if (!status) status = check_state(&w);
    if (status) return status;
    double *memory = mbsri_allocate(&at->allocator, lay_out_verifier(&w, NULL) * sizeof *memory);
    if (!memory) return REFUSE(MBSR_ERR_NO_MEMORY, "mbsr_joint_verify: no memory");
    lay_out_verifier(&w, memory);
    status = verify_joint(&w);
    mbsri_release(&at->allocator, memory);
    if (!status && !finite_errors(errors)) {
        return REFUSE(MBSR_NOT_FINITE, "mbsr_joint_verify: numbers overflow at this state");
    }
    return status;
}
