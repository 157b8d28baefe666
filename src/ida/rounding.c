/* Errors of momenta that are rounding.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The last digit of a coordinate, eps |q|, times a stiffness k is a force that no step makes
 * smaller. A step of length 1 / c takes it, or, where it is long, lets the momentum m c eps |q| of
 * a motion by that digit be left. Both are in
 *
 *   (., r_p, .) = K^-1 (c eps |q|, 0, 0),      |r_p| = k eps |q| c / (c^2 + k / m)
 *
 * for a mass m on k, with K = dF/dy + c dF/dy'. It is largest where c is w = sqrt(k / m): m w / 2
 * for each digit. With 1e12 N m/rad at 20 rad that is 15 times a tolerance of 1e-9. Error tests
 * fail there, whatever moves, shorter steps are taken, and the run stands still: beyond, where c is
 * smaller than w / 10, say, all is well. So an error in the momenta that rounding makes is none,
 * and what else it has is tested alone.
 *
 * The signs are those of the displacement that the error itself makes in a step: if rounding made
 * it, it did so by such digits. An error of a test is a difference of three or more states, and
 * has `several` times what is left in each. A stop that bears by its last digits is open in every
 * other step, and K knows nothing of it: what was found counts for some steps. */
#include "ida/stiff.h"

#include <ida/ida.h>

#include <float.h>
#include <math.h>

static const double several = 4.0;

/* Whether rounding of the coordinates, over a step, is anything beside the tolerances of the
 * velocities, which stand behind the momenta or are those. */
static bool is_seen(const mbsri_stiff *s, const double *y, double c)
{
    const double *weight = N_VGetArrayPointer(s->weight);
    const sunindextype all = N_VGetLength(s->weight), first = s->last < all ? s->last : s->first;
    double largest = 0.0, strictest = 0.0;
    for (int k = 0; k < s->first; ++k) largest = fmax(largest, fabs(y[k]));
    for (sunindextype k = first; k < all; ++k) strictest = fmax(strictest, weight[k]);
    return several * DBL_EPSILON * largest * c * strictest > 1.0;
}

/* The norm of r_p along the error x; 0 if the linear solver fails. */
static double left_along(mbsri_stiff *s, N_Vector x, const double *y, double c)
{
    double *to = N_VGetArrayPointer(s->filtered);
    if (mbsri_stiff_filter(s, x, NULL)) return 0.0;
    for (sunindextype k = 0; k < N_VGetLength(s->filtered); ++k)
        to[k] = k < s->first ? copysign(c * DBL_EPSILON * fabs(y[k]), to[k]) : 0.0;
    ++s->info.filter_solves;
    if (s->solve(s->filtered, s->memory)) return 0.0;
    return mbsri_stiff_momentum_norm(s, s->filtered);
}

bool mbsri_stiff_is_rounding(mbsri_stiff *s, N_Vector x)
{
    enum { STEPS = 10 };
    N_Vector state = NULL;
    const double c = fabs(s->now.c);
    if (IDAGetCurrentY(s->memory, &state) < 0) return false;
    const double *y = N_VGetArrayPointer(state);
    if (!is_seen(s, y, c)) return false;
    const double left = left_along(s, x, y, c);
    if (left >= s->rounding.norm || s->now.steps > s->rounding.at + STEPS) {
        s->rounding.norm = left;
        s->rounding.at = s->now.steps;
    }
    return mbsri_stiff_momentum_norm(s, x) <= several * s->rounding.norm;
}
