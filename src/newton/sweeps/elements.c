/* Slopes of force elements for the Newton sweeps.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * What is not taken in here, the forces on a body over the motion of one that is neither itself nor
 * its neighbour in the tree, is left to the correction (newton/correction.c). */
#include "newton/sweeps/elements.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "forces/gravity.h"
#include "model/query.h"
#include "newton/carried/record.h"
#include "newton/slopes/closure_slopes.h"
#include "newton/slopes/force_slopes.h"
#include "newton/slopes/relation.h"
#include "recursion/closures.h"

#include <string.h>

/* Slopes of blocks are for newton/carried; so are those between a block and its predecessor. */
static bool is_block(const mbsri_sweeps *tree, int i)
{
    return (tree->body[i].flags & MBSRI_BLOCK) != 0;
}

static bool on_bodies(const mbsri_force *force)
{
    return !mbsri_is_gravity(&force->def) && !(force->def.table->flags & MBSR_FORCE_JOINT_ONLY);
}

/* Marks the bodies of an element whose predecessor is in its list, too, in `pair` (may be NULL);
 * returns how many. */
static size_t mark_pairs(const mbsr_model *m, const mbsri_sweeps *tree, const mbsri_force *force,
                         int *pair)
{
    const int *bodies = m->stored.list_index + force->list;
    size_t count = 0;
    if (!on_bodies(force) || force->def.table->flags & MBSR_FORCE_EVERY_BODY) return 0;
    for (int k = 0; k < force->def.bodies; ++k) {
        for (int l = 0; l < force->def.bodies; ++l) {
            if (mbsri_relate(m, bodies[k], bodies[l]) != MBSRI_BELOW || is_block(tree, bodies[k]))
                continue;
            if (pair) pair[bodies[k]] = 0;
            ++count;
        }
    }
    return count;
}

void mbsri_newton_count(const mbsr_model *m, const mbsri_sweeps *tree, size_t *loaded,
                        size_t *pairs, int *number, int *pair)
{
    const mbsri_force *force = m->forces.data;
    *loaded = *pairs = 0;
    for (int i = 1; i <= tree->bodies; ++i) {
        const bool has = tree->body[i].flags & MBSRI_ACTED && !is_block(tree, i);
        if (number) number[i] = has ? (int)*loaded : -1;
        if (pair) pair[i] = -1;
        *loaded += has;
    }
    for (size_t k = 0; k < m->forces.count; ++k) *pairs += mark_pairs(m, tree, force + k, pair);
    if (*pairs > (size_t)m->bodies) *pairs = (size_t)m->bodies;
    int count = 0;
    for (int i = 1; i <= tree->bodies && pair; ++i) {
        if (pair[i] == 0) pair[i] = count++;
    }
}

static void clear_slopes(mbsri_newton_sweeps *w)
{
    const size_t nu = (size_t)w->model->nu;
    mbsri_zero(nu, w->tau_q);
    for (size_t k = 0; k < nu; ++k) w->tau_u[k] = -w->c * w->model->armature[k];
    for (int k = 0; k < w->tree->multi; ++k) {
        memset(w->block[k].tau_q, 0, sizeof w->block[k].tau_q);
        memset(w->block[k].tau_u, 0, sizeof w->block[k].tau_u);
    }
    memset(w->acting.at, 0, w->acting.acted * sizeof *w->acting.at);
    memset(w->acting.by_pred, 0, w->acting.pairs * sizeof *w->acting.by_pred);
    memset(w->acting.on_pred, 0, w->acting.pairs * sizeof *w->acting.on_pred);
}

/* dtau of body i with respect to its own q and u. */
static void add_joint_slopes(mbsri_newton_sweeps *w, int i, const mbsr_force_derivatives *by,
                             int row, int column)
{
    const mbsri_body *body = w->model->body + i;
    const mbsri_sweep_body *b = w->tree->body + i;
    const double *tau = by->matrix + row + body->d,
                 *q = tau + by->rows * (column + mbsri_pose_size(body) + body->d),
                 *u = q + by->rows * body->nq;
    if (b->n == 0) return;
    if (!(b->flags & MBSRI_MULTI)) {
        w->tau_q[b->u] += *q;
        w->tau_u[b->u] += *u;
        return;
    }
    mbsri_newton_block *B = w->block + b->multi;
    for (int k = 0; k < body->n; ++k) {
        for (int l = 0; l < body->nq; ++l) B->tau_q[k][l] += q[by->rows * l + k];
        for (int l = 0; l < body->n; ++l) B->tau_u[k][l] += u[by->rows * l + k];
    }
}

/* Where number k of a body's pose or V stands among three axes and two groups (angular, linear). */
typedef struct place {
    int group, axis;
} place;

static place place_of(const mbsri_body *b, int k)
{
    if (b->joint.space == MBSR_SPACE_SPATIAL) return (place){k / 3, k % 3};
    return k == 2 ? (place){0, 2} : (place){1, k};
}

/* The rows of forces on a body over pose and V of `by`, the first `count` of these. */
static void add_some_slopes(const mbsr_force_derivatives *from, const mbsri_body *on, int row,
                            const mbsri_body *by, int column, int count, mbsri_newton_slopes *to)
{
    const int of_pose = mbsri_pose_size(by);
    for (int k = 0; k < count; ++k) {
        const double *x = from->matrix + from->rows * (column + k) + row;
        const bool pose = k < of_pose;
        const place at = place_of(by, pose ? k : k - of_pose);
        for (int l = 0; l < on->d; ++l) {
            const place in = place_of(on, l);
            to->by[(pose ? 0 : 2) + at.group][at.axis][in.group][in.axis] += x[l];
        }
    }
}

static void add_body_slopes(const mbsr_force_derivatives *from, const mbsri_body *on, int row,
                            const mbsri_body *by, int column, mbsri_newton_slopes *to)
{
    add_some_slopes(from, on, row, by, column, mbsri_pose_size(by) + by->d, to);
}

static bool is_zero(const mbsr_force_derivatives *by, int row, int rows, int column, int columns)
{
    for (int k = column; k < column + columns; ++k) {
        for (int l = row; l < row + rows; ++l) {
            if (by->matrix[by->rows * k + l] != 0.0) return false;
        }
    }
    return true;
}

/* Of the derivatives of an element, what forces on body i (the k-th) owe to body j (the l-th);
 * false: those of bodies and of joints mix. */
static bool add_block(mbsri_newton_sweeps *w, const mbsri_force *force, int i, int k, int j, int l)
{
    const mbsr_model *m = w->model;
    const mbsr_force_derivatives *by = &w->slopes.out;
    const mbsri_relation relation = mbsri_relate(m, i, j);
    const bool apart = (force->def.table->flags & MBSR_FORCE_NO_JOINT) != 0;
    if (is_block(w->tree, relation == MBSRI_ABOVE ? j : i)) return true;
    const mbsri_body *on = m->body + i, *of = m->body + j;
    const int row = by->row[k], column = by->column[l], n = on->n, d = on->d,
              joint = of->nq + of->n, motion = mbsri_pose_size(of) + of->d;
    switch (relation) {
    case MBSRI_SAME:
        add_joint_slopes(w, i, by, row, column);
        add_body_slopes(by, on, row, of, column, w->acting.at + w->acting.number[i]);
        return apart || (is_zero(by, row, d, column + motion, joint) &&
                         is_zero(by, row + d, n, column, motion));
    case MBSRI_BELOW:
        add_body_slopes(by, on, row, of, column, w->acting.by_pred + w->acting.pair[i]);
        return apart || is_zero(by, row + d, n, column, motion);
    case MBSRI_ABOVE:
        add_body_slopes(by, on, row, of, column, w->acting.on_pred + w->acting.pair[j]);
        return apart || is_zero(by, row, d, column + motion, joint);
    case MBSRI_APART: break;
    }
    return true;
}

/* One call of an element: on body i, or on those of its list. */
static int slopes_of_call(mbsri_newton_sweeps *w, mbsr_data *d, const mbsri_force *force, int i)
{
    const mbsr_model *m = w->model;
    const unsigned flags = force->def.table->flags;
    const bool every = (flags & MBSR_FORCE_EVERY_BODY) != 0,
               joints = (flags & MBSR_FORCE_JOINT_ONLY) != 0;
    const int *list = every ? &i : m->stored.list_index + force->list,
              bodies = every ? 1 : force->def.bodies;
    bool any = false;
    for (int k = 0; k < bodies; ++k) any = any || (list[k] > 0 && !is_block(w->tree, list[k]));
    if (!any) return MBSR_OK;
    const int status = mbsri_force_slopes(m, d, force, i, &w->slopes);
    const mbsr_force_derivatives *by = &w->slopes.out;
    for (int k = 0; k < bodies && !status; ++k) {
        for (int l = 0; l < bodies && !joints; ++l) {
            if (list[k] > 0 && list[l] > 0 && !add_block(w, force, list[k], k, list[l], l))
                return MBSRI_NOT_SERVED;
        }
        for (int l = 0; l < bodies && joints && list[k] > 0 && !is_block(w->tree, list[k]); ++l) {
            if (list[l] == list[k]) add_joint_slopes(w, list[k], by, by->row[k], by->column[l]);
        }
    }
    return status;
}

/* Those of elements on one coordinate; joints of several axes have them in their blocks. */
static bool add_coordinate_slopes(mbsri_newton_sweeps *w, const mbsr_data *d)
{
    const mbsr_model *m = w->model;
    mbsri_coordinate_slopes(&m->elements.along, d->element.off + mbsri_other_forces(m), d->q, d->u,
                            w->tau_q, w->tau_u);
    for (int i = 1; i <= w->tree->bodies && w->tree->multi > 0; ++i) {
        const mbsri_sweep_body *b = w->tree->body + i;
        if (!(b->flags & MBSRI_MULTI)) continue;
        for (int k = 0; k < b->n; ++k) {
            w->block[b->multi].tau_q[k][k] += w->tau_q[b->u + k];
            w->block[b->multi].tau_u[k][k] += w->tau_u[b->u + k];
        }
    }
    return mbsri_finite((size_t)m->nu, w->tau_q) && mbsri_finite((size_t)m->nu, w->tau_u);
}

int mbsri_newton_slopes_at(mbsri_newton_sweeps *newton, mbsr_data *d)
{
    const mbsr_model *m = newton->model;
    const mbsri_force *force = m->forces.data;
    const size_t others = mbsri_other_forces(m);
    int status = MBSR_OK;
    clear_slopes(newton);
    if (!add_coordinate_slopes(newton, d)) return MBSRI_NOT_SERVED;
    for (size_t k = 0; k < others; ++k, ++force) {
        if (mbsri_is_gravity(&force->def)) continue;
        const bool every = (force->def.table->flags & MBSR_FORCE_EVERY_BODY) != 0;
        const int calls = every ? newton->tree->bodies : 1;
        for (int i = 1; i <= calls && !status; ++i) status = slopes_of_call(newton, d, force, i);
    }
    return status;
}

/* ---- couplings ---- */

static bool is_bent(const mbsri_closure *c)
{
    return mbsri_is_coupling(c) && !mbsri_closure_is_constant(c);
}

bool mbsri_newton_has_joint_slopes(const mbsr_model *m)
{
    const mbsri_closure *c = m->closures.data;
    bool any = false;
    for (size_t k = 0; k < m->closures.count; ++k) any = any || is_bent(c + k);
    return any;
}

/* S: slopes of the forces of closure c, which is on body i from this column on. */
static void add_coupling_slopes(mbsri_newton_sweeps *w, const mbsri_closure *c, const double *S,
                                int i, int column)
{
    const mbsri_sweep_body *b = w->tree->body + i;
    for (int l = 0; l < b->n; ++l) {
        for (int k = 0; k < b->n; ++k) {
            const double slope = S[(column + l) * c->columns + column + k];
            if (b->flags & MBSRI_MULTI)
                w->block[b->multi].tau_q[k][l] += slope;
            else
                w->tau_q[b->u] += slope;
        }
    }
}

void mbsri_newton_add_joint_slopes(mbsri_newton_sweeps *newton)
{
    const mbsr_model *m = newton->model;
    const mbsri_carried *v = &newton->blocks->carried;
    const mbsri_closure *c = m->closures.data;
    if (newton->last.joint_slopes || !newton->tau_q) return;
    newton->last.joint_slopes = true;
    for (size_t k = 0; k < m->closures.count; ++k, ++c) {
        for (int l = 0; l < c->def.bodies && is_bent(c); ++l) {
            const int i = c->body[l];
            if (!is_block(newton->tree, i))
                add_coupling_slopes(newton, c, v->store + v->loop[k].S, i,
                                    c->column[l] + m->body[i].d);
        }
    }
}
