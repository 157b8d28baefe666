/* Derivatives of closures for Newton systems: see closure_slopes.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "newton/slopes/closure_slopes.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "base/error.h"
#include "closures/stock.h"
#include "model/query.h"
#include "newton/slopes/low_rank.h"
#include "recursion/closure_differences.h"
#include "recursion/closure_rows.h"
#include "recursion/closures.h"
#include "recursion/spans.h"

size_t mbsri_closure_tangents_work(const mbsri_closure *c)
{
    return (size_t)c->columns * (size_t)(4 + c->rows + c->columns);
}

bool mbsri_closure_tangents_serve(const mbsr_model *m, const mbsri_closure *c)
{
    if (!(c->def.table->flags & MBSR_CLOSURE_JOINTS)) return true;
    for (int k = 0; k < c->def.bodies; ++k) {
        if (c->body[k] > 0 && m->body[c->body[k]].joint.table->coordinate_rates) return false;
    }
    return true;
}

bool mbsri_closure_is_constant(const mbsri_closure *c)
{
    return c->def.table->tangent == mbsri_constant_rows;
}

/* E <- S without what each body does to itself. */
static void take_across(const mbsri_closure *c, const double *S, double *E)
{
    const int columns = c->columns;
    mbsri_copy((size_t)columns * (size_t)columns, S, E);
    for (int k = 0; k < c->bodies; ++k) {
        int last = columns;
        for (int l = 0; l < c->bodies; ++l) {
            if (c->column[l] > c->column[k] && c->column[l] < last) last = c->column[l];
        }
        for (int j = c->column[k]; j >= 0 && j < last; ++j) {
            for (int i = c->column[k]; i < last; ++i) E[j * columns + i] = 0.0;
        }
    }
}

/* By the table's own derivatives, zero along a root. */
static int own_tangent(const mbsr_model *m, mbsr_data *d, const mbsri_closure *c,
                       const mbsri_closure_tangents *out)
{
    const size_t columns = (size_t)c->columns, rows = (size_t)c->rows;
    const mbsr_closure_tangent to = {out->S, out->slope, c->rows, c->columns, c->column};
    mbsri_closure_view view;
    mbsri_view_closure(m, d, c, true, &view);
    mbsri_zero(columns * columns, out->S);
    mbsri_zero(rows * columns, out->slope);
    const int status = mbsri_closure_table_tangent(c, &view.args, d->loop_lambda + c->row, &to);
    for (int k = 0; k < c->bodies; ++k) {
        if (c->body[k] > 0 || c->column[k] < 0) continue;
        const size_t at = (size_t)c->column[k], count = (size_t)m->root.d;
        mbsri_zero(columns * count, out->S + at * columns);
        mbsri_zero(rows * count, out->slope + at * rows);
    }
    return status;
}

int mbsri_closure_tangents_of(const mbsr_model *m, mbsr_data *d, const mbsri_closure *c,
                              double *work, mbsri_closure_tangents *out)
{
    const size_t columns = (size_t)c->columns, rows = (size_t)c->rows;
    out->rank = 0;
    const int status =
        c->def.table->tangent
            ? own_tangent(m, d, c, out)
            : mbsri_closure_tangent(m, d, c, d->loop_lambda + c->row, work, out->S, out->slope);
    if (status) return mbsri_closure_failed(m, d, c, status, "a function");
    if (!mbsri_finite(columns * columns, out->S) || !mbsri_finite(rows * columns, out->slope)) {
        char label[MBSRI_LABEL];
        return mbsri_fail(
            &d->error, MBSR_NOT_FINITE, MBSR_NONE, MBSR_NONE,
            "%s (%s): its derivatives are not finite at t = %g",
            mbsri_closure_label(m, (int)(c - (const mbsri_closure *)m->closures.data), label),
            c->def.table->name, d->t);
    }
    return MBSR_OK;
}

/* Typical sizes of the motions that its columns are of. */
static void measure_columns(const mbsr_model *m, const mbsri_closure *c, double *span)
{
    const mbsri_spans spans = mbsri_spans_of(m, NULL);
    for (int k = 0; k < c->bodies; ++k) {
        const mbsri_body *b = m->body + c->body[k];
        if (c->column[k] < 0) continue;
        for (int l = 0; l < b->d; ++l) *span++ = mbsri_pose_span(&spans, b, l);
        for (int l = 0; l < b->n && mbsri_reads_joints(c); ++l)
            *span++ = mbsri_coordinate_span(&spans, m, b, true, l);
    }
}

void mbsri_closure_across(const mbsr_model *m, const mbsri_closure *c, double *work,
                          mbsri_closure_tangents *out)
{
    const int columns = c->columns;
    double *span = work + (size_t)columns * (size_t)columns;
    const mbsri_low_rank_spans spans = {span, span};
    take_across(c, out->S, work);
    measure_columns(m, c, span);
    /* shorter columns are rounding errors of the differences */
    const double least = 1e-10 * mbsri_longest_column(columns, columns, out->S, &spans);
    out->rank =
        mbsri_low_rank(columns, columns, work, &spans, out->left, out->read, out->most, least);
}
