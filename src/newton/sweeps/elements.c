/* Slopes of force elements for the Newton sweeps.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * What is not taken in here, the forces on a body over the motion of one that is neither itself nor
 * its neighbour in the tree, is left to the correction (newton/correction.c). */
#include "newton/sweeps/elements.h"

#include "algebra/dense.h"
#include "forces/gravity.h"
#include "newton/slopes/force_slopes.h"
#include "newton/slopes/relation.h"

#include <string.h>

static bool on_bodies(const mbsri_force *force)
{
    return !mbsri_is_gravity(&force->def) && !(force->def.table->flags & MBSR_FORCE_JOINT_ONLY);
}

/* Marks the bodies of an element whose predecessor is in its list, too, in `pair` (may be NULL);
 * returns how many. */
static size_t mark_pairs(const mbsr_model *m, const mbsri_force *force, int *pair)
{
    const int *bodies = m->list_index + force->list;
    size_t count = 0;
    if (!on_bodies(force) || force->def.table->flags & MBSR_FORCE_EVERY_BODY) return 0;
    for (int k = 0; k < force->def.bodies; ++k) {
        for (int l = 0; l < force->def.bodies; ++l) {
            if (mbsri_relate(m, bodies[k], bodies[l]) != MBSRI_BELOW) continue;
            if (pair) pair[bodies[k]] = 0;
            ++count;
        }
    }
    return count;
}

void mbsri_newton_count(const mbsr_model *m, size_t *loaded, size_t *pairs, int *number, int *pair)
{
    const mbsri_force *force = m->forces.data;
    *loaded = *pairs = 0;
    for (int i = 1; i <= m->bodies; ++i) {
        const bool has = (m->sweeps->body[i].flags & MBSRI_LOADED) != 0;
        if (number) number[i] = has ? (int)*loaded : -1;
        if (pair) pair[i] = -1;
        *loaded += has;
    }
    for (size_t k = 0; k < m->forces.count; ++k) *pairs += mark_pairs(m, force + k, pair);
    if (*pairs > (size_t)m->bodies) *pairs = (size_t)m->bodies;
    int count = 0;
    for (int i = 1; i <= m->bodies && pair; ++i) {
        if (pair[i] == 0) pair[i] = count++;
    }
}

static void clear_slopes(mbsri_newton_sweeps *w)
{
    const size_t nu = (size_t)w->model->nu;
    mbsri_zero(nu, w->tau_q);
    mbsri_zero(nu, w->tau_u);
    for (int k = 0; k < w->tree->multi; ++k) {
        memset(w->block[k].tau_q, 0, sizeof w->block[k].tau_q);
        memset(w->block[k].tau_u, 0, sizeof w->block[k].tau_u);
    }
    for (int i = 1; i <= w->tree->bodies && w->own; ++i) {
        const int number = w->number[i], pair = w->pair[i];
        if (number >= 0) memset(w->at + number, 0, sizeof *w->at);
        if (pair < 0) continue;
        memset(w->by_pred + pair, 0, sizeof *w->by_pred);
        memset(w->on_pred + pair, 0, sizeof *w->on_pred);
    }
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

/* Six rows over pose and V. */
static void add_body_slopes(const mbsr_force_derivatives *by, int row, int column,
                            mbsri_newton_slopes *to)
{
    const double *from = by->matrix + by->rows * column + row;
    for (int g = 0; g < 4; ++g) {
        for (int j = 0; j < 3; ++j, from += by->rows) {
            for (int k = 0; k < 3; ++k) {
                to->by[g][j][0][k] += from[k];
                to->by[g][j][1][k] += from[3 + k];
            }
        }
    }
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
 * false: those of bodies and of joints
 * mix. */
static bool add_block(mbsri_newton_sweeps *w, const mbsri_force *force, int i, int k, int j, int l)
{
    const mbsr_model *m = w->model;
    const mbsr_force_derivatives *by = &w->slopes.out;
    const mbsri_relation relation = mbsri_relate(m, i, j);
    const bool apart = (force->def.table->flags & MBSR_FORCE_NO_JOINT) != 0;
    const int row = by->row[k], column = by->column[l], n = m->body[i].n,
              joint = m->body[j].nq + m->body[j].n;
    switch (relation) {
    case MBSRI_SAME:
        add_joint_slopes(w, i, by, row, column);
        add_body_slopes(by, row, column, w->at + w->number[i]);
        return apart ||
               (is_zero(by, row, 6, column + 12, joint) && is_zero(by, row + 6, n, column, 12));
    case MBSRI_BELOW:
        add_body_slopes(by, row, column, w->by_pred + w->pair[i]);
        return apart || is_zero(by, row + 6, n, column, 12);
    case MBSRI_ABOVE:
        add_body_slopes(by, row, column, w->on_pred + w->pair[j]);
        return apart || is_zero(by, row, 6, column + 12, joint);
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
    const int *list = every ? &i : m->list_index + force->list,
              bodies = every ? 1 : force->def.bodies,
              status = mbsri_force_slopes(m, d, force, i, &w->slopes);
    const mbsr_force_derivatives *by = &w->slopes.out;
    for (int k = 0; k < bodies && !status; ++k) {
        for (int l = 0; l < bodies && !joints; ++l) {
            if (list[k] > 0 && list[l] > 0 && !add_block(w, force, list[k], k, list[l], l))
                return MBSRI_NOT_SERVED;
        }
        if (joints && list[k] > 0) add_joint_slopes(w, list[k], by, by->row[k], by->column[k]);
    }
    return status;
}

int mbsri_newton_slopes_at(mbsri_newton_sweeps *newton, mbsr_data *d)
{
    const mbsr_model *m = newton->model;
    const mbsri_force *force = m->forces.data;
    int status = MBSR_OK;
    clear_slopes(newton);
    for (size_t k = 0; k < m->forces.count; ++k, ++force) {
        if (mbsri_is_gravity(&force->def)) continue;
        const bool every = (force->def.table->flags & MBSR_FORCE_EVERY_BODY) != 0;
        const int calls = every ? m->bodies : 1;
        for (int i = 1; i <= calls && !status; ++i) status = slopes_of_call(newton, d, force, i);
    }
    return status;
}
