/* A consistent start on the tree of a model with stiff rows.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A start closes stiff rows like rigid ones and loads their springs with the force that keeps them
 * so, s = -lambda, so that the gaps are s / k: a copy of the model without springs in its rows
 * starts with these gaps, which shift lambda a little, until they agree. Loops of rigid rows close
 * at the nearest common predecessor; that above it the gaps, small as they are, turn with the root
 * is left out of the matrices.
 *
 * Stiff rows that depend on others, rigid or stiff, are left out of the equations, and exert what
 * their gaps say; from pass to pass all settled ones take the gaps at which they share by their
 * compliance what they bear together.
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

typedef struct rigid {
    mbsri_rigid_twin twin;
    mbsri_tree_start start; /* of the twin */
    double *u;              /* nu: of the guess */
    double *offset;         /* position rows */
    double *stiffness;      /* rows: of the model, 0: rigid */
    double *borne, *tau;    /* rows, nu: see loops_tree_start.h */
    double *forces;         /* rows: that springs lack, and as they share them */
    int *late;              /* rows: which go first of those that depend on each other */
    bool *stiff, *other;    /* rows */
} rigid;

enum { RIGID, STIFF, SOFT };

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
    const size_t nu = (size_t)m->nu, gaps = (size_t)m->position_rows, rows = (size_t)m->rows;
    const mbsri_closure *c = m->closures.data;
    *r = (rigid){.twin = {NULL, NULL}};
    int status = mbsri_rigid_twin_open(m, d, NULL, &r->twin);
    if (status) return status;
    status = mbsri_tree_start_open(&r->start, r->twin.model, r->twin.data);
    if (status) {
        d->error = r->twin.data->error;
        return status;
    }
    r->u = mbsri_allocate(&m->allocator, (2 * nu + gaps + 3 * rows + 1) * sizeof(double) +
                                             rows * (sizeof(int) + 2 * sizeof(bool)));
    if (!r->u)
        return mbsri_fail(&d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "mbsr_dae_consistent: no memory for %d rows of closures", m->rows);
    r->tau = r->u + nu;
    r->offset = r->tau + nu;
    r->stiffness = r->offset + gaps;
    r->borne = r->stiffness + rows;
    r->forces = r->borne + rows;
    r->late = (int *)(void *)(r->forces + rows);
    r->stiff = (bool *)(r->late + rows);
    r->other = r->stiff + rows;
    mbsri_copy(nu, u, r->u);
    mbsri_zero(gaps, r->offset);
    for (size_t id = 0; id < m->closures.count; ++id, ++c) {
        for (int k = 0; k < c->rows; ++k) {
            r->stiffness[c->row + k] = c->def.stiffness[k];
            r->stiff[c->row + k] = mbsri_is_stiff(c, k);
        }
    }
    return MBSR_OK;
}

static void close_rigid(const mbsr_model *m, rigid *r)
{
    mbsri_release(&m->allocator, r->u);
    mbsri_tree_start_close(&r->start);
    mbsri_rigid_twin_close(&r->twin);
}

/* ---- rows that share what they bear ---- */

static bool some_left_out(const mbsr_model *m, const rigid *r)
{
    bool some = false;
    for (int k = 0; k < m->rows; ++k) some = some || (r->stiff[k] && r->twin.data->dropped[k]);
    return some;
}

/* Of rows that depend on each other rigid ones stay, and then stiff ones that are not soft beside
 * others of their closure: the mechanism moves against soft ones. At the guess. */
static int order_rows(const mbsr_model *m, rigid *r, double t, const double *q)
{
    static const double soft = 1e-2;
    const mbsri_closure *c = m->closures.data;
    int status = mbsri_positions(r->twin.model, r->twin.data, t, q);
    if (!status) status = mbsri_closure_jacobians(r->twin.model, r->twin.data);
    if (status || !r->start.w.fronts) return status;
    const double *scale = mbsri_row_fronts_scales(r->start.w.fronts);
    for (size_t id = 0; id < m->closures.count; ++id, ++c) {
        double most = 0.0;
        for (int row = c->row; row < c->row + c->position_rows; ++row)
            most = fmax(most, r->stiffness[row] * scale[row] * scale[row]);
        for (int row = c->row; row < c->row + c->rows; ++row)
            r->late[row] = !r->stiff[row]                                              ? RIGID
                           : r->stiffness[row] * scale[row] * scale[row] < soft * most ? SOFT
                                                                                       : STIFF;
    }
    mbsri_row_fronts_order(r->start.w.fronts, r->late);
    return MBSR_OK;
}

/* The rows that the run leaves out: where rows of a closure depend on others its soft ones all do
 * without, too. */
static void choose_rows(const mbsr_model *m, const rigid *r, bool *dropped)
{
    const mbsri_closure *c = m->closures.data;
    for (size_t id = 0; id < m->closures.count; ++id, ++c) {
        bool some = false;
        for (int row = c->row; row < c->row + c->rows; ++row) {
            dropped[row] = r->twin.data->dropped[row];
            some = some || (dropped[row] && r->stiff[row]);
        }
        for (int row = c->row; row < c->row + c->rows && some; ++row)
            dropped[row] = dropped[row] || r->late[row] == SOFT;
    }
}

/* Whether the rigid rows that are left out depend on rigid ones alone; after the derivatives. */
static int check_rigid(const mbsr_model *m, rigid *r, bool *alone)
{
    const bool *dropped = r->twin.data->dropped;
    mbsri_ranks ranks;
    bool any = false;
    *alone = true;
    for (int k = 0; k < m->rows; ++k) any = any || (dropped[k] && !r->stiff[k]);
    if (!any) return MBSR_OK;
    const int status = mbsri_row_fronts_rank(r->start.w.fronts, r->stiff, NULL, r->other, &ranks);
    for (int k = 0; k < m->rows; ++k) *alone = *alone && (r->stiff[k] || dropped[k] == r->other[k]);
    return status;
}

/* From now on rows that are left out are springs in the twin, too, which exert what they are told
 * to; *served: whether that can be. */
static int begin_sharing(const mbsr_model *m, rigid *r, bool *served)
{
    static const double nearly_nothing = 1e-250;
    mbsri_closure *c = r->twin.model->closures.data;
    *served = r->start.w.fronts && !r->start.start.m;
    if (!*served) return MBSR_OK;
    int status = mbsri_closure_jacobians(r->twin.model, r->twin.data);
    if (!status) status = check_rigid(m, r, served);
    for (size_t id = 0; id < m->closures.count && !status && *served; ++id, ++c) {
        for (int k = 0; k < c->position_rows; ++k) {
            const int row = c->row + k;
            if (!r->stiff[row] || !r->twin.data->dropped[row]) continue;
            c->def.stiffness[k] = nearly_nothing;
            r->start.w.closer.let_go[row] = true;
        }
    }
    r->start.stiffness = r->stiffness;
    r->start.borne = r->borne;
    r->start.tau = r->tau;
    return status;
}

/* lambda, as all settled rows share it by their compliance. */
static int share(rigid *r, double *lambda)
{
    const int status = mbsri_closure_jacobians(r->twin.model, r->twin.data);
    return status ? status
                  : mbsri_row_fronts_share(r->start.w.fronts, r->stiffness, r->twin.data->dropped,
                                           lambda);
}

/* ---- gaps ---- */

/* What springs lack of lambda at their gaps, into r->forces; of those that are left out, which do
 * what their gaps say, nothing. The largest of these. */
static double find_missing(const mbsr_model *m, const double *lambda, rigid *r)
{
    static const double rounding = 1e-14; /* of gaps */
    const mbsri_closure *c = m->closures.data;
    double largest = 0.0;
    mbsri_zero((size_t)m->rows, r->forces);
    for (size_t id = 0; id < m->closures.count; ++id, ++c) {
        for (int k = 0; k < c->position_rows; ++k) {
            const int row = c->row + k;
            const double stiffness = r->stiffness[row],
                         missing = lambda[row] + stiffness * r->offset[c->position_row + k];
            if (!r->stiff[row] || r->twin.data->dropped[row]) continue;
            r->forces[row] = missing;
            if (fabs(missing) > rounding * stiffness) largest = fmax(largest, fabs(missing));
        }
    }
    return largest;
}

/* Gaps by which the springs exert r->forces more. */
static void move_springs(const mbsr_model *m, rigid *r)
{
    const mbsri_closure *c = m->closures.data;
    for (size_t id = 0; id < m->closures.count; ++id, ++c) {
        for (int k = 0; k < c->position_rows; ++k) {
            const int row = c->row + k;
            if (r->stiff[row]) r->offset[c->position_row + k] -= r->forces[row] / r->stiffness[row];
        }
    }
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

/* Passes until the springs bear what they did before, but for rounding: *served. */
static int settle(const mbsr_model *m, rigid *r, double t, double *q, double *u, double *udot,
                  double *lambda, const mbsr_consistent_opt *opt, mbsr_consistent_info *info,
                  bool *served)
{
    enum { PASSES = 30, IDLE = 4 };
    static const double enough = 1e-12, known = 1e-6;
    double least = INFINITY;
    int idle = 0;
    int status = order_rows(m, r, t, q);
    for (int pass = 0; pass < PASSES && !status; ++pass) {
        mbsri_copy((size_t)m->nu, r->u, u);
        status =
            mbsri_tree_start_find(&r->start, t, r->offset, q, u, udot, lambda, opt, info, served);
        if (status || !*served) return status;
        const bool shares = some_left_out(m, r), begins = shares && !r->start.stiffness;
        if (begins) status = begin_sharing(m, r, served);
        if (status || !*served) return status;
        const double missing = find_missing(m, lambda, r), most = mbsri_largest(m->rows, lambda);
        if (missing <= enough * most && !begins) return MBSR_OK;
        idle = missing > 0.5 * least && missing <= known * most ? idle + 1 : 0;
        if (shares && idle == IDLE) return MBSR_OK;
        if (missing < 0.5 * least) least = missing;
        if (shares) status = share(r, r->forces);
        move_springs(m, r);
    }
    *served = false;
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
    if (!status) status = settle(m, &r, t, q, u, udot, lambda, opt, info, served);
    *served = *served && !status;
    if (status < 0 && r.twin.data) d->error = r.twin.data->error;
    if (status > 0) d->error = before;
    if (*served) choose_rows(m, &r, d->dropped);
    close_rigid(m, &r);
    return status > 0 ? MBSR_OK : status;
}
