/* Closing loops with stiff rows: see settled.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "loops/settled.h"

#include "algebra/dense.h"
#include "base/error.h"
#include "base/memory.h"
#include "loops/assemble.h"
#include "loops/ranks.h"
#include "recursion/closures.h"
#include "recursion/kinematics.h"

static bool any_asked(const mbsri_closer *w)
{
    const mbsri_closure *c = mbsri_all_closures(w->m), *end = c + w->m->closures.count;
    bool any = false;
    for (; c < end; ++c) {
        for (int k = 0; k < c->position_rows; ++k)
            any = any || (mbsri_is_stiff(c, k) && mbsri_is_asked(w, c, k));
    }
    return any;
}

/* Lets go of the stiff rows that depend on others at q; *any: whether there are more than before.
 */
static int find_dependent(mbsri_closer *w, double t, const double *q, bool *any)
{
    const mbsri_closure *c = mbsri_all_closures(w->m), *end = c + w->m->closures.count;
    mbsri_ranking ranking;
    mbsri_ranks ranks;
    *any = false;
    if (!any_asked(w)) return MBSR_OK;
    int status = mbsri_ranking_open(&ranking, w->m, w->d, false, w->function);
    if (!status) status = mbsri_positions(w->m, w->d, t, q);
    if (!status) status = mbsri_closure_jacobians(w->m, w->d);
    if (!status) status = mbsri_ranks_here(&ranking, ranking.other, &ranks);
    for (; c < end && !status; ++c) {
        for (int k = 0; k < c->position_rows; ++k) {
            if (!mbsri_is_stiff(c, k) || !mbsri_is_asked(w, c, k) || !ranking.other[c->row + k])
                continue;
            w->let_go[c->row + k] = *any = true;
        }
    }
    mbsri_ranking_close(&ranking);
    return status;
}

int mbsri_assemble_settled(mbsri_closer *w, double t, double *q, const mbsr_assembly_opt *opt,
                           mbsr_assembly_info *info)
{
    bool any = false;
    const size_t nq = (size_t)w->m->nq;
    double *guess = mbsri_allocate(&w->m->allocator, nq * sizeof *guess);
    if (!guess)
        return mbsri_fail(&w->d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "%s: no memory for %d positions", w->function, w->m->nq);
    mbsri_copy(nq, q, guess);
    int status = mbsri_assemble(w, t, q, opt, info);
    if (status == MBSR_LOOP_OPEN) {
        const mbsr_error open = w->d->error;
        status = find_dependent(w, t, guess, &any);
        if (!status && !any) {
            status = MBSR_LOOP_OPEN;
            w->d->error = open;
        }
    }
    if (!status && any) {
        mbsri_copy(nq, guess, q);
        status = mbsri_assemble(w, t, q, opt, info);
    }
    mbsri_release(&w->m->allocator, guess);
    return status;
}
