/* What the sweeps over loops read and keep some bodies ahead. In large models it is in memory, in
 * pieces of a few lines that lie in a dozen arrays, and asked for before it is needed.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * In stages, as one piece tells where the next is: pools and ends of closures; closures; the rest.
 */
#ifndef MBSRI_NEWTON_AHEAD_H
#define MBSRI_NEWTON_AHEAD_H

#include "base/expect.h"
#include "newton/sweeps/closing.h"

/* How many bodies. */
enum { POOLS_AHEAD = 9, CLOSURES_AHEAD = 6, NUMBERS_AHEAD = 3 };

MBSRI_INLINE bool is_body(const mbsri_newton_sweeps *newton, int i)
{
    return i >= 1 && i <= newton->tree->bodies;
}

MBSRI_INLINE void expect_pools(const mbsri_newton_sweeps *newton, int i)
{
    const mbsri_carried *v = &newton->blocks->carried;
    if (!is_body(newton, i)) return;
    const int k = v->first_closing[i];
    if (v->served[i]) mbsri_expect(v->lane_pool + i, v->lane_pool + i + 1);
    if (k == 0) return;
    mbsri_expect(v->lane_pool + k, v->lane_pool + k + 1);
    mbsri_expect(v->front + k, v->front + k + 1);
}

/* ---- factorisation ---- */

/* The first end of a closure at body i; -1: there is none. */
MBSRI_INLINE int first_end(const mbsri_newton_sweeps *newton, int i)
{
    return is_body(newton, i) ? newton->blocks->carried.first_end[i] : -1;
}

/* Its closure, and that closure's derivatives. */
MBSRI_INLINE void expect_closure(const mbsri_newton_sweeps *newton, int end)
{
    const mbsri_carried *v = &newton->blocks->carried;
    if (end < 0) return;
    const int k = v->end[end].closure;
    const mbsri_closure *c = (const mbsri_closure *)newton->model->closures.data + k;
    mbsri_expect(c, c + 1);
    mbsri_expect(v->loop + k, v->loop + k + 1);
}

MBSRI_INLINE void expect_rows(const mbsri_newton_sweeps *newton, const mbsr_data *data, int end)
{
    const mbsri_carried *v = &newton->blocks->carried;
    if (end < 0) return;
    const int k = v->end[end].closure;
    const mbsri_closure *c = (const mbsri_closure *)newton->model->closures.data + k;
    const double *C = data->closure_C + c->at, *S = v->store + v->loop[k].S;
    mbsri_expect(C, C + c->rows * c->columns);
    mbsri_expect(S, S + (c->columns + c->rows) * c->columns);
}

/* What passing body i reads and keeps. */
MBSRI_INLINE void expect_passage(const mbsri_sweep_run *run, const mbsri_newton_sweeps *newton,
                                 int i)
{
    const mbsri_carried *v = &newton->blocks->carried;
    if (!is_body(newton, i)) return;
    const int k = v->first_closing[i];
    const double *record = v->store + v->lane_pool[i].record;
    mbsri_expect(run->tree->body + i, run->tree->body + i + 1);
    mbsri_expect(run->state + i, run->state + i + 1);
    if (v->served[i])
        mbsri_expect_room(record,
                          record + MBSRI_LANE_RECORD * mbsri_lane_span(v->lane_pool[i].most));
    if (k == 0) return;
    record = v->store + v->lane_pool[k].record;
    mbsri_expect_room(record, record + mbsri_closing_size(v->lane_pool[k].most));
}

MBSRI_INLINE void expect_factor(const mbsri_sweep_run *run, const mbsri_newton_sweeps *newton,
                                int i)
{
    const mbsri_loop_end *end = newton->blocks->carried.end;
    const int first = first_end(newton, i - POOLS_AHEAD);
    if (first >= 0) mbsri_expect(end + first, end + first + 1);
    expect_pools(newton, i - POOLS_AHEAD);
    expect_closure(newton, first_end(newton, i - CLOSURES_AHEAD));
    expect_rows(newton, run->data, first_end(newton, i - NUMBERS_AHEAD));
    expect_passage(run, newton, i - NUMBERS_AHEAD);
}

/* ---- solution ---- */

/* Of body i, in the sweep to the root, or to the leaves. */
MBSRI_INLINE void expect_numbers(const mbsri_newton_sweeps *newton, int i, bool to_root)
{
    const mbsri_carried *v = &newton->blocks->carried;
    if (!is_body(newton, i)) return;
    const mbsri_newton_step *s = newton->step + i;
    const mbsri_newton_column *col = mbsri_newton_column_at(newton, s->u);
    if (s->n == 1 && to_root)
        mbsri_expect(col->S, col + 1);
    else if (s->n == 1)
        mbsri_expect(col, col->C);
    if (s->n == 1 && s->flags & MBSRI_FRONT) {
        const open_record by = record_of(newton, i, 0);
        mbsri_expect(to_root ? by.m : by.z, to_root ? by.z : by.p + (by.p - by.e));
    }
    if (!(s->flags & MBSRI_CLOSES)) return;
    const int k = v->first_closing[i];
    const closing c = closing_of(v, k, v->lane_pool[k].count, is_below_massless(newton, i));
    mbsri_expect(to_root ? c.LU : c.right, to_root ? c.W : c.Q);
    if (!to_root) mbsri_expect(c.W, c.W + c.size * CLOSED_MOTIONS);
}

/* `by`: -1 in the sweep to the root, 1 in that to the leaves. */
MBSRI_INLINE void expect_solution(const mbsri_newton_sweeps *newton, int i, int by)
{
    expect_pools(newton, i + by * POOLS_AHEAD);
    expect_numbers(newton, i + by * NUMBERS_AHEAD, by < 0);
}

#endif
