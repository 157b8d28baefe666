/* Force elements that act on bodies, in the vectorised sweeps.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Elements see a body by its own frame: pose, velocity and force stand in the arrays of the stages,
 * for the bodies on which elements act. */
#include "sweeps/loads.h"

#include "algebra/dense.h"
#include "algebra/space3.h"
#include "base/expect.h"
#include "recursion/closures.h"
#include "recursion/elements.h"
#include "recursion/inertia.h"
#include "sweeps/block.h"
#include "sweeps/loops.h"
#include "sweeps/show.h"

#include <string.h>

enum { AHEAD = 4 };

/* What showing body i reads, and what its load is. */
static void expect_shown(const mbsri_sweep_run *run, int i)
{
    const mbsri_body *b = run->model->body + i;
    mbsri_expect(b, &b->dd);
    mbsri_expect(&b->joint.space, &b->joint.space + 1);
    mbsri_expect(run->state + i, run->state[i].U_L);
    mbsri_expect(run->tree->own + i, run->tree->own + i + 1);
    mbsri_expect_room(run->load + i, run->load + i + 1);
}

/* Pose, velocity and mass matrix of the bodies on which elements act; no force yet. */
static void show_all(const mbsri_sweep_run *run)
{
    mbsr_data *d = run->data;
    for (int k = 0; k < run->tree->loads; ++k) {
        const int i = run->tree->loaded[k];
        const mbsri_body *body = run->model->body + i;
        if (k + AHEAD < run->tree->loads && run->tree->bodies > MBSRI_LARGE)
            expect_shown(run, run->tree->loaded[k + AHEAD]);
        mbsri_sweeps_show(run, i);
        mbsri_zero((size_t)body->d, d->f + body->v);
        if (run->tree->masses) mbsri_inertia_mass(body, d->p + body->p, d->M + body->dd);
    }
}

/* What loops exert, or their springs alone, with the derivatives of their rows and, where it is
 * asked for, their bias. */
static int closure_loads(const mbsri_sweep_run *run)
{
    const mbsr_model *m = run->model;
    mbsr_data *d = run->data;
    if (!run->springs) return mbsri_closure_loads_here(m, d, d->loop_lambda, run->eta);
    const bool springs = run->tree->loops->springs;
    int status = MBSR_OK;
    if (springs)
        status = mbsri_closure_springs(m, d);
    else
        mbsri_zero((size_t)m->rows, d->loop_lambda);
    if (!status)
        status =
            run->bias ? mbsri_closure_rows_here(m, d, run->bias) : mbsri_closure_jacobians(m, d);
    if (!status && springs) mbsri_closure_load(m, d, d->loop_lambda, d->f, d->tau);
    return status;
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
    if (!status && m->rows > 0) status = closure_loads(run);
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

static void clear_push(const mbsri_sweep_run *run, int i)
{
    memset(run->load[i].L, 0, sizeof run->load[i].L);
    memset(run->load[i].p, 0, sizeof run->load[i].p);
}

/* (L, p) of body i's load join those at its predecessor's point, or are the first there. */
static void hand_push_on(const mbsri_sweep_run *run, int i, bool first)
{
    const int parent = run->tree->body[i].parent;
    const mbsri_sweep_load *load = run->load + i;
    mbsri_sweep_load *to = run->load + parent;
    double L[3];
    mbsri_cross3(run->state[i].rho, load->p, L);
    for (int k = 0; k < 3; ++k) {
        to->L[k] = (first ? 0.0 : to->L[k]) + (load->L[k] + L[k]);
        to->p[k] = (first ? 0.0 : to->p[k]) + load->p[k];
    }
}

/* To a block, about its own origin. */
static void push_to_block(const mbsri_sweep_run *run, int i, double *f)
{
    const mbsri_body *pred = run->model->body + run->model->body[i].parent;
    double y[6], lowered[6];
    memcpy(y, run->load[i].L, 3 * sizeof *y);
    memcpy(y + 3, run->load[i].p, 3 * sizeof *y);
    mbsri_add_cross3(run->state[i].rho, y + 3, y);
    mbsri_lower(pred->d, y, lowered);
    for (int k = 0; k < pred->d; ++k) f[pred->v + (size_t)k] += lowered[k];
}

/* What body i is pushed by goes through its joint to the predecessor. */
static void push_on(const mbsri_sweep_run *run, int i, double *f, double *tau)
{
    const mbsri_sweep_body *b = run->tree->body + i;
    const mbsri_sweep_state *s = run->state + i;
    const int flags = b->flags;
    mbsri_sweep_load *load = run->load + i;
    if (flags & MBSRI_LOADED) {
        const mbsri_body *body = run->model->body + i;
        double y[6];
        mbsri_lift(body->d, f + body->v, y);
        mbsri_add_cross3(load->arm, y + 3, y);
        mbsri_add3(1.0, y, load->L);
        mbsri_add3(1.0, y + 3, load->p);
    }
    if (flags & MBSRI_MULTI) {
        for (int k = 0; k < b->n; ++k) {
            const double *S = run->multi[b->multi].S[k];
            tau[b->u + k] += mbsri_dot3(S, load->L) + mbsri_dot3(S + 4, load->p);
        }
    } else if (b->n > 0) {
        if (flags & MBSRI_TURNS) tau[b->u] += mbsri_dot3(s->R + 8, load->L);
        if (flags & MBSRI_SLIDES) tau[b->u] += b->pitch * mbsri_dot3(s->R + 8, load->p);
    }
    if (b->parent == 0) return;
    if (flags & MBSRI_TO_BLOCK) {
        push_to_block(run, i, f);
        return;
    }
    const bool one = !(run->tree->body[b->parent].flags & MBSRI_BRANCHES);
    hand_push_on(run, i, run->tree->blocks == 0 && (one || flags & MBSRI_OPENS));
}

/* The same of a block. */
static void push_block(const mbsri_sweep_run *run, int i, double *f, double *tau)
{
    const mbsri_body *b = run->model->body + i;
    const mbsr_data *d = run->data;
    mbsri_sweep_load *load = run->load + b->parent;
    double own[MBSR_MAX_D] = {0.0}, y[6];
    mbsri_atx(b->d, b->n, -1.0, d->J + b->dn, f + b->v, tau + b->iu);
    mbsri_atx(b->d, b->pred.d, -1.0, d->H + b->dp, f + b->v, own);
    if (b->parent == 0) return;
    if (run->tree->body[b->parent].flags & MBSRI_BLOCK) {
        for (int k = 0; k < b->pred.d; ++k) f[b->pred.v + (size_t)k] += own[k];
        return;
    }
    mbsri_lift(b->pred.d, own, y);
    mbsri_add_cross3(load->arm, y + 3, y);
    mbsri_add3(1.0, y, load->L);
    mbsri_add3(1.0, y + 3, load->p);
}

void mbsri_sweeps_push(const mbsri_sweep_run *run)
{
    double *f = run->data->closure_V, *tau = run->data->closure_w;
    for (int i = 0; i <= run->tree->bodies && run->tree->blocks > 0; ++i) clear_push(run, i);
    for (int i = run->tree->bodies; i >= 1; --i) {
        if (run->tree->body[i].flags & MBSRI_LEAF) clear_push(run, i);
        if (run->tree->body[i].flags & MBSRI_BLOCK)
            push_block(run, i, f, tau);
        else
            push_on(run, i, f, tau);
    }
}
