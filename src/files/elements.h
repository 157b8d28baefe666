/* Force elements and closures that files need and the core does not have.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FILES_ELEMENTS_H
#define MBSRI_FILES_ELEMENTS_H

#include <mbsrank/closure.h>
#include <mbsrank/force.h>

#include <stdbool.h>

/* F = gain w + bias[0] + bias[1] x + bias[2] l', w and F each no further than its range, x = l
 * beyond rest[0] .. rest[1], measured from there (0 between; {0, 0}: x = l). */
typedef struct mbsri_file_law {
    double gain, bias[3], rest[2];
    bool control_limited, force_limited;
    double control_range[2], force_range[2];
    const double *control; /* w; NULL: 0 */
} mbsri_file_law;

enum { MBSRI_LAW_PARAMS = 10 };

/* A law in the first parameters of an element, its options and `user`. */
void mbsri_law_put(const mbsri_file_law *law, mbsr_force_def *def);
void mbsri_law_get(const mbsr_force_def *def, mbsri_file_law *law);

/* F, and its slopes in l and l'. */
double mbsri_law_force(const mbsr_force_def *def, double l, double rate, double slope[2]);

/* A law on l = sum of factor q[coordinate] of bodies. */
typedef struct mbsri_transmission {
    int count;
    const int *body, *coordinate;
    const double *factor;
    mbsri_file_law law;
} mbsri_transmission;

enum { MBSRI_TRANSMISSION_MOST = 10 };

mbsr_force_def mbsri_force_transmission(const mbsri_transmission *t);

/* One read back; coordinate and factor have room for MBSRI_TRANSMISSION_MOST. False: it is another
 * element. */
bool mbsri_transmission_of(const mbsr_force_def *def, mbsri_transmission *t, int *coordinate,
                           double *factor);

/* q[coordinate[0]] of body[0] - ref[0] = polynomial of q[coordinate[1]] of body[1] - ref[1], of
 * degree 4. */
mbsr_closure_def mbsri_closure_polynomial(const int body[2], const int coordinate[2],
                                          const double ref[2], const double power[5]);
bool mbsri_polynomial_of(const mbsr_closure_def *def, int coordinate[2], double ref[2],
                         double power[5]);

#endif
