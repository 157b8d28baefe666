/* Tables as functions of time, for motions and applied forces; kinks.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   mbsr_table_def def = mbsr_default_table_def();
 *   def.points = 4, def.x = t, def.value = height, def.kind = MBSR_TABLE_SPLINE;
 *   mbsr_table_create(&def, &road, &error);
 *   joint = mbsr_joint_compound(NULL, NULL, 1, &rise, mbsr_table_motion, road);
 *
 * A table is read-only once made and may be used by several threads and models; it must outlive
 * them. The driver (ida.h) knows where the tables of a model have their kinks. */
#ifndef MBSRANK_TABLE_H
#define MBSRANK_TABLE_H

#include <mbsrank/base.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A time at which something that the equations read jumps or bends. */
typedef struct mbsr_kink {
    double t;       /* s */
    int derivative; /* the lowest derivative of q and of momenta that jumps there: 1 where a force
                     * or the rate of a prescribed motion jumps, 2 where their slopes do, and so
                     * on */
} mbsr_kink;

typedef struct mbsr_table mbsr_table;

/* Between the points. With the slopes m_k at the points each piece is the cubic of its values and
 * slopes at both ends. */
typedef enum mbsr_table_kind {
    MBSR_TABLE_LINEAR = 0,   /* straight lines: the slope jumps at points */
    MBSR_TABLE_MONOTONE = 1, /* PCHIP (Fritsch and Butland 1984): nothing beyond the values at the
                              * points, no overshoot; the second derivative jumps there */
    MBSR_TABLE_SPLINE = 2    /* cubic spline, two continuous derivatives, not-a-knot: one cubic for
                              * the first two pieces and one for the last two (3 points: a
                              * parabola, 2: a line) */
} mbsr_table_kind;

/* Before the first point and behind the last one. */
typedef enum mbsr_table_beyond {
    MBSR_TABLE_CONSTANT = 0, /* the value at the end */
    MBSR_TABLE_STRAIGHT = 1, /* on with the slope at the end */
    MBSR_TABLE_REFUSE = 2    /* MBSR_ERR_VALUE */
} mbsr_table_beyond;

typedef struct mbsr_table_def {
    int cookie;               /* set by mbsr_default_table_def */
    int points;               /* 2 or more */
    const double *x;          /* points, each above the one before; s where it is a time. Copied */
    int columns;              /* functions in one table, default 1, at most 256 */
    const double *value;      /* points x columns: value[k * columns + c] at x[k]. Copied */
    mbsr_table_kind kind;     /* default LINEAR */
    mbsr_table_beyond beyond; /* default CONSTANT */
    mbsr_allocator allocator; /* default: malloc and free */
} mbsr_table_def;

MBSR_API mbsr_table_def mbsr_default_table_def(void);

/* On failure *table is NULL and the reason, with the index of what is wrong, in *error (which may
 * be NULL). MBSR_ERR_NULL, MBSR_ERR_NO_DEFAULT, MBSR_ERR_VALUE (points, columns, kind, beyond, an x
 * that is not above the one before or too close to it for a slope, numbers that are not finite or
 * overflow), MBSR_ERR_NO_MEMORY. */
MBSR_API int mbsr_table_create(const mbsr_table_def *def, mbsr_table **table, mbsr_error *error);
MBSR_API void mbsr_table_destroy(mbsr_table *table); /* NULL is allowed */

/* The table as it was defined: x and value point into *table and are valid as long as that.
 * MBSR_ERR_NULL. */
MBSR_API int mbsr_table_definition(const mbsr_table *table, mbsr_table_def *data);

/* Values, first and second derivatives at x, `columns` numbers each; outputs may be NULL. Where a
 * derivative jumps it is the one behind the point. MBSR_ERR_NULL, MBSR_NOT_FINITE (x, or a number
 * that overflows), MBSR_ERR_VALUE (beyond the ends of a table that refuses that); nothing is
 * written then. */
MBSR_API int mbsr_table_value(const mbsr_table *table, double x, double *value, double *first,
                              double *second);

/* The next point beyond x, strictly, in a direction (+1 or -1) at which a derivative jumps: *next,
 * and the lowest one that does in *derivative (1: the slope). Without one *next is direction *
 * INFINITY. Points in a straight line are left out. MBSR_ERR_NULL, MBSR_NOT_FINITE, MBSR_ERR_VALUE
 * (direction). */
MBSR_API int mbsr_table_kink(const mbsr_table *table, double x, int direction, double *next,
                             int *derivative);

/* A table as mbsr_motion_fn (joint.h), with the table as `user`: one column for each prescribed
 * coordinate, another number of which is refused when the body is added (in a closure: one for each
 * position row, and no more than MBSR_CLOSURE_ROWS). A linear table gives blows at its points,
 * where the velocity jumps. */
MBSR_API int mbsr_table_motion(void *table, double t, double *s, double *sdot, double *sddot);

/* A table as mbsr_force_fn (force.h), with the table as `user`: n columns, another number of which
 * is refused when the model is finished. */
MBSR_API int mbsr_table_force(void *table, double t, int n, double *value);

#ifdef __cplusplus
}
#endif

#endif
