/* A stiff tree's Newton systems of the momentum form in sparse augmented form, with analytic
 * entries.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The unknowns of body i are xi, nu, chi, phi and delta u_i of docs/newton.md, and its rows the
 * equations given there, so that a row has entries for a body and its predecessor only, and for
 * what elements across the tree tie to it:
 *
 *   xi  - xi_pi - sum of S theta = 0
 *       nu - nu_pi - sum of (S delta u + (V x S) theta) = 0
 *   chi - M nu - sum over successors of (chi + (S theta) x* h) = 0,  phi likewise
 *   S^T (c chi - phi) - S'^T chi - ... = r_p + c w            in the range of D
 *   N^T (linearised inverse dynamics) = r_u
 *       for each null vector N of the mass matrix
 *
 * theta: displacements along the joint's axes, by delta u and r_q; w = L (range part of r_u). */
#ifndef RUNS_AUGMENTED_H
#define RUNS_AUGMENTED_H

#include "linear.h"

/* The unknowns of a body, in this order. */
enum { AUGMENTED_XI, AUGMENTED_NU, AUGMENTED_CHI, AUGMENTED_PHI, AUGMENTED_RATES };

/* An entry; or a share of theta (column: of which rate) in a row, which went to the columns of
 * delta u and goes to the right side. */
typedef struct augmented_entry {
    int row, column;
    double value;
} augmented_entry;

typedef struct augmented_list {
    augmented_entry *at;
    long count, room;
} augmented_list;

typedef struct augmented {
    const mbsr_model *model;
    mbsr_data *data;
    linear_model linear;
    int dim, part[6]; /* 6 and all, or 3 and those of the plane */
    int size, *first; /* unknowns; the first of each body */
    double c;
    augmented_list
        entries; /* in the order in which they arise; some may be zero, several at one place */
    augmented_list shares;
    struct augmented_null *null; /* of one null vector: bodies */
    double *theta, *w, *passed;
    double *y; /* where it was linearised */
    const double *u;
} augmented;

void augmented_open(augmented *s, const stiff_model *stiff, const mbsr_model *model,
                    mbsr_data *data);
void augmented_close(augmented *s);

/* Writes the entries for this state; a status. */
int augmented_at(augmented *s, double t, const double *y, double c);

/* The right side (size) for a residual r; and, from the solution x, delta of the library's y. */
void augmented_right(augmented *s, const double *r, double *right);
void augmented_delta(augmented *s, const double *r, const double *x, double *delta);

/* Where the unknowns of this kind of body i begin. */
static inline int augmented_place(const augmented *s, int i, int kind)
{
    return s->first[i] + kind * s->dim;
}

#endif
