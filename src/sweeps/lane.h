/* Four doubles side by side: three components of a vector in space and a fourth that is idle.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The vector types of GCC and Clang, without instructions of any machine: what a file is compiled
 * for decides what they become. */
#ifndef MBSRI_LANE_H
#define MBSRI_LANE_H

#include "base/inlined.h"

/* Compiled once: rarely called, or long. */
#define MBSRI_OUTLINE static __attribute__((noinline))

typedef double v4 __attribute__((vector_size(32), may_alias));
typedef long long i4 __attribute__((vector_size(32), may_alias));
typedef v4 lanes; /* what sine.h works on */
typedef i4 lane_bits;

MBSRI_INLINE v4 splat(double x)
{
    return (v4){x, x, x, x};
}

MBSRI_INLINE v4 load(const double *x)
{
    return *(const v4 *)x;
}

MBSRI_INLINE void store(double *x, v4 a)
{
    *(v4 *)x = a;
}

/* Three numbers anywhere, of which the fourth next to them is read and written too. */
typedef double near4 __attribute__((vector_size(32), aligned(8), may_alias));

MBSRI_INLINE v4 load3(const double *x)
{
    return *(const near4 *)x;
}

MBSRI_INLINE void store3(double *x, v4 a)
{
    *(near4 *)x = a;
}

MBSRI_INLINE v4 xxx(v4 a)
{
    return (v4){a[0], a[0], a[0], a[0]};
}

MBSRI_INLINE v4 yyy(v4 a)
{
    return (v4){a[1], a[1], a[1], a[1]};
}

MBSRI_INLINE v4 zzz(v4 a)
{
    return (v4){a[2], a[2], a[2], a[2]};
}

#if defined(__has_builtin)
#if __has_builtin(__builtin_shufflevector)
#define MBSRI_SHUFFLE_TWO(a, b, i, j) __builtin_shufflevector(a, b, i, j)
#define MBSRI_SHUFFLE_FOUR(a, b, i, j, k, l) __builtin_shufflevector(a, b, i, j, k, l)
#endif
#endif
#ifndef MBSRI_SHUFFLE_FOUR
#define MBSRI_SHUFFLE_TWO(a, b, i, j) __builtin_shuffle(a, b, (i2){i, j})
#define MBSRI_SHUFFLE_FOUR(a, b, i, j, k, l) __builtin_shuffle(a, b, (i4){i, j, k, l})
#endif

/* Numbers i, j, k, l of the eight of a and b. Where a vector is two registers, each is shuffled by
 * itself, as GCC 12 takes both through memory. */
#if defined(__AVX__)
#define MBSRI_SHUFFLE(a, b, i, j, k, l) MBSRI_SHUFFLE_FOUR(a, b, i, j, k, l)
#else
typedef double v2 __attribute__((vector_size(16), may_alias));
typedef long long i2 __attribute__((vector_size(16), may_alias));

MBSRI_INLINE v2 half_of(v4 a, v4 b, int i)
{
    const v4 of = i < 4 ? a : b;
    return i & 2 ? (v2){of[2], of[3]} : (v2){of[0], of[1]};
}

MBSRI_INLINE v4 joined(v2 low, v2 high)
{
    return (v4){low[0], low[1], high[0], high[1]};
}

#define MBSRI_PAIR(a, b, i, j)                                                                     \
    MBSRI_SHUFFLE_TWO(half_of(a, b, i), half_of(a, b, j), (i)&1, 2 + ((j)&1))
#define MBSRI_SHUFFLE(a, b, i, j, k, l) joined(MBSRI_PAIR(a, b, i, j), MBSRI_PAIR(a, b, k, l))
#endif

/* (y, z, x) and (z, x, y) */
MBSRI_INLINE v4 yzx(v4 a)
{
    return MBSRI_SHUFFLE(a, a, 1, 2, 0, 3);
}

MBSRI_INLINE v4 zxy(v4 a)
{
    return MBSRI_SHUFFLE(a, a, 2, 0, 1, 3);
}

MBSRI_INLINE v4 cross(v4 a, v4 b)
{
    return yzx(a * yzx(b) - yzx(a) * b);
}

/* Sum of the three components. */
MBSRI_INLINE double sum3(v4 a)
{
    return a[0] + a[1] + a[2];
}

/* C x, with C by columns */
MBSRI_INLINE v4 times(const v4 C[3], v4 x)
{
    return C[0] * xxx(x) + C[1] * yyy(x) + C[2] * zzz(x);
}

/* The same with x in memory, which loads its components where they are needed. */
MBSRI_INLINE v4 times_stored(const v4 C[3], const double x[4])
{
    return C[0] * splat(x[0]) + C[1] * splat(x[1]) + C[2] * splat(x[2]);
}

/* T = A^T */
MBSRI_INLINE void transpose(const v4 A[3], v4 T[3])
{
    const v4 none = splat(0.0);
    const v4 low = MBSRI_SHUFFLE(A[0], A[1], 0, 4, 2, 6),
             high = MBSRI_SHUFFLE(A[0], A[1], 1, 5, 3, 7),
             last_low = MBSRI_SHUFFLE(A[2], none, 0, 4, 2, 6),
             last_high = MBSRI_SHUFFLE(A[2], none, 1, 5, 3, 7);
    T[0] = MBSRI_SHUFFLE(low, last_low, 0, 1, 4, 5);
    T[1] = MBSRI_SHUFFLE(high, last_high, 0, 1, 4, 5);
    T[2] = MBSRI_SHUFFLE(low, last_low, 2, 3, 6, 7);
}

/* C^T x: rows of products, summed across */
MBSRI_INLINE v4 transposed_times(const v4 C[3], v4 x)
{
    const v4 product[3] = {C[0] * x, C[1] * x, C[2] * x};
    v4 row[3];
    transpose(product, row);
    return row[0] + row[1] + row[2];
}

/* Matrices by their diagonals, each with what it goes on with at the other side of the matrix: (xx,
 * yy, zz), (xy, yz, zx), (xz, yx, zy). Products, transposed ones too, then are component by
 * component with x turned round. Of symmetric matrices A[0] = (xx, yy, zz), A[1] = (yz, zx, xy). */
MBSRI_INLINE v4 symmetric_times(const v4 A[2], v4 x)
{
    return A[0] * x + zxy(A[1]) * yzx(x) + yzx(A[1]) * zxy(x);
}

MBSRI_INLINE void by_diagonals(const v4 C[3], v4 A[3])
{
    for (int k = 0; k < 3; ++k) {
        const v4 two = MBSRI_SHUFFLE(C[k], C[(k + 1) % 3], 0, 5, 2, 3);
        A[k] = MBSRI_SHUFFLE(two, C[(k + 2) % 3], 0, 1, 6, 3);
    }
}

MBSRI_INLINE v4 cyclic_times(const v4 A[3], v4 x)
{
    return A[0] * x + A[1] * yzx(x) + A[2] * zxy(x);
}

/* A^T x */
MBSRI_INLINE v4 cyclic_transposed_times(const v4 A[3], v4 x)
{
    return A[0] * x + zxy(A[1] * x) + yzx(A[2] * x);
}

#endif
