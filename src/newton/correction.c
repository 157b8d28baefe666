/* Force elements between bodies that are no neighbours: a correction of low rank.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * What the elimination on the tree leaves out of an element's derivatives is a small matrix E =
 * left * read: forces on some bodies (and joints) by the motion of others. With Z the motion that
 * the tree answers to the loads `left` of all elements, the system's solution is that of the tree
 * with additional loads left * w (Sherman, Morrison and Woodbury),
 *
 *   (1 - read Z) w = read x0,     x0: the tree's solution without them */
#include "newton/correction.h"

#include "algebra/dense.h"
#include "base/error.h"
#include "newton/carried/block.h"
#include "newton/slopes/force_slopes.h"
#include "newton/slopes/low_rank.h"
#include "newton/slopes/relation.h"
#include "newton/sweeps/sweeps.h"
#include "recursion/spans.h"

#include <math.h>

/* ---- E = left * read ---- */

static void clear_block(const mbsr_force_derivatives *s, int row, int rows, int column, int columns)
{
    for (int k = column; k < column + columns; ++k) {
        double *x = s->matrix + (size_t)k * (size_t)s->rows + row;
        for (int l = 0; l < rows; ++l) x[l] = 0.0;
    }
}

/* Leaves in s what the elimination on the tree leaves out. */
static void clear_tree(const mbsr_model *m, const mbsri_force *force,
                       const mbsr_force_derivatives *s)
{
    const int *bodies = m->stored.list_index + force->list;
    for (int k = 0; k < force->def.bodies; ++k) {
        for (int l = 0; l < force->def.bodies; ++l) {
            const mbsri_relation relation = mbsri_relate(m, bodies[k], bodies[l]);
            if (relation == MBSRI_APART) continue;
            const mbsri_body *a = m->body + bodies[k], *b = m->body + bodies[l];
            const int x = mbsri_pose_size(b) + b->d;
            clear_block(s, s->row[k], relation == MBSRI_ABOVE ? a->d : a->d + a->n, s->column[l],
                        relation == MBSRI_BELOW ? x : x + b->nq + b->n);
        }
    }
}

/* Typical sizes of the motions of an element: of its rows, and of its columns over 1 / c. */
static void measure_motions(const mbsr_newton *w, const mbsri_force *force,
                            const mbsr_force_derivatives *s, const mbsri_low_rank_spans *span)
{
    const mbsr_model *m = w->model;
    const mbsri_spans spans = mbsri_spans_of(m, NULL);
    const double rate = fabs(w->sweeps->c);
    for (int k = 0; k < force->def.bodies; ++k) {
        const mbsri_body *b = m->body + m->stored.list_index[force->list + (size_t)k];
        if (s->row[k] < 0) continue;
        double *row = span->row + s->row[k], *column = span->column + s->column[k];
        for (int l = 0; l < b->d; ++l) *row++ = mbsri_pose_span(&spans, b, l);
        for (int l = 0; l < b->n; ++l) *row++ = mbsri_coordinate_span(&spans, m, b, true, l);
        for (int l = 0; l < mbsri_pose_size(b); ++l) *column++ = mbsri_pose_span(&spans, b, l);
        for (int l = 0; l < b->d; ++l) *column++ = rate * mbsri_pose_span(&spans, b, l);
        for (int l = 0; l < b->nq; ++l) *column++ = mbsri_coordinate_span(&spans, m, b, false, l);
        for (int l = 0; l < b->n; ++l)
            *column++ = rate * mbsri_coordinate_span(&spans, m, b, true, l);
    }
}

static int decompose_element(mbsr_newton *w, mbsr_data *d, mbsri_across *a)
{
    const mbsr_model *m = w->model;
    const mbsri_force *force = (const mbsri_force *)m->forces.data + a->force;
    const int status = mbsri_force_slopes(m, d, force, 0, &w->slopes);
    if (status) return status;
    const mbsr_force_derivatives *s = &w->slopes.out;
    clear_tree(m, force, s);
    const mbsri_low_rank_spans *span = &w->correction.span;
    measure_motions(w, force, s, span);
    const double least = 1e-13 * mbsri_longest_column(s->rows, s->columns, s->matrix, span);
    a->rank = mbsri_low_rank(s->rows, s->columns, s->matrix, span, w->correction.left + a->left,
                             w->correction.read + a->read, a->most, least);
    return MBSR_OK;
}

/* ---- motions and loads of an element ---- */

/* weights (of the element's rank) = read * motion, where the tree's solution is delta. */
static void read_motion(const mbsr_newton *w, const mbsri_across *a, const double *delta,
                        double *weights)
{
    const mbsr_model *m = w->model;
    const mbsri_force *force = (const mbsri_force *)m->forces.data + a->force;
    const double *read = w->correction.read + a->read;
    mbsri_zero((size_t)a->rank, weights);
    for (int k = 0; k < force->def.bodies; ++k) {
        const int i = m->stored.list_index[force->list + (size_t)k];
        const mbsri_body *b = m->body + i;
        if (i == 0) continue;
        const double *parts[] = {w->motion + 12 * (size_t)i, delta + b->q,
                                 delta + m->nq + m->nu + b->u};
        const int lengths[] = {mbsri_pose_size(b) + b->d, b->nq, b->n};
        for (int part = 0; part < 3; ++part) {
            for (int l = 0; l < lengths[part]; ++l, read += a->most) {
                for (int r = 0; r < a->rank; ++r) weights[r] += read[r] * parts[part][l];
            }
        }
    }
}

/* load += left * weights */
static void add_load(const mbsr_newton *w, const mbsri_across *a, const double *weights,
                     double *load)
{
    const mbsr_model *m = w->model;
    const mbsri_force *force = (const mbsri_force *)m->forces.data + a->force;
    for (int r = 0; r < a->rank; ++r) {
        const double *left = w->correction.left + a->left + (size_t)r * (size_t)a->most;
        for (int k = 0; k < force->def.bodies; ++k) {
            const int i = m->stored.list_index[force->list + (size_t)k];
            const mbsri_body *b = m->body + i;
            if (i == 0) continue;
            for (int l = 0; l < b->d; ++l) load[b->v + (size_t)l] += *left++ * weights[r];
            for (int l = 0; l < b->n; ++l)
                load[m->size.v + (size_t)(b->iu + l)] += *left++ * weights[r];
        }
    }
}

static size_t load_size(const mbsr_newton *w)
{
    return w->model->size.v + (size_t)w->model->nu;
}

/* ---- factoring and solving ---- */

/* Column `first + r`: 1 - read Z. */
static void answer(mbsr_newton *w, const mbsri_across *a, int r, int size)
{
    mbsri_correction *c = &w->correction;
    double *column = c->matrix + (size_t)(a->first + r) * (size_t)size;
    mbsri_zero(load_size(w), w->load);
    mbsri_zero((size_t)a->rank, c->weights);
    c->weights[r] = 1.0;
    add_load(w, a, c->weights, w->load);
    mbsri_newton_sweeps_solve(w->sweeps, NULL, w->load, c->delta, w->motion);
    for (int k = 0; k < c->count; ++k)
        read_motion(w, c->element + k, c->delta, column + c->element[k].first);
    for (int k = 0; k < size; ++k) column[k] = -column[k];
    column[a->first + r] += 1.0;
}

int mbsri_correction_factor(mbsr_newton *w, mbsr_data *d)
{
    mbsri_correction *c = &w->correction;
    int size = 0;
    for (int k = 0; k < c->count; ++k) {
        const int status = decompose_element(w, d, c->element + k);
        if (status) return status;
        c->element[k].first = size;
        size += c->element[k].rank;
    }
    w->info.rank = size;
    for (int k = 0; k < c->count; ++k) {
        for (int r = 0; r < c->element[k].rank; ++r) answer(w, c->element + k, r, size);
    }
    for (int k = 0; k < size; ++k) {
        c->rows[k] = 0.0;
        for (int l = 0; l < size; ++l) c->rows[k] += fabs(c->matrix[l * size + k]);
    }
    if (mbsri_block_factor(size, c->matrix, c->rows, c->columns, c->pivots)) return MBSR_OK;
    const mbsri_force *force = (const mbsri_force *)w->model->forces.data + c->element[0].force;
    return mbsri_fail(
        &d->error, MBSR_SINGULAR_BLOCK, MBSR_NONE, force->id,
        "the Newton equations of the %d force elements across the tree are singular "
        "at t = %g; mbsr_index_report_create names joint rates that nothing determines",
        c->count, d->t);
}

void mbsri_correction_solve(mbsr_newton *w, const double *r, bool loaded, double *delta)
{
    mbsri_correction *c = &w->correction;
    mbsri_newton_sweeps_solve(w->sweeps, r, loaded ? w->load : NULL, c->delta, w->motion);
    for (int k = 0; k < c->count; ++k)
        read_motion(w, c->element + k, c->delta, c->weights + c->element[k].first);
    mbsri_block_solve(w->info.rank, c->matrix, c->rows, c->columns, c->pivots, c->weights);
    if (!loaded) mbsri_zero(load_size(w), w->load);
    for (int k = 0; k < c->count; ++k)
        add_load(w, c->element + k, c->weights + c->element[k].first, w->load);
    mbsri_newton_sweeps_solve(w->sweeps, r, w->load, delta, w->motion);
}
