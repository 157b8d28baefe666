/* Steps of IDA that begin with a new matrix of Newton's method.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * IDA keeps a matrix until h has changed or Newton's method does not converge. By then bodies have turned away from it, and
 * a test of the norm of corrections does not see how little is corrected along light directions: of the spin of a rod
 * between two ball joints, 1/57 of its inertia across, hardly anything. What is left alternates from step to step, and the
 * prediction of order 5 multiplies that by 63: it grows until error tests fail, and there are twice as many steps.
 * On the tree a matrix takes no more than two residuals. So steps begin with a new one where the old one has become
 * too wrong, which is measured: the first correction d is solved for with both, and
 *
 *   r = |d_old - d_new| / |d_new|
 *
 * is what the next iteration with the old one would have to correct. It grows with the age of the matrix, so that the
 * next is due at the age at which r is a given share. The iterations of such a step converge quadratically,
 * |d2| = a |d1|^2, and one is mostly all. */
#include "ida/stiff.h"

#include <ida/ida.h>
#include <nvector/nvector_serial.h>
#include <sunnonlinsol/sunnonlinsol_newton.h>

#include <math.h>

/* Where a stiff direction turns, steps are to be careful, and it is old matrices that tell (iteration.c): they are
 * kept at first, and for some time after careful steps. */
static bool is_calm(const mbsri_stiff *s)
{
    enum { FIRST = 100, CALM = 500 };
    if (s->careful_until > 0) return s->steps >= s->careful_until + CALM;
    return !s->looks || s->steps >= FIRST;
}

bool mbsri_stiff_is_due(mbsri_stiff *s, bool set_up)
{
    s->age = set_up ? 0 : s->age + 1;
    return s->wrong > 0.0 && s->set_up && !s->dear && s->age >= s->due && is_calm(s);
}

void mbsri_stiff_note_age(mbsri_stiff *s)
{
    if (s->stale == 0) return;
    s->age = 0;
    s->due = 1.0;
}

/* The age of the next matrix, from what the one of this age has made of the correction s->change: s->error. */
static void plan(mbsri_stiff *s, N_Vector w)
{
    static const double longest = 32.0;
    const double size = N_VWrmsNorm(s->change, w);
    N_VLinearSum(1.0, s->error, -1.0, s->change, s->error);
    const double off = N_VWrmsNorm(s->error, w), most = fmin(longest, 2.0 * s->age);
    s->due = off * most > s->age * s->wrong * size ? s->age * s->wrong * size / off : most;
}

/* ee changes by s->change. */
static int correct(mbsri_stiff *s, N_Vector ee, N_Vector w, bool anew)
{
    sunbooleantype current = SUNFALSE;
    int status = s->system(ee, s->change, s->memory);
    if (status) return status;
    ++s->iterations;
    N_VScale(-1.0, s->change, s->change);
    if (anew) {
        N_VScale(1.0, s->change, s->error);
        status = s->solve(s->error, s->memory);
        ++s->info.renewals;
        if (!status) status = s->set_up(SUNFALSE, &current, s->memory);
        s->untested = true;
    }
    if (!status) status = mbsri_stiff_solve(s, s->change);
    if (status) return status;
    if (anew) plan(s, w);
    N_VLinearSum(1.0, ee, 1.0, s->change, ee);
    return SUN_NLS_SUCCESS;
}

int mbsri_stiff_begin_anew(mbsri_stiff *s, N_Vector ee, N_Vector w, double tolerance)
{
    enum { MOST = 4, MEASURED = 10 };
    static const double share = 0.1, small = 0.05, slow = 0.9;
    double before = 0.0;
    for (int k = 1; k <= MOST; ++k) {
        const bool first = k == 1;
        const int status = correct(s, ee, w, first);
        if (status) return status;
        const double size = N_VWrmsNorm(s->change, w), rate = first ? 0.0 : size / before;
        if (first) {
            s->age = 0;
            if (size <= small * tolerance) return SUN_NLS_SUCCESS;
            if (s->rated > 0 && s->quadratic * size * size <= share * tolerance) {
                --s->rated;
                return SUN_NLS_SUCCESS;
            }
        } else if (k == 2) {
            s->quadratic = rate / before;
            s->rated = MEASURED;
        }
        if (rate >= slow) break;
        if (!first && rate / (1.0 - rate) * size <= tolerance) return SUN_NLS_SUCCESS;
        before = size;
    }
    ++s->failures;
    return SUN_NLS_CONV_RECVR;
}
