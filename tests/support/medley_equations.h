/* The dense equations of motion of a mechanism (medley.h), solved by singular values:
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   forward    [M -C^T; C 0] (u'; lambda) = (g; -bias) with the rigid rows
 *   inverse    B tau + C^T lambda = need, of all tau that do this the shortest: tau = B^T x with C
 *       x = 0 */
#ifndef TEST_MEDLEY_EQUATIONS_H
#define TEST_MEDLEY_EQUATIONS_H

#include "medley.h"

typedef struct medley_equations {
    int n, m, N;       /* nu, rigid rows, both */
    double *M, *C;     /* n x n, m x n */
    double *g, *bias;  /* less inverse dynamics at u' = 0 */
    double *x;         /* u', lambda */
    bool *rigid;       /* rows of the model */
    double noise;      /* what rounding of gaps is as a force of stiff rows */
    bool clear, moves; /* each singular value is large or rounding; some motion is in the kernel */
    double left,
        worst; /* of the right-hand side; smallest singular value that is large, relative */
} medley_equations;

/* At the state of s; the data has its velocities then. */
void medley_find_equations(const medley *s, medley_equations *e);
void medley_free_equations(medley_equations *e);

/* [P -C^T; C 0] x = (g; b), b NULL: zero. */
void medley_solve(medley_equations *e, const double *P, const double *g, const double *b);

/* How far C^T lambda of the rigid rows, of the library, is from that of x, of lambda with that
 * sign. */
double medley_forces_off(const medley *s, const medley_equations *e, const double *lambda,
                         double sign);

#endif
