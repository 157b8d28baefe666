/* Mechanisms of everything at once: joints of all kinds, users' ones, locked and driven axes,
 * bodies of any rank and dimension, in space and in the plane, points, moving roots, springs across
 * the tree; closures of all kinds, rigid, stiff and compliant, redundant ones, couplings, springs
 * as closures.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_MEDLEY_H
#define TEST_MEDLEY_H

#include "close.h"

#include <mbsrank/mbsrank.h>

#include <stdbool.h>

enum { MEDLEY_LENGTHS = 64 };

typedef enum medley_family {
    MEDLEY_SPACE, /* rigid bodies in space */
    MEDLEY_FLAT,  /* the same, all joints in one plane */
    MEDLEY_PLANE, /* bodies in the plane */
    MEDLEY_MIXED, /* points, bodies in the plane and in space */
    MEDLEY_FAMILIES
} medley_family;

typedef struct medley_choice {
    uint64_t seed;
    medley_family family;
    int bodies, closures, springs;
    double own; /* share of users' joints, locked coordinates, added masses, armature, bodies of any
                   dimension */
    double massless; /* share of bodies without inertia; a third as many have a deficient one */
    double stiff, twice;
    bool moving; /* the root, and what closures follow */
    bool local;  /* loops are short: for large trees */
} medley_choice;

/* A model with data and a state (t, q, u), at which its closures are closed. */
typedef struct medley {
    medley_choice c;
    mbsr_model *m;
    mbsr_data *d;
    int bodies, nq, nu, rows, position_rows, size;
    double t, *q, *u;
    struct medley_body *body;
    double length[MEDLEY_LENGTHS]; /* of distances that follow a motion */
    int lengths;
} medley;

/* Of all sorts, by its number. */
medley_choice medley_choose(uint64_t seed);
/* The structure must stay where it is until it is freed. False: a closure has no freedom to hold.
 */
bool medley_make(medley *s, const medley_choice *c);
void medley_free(medley *s);

#endif
