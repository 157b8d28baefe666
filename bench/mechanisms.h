/* Mechanisms whose loops are closed by stiff damped springs, written as force elements or as stiff
 * closures.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MECHANISMS_H
#define MECHANISMS_H

#include <mbsrank/mbsrank.h>

enum { MECHANISM_MOST = 24 }; /* joint coordinates */

/* The springs: stiffness N/m, damping N s/m; as closures they start as they are, without load. */
typedef struct mechanism_ties {
    double stiffness, damping;
    int closures; /* 1: stiff closures; 0: force elements */
} mechanism_ties;

typedef struct mechanism {
    const char *name;
    /* Adds bodies, forces and ties to an empty model; writes a start that closes the loops. */
    void (*build)(mbsr_model *model, const mechanism_ties *ties, double *q, double *u);
    double T; /* s */
    double
        mass; /* kg, about what a tie feels: damping ratio = damping / (2 sqrt(mass stiffness)) */
    int conserve; /* 1: nothing drives it, so that its energy never rises above that of the start */
} mechanism;

/* The first is the slider-crank of docs/dae_forms.md; both end with a name of NULL. */
extern const mechanism mechanisms[], mechanisms_more[];

#endif
