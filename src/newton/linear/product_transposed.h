/* Products with the transposed Newton matrix.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_PRODUCT_TRANSPOSED_H
#define MBSRI_PRODUCT_TRANSPOSED_H

#include "newton/linear/product.h"

/* delta = (dF/dy + c dF/dy')^T r, not the same. */
void mbsri_product_transposed(const mbsri_linear *w, const double *r, mbsri_vectors *v,
                              double *delta);

/* tau (nu) = (dF/dtau)^T r, the transpose of mbsri_product_of_torque. */
void mbsri_product_of_torque_transposed(const mbsri_linear *w, const double *r, mbsri_vectors *v,
                                        double *tau);

#endif
