/* The forward recursion of the vectorised sweeps, root to leaves: A, u'.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_SWEEPS_FORWARD_H
#define MBSRI_SWEEPS_FORWARD_H

#include "algebra/dense.h"
#include "recursion/forward.h"
#include "sweeps/block.h"
#include "sweeps/lane.h"
#include "sweeps/multi_axis.h"

/* As mbsri_known_part, with sizes known to the compiler: w = e - U^T H A_pi, u' = D^+ w,
 * A = -(H A_pi + kII + J u'). */
MBSRI_INLINE void known_sized(const mbsri_sweep_run *run, int i, int d, int dp, int n)
{
    const mbsri_body *b = run->model->body + i;
    const mbsr_data *data = run->data;
    double *A = data->A + b->v, *udot = run->out + run->tree->body[i].u, w[6], sum[6] = {0.0};
    mbsri_ax(d, dp, 1.0, data->H + b->dp, data->A + b->pred.v, sum);
    for (int k = 0; k < n; ++k) w[k] = data->e[b->group.iu + k], udot[k] = 0.0;
    mbsri_atx(d, n, -1.0, data->U + b->dg, sum, w);
    mbsri_ax(n, n, 1.0, data->Dinv + b->nn, w, udot);
    mbsri_ax(d, n, 1.0, data->J + b->dn, udot, sum);
    for (int k = 0; k < d; ++k) A[k] = -sum[k] - data->kII[b->v + (size_t)k];
}

/* u' to `out` and A of block i; of a group, all with its head. */
MBSRI_OUTLINE void forward_block(const mbsri_sweep_run *run, int i)
{
    const mbsri_body *b = run->model->body + i;
    if (mbsri_heads(run->model, run->data, i)) {
        const mbsri_group g = mbsri_group_of(run->model, run->data, i);
        mbsri_block_open_forward(run, i);
        if (b->d == 6 && b->pred.d == 6 && g.n == 1) {
            known_sized(run, i, 6, 6, 1);
        } else {
            double w[MBSR_MAX_D], rate[MBSR_MAX_D];
            mbsri_known_part(run->model, run->data, &g, w, rate);
            mbsri_block_rates(run, &g, rate, run->out);
        }
    }
    mbsri_block_close_forward(run, i);
}

/* u' = D^-1 (e - U^T A),  A += S u' */
static void multi_forward(const mbsri_sweep_run *run, int i)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    mbsri_sweep_state *s = run->state + i;
    mbsri_sweep_multi *multi = run->multi + b->multi;
    const bool on_root = b->parent == 0;
    _Alignas(32) double A[8];
    double *x = multi->x;
    memcpy(A, s->A_w, sizeof s->A_w);
    memcpy(A + 4, s->A_v, sizeof s->A_v);
    for (int k = 0; k < b->n; ++k) x[k] -= product(on_root ? multi->U[k] : multi->G[k], A);
    if (on_root) mbsri_solve_joint(b->n, multi->factor, x);
    for (int k = 0; k < b->n; ++k) {
        run->out[b->u + k] = x[k];
        mbsri_add3(x[k], multi->S[k], s->A_w);
        mbsri_add3(x[k], multi->S[k] + 4, s->A_v);
    }
}

/* What u' needs of A_pi comes first, so that the next body waits for little:
 * u' = D^-1 e - D^-1 (X^T U)^T A_pi. */
MBSRI_INLINE void forward_part(const mbsri_sweep_run *run, int first, int last)
{
    if (first > last) return;
    const mbsri_sweep_state *before = run->state + run->tree->body[first].parent;
    v4 last_w = load(before->A_w), last_v = load(before->A_v);
    for (int i = first; i <= last; ++i) {
        const mbsri_sweep_body *b = run->tree->body + i;
        const mbsri_sweep_state *pred = run->state + b->parent;
        mbsri_sweep_state *s = run->state + i;
        const bool next = b->parent == i - 1;
        const v4 w = next ? last_w : load(pred->A_w), v = next ? last_v : load(pred->A_v);
        const v4 rho = load(s->rho), c_w = load(s->A_w), c_v = load(s->A_v);
        last_w = w + c_w;
        last_v = v + (cross(w, rho) + c_v);
        if (b->flags & (MBSRI_MULTI | MBSRI_BLOCK)) {
            store(s->A_w, last_w);
            store(s->A_v, last_v);
            if (b->flags & MBSRI_BLOCK)
                forward_block(run, i);
            else
                multi_forward(run, i);
            last_w = load(s->A_w);
            last_v = load(s->A_v);
            continue;
        }
        const v4 Z = load(s->R + 8), U_L = load(s->U_L), U_p = load(s->U_p), Dinv = splat(s->Dinv);
        const v4 known = {s->e * s->Dinv, 0.0, 0.0, 0.0};
        const v4 g_L = (U_L + cross(rho, U_p)) * Dinv, g_p = U_p * Dinv;
        const double udot = sum3(known - g_p * v - g_L * w);
        if (b->n) run->out[b->u] = udot;
        if (b->flags & MBSRI_TURNS) last_w += Z * splat(udot);
        if (b->flags & MBSRI_SLIDES) last_v += Z * splat(b->pitch * udot);
        store(s->A_w, last_w);
        store(s->A_v, last_v);
    }
}

static void forward(const mbsri_sweep_run *run)
{
    forward_part(run, 1, run->tree->bodies);
}

#endif
