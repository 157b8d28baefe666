/* Random trees whose frames are turned by exact right angles, by half of them or by any angle, and
 * dense linear algebra that tells what must be said of them.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_TURNED_H
#define TEST_TURNED_H

#include "expect.h"
#include "units.h"

#include <mbsrank/mbsrank.h>

#include <stdbool.h>
#include <stdint.h>

enum { TURNED_BODIES = 8, TURNED_MOST = 48 };

/* A model under way, its state and its coordinates. */
typedef struct turned {
    mbsr_model *m;
    mbsr_data *d;
    test_rng rng;
    const units *of;
    int bodies, nq, nu;
    int first[TURNED_BODIES], n[TURNED_BODIES], parent[TURNED_BODIES];
    bool plain[TURNED_BODIES]; /* its q' is its u */
    bool turns[TURNED_MOST];   /* nu */
    double q[TURNED_MOST], u[TURNED_MOST];
} turned;

enum { TURNED_JOINTS = 8, TURNED_FREE = 7 };

/* R <- R times a turn about an axis; cosines of right angles are 6e-17. */
void turned_about(double R[9], int axis, double angle);

void turned_begin(turned *s, uint64_t seed, const units *of);
mbsr_frame turned_frame(turned *s);

/* One more body on a joint of that kind (below TURNED_JOINTS); half of its coordinates are zero. */
void turned_add(turned *s, int parent, int kind, mbsr_inertia inertia);
void turned_force(turned *s, mbsr_force_def force);
mbsr_inertia turned_rigid(turned *s);

/* Finishes the model, with data. */
void turned_finish(turned *s);
void turned_free(turned *s);

/* Eigenvectors (n x n, columns) of a symmetric matrix with unit diagonal or zeros there, null ones
 * first; how many these are, -1: eigenvalues between that tell nothing. */
int turned_null(int n, const double *A, double *vectors);

#endif
