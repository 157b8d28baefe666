/* The forward recursion of the vectorised sweeps, root to leaves: A, u'.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_SWEEPS_FORWARD_H
#define MBSRI_SWEEPS_FORWARD_H

#include "sweeps/block.h"
#include "sweeps/lane.h"
#include "sweeps/multi_axis.h"

/* What u' needs of A_pi comes first, so that the next body waits for little:
 * u' = D^-1 (e - U^T c) - D^-1 (X^T U)^T A_pi. */
static void forward(const mbsri_sweep_run *run)
{
    v4 last_w = load(run->state->A_w), last_v = load(run->state->A_v);
    for (int i = 1; i <= run->tree->bodies; ++i) {
        const mbsri_sweep_body *b = run->tree->body + i;
        const mbsri_sweep_state *pred = run->state + b->parent;
        mbsri_sweep_state *s = run->state + i;
        const bool next = b->parent == i - 1;
        const v4 w = next ? last_w : load(pred->A_w), v = next ? last_v : load(pred->A_v);
        const v4 rho = load(s->rho), c_w = load(s->A_w), c_v = load(s->A_v);
        last_w = w + c_w;
        last_v = v + cross(w, rho) + c_v;
        if (b->flags & (MBSRI_MULTI | MBSRI_BLOCK)) {
            store(s->A_w, last_w);
            store(s->A_v, last_v);
            if (b->flags & MBSRI_BLOCK)
                mbsri_block_forward(run, i);
            else
                multi_forward(run, i);
            last_w = load(s->A_w);
            last_v = load(s->A_v);
            continue;
        }
        const v4 Z = load(s->R + 8), U_L = load(s->U_L), U_p = load(s->U_p), Dinv = splat(s->Dinv);
        const double known = (s->e - sum3(U_L * c_w + U_p * c_v)) * s->Dinv;
        const v4 g_L = (U_L + cross(rho, U_p)) * Dinv, g_p = U_p * Dinv;
        const double udot = known - sum3(g_L * w + g_p * v);
        if (b->n) run->out[b->u] = udot;
        if (b->flags & MBSRI_TURNS) last_w += Z * splat(udot);
        if (b->flags & MBSRI_SLIDES) last_v += Z * splat(b->pitch * udot);
        store(s->A_w, last_w);
        store(s->A_v, last_v);
    }
}

#endif
