/* Central differences of fourth order,
 *
 *   df/dx = (-f(x + 2h) + 8 f(x + h) - 8 f(x - h) + f(x - 2h)) / (12 h) + O(h^4)
 *
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_DIFFERENCES_H
#define MBSRI_DIFFERENCES_H

#include <math.h>

/* Number l of the four: x + place h, with this weight, to be divided by 12 h. Summed in this order,
 * differences of a function that does not change are zero, without rounding errors. */
static inline double mbsri_difference_place(int l)
{
    static const double place[] = {1.0, -1.0, 2.0, -2.0};
    return place[l];
}

static inline double mbsri_difference_weight(int l)
{
    static const double weight[] = {8.0, -8.0, -1.0, 1.0};
    return weight[l];
}

/* The power of 16 in (span / 4, 4 span]: one step for all models of about one size. */
static inline double mbsri_binary(double span)
{
    int exponent;
    frexp(span, &exponent);
    return ldexp(1.0, 4 * (int)floor((exponent + 1) / 4.0));
}

/* The step h that balances the error h^4 with that of rounding in numbers of size x, for functions
 * that change over some tenths of `span`. A power of two, so that x + h is exact. */
static inline double mbsri_difference_step(double x, double span)
{
    const double unit = mbsri_binary(span);
    int exponent;
    frexp(1.0 + fabs(x) / unit, &exponent);
    return ldexp(unit, exponent / 5 - 12);
}

/* ---- slopes of forces that nothing is known of: steps a decade apart ---- */

/* In decades of the size of the state; the last of them at which no failure is excused. */
enum { MBSRI_LOWEST_DECADE = -11, MBSRI_NEAR_DECADE = -5, MBSRI_HIGHEST_DECADE = 6 };

/* Rounding in difference quotient number `at` of `count`, the step being `share` times `unit`, the
 * size of the state; `size` is that of what was added up to the forces. They may cancel within an
 * element, unseen: they count as some tens of times the largest slope at steps up to a thousand
 * times as long. slopes: every `stride`-th number. */
double mbsri_slope_noise(int count, int at, int stride, const double *slopes, double size,
                         double share, double unit);

#endif
