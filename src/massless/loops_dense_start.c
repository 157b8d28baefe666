/* A consistent state of a model with closures whose stiff rows share what they bear, or whose ranks
 * fronts do not find: rows chosen in dense linear algebra.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   positions      near the guess, with closed loops (loops/assemble.c)
 *   velocities     changed by impulses of the loops alone (loops/motion.c)
 *   u', lambda     from the equations of motion
 *
 * and where directions move no mass that no loop holds, all but the first by Newton systems
 * (closed_start.h).
 *
 * Stiff rows count as rigid here (unless the closure is not settled: then they are forces);
 * afterwards their springs get the force that was found, s = -lambda, and the positions the gaps
 * s / k. Stiff rows that depend on others share what these bear by their compliance, or are springs
 * throughout: then what the others bear goes over to them as these give way. */
#include "massless/loops_dense_start.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "base/error.h"
#include "base/memory.h"
#include "loops/assemble.h"
#include "loops/motion.h"
#include "loops/ranks.h"
#include "loops/settled.h"
#include "massless/closed_start.h"
#include "massless/rigid_twin.h"
#include "recursion/backward.h"
#include "recursion/closures.h"
#include "recursion/elements.h"
#include "recursion/kinematics.h"

#include <math.h>

/* Springs and positions are found in turn, as often at most; where springs share what they bear it
 * hardly changes. Forces that are known but for so little, and not half as much after IDLE passes
 * more, are known but for rounding. */
enum { PASSES = 60, SHARING = 8, IDLE = 4 };
static const double known = 1e-6;

typedef struct search {
    mbsri_dense *w;
    mbsri_rigid_twin twin;    /* where some stiff row counts as rigid */
    mbsri_closed_start start; /* where something moves no mass */
} search;

static bool any_stiff(const mbsri_dense *w)
{
    const mbsri_closure *first = mbsri_all_closures(w->m);
    bool any = false;
    for (const mbsri_closure *c = first; c < first + w->m->closures.count; ++c)
        any = any || mbsri_largest(c->position_rows, c->def.stiffness) > 0.0;
    return any;
}

static int open_start(search *s)
{
    mbsri_dense *w = s->w;
    int status = MBSR_OK;
    if (s->start.m) return MBSR_OK;
    if (any_stiff(w)) status = mbsri_rigid_twin_open(w->m, w->d, w->left_out, &s->twin);
    if (status) return status;
    const mbsr_model *m = s->twin.model ? s->twin.model : w->m;
    mbsr_data *d = s->twin.model ? s->twin.data : w->d;
    status = mbsri_closed_start_open(&s->start, m, d);
    if (status) w->d->error = d->error;
    for (int k = 0; k < m->rows; ++k) d->dropped[k] = w->d->dropped[k];
    return status;
}

static void close_search(search *s)
{
    mbsri_closed_start_close(&s->start);
    mbsri_rigid_twin_close(&s->twin);
}

/* Velocities, accelerations and loop forces at closed positions, which springs may change. */
static int find_motion(search *s, double t, double *q, double *u, double *udot, double *lambda,
                       const mbsr_consistent_opt *opt, mbsr_consistent_info *info)
{
    mbsri_dense *w = s->w;
    double *given = w->out;
    mbsri_copy((size_t)w->n, u, given);
    int status = mbsri_loops_velocities(w, t, q, u);
    const int directions = w->factor.moving;
    if (!status) status = mbsri_positions(w->m, w->d, t, q);
    if (!status) status = mbsri_velocities(w->m, w->d, u);
    if (!status) status = mbsri_forces(w->m, w->d, NULL, NULL);
    if (!status) status = mbsri_backward(w->m, w->d);
    if (status) return status;
    if (w->d->total_rank == w->m->nu) {
        info->null_directions = 0;
        return mbsri_loops_rates(w, t, q, u, NULL, udot, lambda);
    }
    mbsri_copy((size_t)w->n, given, u);
    status = open_start(s);
    if (!status) {
        status =
            mbsri_closed_start_find(&s->start, t, w->closer.offset, q, u, udot, lambda, opt, info);
        if (status) w->d->error = s->start.d->error;
    }
    info->null_directions = directions;
    return status ? status : mbsri_loops_share(w, lambda);
}

/* Whether springs that the data leaves out are to share what others bear. */
static bool some_share(const mbsri_dense *w)
{
    bool some = false;
    for (int k = 0; k < w->rows; ++k) some = some || (w->d->dropped[k] && !w->left_out[k]);
    return some;
}

/* Springs and positions in turn, from closed positions; apart: springs that depend on others follow
 * these. */
static int find_springs(search *s, double t, bool apart, double *q, double *u, double *udot,
                        double *lambda, const mbsr_consistent_opt *opt, mbsr_consistent_info *info)
{
    mbsri_dense *w = s->w;
    mbsr_assembly_opt assembly_opt = mbsri_assembly_of(opt);
    mbsr_assembly_info assembly;
    if (any_stiff(w)) assembly_opt.tolerance *= 1e-2; /* what is left of gaps is a force */
    mbsri_zero((size_t)w->position_rows, w->closer.offset);
    mbsri_zero((size_t)w->position_rows, w->offset.missed);
    int status = mbsri_positions(w->m, w->d, t, q);
    if (!status) status = mbsri_dense_rows(w);
    mbsri_loops_leave_out(w, false);
    const bool follow = mbsri_springs_let_go(w, apart);
    const int passes = some_share(w) ? SHARING : PASSES;
    double least = INFINITY;
    int idle = 0;
    bool changed = true;
    for (int pass = 0; pass < passes && !status && changed && idle < IDLE; ++pass) {
        if (pass > 0) {
            mbsri_springs_move(w);
            status = mbsri_assemble(&w->closer, t, q, &assembly_opt, &assembly);
        }
        if (!status) status = find_motion(s, t, q, u, udot, lambda, opt, info);
        if (!status) status = mbsri_loops_springs(w, t, q, u, lambda);
        if (!status) status = mbsri_springs_load(w, t, q, lambda, follow, &changed);
        if (status) break;
        const double left = mbsri_springs_left(w);
        idle = left > 0.5 * least && left <= known ? idle + 1 : 0;
        if (left <= 0.5 * least) least = left;
    }
    if (!status && changed && passes == SHARING) status = MBSR_NO_CONVERGENCE;
    if (!status) status = mbsri_springs_take(w, lambda);
    close_search(s);
    return status;
}

/* From closed positions. Springs that depend on others share what these bear; where their gaps are
 * so wide that the rows are independent but for little, they follow instead. */
static int find_shares(mbsri_dense *w, double t, double *q, double *u, double *udot, double *lambda,
                       const mbsr_consistent_opt *opt, mbsr_consistent_info *info)
{
    const size_t nq = (size_t)w->m->nq, nu = (size_t)w->n;
    double *given = mbsri_allocate(&w->m->allocator, (nq + nu + 1) * sizeof *given);
    search s = {.w = w};
    if (!given)
        return mbsri_fail(&w->d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "%s: no memory for %d coordinates", w->function, w->m->nq + w->n);
    mbsri_copy(nq, q, given);
    mbsri_copy(nu, u, given + nq);
    int status = find_springs(&s, t, false, q, u, udot, lambda, opt, info);
    if (status > 0 && some_share(w)) {
        s = (search){.w = w};
        mbsri_copy(nq, given, q);
        mbsri_copy(nu, given + nq, u);
        status = find_springs(&s, t, true, q, u, udot, lambda, opt, info);
    }
    mbsri_release(&w->m->allocator, given);
    return status;
}

int mbsri_loops_dense_start(mbsri_dense *w, double t, double *q, double *u, double *udot,
                            double *lambda, const mbsr_consistent_opt *opt,
                            mbsr_consistent_info *info)
{
    mbsr_assembly_opt assembly_opt = mbsri_assembly_of(opt);
    mbsr_assembly_info assembly;
    mbsri_ranks here;
    int nearby;
    if (any_stiff(w)) assembly_opt.tolerance *= 1e-2;
    int status = mbsri_assemble_settled(&w->closer, t, q, &assembly_opt, &assembly);
    if (!status) status = mbsri_ranks_around(w, t, q, w->d->dropped, &here, &nearby);
    info->iterations = assembly.iterations;
    return status ? status : find_shares(w, t, q, u, udot, lambda, opt, info);
}
