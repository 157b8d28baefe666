/* Products with the Newton matrix.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_PRODUCT_H
#define MBSRI_PRODUCT_H

#include "newton/blocks/record.h"

/* Doubles and ints that the product of a model needs; offsets of its bodies go to w->node. They are
 * given to it as w->product.store and w->product.flags. */
size_t mbsri_product_size(mbsr_newton *w);
size_t mbsri_product_flags(const mbsr_newton *w);

/* The derivatives at the state (t, y), with the loop forces of y', for the factor c. A status. Leaves
 * the factorisation as it is. */
int mbsri_product_linearise(mbsr_newton *w, mbsr_data *d, double t, const double *y,
                            const double *yp, double c);

/* r = (dF/dy + c dF/dy') delta; not the same. */
void mbsri_product_multiply(mbsr_newton *w, const double *delta, double *r);

#endif
