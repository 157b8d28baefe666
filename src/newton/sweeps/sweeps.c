/* The Newton system by the vectorised sweeps: memory and calls.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "newton/sweeps/sweeps.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "base/error.h"
#include "base/expect.h"
#include "base/memory.h"
#include "dynamics/entry.h"
#include "model/query.h"
#include "newton/carried/record.h"
#include "newton/slopes/force_slopes.h"
#include "newton/sweeps/elements.h"
#include "sweeps/dynamics.h"

#include <string.h>

/* ---- memory ---- */

static size_t branching(const mbsri_sweeps *tree)
{
    size_t count = 0;
    for (int i = 1; i <= tree->bodies; ++i) count += (tree->body[i].flags & MBSRI_BRANCHES) != 0;
    return count;
}

/* Whether some joint block may be zero: hardly where the own inertia of every body is regular. */
static bool may_be_below_massless(const mbsri_sweeps *tree)
{
    for (int i = 1; i <= tree->bodies; ++i) {
        if (!(tree->body[i].soft > 0.0)) return true;
    }
    return false;
}

/* Compiled for the same processor as those of the tree, which there is with vector types alone. */
static const mbsri_newton_kernels *kernels_of(const mbsri_sweeps *tree)
{
    (void)tree;
#if defined(MBSR_WITHOUT_VECTORS)
    return NULL;
#else
#if defined(MBSR_WITH_V3)
    if (tree->kernels == &mbsri_sweeps_v3) return &mbsri_newton_v3;
#endif
    return &mbsri_newton_base;
#endif
}

/* Places the solver in `base`, or with base == NULL only returns the size. */
static size_t layout(const mbsr_model *m, const mbsri_sweeps *tree, unsigned char *base,
                     mbsri_newton_sweeps **newton)
{
    const size_t bodies = (size_t)m->bodies + 1, nu = (size_t)m->nu, depth = (size_t)tree->depth;
    mbsri_newton_sweeps counted;
    size_t used = 0, doubles, ints, loaded, pairs;
    mbsri_newton_sweeps *w = mbsri_take_bytes(base, &used, sizeof *w);
    if (!w) w = &counted;
    const bool full = tree->body_forces;
    const size_t narrow = offsetof(mbsri_newton_column, C_last) - offsetof(mbsri_newton_column, K);
    w->column_size = full ? sizeof(mbsri_newton_column) : narrow;
    w->column =
        mbsri_take_bytes(base, &used, nu * w->column_size + sizeof(mbsri_newton_column) - narrow);
    w->step = mbsri_take_bytes(base, &used, bodies * sizeof *w->step);
    w->block = mbsri_take_bytes(base, &used, (size_t)tree->multi * sizeof *w->block);
    w->acting.own = mbsri_take_bytes(base, &used, full ? bodies * sizeof *w->acting.own : 0);
    mbsri_newton_count(m, tree, &loaded, &pairs, NULL, NULL);
    w->acting.acted = loaded;
    w->acting.pairs = pairs;
    w->acting.at = mbsri_take_bytes(base, &used, loaded * sizeof *w->acting.at);
    w->acting.by_pred = mbsri_take_bytes(base, &used, pairs * sizeof *w->acting.by_pred);
    w->acting.on_pred = mbsri_take_bytes(base, &used, pairs * sizeof *w->acting.on_pred);
    w->acting.number = mbsri_take_bytes(base, &used, full ? bodies * sizeof *w->acting.number : 0);
    w->acting.pair = mbsri_take_bytes(base, &used, full ? bodies * sizeof *w->acting.pair : 0);
    w->k = mbsri_take_bytes(base, &used, nu * sizeof *w->k);
    w->p = mbsri_take_bytes(base, &used, nu * sizeof *w->p);
    w->x = mbsri_take_bytes(base, &used, branching(tree) * sizeof *w->x);
    w->said = mbsri_take_bytes(base, &used, branching(tree) * sizeof *w->said);
    w->carry = mbsri_take_bytes(base, &used, depth * sizeof *w->carry);
    w->flow = mbsri_take_bytes(base, &used, depth * sizeof *w->flow);
    const bool armature = mbsri_largest(m->nu, m->armature) > 0.0;
    const bool any =
        loaded > 0 || tree->joint_forces || armature || mbsri_newton_has_joint_slopes(m);
    const size_t slopes = any ? nu : 0;
    w->tau_q = mbsri_take_bytes(base, &used, slopes * sizeof *w->tau_q);
    w->tau_u = mbsri_take_bytes(base, &used, slopes * sizeof *w->tau_u);
    const bool below_massless = may_be_below_massless(tree);
    w->below = mbsri_take_bytes(base, &used, below_massless ? nu * sizeof *w->below : 0);
    w->reaction = mbsri_take_bytes(base, &used, below_massless ? bodies * sizeof *w->reaction : 0);
    mbsri_slopes_size(m, MBSRI_SLOPES_BY_PAIRS, &doubles, &ints);
    double *work = mbsri_take_bytes(base, &used, doubles * sizeof *work);
    int *places = mbsri_take_bytes(base, &used, ints * sizeof *places);
    if (!base) return used;
    w->model = m;
    w->tree = tree;
    w->kernels = kernels_of(tree);
    w->large = m->bodies > MBSRI_LARGE;
    if (!full) w->acting.own = NULL;
    if (!below_massless) w->below = NULL;
    w->last.below_massless = w->last.unclear = w->last.massless_on_loop = w->last.marked = false;
    w->last.looped = m->rows > 0;
    if (full) mbsri_newton_count(m, tree, &loaded, &pairs, w->acting.number, w->acting.pair);
    if (slopes == 0) w->tau_q = w->tau_u = NULL;
    mbsri_slopes_place(m, MBSRI_SLOPES_BY_PAIRS, &w->slopes, work, places);
    *newton = w;
    return used;
}

/* Whether looped.h has memory for bodies that count as below a massless joint; beside loops these
 * are not on joints of several axes. light: whether there are any. */
static bool finds_light(const mbsri_sweeps *tree, bool *light)
{
    bool serves = true;
    *light = false;
    for (int i = 1; i <= tree->bodies; ++i) {
        const int flags = tree->body[i].flags;
        if (flags & MBSRI_HEAVY || !(flags & MBSRI_WIDE_JOINT)) continue;
        *light = true;
        serves = serves && (flags & MBSRI_FRONT || !(flags & MBSRI_MULTI));
    }
    return serves && (!*light || may_be_below_massless(tree));
}

static bool serves_loops(const mbsr_model *m, const mbsri_sweeps *tree)
{
    bool light;
    return tree->with_loops && !m->order.grouped && finds_light(tree, &light);
}

size_t mbsri_newton_sweeps_size(const mbsr_model *m, bool lean)
{
    const mbsri_sweeps *tree = m->tree.newton;
    /* of nothing but blocks, the front alone loses fewer digits: no Mbar stands for what is below
     */
    if (!tree || (tree->blocks > 0 && (!tree->rates || tree->blocks == tree->bodies))) return 0;
    if (m->rows > 0 && (lean || tree->blocks > 0 || !serves_loops(m, tree))) return 0;
    return layout(m, tree, NULL, NULL);
}

mbsri_newton_sweeps *mbsri_newton_sweeps_place(const mbsr_model *m, bool alone, void *memory,
                                               struct mbsr_newton *blocks)
{
    mbsri_newton_sweeps *w;
    const mbsri_sweeps *tree = m->tree.newton;
    layout(m, tree, memory, &w);
    w->blocks = m->rows > 0 ? blocks : NULL;
    w->mixed = blocks ? blocks->mixed : NULL;
    memset(w->step, 0, sizeof *w->step);
    w->least_pivot = alone ? MBSRI_LEAST_PIVOT : MBSRI_CLEAR_PIVOT;
    int branch = 0;
    for (int i = 1; i <= tree->bodies; ++i) {
        const mbsri_sweep_body *b = tree->body + i;
        w->step[i] = (mbsri_newton_step){.parent = b->parent,
                                         .flags = b->flags,
                                         .n = b->n,
                                         .q = b->q,
                                         .u = b->u,
                                         .multi = b->multi,
                                         .branch = branch};
        branch += (b->flags & MBSRI_BRANCHES) != 0;
    }
    for (int k = 0; k < tree->multi; ++k) memset(w->block + k, 0, sizeof *w->block);
    if (m->rows > 0) (void)finds_light(tree, &w->last.massless_on_loop);
    return w;
}

/* ---- calls ---- */

/* What the bound tells, and which bodies are below a massless joint, seldom changes. */
static int factor_sweeps(const mbsri_sweep_run *run, mbsri_newton_sweeps *newton)
{
    const mbsri_newton_kernels *kernels = newton->kernels;
    int singular = MBSRI_DEFICIENT;
    newton->last.below_massless = false;
    if (newton->last.looped) return kernels->factor_looped(run, newton);
    if (newton->mixed) return kernels->factor_mixed(run, newton);
    if (!newton->last.unclear) singular = kernels->factor(run, newton);
    return singular == MBSRI_DEFICIENT ? kernels->factor_below_massless(run, newton) : singular;
}

int mbsri_newton_sweeps_factor(mbsri_newton_sweeps *newton, mbsr_data *d, double t, const double *q,
                               const double *u, double c)
{
    const mbsr_model *m = newton->model;
    mbsri_sweep_run run;
    const int opened = mbsri_sweeps_open(&run, m, newton->tree, d, t, q, u);
    if (opened) return opened;
    newton->c = c;
    newton->by_c = 1.0 / c;
    newton->last.joint_slopes = false;
    if (newton->tau_q) {
        /* elements look into the data */
        if (run.q != d->q) mbsri_copy((size_t)m->nq, run.q, d->q);
        if (run.u != d->u) mbsri_copy((size_t)m->nu, run.u, d->u);
        const int status = mbsri_newton_slopes_at(newton, d);
        if (status) return status;
    }
    const int singular = factor_sweeps(&run, newton);
    if (singular == MBSRI_BLOCK_FAILED) return newton->status;
    if (singular < 0 || !mbsri_sweeps_as_watched(&run) || mbsri_sweeps_coupled(&run))
        return MBSRI_NOT_SERVED;
    if (singular > 0 && newton->least_pivot > MBSRI_LEAST_PIVOT &&
        run.tree->body[singular].flags & MBSRI_MULTI)
        return MBSRI_NOT_SERVED;
    mbsri_remember(m, d, MBSRI_PENDING_FORWARD, q, u, NULL);
    if (singular == 0) return MBSR_OK;
    char label[MBSRI_LABEL];
    return mbsri_fail(&d->error, MBSR_SINGULAR_BLOCK, m->body[singular].id, MBSR_NONE,
                      "%s: joint '%s': its equations are singular at t = %g; %s",
                      mbsri_body_label(m, singular, label), m->body[singular].joint.table->name, t,
                      MBSRI_SINGULAR_ADVICE);
}

void mbsri_newton_sweeps_solve(mbsri_newton_sweeps *newton, const double *r, const double *load,
                               double *delta, double *motion)
{
    newton->kernels->solve(newton, r, load, delta, motion);
}

void mbsri_newton_sweeps_solve_transposed(mbsri_newton_sweeps *newton, const double *v, double *x,
                                          double *tau)
{
    newton->kernels->solve_transposed(newton, v, x, tau);
}
