/* A joint coordinate in the Newton sweeps: its axis, its row, its column.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_NEWTON_AXIS_H
#define MBSRI_NEWTON_AXIS_H

#include "newton/sweeps/perturbation.h"

/* An axis at the body's point, and what goes with it. */
typedef struct axis {
    v4 S_w, S_v;       /* S */
    v4 rate_w, rate_v; /* S' */
    v4 row_w, row_v;   /* S - S' / c: the row of the joint over chi */
    v4 J[4];           /* what dq adds to the forces */
    v4 rotated;        /* S_w x N + S_v x F */
} axis;

MBSRI_INLINE void finish_axis(const slab *y, double by_c, axis *a)
{
    const v4 s = splat(by_c);
    a->row_w = a->S_w - s * a->rate_w;
    a->row_v = a->S_v - s * a->rate_v;
    a->J[CHI_L] = cross(a->S_w, y->L) + cross(a->S_v, y->p);
    a->J[CHI_P] = cross(a->S_w, y->p);
    a->J[MOMENT] = cross(a->S_v, y->F);
    a->J[FORCE] = splat(0.0);
    a->rotated = cross(a->S_w, y->N) + a->J[MOMENT];
}

/* out = P (rotation, nu_w, nu_v, displacement) */
MBSRI_INLINE void apply_slab(const slab *y, const v4 x[4], v4 out[4], bool full)
{
    for (int r = 0; r < groups(full); ++r) out[r] = splat(0.0);
    for (int g = 0; g < groups(full); ++g) {
        const v4 one = xxx(x[g]), two = yyy(x[g]), three = zzz(x[g]);
        for (int r = 0; r < groups(full); ++r)
            out[r] += y->P[g][0][r] * one + y->P[g][1][r] * two + y->P[g][2][r] * three;
    }
}

/* The products, not summed, of the row of a joint with a column of forces. */
MBSRI_INLINE v4 along_row(const axis *a, v4 by_c, const v4 column[4], bool full)
{
    v4 sum = a->row_w * column[CHI_L] + a->row_v * column[CHI_P] - by_c * a->S_w * column[MOMENT];
    if (full) sum -= by_c * a->S_v * column[FORCE];
    return sum;
}

MBSRI_INLINE v4 magnitude(v4 x)
{
    return (v4)((i4)x & (i4){0x7fffffffffffffff, 0x7fffffffffffffff, 0x7fffffffffffffff, 0});
}

/* The sum of the sizes of these products. */
MBSRI_INLINE double size_of_row(const axis *a, v4 by_c, const v4 column[4], bool full)
{
    v4 sum = magnitude(a->row_w * column[CHI_L]) + magnitude(a->row_v * column[CHI_P]) +
             magnitude(by_c * a->S_w * column[MOMENT]);
    if (full) sum += magnitude(by_c * a->S_v * column[FORCE]);
    return sum3(sum);
}

/* R, the row of the joint over x_h. */
MBSRI_INLINE void joint_row(const slab *y, const axis *a, v4 by_c, v4 R[4], bool full)
{
    for (int g = 0; g < groups(full); ++g)
        R[g] = sums(along_row(a, by_c, y->P[g][0], full), along_row(a, by_c, y->P[g][1], full),
                    along_row(a, by_c, y->P[g][2], full));
    R[ROTATION] -= by_c * a->rotated;
    R[SPIN] -= by_c * a->J[CHI_L];
    R[DRIFT] -= by_c * a->J[CHI_P];
}

/* S^T chi over x_h */
MBSRI_INLINE void momentum_row(const slab *y, v4 S_w, v4 S_v, v4 Q[4], bool full)
{
    for (int g = 0; g < groups(full); ++g) {
        v4 product[3];
        for (int j = 0; j < 3; ++j) product[j] = S_w * y->P[g][j][CHI_L] + S_v * y->P[g][j][CHI_P];
        Q[g] = sums(product[0], product[1], product[2]);
    }
}

/* P -= C K^T */
MBSRI_INLINE void subtract_column(slab *y, const v4 C[4], const v4 K[4], bool full)
{
    for (int g = 0; g < groups(full); ++g) {
        const v4 k[3] = {xxx(K[g]), yyy(K[g]), zzz(K[g])};
        for (int j = 0; j < 3; ++j) {
            for (int r = 0; r < groups(full); ++r) y->P[g][j][r] -= C[r] * k[j];
        }
    }
}

/* The record of a coordinate, its groups in their order. */
MBSRI_INLINE void keep_column(mbsri_newton_column *col, const axis *a, const v4 K[4], const v4 Q[4],
                              const v4 C[4], const v4 U[4], const v4 G[2], bool full)
{
    if (full) store3(col->K_last, K[3]), store3(col->Q_last, Q[3]);
    for (int g = 0; g < 3; ++g) store3(col->K + 3 * g, K[g]);
    for (int g = 0; g < 3; ++g) store3(col->Q + 3 * g, Q[g]);
    store3(col->S, a->S_w), store3(col->S + 3, a->S_v);
    store3(col->row, a->row_w), store3(col->row + 3, a->row_v);
    for (int g = 0; g < 3; ++g) store3(col->C + 3 * g, C[g]);
    for (int g = 0; g < 3; ++g) store3(col->U + 3 * g, U[g]);
    store3(col->G, G[0]), store3(col->G + 3, G[1]);
    if (full) store3(col->C_last, C[3]), store3(col->U_last, U[3]);
}

#endif
