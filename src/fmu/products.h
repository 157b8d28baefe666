/* Derivatives of an instance from the library's analytic products.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Model exchange: from F(q, p, u; w) of the momentum form, w inputs,
 *
 *   (q', p') = -(F_x dx + F_u du + F_w dw),   0 = the rows of u of the same
 *
 * with products and solutions of the Newton matrix. Both kinds: accelerations and loop forces from
 * linearised forward dynamics. F_w is a difference of F alone, in which applied forces are linear.
 */
#ifndef MBSRI_FMU_PRODUCTS_H
#define MBSRI_FMU_PRODUCTS_H

#include "fmu/instance.h"

/* At the state of an instance. */
typedef struct mbsri_products {
    mbsri_instance *in;
    bool states;        /* q, u, p and derivatives of the states are served */
    bool accelerations; /* u' and loop forces are served */
    bool motions;       /* numbers of motions are among the knowns */
    int nq, nu, size;   /* size: of y */
    double *y, *yp, *F; /* the state, and a residual */
    double *z, *r;      /* change of y, or multipliers of F with weights of u; a product: size */
    double *b;          /* F_w dw: size */
    double *x, *tau;    /* nu: change of q along joint rates; of joint forces */
    double *udot;       /* nu: change or weight of u' */
    double *lambda;     /* rows: of loop forces */
    double *input;      /* where the inputs stand */
    double *dw, *dx;    /* changes of inputs; of x, x', or their weights: nq + nu each */
} mbsri_products;

/* Prepares products at the state of the instance: x, or q and u. False: no memory; what cannot be
 * served is not. mbsri_products_end in every case. */
bool mbsri_products_begin(mbsri_products *p, mbsri_instance *in, bool accelerations, bool motions);
void mbsri_products_end(mbsri_products *p);

/* Whether a variable's derivatives are served. */
bool mbsri_products_serve(const mbsri_products *p, const mbsri_variable *v);

/* From dx and dw: what mbsri_products_of tells then of a variable. False: it does not converge. */
bool mbsri_products_along(mbsri_products *p);
double mbsri_products_of(const mbsri_products *p, const mbsri_variable *v);

/* The transpose. Weights are added to zeros by _weigh; then _against; then the gradient by a known,
 * an input (the first pair of residuals differs) or a state. */
void mbsri_products_weigh(mbsri_products *p, const mbsri_variable *v, double weight);
bool mbsri_products_against(mbsri_products *p);
bool mbsri_products_gradient(mbsri_products *p, const mbsri_variable *v, double *gradient);

#endif
