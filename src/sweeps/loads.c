/* Force elements that act on bodies, in the vectorised sweeps.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Elements see a body by its own frame: pose, velocity and force stand in the arrays of the stages,
 * for the bodies on which elements act. */
#include "sweeps/loads.h"

#include "algebra/dense.h"
#include "algebra/space3.h"
#include "recursion/closures.h"
#include "recursion/elements.h"
#include "recursion/inertia.h"
#include "sweeps/block.h"
#include "sweeps/loops.h"
#include "sweeps/show.h"

#include <string.h>

/* Pose, velocity and mass matrix of the bodies on which elements act; no force yet. */
static void show_all(const mbsri_sweep_run *run)
{
    mbsr_data *d = run->data;
    for (int k = 0; k < run->tree->loads; ++k) {
        const int i = run->tree->loaded[k];
        const mbsri_body *body = run->model->body + i;
        mbsri_sweeps_show(run, i);
        mbsri_zero((size_t)body->d, d->f + body->v);
        if (run->tree->masses) mbsri_inertia_mass(body, d->p + body->p, d->M + body->dd);
    }
}

int mbsri_sweeps_loads(const mbsri_sweep_run *run)
{
    const mbsri_sweeps *tree = run->tree;
    const mbsr_model *m = run->model;
    mbsr_data *d = run->data;
    mbsri_sweep_load *load = run->load;
    show_all(run);
    mbsri_zero((size_t)m->root.d, d->f);
    int status = mbsri_block_forces(run);
    if (!status) status = mbsri_body_elements(m, d);
    if (!status && m->rows > 0)
        status = run->springs ? mbsri_closure_springs(m, d) : mbsri_closure_jacobians(m, d);
    const bool loads = m->rows > 0 && !(run->springs && !tree->loops->springs);
    if (!status && loads) mbsri_closure_load(m, d, d->loop_lambda, d->f, d->tau);
    for (int k = 0; k < tree->loads; ++k) {
        const int i = tree->loaded[k];
        const mbsri_body *body = m->body + i;
        double f[6];
        mbsri_lift(body->d, d->f + body->v, f);
        memset(load[i].L, 0, sizeof load[i].L);
        memset(load[i].p, 0, sizeof load[i].p);
        mbsri_cross3(load[i].arm, f + 3, load[i].L);
        mbsri_add3(1.0, f, load[i].L);
        memcpy(load[i].p, f + 3, 3 * sizeof *f);
    }
    return status;
}

/* What body i is pushed by goes through its joint to the predecessor. */
static void push_on(const mbsri_sweep_run *run, int i, double *f, double *tau)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    const mbsri_sweep_state *s = run->state + i;
    const mbsri_body *body = run->model->body + i, *pred = run->model->body + body->parent;
    mbsri_sweep_load *load = run->load + i;
    double y[6], lowered[6];
    if (b->flags & MBSRI_LOADED) {
        mbsri_lift(body->d, f + body->v, y);
        mbsri_add_cross3(load->arm, y + 3, y);
        mbsri_add3(1.0, y, load->L);
        mbsri_add3(1.0, y + 3, load->p);
    }
    if (b->flags & MBSRI_MULTI) {
        for (int k = 0; k < b->n; ++k) {
            const double *S = run->multi[b->multi].S[k];
            tau[b->u + k] += mbsri_dot3(S, load->L) + mbsri_dot3(S + 4, load->p);
        }
    } else if (b->n > 0) {
        if (b->flags & MBSRI_TURNS) tau[b->u] += mbsri_dot3(s->R + 8, load->L);
        if (b->flags & MBSRI_SLIDES) tau[b->u] += b->pitch * mbsri_dot3(s->R + 8, load->p);
    }
    memcpy(y, load->L, 3 * sizeof *y);
    memcpy(y + 3, load->p, 3 * sizeof *y);
    mbsri_add_cross3(s->rho, y + 3, y);
    if (run->tree->body[b->parent].flags & MBSRI_BLOCK) {
        mbsri_lower(pred->d, y, lowered);
        for (int k = 0; k < pred->d; ++k) f[pred->v + (size_t)k] += lowered[k];
    } else {
        mbsri_add3(1.0, y, run->load[b->parent].L);
        mbsri_add3(1.0, y + 3, run->load[b->parent].p);
    }
}

/* The same of a block. */
static void push_block(const mbsri_sweep_run *run, int i, double *f, double *tau)
{
    const mbsri_body *b = run->model->body + i;
    const mbsr_data *d = run->data;
    mbsri_sweep_load *load = run->load + b->parent;
    double own[MBSR_MAX_D] = {0.0}, y[6];
    mbsri_atx(b->d, b->n, -1.0, d->J + b->dn, f + b->v, tau + b->iu);
    mbsri_atx(b->d, b->d_pred, -1.0, d->H + b->dp, f + b->v, own);
    if (b->parent == 0) return;
    if (run->tree->body[b->parent].flags & MBSRI_BLOCK) {
        for (int k = 0; k < b->d_pred; ++k) f[b->pred_v + (size_t)k] += own[k];
        return;
    }
    mbsri_lift(b->d_pred, own, y);
    mbsri_add_cross3(load->arm, y + 3, y);
    mbsri_add3(1.0, y, load->L);
    mbsri_add3(1.0, y + 3, load->p);
}

void mbsri_sweeps_push(const mbsri_sweep_run *run, const double *x)
{
    const mbsr_model *m = run->model;
    mbsr_data *d = run->data;
    double *f = d->closure_V, *tau = d->closure_w;
    mbsri_zero(m->size_v, f);
    mbsri_zero((size_t)m->nu, tau);
    mbsri_closure_load(m, d, x, f, tau);
    for (int i = 0; i <= run->tree->bodies; ++i) {
        memset(run->load[i].L, 0, sizeof run->load[i].L);
        memset(run->load[i].p, 0, sizeof run->load[i].p);
    }
    for (int i = run->tree->bodies; i >= 1; --i) {
        if (run->tree->body[i].flags & MBSRI_BLOCK)
            push_block(run, i, f, tau);
        else
            push_on(run, i, f, tau);
    }
}
