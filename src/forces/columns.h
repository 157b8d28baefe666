/* Where the derivatives of an element stand in its matrix.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_COLUMNS_H
#define MBSRI_COLUMNS_H

#include <mbsrank/force.h>

/* Numbers of a perturbation of a body's pose. */
static inline int mbsri_pose_numbers(mbsr_space space, int np)
{
    return space == MBSR_SPACE_SPATIAL || space == MBSR_SPACE_FLEXIBLE ? np - 6 : np;
}

/* Columns of V, q and u of a body among the derivatives of an element, and the row of its tau,
 * where its first ones are `column` and `row`. */
static inline int mbsri_V_column(const mbsr_force_body *body, int column)
{
    return column + mbsri_pose_numbers(body->space, body->np);
}

static inline int mbsri_q_column(const mbsr_force_body *body, int column)
{
    return mbsri_V_column(body, column) + body->d;
}

static inline int mbsri_u_column(const mbsr_force_body *body, int column)
{
    return mbsri_q_column(body, column) + body->nq;
}

static inline int mbsri_tau_row(const mbsr_force_body *body, int row)
{
    return row + body->d;
}

#endif
