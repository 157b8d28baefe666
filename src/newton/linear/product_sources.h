/* Products with the Newton matrix that take in more than delta: changes of the equations where they
 * stand, as parameters make them; and the transposed products.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_PRODUCT_SOURCES_H
#define MBSRI_PRODUCT_SOURCES_H

struct mbsri_linear;
struct mbsri_vectors; /* product.h */

/* What is taken in, or what a transposed product says of it: x and y as in mbsri_vectors, torques
 * in the order of the sweeps; in the caller's order (nu) parts of d(M u) - dp, of d(J^T mu - tau)
 * and of dP; forces of the rows of closures; their velocity and position rows. */
typedef struct mbsri_sources {
    double *motion, *action, *torque;
    double *pulse, *load, *drift;
    double *lambda, *rows;
} mbsri_sources;

/* mbsri_product with these; NULL: none. */
void mbsri_product_with(const struct mbsri_linear *w, const double *delta,
                        const mbsri_sources *sources, struct mbsri_vectors *v, double *r);

/* mbsri_product_transposed, and into `by` what it says of sources, but for motion, action and
 * torque, which stand in v; NULL: not asked. */
void mbsri_product_transposed_with(const struct mbsri_linear *w, const double *r,
                                   struct mbsri_vectors *v, double *delta, mbsri_sources *by);

#endif
