/* When Newton's method gets a new matrix.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * IDA keeps a matrix until h has changed or Newton's method does not converge. By then bodies have turned away from it, and
 * a test of the norm of corrections does not see how little is corrected along light directions, or across stiff ones,
 * where only inertia resists. What is left adds up. So matrices are renewed when they are due, at an age in steps that is
 * learned from what old ones leave, compared with new ones.
 *
 * Light directions: of the spin of a rod between two ball joints, 1/57 of its inertia across, hardly anything is corrected.
 * What is left alternates from step to step, and the prediction of order 5 multiplies that by 63: it grows until error
 * tests fail, and there are twice as many steps. On the tree a matrix takes no more than two residuals. So steps begin
 * with a new one where the first correction d, solved for with both,
 *
 *   r = |d_old - d_new| / |d_new|,
 *
 * is to reach a given share, which is what the next iteration with the old one would have to correct. The
 * iterations of such a step converge quadratically, |d2| = a |d1|^2, and one is mostly all.
 *
 * Stiff directions: once one has been seen to turn, ordinary steps get a new matrix at the latest when the one at hand
 * is `life` steps old, however dear. The last step of an old one is corrected once more by the new one. `life` is halved
 * where that is much of what IDA lets be left, which is also a sign for careful steps, and doubled where it is
 * little; where each step has a matrix of its own every fifth is such a step instead. */
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

static int factor(mbsri_stiff *s)
{
    sunbooleantype current = SUNFALSE;
    s->untested = true;
    return s->set_up(SUNFALSE, &current, s->memory);
}

/* s->change is solved for, and ee changes by it. */
static int correct(mbsri_stiff *s, N_Vector ee)
{
    ++s->iterations;
    const int status = mbsri_stiff_solve(s, s->change);
    if (!status) N_VLinearSum(1.0, ee, 1.0, s->change, ee);
    return status;
}

double mbsri_stiff_left(const mbsri_stiff *s)
{
    return mbsri_stiff_momenta(s, s->change) / fabs(s->c);
}

int mbsri_stiff_correct(mbsri_stiff *s, N_Vector ee, double within)
{
    const bool renew = s->set_up && !(within > 0.0 && mbsri_stiff_left(s) <= within);
    const int status = renew ? factor(s) : 0;
    return status ? status : correct(s, ee);
}

int mbsri_stiff_improve(mbsri_stiff *s, N_Vector ee, double within)
{
    const int status = mbsri_stiff_evaluate(s, ee);
    return status ? status : mbsri_stiff_correct(s, ee, within);
}

/* ---- which matrix ---- */

/* Where a stiff direction turns, steps are to be careful, and it is old matrices that tell (iteration.c): they are
 * kept at first, and for some time after careful steps. */
static bool is_calm(const mbsri_stiff *s)
{
    enum { FIRST = 100, CALM = 500 };
    if (s->careful_until > 0) return s->steps >= s->careful_until + CALM;
    return !s->looks || s->steps >= FIRST;
}

/* One is made in this attempt. */
static void note_new(mbsri_stiff *s)
{
    s->age = 0;
    s->made_at = s->steps;
}

mbsri_matrix mbsri_stiff_choose(mbsri_stiff *s, bool set_up)
{
    enum { BETWEEN = 5 };
    ++s->age;
    if (set_up) note_new(s);
    if (s->wrong > 0.0 && s->set_up && !s->dear && s->age >= s->due && is_calm(s))
        return MBSRI_MATRIX_BEGIN;
    if (set_up) return MBSRI_MATRIX_NEW;
    if (s->life == 0 || s->iterates || s->steps < s->made_at + s->life) return MBSRI_MATRIX_OLD;
    if (s->life > 1 || s->steps >= s->measured_at + BETWEEN) return MBSRI_MATRIX_LAST;
    note_new(s);
    return MBSRI_MATRIX_NEW;
}

/* ---- light directions ---- */

/* The age of the next matrix, from what the one of this age has made of the correction s->change: s->error. */
static void plan(mbsri_stiff *s, N_Vector w)
{
    static const double longest = 32.0;
    const double size = N_VWrmsNorm(s->change, w);
    N_VLinearSum(1.0, s->error, -1.0, s->change, s->error);
    const double off = N_VWrmsNorm(s->error, w), most = fmin(longest, 2.0 * s->age);
    s->due = off * most > s->age * s->wrong * size ? s->age * s->wrong * size / off : most;
    note_new(s);
}

/* The first iteration, with a new matrix, and an old one to compare it with. */
static int begin(mbsri_stiff *s, N_Vector ee, N_Vector w)
{
    int status = mbsri_stiff_evaluate(s, ee);
    if (status) return status;
    N_VScale(1.0, s->change, s->error);
    ++s->info.renewals;
    status = s->solve(s->error, s->memory);
    if (!status) status = factor(s);
    if (!status) status = correct(s, ee);
    if (!status) plan(s, w);
    return status;
}

int mbsri_stiff_begin_anew(mbsri_stiff *s, N_Vector ee, N_Vector w, double tolerance)
{
    enum { MOST = 4, MEASURED = 10 };
    static const double share = 0.1, small = 0.05, slow = 0.9;
    int status = begin(s, ee, w);
    if (status) return status;
    double before = N_VWrmsNorm(s->change, w);
    if (before <= small * tolerance) return SUN_NLS_SUCCESS;
    if (s->rated > 0 && s->quadratic * before * before <= share * tolerance) {
        --s->rated;
        return SUN_NLS_SUCCESS;
    }
    for (int k = 2; k <= MOST; ++k) {
        status = mbsri_stiff_improve(s, ee, INFINITY);
        if (status) return status;
        const double size = N_VWrmsNorm(s->change, w), rate = size / before;
        if (k == 2) {
            s->quadratic = rate / before;
            s->rated = MEASURED;
        }
        if (rate >= slow) break;
        if (rate / (1.0 - rate) * size <= tolerance) return SUN_NLS_SUCCESS;
        before = size;
    }
    ++s->failures;
    return SUN_NLS_CONV_RECVR;
}

/* ---- stiff directions ---- */

/* The last step of a matrix: ee is improved by a new one; *much: the old one had left much. */
static int compare(mbsri_stiff *s, N_Vector ee, N_Vector w, double tolerance, bool *much)
{
    enum { LONGEST = 64 };
    static const double most = 0.25, little = 0.08;
    const int status = mbsri_stiff_improve(s, ee, 0.0);
    if (status) return status;
    note_new(s);
    s->measured_at = s->steps;
    s->hides = false;
    const double left = N_VWrmsNorm(s->change, w);
    *much = left > most * tolerance;
    if (*much && s->life > 1) s->life /= 2;
    if (left < little * tolerance && s->life < LONGEST) s->life *= 2;
    return SUN_NLS_SUCCESS;
}

/* A stiff direction has turned. Matrices that are not quite old enough to fail mislead the plain iteration: twice within some steps,
 * and the next ones are careful, and matrices live shortly afterwards. */
static void note_turn(mbsri_stiff *s)
{
    enum { SOON = 30 };
    if (s->turned_at >= 0 && s->steps - s->turned_at < SOON) {
        ++s->info.stiff_iterations;
        mbsri_stiff_try(s);
        s->life = 1;
    }
    s->turned_at = s->steps;
}

int mbsri_stiff_judge(mbsri_stiff *s, mbsri_matrix matrix, int status, N_Vector ee, N_Vector w,
                      double tolerance)
{
    bool wrong = s->stale > 0;
    if (wrong) {
        note_new(s);
        s->due = 1.0;
    } else if (!status && matrix == MBSRI_MATRIX_LAST) {
        status = compare(s, ee, w, tolerance, &wrong);
    }
    if (!status && wrong && !s->iterates && mbsri_stiff_moves(s, ee)) note_turn(s);
    return status;
}
