/* The Newton solver (struct mbsr_newton), and what loops carry in vector code.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Perturbations of a body: of its pose, e numbers (SPATIAL: a small rotation about its origin and
 * the displacement of that origin, along the world's axes; else the np numbers of the pose), of its
 * velocity V and, where needed, of its acceleration A, d numbers each. */
#ifndef MBSRI_CARRIED_RECORD_H
#define MBSRI_CARRIED_RECORD_H

#include "newton/front/front.h"
#include "newton/slopes/low_rank.h"

#include <mbsrank/newton.h>

#include <stddef.h>

struct mbsri_newton_sweeps;

/* A body, as the sweeps over loops see it. */
typedef struct mbsri_node {
    int e;               /* numbers of the pose's perturbation */
    bool below_massless; /* its perturbation has A, at the last factorisation */
    size_t v;            /* offset of the names of its joint: 2 n numbers */
} mbsri_node;

/* An element that acts across the tree: what of it is not on the tree is left * read, of low
 * rank. */
typedef struct mbsri_across {
    int force;         /* its number among the model's */
    int rank;          /* at the last factorisation */
    int most;          /* its number of rows, which the rank does not exceed */
    int first;         /* its first column in the correction */
    size_t left, read; /* offsets of rows x most and of most x columns numbers */
} mbsri_across;

typedef struct mbsri_correction {
    int count, most; /* elements; largest rank */
    mbsri_across *element;
    double *left, *read;
    double *matrix, *weights, *rows, *columns; /* most x most, most each */
    mbsri_low_rank_spans span;                 /* of an element */
    double *delta;                             /* the size of y */
    int *pivots;                               /* most */
} mbsri_correction;

/* Closures in the elimination (carried.h). Unknowns that are carried have names: the multipliers
 * lambda of the rows, eta of the position rows, w of what crosses the tree, and the unknowns of the
 * joints. */

/* What of a closure enters the elimination. */
typedef struct mbsri_loop {
    int level;         /* place of the front that closes it in the order of elimination */
    int pool;          /* index of that front and of its pool */
    int across;        /* name of the first unknown w that carries its forces across the tree */
    int most, rank;    /* number of these unknowns: at most, and at the last factorisation */
    size_t S;          /* offset of d(C^T lambda) over motions, columns x columns */
    size_t slope;      /* offset of slopes of the velocity rows, rows x columns */
    size_t left, read; /* offsets of the factors of S: columns x most, most x columns */
    int next;          /* next loop of the same front in vector code (lane_pools.h); -1: none */
    bool follower;     /* whether its forces follow a body and no w is needed (follower.h) */
    int next_follower; /* next loop of that kind; -1: none */
    size_t turn;       /* offset of its mbsri_closure_turn; nothing where `most` is 0 */
} mbsri_loop;

/* A multiplier lambda or eta in a solution. */
typedef struct mbsri_multiplier {
    ptrdiff_t right; /* offset of its row's right-hand side; -1: it is left out */
    double in, out;  /* factors: of r in that, of its value in delta */
} mbsri_multiplier;

/* A closure at one of its bodies. */
typedef struct mbsri_loop_end {
    int closure, slot;
    int next; /* of the same body; -1: none */
    int d;    /* velocity coordinates of the body */
} mbsri_loop_end;

/* What comes to a front from behind, and from closures at its body: unknowns v and rows that wait
 * for elimination, with y = P x + Q v + b and R x + T v = s in the body's x and y. There are as
 * many rows as unknowns. One line of the cache: solving reads no more of a joint's front in vector
 * code. */
typedef struct mbsri_pool {
    int body;
    int up;          /* the pool that its front hands on to */
    int most, count; /* unknowns: the most, and those in it now */
    short stride;    /* numbers of a column of Q, at most; kappa has stride / 3 */
    short motions;   /* numbers of a row of R, at most */
    bool in_lanes;   /* whether vector code passes the body */
    bool in_place;   /* whether pool `up` goes on in the same memory */
    bool loose;      /* whether unknowns of joints behind may be delayed into it */
    size_t column;   /* offset among ints: names of unknowns, then of rows */
    size_t place;    /* offset among ints: places of rows in the front */
    size_t Q, right; /* offsets among doubles: stride x most, behind it R, T and kappa; most */
    size_t record;   /* offset among doubles, in vector code: what solving needs of the front */
} mbsri_pool;
_Static_assert(sizeof(mbsri_pool) <= 64, "mbsri_pool");

/* Behind the names of unknowns, and behind Q: motions x most by rows, most x most, stride / 3 x
 * most. */
static inline size_t mbsri_pool_row(const mbsri_pool *pool)
{
    return pool->column + (size_t)pool->most;
}

static inline size_t mbsri_pool_R(const mbsri_pool *pool)
{
    return pool->Q + (size_t)(pool->stride * pool->most);
}

static inline size_t mbsri_pool_T(const mbsri_pool *pool)
{
    return mbsri_pool_R(pool) + (size_t)(pool->motions * pool->most);
}

static inline size_t mbsri_pool_kappa(const mbsri_pool *pool)
{
    return mbsri_pool_T(pool) + (size_t)pool->most * (size_t)pool->most;
}

/* A joint, or loops that close on a body, with what is carried there; of the latter `size`
 * unknowns, of which `done` are eliminated; the rest is carried on. */
typedef struct mbsri_carried_front {
    int level;          /* higher than of any that is eliminated later */
    int next, previous; /* closing fronts: on the same body, as they are
                         * eliminated, 0: none */
    int delayed;        /* what it may hand on of unknowns that could go */
    int first_loop;     /* that closes here; -1: none */
    bool passes;        /* loops go on from it */
    bool judged;        /* rigid position rows of loops that close on bodies stand in it */
    size_t place;       /* ints */
    int size, done;     /* at the last factorisation */
} mbsri_carried_front;

typedef struct mbsri_carried {
    int names, multipliers; /* all; of closures */
    int fronts;             /* and pools: N + 1 for the bodies, then closing fronts */
    int most;               /* unknowns of any front */
    size_t widest;          /* doubles of work */
    mbsri_loop *loop;       /* closures */
    mbsri_loop_end *end;    /* */
    int *first_end;         /* N + 1 */
    int *first_closing,     /* N + 1: closing fronts of a body, 0: none */
        *last_closing;
    int *closure;       /* multipliers: the closure of the name */
    int first_follower; /* -1: none */
    bool *served;       /* N + 1: joints that are fronts */
    int *used, uses;    /* pools that have room for unknowns: which, and how many */
    mbsri_pool *pool;
    mbsri_pool *lane_pool; /* the same of bodies in vector code (lane_pools.h) */
    mbsri_carried_front *front;
    mbsri_multiplier *multiplier; /* rows and position rows of closures */
    double mobility;              /* 1/kg: the least weight of a rate (mbsri_scales), as if it
                                   * moved by the length what it turns */
    double *value;                /* names: the solution */
    double *store, *work;
    int *numbers, *list;
    size_t right, right_count; /* right-hand sides of the pools in vector code: offset and length */
    void *memory;
    size_t bytes;
} mbsri_carried;

struct mbsr_newton {
    const mbsr_model *model;
    mbsr_newton_info info;
    mbsr_error error;
    bool factored, corrected;
    double *solution; /* the size of y */

    /* what the sweeps in vector code do not serve; NULL: lean */
    mbsri_front *front;

    /* the sweeps in vector code; NULL: they do not serve the model, or are not wanted */
    struct mbsri_newton_sweeps *sweeps;
    mbsri_front *mixed; /* the same of bodies among those in vector code; NULL: there are none */
    bool by_sweeps;     /* the last factorisation is theirs */
    bool lean;          /* there is nothing else */
    bool transposes;    /* transposed solutions are wanted */
    size_t sweep_size;  /* its bytes; 0: none */
    void *sweep_block;  /* where it was allocated */
    double *motion;     /* 12 (N + 1): perturbations of pose and V of the bodies, where corrected */
    double *load;       /* size_v + nu: of their forces and, in the order of the sweeps, of joint
                           forces; right: the size of y. lean: NULL, but load where corrected */
    double *right;
    double c;
    void *block, *numbers; /* memory: doubles and ints; nodes and lists */
    mbsri_node *node;      /* N + 1, with closures */
    size_t size_n;         /* names of joints */
    mbsri_slopes slopes;
    mbsri_correction correction;
    mbsri_carried carried;

    /* for products; NULL: none are wanted */
    mbsri_linear *linear;
    mbsri_vectors vectors;
    double *other; /* the size of y */
    void *of_products;
    bool linearised;
};

#endif
