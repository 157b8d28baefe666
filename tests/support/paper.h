/* The problems of M. Arnold, Mech. Sci. 4 (2013): two planar mass points (Fig. 3) and two coupled
 * oscillators (Fig. 1), as models and as the linear equations they must give, written by hand.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_PAPER_H
#define TEST_PAPER_H

#include "close.h"

#include "../../examples/expm.h"

#include <mbsrank/mbsrank.h>

typedef struct paper_parameters {
    double mi, mj;             /* kg */
    double cix, dix, ciy, diy; /* point i to ground */
    double cjx, djx;           /* point j to point i along x (upper configuration) */
    double l;                  /* distance in x (lower configuration) */
} paper_parameters;

extern const paper_parameters paper_standard; /* mi = 0 */

/* Finished models; body 0 is i, body 1 is j. */
mbsr_model *paper_upper(const paper_parameters *p); /* q = qix qiy qjx qjy */
mbsr_model *paper_lower(const paper_parameters *p); /* q = qix qiy qj */

/* Point 1 between ground and point 2 on a line: q = p1, p2 - p1 (relative) or p1, p2 (absolute);
 * force F on point 1. */
typedef struct oscillator_parameters {
    double m1, m2, c1, c2, d1, d2, F;
} oscillator_parameters;

extern const oscillator_parameters oscillator_standard; /* m1 = 0 */

mbsr_model *paper_oscillators(const oscillator_parameters *p, int relative);

/* The motions as x' = A x + b, with these states; those in brackets only for mi > 0 (m1 > 0):
 *   upper        pix piy pjx pjy vjx vjy (vix viy)
 *   lower        pix piy pjy vix vjy (viy)
 *   oscillators  p1 p2 v2 (v1) */
expm_system paper_upper_system(const paper_parameters *p);
expm_system paper_lower_system(const paper_parameters *p);
expm_system paper_oscillator_system(const oscillator_parameters *p);

/* States from q and u, and q from states. */
void paper_upper_state(const double *q, const double *u, double *x);
void paper_upper_positions(const double *x, double *q);
void paper_lower_state(const double *q, const double *u, double *x);
void paper_lower_positions(const double *x, double *q);

#endif
