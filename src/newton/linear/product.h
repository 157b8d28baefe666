/* Products with the Newton matrix.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_PRODUCT_H
#define MBSRI_PRODUCT_H

#include "newton/linear/linear.h"

/* Vectors of one product, body by body, in the order of the sweeps or of groups. */
typedef struct mbsri_vectors {
    double *motion;             /* w->motions: x */
    double *action;             /* 3 size_v: y */
    double *torque, *push;      /* nu: dtau; w C_h^T c deta */
    double *own;                /* 3 nu, joint by joint */
    double *momentum, *balance; /* nu: d(M u) - dp and d(J^T mu - tau); then L^-1 of them */
    double *mbar, *fbar;        /* size_v: what L^-1 passes on of both */
    double *kappa;              /* size_v: C_h^T c deta */
    double *in, *out;           /* of one joint, element or closure: what it reads, what it gives */
} mbsri_vectors;

/* Places them in memory (NULL: none); returns how many doubles they take. */
size_t mbsri_vectors_place(const mbsri_linear *w, double *memory, mbsri_vectors *v);

/* All of r. */
void mbsri_product(const mbsri_linear *w, const double *delta, mbsri_vectors *v, double *r);

/* What joint forces tau (nu) on top of all others add to F: r = dF/dtau tau. */
void mbsri_product_of_torque(const mbsri_linear *w, const double *tau, mbsri_vectors *v, double *r);

#endif
