/* A consistent start of a model with closures, front by front: see loops_tree_start.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   positions      near the guess, with closed loops (loops/assemble.c); there and beside it the
 *       rows that depend on others are found (loops/ranks.h), and left out of what follows, as are
 *       those that depend on others at a singular position alone
 *   velocities     changed by impulses of the loops alone
 *   u', lambda     from the equations of motion
 *
 * the last two from the equations with loops (loops/forward.c), or by Newton systems where
 * directions move no mass (closed_start.h). */
#include "massless/loops_tree_start.h"

#include "algebra/dense.h"
#include "loops/forward.h"
#include "loops/ranks.h"
#include "loops/row_fronts.h"
#include "recursion/backward.h"
#include "recursion/elements.h"
#include "recursion/kinematics.h"

#include <math.h>

static const char function[] = "mbsr_dae_consistent";

int mbsri_tree_start_open(mbsri_tree_start *s, const mbsr_model *m, mbsr_data *d)
{
    *s = (mbsri_tree_start){.m = m, .d = d};
    return mbsri_ranking_open(&s->w, m, d, true, function);
}

void mbsri_tree_start_close(mbsri_tree_start *s)
{
    if (!s->m) return;
    mbsri_closed_start_close(&s->start);
    mbsri_ranking_close(&s->w);
}

/* The rows that depend on others, in the data, and at a singular position those that do there, in
 * left_out. */
static int rank_rows(mbsri_tree_start *s, double t, const double *q)
{
    mbsri_ranks here, there;
    int nearby, status = mbsri_ranks_around(&s->w, t, q, s->d->dropped, &here, &nearby);
    for (int k = 0; k < s->m->rows; ++k) s->w.left_out[k] = s->d->dropped[k];
    if (!status && nearby > here.independent)
        status = mbsri_ranks_without(&s->w, s->d->dropped, s->w.left_out, &there);
    s->ranked = !status;
    return status;
}

static int close_positions(mbsri_tree_start *s, double t, const double *offset, double *q,
                           const mbsr_consistent_opt *opt, mbsr_consistent_info *info)
{
    mbsr_assembly_opt assembly_opt = mbsri_assembly_of(opt);
    mbsr_assembly_info assembly;
    if (offset) assembly_opt.tolerance *= 1e-2; /* what is left of gaps is a force */
    for (int k = 0; k < s->m->position_rows; ++k) s->w.closer.offset[k] = offset ? offset[k] : 0.0;
    const int status = mbsri_assemble(&s->w.closer, t, q, &assembly_opt, &assembly);
    info->iterations = assembly.iterations;
    return status;
}

/* Whether all joint rates move mass, at rest. */
static int look_for_masses(mbsri_tree_start *s, double t, const double *q, bool *massive)
{
    mbsri_zero((size_t)s->m->nu, s->w.x);
    int status = mbsri_positions(s->m, s->d, t, q);
    if (!status) status = mbsri_velocities(s->m, s->d, s->w.x);
    if (!status) status = mbsri_forces(s->m, s->d, NULL, NULL);
    if (!status) status = mbsri_backward(s->m, s->d);
    *massive = s->d->total_rank == s->m->nu;
    return status;
}

/* Forces of rows that share what others bear: by the gaps that the others leave them, as they ask
 * for but for rounding. At the positions of the data. */
static int bear(mbsri_tree_start *s, const double *offset)
{
    static const double rounding = 1e-13;
    const mbsr_model *m = s->m;
    const mbsri_closing *measure = &s->w.closer.closing;
    const mbsri_closure *c = m->closures.data;
    const double size = rounding * mbsri_closing_size(m, s->d, measure);
    int status = mbsri_closure_gaps(m, s->d, s->w.g);
    if (!status) status = mbsri_closure_jacobians(m, s->d);
    mbsri_zero((size_t)m->rows, s->borne);
    for (size_t id = 0; id < m->closures.count && !status; ++id, ++c) {
        for (int k = 0; k < c->position_rows; ++k) {
            const int row = c->row + k, at = c->position_row + k;
            const bool same = fabs(s->w.g[at] - offset[at]) <= size * measure->gap[at];
            if (s->w.left_out[row])
                s->borne[row] = -s->stiffness[row] * (same ? offset[at] : s->w.g[at]);
        }
    }
    if (!status) mbsri_closure_transpose(m, s->d, s->borne, s->tau);
    return status;
}

/* u' and lambda where all joint rates move mass. */
static int find_accelerations(mbsri_tree_start *s, double t, const double *offset, const double *q,
                              const double *u, double *udot, double *lambda)
{
    const mbsr_model *m = s->m;
    const bool shares = s->stiffness != NULL;
    int status = shares ? bear(s, offset) : MBSR_OK;
    if (!status)
        status = mbsri_loops_forward(m, s->d, t, q, u, shares ? s->tau : NULL, s->w.left_out, udot,
                                     function);
    mbsri_copy((size_t)m->rows, s->d->loop_lambda, lambda);
    for (int k = 0; k < m->rows && shares; ++k) {
        if (s->w.left_out[k] && s->stiffness[k] > 0.0) lambda[k] = s->borne[k];
    }
    return status;
}

/* Exchanges the rows that the data leaves out, with which Newton systems are regular at most
 * positions, and those that are left out here. */
static void exchange_left_out(const mbsri_tree_start *s)
{
    for (int k = 0; k < s->m->rows; ++k) {
        const bool dropped = s->d->dropped[k];
        s->d->dropped[k] = s->w.left_out[k];
        s->w.left_out[k] = dropped;
    }
}

/* Loop forces at the state that a search begins with, as the index report finds them: directions
 * that they alone hold are held from the beginning. Zero where they cannot be had, and where rows
 * depend on each other, so that nothing tells which of them bears what. */
static int guess_forces(mbsri_tree_start *s, double t, const double *q, const double *u,
                        double *lambda)
{
    const mbsr_model *m = s->m;
    const mbsri_closure *c = mbsri_all_closures(m), *end = c + m->closures.count;
    bool *left_out = s->w.other;
    double load, *doubt = s->w.out;
    mbsri_zero((size_t)m->rows, lambda);
    for (; c < end; ++c) {
        for (int row = c->row; row < c->row + c->rows; ++row) {
            left_out[row] = mbsri_is_loose(c, row - c->row);
            if (s->w.left_out[row] && !left_out[row]) return MBSR_OK;
        }
    }
    const int status =
        mbsri_loops_settled(m, s->d, t, q, u, left_out, s->w.span, lambda, doubt, &load, function);
    if (!status)
        mbsri_row_fronts_clear_traces(s->w.fronts, load, doubt, lambda);
    else
        mbsri_zero((size_t)m->rows, lambda);
    return status < 0 ? status : MBSR_OK;
}

/* Velocities, u' and lambda at closed positions. */
static int find_motion(mbsri_tree_start *s, double t, const double *offset, double *q, double *u,
                       double *udot, double *lambda, const mbsr_consistent_opt *opt,
                       mbsr_consistent_info *info)
{
    const mbsr_model *m = s->m;
    mbsr_data *d = s->d;
    bool massive = false;
    int status = look_for_masses(s, t, q, &massive);
    if (!status && !massive && !s->start.m) status = mbsri_closed_start_open(&s->start, m, d);
    if (status) return status;
    if (!massive) {
        int directions;
        status = mbsri_loops_count_free(m, d, s->w.left_out, false, function, &directions);
        if (!status) status = guess_forces(s, t, q, u, lambda);
        exchange_left_out(s);
        if (!status)
            status = mbsri_closed_start_find(&s->start, t, offset, q, u, udot, lambda, opt, info);
        exchange_left_out(s);
        if (!status) status = mbsri_loops_take_springs(m, d, t, q, u, NULL, lambda);
        info->null_directions = directions;
        return status;
    }
    info->null_directions = 0;
    status = mbsri_loops_push(m, d, t, q, s->w.left_out, u, function);
    return status ? status : find_accelerations(s, t, offset, q, u, udot, lambda);
}

int mbsri_tree_start_find(mbsri_tree_start *s, double t, const double *offset, double *q, double *u,
                          double *udot, double *lambda, const mbsr_consistent_opt *opt,
                          mbsr_consistent_info *info)
{
    int status = close_positions(s, t, offset, q, opt, info);
    if (!status && !s->ranked) status = rank_rows(s, t, q);
    return status ? status : find_motion(s, t, offset, q, u, udot, lambda, opt, info);
}
