/* A consistent start of a model with closures, on the tree: see loops_tree_start.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Positions are those of loops/close_tree.c, the rest follows by Newton systems (closed_start.h).
 * Where that fails, rows may depend on each other. Which ones do is found cluster by cluster
 * (loops/clusters.h), in the closed position and in one nearby; they are left out, and what is left
 * of them is looked at in the end. */
#include "massless/loops_tree_start.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "base/error.h"
#include "base/memory.h"
#include "loops/assemble.h"
#include "loops/close_tree.h"
#include "loops/clusters.h"
#include "massless/closed_start.h"
#include "recursion/closures.h"
#include "recursion/kinematics.h"

#include <math.h>

typedef struct work {
    const mbsr_model *m;
    mbsr_data *d;
    double t;
    mbsri_closed_start start;
    bool begun; /* there is one */
    double *q, *u, *lambda;
    const double *offset;              /* held: what the gaps are to be; NULL: zero */
    double *q_try, *q_given, *u_given; /* nq, nq, nu */
    double *rate, *row;                /* nu, rows: scratch */
    bool *there;                       /* rows: left out nearby */
    bool good;
    void *memory;
} work;

static int open_work(work *w)
{
    const size_t nq = (size_t)w->m->nq, nu = (size_t)w->m->nu, rows = (size_t)w->m->rows,
                 numbers = 2 * nq + 2 * nu + rows;
    w->memory =
        mbsri_allocate(&w->m->allocator, numbers * sizeof(double) + (rows + 1) * sizeof(bool));
    if (!w->memory)
        return mbsri_fail(&w->d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "mbsr_dae_consistent: no memory for %zu numbers", numbers);
    w->q_try = w->memory;
    w->q_given = w->q_try + nq;
    w->u_given = w->q_given + nq;
    w->rate = w->u_given + nu;
    w->row = w->rate + nu;
    w->there = (bool *)(void *)(w->row + rows);
    mbsri_copy(nq, w->q, w->q_given);
    mbsri_copy(nu, w->u, w->u_given);
    return MBSR_OK;
}

static void close_work(work *w)
{
    mbsri_closed_start_close(&w->start);
    mbsri_release(&w->m->allocator, w->memory);
}

/* Closed positions; not good where there are none. */
static int close_positions(work *w, const mbsr_consistent_opt *opt, mbsr_consistent_info *info)
{
    const mbsr_assembly_opt assembly = mbsri_assembly_of(opt);
    return mbsri_close_on_tree(w->m, w->d, w->t, &assembly, w->offset, w->q, &info->iterations,
                               &w->good);
}

/* The state at closed positions; not good where there is none. */
static int find_state(work *w, double *udot, const mbsr_consistent_opt *opt,
                      mbsr_consistent_info *info)
{
    int status = w->begun ? MBSR_OK : mbsri_closed_start_open(&w->start, w->m, w->d);
    w->begun = true;
    if (status) return status;
    status =
        mbsri_closed_start_find(&w->start, w->t, w->offset, w->q, w->u, udot, w->lambda, opt, info);
    if (status > 0) w->good = false;
    return status < 0 ? status : MBSR_OK;
}

/* ---- redundant rows ---- */

/* Rows that depend on others at the positions q, or would if these were not open by that much, and
 * how many do not. */
static int choose_rows(work *w, const double *q, double open, bool *dropped, int *independent)
{
    const double far = 30.0 * open / (w->m->length > 0.0 ? w->m->length : 1.0),
                 dependent = fmax(MBSRI_DEPENDENT, fmin(far * far, 1e-2));
    bool served = false;
    mbsri_ranks found;
    int status = mbsri_positions(w->m, w->d, w->t, q);
    if (!status) status = mbsri_ranks_by_clusters(w->m, w->d, dependent, dropped, &found, &served);
    if (!served) w->good = false;
    *independent = found.independent;
    return status;
}

/* The largest gap at q of all rows, those left out too. */
static int widest_gap(work *w, const double *q, double *gap)
{
    int status = mbsri_positions(w->m, w->d, w->t, q);
    if (!status) status = mbsri_closure_gaps(w->m, w->d, w->row);
    for (int k = 0; k < w->m->held && w->offset; ++k) w->row[k] -= w->offset[k];
    *gap = mbsri_largest(w->m->held, w->row);
    return status;
}

static bool closed(const work *w, double open)
{
    return open <= 1e-10 * fmax(1.0, mbsri_largest((int)w->m->size_p, w->d->p));
}

/* Closes the loops without the rows that are redundant where the gaps are: what depends but for the
 * gap counts as redundant. */
static int close_without(work *w, const mbsr_consistent_opt *opt, mbsr_consistent_info *info)
{
    enum { PASSES = 8 };
    double open = 0.0;
    int independent, status = widest_gap(w, w->q, &open);
    for (int pass = 0; pass < PASSES && !status; ++pass) {
        w->good = true;
        status = choose_rows(w, w->q, open, w->d->dropped, &independent);
        if (status || !w->good) return status;
        status = close_positions(w, opt, info);
        if (!status) status = widest_gap(w, w->q, &open);
        if (closed(w, open)) return status;
    }
    w->good = false;
    return status;
}

/* The rows that are redundant in the closed position; not good where more are independent in one
 * nearby in which those that are independent here stay closed: the position is singular
 * (loops/ranks.h). */
static int choose_nearby(work *w, const mbsr_consistent_opt *opt, mbsr_consistent_info *info)
{
    static const double step = 1e-3; /* rad or m */
    const mbsr_model *m = w->m;
    double *q = w->q, *there = w->q_given, *rate = w->rate, open = 0.0;
    int here = 0, nearby = 0, status = widest_gap(w, q, &open);
    if (!status) status = choose_rows(w, q, open, w->d->dropped, &here);
    if (status || !w->good) return status;
    for (int k = 0; k < m->nu; ++k) rate[k] = fmod(0.6180339887498949 * (k + 1), 1.0) - 0.5;
    status = mbsri_velocities(m, w->d, rate);
    if (!status) status = mbsri_coordinate_rates(m, w->d, w->q_try);
    for (int k = 0; k < m->nq; ++k) there[k] = q[k] + step * w->q_try[k];
    if (!status) status = mbsri_normalise(m, w->d, there);
    w->q = there;
    if (!status) status = close_positions(w, opt, info);
    if (!status) status = widest_gap(w, there, &open);
    if (!status && w->good) status = choose_rows(w, there, open, w->there, &nearby);
    w->q = q;
    w->good = nearby <= here; /* also without such a position */
    return status;
}

/* Not good where rows that were left out are violated. */
static int check_left_out(work *w)
{
    double open;
    int status = widest_gap(w, w->q, &open);
    if (!status) status = mbsri_velocities(w->m, w->d, w->u);
    if (!status) status = mbsri_closure_jacobians(w->m, w->d);
    if (!status) status = mbsri_closure_rates(w->m, w->d, w->row);
    const double speed = 1.0 + mbsri_largest(w->m->nu, w->u);
    if (mbsri_largest(w->m->rows, w->row) > 1e-9 * speed) w->good = false;
    return status;
}

static int start_without(work *w, double *udot, const mbsr_consistent_opt *opt,
                         mbsr_consistent_info *info)
{
    const mbsr_model *m = w->m;
    mbsri_copy((size_t)m->nq, w->q_given, w->q);
    mbsri_copy((size_t)m->nu, w->u_given, w->u);
    mbsri_zero((size_t)m->rows, w->lambda);
    mbsri_zero((size_t)m->nu, udot);
    w->good = true;
    info->iterations = 0;
    int status = close_without(w, opt, info);
    if (!status && w->good) status = choose_nearby(w, opt, info);
    if (!status && w->good) status = find_state(w, udot, opt, info);
    if (!status && w->good) status = check_left_out(w);
    return status;
}

int mbsri_loops_tree_start(const mbsr_model *m, mbsr_data *d, double t, const double *offset,
                           double *q, double *u, double *udot, double *lambda,
                           const mbsr_consistent_opt *opt, mbsr_consistent_info *info, bool *served)
{
    const mbsr_error before = d->error;
    work w = {
        .m = m, .d = d, .t = t, .q = q, .u = u, .lambda = lambda, .offset = offset, .good = true};
    *served = false;
    for (int k = 0; k < m->rows; ++k) d->dropped[k] = false;
    mbsri_zero((size_t)m->rows, lambda);
    mbsri_zero((size_t)m->nu, udot);
    int status = open_work(&w);
    if (!status) status = close_positions(&w, opt, info);
    if (!status && w.good) status = find_state(&w, udot, opt, info);
    if (!status && !w.good) status = start_without(&w, udot, opt, info);
    *served = !status && w.good;
    close_work(&w);
    if (*served || (status < 0 && status != MBSR_ERR_SPACE)) return status;
    d->error = before;
    return MBSR_OK;
}
