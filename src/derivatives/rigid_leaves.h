/* Matrices of derivatives of forward dynamics: from the root to the leaves, and to the caller.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * x = L^-T Y of rigid_matrices.h, for columns side by side: with Lambda = L^-1, row by row,
 *
 *   x_k = Y_k + sum of Lambda_jk Y_j for columns j of joints before k,
 *
 * or where these are many by the accelerations A of bodies, x_k = Y_k - G_k^T A, A += S_k x_k. */
#ifndef MBSRI_DERIVATIVES_RIGID_LEAVES_H
#define MBSRI_DERIVATIVES_RIGID_LEAVES_H

#include "derivatives/rigid_pairs.h"
#include "derivatives/rigid_record.h"

#include <string.h>

/* Place of component k in vectors of four. */
MBSRI_INLINE int component(int k)
{
    return k < 3 ? k : k + 1;
}

/* ---- to the caller ---- */

/* Rows of four columns from columns of four rows, and back. */
MBSRI_INLINE void turn_four(v4 x[4])
{
    const v4 a = MBSRI_SHUFFLE(x[0], x[1], 0, 4, 2, 6), b = MBSRI_SHUFFLE(x[0], x[1], 1, 5, 3, 7),
             c = MBSRI_SHUFFLE(x[2], x[3], 0, 4, 2, 6), d = MBSRI_SHUFFLE(x[2], x[3], 1, 5, 3, 7);
    x[0] = MBSRI_SHUFFLE(a, c, 0, 1, 4, 5);
    x[1] = MBSRI_SHUFFLE(b, d, 0, 1, 4, 5);
    x[2] = MBSRI_SHUFFLE(a, c, 2, 3, 6, 7);
    x[3] = MBSRI_SHUFFLE(b, d, 2, 3, 6, 7);
}

/* Rows of u .. u + 3, columns of places c .. end - 1, to a matrix by u. Zero times them, added to
 * `check`. */
MBSRI_INLINE v4 hand_out(const mbsri_rigid *r, const double *const row[4], int u, int c, int end,
                         double *matrix, v4 check)
{
    const size_t nu = (size_t)r->model->nu;
    const int *of = r->order.u + c, count = end - c, rows = r->model->nu - u;
    double *to = matrix + u;
    const v4 none = splat(0.0);
    int at = 0;
    for (; at + 4 <= count && rows >= 4; at += 4) {
        v4 x[4];
        for (int l = 0; l < 4; ++l) x[l] = load(row[l] + at);
        turn_four(x);
        for (int l = 0; l < 4; ++l) {
            store3(to + (size_t)of[at + l] * nu, x[l]);
            check += none * x[l];
        }
    }
    for (; at < count; ++at) {
        for (int l = 0; l < 4 && l < rows; ++l) {
            to[(size_t)of[at] * nu + (size_t)l] = row[l][at];
            check += splat(0.0 * row[l][at]);
        }
    }
    return check;
}

/* 0 x, added up */
MBSRI_INLINE v4 nothing_of(size_t n, const double *x)
{
    v4 sum = splat(0.0);
    size_t k = 0;
    for (; k + 4 <= n; k += 4) sum += splat(0.0) * load3(x + k);
    for (; k < n; ++k) sum += splat(0.0 * x[k]);
    return sum;
}

/* Rows of one matrix that begins at `part`. */
static v4 rows_as_they_are(const mbsri_rigid *r, size_t part, double *matrix)
{
    const mbsri_rigid_order *o = &r->order;
    const int nu = r->model->nu;
    v4 check = splat(0.0);
    for (int u = 0; u < nu; u += 4) {
        const double *row[4];
        for (int l = 0; l < 4; ++l)
            row[l] = o->rows + ((size_t)o->place[u + l < nu ? u + l : u] * o->down + part);
        check = hand_out(r, row, u, 0, nu, matrix, check);
    }
    return check;
}

/* ---- by Lambda ---- */

/* A row of `rows`, `width` times four columns: its own Y and, of each row on the way to the root,
 * by lambda its part. */
MBSRI_INLINE void add_path(const double *rows, const double *lambda, const mbsri_rigid_way *way,
                           const int width, double *to)
{
    const size_t *path = way->path, *const end = path + way->count;
    const double *own = rows + way->row;
    v4 x[MBSRI_RIGID_WIDTH];
    for (int l = 0; l < width; ++l) x[l] = load(own + 4 * l);
    for (; path < end; ++path) {
        const v4 by = splat(lambda[*path]);
        const double *row = rows + *path;
        for (int l = 0; l < width; ++l) x[l] += by * load(row + 4 * l);
    }
    for (int l = 0; l < width; ++l) store(to + 4 * l, x[l]);
}

/* Rows of one matrix that begins at `part`, four at a time, columns of `width` times four places
 * from c on. */
MBSRI_INLINE v4 add_paths(const mbsri_rigid *r, size_t part, int c, const int width, double *matrix)
{
    const mbsri_rigid_order *o = &r->order;
    const int nu = r->model->nu, end = c + 4 * width < nu ? c + 4 * width : nu, *place = o->place;
    const double *rows = o->rows + (part + (size_t)c), *lambda = o->rows + 3 * o->part;
    const mbsri_rigid_way *way = o->way;
    _Alignas(32) double stage[4][4 * MBSRI_RIGID_WIDTH];
    const double *const row[4] = {stage[0], stage[1], stage[2], stage[3]};
    v4 check = splat(0.0);
    for (int u = 0; u < nu; u += 4) {
        for (int l = 0; l < 4 && u + l < nu; ++l) {
            const int k = place[u + l];
            add_path(rows, lambda + k, way + k, width, stage[l]);
        }
        check = hand_out(r, row, u, c, end, matrix, check);
    }
    return check;
}

static v4 rows_by_factor(const mbsri_rigid *r, size_t part, double *matrix)
{
    const int nu = r->model->nu, width = r->order.width;
    v4 check = splat(0.0);
    for (int c = 0; c < nu; c += 4 * width) {
        switch (width) {
        case 3: check += add_paths(r, part, c, 3, matrix); break;
        case 5: check += add_paths(r, part, c, 5, matrix); break;
        case 7: check += add_paths(r, part, c, 7, matrix); break;
        default: check += add_paths(r, part, c, MBSRI_RIGID_WIDTH, matrix);
        }
    }
    return check;
}

/* ---- by accelerations ---- */

/* Past the joint of body b, of eight columns: its rows from `y`, `down` numbers apart, to x; and
 * A. */
MBSRI_INLINE void pass_accelerations(const mbsri_rigid_body *b, const mbsri_rigid_column *c,
                                     const int n, const double *y, size_t down,
                                     double (*x)[MBSRI_RIGID_SIDE], v4 A[6][2])
{
    v4 rate[6][2];
    for (int k = 0; k < n; ++k) {
        v4 more[2] = {splat(0.0), splat(0.0)};
        for (int h = 0; h < 2; ++h) rate[k][h] = load(y + (size_t)k * down + 4 * h);
        for (int l = 0; l < 3; ++l) {
            for (int h = 0; h < 2; ++h) {
                rate[k][h] -= splat(c[k].P[l]) * A[l][h];
                more[h] += splat(c[k].P[4 + l]) * A[3 + l][h];
            }
        }
        for (int h = 0; h < 2; ++h) {
            rate[k][h] -= more[h];
            store(x[k] + 4 * h, rate[k][h]);
        }
    }
    for (int l = 0; l < 3; ++l) { /* A_v += A_w x r */
        const int p = (l + 1) % 3, q = (l + 2) % 3;
        for (int h = 0; h < 2; ++h) {
            A[3 + l][h] += splat(b->r[q]) * A[p][h];
            A[3 + l][h] -= splat(b->r[p]) * A[q][h];
        }
    }
    for (int k = 0; k < n; ++k) {
        for (int l = 0; l < 6; ++l) {
            for (int h = 0; h < 2; ++h) A[l][h] += splat(c[k].S[component(l)]) * rate[k][h];
        }
    }
}

/* Eight columns from place c on, of rows that may be r->side itself; rows of places up to `most`
 * and a few more, where places are u. */
MBSRI_INLINE v4 sweep_to_leaves(const mbsri_rigid *r, const double *rows, size_t down, int c,
                                int most, double *matrix, v4 check)
{
    const int bodies = r->tree->bodies, nu = r->model->nu, *place = r->order.place,
              end = c + MBSRI_RIGID_SIDE < nu ? c + MBSRI_RIGID_SIDE : nu;
    v4 A[6][2];
    for (int l = 0; l < 12; ++l) A[l / 2][l % 2] = splat(0.0);
    double(*x)[MBSRI_RIGID_SIDE] = r->side;
    int last = 0;
    for (int at = 1; at <= bodies; ++at) {
        const int i = r->along[at];
        const mbsri_rigid_body *b = r->body + i;
        const mbsri_rigid_column *column = r->column + b->first;
        if (b->place >= most) break;
        for (int l = 0; l < 12 && b->parent != last; ++l)
            A[l / 2][l % 2] = load(r->force[b->parent][l / 2] + l % 2 * 4);
        if (b->n == 1)
            pass_accelerations(b, column, 1, rows, down, x, A);
        else
            pass_accelerations(b, column, b->n, rows, down, x, A);
        rows += (size_t)b->n * down;
        x += b->n;
        for (int l = 0; l < 12 && b->flags & MBSRI_BRANCHES; ++l)
            store(r->force[i][l / 2] + l % 2 * 4, A[l / 2][l % 2]);
        last = i;
    }
    for (int u = 0; u < most; u += 4) {
        const double *row[4];
        for (int l = 0; l < 4; ++l) row[l] = r->side[place[u + l < nu ? u + l : u]];
        check = hand_out(r, row, u, c, end, matrix, check);
    }
    return check;
}

/* The rest of a symmetric matrix whose columns have their rows up to the last of eight columns. */
MBSRI_INLINE void mirror(int nu, double *matrix)
{
    const size_t down = (size_t)nu;
    for (int c = 0; c < nu; c += 4) {
        double *to = matrix + (size_t)c * down;
        int k = c / MBSRI_RIGID_SIDE * MBSRI_RIGID_SIDE + MBSRI_RIGID_SIDE;
        for (; k + 4 <= nu; k += 4) {
            v4 x[4];
            for (int l = 0; l < 4; ++l) x[l] = load3(matrix + (size_t)(k + l) * down + c);
            turn_four(x);
            for (int l = 0; l < 4; ++l) store3(to + (size_t)l * down + k, x[l]);
        }
        for (; k < nu; ++k) {
            for (int l = 0; l < 4; ++l)
                to[(size_t)l * down + (size_t)k] = matrix[(size_t)k * down + (size_t)(c + l)];
        }
    }
}

/* How many rows of columns from place c on are asked for: of the symmetric matrix half of them. */
MBSRI_INLINE int rows_of(const mbsri_rigid *r, int c, bool half)
{
    const int nu = r->model->nu;
    return half && c + MBSRI_RIGID_SIDE < nu ? c + MBSRI_RIGID_SIDE : nu;
}

/* Rows of one matrix that begins at `part`. */
static v4 rows_by_sweep(const mbsri_rigid *r, size_t part, bool half, double *matrix)
{
    const mbsri_rigid_order *o = &r->order;
    v4 check = splat(0.0);
    for (int c = 0; c < r->model->nu; c += MBSRI_RIGID_SIDE)
        check = sweep_to_leaves(r, o->rows + (part + (size_t)c), o->down, c, rows_of(r, c, half),
                                matrix, check);
    if (half) mirror(r->model->nu, matrix);
    return check;
}

/* Columns of places c .. c + 3 of a matrix by u to rows by places from `at` on. */
MBSRI_INLINE void take_columns(const mbsri_rigid *r, const double *matrix, int c, int at)
{
    const int nu = r->model->nu, *u = r->order.u;
    const double *column[4];
    for (int l = 0; l < 4; ++l) column[l] = matrix + (size_t)u[c + l < nu ? c + l : c] * (size_t)nu;
    int k = 0;
    for (; k + 4 <= nu; k += 4) {
        v4 x[4];
        for (int l = 0; l < 4; ++l) x[l] = load3(column[l] + k);
        turn_four(x);
        for (int l = 0; l < 4; ++l) store(r->side[r->order.place[k + l]] + at, x[l]);
    }
    for (; k < nu; ++k) {
        for (int l = 0; l < 4; ++l) r->side[r->order.place[k]][at + l] = column[l][k];
    }
}

/* A matrix by u in place. */
static v4 matrix_to_leaves(const mbsri_rigid *r, bool half, double *matrix)
{
    const int nu = r->model->nu;
    v4 check = splat(0.0);
    for (int c = 0; c < nu; c += MBSRI_RIGID_SIDE) {
        for (int at = 0; at < MBSRI_RIGID_SIDE && c + at < nu; at += 4)
            take_columns(r, matrix, c + at, at);
        check =
            sweep_to_leaves(r, r->side[0], MBSRI_RIGID_SIDE, c, rows_of(r, c, half), matrix, check);
    }
    if (half) mirror(nu, matrix);
    return check;
}

#endif
