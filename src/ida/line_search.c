/* How far a correction of Newton's method goes where a force has a kink.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The force of a cable, a stop or a contact has a kink where it lets go, and where its damper holds
 * no more. From the slack side Newton's method sees nothing stiff and flies far beyond the kink;
 * from there it comes back to the slack side, as the force is concave, and so on: no length of the
 * step changes that. Forces balance somewhere between such two points. Along a correction d
 *
 *   w(x) = -d_u . F_p(x),     d_u the velocities in d, F_p the balance of momenta in the residual,
 *
 * is the power of what is out of balance, which falls monotonically from w > 0 at the last point
 * for all forces that resist. Where it comes out at the next point with the opposite sign and not
 * much smaller, d is shortened to where w vanishes.
 *
 * Beyond the kink w is steep and nearly straight: the line through two points there is followed as
 * long as that halves what is enclosed, else it is halved itself. Where rounding of coordinates
 * makes a step of w, nothing vanishes. The correction is taken as it is then, the first time: what
 * it leaves may be rounding alone, of a stop that bears a load. */
#include "ida/stiff.h"

#include <math.h>

/* A point x = ee - back d and w there. */
typedef struct point {
    double back, power;
} point;

/* s->trial becomes x, s->change -F there. */
static int evaluate_point(mbsri_stiff *s, N_Vector ee, point *x)
{
    N_VLinearSum(1.0, ee, -x->back, s->filtered, s->trial);
    const int status = mbsri_stiff_evaluate(s, s->trial);
    if (!status) x->power = mbsri_stiff_power(s, s->filtered, s->change);
    return status;
}

/* Where the line through two points on the far side meets zero, if that is between near and far;
 * else half-way. */
static double propose(const point *near, const point *far, const point *farther)
{
    const double slope = (farther->power - far->power) / (farther->back - far->back),
                 zero = far->back - far->power / slope;
    return zero > far->back && zero < near->back ? zero : 0.5 * (near->back + far->back);
}

/* Between near and far, where w > 0 and < 0: a point where |w| <= small, or where the momenta left
 * are `enough`. *found: whether there is one. */
static int enclose(mbsri_stiff *s, N_Vector ee, point near, point far, double small, double enough,
                   bool *found)
{
    enum { MOST = 40 };
    point farther = far;
    bool halve = true;
    for (int k = 0; k < MOST; ++k) {
        const double width = near.back - far.back;
        point x = {halve ? 0.5 * (near.back + far.back) : propose(&near, &far, &farther), 0.0};
        const int status = evaluate_point(s, ee, &x);
        if (status) return status;
        *found = fabs(x.power) <= small || mbsri_stiff_left(s) <= enough;
        if (*found || x.power == near.power || x.power == far.power) break;
        if (x.power > 0.0) {
            near = x;
        } else {
            farther = far;
            far = x;
        }
        halve = far.back == farther.back || (!halve && near.back - far.back > 0.5 * width);
    }
    return 0;
}

int mbsri_stiff_search(mbsri_stiff *s, N_Vector ee, double before, double enough, bool stay,
                       mbsri_search *found)
{
    static const double over = 0.5, little = 0.1;
    const point near = {1.0, before}, far = {0.0, mbsri_stiff_power(s, s->filtered, s->change)};
    bool balanced = false;
    *found = MBSRI_SEARCH_NONE;
    if (!(before > 0.0 && far.power < -over * before) || mbsri_stiff_left(s) <= enough) return 0;
    const int status = enclose(s, ee, near, far, little * before, enough, &balanced);
    if (status) return status;
    *found = balanced ? MBSRI_SEARCH_BALANCED : MBSRI_SEARCH_IN_VAIN;
    if (!balanced && stay) return mbsri_stiff_evaluate(s, ee);
    N_VScale(1.0, s->trial, ee);
    return 0;
}
