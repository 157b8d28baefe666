/* Derivatives of a joint's equations: see joint_slopes.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A column starts as a change of the predecessor's pose, its velocity, q or u. `tangent` gives what
 * follows for the pose, K, H, J and kI; with (8) that fixes dV; `rate_tangent` gives dkII, dK', dH'
 * and dJ'. Joints without them are differenced along the same change. With K divided out,
 *
 *   dH <- K^-1 (dH - dK H),   dkII <- K^-1 (dkII - dK kII)
 *   dH' <- K^-1 (dH' - dK' H - K' dH - dK H')
 *
 * where H, kII, H' and dH on the right are divided by K already. */
#include "newton/slopes/joint_slopes.h"

#include "algebra/dense.h"
#include "algebra/differences.h"
#include "base/memory.h"
#include "joints/flexible.h"
#include "newton/slopes/force_slopes.h"
#include "newton/slopes/joint_turns.h"
#include "newton/slopes/move.h"
#include "model/query.h"
#include "newton/slopes/planar_slopes.h"
#include "newton/slopes/steady_joint.h"
#include "recursion/kinematics.h"
#include "recursion/locks.h"
#include "recursion/spans.h"

#include <math.h>
#include <stdlib.h>

/* Numbers of one set of K, H, J and two vectors, with every column of J, those held included; no J
 * of mounts whose J is constant (upright). */
typedef struct block {
    double *K, *H, *J, *k;
} block;

typedef struct column {
    const mbsr_model *m;
    mbsr_data *d;
    const mbsri_body *b;
    const mbsri_body *pred;
    int i;
    bool accelerated;
    const double *udot;
    mbsri_spans spans; /* of differences */
    mbsr_joint_args args;
    mbsr_joint_change by;
    double *q, *u, *p_pred, *V_pred, *dp, *dV; /* of `by` */
    bool displaced;                            /* of q or p_pred; else dp and `first` are zero */
    block first;                               /* dK, dH, dJ, dkI, later divided by K */
    block second;                              /* dK', dH', dJ', dkII */
    double *qdot;                              /* d(G u), with every coordinate */
    double *Kdot;                              /* as the joint gives it */
    double *spare;                             /* d x max(n, d_pred) + d */
    mbsri_joint_mover move;                    /* where a joint leaves derivatives to differences */
    mbsri_flex_view *view;                     /* of a marker; NULL: it is none */
    bool turns;                                /* joint_turns.h has the predecessor's columns */
} column;

/* Places the arrays of a column in memory (NULL: none); returns how many doubles they take. */
static size_t lay_out(const mbsr_model *m, const mbsri_body *b, double *memory, column *c)
{
    const size_t d = (size_t)b->d, dp = (size_t)b->pred.d, n = (size_t)b->joint.n,
                 nq = (size_t)b->joint.nq, np_pred = (size_t)m->body[b->parent].np;
    size_t used = 0;
    c->q = mbsri_take(&memory, &used, nq);
    c->u = mbsri_take(&memory, &used, n);
    c->p_pred = mbsri_take(&memory, &used, np_pred);
    c->V_pred = mbsri_take(&memory, &used, dp);
    c->dp = mbsri_take(&memory, &used, (size_t)b->np);
    c->dV = mbsri_take(&memory, &used, d);
    block *const blocks[] = {&c->first, &c->second};
    for (int k = 0; k < 2; ++k) {
        blocks[k]->K = mbsri_take(&memory, &used, d * d);
        blocks[k]->H = mbsri_take(&memory, &used, d * dp);
        blocks[k]->J = mbsri_take(&memory, &used, d * n);
        blocks[k]->k = mbsri_take(&memory, &used, d);
    }
    c->qdot = mbsri_take(&memory, &used, nq);
    c->Kdot = mbsri_take(&memory, &used, d * d);
    c->spare = mbsri_take(&memory, &used, d * (dp > n ? dp : n) + d);
    return used + mbsri_joint_mover_place(b, (int)np_pred, memory, &c->move);
}

size_t mbsri_joint_slopes_size(const mbsr_model *m)
{
    size_t largest = 0;
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i, *pred = m->body + b->parent;
        const size_t e = (size_t)mbsri_pose_size(b), e_pred = (size_t)mbsri_pose_size(pred),
                     rows = e + 2 * (size_t)b->d + 3 * (size_t)b->pred.d + 3 * (size_t)b->n +
                            (size_t)b->nq,
                     columns = e_pred + 2 * (size_t)b->pred.d + (size_t)b->nq + 2 * (size_t)b->n;
        column c;
        const size_t size = rows * columns + lay_out(m, b, NULL, &c);
        if (size > largest) largest = size;
    }
    return largest;
}

void mbsri_joint_slopes_place(mbsri_joint_slopes *s, double *memory)
{
    s->x = memory;
}

bool mbsri_joint_slopes_serve(const mbsri_body *b, int np_pred)
{
    return b->joint.table->rates || b->pred.space != MBSR_SPACE_GENERAL || np_pred == b->pred.d;
}

static bool unit_K(const mbsri_body *b)
{
    return (b->joint.table->flags & MBSR_JOINT_UNIT_K) != 0;
}

/* ---- calls of the joint ---- */

static void clear(const mbsri_body *b, block *x)
{
    const size_t d = (size_t)b->d;
    if (!unit_K(b)) mbsri_zero(d * d, x->K);
    mbsri_zero(d * (size_t)b->pred.d, x->H);
    if (!b->flexible.upright) mbsri_zero(d * (size_t)b->joint.n, x->J);
    mbsri_zero(d, x->k);
}

/* dp, dK, dH, dJ, dkI along q and p_pred of `by`. */
static int call_tangent(column *c)
{
    const mbsri_body *b = c->b;
    mbsr_joint_args args = c->args;
    mbsr_joint_change by = {.q = c->q, .p_pred = c->p_pred};
    args.u = args.V = args.V_pred = NULL;
    clear(b, &c->first);
    mbsri_zero((size_t)b->np, c->dp);
    if (c->view) {
        mbsri_marker_change(&args, &by, c->view, c->dp, c->first.H);
        return MBSR_OK;
    }
    double *dK = unit_K(b) ? NULL : c->first.K;
    const char *name = "tangent";
    const int status =
        b->joint.table->tangent
            ? b->joint.table->tangent(&args, &by, c->dp, dK, c->first.H, c->first.J, c->first.k)
            : mbsri_joint_move_tangent(&c->move, &args, &by, c->dp, dK, c->first.H, c->first.J,
                                       c->first.k, &name);
    return status ? mbsri_joint_failed(c->m, c->d, c->i, status, name) : MBSR_OK;
}

/* dkII, dK', dH', dJ', d(G u) along all of `by`. */
static int call_rate_tangent(column *c)
{
    const mbsri_body *b = c->b;
    const mbsr_joint_change by = {c->q, c->u, c->p_pred, c->V_pred, c->dp, c->dV};
    clear(b, &c->second);
    mbsri_zero((size_t)b->joint.nq, c->qdot);
    if (c->view) {
        mbsri_marker_rate_change(&c->args, &by, c->view, c->second.k, c->second.H);
        return MBSR_OK;
    }
    const bool own_rates = b->joint.table->coordinate_rates != NULL;
    double *dKdot = unit_K(b) ? NULL : c->second.K, *dqdot = own_rates ? c->qdot : NULL;
    const char *name = "rate_tangent";
    const int status = b->joint.table->rate_tangent
                           ? b->joint.table->rate_tangent(&c->args, &by, c->second.k, dKdot,
                                                          c->second.H, c->second.J, dqdot)
                           : mbsri_joint_move_rates(&c->move, &c->args, &by, c->second.k, dKdot,
                                                    c->second.H, c->second.J, dqdot, &name);
    if (!own_rates) mbsri_copy((size_t)b->joint.n, c->u, c->qdot);
    return status ? mbsri_joint_failed(c->m, c->d, c->i, status, name) : MBSR_OK;
}

/* X <- K^-1 X for `columns` columns. */
static void divide(const column *c, int columns, double *X)
{
    const mbsri_body *b = c->b;
    const size_t size = (size_t)b->d * (size_t)columns;
    mbsri_copy(size, X, c->spare);
    mbsri_zero(size, X);
    mbsri_ab(b->d, b->d, columns, 1.0, c->d->Kinv + b->k, c->spare, X);
}

static void divide_first(const column *c, int columns, const double *X, double *dX)
{
    mbsri_ab(c->b->d, c->b->d, columns, -1.0, c->first.K, X, dX);
    divide(c, columns, dX);
}

static void divide_second(const column *c, int columns, const double *X, const double *dX,
                          const double *Xdot, double *dXdot)
{
    mbsri_ab(c->b->d, c->b->d, columns, -1.0, c->second.K, X, dXdot);
    mbsri_ab(c->b->d, c->b->d, columns, -1.0, c->Kdot, dX, dXdot);
    mbsri_ab(c->b->d, c->b->d, columns, -1.0, c->first.K, Xdot, dXdot);
    divide(c, columns, dXdot);
}

/* Leaves the free columns of J at its beginning. */
static void drop(const mbsri_body *b, double *J)
{
    if (b->lock.count) mbsri_drop_held(b, J, J);
}

static int first_order(column *c)
{
    const int status = call_tangent(c);
    if (status) return status;
    drop(c->b, c->first.J);
    if (unit_K(c->b)) return MBSR_OK;
    const mbsr_data *d = c->d;
    divide_first(c, c->b->pred.d, d->H + c->b->dp, c->first.H);
    divide_first(c, c->b->n, d->J + c->b->dn, c->first.J);
    divide_first(c, 1, d->kI + c->b->v, c->first.k);
    return MBSR_OK;
}

static int second_order(column *c)
{
    const int status = call_rate_tangent(c);
    if (status) return status;
    drop(c->b, c->second.J);
    if (unit_K(c->b)) return MBSR_OK;
    const mbsr_data *d = c->d;
    const mbsri_body *b = c->b;
    divide_second(c, b->pred.d, d->H + b->dp, c->first.H, d->Hdot + b->dp, c->second.H);
    divide_second(c, b->n, d->J + b->dn, c->first.J, d->Jdot + b->dn, c->second.J);
    divide_first(c, 1, d->kII + b->v, c->second.k);
    return MBSR_OK;
}

/* ---- what a column makes of the equations ---- */

/* dV = -(dH V_pi + dJ u + dkI) of a column of the pose or of q. */
static void velocity(column *c)
{
    const mbsri_body *b = c->b;
    const mbsr_data *d = c->d;
    mbsri_zero((size_t)b->d, c->dV);
    mbsri_ax(b->d, b->pred.d, -1.0, c->first.H, d->V + b->pred.v, c->dV);
    if (!b->flexible.upright) mbsri_ax(b->d, b->n, -1.0, c->first.J, d->u + b->iu, c->dV);
    for (int k = 0; k < b->d; ++k) c->dV[k] -= c->first.k[k];
}

/* The column's entries from dp, dV and the blocks. */
static void store(column *c, int at, mbsri_joint_slopes *s)
{
    const mbsri_body *b = c->b;
    const mbsr_data *d = c->d;
    const int dim = b->d, dp = b->pred.d, n = b->n;
    double *x = s->x + (size_t)at * (size_t)(s->e + 2 * dim), *A = x + s->e + dim;
    double *below = s->below + (size_t)at * (size_t)(3 * dp),
           *own = s->own + (size_t)at * (size_t)(3 * n);
    mbsri_copy((size_t)dim, c->dV, x + s->e);
    if (c->displaced) {
        mbsri_pose_change(b->joint.space, b->np, d->p + b->p, c->dp, x);
        mbsri_atx(dim, dp, -1.0, c->first.H, d->imp + b->v, below);
        mbsri_atx(dim, dp, -1.0, c->first.H, d->sigma + b->v, below + dp);
    }
    if (c->displaced && !b->flexible.upright) {
        mbsri_atx(dim, n, 1.0, c->first.J, d->imp + b->v, own);
        mbsri_atx(dim, n, 1.0, c->first.J, d->sigma + b->v, own + n);
    }
    mbsri_atx(dim, dp, -1.0, c->second.H, d->imp + b->v, below + dp);
    if (!b->flexible.upright) mbsri_atx(dim, n, 1.0, c->second.J, d->imp + b->v, own + n);
    double *qdot = s->qdot + (size_t)at * (size_t)b->nq;
    for (int k = 0, l = 0; k < b->joint.nq; ++k) {
        if (!b->lock.count || isnan(b->lock.at[k])) qdot[l++] = c->qdot[k];
    }
    if (!c->accelerated) return;
    /* dA = -(dH A_pi + dJ u' + dkII) */
    mbsri_ax(dim, dp, -1.0, c->first.H, d->A + b->pred.v, A);
    if (!b->flexible.upright) mbsri_ax(dim, n, -1.0, c->first.J, c->udot, A);
    for (int k = 0; k < dim; ++k) A[k] -= c->second.k[k];
    mbsri_atx(dim, dp, -1.0, c->first.H, d->mu + b->v, below + 2 * dp);
    if (!b->flexible.upright) mbsri_atx(dim, n, 1.0, c->first.J, d->mu + b->v, own + 2 * n);
}

static void rest(column *c)
{
    const mbsri_body *b = c->b;
    mbsri_zero((size_t)b->joint.nq, c->q);
    mbsri_zero((size_t)b->joint.n, c->u);
    mbsri_zero((size_t)c->pred->np, c->p_pred);
    mbsri_zero((size_t)b->pred.d, c->V_pred);
}

/* Whether column k of the predecessor's pose, or of its velocity, is a shift that the body follows
 * without any other change: markers and mounts know of places only how they lie to each other. */
static bool is_shift(const mbsri_body *b, int k)
{
    const mbsri_joint *joint = &b->joint;
    if (k < 3 || k >= 6) return false;
    return mbsri_marker_of(joint->table, joint->user) ||
           (b->pred.space == MBSR_SPACE_SPATIAL && mbsri_mount_of(joint->table, joint->user));
}

/* Columns of the pose of the predecessor, and of q. */
static int pose_columns(column *c, mbsri_joint_slopes *s)
{
    const mbsri_body *b = c->b;
    int status = MBSR_OK;
    c->displaced = true;
    c->move.still = false;
    for (int k = c->turns ? s->e_pred : 0;
         k < (b->flexible.upright ? 0 : b->nq) + s->e_pred && !status; ++k) {
        const bool outside = k < s->e_pred;
        if (outside && is_shift(b, k)) {
            s->x[k * (s->e + 2 * b->d) + k] = 1.0;
            continue;
        }
        rest(c);
        if (outside)
            mbsri_pose_unit(b->pred.space, k, c->d->p + b->pred.p, c->p_pred);
        else
            c->q[mbsri_place_of_free(b, k - s->e_pred)] = 1.0;
        c->move.span =
            mbsri_binary(outside ? mbsri_pose_span(&c->spans, c->pred, k)
                                 : mbsri_coordinate_span(&c->spans, c->m, b, false, k - s->e_pred));
        status = first_order(c);
        if (status) return status;
        velocity(c);
        status = second_order(c);
        if (!status) store(c, outside ? k : s->q + k - s->e_pred, s);
    }
    return status;
}

/* Columns of the predecessor's velocity, and of u: dV = -H dV_pi - J du. */
static int rate_columns(column *c, mbsri_joint_slopes *s)
{
    const mbsri_body *b = c->b;
    int status = MBSR_OK;
    c->displaced = false;
    c->move.still = true;
    mbsri_zero((size_t)b->np, c->dp);
    clear(b, &c->first);
    for (int k = c->turns ? b->pred.d : 0;
         k < (b->flexible.upright ? 0 : b->n) + b->pred.d && !status; ++k) {
        const bool outside = k < b->pred.d;
        const double *along = outside ? c->d->H + b->dp + (size_t)(k * b->d)
                                      : c->d->J + b->dn + (size_t)((k - b->pred.d) * b->d);
        if (outside && is_shift(b, k)) {
            double *dV = s->x + (s->e_pred + k) * (s->e + 2 * b->d) + s->e;
            for (int l = 0; l < b->d; ++l) dV[l] = -along[l];
            continue;
        }
        const double span = outside
                                ? mbsri_pose_span(&c->spans, c->pred, k)
                                : mbsri_coordinate_span(&c->spans, c->m, b, true, k - b->pred.d);
        rest(c);
        c->move.span = mbsri_binary(span * c->move.speed);
        if (outside)
            c->V_pred[k] = 1.0;
        else
            c->u[mbsri_place_of_free(b, k - b->pred.d)] = 1.0;
        for (int l = 0; l < b->d; ++l) c->dV[l] = -along[l];
        status = second_order(c);
        if (!status) store(c, outside ? s->e_pred + k : s->u + k - b->pred.d, s);
    }
    return status;
}

/* Where a coordinate moves the body the same way in every state: dx and dV = -J. */
static void steady_column(const column *c, int k, mbsri_joint_slopes *s)
{
    const mbsri_body *b = c->b;
    const size_t rows = (size_t)(s->e + 2 * b->d), e = (size_t)s->e;
    const double *along = c->d->J + b->dn + (size_t)(k * b->d);
    double *of_q = s->x + (size_t)(s->q + k) * rows, *of_u = s->x + (size_t)(s->u + k) * rows;
    for (int l = 0; l < b->d; ++l) of_q[l] = of_u[e + (size_t)l] = -along[l];
    s->qdot[(size_t)(s->u + k) * (size_t)b->nq + (size_t)k] = 1.0;
}

/* Columns of the predecessor's acceleration, and of u': dA = -H dA_pi - J du'. */
static void acceleration_columns(const column *c, mbsri_joint_slopes *s)
{
    const mbsri_body *b = c->b;
    const size_t rows = (size_t)(s->e + 2 * b->d), first = (size_t)(s->e + b->d);
    for (int k = 0; k < b->pred.d + b->n; ++k) {
        const bool outside = k < b->pred.d;
        const int at = outside ? s->e_pred + b->pred.d + k : s->a + k - b->pred.d;
        const double *from = outside ? c->d->H + b->dp + (size_t)(k * b->d)
                                     : c->d->J + b->dn + (size_t)((k - b->pred.d) * b->d);
        for (int l = 0; l < b->d; ++l) s->x[(size_t)at * rows + first + (size_t)l] = -from[l];
    }
}

/* Of armature: a_k du_k in d(M u), a_k du_k' in d(J^T mu). */
static void add_armature(const mbsri_body *b, bool accelerated, mbsri_joint_slopes *s)
{
    const size_t rows = (size_t)(3 * b->n);
    for (int k = 0; k < b->n; ++k) {
        s->own[(size_t)(s->u + k) * rows + (size_t)k] += b->mass.armature[k];
        if (accelerated)
            s->own[(size_t)(s->a + k) * rows + (size_t)(2 * b->n + k)] += b->mass.armature[k];
    }
}

/* The columns of the predecessor's pose and V, of q and u, one after the other. */
static int all_columns(column *c, mbsri_joint_slopes *s)
{
    const mbsri_body *b = c->b;
    const mbsr_data *d = c->d;
    mbsri_flex_view view;
    c->args = mbsri_joint_args(c->m, c->d, c->i, true);
    if (mbsri_marker_of(b->joint.table, b->joint.user)) {
        mbsri_marker_see(&c->args, &view);
        c->view = &view;
    }
    c->move.table = b->joint.table;
    c->move.space = b->joint.space;
    c->move.np_pred = c->pred->np;
    c->spans = mbsri_spans_of(c->m, &b->joint.table->scales);
    c->move.speed = fmax(mbsri_span_rate(&c->spans),
                         fmax(mbsri_twist_rate(&c->spans, b, d->V + b->v),
                              mbsri_twist_rate(&c->spans, c->pred, d->V + b->pred.v)));
    if (!unit_K(b)) {
        const int status =
            mbsri_joint_move_Kdot(&c->move, &c->args, c->Kdot, c->second.H, c->second.J);
        if (status) return mbsri_joint_failed(c->m, c->d, c->i, status, "rates");
    }
    c->turns = mbsri_joint_turns_serve(b);
    if (c->turns) mbsri_joint_turns(c->m, d, c->i, c->accelerated, c->udot, s->x, s->below, s->own);
    int status = MBSR_OK;
    if (mbsri_steady_joint_serves(b)) {
        const size_t rows = (size_t)(s->e + 2 * b->d), nq = (size_t)b->nq;
        double *const x_own[] = {s->x + (size_t)s->q * rows, s->x + (size_t)s->u * rows},
                      *const rate[] = {s->qdot + (size_t)s->q * nq, s->qdot + (size_t)s->u * nq};
        mbsri_steady_joint(b, d, c->args.q, c->args.u, x_own, rate);
    } else {
        status = pose_columns(c, s);
        if (!status) status = rate_columns(c, s);
    }
    for (int k = 0; k < b->n && b->flexible.upright; ++k) steady_column(c, k, s);
    return status;
}

int mbsri_joint_slopes_of(const mbsr_model *m, mbsr_data *d, int i, bool accelerated,
                          const double *udot, mbsri_joint_slopes *s)
{
    const mbsri_body *b = m->body + i;
    column c = {.m = m, .d = d, .b = b, .pred = m->body + b->parent, .i = i};
    s->e = mbsri_pose_size(b);
    s->e_pred = mbsri_pose_size(c.pred);
    s->q = s->e_pred + 2 * b->pred.d;
    s->u = s->q + b->nq;
    s->a = s->u + b->n;
    s->columns = s->a + b->n;
    const size_t columns = (size_t)s->columns, x = columns * (size_t)(s->e + 2 * b->d),
                 below = columns * (size_t)(3 * b->pred.d), own = columns * (size_t)(3 * b->n),
                 qdot = columns * (size_t)b->nq;
    s->below = s->x + x;
    s->own = s->below + below;
    s->qdot = s->own + own;
    s->work = s->qdot + qdot;
    mbsri_zero(x, s->x);
    mbsri_zero(below + own + qdot, s->below);
    c.accelerated = accelerated;
    c.udot = udot;
    int status = MBSR_OK;
    if (mbsri_planar_slopes_serve(b)) {
        mbsri_planar_slopes(b, d, accelerated, udot, s->x, s->below, s->own, s->qdot);
    } else {
        lay_out(m, b, s->work, &c);
        status = all_columns(&c, s);
    }
    if (!status) acceleration_columns(&c, s);
    if (!status) add_armature(b, accelerated, s);
    return status;
}
