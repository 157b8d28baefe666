/* What the parts of the test of joints share: its memory, calls of the joint, verdicts.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "verify/verifier.h"

#include "algebra/dense.h"
#include "algebra/lapack.h"
#include "algebra/numbers.h"
#include "algebra/space3.h"
#include "base/error.h"
#include "recursion/pose.h"

#include <mbsrank/verify.h>

#include <math.h>

double *mbsri_verifier_take(double *memory, size_t *used, int rows, int columns)
{
    double *here = memory ? memory + *used : NULL;
    *used += (size_t)rows * (size_t)columns;
    return here;
}

void mbsri_verifier_lay_out_place(const mbsri_verifier *w, mbsri_place *x, double *memory,
                                  size_t *used)
{
    x->q = mbsri_verifier_take(memory, used, w->nq, 1);
    x->p_pred = mbsri_verifier_take(memory, used, w->np_pred, 1);
    x->p = mbsri_verifier_take(memory, used, w->np, 1);
}

void mbsri_verifier_lay_out_jacobians(const mbsri_verifier *w, mbsri_jacobians *x, double *memory,
                                      size_t *used)
{
    x->K = mbsri_verifier_take(memory, used, w->d, w->d);
    x->H = mbsri_verifier_take(memory, used, w->d, w->d_pred);
    x->J = mbsri_verifier_take(memory, used, w->d, w->n);
    x->kI = mbsri_verifier_take(memory, used, w->d, 1);
}

/* ---- calls of the joint ---- */

mbsr_joint_args mbsri_verifier_args(const mbsri_verifier *w, const mbsri_place *at, const double *u,
                                    const double *V_pred, const double *V)
{
    const mbsr_joint *joint = w->joint;
    return (mbsr_joint_args){.param = joint->param,
                             .option = joint->option,
                             .motion = joint->motion,
                             .user = joint->user,
                             .d = w->d,
                             .np = w->np,
                             .n = w->n,
                             .nq = w->nq,
                             .t = at->t,
                             .q = at->q,
                             .u = u,
                             .pred_space = w->at->pred_space,
                             .pred_d = w->d_pred,
                             .p_pred = at->p_pred,
                             .V_pred = V_pred,
                             .p = at->p,
                             .V = V};
}

int mbsri_verifier_settle(mbsri_verifier *w, int status, const char *function, size_t count,
                          const double *x)
{
    const char *name = w->joint->table->name;
    if (status) {
        return mbsri_fail(w->error, status, MBSR_NONE, MBSR_NONE,
                          "mbsr_joint_verify: joint '%s': %s returned %d (%s)", name, function,
                          status, mbsr_status_text(status));
    }
    if (mbsri_finite(count, x)) return MBSR_OK;
    return mbsri_fail(w->error, MBSR_NOT_FINITE, MBSR_NONE, MBSR_NONE,
                      "mbsr_joint_verify: joint '%s': what %s wrote is not finite", name, function);
}

int mbsri_verifier_pose(mbsri_verifier *w, mbsri_place *at)
{
    mbsr_joint_args args = mbsri_verifier_args(w, at, NULL, NULL, NULL);
    args.p = NULL;
    mbsri_zero((size_t)w->np, at->p);
    const int status = w->joint->table->position(&args, at->p);
    return mbsri_verifier_settle(w, status, "position", (size_t)w->np, at->p);
}

int mbsri_verifier_jacobians(mbsri_verifier *w, const mbsri_place *at, mbsri_jacobians *out)
{
    const mbsr_joint_args args = mbsri_verifier_args(w, at, NULL, NULL, NULL);
    const size_t d = (size_t)w->d, columns = (size_t)(w->d + w->d_pred + w->n + 1);
    mbsri_zero(d * columns, out->K);
    for (size_t k = 0; k < d; ++k) out->K[k * d + k] = 1.0;
    const int status = w->joint->table->jacobians(&args, mbsri_verifier_unit_K(w) ? NULL : out->K,
                                                  out->H, out->J, out->kI);
    return mbsri_verifier_settle(w, status, "jacobians", d * columns, out->K);
}

/* q' = G(q) u */
int mbsri_verifier_qdot(mbsri_verifier *w, const mbsri_place *at, const double *u)
{
    if (!w->joint->table->coordinate_rates) {
        mbsri_copy((size_t)w->n, u, w->qdot);
        return MBSR_OK;
    }
    const mbsr_joint_args args = mbsri_verifier_args(w, at, u, w->V_pred, w->V);
    mbsri_zero((size_t)w->nq, w->qdot);
    const int status = w->joint->table->coordinate_rates(&args, w->qdot);
    return mbsri_verifier_settle(w, status, "coordinate_rates", (size_t)w->nq, w->qdot);
}

/* ---- motions ---- */

void mbsri_verifier_move(const mbsri_verifier *w, const double *V, double s, double *p)
{
    const double rate = mbsri_turns(w->at->pred_space) ? mbsri_norm3(V) : 0.0;
    if (mbsri_turns(w->at->pred_space)) {
        for (int k = 3; k < w->d_pred; ++k) p[MBSR_POSE_X + k - 3] += s * V[k];
        if (!(rate > 0.0)) return;
        double R[9];
        const mbsr_frame turn = mbsr_frame_rotated(NULL, V, rate * s);
        mbsri_multiply3(turn.R, p + MBSR_POSE_R, R);
        mbsri_copy(9, R, p + MBSR_POSE_R);
    } else if (w->pred) {
        for (int k = 0; k < w->d_pred; ++k) p[k] += s * V[k];
    }
}

int mbsri_verifier_velocity(mbsri_verifier *w, const mbsri_jacobians *x, const double *u,
                            const double *V_pred, double *V)
{
    const int d = w->d;
    double *right = w->x;
    mbsri_copy((size_t)d * (size_t)d, x->K, w->inverse.K);
    const double rcond = mbsri_lapack_inverse(d, w->inverse.K, w->inverse.pivots, w->inverse.work);
    if (!(rcond > 1e-15)) {
        return mbsri_fail(w->error, MBSR_SINGULAR_K, MBSR_NONE, MBSR_NONE,
                          "mbsr_joint_verify: joint '%s': K is singular (reciprocal condition "
                          "%.2g)",
                          w->joint->table->name, rcond);
    }
    mbsri_copy((size_t)d, x->kI, right);
    mbsri_ax(d, w->d_pred, 1.0, x->H, V_pred, right);
    mbsri_ax(d, w->n, 1.0, x->J, u, right);
    mbsri_zero((size_t)d, V);
    mbsri_ax(d, d, -1.0, w->inverse.K, right, V);
    return MBSR_OK;
}

/* ---- the verdicts ---- */

/* Largest number of rows x columns, each divided by the size of its row. */
static double largest_of_rows(const mbsri_verifier *w, int columns, const double *x)
{
    double size = 0.0;
    for (int k = 0; k < columns * w->d; ++k)
        size = fmax(size, fabs(x[k]) / w->jacobians.row[k % w->d]);
    return size;
}

void mbsri_verifier_note(mbsri_verifier *w, double *field, double value, const char *format, ...)
{
    if (!(value <= *field)) *field = value;
    if (value <= w->errors->largest) return;
    w->errors->largest = value;
    va_list arguments;
    va_start(arguments, format);
    mbsri_vprint(w->errors->text, sizeof w->errors->text, format, arguments);
    va_end(arguments);
}

void mbsri_verifier_compare(mbsri_verifier *w, double *field, const char *name, int columns,
                            const double *given, const double *expected, double rate)
{
    if (columns > 0 && *field < 0.0) *field = 0.0;
    const double size =
        fmax(rate, fmax(largest_of_rows(w, columns, given), largest_of_rows(w, columns, expected)));
    for (int k = 0; k < columns * w->d && size > 0.0; ++k) {
        mbsri_verifier_note(w, field,
                            fabs(given[k] - expected[k]) / (w->jacobians.row[k % w->d] * size),
                            "%s(%d,%d) is %.9g, by differences %.9g", name, k % w->d, k / w->d,
                            given[k], expected[k]);
    }
}
