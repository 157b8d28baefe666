/* The matrix of loops that close, in the Newton sweeps: see closing.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_NEWTON_CLOSING_MATRIX_H
#define MBSRI_NEWTON_CLOSING_MATRIX_H

#include "newton/sweeps/ends.h"

#include <stdint.h>

/* What is kept, in the order of the exchanges: LU (span x size, by columns) of the scaled T, Q
 * (groups of three numbers, a column after the other), T^-1 s, W (likewise, by rows), all of them
 * scaled; the scales; which row it was, and the names of the unknowns. Of `rest` unknowns that are
 * carried on, see closing_part.h, what stands beside and below LU. */
typedef struct closing {
    double *LU, *by_row, *Q, *right, *by_column, *W;
    int *row, *name, size, rest, span, actions;
} closing;

/* Numbers of a row of W, and of a column of Q where psi takes no part. */
enum { CLOSED_MOTIONS = 12, CLOSED_ACTIONS = 12 };

/* below_massless: of a body with psi. */
MBSRI_INLINE bool is_below_massless(const mbsri_newton_sweeps *newton, int i)
{
    return newton->last.below_massless && newton->step[i].below_massless & MBSRI_BELOW_MASSLESS;
}

MBSRI_INLINE closing closing_of(const mbsri_carried *v, int k, int size, bool below_massless)
{
    const mbsri_pool *pool = v->lane_pool + k;
    const int span = mbsri_lane_span(size),
              actions = below_massless ? CLOSED_ACTIONS + 6 : CLOSED_ACTIONS;
    double *LU = v->store + pool->record, *by_row = LU + span * size, *right = by_row + span,
           *by_column = right + span, *Q = by_column + span, *W = Q + actions * size;
    int *row = v->numbers + pool->place + pool->most;
    return (closing){.LU = LU,
                     .by_row = by_row,
                     .Q = Q,
                     .right = right,
                     .by_column = by_column,
                     .W = W,
                     .row = row,
                     .name = row + size,
                     .size = size,
                     .span = span,
                     .actions = actions};
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

/* One scale, of a row or column whose largest entry is this without it: nearer to what makes that
 * 1, by the root, so that neither side gets all of it, or exactly. True: it was within a factor 2.
 */
MBSRI_INLINE bool adjust(int *scale, int largest, bool exactly)
{
    if (largest <= NO_EXPONENT / 2) return true;
    const int all = largest + *scale;
    *scale -= exactly ? all : all / 2;
    return all >= -1 && all <= 1;
}

/* Exponents of scales with which the largest entry of each row and column is about 1. E: those of
 * the entries, `span` a column. */
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

MBSRI_INLINE int larger(int a, int b)
{
    return a > b ? a : b;
}

/* The same of two by two, at once: the larger of both products of two entries becomes that of two
 * ones, and the other two entries equal. Zeros count as if they were no smaller than 2^-200 of the
 * largest entry. */
MBSRI_INLINE void equilibrate_two(int span, const int *E, int *of_row, int *of_column)
{
    const int least = larger(larger(E[0], E[1]), larger(E[span], E[span + 1])) - 200,
              a = larger(E[0], least), b = larger(E[1], least), c = larger(E[span], least),
              d = larger(E[span + 1], least);
    const bool crossed = b + c > a + d;
    const int sum = crossed ? b + c : a + d, columns = (a + b - c - d) / 2,
              first = (-sum / 2 - columns) / 2;
    of_column[0] = first;
    of_column[1] = first + columns;
    of_row[0] = crossed ? -c - of_column[1] : -a - of_column[0];
    of_row[1] = crossed ? -b - of_column[0] : -d - of_column[1];
}

/* ---- T ---- */

/* LU of the scaled T with complete pivoting; false: some pivot is not larger than `least`. place:
 * which columns these are. */
MBSRI_INLINE bool factor_T(const closing *c, int *place, double least)
{
    const int size = c->size, span = c->span;
    for (int k = 0; k < size; ++k) c->row[k] = place[k] = k;
    for (int k = 0; k < size; ++k) {
        double largest = least;
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
        const int i = c->row[row], j = place[column];
        c->row[row] = c->row[k], c->row[k] = i;
        place[column] = place[k], place[k] = j;
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
    const int size = c->size, span = c->span, of = MBSRI_LANE_MOTIONS;
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

/* Scaled T to LU; false: not finite. at: places of its unknowns in the pool, NULL: as they are. E:
 * scratch, span (size + 2). */
MBSRI_INLINE bool scale_T(const closing *c, const open_pool *pool, const int *at, int *E)
{
    const int size = c->size, span = c->span;
    int *of_row = E + size * span, *of_column = of_row + span;
    double worst = 0.0;
    for (int j = 0; j < size; ++j) {
        for (int i = 0; i < size; ++i) {
            const double x = pool->T[(at ? at[j] : j) * pool->most + (at ? at[i] : i)];
            c->LU[j * span + i] = x;
            E[j * span + i] = exponent_of(x);
            worst += x - x;
        }
    }
    if (!(worst == 0.0)) return false;
    if (size == 2)
        equilibrate_two(span, E, of_row, of_column);
    else
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

/* W and Q; false: not finite. place: the columns; W is made in `work`, with idle numbers. */
MBSRI_INLINE bool place_W(const closing *c, const open_pool *pool, const int *place, double *work)
{
    v4 worst = splat(0.0);
    for (int k = 0; k < c->size; ++k) {
        const double *R = pool->R + c->row[k] * MBSRI_LANE_MOTIONS,
                     *Q = pool->Q + place[k] * MBSRI_LANE_ACTIONS;
        double *row = work + k * MBSRI_LANE_MOTIONS, *to = c->Q + k * c->actions;
        const v4 by_row = splat(c->by_row[k]), by_column = splat(c->by_column[k]);
        for (int g = 0; g < 4; ++g) store3(row + 4 * g, load3(R + 4 * g) * by_row);
        for (int g = 0; g < c->actions / 3; ++g) {
            const v4 x = load3(Q + 4 * g) * by_column;
            store3(to + 3 * g, x);
            worst += x - x;
        }
    }
    solve_rows(c, work);
    for (int k = 0; k < c->size; ++k) {
        for (int g = 0; g < 4; ++g) {
            const v4 x = load3(work + k * MBSRI_LANE_MOTIONS + 4 * g);
            store3(c->W + k * CLOSED_MOTIONS + 3 * g, x);
            worst += x - x;
        }
    }
    return sum3(worst) == 0.0;
}

/* P -= Q W, Y likewise. */
MBSRI_INLINE void subtract_closed(const closing *c, slab *y, bool below_massless)
{
    for (int g = 0; g < 4; ++g) {
        for (int j = 0; j < 3; ++j) {
            v4 *P = y->P[g][j], *Y = y->Y[g][j];
            v4 sum[4] = {P[0], P[1], P[2], P[3]};
            for (int k = 0; k < c->size; ++k) {
                const double *Q = c->Q + k * c->actions;
                const v4 x = splat(c->W[k * CLOSED_MOTIONS + 3 * g + j]);
                for (int r = 0; r < 4; ++r) sum[r] -= load3(Q + 3 * r) * x;
                for (int r = 0; r < 2 && below_massless; ++r) Y[r] -= load3(Q + 12 + 3 * r) * x;
            }
            for (int r = 0; r < 4; ++r) P[r] = sum[r];
        }
    }
}

/* By its numbers in turn. */
MBSRI_INLINE void exchange(int size, const int *order, double *x, double *scratch)
{
    for (int k = 0; k < size; ++k) scratch[k] = x[order[k]];
    for (int k = 0; k < size; ++k) x[k] = scratch[k];
}

#endif
