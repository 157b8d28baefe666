/* The Newton matrix of a DAE form as a dense matrix of differences, and errors of a solution.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_NEWTON_SYSTEM_H
#define TEST_NEWTON_SYSTEM_H

#include <mbsrank/mbsrank.h>

/* A model with data and a state to linearise at. */
typedef struct test_newton_state {
    const mbsr_model *model;
    mbsr_data *data;
    mbsr_dae_form form;
    double t;
    int nq, nu, n; /* n: length of y */
    double *y, *yp;
    double *A, *B, *D; /* n x n, of test_newton_matrices */
    double roughness;  /* likewise: largest entry of D, relative to its row */
} test_newton_state;

/* A consistent state of the momentum form near q, u. Returns what mbsr_dae_consistent returns; info
 * may be NULL. To be freed in any case. */
int test_newton_start(test_newton_state *s, const mbsr_model *model, mbsr_data *data, double t,
                      const double *q, const double *u, mbsr_consistent_info *info);
void test_newton_free(test_newton_state *s);

/* A = dF/dy and B = dF/dy' (column-major) by differences of eighth order, and how far differences
 * over two lengths disagree about A, as entries of D: the residual may have rounding errors (large
 * velocities, rates by differences), high derivatives, and jumps. Of the residual of `model`, which
 * is that of s or one of the same equations. A status of the residual.
 *
 * A residual that takes rates of joints or inertias by differences has 1e4 times the rounding
 * errors of another, and D, a difference of two samples of them, may be small by chance. So where
 * there is a model of the same equations that has rates by formulas, it is the one to give. */
int test_newton_matrices(test_newton_state *s, const mbsr_model *model, mbsr_data *data);

/* How well x solves (A + c B) x = r. */
typedef struct test_newton_errors {
    /* Largest defect of a row, relative to the sum of what is added up in it; net of what D
     * accounts for. */
    double row, net_row;
    /* Largest error of an entry against LAPACK's solution, relative to the largest entry of its
     * kind (q, p, u, Lambda or Eta); net of what D accounts for. */
    double delta, net_delta;
    double amplification; /* of small relative changes of the matrix's entries in delta */
} test_newton_errors;

test_newton_errors test_newton_compare(const test_newton_state *s, double c, const double *r,
                                       const double *x);

/* Largest difference of p from (A + c B) x, net of what D accounts for, or, where r is given, from
 * r, relative to what is added up in the row of (A + c B) x. */
double test_newton_product_error(const test_newton_state *s, double c, const double *x,
                                 const double *p, const double *r);

/* Largest difference of two solutions, relative to the largest entry of its kind. */
double test_newton_distance(const test_newton_state *s, const double *x, const double *y);

#endif
