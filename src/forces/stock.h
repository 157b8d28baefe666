/* What the stock force elements share.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_STOCK_H
#define MBSRI_STOCK_H

#include "base/error.h"

#include <mbsrank/force.h>

#include <math.h>

/* A definition with its cookie, table and up to two bodies set. */
mbsr_force_def mbsri_stock_force(const mbsr_force_table *table, int bodies, int a, int b);

/* Writes a refusal into text and returns status. */
int mbsri_refuse(char text[MBSR_TEXT_SIZE], int status, const char *format, ...) MBSRI_FORMAT(3, 4);

/* The same for the value of parameter k, which is `wrong`, such as "negative". */
int mbsri_refuse_parameter(char text[MBSR_TEXT_SIZE], const mbsr_force_args *args, int k,
                           const char *wrong);

/* Refuses negative numbers among `count` parameters from `first` on. */
int mbsri_check_not_negative(const mbsr_force_args *args, int first, int count,
                             char text[MBSR_TEXT_SIZE]);

/* Refuses a friction below 0, and a slip velocity (its regularisation) that is not above. */
int mbsri_check_friction(const mbsr_force_args *args, int force, int slip,
                         char text[MBSR_TEXT_SIZE]);

/* For check_fields: refuses another number of bodies, and options other than 0 from the first
 * unused one on. An element whose data were given as NULL (mbsri_given_null) is refused as such. */
int mbsri_check_shape(const mbsr_force_def *def, int bodies, int first_unused,
                      char text[MBSR_TEXT_SIZE]);

/* Marks an element as made from a pointer that must not be NULL. */
mbsr_force_def mbsri_given_null(mbsr_force_def def);

/* Refuses an element with both ends on one body. */
int mbsri_check_ends(const mbsr_force_args *args, char text[MBSR_TEXT_SIZE]);

/* Entry k of a table of parameter names, "" beyond its end. */
#define MBSRI_PARAMETER(names, k) ((k) < (int)(sizeof(names) / sizeof *(names)) ? (names)[k] : "")

/* Entry k of a body's pose or velocity; a root at rest counts as zero. */
static inline double mbsri_entry(const mbsr_force_body *body, const double *x, int k)
{
    return body->space == MBSR_SPACE_FIXED ? 0.0 : x[k];
}

/* Force of a one-sided spring-damper, elastic >= 0: the damping part is at most as large as the
 * elastic one, so that the sum is never negative and tends to zero where contact ends or begins. */
static inline double mbsri_one_sided(double elastic, double damping)
{
    return elastic + fmax(-elastic, fmin(damping, elastic));
}

/* Its derivatives with respect to both, elastic > 0: those of the branch taken. */
static inline void mbsri_one_sided_slopes(double elastic, double damping, double *by_elastic,
                                          double *by_damping)
{
    *by_elastic = damping >= elastic ? 2.0 : damping <= -elastic ? 0.0 : 1.0;
    *by_damping = fabs(damping) < elastic ? 1.0 : 0.0;
}

/* Its branch: 0 without contact. */
static inline double mbsri_one_sided_branch(double elastic, double damping)
{
    if (!(elastic > 0.0)) return 0.0;
    return damping >= elastic ? 2.0 : damping <= -elastic ? 3.0 : 1.0;
}

static inline void mbsri_add_slope(const mbsr_force_derivatives *out, int row, int column,
                                   double value)
{
    out->matrix[(ptrdiff_t)column * out->rows + row] += value;
}

/* Derivatives of a force that depends on time alone: none. */
int mbsri_no_slopes(const mbsr_force_args *args, const mbsr_force_derivatives *out);

#endif
