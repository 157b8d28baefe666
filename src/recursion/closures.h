/* Closures over the tree: rows, their derivatives, and what they exert.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_CLOSURES_H
#define MBSRI_CLOSURES_H

#include "recursion/closure_view.h"

/* g of all position rows, at the positions. */
int mbsri_closure_gaps(const mbsr_model *m, mbsr_data *d, double *g);

/* Derivatives of all velocity rows, or of those of one closure, into the data's closure_C, at the
 * positions. */
int mbsri_closure_jacobians(const mbsr_model *m, mbsr_data *d);
int mbsri_closure_jacobian_of(const mbsr_model *m, mbsr_data *d, const mbsri_closure *c);

/* C u + g_t, and its derivative where u' is zero; at the velocities, after the derivatives. */
int mbsri_closure_rates(const mbsr_model *m, mbsr_data *d, double *rate);
int mbsri_closure_bias(const mbsr_model *m, mbsr_data *d, double *bias);

/* The derivatives of the rows, and that bias where all accelerations of bodies are zero; at the
 * velocities. */
int mbsri_closure_rows_here(const mbsr_model *m, mbsr_data *d, double *bias);

/* Both of gaps and rates. */
int mbsri_closure_errors(const mbsr_model *m, mbsr_data *d, double *rate, double *g);

/* Adds C^T lambda, row by row as forces on bodies (size_v) and joints (nu, in the order of the
 * sweeps). */
void mbsri_closure_load(const mbsr_model *m, const mbsr_data *d, const double *lambda, double *f,
                        double *tau);

/* The derivatives, with lambda into the data's f and tau and, if it is not NULL, eta into closure_V
 * and closure_w, which are zero before. */
int mbsri_closure_loads_here(const mbsr_model *m, mbsr_data *d, const double *lambda,
                             const double *eta);

/* y (nu, by the caller's order) = C^T x, which is left in closure_w in the order of the sweeps (y
 * may be NULL); y (rows) = C x; after the derivatives. */
void mbsri_closure_transpose(const mbsr_model *m, mbsr_data *d, const double *x, double *y);
void mbsri_closure_apply(const mbsr_model *m, mbsr_data *d, const double *x, double *y);

/* Loop forces at the state of the velocities, from which forces are evaluated: those of stiff rows
 * by their law, of others zero; into loop_lambda. */
int mbsri_closure_springs(const mbsr_model *m, mbsr_data *d);

/* Reports the status of a function of a closure's table. */
int mbsri_closure_failed(const mbsr_model *m, mbsr_data *d, const mbsri_closure *c, int status,
                         const char *function);

/* Whether row k of the closure is a spring. */
static inline bool mbsri_is_stiff(const mbsri_closure *c, int k)
{
    return c->def.stiffness[k] > 0.0;
}

/* The first of them; where there are none, something that has an address. */
const mbsri_closure *mbsri_all_closures(const mbsr_model *m);

/* Whether its functions read joint coordinates. */
static inline bool mbsri_reads_joints(const mbsri_closure *c)
{
    return (c->def.table->flags & MBSR_CLOSURE_JOINTS) != 0;
}

/* Whether a start leaves its spring as it is. */
static inline bool mbsri_is_loose(const mbsri_closure *c, int k)
{
    return mbsri_is_stiff(c, k) && !c->def.settled;
}

/* Adds the energy of the springs of stiff rows, k g^2 / 2, or the power that they turn into heat,
 * to *sum. */
int mbsri_closure_sum(const mbsr_model *m, mbsr_data *d, bool energy, double *sum);

#endif
