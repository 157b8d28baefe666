/* The rank decision: what counts as inertia, for all engines alike.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * lambda is an eigenvalue of a joint block D, or D itself where there is one rate, and `noise` what
 * was added up on the way to it: S^T W S, with W of backward.c, which is at least S^T Diag(Mbar) S.
 * Sums in double precision leave errors of some 1e-16 of that. So lambda is
 *
 *   known     to nine digits, where lambda > known noise             known   = 1e-6
 *   nothing   but rounding, where |lambda| <= nothing noise
 *       nothing = 3e-4 tolerance = 3e-16
 *   unclear   between: the masses run once more in twofold precision (exact.c), after which errors
 *       of
 *             sums count as 3e-4 of what they were, and
 *   inertia   if lambda > tolerance of the noise that is left        tolerance = 1e-12
 *
 * Errors that a slender body behind the joint makes larger may be far above the sums at the joint's
 * own body, local = S^T Diag(Mbar) S. They are seldom as large as they may be, and would hide an
 * inertia; so for what is nothing they count up to a thousand times local.
 *
 * Tolerance is the model's; with a larger one the first limit is ten times that. The engines differ
 * in how they come by the noise: rank.c has W, as do the vectorised sweeps where they carry it
 * (`judge`); mostly these have a bound of W only (`certify`), larger by orders of magnitude. There
 * lambda is known where it is beyond by_bound = 1e-8 of the bound, and beyond `known` of the sums
 * it comes from at this body. Where joints of several axes are taken apart (batch/), every part
 * adds to the bound what the joint in one piece does once, and by_parts = 1e-11 of it is about the
 * same. */
#ifndef MBSRI_RANK_RULE_H
#define MBSRI_RANK_RULE_H

#include <math.h>
#include <stdbool.h>

/* What counts as an error after sums in twofold precision, as a share of what does in double. */
#define MBSRI_EXACT_SHARE 3e-4

/* How many times as large as what is added up at a body errors that come from behind it may count.
 */
#define MBSRI_FROM_BEHIND 1000.0

/* Beyond this part of what was added up a sum is known to nine digits. */
#define MBSRI_NINE_DIGITS 1e-6

typedef struct mbsri_rank_rule {
    double tolerance, known, by_bound, by_parts, nothing;
} mbsri_rank_rule;

static inline mbsri_rank_rule mbsri_rank_rule_of(double tolerance)
{
    const double wide = 10.0 * tolerance;
    return (mbsri_rank_rule){.tolerance = tolerance,
                             .known = wide > MBSRI_NINE_DIGITS ? wide : MBSRI_NINE_DIGITS,
                             .by_bound = wide > 1e-8 ? wide : 1e-8,
                             .by_parts = wide,
                             .nothing = MBSRI_EXACT_SHARE * tolerance};
}

static inline bool mbsri_is_known(const mbsri_rank_rule *rule, double lambda, double noise)
{
    return lambda > rule->known * noise;
}

/* bound: of the noise; local: at least S^T Diag(Mbar) S. */
static inline bool mbsri_is_known_by_bound(const mbsri_rank_rule *rule, double lambda, double bound,
                                           double local)
{
    return lambda > rule->by_bound * bound && lambda > MBSRI_NINE_DIGITS * local;
}

static inline bool mbsri_is_nothing(const mbsri_rank_rule *rule, double lambda, double noise,
                                    double local)
{
    return !(fabs(lambda) > rule->nothing * fmin(noise, MBSRI_FROM_BEHIND * local));
}

/* After sums whose errors are `noise` times the tolerance. */
static inline bool mbsri_is_inertia(const mbsri_rank_rule *rule, double lambda, double noise)
{
    return lambda > rule->tolerance * noise;
}

#endif
