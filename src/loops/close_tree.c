/* Positions that close loops, along the tree.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Gauss-Newton steps in the measure of closing.h: the least x with C_h x = -g solves W x = C_h^T
 * lambda, the equations of fronts/fronts.h for a tree whose only inertias are W. */
#include "loops/close_tree.h"

#include "algebra/dense.h"
#include "base/error.h"
#include "base/memory.h"
#include "loops/assemble.h"
#include "loops/closing.h"
#include "fronts/fronts.h"
#include "model/query.h"
#include "recursion/closures.h"
#include "recursion/kinematics.h"

#include <math.h>

static const char function[] = "mbsr_dae_consistent";

typedef struct closer {
    const mbsr_model *m;
    mbsr_data *d;
    double t;
    const double *offset;
    mbsri_closing measure;
    mbsri_fronts system;
    double *resist, *x, *none, *rows, *lambda; /* nu, nu, nu, rows, rows */
    double *g, *q_try;                         /* held, nq */
    void *memory;
} closer;

static int open_closer(closer *w)
{
    const mbsr_model *m = w->m;
    const size_t nu = (size_t)m->nu, rows = (size_t)m->rows, held = (size_t)m->held,
                 numbers = 4 * nu + 2 * rows + 2 * held + (size_t)m->nq;
    const mbsri_closure *c = mbsri_all_closures(m), *end = c + m->closures.count;
    w->memory = mbsri_allocate(&m->allocator, numbers * sizeof(double));
    if (!w->memory)
        return mbsri_fail(&w->d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "%s: no memory for %zu numbers", function, numbers);
    w->resist = w->memory;
    w->x = w->resist + nu;
    w->none = w->x + nu;
    w->measure.give = w->none + nu;
    w->rows = w->measure.give + nu;
    w->lambda = w->rows + rows;
    w->g = w->lambda + rows;
    w->measure.gap = w->g + held;
    w->q_try = w->measure.gap + held;
    mbsri_zero(nu, w->none);
    const int status = mbsri_fronts_open(&w->system, m, w->d, true, function);
    for (; c < end && !status; ++c) {
        for (int k = 0; k < c->rows; ++k)
            w->system.left_out[c->row + k] = k >= c->held || w->d->dropped[c->row + k];
    }
    return status;
}

static void close_closer(closer *w)
{
    mbsri_fronts_close(&w->system);
    mbsri_release(&w->m->allocator, w->memory);
}

/* Resistances of coordinates that stay are so much larger, and what they do is left out. */
static const double stays = 1e12;

static void find_resistances(closer *w)
{
    double most = 0.0, *resist = w->x;
    for (int k = 0; k < w->m->nu; ++k) {
        const double give = w->measure.give[k];
        resist[k] = give > 0.0 ? 1.0 / (give * give) : 0.0;
        most = fmax(most, resist[k]);
    }
    for (int k = 0; k < w->m->nu; ++k) {
        if (!(w->measure.give[k] > 0.0)) resist[k] = stays * (most > 0.0 ? most : 1.0);
    }
    mbsri_gather(w->m, resist, w->resist);
}

/* Gaps at q of rows that are not left out, less what they are to be; their norm. */
static int find_gaps(closer *w, const double *q, double *norm)
{
    const mbsri_closure *c = mbsri_all_closures(w->m), *end = c + w->m->closures.count;
    int status = mbsri_positions(w->m, w->d, w->t, q);
    if (!status) status = mbsri_closure_gaps(w->m, w->d, w->g);
    for (; c < end && !status; ++c) {
        for (int k = 0; k < c->held; ++k) {
            double *g = w->g + c->held_row + k;
            *g = w->system.left_out[c->row + k]
                     ? 0.0
                     : *g - (w->offset ? w->offset[c->held_row + k] : 0.0);
        }
    }
    *norm = status ? INFINITY : mbsri_closing_norm(w->m, &w->measure, w->g);
    return status;
}

/* x by the gaps, which the data is at the positions of. */
static int find_step(closer *w)
{
    const mbsri_closure *c = mbsri_all_closures(w->m), *end = c + w->m->closures.count;
    int status = mbsri_closure_jacobians(w->m, w->d);
    if (!status) status = mbsri_fronts_factor(&w->system, w->resist, function);
    if (status) return status;
    mbsri_zero((size_t)w->m->rows, w->rows);
    for (; c < end; ++c) {
        for (int k = 0; k < c->held; ++k) w->rows[c->row + k] = -w->g[c->held_row + k];
    }
    mbsri_fronts_solve(&w->system, w->none, w->rows, w->x, w->lambda);
    for (int k = 0; k < w->m->nu; ++k) {
        if (!(w->measure.give[k] > 0.0)) w->x[k] = 0.0;
    }
    return MBSR_OK;
}

/* Moves q along x, halved until the gaps get smaller; *better: whether they do. */
static int move(closer *w, double *q, double *norm, bool *better)
{
    const double before = *norm;
    double share = mbsri_closing_share(w->m, &w->measure, w->x, before);
    *better = false;
    for (int tries = 0; tries < 12 && !*better; ++tries, share *= 0.5) {
        int status = mbsri_positions(w->m, w->d, w->t, q);
        if (!status) status = mbsri_displace(w->m, w->d, q, share, w->x, w->q_try);
        if (!status) status = find_gaps(w, w->q_try, norm);
        if (status < 0) return status;
        *better = !status && *norm < before;
    }
    if (*better) mbsri_copy((size_t)w->m->nq, w->q_try, q);
    return MBSR_OK;
}

/* It is given up where six steps have not halved the gaps: rows depend on each other but for these.
 */
static int iterate(closer *w, double *q, int *iterations, bool *closed)
{
    enum { WINDOW = 6 };
    double norm = 0.0, before[WINDOW];
    bool better = true;
    int status = find_gaps(w, q, &norm);
    for (int step = 0; step < 100 && !status; ++step) {
        const double open = mbsri_closing_widest(w->m, &w->measure, w->g),
                     limit = 1e-12 * mbsri_closing_size(w->m, w->d, &w->measure);
        const bool ends = !better || (step >= WINDOW && norm > 0.5 * before[step % WINDOW]);
        before[step % WINDOW] = norm;
        /* as long as gaps get smaller: what is left opens rows that are left out by more */
        *closed = open <= (ends ? 1e3 : 1e-3) * limit;
        if (*closed || ends) break;
        status = find_step(w);
        if (!status) status = move(w, q, &norm, &better);
        if (!status && !better) status = find_gaps(w, q, &norm);
        ++*iterations;
    }
    return status;
}

int mbsri_close_on_tree(const mbsr_model *m, mbsr_data *d, double t, const mbsr_assembly_opt *opt,
                        const double *offset, double *q, int *iterations, bool *closed)
{
    closer w = {.m = m, .d = d, .t = t, .offset = offset};
    *closed = false;
    int status = open_closer(&w);
    if (!status) status = mbsri_positions(m, d, t, q);
    if (!status) status = mbsri_closing_measure(m, d, opt, &w.measure);
    if (!status) {
        find_resistances(&w);
        status = iterate(&w, q, iterations, closed);
    }
    close_closer(&w);
    return status < 0 ? status : MBSR_OK;
}
