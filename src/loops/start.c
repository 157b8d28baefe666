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

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "base/error.h"
#include "loops/assemble.h"
#include "loops/balance.h"
#include "loops/motion.h"
#include "loops/ranks.h"
#include "model/query.h"
#include "recursion/closures.h"
#include "recursion/elements.h"
#include "recursion/inverse.h"
#include "recursion/not_finite.h"

#include <math.h>

int mbsri_loops_accelerate(mbsri_dense *w, double t, const double *q, const double *u,
                           const double *tau, double *udot, double *lambda)
{
    mbsri_loops_leave_out(w, true);
    int status = mbsri_loops_factor(w, t, q, u);
    if (!status && w->moving > 0) {
        mbsri_dense_null(w, 0, w->x);
        status = mbsri_loops_refuse(w, w->x, ": its acceleration is not determined");
    }
    if (!status) status = mbsri_loops_rates(w, t, q, u, tau, udot, lambda);
    return status ? status : mbsri_loops_springs(w, t, q, u, lambda);
}

/* The data at (q, u) with the loop forces lambda, and accelerations. */
static int settle(mbsri_dense *w, const double *tau, const double *udot, const double *lambda)
{
    mbsr_data *d = w->d;
    int status = mbsri_closure_jacobians(w->m, d);
    mbsri_copy((size_t)w->rows, lambda, d->loop_lambda);
    d->loaded = true;
    if (!status) status = mbsri_forces(w->m, d, tau);
    if (status) return status;
    mbsri_inverse(w->m, d, udot);
    return MBSR_OK;
}

int mbsri_loops_forward(const mbsr_model *m, mbsr_data *d, double t, const double *q,
                        const double *u, const double *tau, double *udot)
{
    static const char name[] = "mbsr_forward_dynamics";
    mbsri_dense w;
    int status = mbsri_check_input(d, (size_t)m->nu, u, name, "u");
    if (status) return status;
    status = mbsri_dense_open(&w, m, d, name);
    if (!status) {
        double *found = w.out, *lambda = w.out + w.n;
        status = mbsri_loops_accelerate(&w, t, q, u, tau, found, lambda);
        if (!status) status = settle(&w, tau, found, lambda);
        if (!status) status = mbsri_check_result(m, d, (size_t)m->nu, found, name);
        if (!status) mbsri_copy((size_t)m->nu, found, udot);
    }
    mbsri_dense_close(&w);
    return status;
}

/* ---- the start ---- */

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
