/* A consistent start on the tree of a model with stiff rows.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A start closes stiff rows like rigid ones and loads their springs with the force that keeps them
 * so, s = -lambda, so that the gaps are s / k: a copy of the model without springs in its rows
 * starts with these gaps, which shift lambda a little, until they agree. Loops of rigid rows close
 * at the nearest common predecessor; that above it the gaps, small as they are, turn with the root
 * is left out of the matrices.
 *
 * Springs that a start takes as they are leave the state to the rigid rows. Where it is one that
 * these allow, and each motion has mass or a loop that holds it, forward dynamics are the start. */
#include "massless/loops_tree_start.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "base/error.h"
#include "base/memory.h"
#include "loops/forward.h"
#include "loops/ranks.h"
#include "massless/rigid_twin.h"
#include "recursion/closures.h"
#include "recursion/kinematics.h"

#include <math.h>

enum { PASSES = 30 };

typedef struct rigid {
    mbsri_rigid_twin twin;
    mbsri_tree_start start; /* of the twin */
    double *u;              /* nu: of the guess */
    double *offset;         /* position rows */
} rigid;

/* Whether some row is stiff, and whether all of these are settled. */
static bool some_stiff(const mbsr_model *m, bool *settled)
{
    const mbsri_closure *c = m->closures.data;
    bool some = false;
    *settled = true;
    for (size_t id = 0; id < m->closures.count; ++id, ++c) {
        for (int k = 0; k < c->rows; ++k) {
            some = some || mbsri_is_stiff(c, k);
            *settled = *settled && !mbsri_is_loose(c, k);
        }
    }
    return some;
}

static int open_rigid(const mbsr_model *m, mbsr_data *d, const double *u, rigid *r)
{
    const size_t nu = (size_t)m->nu, gaps = (size_t)m->position_rows;
    *r = (rigid){.twin = {NULL, NULL}};
    int status = mbsri_rigid_twin_open(m, d, NULL, &r->twin);
    if (status) return status;
    status = mbsri_tree_start_open(&r->start, r->twin.model, r->twin.data);
    if (status) {
        d->error = r->twin.data->error;
        return status;
    }
    r->u = mbsri_allocate(&m->allocator, (nu + gaps + 1) * sizeof(double));
    if (!r->u)
        return mbsri_fail(&d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "mbsr_dae_consistent: no memory for %d position rows", m->position_rows);
    r->offset = r->u + nu;
    mbsri_copy(nu, u, r->u);
    mbsri_zero(gaps, r->offset);
    return MBSR_OK;
}

static void close_rigid(const mbsr_model *m, rigid *r)
{
    mbsri_release(&m->allocator, r->u);
    mbsri_tree_start_close(&r->start);
    mbsri_rigid_twin_close(&r->twin);
}

/* Gaps at which the springs bear lambda; the largest force by which they did not. Not served where
 * such a row is left out (*shared). */
static double load_springs(const mbsr_model *m, const double *lambda, rigid *r, bool *shared)
{
    const mbsri_closure *c = m->closures.data;
    double largest = 0.0;
    for (size_t id = 0; id < m->closures.count; ++id, ++c) {
        for (int k = 0; k < c->position_rows; ++k) {
            if (!mbsri_is_stiff(c, k)) continue;
            double *gap = r->offset + c->position_row + k;
            const double stiffness = c->def.stiffness[k], force = lambda[c->row + k],
                         missing = fabs(force + stiffness * *gap);
            if (missing > 1e-14 * stiffness) largest = fmax(largest, missing);
            *gap = -force / stiffness;
            if (r->twin.data->dropped[c->row + k]) *shared = true;
        }
    }
    return largest;
}

/* The largest of what rigid rows are open by and move by, without stiff ones; work: rows. */
static int find_defect(const mbsr_model *m, mbsr_data *d, double *work, double *open, double *speed)
{
    const mbsri_closure *c = m->closures.data;
    *open = *speed = 0.0;
    int status = mbsri_closure_gaps(m, d, work);
    for (size_t id = 0; id < m->closures.count && !status; ++id) {
        for (int k = 0; k < c[id].position_rows; ++k) {
            if (!mbsri_is_stiff(c + id, k)) *open = fmax(*open, fabs(work[c[id].position_row + k]));
        }
    }
    if (!status) status = mbsri_closure_jacobians(m, d);
    if (!status) status = mbsri_closure_rates(m, d, work);
    for (size_t id = 0; id < m->closures.count && !status; ++id) {
        for (int k = 0; k < c[id].rows; ++k) {
            if (!mbsri_is_stiff(c + id, k)) *speed = fmax(*speed, fabs(work[c[id].row + k]));
        }
    }
    return status;
}

/* Rows, stiff ones as others, that depend on each other at q are marked in the data; *found is
 * false where digits got lost. */
static int find_loose_ranks(const mbsr_model *m, mbsr_data *d, double t, const double *q,
                            bool *found)
{
    mbsri_tree_start s;
    mbsri_ranks ranks;
    int status = mbsri_tree_start_open(&s, m, d);
    if (!status) status = mbsri_positions(m, d, t, q);
    if (!status) status = mbsri_closure_jacobians(m, d);
    if (!status) status = mbsri_row_fronts_rank(s.w.fronts, NULL, NULL, d->dropped, &ranks);
    *found = !status && !mbsri_row_fronts_lost(s.w.fronts);
    mbsri_tree_start_close(&s);
    return status;
}

/* Springs that are taken as they are, in a state that the rigid rows allow, none of these and of
 * the springs dependent: u' and loop forces are those of forward dynamics. */
static int start_loose(const mbsr_model *m, mbsr_data *d, double t, const double *q,
                       const double *u, double *udot, double *lambda, bool *served)
{
    const mbsr_error before = d->error;
    double open, speed;
    int status = find_loose_ranks(m, d, t, q, served);
    for (int k = 0; k < m->rows; ++k) *served = *served && !d->dropped[k];
    if (!status) status = mbsri_velocities(m, d, u);
    if (!status) status = find_defect(m, d, lambda, &open, &speed);
    if (status) return status;
    const double size = fmax(1.0, mbsri_largest((int)m->size.p, d->p));
    if (open > 1e-12 * size || speed > 1e-13 * (1.0 + mbsri_largest(m->nu, u))) *served = false;
    if (!*served) return MBSR_OK;
    status = mbsri_loops_forward(m, d, t, q, u, NULL, NULL, udot, "mbsr_dae_consistent");
    mbsri_copy((size_t)m->rows, d->loop_lambda, lambda);
    *served = !status;
    if (status) d->error = before;
    return status == MBSR_ERR_NO_MEMORY ? status : MBSR_OK;
}

/* One start of a model without stiff rows. */
static int start_rigid_rows(const mbsr_model *m, mbsr_data *d, double t, double *q, double *u,
                            double *udot, double *lambda, const mbsr_consistent_opt *opt,
                            mbsr_consistent_info *info, bool *served)
{
    mbsri_tree_start s;
    int status = mbsri_tree_start_open(&s, m, d);
    if (!status) status = mbsri_tree_start_find(&s, t, NULL, q, u, udot, lambda, opt, info, served);
    mbsri_tree_start_close(&s);
    return status;
}

int mbsri_stiff_tree_start(const mbsr_model *m, mbsr_data *d, double t, double *q, double *u,
                           double *udot, double *lambda, const mbsr_consistent_opt *opt,
                           mbsr_consistent_info *info, bool *served)
{
    const mbsr_error before = d->error;
    bool settled;
    rigid r;
    *served = false;
    if (!some_stiff(m, &settled))
        return start_rigid_rows(m, d, t, q, u, udot, lambda, opt, info, served);
    if (!settled) return start_loose(m, d, t, q, u, udot, lambda, served);
    int status = open_rigid(m, d, u, &r);
    for (int pass = 0; pass < PASSES && !status; ++pass) {
        mbsri_copy((size_t)m->nu, r.u, u);
        status =
            mbsri_tree_start_find(&r.start, t, r.offset, q, u, udot, lambda, opt, info, served);
        if (status || !*served) break;
        bool shared = false;
        const double missing = load_springs(m, lambda, &r, &shared);
        *served = !shared && missing <= 1e-12 * mbsri_largest(m->rows, lambda);
        if (shared || *served) break;
    }
    *served = *served && !status;
    if (status < 0) d->error = r.twin.data->error;
    if (status > 0) d->error = before;
    for (int k = 0; k < m->rows && *served; ++k) d->dropped[k] = r.twin.data->dropped[k];
    close_rigid(m, &r);
    return status > 0 ? MBSR_OK : status;
}
