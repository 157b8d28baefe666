/* The Newton solver's structure.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Perturbations of a body: of its pose, e numbers (SPATIAL: a small rotation about its origin and
 * the displacement of that origin, along the world's axes; else the np numbers of the pose), of its
 * velocity V and, where needed, of its acceleration A, d numbers each. */
#ifndef MBSRI_BLOCKS_RECORD_H
#define MBSRI_BLOCKS_RECORD_H

#include "newton/front/front.h"

#include <mbsrank/newton.h>

#include <stddef.h>

struct mbsri_newton_sweeps;

/* A body in the general elimination (factor.c). Its perturbation x counts pose and V, and A where
 * `deep`: in the subtree of a joint whose block is deficient. */
typedef struct mbsri_node {
    int e;            /* numbers of the pose's perturbation */
    bool deep;        /* at the last factorisation; so are the next three */
    bool coupled;     /* one of a group of joints that are eliminated as one (coupled.c) */
    int rank;         /* of its joint, or group */
    int unknowns;     /* du, and u' in the range of D where deep */
    int slot;         /* of its matrix while the elimination goes on */
    int last;         /* its last successor; 0: none */
    int first, count; /* its entries in `listed` */
    size_t x, v;      /* offsets: e + 2 d numbers, max(2 n, nq) numbers */
    size_t store;     /* offset of what is kept of its joint, see mbsri_kept */
    size_t product;   /* offset of its matrices for products */
} mbsri_node;

/* What is kept of a joint between factoring and solving; matrices by columns. The columns of `x`,
 * `momentum` and `rate` are the predecessor's perturbation, dq, du and, where deep, du'; of a group
 * its head keeps what counts rates, and `x` of every member has the columns of the head's. */
typedef struct mbsri_kept {
    double *H, *Hdot, *J, *Jdot, *G; /* as in the data */
    double *s, *X;                   /* likewise */
    double *unit;                    /* 1: of du' as an unknown */
    double *x;                       /* the body's perturbation */
    double *momentum;                /* d(M u) of the joint, n rows, but for b */
    double *rate;                    /* dp', likewise */
    double *Cq;                      /* nq x nq: dq = Cq (G du + r_q) */
    double *Q;                       /* nq x n: Cq G */
    double *E;                       /* unknowns x unknowns, factored; its scales */
    double *row_scale, *column_scale;
    double *Eq; /* unknowns x nq */
    double *K;  /* unknowns x the predecessor's perturbation */
    double *U;  /* what the unknowns add to the predecessor's forces */
    double *Uq; /* what Cq r_q adds */
} mbsri_kept;

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
    double *load;                              /* size_v + nu */
    double *delta;                             /* the size of y */
    int *pivots;                               /* most */
} mbsri_correction;

/* Closures in the elimination (carried.h). Unknowns that are carried have names: the multipliers
 * lambda of the rows, eta of the position rows, w of what crosses the tree, and the unknowns of the
 * joints. */

/* What of a closure enters the elimination. */
typedef struct mbsri_loop {
    int level;         /* of the front that closes it */
    int pool;          /* of that front */
    int across;        /* names of what crosses the tree: the first */
    int most, rank;    /* of them: at most, and at the last factorisation */
    size_t S, slope;   /* offsets: columns x columns, rows x columns */
    size_t left, read; /* columns x most, most x columns */
    int next;          /* of the same front in vector code (swept.h); -1: none */
    bool turned;       /* at the last factorisation: nothing crosses, see turned.h */
    int next_turned;   /* -1: none */
    size_t turn;       /* offset, where anything may cross */
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
 * many rows as unknowns. One line of the cache: solving reads no more of a joint's front in vector code. */
typedef struct mbsri_pool {
    int body;
    int up; /* the pool that its front hands on to */
    int most, count;
    short stride,
        motions; /* numbers of a column of Q and of a row of R, at most; kappa has stride / 3 */
    bool swept;  /* the body is in vector code, and the pool of that kind; so are the next three */
    bool in_place;        /* the pool above goes on where this one is */
    bool loose;           /* joints from behind may be delayed here */
    bool closed;          /* at the last factorisation: by newton/sweeps/closing.h */
    size_t column, place; /* ints: names of unknowns, then of rows; places of rows in the front */
    size_t Q, right;      /* doubles: stride x most, and behind it R, T and kappa; most */
    size_t record;        /* doubles, in vector code: what solving needs of the front */
} mbsri_pool;
_Static_assert(sizeof(mbsri_pool) <= 64, "mbsri_pool");

/* Behind the names of unknowns, and behind Q: motions x most by rows, most x most, stride / 3 x most. */
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

static inline size_t mbsri_pool_end(const mbsri_pool *pool)
{
    return mbsri_pool_kappa(pool) + (size_t)(pool->stride / 3 * pool->most);
}

/* The equations of a joint, or of loops that close on a body, with what is carried there: `size`
 * unknowns, `own` of the joint, of which `done` are eliminated; the rest is carried on. */
typedef struct mbsri_carried_front {
    int level;            /* higher than of any that is eliminated later */
    int next, previous;   /* closing fronts: on the same body, as they are eliminated, 0: none */
    int delayed;          /* what it may hand on of unknowns that could go */
    int first_loop;       /* in vector code (swept.h): that closes here; -1: none */
    bool passes;          /* loops go on from it */
    size_t place;         /* ints */
    int most;             /* unknowns */
    int own, size, done;  /* at the last factorisation; so are the next two */
    int motions, actions; /* of the body it hands on to */
    int n, nq;            /* of the joint */
    size_t column, row, swap_column, swap_row;   /* ints */
    size_t LU, Mq, along, momentum, rate, right; /* doubles; LU: see front.h */
} mbsri_carried_front;

typedef struct mbsri_carried {
    int names, multipliers; /* all; of closures */
    int fronts;             /* and pools: N + 1 for the bodies, then closing fronts */
    int most;               /* unknowns of any front */
    size_t widest, largest; /* doubles of work, of the matrix of any front */
    mbsri_loop *loop;       /* closures */
    mbsri_loop_end *end;    /* */
    int *first_end;         /* N + 1 */
    int *first_closing,     /* N + 1: closing fronts of a body, 0: none */
        *last_closing;
    int *closure;     /* multipliers: the closure of the name */
    int first_turned; /* -1: none */
    bool *served;     /* N + 1: joints that are fronts */
    int *used, uses,
        apart; /* pools that have room for unknowns: which, and how many; those of blocks, which stand
                             * in front */
    mbsri_pool *pool;
    mbsri_pool *swept; /* the same of bodies in vector code (swept.h) */
    mbsri_carried_front *front;
    mbsri_multiplier *multiplier; /* rows and position rows of closures */
    double *value;                /* names: the solution */
    double *store, *work, *matrix;
    int *numbers, *list;
    size_t right, right_count; /* right-hand sides of the pools in vector code: offset and length */
    void *memory;
    size_t bytes;
} mbsri_carried;

/* Bodies that elements tie across the tree (linked.h). How joint i of a tree in vector code is passed, as it is
 * or as a block: from the load on its body to the unknowns and the load above; from the motion above and
 * the unknowns to the body's; pose and V of that motion; the forces f on a body, added to a load. */
typedef struct mbsri_link_passes {
    void (*reduce)(struct mbsri_newton_sweeps *sweeps, int i);
    void (*move)(struct mbsri_newton_sweeps *sweeps, int i, const double *r, double *delta);
    void (*tell)(const struct mbsri_newton_sweeps *sweeps, int i, const double *x, double *motion);
    void (*act)(const struct mbsri_newton_sweeps *sweeps, int i, const double *f, double *y);
} mbsri_link_passes;

/* Of body i: to one that is eliminated later; offsets of y_i over x_other, of y_other over x_i, and of the
 * unknowns of joint i over x_other. */
typedef struct mbsri_link {
    int other;
    size_t on, onto, answer;
} mbsri_link;

typedef struct mbsri_links {
    int *order;       /* N: bodies as they are eliminated */
    int *position;    /* N + 1: of each in that */
    int *first;       /* N + 2: of each body in `link` */
    mbsri_link *link; /* */
    size_t *own;      /* N + 1: offset of what is added to P */
    double *store;
    size_t matrices, size; /* doubles: of the matrices, of all */
    double *by_rate;       /* scratch of a joint: the bodies it is tied to, by its rates */
    /* of bodies in vector code: MBSRI_TIED_LOAD, MBSRI_SWEPT_MOTIONS, and MBSRI_TIED_SUMS of what
     * is handed on of momenta and forces */
    double *load, *motion, *sums;
    double *k, *p;  /* of their joints, as in the sweeps */
    double **place; /* scratch: N + 2 */
    const mbsri_link_passes *passes;
    void *memory;
    size_t bytes;
} mbsri_links;

struct mbsr_newton {
    const mbsr_model *model;
    mbsr_newton_info info;
    mbsr_error error;
    bool factored, corrected;

    /* the sweeps in vector code; NULL: they do not serve the model, or are not wanted */
    struct mbsri_newton_sweeps *sweeps;
    bool by_sweeps;    /* the last factorisation is theirs */
    bool mixed;        /* with the joints of blocks by the general elimination */
    bool lean;         /* the general elimination has memory for bodies that are seen alone */
    size_t sweep_size; /* its bytes; 0: none */
    void *sweep_block; /* where it was allocated */
    double *motion;    /* 12 (N + 1): perturbations of pose and V of the bodies, where corrected */
    double c;
    void *block, *numbers; /* the memory: doubles and ints; nodes and lists */
    double *solution;      /* the size of y */

    /* eliminates all of a model whose loops would be too many to carry; else NULL */
    mbsri_front *front;

    /* for products; NULL: none are wanted */
    mbsri_linear *linear;
    mbsri_vectors vectors;
    void *of_products;
    bool linearised;

    /* the general elimination */
    mbsri_node *node; /* N + 1 */
    int *listed;      /* numbers of force elements, body after body; then those on every body */
    int every;        /* how many of the latter */
    int first_every;
    int slots;   /* matrices that are in use at once, at most */
    int *pivots; /* size_n */
    double *slot, *store;
    size_t slot_size;
    double *x, *b, *v;        /* of the bodies: size_x, 3 size_v; unknowns: size_n */
    double *wbar;             /* size_v: on the way from r_u to w = L (1 - P) r_u */
    double *rq, *rp, *ru;     /* r in the order of the sweeps; nq, nu, nu */
    double *q0;               /* nq: Cq r_q */
    double *momentum, *range; /* nu: w, (1 - P) r_u */
    double *spare;            /* nq + nu */
    double *work;             /* of one joint */
    double *joint, *body;     /* mbsri_joint_slopes_size, mbsri_body_slopes_size */
    mbsri_slopes slopes;
    mbsri_kept_slopes kept; /* of elements across */
    mbsri_correction correction;
    mbsri_carried carried;
    mbsri_links links;
    bool linked; /* elements across are eliminated with the tree */
    size_t size_x, size_n, store_size;
};

/* Numbers of a body's perturbation, and of its forces (momentum, its rate, and, where deep, the
 * reaction). */
static inline int mbsri_motions(const mbsri_node *node, const mbsri_body *b)
{
    return node->e + (node->deep ? 2 : 1) * b->d;
}

static inline int mbsri_actions(const mbsri_node *node, const mbsri_body *b)
{
    return (node->deep ? 3 : 2) * b->d;
}

#endif
