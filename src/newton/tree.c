/* The elimination on the tree: by the vectorised sweeps where they serve, else by blocks.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "newton/tree.h"

#include "algebra/dense.h"
#include "base/error.h"
#include "forms/loops.h"
#include "newton/blocks/factor.h"
#include "newton/blocks/front_solve.h"
#include "newton/blocks/linked.h"
#include "newton/blocks/solve.h"
#include "newton/sweeps/elements.h"
#include "newton/sweeps/sweeps.h"

/* A status, or MBSRI_NOT_SERVED. */
static int factor_by_sweeps(mbsr_newton *w, mbsr_data *d, double t, const double *y,
                            const double *yp, double c)
{
    const mbsr_model *m = w->model;
    const double *u = y + m->nq + m->nu;
    if (!w->sweeps) return MBSRI_NOT_SERVED;
    if (m->rows > 0) mbsri_loops_take(m, d, u + m->nu, yp + m->nq + 2 * m->nu);
    const int status = mbsri_newton_sweeps_factor(w->sweeps, d, t, y, u, c);
    d->loaded = m->rows > 0;
    return status;
}

int mbsri_newton_tree_factor(mbsr_newton *w, mbsr_data *d, double t, const double *y,
                             const double *yp, double c)
{
    const mbsr_model *m = w->model;
    const int status = factor_by_sweeps(w, d, t, y, yp, c);
    w->by_sweeps = status != MBSRI_NOT_SERVED;
    w->info.vector_code = w->by_sweeps && (m->bodies == 0 || w->sweeps->tree->blocks < m->bodies);
    w->info.blocks = w->by_sweeps ? w->sweeps->tree->blocks : m->bodies;
    if (w->by_sweeps) return status;
    if (w->sweeps) w->sweeps->marked = false;
    mbsri_slopes_forget(&w->kept); /* the stages' state has other roundings */
    if (!w->lean) return mbsri_tree_factor(w, d, t, y, yp, c);
    return mbsri_fail(&d->error, MBSR_ERR_LEAN, MBSR_NONE, MBSR_NONE,
                      "mbsr_newton_factor: the solver was created lean, and the sweeps in vector "
                      "code do not serve %s",
                      w->sweeps ? "this state" : "this model");
}

/* Leaves the perturbations in w->x. */
static void solve_by_blocks(mbsr_newton *w, const double *r, const double *load, double *delta)
{
    const mbsr_model *m = w->model;
    const double *tau = load ? load + m->size_v : NULL;
    mbsri_tree_clear_load(w, 0);
    for (int i = 1; i <= m->bodies; ++i) mbsri_tree_load(w, i, r, load);
    const bool closed = m->rows > 0;
    if (closed) mbsri_front_load(w, r);
    for (int k = 0; k < m->bodies; ++k) {
        const int i = mbsri_links_turn(w, k);
        if (closed) mbsri_front_reduce_closing(w, i);
        mbsri_tree_reduce(w, i, tau);
        mbsri_links_reduce(w, i, r);
    }
    if (closed) mbsri_front_reduce_closing(w, 0);
    mbsri_zero((size_t)mbsri_motions(w->node, m->body), w->x);
    if (closed) mbsri_front_substitute_closing(w, 0);
    for (int k = m->bodies - 1; k >= 0; --k) {
        const int i = mbsri_links_turn(w, k);
        mbsri_links_substitute(w, i);
        mbsri_tree_substitute(w, i, tau, delta);
        if (closed) mbsri_front_substitute_closing(w, i);
    }
    if (closed) mbsri_front_multipliers(w, r, delta);
}

void mbsri_newton_tree_solve(mbsr_newton *w, const double *r, const double *load, double *delta)
{
    if (w->by_sweeps)
        mbsri_newton_sweeps_solve(w->sweeps, r, load, delta, w->motion);
    else
        solve_by_blocks(w, r, load, delta);
}

const double *mbsri_newton_motion(const mbsr_newton *w, int i)
{
    const bool swept = w->by_sweeps && !(w->sweeps->tree->body[i].flags & MBSRI_BLOCK);
    return swept ? w->motion + 12 * (size_t)i : w->x + w->node[i].x;
}
