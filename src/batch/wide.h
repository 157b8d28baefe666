/* Several states side by side: scalars, vectors in space and matrices of which every number is a
 * vector over MBSRI_LANES states.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The vector types of GCC and Clang; the file that includes this says how many states it takes at
 * once, by what its processor's registers hold. */
#ifndef MBSRI_WIDE_H
#define MBSRI_WIDE_H

#include "base/inlined.h"

typedef double lanes __attribute__((vector_size(8 * MBSRI_LANES), may_alias));
typedef long long lane_bits __attribute__((vector_size(8 * MBSRI_LANES), may_alias));

typedef struct vec {
    lanes x, y, z;
} vec;

typedef struct mat { /* columns */
    vec x, y, z;
} mat;

typedef struct sym {
    lanes xx, yy, zz, xy, xz, yz;
} sym;

MBSRI_INLINE lanes splat(double x)
{
    return x - (lanes){0.0};
}

MBSRI_INLINE vec vec_of(const double x[3])
{
    return (vec){splat(x[0]), splat(x[1]), splat(x[2])};
}

MBSRI_INLINE vec add(vec a, vec b)
{
    return (vec){a.x + b.x, a.y + b.y, a.z + b.z};
}

MBSRI_INLINE vec scaled(vec a, lanes s)
{
    return (vec){a.x * s, a.y * s, a.z * s};
}

/* a + s b */
MBSRI_INLINE vec plus(vec a, lanes s, vec b)
{
    return (vec){a.x + s * b.x, a.y + s * b.y, a.z + s * b.z};
}

MBSRI_INLINE lanes dot(vec a, vec b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

MBSRI_INLINE vec cross(vec a, vec b)
{
    return (vec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/* C x with x in the lanes, C^T x, and C x with x the same in all states */
MBSRI_INLINE vec times(const mat *C, vec x)
{
    return plus(plus(scaled(C->x, x.x), x.y, C->y), x.z, C->z);
}

MBSRI_INLINE vec transposed_times(const mat *C, vec x)
{
    return (vec){dot(C->x, x), dot(C->y, x), dot(C->z, x)};
}

MBSRI_INLINE vec turned(const mat *C, const double x[3])
{
    return times(C, vec_of(x));
}

MBSRI_INLINE vec sym_times(const sym *S, vec x)
{
    return (vec){S->xx * x.x + S->xy * x.y + S->xz * x.z, S->xy * x.x + S->yy * x.y + S->yz * x.z,
                 S->xz * x.x + S->yz * x.y + S->zz * x.z};
}

/* a sine and cosine, and their products, of a turn by an angle */
typedef struct turn {
    lanes c, s, cc, ss, sc;
} turn;

MBSRI_INLINE turn turn_of(lanes c, lanes s)
{
    return (turn){c, s, c * c, s * s, s * c};
}

/* from five constants */
MBSRI_INLINE turn fixed_turn(const double x[5])
{
    return (turn){splat(x[0]), splat(x[1]), splat(x[2]), splat(x[3]), splat(x[4])};
}

/* R a and R^T a, where R turns about z or about x */
MBSRI_INLINE vec about_z(const turn *t, vec a)
{
    return (vec){t->c * a.x - t->s * a.y, t->s * a.x + t->c * a.y, a.z};
}

MBSRI_INLINE vec back_about_z(const turn *t, vec a)
{
    return (vec){t->c * a.x + t->s * a.y, t->c * a.y - t->s * a.x, a.z};
}

MBSRI_INLINE vec about_x(const turn *t, vec a)
{
    return (vec){a.x, t->c * a.y - t->s * a.z, t->s * a.y + t->c * a.z};
}

MBSRI_INLINE vec back_about_x(const turn *t, vec a)
{
    return (vec){a.x, t->c * a.y + t->s * a.z, t->c * a.z - t->s * a.y};
}

/* S -= a b^T, which is symmetric */
MBSRI_INLINE void subtract_product(sym *S, vec a, vec b)
{
    S->xx -= a.x * b.x, S->yy -= a.y * b.y, S->zz -= a.z * b.z;
    S->xy -= a.x * b.y, S->xz -= a.x * b.z, S->yz -= a.y * b.z;
}

MBSRI_INLINE void add_to(sym *S, const sym *T)
{
    S->xx += T->xx, S->yy += T->yy, S->zz += T->zz;
    S->xy += T->xy, S->xz += T->xz, S->yz += T->yz;
}

#endif
