/* Factors of the equations of motion with loops: see fronts.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "algebra/dense.h"
#include "base/error.h"
#include "fronts/assemble.h"
#include "fronts/idle.h"
#include "recursion/backward.h"
#include "recursion/errors.h"
#include "recursion/group.h"
#include "recursion/pose.h"
#include "recursion/rank.h"
#include "recursion/rounding.h"

#include <math.h>

/* U, D, its rank and pseudo-inverse, and G of the joint. */
static int factor_joint(mbsri_fronts *w, int i)
{
    const mbsr_model *m = w->m;
    mbsr_data *d = w->d;
    const mbsri_body *b = m->body + i;
    const mbsri_group g = mbsri_group_of(m, d, i);
    double *U = d->U + b->dg, *G = d->G + b->dg, *D = d->D + b->nn;
    mbsri_symmetrise(b->d, d->Mbar + b->dd);
    mbsri_add_diagonal(b->d, 1.0, d->Mbar + b->dd, d->W + b->dd);
    mbsri_group_products(m, d, &g, d->Mbar, U, D, d->scratch);
    if (!d->armature) mbsri_group_add_armature(m, &g, D);
    for (int k = 0; k < b->n && d->armature; ++k) D[k * (b->n + 1)] += d->armature[b->iu + k];
    d->rank[i] = 0;
    d->scale[b->scalar_offset] = 0.0;
    const int status = b->n > 0 ? mbsri_rank_decision(m, d, &g, true) : MBSR_OK;
    mbsri_zero((size_t)(b->d * b->n), G);
    mbsri_ab(b->d, b->n, b->n, 1.0, U, d->Dinv + b->nn, G);
    return status;
}

static void begin_masses(mbsri_fronts *w)
{
    const mbsr_model *m = w->m;
    mbsr_data *d = w->d;
    mbsri_zero((size_t)m->root.d * (size_t)m->root.d, d->M);
    mbsri_zero(m->size.dd, d->W);
    if (d->armature)
        mbsri_zero(m->size.dd, d->Mbar);
    else
        mbsri_copy(m->size.dd, d->M, d->Mbar);
    for (int i = 0; i <= m->bodies; ++i)
        d->rotated[m->body[i].scalar_offset] =
            d->armature ? 0.0 : mbsri_own_rotated(m->body + i, d->M + m->body[i].dd);
}

static int eliminate(mbsri_fronts *w)
{
    if (!mbsri_fronts_begin(w)) return MBSR_ERR_NO_MEMORY;
    begin_masses(w);
    mbsri_zero((size_t)w->m->rows, w->share);
    w->lever = mbsri_longest_lever(w->m, w->d);
    for (int k = 0; k < w->plan->steps; ++k) {
        const int i = w->plan->step[k].body;
        if (!mbsri_fronts_assemble(w, k)) return MBSR_ERR_NO_MEMORY;
        if (i == 0) {
            if (!mbsri_fronts_leave(w, k)) return MBSR_ERR_NO_MEMORY;
            continue;
        }
        const int status = factor_joint(w, i);
        if (status) return status;
        if (!mbsri_fronts_pass(w, k)) return MBSR_ERR_NO_MEMORY;
        mbsri_pass_masses(w->m, w->d, i, false);
    }
    return mbsri_idle_find(w) ? MBSR_OK : MBSR_ERR_NO_MEMORY;
}

int mbsri_fronts_factor(mbsri_fronts *w, const double *armature, const char *function)
{
    mbsr_data *d = w->d;
    const bool single = d->single;
    if (d->stage > MBSRI_STAGE_FORCES) d->stage = MBSRI_STAGE_FORCES;
    d->single = true;
    d->armature = armature;
    w->frees = 0;
    const int status = eliminate(w);
    d->single = single;
    d->armature = NULL;
    if (status != MBSR_ERR_NO_MEMORY) return status;
    return mbsri_fail(&d->error, status, MBSR_NONE, MBSR_NONE,
                      "%s: no memory for the loops that are open at once", function);
}

/* The body whose joint has this rate. */
static int carrier_of(const mbsri_fronts *w, int rate)
{
    int i = 1;
    while (rate >= w->m->body[i].iu + w->m->body[i].n || rate < w->m->body[i].iu) ++i;
    return i;
}

int mbsri_fronts_free_rate(const mbsri_fronts *w)
{
    const int rate = w->free[w->frees - 1];
    const mbsri_body *b = w->m->body + carrier_of(w, rate);
    const double *x = w->d->X + b->nn + (size_t)((rate - b->iu) * b->n), *s = w->d->s + b->group.iu;
    int most = 0;
    for (int k = 0; k < b->n; ++k) {
        if (fabs(s[k] * x[k]) > fabs(s[most] * x[most])) most = k;
    }
    return b->u + most;
}

void mbsri_fronts_free_seed(const mbsri_fronts *w, int l, double *x)
{
    const int i = carrier_of(w, w->free[l]), first = w->m->body[i].iu;
    mbsri_zero((size_t)w->m->nu, x);
    mbsri_fronts_null_column(w, i, w->free[l] - first, x + first);
}
