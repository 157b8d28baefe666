/* The Newton solver: its structure, and what its source files share.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Perturbations of a body: of its pose, e numbers (SPATIAL: a small rotation about its origin and
 * the displacement of that origin, along the world's axes; else the np numbers of the pose), of its
 * velocity V and, where needed, of its acceleration A, d numbers each. */
#ifndef MBSRI_NEWTON_H
#define MBSRI_NEWTON_H

#include "../internal.h"

/* ---- derivatives of force elements (force_slopes.c) ---- */

/* Numbers of a perturbation of a body's pose. */
static inline int mbsri_pose_size(const mbsri_body *b)
{
    return mbsri_pose_numbers(b->joint.space, b->np);
}

/* What mbsri_force_slopes works in: one for a model's elements, one at a time. */
typedef struct mbsri_slopes {
    mbsr_force_derivatives out; /* of the last element; its pointers point into the memory below */
    int *row, *column;          /* max_force_bodies */
    double *matrix, *work;
} mbsri_slopes;

/* Doubles and ints that it needs, and where they are given to it. */
void mbsri_slopes_size(const mbsr_model *m, size_t *doubles, size_t *ints);
void mbsri_slopes_place(const mbsr_model *m, mbsri_slopes *s, double *doubles, int *ints);

/* Derivatives of an element at the state of mbsr_velocities, into s->out: its own, or central
 * differences. `body`: the index of the one body it is asked for, for elements that act on every
 * body; else not used. Returns what the element returned, or MBSR_NOT_FINITE, with the data's error
 * set. Leaves f and tau of the data as they were. */
int mbsri_force_slopes(const mbsr_model *m, mbsr_data *d, const mbsri_force *force, int body,
                       mbsri_slopes *s);

/* The forces themselves, in the order of the rows; s->out has these and a matrix of zeros. */
int mbsri_force_values(const mbsr_model *m, mbsr_data *d, const mbsri_force *force, int body,
                       mbsri_slopes *s, double *forces);

/* The derivatives by differences, whatever the element has. */
int mbsri_force_differences(const mbsr_model *m, mbsr_data *d, const mbsri_force *force, int body,
                            mbsri_slopes *s);

/* ---- the solver ---- */

/* A body in the general elimination (factor.c). Its perturbation x counts pose and V, and A where
 * `deep`: in the subtree of a joint whose block is deficient. */
typedef struct mbsri_node {
    int e;            /* numbers of the pose's perturbation */
    bool deep;        /* at the last factorisation; so are rank and unknowns */
    int rank;         /* of its joint */
    int unknowns;     /* du, and u' in the range of D where deep */
    int slot;         /* of its matrix while the elimination goes on */
    int last;         /* its last successor; 0: none */
    int first, count; /* its entries in `listed` */
    size_t x, v;      /* offsets: e + 2 d numbers, max(2 n, nq) numbers */
    size_t store;     /* offset of what is kept of its joint, see mbsri_kept */
} mbsri_node;

/* What is kept of a joint between factoring and solving; matrices by columns. The columns of `x`,
 * `momentum` and `rate` are the predecessor's perturbation, dq, du and, where deep, du'. */
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

struct mbsr_newton {
    const mbsr_model *model;
    mbsr_newton_info info;
    mbsr_error error;
    bool factored, corrected;

    /* the sweeps in vector code; NULL: they do not serve the model, or are not wanted */
    struct mbsri_fast_newton *fast;
    bool by_sweeps;   /* the last factorisation is theirs */
    bool lean;        /* there is no memory for the general elimination */
    size_t fast_size; /* its bytes; 0: none */
    void *fast_block; /* where it was allocated */
    double *motion;   /* 12 (N + 1): perturbations of pose and V of the bodies, where corrected */
    double c;
    void *block, *numbers; /* the memory: doubles and ints; nodes and lists */
    double *solution;      /* the size of y */

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
    mbsri_correction correction;
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

/* Places what is kept of joint i in memory (NULL: none); returns how many doubles it takes at
 * most. */
size_t mbsri_keep(const mbsr_newton *w, int i, double *memory, mbsri_kept *kept);

/* y_pi += B y, the part of the predecessor's forces that does not come from the joint itself. */
void mbsri_pass_action(const mbsri_body *b, const mbsri_kept *kept, bool deep, const double *y,
                       double *below);

/* Doubles of w->work for the largest joint. */
size_t mbsri_tree_work(const mbsr_newton *w);

/* The elimination at the state (t, q, u), for the factor c. */
int mbsri_tree_factor(mbsr_newton *w, mbsr_data *d, double t, const double *q, const double *u,
                      double c);

/* delta from r (NULL: zero; may be delta), and from a change of the forces f (size_v) and tau (nu)
 * at `load` (NULL: none). Leaves the bodies' perturbations in w->x. */
void mbsri_tree_solve(mbsr_newton *w, const double *r, const double *load, double *delta);

/* Whichever elimination was last, as mbsri_tree_solve; and the perturbations of a body's pose and V
 * that it left. */
void mbsri_newton_tree_solve(mbsr_newton *w, const double *r, const double *load, double *delta);
const double *mbsri_newton_motion(const mbsr_newton *w, int i);

/* ---- elements across the tree (correction.c) ---- */

/* How body i stands to body j. APART too where one is the root, which does not move. */
typedef enum mbsri_relation {
    MBSRI_APART,
    MBSRI_SAME,
    MBSRI_BELOW, /* j is the predecessor of i */
    MBSRI_ABOVE  /* i is the predecessor of j */
} mbsri_relation;

mbsri_relation mbsri_relate(const mbsr_model *m, int i, int j);

/* Whether an element may couple what the elimination does not take in: bodies that are apart, and
 * neighbours by more than their f, pose and V and what concerns the successor's joint. */
bool mbsri_may_cross(const mbsr_model *m, const mbsri_force *force);

/* Numbers of the derivatives of an element: rows, and columns. */
void mbsri_slopes_shape(const mbsr_model *m, const mbsri_force *force, int *rows, int *columns);

/* After the tree was factored; MBSR_SINGULAR_BLOCK names the first element. */
int mbsri_correction_factor(mbsr_newton *w, mbsr_data *d);

/* delta may be r. */
void mbsri_correction_solve(mbsr_newton *w, const double *r, double *delta);
#endif
