/* A stiff tree (stiff.h) linearised at a state, body by body: what a matrix of its equations in
 * sparse form consists of. Written for itself, without the library's recursions.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Twists (omega, v) and wrenches (moment, force) are about the world's origin, along its axes.
 * Notation and equations: docs/newton.md, "Rigid bodies in space, regular masses" and "Massless
 * directions". */
#ifndef RUNS_LINEAR_H
#define RUNS_LINEAR_H

#include "stiff.h"

#include <mbsrank/mbsrank.h>

enum { LINEAR_RATES = 6 };

/* One rate of a joint: V_i = V_pi + sum of S u. */
typedef struct linear_axis {
    double S[6], rate[6]; /* S and its rate */
    double twist[6]; /* change of V_i, seen in the moving body, with the displacement along S */
    unsigned
        after; /* axes (bits) whose displacements do not move this one, itself included if so */
    double stiffness, damping;
} linear_axis;

typedef struct linear_body {
    int parent, q, u, axes, free; /* as in stiff_body; q, u: places in the library's coordinates */
    double R[9], x[3], V[6], A[6];
    double M[36]; /* rows; about the world's origin */
    double h[6], F[6],
        B[6]; /* sums from here to the leaves: momentum, external wrench, M A + V x* M V - F */
    int loaded;
    double by_xi[36], by_nu[36]; /* rows: change of the body's own wrench, if it is loaded, with its
                                    displacement and with that of V */
    linear_axis axis[LINEAR_RATES];
    double
        theta[36]; /* rows: displacements along the axes = theta delta u + what the residual adds */
    int rank;
    double range[36], null[36]; /* columns: rank of them to test the range of D with, axes - rank
                                   that span its null space */
    double kept[36];            /* rows: D D^+ */
    double gain[36];            /* columns U D^+ */
} linear_body;

/* A force between two bodies: changes of both wrenches (rows 0..5 of a, 6..11 of b) with xi_a,
 * nu_a, xi_b, nu_b. */
typedef struct linear_tie {
    int a, b;
    double by[12 * 24];
} linear_tie;

typedef struct linear_model {
    const stiff_model *stiff;
    linear_body *body;
    linear_tie *tie;
    double *udot;
} linear_model;

void linear_open(linear_model *m, const stiff_model *stiff, const mbsr_model *model);
void linear_close(linear_model *m);

/* At time t, state y of the momentum form and c = dy'/dy. */
int linear_at(linear_model *m, const mbsr_model *model, mbsr_data *data, double t, const double *y,
              double c);

/* The two products of motions, and of a motion with a force. */
void linear_cross(const double X[6], const double Y[6], double Z[6]);
void linear_cross_force(const double X[6], const double f[6], double g[6]);
double linear_dot(const double X[6], const double f[6]);

#endif
