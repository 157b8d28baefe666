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
 * Springs that a start takes as they are stay springs in the copy: forces in a state that the other
 * rows allow. */
#include "massless/loops_tree_start.h"
#include "massless/open.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "base/error.h"
#include "base/memory.h"
#include "loops/forward.h"
#include "loops/ranks.h"
#include "model/query.h"
#include "massless/rigid_twin.h"
#include "recursion/closures.h"
#include "recursion/kinematics.h"

#include <math.h>

typedef struct rigid {
    mbsri_rigid_twin twin;
    mbsri_tree_start start; /* of the twin */
    double *q, *u;          /* nq, nu: of the guess */
    double *offset;         /* position rows */
    double *stiffness;      /* rows: of the model, 0: rigid */
    double *borne, *tau;    /* rows, nu: see loops_tree_start.h */
    double *forces;         /* rows: that springs lack, and as they share them */
    double *moved;          /* position rows: by how much gaps were to change last */
    double relaxation;      /* the share of that by which they did */
    int *late;              /* rows: which go first of those that depend on each other */
    bool *stiff, *loose;    /* rows: settled springs; those taken as they are */
    bool *other, *more;     /* rows: for a short time */
    bool shares;            /* whether some of these are left out, and exert what their gaps say */
} rigid;

static int allocate_rigid(const mbsr_model *m, mbsr_data *d, rigid *r)
{
    const size_t nq = (size_t)m->nq, nu = (size_t)m->nu, gaps = (size_t)m->position_rows,
                 rows = (size_t)m->rows;
    r->u = mbsri_allocate(&m->allocator, (nq + 2 * nu + 2 * gaps + 3 * rows) * sizeof(double) +
                                             rows * (sizeof(int) + 4 * sizeof(bool)));
    if (!r->u)
        return mbsri_fail(&d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "mbsr_dae_consistent: no memory for %d rows of closures", m->rows);
    r->q = r->u + nu;
    r->tau = r->q + nq;
    r->offset = r->tau + nu;
    r->moved = r->offset + gaps;
    r->stiffness = r->moved + gaps;
    r->borne = r->stiffness + rows;
    r->forces = r->borne + rows;
    r->late = (int *)(void *)(r->forces + rows);
    r->stiff = (bool *)(r->late + rows);
    r->loose = r->stiff + rows;
    r->other = r->loose + rows;
    r->more = r->other + rows;
    mbsri_zero(2 * gaps, r->offset);
    return MBSR_OK;
}

static int open_rigid(const mbsr_model *m, mbsr_data *d, const double *q, const double *u, rigid *r)
{
    const mbsri_closure *c = m->closures.data;
    *r = (rigid){.relaxation = 1.0};
    int status = allocate_rigid(m, d, r);
    if (status) return status;
    mbsri_copy((size_t)m->nq, q, r->q);
    mbsri_copy((size_t)m->nu, u, r->u);
    for (size_t id = 0; id < m->closures.count; ++id, ++c) {
        for (int k = 0, row = c->row; k < c->rows; ++k, ++row) {
            r->loose[row] = mbsri_is_loose(c, k);
            r->stiff[row] = mbsri_is_stiff(c, k) && !r->loose[row];
            r->stiffness[row] = r->stiff[row] ? c->def.stiffness[k] : 0.0;
            r->late[row] = 0;
        }
    }
    status = mbsri_rigid_twin_open(m, d, r->loose, &r->twin);
    if (status) return status;
    status = mbsri_tree_start_open(&r->start, r->twin.model, r->twin.data);
    if (status) d->error = r->twin.data->error;
    return status;
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

/* Which rows that depend on others are left out first; at the guess. */
static int order_rows(const mbsr_model *m, rigid *r, double t, const double *q)
{
    int status = mbsri_positions(r->twin.model, r->twin.data, t, q);
    if (!status) status = mbsri_closure_jacobians(r->twin.model, r->twin.data);
    if (status) return status;
    mbsri_late_rows(m, mbsri_row_fronts_scales(r->start.w.fronts), r->late);
    mbsri_row_fronts_order(r->start.w.fronts, r->late);
    return MBSR_OK;
}

/* Whether the rigid rows that are left out depend on rigid ones alone; after the derivatives. */
static int check_rigid(const mbsr_model *m, rigid *r, bool *alone)
{
    const bool *dropped = r->twin.data->dropped;
    mbsri_ranks ranks;
    bool any = false;
    *alone = true;
    for (int k = 0; k < m->rows; ++k) {
        r->more[k] = r->stiff[k] || r->loose[k];
        any = any || (dropped[k] && !r->more[k]);
    }
    if (!any) return MBSR_OK;
    const int status = mbsri_row_fronts_rank(r->start.w.fronts, r->more, NULL, r->other, &ranks);
    for (int k = 0; k < m->rows; ++k) *alone = *alone && (r->more[k] || dropped[k] == r->other[k]);
    return status;
}

/* From now on rows that are left out are springs in the twin, too. Where all joint rates move mass
 * they exert what they are told to; else what their gaps say. */
static int begin_sharing(const mbsr_model *m, rigid *r)
{
    static const double nearly_nothing = 1e-250;
    const bool massive = !r->start.start.m;
    const mbsri_closure *given = m->closures.data;
    mbsri_closure *c = r->twin.model->closures.data;
    bool alone = true;
    int status = mbsri_closure_jacobians(r->twin.model, r->twin.data);
    if (!status) status = check_rigid(m, r, &alone);
    if (status) return status;
    if (!alone)
        return mbsri_fail(&r->twin.data->error, MBSR_NO_CONVERGENCE, MBSR_NONE, MBSR_NONE,
                          "mbsr_dae_consistent: not found which rows of closures depend on others, "
                          "rigid or stiff; settled = 0 takes springs as they are");
    mbsri_leave_soft(m, r->late, r->twin.data->dropped);
    for (size_t id = 0; id < m->closures.count; ++id) {
        for (int k = 0, row = c[id].row; k < c[id].position_rows; ++k, ++row) {
            if (!r->stiff[row] || !r->twin.data->dropped[row]) continue;
            r->start.w.left_out[row] = true;
            c[id].def.stiffness[k] = massive ? nearly_nothing : given[id].def.stiffness[k];
            c[id].def.damping[k] = massive ? 0.0 : given[id].def.damping[k];
            r->start.w.closer.let_go[row] = true;
        }
    }
    mbsri_rigid_twin_forget_plan(&r->twin);
    mbsri_closed_start_close(&r->start.start); /* its solver knows them as rigid */
    r->start.start.m = NULL;
    r->start.stiffness = massive ? r->stiffness : NULL;
    r->start.borne = r->borne;
    r->start.tau = r->tau;
    r->shares = true;
    return MBSR_OK;
}

/* r->forces, as all settled rows share them by their compliance. */
static int share_forces(const mbsr_model *m, rigid *r)
{
    const int status = mbsri_closure_jacobians(r->twin.model, r->twin.data);
    for (int k = 0; k < m->rows; ++k)
        r->other[k] = r->loose[k] || (r->twin.data->dropped[k] && !r->stiff[k]);
    return status ? status
                  : mbsri_row_fronts_share(r->start.w.fronts, r->stiffness, r->other, r->forces);
}

/* ---- gaps ---- */

/* What springs lack of lambda at their gaps, into r->forces; of those that are left out, which do
 * what their gaps say, nothing. The largest of these, and of all of lambda, *most: as works along
 * what gaps compare to. */
static double find_missing(const mbsr_model *m, const double *lambda, rigid *r, double *most)
{
    const mbsri_closing *measure = &r->start.w.closer.closing;
    const double rounding = 1e-14 * mbsri_closing_size(r->twin.model, r->twin.data, measure);
    const mbsri_closure *c = m->closures.data;
    double largest = 0.0;
    *most = 0.0;
    mbsri_zero((size_t)m->rows, r->forces);
    for (size_t id = 0; id < m->closures.count; ++id, ++c) {
        for (int k = 0, row = c->row; k < c->position_rows; ++k, ++row) {
            const double way = measure->gap[c->position_row + k], stiffness = r->stiffness[row],
                         missing = lambda[row] + stiffness * r->offset[c->position_row + k];
            *most = fmax(*most, fabs(lambda[row]) * way);
            if (!r->stiff[row] || r->twin.data->dropped[row]) continue;
            r->forces[row] = missing;
            if (fabs(missing) > rounding * way * stiffness)
                largest = fmax(largest, fabs(missing) * way);
        }
    }
    return largest;
}

/* Gaps by which the springs exert r->forces more. Where other springs are soft beside them that
 * changes the forces: a share of it is taken that would have left nothing so far (Aitken). */
static void move_springs(const mbsr_model *m, rigid *r)
{
    static const double most = 100.0, rounding = 1e-16; /* of squares: not to be followed */
    const mbsri_closure *c = m->closures.data;
    double along = 0.0, square = 0.0, before = 0.0, now = 0.0, size = 0.0;
    for (size_t id = 0; id < m->closures.count; ++id, ++c) {
        for (int k = 0, row = c->row; k < c->position_rows; ++k, ++row) {
            const double was = r->moved[c->position_row + k], gap = r->offset[c->position_row + k],
                         stiffness = r->stiffness[row];
            if (!r->stiff[row]) continue;
            const double is = -r->forces[row] / stiffness;
            along += stiffness * was * (is - was);
            square += stiffness * (is - was) * (is - was);
            before += stiffness * was * was;
            now += stiffness * is * is;
            size += stiffness * gap * gap;
            r->moved[c->position_row + k] = is;
        }
    }
    if (before > 0.0 && square > 0.0 && now > rounding * size)
        r->relaxation = fmax(-most, fmin(-r->relaxation * along / square, most));
    for (int k = 0; k < m->position_rows; ++k) r->offset[k] += r->relaxation * r->moved[k];
}

/* Lets go of the settled rows that depend on others at the guess; *any: whether there are some. */
static int let_go_dependent(const mbsr_model *m, rigid *r, double t, bool *any)
{
    mbsri_ranks ranks;
    *any = false;
    int status = mbsri_positions(r->twin.model, r->twin.data, t, r->q);
    if (!status) status = mbsri_closure_jacobians(r->twin.model, r->twin.data);
    if (!status) status = mbsri_ranks_here(&r->start.w, r->other, &ranks);
    if (!status) mbsri_leave_soft(m, r->late, r->other);
    for (int k = 0; k < m->rows && !status; ++k) {
        r->start.w.closer.let_go[k] = r->stiff[k] && r->other[k];
        *any = *any || r->start.w.closer.let_go[k];
    }
    return status;
}

/* The first start of the twin. Settled rows that depend on others at the guess do not count where
 * they all do not meet. */
static int start_first(const mbsr_model *m, rigid *r, double t, double *q, double *u, double *udot,
                       double *lambda, const mbsr_consistent_opt *opt, mbsr_consistent_info *info)
{
    bool any;
    int status = order_rows(m, r, t, q);
    if (!status)
        status = mbsri_tree_start_find(&r->start, t, r->offset, q, u, udot, lambda, opt, info);
    if (status != MBSR_LOOP_OPEN) return status;
    const mbsr_error open = r->twin.data->error;
    status = let_go_dependent(m, r, t, &any);
    if (status) return status;
    if (!any) {
        r->twin.data->error = open;
        return MBSR_LOOP_OPEN;
    }
    mbsri_copy((size_t)m->nq, r->q, q);
    mbsri_copy((size_t)m->nu, r->u, u);
    return mbsri_tree_start_find(&r->start, t, r->offset, q, u, udot, lambda, opt, info);
}

/* With the forces that springs lack in r->forces. */
static int refuse_springs(const mbsr_model *m, const rigid *r)
{
    const double *way = r->start.w.closer.closing.gap;
    const mbsri_closure *c = m->closures.data;
    char label[MBSRI_LABEL];
    double missing = 0.0, largest = 0.0;
    int most = 0;
    for (int id = 0; id < (int)m->closures.count; ++id, ++c) {
        for (int k = 0; k < c->position_rows; ++k) {
            const double force = fabs(r->forces[c->row + k]);
            if (!(force * way[c->position_row + k] > largest)) continue;
            largest = force * way[c->position_row + k];
            missing = force;
            most = id;
        }
    }
    return mbsri_fail(&r->twin.data->error, MBSR_NO_CONVERGENCE, MBSR_NONE, MBSR_NONE,
                      "mbsr_dae_consistent: no positions found at which the springs of %s bear its "
                      "forces (%.3g is left); settled = 0 takes them as they are",
                      mbsri_closure_label(m, most, label), missing);
}

/* Starts until the springs bear what they did before, but for rounding. */
static int settle(const mbsr_model *m, rigid *r, double t, double *q, double *u, double *udot,
                  double *lambda, const mbsr_consistent_opt *opt, mbsr_consistent_info *info)
{
    enum { PASSES = 60, IDLE = 4 };
    static const double enough = 1e-12, known = 1e-6;
    double least = INFINITY;
    int idle = 0;
    int status = start_first(m, r, t, q, u, udot, lambda, opt, info);
    for (int pass = 0; pass < PASSES && !status; ++pass) {
        const bool begins = !r->shares && some_left_out(m, r);
        if (begins) status = begin_sharing(m, r);
        if (status) return status;
        double most;
        const double missing = find_missing(m, lambda, r, &most);
        if (missing <= enough * most && !begins) return MBSR_OK;
        idle = missing > 0.5 * least && missing <= known * most ? idle + 1 : 0;
        if (idle == IDLE) return MBSR_OK;
        if (missing < 0.5 * least) least = missing;
        if (pass == PASSES - 1) return refuse_springs(m, r);
        if (r->shares) status = share_forces(m, r);
        if (status) return status;
        move_springs(m, r);
        mbsri_copy((size_t)m->nu, r->u, u);
        status = mbsri_tree_start_find(&r->start, t, r->offset, q, u, udot, lambda, opt, info);
    }
    return status;
}

/* One start of a model without stiff rows. */
static int start_rigid_rows(const mbsr_model *m, mbsr_data *d, double t, double *q, double *u,
                            double *udot, double *lambda, const mbsr_consistent_opt *opt,
                            mbsr_consistent_info *info)
{
    mbsri_tree_start s;
    int status = mbsri_tree_start_open(&s, m, d);
    if (!status) status = mbsri_tree_start_find(&s, t, NULL, q, u, udot, lambda, opt, info);
    mbsri_tree_start_close(&s);
    return status;
}

/* Springs that settle may come to hold what nothing holds at the state given: refused, as the index
 * report there says it. */
static int refuse_given(const mbsr_model *m, mbsr_data *d, double t, const rigid *r,
                        const mbsr_consistent_info *info)
{
    enum { ASKED = 64 }; /* directions: a report of more costs more than all the rest */
    mbsri_verdict verdict;
    if (!info->elastic || info->null_directions > ASKED) return MBSR_OK;
    return mbsri_refuse_open(m, d, t, r->q, r->u, "mbsr_dae_consistent", &verdict);
}

int mbsri_stiff_tree_start(const mbsr_model *m, mbsr_data *d, double t, double *q, double *u,
                           double *udot, double *lambda, const mbsr_consistent_opt *opt,
                           mbsr_consistent_info *info)
{
    rigid r;
    if (!mbsri_any_stiff(m)) return start_rigid_rows(m, d, t, q, u, udot, lambda, opt, info);
    int status = open_rigid(m, d, q, u, &r);
    if (!status) {
        status = settle(m, &r, t, q, u, udot, lambda, opt, info);
        if (status) d->error = r.twin.data->error;
    }
    if (!status) status = refuse_given(m, d, t, &r, info);
    for (int k = 0; k < m->rows && !status; ++k) d->dropped[k] = r.twin.data->dropped[k];
    if (!status) mbsri_leave_soft(m, r.late, d->dropped);
    close_rigid(m, &r);
    return status;
}
