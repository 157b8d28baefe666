/* Random models of everything, with bodies without mass, trees and closed ones: they stand on axes,
 * in lines and in each other's planes, or anywhere.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_ANY_MODEL_H
#define TEST_ANY_MODEL_H

#include "expect.h"
#include "units.h"

#include <mbsrank/mbsrank.h>

#include <stdbool.h>
#include <stdint.h>

enum { ANY_BODIES = 8, ANY_MOST = 64 };

/* A model under way: its coordinates, and where its bodies are. */
typedef struct any_model {
    mbsr_model *m;
    test_rng *rng;
    const units *of;
    bool rich;    /* friction, stops, gears, cables, stiff rows, armature, and it moves */
    bool generic; /* places and angles are any numbers */
    int nq, nu, bodies;
    bool turns[ANY_MOST];                 /* nu */
    bool turn[ANY_MOST];                  /* nq */
    int first[ANY_BODIES], n[ANY_BODIES]; /* of the rates of each body */
    bool plain[ANY_BODIES];               /* its q' is its u */
    int points[ANY_BODIES];               /* where masses are, a solid body has one; 0: none */
    double place[ANY_BODIES][6];          /* of these */
    double q[ANY_MOST], u[ANY_MOST];
    mbsr_frame at[ANY_BODIES];
} any_model;

/* False: a closure has no freedom to hold. Closed where the seed is odd. */
bool any_model_make(any_model *s, uint64_t seed, const units *of, bool rich);

#endif
