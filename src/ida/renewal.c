/* When Newton's method gets a new matrix.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * IDA keeps a matrix until h has changed or Newton's method does not converge. By then bodies have
 * turned away from it, and a test of the norm of corrections does not see how little is corrected
 * along light directions, or across stiff ones, where only inertia resists. What is left adds up.
 * So matrices are renewed when they are due, at an age in steps that is learned from what old ones
 * leave, compared with new ones.
 *
 * Light directions: of the spin of a rod between two ball joints, 1/57 of its inertia across,
 * hardly anything is corrected. What is left alternates from step to step, and the prediction of
 * order 5 multiplies that by 63: it grows until error tests fail, and there are twice as many
 * steps. On the tree a matrix takes no more than two residuals. So steps begin with a new one where
 * the first correction d, solved for with both,
 *
 *   r = |d_old - d_new| / |d_new|,
 *
 * is to reach a given share, which is what the next iteration with the old one would have to
 * correct. The iterations of such a step converge quadratically, |d2| = a |d1|^2, and one is mostly
 * all.
 *
 * Stiff directions: once one has been seen to turn, ordinary steps get a new matrix at the latest
 * when the one at hand is `life` steps old, however dear. The last step of an old one is corrected
 * once more by the new one. `life` is halved where that is much of what IDA lets be left, which is
 * also a sign for careful steps, and doubled where it is little; where each step has a matrix of
 * its own every fifth is such a step instead. */
#include "ida/stiff.h"

#include <ida/ida.h>
#include <nvector/nvector_serial.h>

#include <math.h>

/* ---- one iteration ---- */

int mbsri_stiff_evaluate(mbsri_stiff *s, N_Vector ee)
{
    const int status = s->system(ee, s->change, s->memory);
    if (!status) N_VScale(-1.0, s->change, s->change);
    return status;
}

static int factor_matrix(mbsri_stiff *s)
{
    sunbooleantype current = SUNFALSE;
    s->control.matrices.untested = true;
    mbsri_stiff_note_matrix(s);
    return s->set_up(SUNFALSE, &current, s->memory);
}

void mbsri_stiff_note_matrix(mbsri_stiff *s)
{
    s->made.step = s->now.steps;
    s->made.c = s->now.c;
}

double mbsri_stiff_momenta(const mbsri_stiff *s, N_Vector x)
{
    const double *value = NV_DATA_S(x), *weight = NV_DATA_S(s->weight);
    double sum = 0.0;
    for (int k = s->first; k < s->last; ++k) {
        const double e = value[k] * weight[k];
        sum += e * e;
    }
    return sqrt(sum / (double)NV_LENGTH_S(x));
}

double mbsri_stiff_left(const mbsri_stiff *s)
{
    return mbsri_stiff_momenta(s, s->change) / fabs(s->now.c);
}

int mbsri_stiff_solve(mbsri_stiff *s, N_Vector b)
{
    static const double share = 0.3;
    const double c = fabs(s->now.c);
    if (!s->control.looks || c == 0.0) return s->solve(b, s->memory);
    const double before = mbsri_stiff_momenta(s, b) / c;
    const int status = s->solve(b, s->memory);
    s->now.hides = before > 1.0 && mbsri_stiff_momenta(s, b) < share * before;
    return status;
}

/* s->change is solved for, and ee changes by it. */
static int correct(mbsri_stiff *s, N_Vector ee)
{
    ++s->now.iterations;
    const int status = mbsri_stiff_solve(s, s->change);
    if (!status) N_VLinearSum(1.0, ee, 1.0, s->change, ee);
    return status;
}

int mbsri_stiff_correct(mbsri_stiff *s, N_Vector ee, double within)
{
    const bool renew = s->set_up && !(within > 0.0 && mbsri_stiff_left(s) <= within);
    const int status = renew ? factor_matrix(s) : 0;
    return status ? status : correct(s, ee);
}

/* Both. */
static int improve(mbsri_stiff *s, N_Vector ee, double within)
{
    const int status = mbsri_stiff_evaluate(s, ee);
    return status ? status : mbsri_stiff_correct(s, ee, within);
}

/* ---- light directions ---- */

/* The first iteration, with a new matrix, and an old one to compare it with. */
static int begin_iteration(mbsri_stiff *s, N_Vector ee)
{
    int status = mbsri_stiff_evaluate(s, ee);
    if (status) return status;
    N_VScale(1.0, s->change, s->error);
    ++s->info.renewals;
    status = s->solve(s->error, s->memory);
    if (!status) status = factor_matrix(s);
    if (!status) status = correct(s, ee);
    if (status) return status;
    const double size = N_VWrmsNorm(s->change, s->weight);
    N_VLinearSum(1.0, s->error, -1.0, s->change, s->error);
    mbsri_control_plan(&s->control, s->now.steps, N_VWrmsNorm(s->error, s->weight), size);
    return MBSR_OK;
}

int mbsri_stiff_settle(mbsri_stiff *s, N_Vector ee, double before, double tolerance, bool fresh)
{
    enum { MOST = 3 };
    static const double slow = 0.9;
    for (int k = 0; k < MOST; ++k) {
        const int status = improve(s, ee, INFINITY);
        if (status) return status;
        const double size = N_VWrmsNorm(s->change, s->weight), rate = size / before;
        if (k == 0 && fresh) mbsri_control_rate(&s->control, rate / before);
        if (rate >= slow) break;
        if (rate / (1.0 - rate) * size <= tolerance) return SUN_NLS_SUCCESS;
        before = size;
    }
    return SUN_NLS_CONV_RECVR;
}

int mbsri_stiff_begin_anew(mbsri_stiff *s, N_Vector ee, double tolerance)
{
    static const double share = 0.1, small = 0.05;
    int status = begin_iteration(s, ee);
    if (status) return status;
    const double size = N_VWrmsNorm(s->change, s->weight);
    if (size <= small * tolerance) return SUN_NLS_SUCCESS;
    if (mbsri_control_predicts(&s->control, size, share * tolerance)) return SUN_NLS_SUCCESS;
    status = mbsri_stiff_settle(s, ee, size, tolerance, true);
    if (status == SUN_NLS_CONV_RECVR) ++s->now.failures;
    return status;
}

/* ---- stiff directions ---- */

/* The last step of a matrix: ee is improved by a new one; *much: the old one had left much. */
static int compare(mbsri_stiff *s, N_Vector ee, double tolerance, bool *much)
{
    const int status = improve(s, ee, 0.0);
    if (status) return status;
    const double left = N_VWrmsNorm(s->change, s->weight) / tolerance;
    s->now.hides = false;
    *much = mbsri_control_compared(&s->control, s->now.steps, left);
    return SUN_NLS_SUCCESS;
}

int mbsri_stiff_judge(mbsri_stiff *s, mbsri_matrix matrix, int status, N_Vector ee,
                      double tolerance)
{
    bool wrong = s->now.stale > 0;
    if (wrong)
        mbsri_control_stale(&s->control, s->now.steps);
    else if (!status && matrix == MBSRI_MATRIX_LAST)
        status = compare(s, ee, tolerance, &wrong);
    if (!status && wrong && !s->control.iterates && mbsri_stiff_moves(s, ee))
        mbsri_stiff_note(s, MBSRI_SIGN_TURNED);
    return status;
}
