/* What parameters change of the equations where they stand, all else held: seeds of the products of
 * linearised inverse dynamics, and their values at a state.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_DERIVATIVES_SEED_VALUES_H
#define MBSRI_DERIVATIVES_SEED_VALUES_H

#include "assembly/parameters.h"
#include "newton/linear/linear.h"

/* Where a change enters: pose, V and A of a body; forces on it, in mu; joint forces, in the order
 * of the sweeps; joint forces that are missing, in the caller's; forces of stiff rows. In the
 * residual of the momentum form, as mbsri_sources has it: in place of mu momentum, its rate and mu;
 * missing momenta and rates of momenta of joints; rows of closures. */
typedef enum mbsri_seed_place {
    MBSRI_SEED_MOTION,
    MBSRI_SEED_REACTION,
    MBSRI_SEED_TORQUE,
    MBSRI_SEED_LOAD,
    MBSRI_SEED_SPRING,
    MBSRI_SEED_ACTION,
    MBSRI_SEED_PULSE,
    MBSRI_SEED_DRIFT,
    MBSRI_SEED_ROW,
    MBSRI_SEED_PLACES
} mbsri_seed_place;

/* What the seeds are for: products of any model, those of the residual of the momentum form; else
 * the sweeps, which want so many numbers of a frame. */
enum { MBSRI_SEED_PRODUCTS = 0, MBSRI_SEED_RESIDUAL = -1 };

/* `count` numbers from `at` on in the vector of that place; their values by offset. */
typedef struct mbsri_seed {
    mbsri_seed_place place;
    int count;
    size_t at, value;
} mbsri_seed;

/* A parameter: its seeds, and the index of the body, element or closure that has it. */
typedef struct mbsri_seeded {
    mbsri_parameter parameter;
    int index;
    size_t first, last; /* seeds: first .. last - 1 */
} mbsri_seeded;

typedef struct mbsri_seeds {
    int count; /* of parameters */
    size_t seeds, values, longest;
    mbsri_seeded *of;
    mbsri_seed *seed;
    double *value;                  /* at the state */
    double *by;                     /* a gradient in all */
    double *work;                   /* of one call of an element */
    double *sum[MBSRI_SEED_PLACES]; /* along a change of all parameters */
    size_t length[MBSRI_SEED_PLACES];
    int use;                          /* numbers of a frame of the sweeps, or the above */
    const double *loops, *loops_rate; /* of the residual: y and y' of closures */
    bool active;                      /* whether products take `sum` in */
    void *memory;
} mbsri_seeds;

/* Values of one parameter where the data is at the state, with A and mu. A status, with the text in
 * the data. */
int mbsri_seed_values(mbsri_seeds *s, const mbsri_seeded *p, const mbsri_linear *l, mbsr_data *d);

/* x: what moving a frame of the joint of body p->index changes of pose, V and A of that body, six
 * numbers each, angular parts first, all else held; `behind`: the joint's axes stay. A status. */
int mbsri_frame_change(const mbsri_seeded *p, const mbsr_model *m, mbsr_data *d, double x[18],
                       bool *behind);

/* Whether body j moves along where a frame of the joint of body i is moved, by another way than
 * with its predecessor: i itself, or what stands rigidly on an i that is welded. By index. */
bool mbsri_rides(const mbsr_model *m, int i, int j);

/* Which free rate coordinate k of a joint is, as it was given; -1: it is locked. */
int mbsri_rate_as_given(const mbsri_body *b, int k);

#endif
