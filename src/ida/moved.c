/* The error test of momenta where loops are closed.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The momentum of a joint is that of all bodies behind it, so what an error e_p means depends on where loops are
 * cut. Part of it, along the rows, moves nothing: loop forces take it. The rest moves all joints together, by
 *
 *   (., ., e_u, .) = K^-1 (0, c e_p, 0, 0),     K = dF/dy + c dF/dy',
 *
 * and e_u means the same wherever loops are cut. So it is tested in the place of e_p, by the tolerances of u. Only
 * where that is less: what moves hardly any mass, such as a slender rod on two balls that turns about itself, errs
 * in u by far more than others notice (see forms/scales.c).
 *
 * IDA compares errors of neighbouring orders with each other. They are much alike in direction: all of a test get
 * the share that is left of its first. */
#include "ida/stiff.h"

#include <ida/ida.h>
#include <nvector/nvector_serial.h>

/* Such errors may be smaller by this than others: with 1 the four-bar linkage of docs/closed_loops.md errs by
 * a fifth more than when e_p is tested, with 1.5 by less. */
static const double stricter = 1.5;

/* s->filtered becomes what the momenta of x, an error, move; nonzero if the linear solver fails. */
static int move(mbsri_stiff *s, N_Vector x, N_Vector id)
{
    const double *e = NV_DATA_S(x), *counts = NV_DATA_S(id);
    double *to = NV_DATA_S(s->filtered);
    for (sunindextype k = 0; k < NV_LENGTH_S(x); ++k) {
        const bool momentum = k >= s->first && k < s->last && counts[k] > 0.0;
        to[k] = momentum ? s->c * e[k] : 0.0;
    }
    ++s->info.filter_solves;
    return s->solve(s->filtered, s->memory);
}

/* The norm of x with e_u for e_p; negative if the linear solver fails. */
static double moved_norm(mbsri_stiff *s, N_Vector x, N_Vector w, N_Vector id)
{
    const int nu = s->last - s->first;
    const double *e = NV_DATA_S(x), *weight = NV_DATA_S(w);
    double *to = NV_DATA_S(s->filtered);
    if (move(s, x, id)) return -1.0;
    for (int k = 0; k < s->first; ++k) to[k] = e[k];
    for (int k = s->first; k < s->last; ++k) to[k] = to[k + nu] * weight[k + nu] / weight[k];
    return stricter * s->masked(s->filtered, w, id);
}

double mbsri_stiff_moved(mbsri_stiff *s, N_Vector x, N_Vector w, N_Vector id, bool first)
{
    const double plain = s->masked(x, w, id);
    if (!first) return s->share * plain;
    s->share = 1.0;
    if (s->iterates || s->c == 0.0) return plain;
    const double moved = moved_norm(s, x, w, id);
    if (moved >= 0.0 && moved < plain) s->share = moved / plain;
    return s->share * plain;
}
