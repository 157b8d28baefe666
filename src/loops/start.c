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
 * their springs get the force that was found, s = -lambda, and the positions the gaps s / k. Stiff rows that depend
 * on others are springs throughout: what the others bear goes over to them as these give way. */
#include "loops/start.h"

#include "algebra/numbers.h"
#include "loops/assemble.h"
#include "loops/balance.h"
#include "loops/motion.h"
#include "loops/ranks.h"
#include "loops/settled.h"

/* Springs and positions are found in turn, as often at most. */
enum { PASSES = 60 };

static bool any_stiff(const mbsri_dense *w)
{
    const mbsri_closure *first = mbsri_all_closures(w->m);
    bool any = false;
    for (const mbsri_closure *c = first; c < first + w->m->closures.count; ++c)
        any = any || mbsri_largest(c->held, c->def.stiffness) > 0.0;
    return any;
}

int mbsri_loops_consistent(mbsri_dense *w, double t, double *q, double *u, double *udot,
                           double *lambda, const mbsr_consistent_opt *opt,
                           mbsr_consistent_info *info)
{
    mbsr_assembly_opt assembly_opt = mbsri_assembly_of(opt);
    mbsr_assembly_info assembly;
    mbsri_ranks here;
    int nearby;
    if (any_stiff(w)) assembly_opt.tolerance *= 1e-2; /* what is left of gaps is a force */
    int status = mbsri_assemble_settled(w, t, q, &assembly_opt, &assembly);
    if (!status) status = mbsri_ranks_around(w, t, q, w->d->dropped, &here, &nearby);
    if (status) return status;
    info->iterations = assembly.iterations;
    mbsri_loops_leave_out(w, false);
    const bool shared = mbsri_springs_let_go(w);
    bool changed = true;
    for (int pass = 0; pass < PASSES && !status && changed; ++pass) {
        if (pass > 0) {
            mbsri_springs_move(w);
            status = mbsri_assemble(w, t, q, &assembly_opt, &assembly);
        }
        if (!status) status = mbsri_balance(w, t, q, u, udot, lambda, opt, info);
        if (!status) status = mbsri_loops_springs(w, t, q, u, lambda);
        if (!status) status = mbsri_springs_load(w, t, q, lambda, shared, &changed);
    }
    return status ? status : mbsri_springs_take(w, lambda);
}
