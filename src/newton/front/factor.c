/* Factoring: see front.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "newton/front/pass.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "base/error.h"
#include "model/query.h"
#include "newton/front/axes_step.h"
#include "newton/front/crowd.h"
#include "newton/front/floating.h"
#include "newton/front/pivots.h"
#include "recursion/backward.h"
#include "recursion/closure_view.h"

/* ---- what is left singular ---- */

static int singular_joint(const mbsri_front *f, mbsr_data *d, int i, int kind)
{
    const mbsri_body *b = f->model->body + i;
    const bool loops = f->model->rows > 0 && f->linear->below_massless[i];
    char label[MBSRI_LABEL];
    if (kind == MBSRI_FRONT_PLACE)
        return mbsri_fail(&d->error, MBSR_SINGULAR_BLOCK, b->id, MBSR_NONE,
                          "%s: joint '%s': c - d(q')/dq is singular at t = %g; take a shorter step",
                          mbsri_body_label(f->model, i, label), b->joint.table->name, d->t);
    return mbsri_fail(&d->error, MBSR_SINGULAR_BLOCK, b->id, MBSR_NONE,
                      "%s: joint '%s': %s at t = %g; " MBSRI_SINGULAR_ADVICE,
                      mbsri_body_label(f->model, i, label), b->joint.table->name,
                      loops ? "no loop holds its massless motion" : "its equations are singular",
                      d->t);
}

int mbsri_front_refuse_row(const mbsr_model *m, mbsr_data *d, int closure, int row)
{
    const mbsri_closure *c = (const mbsri_closure *)m->closures.data + closure;
    char label[MBSRI_LABEL];
    return mbsri_fail(&d->error, MBSR_LOOP_SINGULAR, MBSR_NONE, MBSR_NONE,
                      "%s (%s): row '%s' depends on other rows at t = %g; mbsr_closures_report "
                      "names redundant rows and singular positions",
                      mbsri_closure_label(m, closure, label), c->def.table->name,
                      mbsri_closure_row_name(m, c, row), d->t);
}

/* Names the joint nearest to the leaves, or else a row of a closure, that is left. Rounding alone
 * leaves a joint's unknown with rows of closures, or its row with multipliers: these depend on each
 * other then. */
static int singular(const mbsri_front *f, mbsr_data *d, const mbsri_front_pivots *p)
{
    const mbsr_model *m = f->model;
    int joint = 0, joint_row = 0, closure = 0, number = 0, joint_kind = MBSRI_FRONT_NONE;
    for (int l = p->done; l < p->size; ++l) {
        const int owner = f->columns.owner[p->column[l]], row = f->rows.owner[p->row[l]],
                  kind = f->columns.kind[p->column[l]];
        if (kind == MBSRI_FRONT_PENDING) continue;
        if (owner > joint || (owner == joint && kind == MBSRI_FRONT_PLACE))
            joint = owner, joint_kind = kind;
        if (row > joint_row) joint_row = row;
        if (owner < closure) closure = owner, number = p->column[l] - f->columns.count;
        if (row < closure) closure = row, number = p->row[l] - f->rows.count;
    }
    if (joint > 0 && (joint_row > 0 || closure == 0))
        return singular_joint(f, d, joint, joint_kind);
    const mbsri_closure *c = (const mbsri_closure *)m->closures.data - 1 - closure;
    const int row = number < m->rows ? number - c->row : number - m->rows - c->position_row;
    return mbsri_front_refuse_row(m, d, -1 - closure, row);
}

static int not_finite(const mbsri_front *f, mbsr_data *d, int i)
{
    const mbsri_body *b = f->model->body + i;
    char label[MBSRI_LABEL];
    return mbsri_fail(&d->error, MBSR_NOT_FINITE, b->id, MBSR_NONE,
                      "%s: joint '%s': its Newton equations are not finite at t = %g",
                      mbsri_body_label(f->model, i, label), b->joint.table->name, d->t);
}

/* ---- factoring ---- */

/* d(M u) of the joint, then dp' but for c dp, over the columns as they stand now: column by column.
 */
static void keep_momentum(const mbsri_front *f, const mbsri_front_build *b,
                          const mbsri_front_pivots *p, double *to)
{
    const int n = b->b->n, momentum = f->rows.at[b->at.momentum], rate = f->rows.at[b->at.rate];
    for (int l = 0; l < p->columns && n > 0; ++l) {
        const double *from = p->M + (size_t)f->columns.at[p->column[l]] * (size_t)p->stride;
        mbsri_copy((size_t)n, from + momentum, to + 2 * l * n);
        mbsri_copy((size_t)n, from + rate, to + (2 * l + 1) * n);
    }
}

/* Whether what is handed on is y of the predecessor over its x, whatever else was in the front. */
static bool leaves_plain(const mbsri_front_build *b, const mbsri_front_pivots *p)
{
    const mbsri_front *f = b->f;
    const mbsri_front_step *s = b->step;
    const int parent = b->b->parent;
    const bool alone = s->borders == 0 ||
                       (s->borders == 1 && f->plan.border[s->first_border].body == parent &&
                        !f->plan.coordinates[parent]),
               bare = alone && !f->served && f->model->position_rows == 0;
    return p->done == p->size && (b->plain || bare);
}

/* Columns of L and rows of U of what was eliminated, the numbers, and what is handed on. */
static void keep(mbsri_front *f, const mbsri_front_build *b, const mbsri_front_pivots *p)
{
    const mbsri_front_step *s = b->step;
    const int done = p->done;
    double *L = f->LU + s->LU, *U = L + (size_t)done * (size_t)p->rows,
           *to = f->matrices + s->matrix;
    int *numbers = f->numbers + s->numbers;
    f->left[b->k] =
        (mbsri_front_left){done, p->rows, p->columns, p->size - done, leaves_plain(b, p)};
    for (int k = 0; k < p->rows; ++k) numbers[k] = p->row[k];
    for (int k = 0; k < p->columns; ++k) numbers[p->rows + k] = p->column[k];
    for (int k = 0; k < done; ++k) {
        mbsri_copy((size_t)p->rows, p->M + (size_t)k * (size_t)p->stride,
                   L + (size_t)(k * p->rows));
        for (int l = k; l < p->columns; ++l)
            U[k * p->columns + l] = p->M[(size_t)l * (size_t)p->stride + (size_t)k];
    }
    keep_momentum(f, b, p, U + done * p->columns);
    for (int l = done; l < p->columns; ++l) {
        mbsri_copy((size_t)(p->rows - done), p->M + (size_t)l * (size_t)p->stride + done, to);
        to += p->rows - done;
    }
}

/* How many unknowns a step may leave to the next; whether others want that room, too. */
static int room_of(const mbsri_front *f, const mbsri_front_step *s, bool *scarce)
{
    const mbsri_front_step *next = s->next >= 0 ? f->plan.step + s->next : NULL;
    *scarce = false;
    if (s->borders == 0) return 0;
    if (!next || !next->crowded) return s->delayed;
    *scarce = next->room < MBSRI_FRONT_ROOM / 2;
    return next->room < s->delayed ? next->room : s->delayed;
}

/* Of those that were left, what is not pending. */
static void take_room(const mbsri_front *f, const mbsri_front_step *s, const mbsri_front_pivots *p)
{
    if (s->next < 0 || !f->plan.step[s->next].crowded) return;
    for (int l = p->done; l < p->size; ++l)
        f->plan.step[s->next].room -= p->column_kind[p->column[l]] != MBSRI_FRONT_PENDING;
}

/* False: something singular is left. */
static bool eliminate(mbsri_front *f, const mbsri_front_build *b, mbsri_front_pivots *p)
{
    *p = (mbsri_front_pivots){.size = b->size,
                              .rows = b->rows,
                              .columns = b->columns,
                              .stride = b->all_rows,
                              .watched = b->watched,
                              .lacks_mass = b->lacks_mass,
                              .M = b->M,
                              .N = b->N,
                              .row = b->row,
                              .column = b->column,
                              .row_kind = f->rows.kind,
                              .column_kind = f->columns.kind,
                              .row_scale = f->now.row_scale,
                              .column_scale = f->now.column_scale,
                              .largest = f->now.largest};
    p->delayed = room_of(f, b->step, &p->scarce);
    return mbsri_front_eliminate(p);
}

static int pass(mbsri_front *f, mbsr_data *d, int k)
{
    mbsri_front_build b;
    mbsri_front_pivots p;
    int status =
        f->linear->whole ? MBSR_OK : mbsri_linear_joint(f->linear, d, f->plan.step[k].body);
    bool done = false;
    if (!status && f->plan.step[k].axes) status = mbsri_front_step_axes(f, d, k, &done);
    if (!status && !done) status = mbsri_front_assemble(f, d, k, false, &b);
    if (status || done) return status;
    mbsri_front_pass(&b);
    const size_t stride = (size_t)b.all_rows, count = stride * (size_t)b.columns;
    if (!mbsri_finite(stride * (size_t)b.size, b.M)) return not_finite(f, d, b.i);
    bool regular = eliminate(f, &b, &p);
    if (regular && p.done < p.size && !b.watched) { /* seldom */
        status = mbsri_front_assemble(f, d, k, true, &b);
        if (status) return status;
        mbsri_front_pass(&b);
        regular = eliminate(f, &b, &p);
    }
    if (!regular) return singular(f, d, &p);
    if (!mbsri_finite(count, b.M)) return not_finite(f, d, b.i);
    keep(f, &b, &p);
    take_room(f, b.step, &p);
    return MBSR_OK;
}

int mbsri_front_pass_body(mbsri_front *f, mbsr_data *d, int i)
{
    return pass(f, d, f->plan.position[i]);
}

void mbsri_front_hand_on(mbsri_front *f, int i)
{
    f->left[f->plan.position[i]] = (mbsri_front_left){.plain = true};
}

/* All steps. Where a pivot of a body that floats is not good, all again as if none did. */
static int pass_all(mbsri_front *f, mbsr_data *d)
{
    int status = MBSR_OK;
    bool done = true;
    for (int k = 0; k < f->plan.steps && f->plan.crowded; ++k)
        f->plan.step[k].room = MBSRI_FRONT_ROOM;
    for (int k = 0; k < f->plan.steps && !status && done; ++k)
        status = f->plan.step[k].floats ? mbsri_floating_pass(f, d, k, &done) : pass(f, d, k);
    if (status || done) return status;
    for (int k = 0; k < f->plan.steps; ++k) f->plan.step[k].floats = false;
    return pass_all(f, d);
}

int mbsri_front_factor(mbsri_front *f, mbsr_data *d, double t, const double *y, const double *yp,
                       double c)
{
    f->c = c;
    int status = f->linear->whole ? mbsri_linear_at(f->linear, d, t, y, yp, c)
                                  : mbsri_linear_open(f->linear, d, t, y, yp, c);
    if (!status) status = mbsri_front_replan(f, d);
    if (!status && mbsri_front_iterates(f)) mbsri_front_crowd_begin(f, d);
    if (!status) mbsri_floating_begin(f, d);
    if (!status) status = pass_all(f, d);
    if (!status && mbsri_front_iterates(f)) mbsri_front_crowd_finish(f, mbsri_floating_response);
    if (!status && f->model->order.grouped) status = mbsri_backward(f->model, d);
    return status;
}
