/* How long a matrix of the plain iteration lives.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Stiff directions turn. A matrix of some steps ago is stiff across them, where only inertia resists,
 * and hardly corrects what is off there: the corrections are small, and pass for converged. IDA keeps
 * such a matrix until iterations fail. What is left meanwhile adds up, and excites what is stiff.
 *
 * Once a stiff direction has been seen to turn, ordinary steps therefore get a new matrix at the latest
 * when the one at hand is `life` steps old. Whether that is soon enough is measured: the last step of an
 * old matrix is corrected once more by the new one, by what the old one has left. `life` is halved where
 * that is much of what IDA lets be left, which is also a sign for careful steps, and doubled where it is
 * little; where each step has a matrix of its own every fifth is such a step instead. */
#include "ida/stiff.h"

#include <ida/ida.h>

#include <math.h>

enum { LONGEST = 64, BETWEEN = 5 };

double mbsri_stiff_left(const mbsri_stiff *s)
{
    return mbsri_stiff_momenta(s, s->change) / fabs(s->c);
}

int mbsri_stiff_improve(mbsri_stiff *s, N_Vector ee, double within)
{
    sunbooleantype current = SUNFALSE;
    int status = s->system(ee, s->change, s->memory);
    const bool renew = s->set_up && !(within > 0.0 && mbsri_stiff_left(s) <= within);
    if (!status && renew) status = s->set_up(SUNFALSE, &current, s->memory);
    s->untested = s->untested || renew;
    if (status) return status;
    ++s->iterations;
    N_VScale(-1.0, s->change, s->change);
    status = s->solve(s->change, s->memory);
    if (!status) N_VLinearSum(1.0, ee, 1.0, s->change, ee);
    return status;
}

bool mbsri_stiff_outlived(mbsri_stiff *s, bool set_up)
{
    const bool due = s->life > 0 && !s->iterates && s->steps >= s->made_at + s->life;
    s->measures = due && !set_up && (s->life > 1 || s->steps >= s->measured_at + BETWEEN);
    if (s->measures || !(set_up || due)) return false;
    s->made_at = s->steps;
    return true;
}

int mbsri_stiff_measure(mbsri_stiff *s, N_Vector ee, N_Vector w, double tolerance)
{
    static const double much = 0.25, little = 0.08;
    s->misled = false;
    if (s->stale > 0) s->made_at = s->steps;
    if (!s->measures || s->stale > 0) return 0;
    const int status = mbsri_stiff_improve(s, ee, 0.0);
    if (status) return status;
    s->made_at = s->measured_at = s->steps;
    s->hides = false;
    const double left = N_VWrmsNorm(s->change, w);
    s->misled = left > much * tolerance;
    if (s->misled && s->life > 1) s->life /= 2;
    if (left < little * tolerance && s->life < LONGEST) s->life *= 2;
    return 0;
}
