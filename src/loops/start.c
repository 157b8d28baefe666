/* A consistent state of a model with closures.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   positions      near the guess, with closed loops (assemble.c)
 *   velocities     changed by impulses of the loops alone (motion.c)
 *   u', lambda     from the equations of motion
 *
 * and along directions that move no mass and that no loop holds, by the balance of forces (balance.c).
 *
 * Stiff rows count as rigid here (unless the closure is not settled: then they are forces); afterwards
 * their springs get the force that was found, s = -lambda, and the positions the gaps s / k. */
#include "loops/start.h"

#include "algebra/numbers.h"
#include "base/error.h"
#include "loops/assemble.h"
#include "loops/balance.h"
#include "loops/motion.h"
#include "loops/ranks.h"
#include "model/query.h"
#include "recursion/closures.h"

#include <math.h>

/* Gaps at which the springs of settled rows have their forces; whether they are others than before. */
static bool load_springs(mbsri_dense *w, const double *lambda)
{
    const mbsri_closure *first = w->m->closures.data;
    bool any = false;
    for (const mbsri_closure *c = first; c < first + w->m->closures.count; ++c) {
        for (int k = 0; k < c->held; ++k) {
            if (!mbsri_is_stiff(c, k) || mbsri_is_loose(c, k)) continue;
            const double gap = -lambda[c->row + k] / c->def.stiffness[k];
            any = any || fabs(gap - w->offset[c->held_row + k]) > 1e-14;
            w->offset[c->held_row + k] = gap;
        }
    }
    return any;
}

/* Forces of settled springs at the gaps that they have been given; refused where others were found. */
static int take_springs(const mbsri_dense *w, double *lambda)
{
    const mbsr_model *m = w->m;
    const mbsri_closure *first = m->closures.data;
    const double limit = 1e-6 * mbsri_largest(w->rows, lambda);
    char label[MBSRI_LABEL];
    for (int id = 0; id < (int)m->closures.count; ++id) {
        const mbsri_closure *c = first + id;
        for (int k = 0; k < c->held; ++k) {
            if (!mbsri_is_stiff(c, k) || mbsri_is_loose(c, k)) continue;
            const double force = -w->offset[c->held_row + k] * c->def.stiffness[k],
                         change = fabs(lambda[c->row + k] - force);
            if (change > limit && change > 1e-14 * c->def.stiffness[k])
                return mbsri_fail(&w->d->error, MBSR_NO_CONVERGENCE, MBSR_NONE, MBSR_NONE,
                                  "%s: no positions found at which the springs of %s bear its "
                                  "forces (%.3g is left); settled = 0 takes them as they are",
                                  w->function, mbsri_closure_label(m, id, label), change);
            lambda[c->row + k] = force;
        }
    }
    return MBSR_OK;
}

/* Springs and positions are found in turn, as often at most. */
enum { PASSES = 60 };

int mbsri_loops_consistent(mbsri_dense *w, double t, double *q, double *u, double *udot,
                           double *lambda, const mbsr_consistent_opt *opt,
                           mbsr_consistent_info *info)
{
    const mbsr_assembly_opt standard = mbsri_assembly_standard();
    mbsr_assembly_info assembly;
    mbsri_ranks here;
    int nearby;
    int status = mbsri_assemble(w, t, q, &standard, &assembly);
    if (!status) status = mbsri_ranks_around(w, t, q, w->d->dropped, &here, &nearby);
    if (status) return status;
    info->iterations = assembly.iterations;
    mbsri_loops_leave_out(w, false);
    for (int pass = 0; pass < PASSES && !status; ++pass) {
        status = mbsri_balance(w, t, q, u, udot, lambda, opt, info);
        if (!status) status = mbsri_loops_springs(w, t, q, u, lambda);
        if (status || pass + 1 == PASSES || !load_springs(w, lambda)) break;
        status = mbsri_assemble(w, t, q, &standard, &assembly);
    }
    return status ? status : take_springs(w, lambda);
}
