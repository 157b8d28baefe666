/* What the parts of medley.h have in common.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_MEDLEY_PARTS_H
#define TEST_MEDLEY_PARTS_H

#include "medley.h"

typedef struct medley_body {
    mbsr_space space;
    int parent, cut; /* cut: the body it is welded to by a closure, or MBSR_NONE */
    bool plain;      /* q' = u */
    int n, u;
    mbsr_frame at; /* where it is */
    mbsr_joint_table table;
} medley_body;

static inline double medley_share(test_rng *rng)
{
    return 0.5 * (1.0 + test_uniform(rng));
}

/* Motions, which are zero at the time of the state: of three numbers; of one, from *user on. */
int medley_follow(void *user, double t, double *s, double *sdot, double *sddot);
int medley_follow_one(void *user, double t, double *s, double *sdot, double *sddot);

/* A frame of the world, and one in the axes of a body; -1: the ground. */
mbsr_frame medley_frame(const medley *s, int body);
mbsr_frame medley_seen_from(const medley *s, int body, const mbsr_frame *world);

/* So many bodies before one, -1: the ground. */
int medley_before(const medley *s, int body, int steps);
/* Whether neither is in space. */
bool medley_is_flat(const medley *s, int a, int b);

/* To a model whose bodies are there; cuts: welds of the bodies that are to close a loop. */
void medley_add_cuts(medley *s);
void medley_add_closures(medley *s, test_rng *rng);
void medley_add_springs(medley *s, test_rng *rng);

#endif
