/* Loops that close, in the Newton sweeps: the unknowns of a pool of which none is carried on.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * With R x + T v = s and y = P x + Q v + b (fronts.h),
 *
 *   v = T^-1 s - W x,   W = T^-1 R,      P <- P - Q W,   b <- b + Q T^-1 s
 *
 * T is scaled by powers of two and factored with complete pivoting; what is singular or not finite, and
 * pools of which something is carried on, go to newton/blocks/front.c, which can say what it is. */
#ifndef MBSRI_NEWTON_CLOSING_H
#define MBSRI_NEWTON_CLOSING_H

#include "newton/sweeps/ends.h"

#include <stdint.h>

/* What is kept, in the order of the exchanges: LU (span x span, by columns) of the scaled T, W (16 a
 * row), Q (24 a column), T^-1 s, all of them scaled; the scales; which row and column it was. */
typedef struct closing {
    double *LU, *W, *Q, *right, *by_row, *by_column;
    int *row, *column, size, span;
} closing;

MBSRI_INLINE closing closing_of(const mbsri_carried *v, int k)
{
    const mbsri_front *front = v->front + k;
    const int span = front->span;
    double *LU = v->store + front->record, *W = LU + span * span,
           *Q = W + MBSRI_SWEPT_MOTIONS * span, *right = Q + MBSRI_SWEPT_ACTIONS * span;
    int *row = v->numbers + front->order;
    return (closing){.LU = LU,
                     .W = W,
                     .Q = Q,
                     .right = right,
                     .by_row = right + span,
                     .by_column = right + 2 * span,
                     .row = row,
                     .column = row + span,
                     .size = v->swept[k].count,
                     .span = span};
}

/* ---- scales ---- */

enum { NO_EXPONENT = -4000, LARGEST_EXPONENT = 500 };

MBSRI_INLINE int exponent_of(double x)
{
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    const int exponent = (int)(bits >> 52 & 0x7ff);
    return exponent > 0 ? exponent - 1023 : NO_EXPONENT;
}

MBSRI_INLINE double power_of_two(int exponent)
{
    const int limit = LARGEST_EXPONENT;
    const uint64_t biased = (uint64_t)((exponent > limit    ? limit
                                        : exponent < -limit ? -limit
                                                            : exponent) +
                                       1023);
    const uint64_t bits = biased << 52;
    double x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

/* One scale, of a row or column whose largest entry is this without it: nearer to what makes that 1, by
 * the root, so that neither side gets all of it, or exactly. True: it was within a factor 2. */
MBSRI_INLINE bool adjust(int *scale, int largest, bool exactly)
{
    if (largest <= NO_EXPONENT / 2) return true;
    const int all = largest + *scale;
    *scale -= exactly ? all : all / 2;
    return all >= -1 && all <= 1;
}

/* Exponents of scales with which the largest entry of each row and column is about 1. E: those of the
 * entries, `span` a column. */
MBSRI_INLINE void equilibrate(int size, int span, const int *E, int *of_row, int *of_column)
{
    bool last = false;
    for (int k = 0; k < size; ++k) of_row[k] = of_column[k] = 0;
    for (int round = 0; round < 6; ++round) {
        bool even = true;
        const bool exactly = last || round == 5;
        for (int i = 0; i < size; ++i) {
            int largest = NO_EXPONENT;
            for (int j = 0; j < size; ++j) {
                const int x = E[j * span + i] + of_column[j];
                largest = x > largest ? x : largest;
            }
            even = adjust(of_row + i, largest, exactly) && even;
        }
        for (int j = 0; j < size; ++j) {
            int largest = NO_EXPONENT;
            for (int i = 0; i < size; ++i) {
                const int x = E[j * span + i] + of_row[i];
                largest = x > largest ? x : largest;
            }
            even = adjust(of_column + j, largest, exactly) && even;
        }
        if (exactly) return;
        last = even;
    }
}

/* ---- T ---- */

/* LU of the scaled T with complete pivoting; false: singular. */
MBSRI_INLINE bool factor_T(const closing *c)
{
    const int size = c->size, span = c->span;
    for (int k = 0; k < size; ++k) c->row[k] = c->column[k] = k;
    for (int k = 0; k < size; ++k) {
        double largest = 1e-13;
        int row = -1, column = -1;
        for (int j = k; j < size; ++j) {
            for (int i = k; i < size; ++i) {
                const double x = fabs(c->LU[j * span + i]);
                if (!(x > largest)) continue;
                largest = x;
                row = i;
                column = j;
            }
        }
        if (row < 0) return false;
        const int i = c->row[row], j = c->column[column];
        c->row[row] = c->row[k], c->row[k] = i;
        c->column[column] = c->column[k], c->column[k] = j;
        for (int l = 0; l < size && column != k; ++l) {
            const double x = c->LU[column * span + l];
            c->LU[column * span + l] = c->LU[k * span + l];
            c->LU[k * span + l] = x;
        }
        for (int l = 0; l < size && row != k; ++l) {
            const double x = c->LU[l * span + row];
            c->LU[l * span + row] = c->LU[l * span + k];
            c->LU[l * span + k] = x;
        }
        double *L = c->LU + k * span;
        const double inverse = 1.0 / L[k];
        for (int l = k + 1; l < size; ++l) L[l] *= inverse;
        for (int l = k + 1; l < size; ++l) {
            double *to = c->LU + l * span;
            for (int r = k + 1; r < size; ++r) to[r] -= L[r] * to[k];
        }
        L[k] = inverse;
    }
    return true;
}

/* x <- U^-1 L^-1 x, numbers in the order of the exchanges. */
MBSRI_INLINE void solve_T(const closing *c, double *x)
{
    const int size = c->size, span = c->span;
    for (int k = 0; k < size; ++k) {
        for (int l = k + 1; l < size; ++l) x[l] -= c->LU[k * span + l] * x[k];
    }
    for (int k = size - 1; k >= 0; --k) {
        x[k] *= c->LU[k * span + k];
        for (int l = 0; l < k; ++l) x[l] -= c->LU[k * span + l] * x[k];
    }
}

/* The same of rows of four groups. */
MBSRI_INLINE void solve_rows(const closing *c, double *x)
{
    const int size = c->size, span = c->span, of = MBSRI_SWEPT_MOTIONS;
    for (int k = 1; k < size; ++k) {
        v4 sum[4] = {load3(x + of * k), load3(x + of * k + 4), load3(x + of * k + 8),
                     load3(x + of * k + 12)};
        for (int l = 0; l < k; ++l) {
            const v4 factor = splat(c->LU[l * span + k]);
            for (int g = 0; g < 4; ++g) sum[g] -= factor * load3(x + of * l + 4 * g);
        }
        for (int g = 0; g < 4; ++g) store3(x + of * k + 4 * g, sum[g]);
    }
    for (int k = size - 1; k >= 0; --k) {
        v4 sum[4] = {load3(x + of * k), load3(x + of * k + 4), load3(x + of * k + 8),
                     load3(x + of * k + 12)};
        for (int l = k + 1; l < size; ++l) {
            const v4 factor = splat(c->LU[l * span + k]);
            for (int g = 0; g < 4; ++g) sum[g] -= factor * load3(x + of * l + 4 * g);
        }
        const v4 inverse = splat(c->LU[k * span + k]);
        for (int g = 0; g < 4; ++g) store3(x + of * k + 4 * g, sum[g] * inverse);
    }
}

/* ---- a front ---- */

/* Scaled T to LU; false: not finite. E: scratch, span (size + 2). */
MBSRI_INLINE bool scale_T(const closing *c, const open_pool *pool, int *E)
{
    const int size = c->size, span = c->span;
    int *of_row = E + size * span, *of_column = of_row + span;
    double worst = 0.0;
    for (int j = 0; j < size; ++j) {
        for (int i = 0; i < size; ++i) {
            const double x = pool->T[j * pool->most + i];
            c->LU[j * span + i] = x;
            E[j * span + i] = exponent_of(x);
            worst += x - x;
        }
    }
    if (!(worst == 0.0)) return false;
    equilibrate(size, span, E, of_row, of_column);
    for (int k = 0; k < size; ++k) {
        c->by_row[k] = power_of_two(of_row[k]);
        c->by_column[k] = power_of_two(of_column[k]);
    }
    for (int j = 0; j < size; ++j) {
        for (int i = 0; i < size; ++i) c->LU[j * span + i] *= c->by_row[i] * c->by_column[j];
    }
    return true;
}

/* W and Q; false: not finite. */
MBSRI_INLINE bool place_W(const closing *c, const open_pool *pool)
{
    v4 worst = splat(0.0);
    for (int k = 0; k < c->size; ++k) {
        const double *R = pool->R + c->row[k] * MBSRI_SWEPT_MOTIONS,
                     *Q = pool->Q + c->column[k] * MBSRI_SWEPT_ACTIONS;
        double *to = c->W + k * MBSRI_SWEPT_MOTIONS, *to_Q = c->Q + k * MBSRI_SWEPT_ACTIONS;
        const v4 by_row = splat(c->by_row[k]), by_column = splat(c->by_column[k]);
        for (int g = 0; g < MBSRI_SWEPT_MOTIONS; g += 4) store3(to + g, load3(R + g) * by_row);
        for (int g = 0; g < MBSRI_SWEPT_ACTIONS; g += 4) {
            const v4 x = load3(Q + g) * by_column;
            store3(to_Q + g, x);
            worst += x - x;
        }
    }
    solve_rows(c, c->W);
    for (int k = 0; k < c->size * MBSRI_SWEPT_MOTIONS; k += 4) {
        const v4 x = load3(c->W + k);
        worst += x - x;
    }
    return sum3(worst) == 0.0;
}

/* P -= Q W, Y likewise. */
MBSRI_INLINE void subtract_closed(const closing *c, slab *y, bool deep)
{
    const int of = MBSRI_SWEPT_ACTIONS;
    for (int g = 0; g < MBSRI_SWEPT_MOTIONS; ++g) {
        if (g % 4 == 3) continue; /* idle */
        v4 *P = y->P[g / 4][g % 4], *Y = y->Y[g / 4][g % 4];
        v4 sum[4] = {P[0], P[1], P[2], P[3]};
        for (int k = 0; k < c->size; ++k) {
            const v4 x = splat(c->W[k * MBSRI_SWEPT_MOTIONS + g]);
            for (int r = 0; r < 4; ++r) sum[r] -= load3(c->Q + k * of + 4 * r) * x;
            for (int r = 0; r < 2 && deep; ++r) Y[r] -= load3(c->Q + k * of + 16 + 4 * r) * x;
        }
        for (int r = 0; r < 4; ++r) P[r] = sum[r];
    }
}

/* By its numbers in turn. */
MBSRI_INLINE void exchange(int size, const int *order, double *x, double *scratch)
{
    for (int k = 0; k < size; ++k) scratch[k] = x[order[k]];
    for (int k = 0; k < size; ++k) x[k] = scratch[k];
}

/* Of `size` unknowns, a constant where that makes loops short; y: NULL on the root. */
MBSRI_INLINE bool close_sized(const mbsri_newton_sweeps *newton, int k, int size, slab *y)
{
    const mbsr_newton *w = newton->blocks;
    const mbsri_carried *v = &w->carried;
    closing c = closing_of(v, k);
    const open_pool pool = view_pool(v, v->swept + k);
    c.size = size;
    if (!scale_T(&c, &pool, (int *)(void *)v->work) || !factor_T(&c)) return false;
    exchange(size, c.row, c.by_row, v->work);
    exchange(size, c.column, c.by_column, v->work);
    if (!y) return true;
    if (!place_W(&c, &pool)) return false;
    if (w->node[v->swept[k].body].deep)
        subtract_closed(&c, y, true);
    else
        subtract_closed(&c, y, false);
    return true;
}

/* Front k, from which nothing is carried on. False: see newton/blocks/front.c. A pin in the plane has
 * four unknowns, or five with a link without mass that it holds. */
MBSRI_OUTLINE bool close_front(mbsri_newton_sweeps *newton, int k, slab *y)
{
    mbsri_carried *v = &newton->blocks->carried;
    bool *closed = &v->front[k].closed;
    switch (v->swept[k].count) {
    case 4: return *closed = close_sized(newton, k, 4, y);
    case 5: return *closed = close_sized(newton, k, 5, y);
    default: return *closed = close_sized(newton, k, v->swept[k].count, y);
    }
}

/* By the dense front; a status. */
MBSRI_OUTLINE int close_by_front(const mbsri_sweep_run *run, mbsri_newton_sweeps *newton, int k,
                                 slab *y)
{
    mbsr_newton *w = newton->blocks;
    double P[MBSRI_SWEPT_MOTIONS * MBSRI_SWEPT_ACTIONS] = {0.0};
    const int status = mbsri_front_close_one(w, run->data, k, P),
              actions = mbsri_carried_actions(w, w->carried.swept + k);
    for (int g = 0; g < 4 && y; ++g) {
        for (int j = 0; j < 3; ++j) {
            const double *x = P + (4 * g + j) * actions;
            for (int r = 0; r < 4; ++r) y->P[g][j][r] += load3(x + 4 * r);
            for (int r = 0; r < 2 && actions == MBSRI_SWEPT_ACTIONS; ++r)
                y->Y[g][j][r] += load3(x + 16 + 4 * r);
        }
    }
    return status;
}

/* Loops that close on body i, or on the root; a status. */
MBSRI_OUTLINE int close_loops_on(const mbsri_sweep_run *run, int i, mbsri_newton_sweeps *newton,
                                 slab *y)
{
    mbsr_newton *w = newton->blocks;
    const mbsri_carried *v = &w->carried;
    int status = MBSR_OK;
    for (int k = v->first_closing[i]; k > 0 && !status; k = v->front[k].next) {
        if (v->swept[k].swept) {
            mbsri_carried_diagonal(w, run->data, k, newton->c);
            if (!v->front[k].passes && close_front(newton, k, y)) continue;
        }
        status = close_by_front(run, newton, k, y);
    }
    return status;
}

/* The loops at body i, before its joint; a status. */
MBSRI_OUTLINE int meet_loops(const mbsri_sweep_run *run, int i, mbsri_newton_sweeps *newton,
                             slab *y)
{
    take_ends(run, i, newton, y);
    return run->tree->body[i].flags & MBSRI_CLOSES ? close_loops_on(run, i, newton, y) : MBSR_OK;
}

/* ---- solution ---- */

/* T^-1 s. */
MBSRI_INLINE void reduce_front(mbsr_newton *w, const closing *c, int k)
{
    const double *s = w->carried.store + w->carried.swept[k].right;
    for (int l = 0; l < c->size; ++l) c->right[l] = s[c->row[l]] * c->by_row[l];
    solve_T(c, c->right);
}

/* Loops that close on body i: what their right-hand sides add to its forces. */
MBSRI_OUTLINE void close_loads(mbsri_newton_sweeps *newton, int i, v4 b[4], v4 psi[2])
{
    mbsr_newton *w = newton->blocks;
    const mbsri_carried *v = &w->carried;
    for (int k = v->first_closing[i]; k > 0; k = v->front[k].next) {
        double own[MBSRI_SWEPT_ACTIONS] = {0.0};
        if (!v->front[k].closed) {
            mbsri_front_reduce_one(w, k, own);
            for (int r = 0; r < 4; ++r) b[r] += load3(own + 4 * r);
            for (int r = 0; r < 2; ++r) psi[r] += load3(own + 16 + 4 * r);
            continue;
        }
        const closing c = closing_of(v, k);
        reduce_front(w, &c, k);
        for (int l = 0; l < c.size && i > 0; ++l) {
            const double *Q = c.Q + l * MBSRI_SWEPT_ACTIONS;
            const v4 x = splat(c.right[l]);
            for (int r = 0; r < 4; ++r) b[r] += load3(Q + 4 * r) * x;
            for (int r = 0; r < 2; ++r) psi[r] += load3(Q + 16 + 4 * r) * x;
        }
    }
}

/* Loops that close on body i, from its motion. */
MBSRI_OUTLINE void close_motion(mbsri_newton_sweeps *newton, int i, const v4 x[4])
{
    mbsr_newton *w = newton->blocks;
    const mbsri_carried *v = &w->carried;
    for (int k = v->first_closing[i]; k > 0; k = v->front[k].next) {
        double at[MBSRI_SWEPT_MOTIONS];
        for (int g = 0; g < 4; ++g) store3(at + 4 * g, first_three(x[g]));
        if (!v->front[k].closed) {
            mbsri_front_substitute_one(w, k, at);
            continue;
        }
        const closing c = closing_of(v, k);
        const int *name = v->numbers + v->swept[k].column;
        for (int l = 0; l < c.size; ++l) {
            const double *W = c.W + l * MBSRI_SWEPT_MOTIONS;
            double of_motion = 0.0;
            if (i > 0) {
                v4 sum = load3(W) * x[0] + load3(W + 4) * x[1] + load3(W + 8) * x[2] +
                         load3(W + 12) * x[3];
                of_motion = sum3(sum);
            }
            v->value[name[c.column[l]]] = (c.right[l] - of_motion) * c.by_column[l];
        }
    }
}

/* Those that close on the root. */
MBSRI_INLINE void turn_root(mbsri_newton_sweeps *newton)
{
    v4 none[4] = {splat(0.0), splat(0.0), splat(0.0), splat(0.0)};
    close_loads(newton, 0, none, none);
    close_motion(newton, 0, none);
}

#endif
