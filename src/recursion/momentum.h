/* The steps of the momentum form for one body: impulses, their rates, the algebraic equations. The
 * equations are in forms/momentum.c.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_MOMENTUM_STEPS_H
#define MBSRI_MOMENTUM_STEPS_H

#include "recursion/group.h"

/* Each has what the successors passed on in imp, sigma, impbar of the body, and passes on to the
 * predecessor's. p, pdot, F: the body's own n numbers. */

/* m and p.  reads M, V, H, J;  writes imp, p. */
void mbsri_momentum_of(const mbsr_model *m, mbsr_data *d, int i, double *p);

/* p'.  reads imp, f, tau, H, J, their rates, Mdot;  writes sigma, pdot. */
void mbsri_momentum_rate_of(const mbsr_model *m, mbsr_data *d, int i, double *pdot);

/* ep.  reads p, Mbar, G, kI, H, J;  writes ep and, what the predecessor gets of it with H^T, impbar
 * of heads. */
void mbsri_condense_of(const mbsr_model *m, mbsr_data *d, int i, const double *p);

/* The rate that makes a force of a momentum in the algebraic equations of a joint or group of n
 * rates that has both: that typical of the model; 1 where it has one of them alone. */
static inline double mbsri_momentum_rate(const mbsr_model *m, int n, int rank)
{
    const double rate = m->typical.frequency;
    return rank > 0 && rank < n && rate > 0.0 ? rate : 1.0;
}

/* The algebraic equations of a group (n).  reads ep, e, D, U, H, V, u;  writes F. */
void mbsri_balance_of(const mbsr_model *m, mbsr_data *d, const mbsri_group *g, double *F);

#endif
