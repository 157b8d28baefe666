/* What stiff directions leave of an error.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * In the direction of a stiff, damped element BDF of order k gives the momentum an offset of
 * O(h^k), of order 1 about m a h / 2, which jumps when h changes. IDA takes the jump for an error
 * that shrinks with the step, and it does not: tests fail again and again, and the order stays 1.
 * But the offset does no harm: the next implicit step forgets it. So what is tested of an error e_p
 * of the momenta is what is left of it after one such step, with K = dF/dy + c dF/dy'
 *
 *   (., e_p', .) = K^-1 (0, c e_p, 0)
 *
 * In other directions K^-1 c is 1 but for O(h). Errors of q are tested as they are: they have no
 * offset, and q and p together would not do, for e_q / h would come with p. */
#include "ida/stiff.h"

#include <ida/ida.h>
#include <nvector/nvector_serial.h>

#include <math.h>

static bool is_momentum(const mbsri_stiff *s, sunindextype k)
{
    return k >= s->first && k < s->last;
}

int mbsri_stiff_filter(mbsri_stiff *s, N_Vector x, N_Vector right)
{
    const double *e = NV_DATA_S(x), *counts = NV_DATA_S(s->id);
    double *to = NV_DATA_S(s->filtered);
    for (sunindextype k = 0; k < NV_LENGTH_S(x); ++k)
        to[k] = is_momentum(s, k) && counts[k] > 0.0 ? s->now.c * e[k] : 0.0;
    const int status = s->weigh ? s->weigh(s->user, s->filtered) : 0;
    if (status) return status;
    if (right) N_VScale(1.0, s->filtered, right);
    ++s->info.filter_solves;
    return s->solve(s->filtered, s->memory);
}

double mbsri_stiff_filtered_norm(mbsri_stiff *s, N_Vector x)
{
    const double *e = NV_DATA_S(x);
    double *to = NV_DATA_S(s->filtered);
    if (mbsri_stiff_filter(s, x, NULL)) return -1.0;
    for (sunindextype k = 0; k < NV_LENGTH_S(x); ++k)
        if (!is_momentum(s, k)) to[k] = e[k];
    return s->masked(s->filtered, s->weight, s->id);
}

double mbsri_stiff_momentum_norm(mbsri_stiff *s, N_Vector x)
{
    const double *from = NV_DATA_S(x);
    double *to = NV_DATA_S(s->change);
    for (sunindextype k = 0; k < NV_LENGTH_S(x); ++k) to[k] = is_momentum(s, k) ? from[k] : 0.0;
    return s->masked(s->change, s->weight, s->id);
}

double mbsri_stiff_coordinate_norm(mbsri_stiff *s, N_Vector x)
{
    double *to = N_VGetArrayPointer(s->change);
    N_VScale(1.0, x, s->change);
    for (int k = s->first; k < s->last; ++k) to[k] = 0.0;
    return s->masked(s->change, s->weight, s->id);
}

bool mbsri_stiff_moves(mbsri_stiff *s, N_Vector x)
{
    static const double left = 0.3;
    if (s->test != MBSRI_TEST_FILTERED || !s->id || mbsri_stiff_filter(s, x, NULL)) return false;
    return mbsri_stiff_momentum_norm(s, s->filtered) < left * mbsri_stiff_momentum_norm(s, x);
}

void mbsri_stiff_keep(mbsri_stiff *s, N_Vector x, bool of_iteration)
{
    N_Vector y = NULL;
    s->blame.of_iteration = of_iteration;
    if (IDAGetCurrentY(s->memory, &y) < 0 || IDAGetCurrentTime(s->memory, &s->blame.at) < 0) return;
    N_VScale(1.0, x, s->blame.direction);
    N_VScale(1.0, y, s->blame.state);
}

void mbsri_stiff_note(mbsri_stiff *s, mbsri_sign sign)
{
    const bool enough = mbsri_control_note(&s->control, s->now.steps, sign, 1.0);
    if (enough && sign != MBSRI_SIGN_TURNS) ++s->info.stiff_iterations;
}

/* ---- where loops are closed ----
 *
 * The momentum of a joint is that of all bodies behind it, so what an error e_p means depends on
 * where loops are cut. Part of it, along the rows, moves nothing: loop forces take it. The rest
 * moves all joints together, by
 *
 *   (., ., e_u, .) = K^-1 (0, c e_p, 0, 0),
 *
 * and e_u means the same wherever loops are cut. So it is tested in the place of e_p, by the
 * tolerances of u. Only where that is less: what moves hardly any mass, such as a slender rod on
 * two balls that turns about itself, errs in u by far more than others notice (see forms/scales.c).
 *
 * IDA compares errors of neighbouring orders with each other. They are much alike in direction: all
 * of a test get the share that is left of its first. Such errors may be smaller by `stricter` than
 * others: with 1 the four-bar linkage of docs/closed_loops.md errs by a fifth more than when e_p is
 * tested, with 1.5 by less. */
static const double stricter = 1.5;

/* The norm of x with e_u for e_p; negative if the linear solver fails. */
static double moved_norm(mbsri_stiff *s, N_Vector x)
{
    const int nu = s->last - s->first;
    const double *e = NV_DATA_S(x), *weight = NV_DATA_S(s->weight);
    double *to = NV_DATA_S(s->filtered);
    if (mbsri_stiff_filter(s, x, NULL)) return -1.0;
    for (int k = 0; k < s->first; ++k) to[k] = e[k];
    for (int k = s->first; k < s->last; ++k) to[k] = to[k + nu] * weight[k + nu] / weight[k];
    return stricter * s->masked(s->filtered, s->weight, s->id);
}

double mbsri_stiff_moved(mbsri_stiff *s, N_Vector x, bool first)
{
    const double plain = s->masked(x, s->weight, s->id);
    double *share = &s->now.share;
    if (!first) return *share * plain;
    *share = 1.0;
    if (s->control.iterates || s->now.c == 0.0) return plain;
    const double moved = moved_norm(s, x);
    if (moved >= 0.0 && moved < plain) *share = moved / plain;
    return *share * plain;
}
