/* The model: bodies as added, and the finished tree.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Bodies 1 .. `live` are numbered parent before child, in depth-first order; body 0 is the root.
 * Bodies that are welded to others come behind them and have no successors but such: what stands on
 * them is carried over to the body that they are welded to (assembly/welds.h), whose inertia in the
 * sweeps has theirs. Each array of the data (recursion/data.h) is indexed through the offsets
 * below. */
#ifndef MBSRI_RECORD_H
#define MBSRI_RECORD_H

#include "base/memory.h"
#include "forces/coordinate_laws.h"

#include <mbsrank/closure.h>
#include <mbsrank/force.h>
#include <mbsrank/inertia.h>
#include <mbsrank/joint.h>
#include <mbsrank/model.h>

#include <stdbool.h>
#include <stddef.h>

/* A joint as the model keeps it; param points into the model. */
typedef struct mbsri_joint {
    const mbsr_joint_table *table;
    mbsr_space space;
    int d, np, n, nq;
    int params;
    const double *param;
    mbsr_motion_fn motion;
    void *user;
    int option[MBSR_JOINT_OPTIONS];
} mbsri_joint;

/* Fields that mbsr_joint and mbsri_joint have in common, but for param and option. */
#define MBSRI_JOINT_FIELDS(from)                                                                   \
    .table = (from)->table, .space = (from)->space, .d = (from)->d, .np = (from)->np,              \
    .n = (from)->n, .nq = (from)->nq, .params = (from)->params, .motion = (from)->motion,          \
    .user = (from)->user

/* Bodies, and joint rates, of a group (recursion/group.h) of more than one body. */
enum { MBSRI_GROUP_MOST = 6 };

/* Lengths of arrays of the data, by what they have a number of: p of each number of a pose, v of
 * each velocity, dd, dp, dn, dg, k, nn of each entry of such a matrix, rates and coordinates of
 * each of a group, bodies of each body. */
typedef struct mbsri_lengths {
    size_t p, v, dd, dp, dn, dg, k, nn, full, rates, coordinates, bodies;
} mbsri_lengths;

/* A body that is welded to another, its host. */
typedef struct mbsri_stand {
    int host;         /* the host: an id, in a finished model an index */
    int next;         /* next body on the same host, index into `stand` from 1; 0: none */
    mbsr_frame frame; /* frame of the body in that of the host */
    double angle;     /* in the plane: angle of the body against the host, rad */
} mbsri_stand;

/* A body of the finished tree, with its joint. Offsets are into arrays of the data
 * (recursion/data.h) that have numbers of every body. */
typedef struct mbsri_body {
    /* --- the tree */
    int id;     /* id as added; MBSR_GROUND for the root */
    int parent; /* index of the predecessor; 0: on the root; -1: the root itself */
    int welded; /* first body welded to this one, index into the model's `stand` from 1; 0: none */
    int first_marker, next_marker; /* first marker on it; next one on its predecessor; 0: none */
    /* --- sizes, and where its numbers stand */
    int d, d_pred; /* velocity coordinates of the body, of its predecessor */
    int np;        /* numbers in the pose */
    int n, nq;     /* joint velocity and position coordinates, without locked ones */
    int q, u;      /* first index in the caller's vectors q and u, by id */
    int iq, iu;    /* first index in the data's vectors, by order of the sweeps */
    size_t pred_p, pred_v, pred_dd; /* the predecessor's p, v and dd */
    mbsr_space pred_space;          /* space of the predecessor */
    size_t p, v;                    /* offsets of np and d numbers */
    size_t dd, dp, dn;              /* offsets of d x d, d x d_pred and d x n numbers */
    size_t k;                       /* offset of K^-1 (d x d); none with MBSR_JOINT_UNIT_K */
    size_t nn, dg;        /* offsets of n x n and d x n numbers; n: of the group at a head */
    size_t scalar_offset; /* offset of one number */
    size_t full;          /* offset of joint.n numbers, where some are locked */
    /* --- the group whose joints are eliminated as one block (recursion/group.h) */
    int head;     /* first body of the group, mostly the body itself */
    int members;  /* bodies of the group that it is the head of; 0: none */
    int group_n;  /* joint rates of that group, or of the body's own joint */
    int group_nq; /* joint coordinates of that group, or of the body's own joint */
    int at;       /* index in the model's `member` */
    int ig, igq;  /* first index of its rates and coordinates in vectors by groups */
    bool coupled; /* whether the sweeps keep the group in one piece (assembly/survey.h) */
    /* --- what evaluations do with it */
    bool modal;    /* whether it is flexible, on its mount, all modes free: recursion/modal.h */
    bool upright;  /* whether it is modal and J = [0; -1] in every pose */
    bool factored; /* whether its joint block may be in factors: recursion/flexible_factors.h */
    bool whole;    /* whether the steps of recursion/ eliminate it: assembly/survey.h */
    bool spanned_by_loop;  /* whether a loop spans its joint, and closes nearer to the root */
    bool empty;            /* with closures: whether neither it nor a body behind it has inertia */
    bool massless_on_loop; /* whether it is both, and loops determine it and all behind it */
    bool closes;           /* whether a loop closes on it */
    bool by_blocks; /* whether it is on a loop that takes its bodies one by one (sweeps/build.c) */
    bool users;     /* whether its joint is a user's that the sweeps take (sweeps/users_joint.h) */
    bool in_sweeps; /* whether the sweeps read or write its arrays too (assembly/places.h) */
    int surveyed_rank; /* rank of the joint at the position surveyed (assembly/survey.h), plus 1 */
    /* --- joint and inertia */
    mbsri_joint joint;       /* the joint, of which locked coordinates are part */
    mbsr_inertia inertia;    /* the inertia; its matrix points into the model */
    size_t name;             /* offset into names */
    bool regular;            /* whether M is positive definite in every pose */
    const double *added;     /* d x d, part of M in every pose; NULL: none */
    int locks;               /* locked coordinates of `joint`, 0 where a stock joint is left */
    const double *locked_at; /* joint.n values of locked coordinates, NaN for others; NULL: none */
    const double *given_locked_at; /* the same for the joint as given; NULL: none */
    const double *armature;        /* inertia along each joint rate (n), kg m^2 or kg */
    int neglected;                 /* index into the model's `neglected`, plus 1; 0: nothing is */
} mbsri_body;

/* A body as added. */
typedef struct mbsri_body_entry {
    int parent;
    size_t name, matrix;
    size_t param; /* offset into matrices */
    mbsri_joint joint;
    mbsr_inertia inertia;
    bool regular;
    size_t added, locked_at, armature; /* offsets into matrices, 0: none */
    int locks;
    bool drops_locked; /* what acts on locked coordinates is dropped */
    int neglected;     /* as in mbsri_body */
} mbsri_body_entry;

/* What a body's inertia was before parts of it were neglected. */
typedef struct mbsri_neglected {
    int body, parts;    /* id; MBSR_MASS, MBSR_MOMENT */
    mbsr_inertia given; /* matrix: NULL or not */
    size_t matrix;      /* offset into matrices, as in mbsri_body_entry */
    bool regular;
} mbsri_neglected;

typedef struct mbsri_force {
    mbsr_force_def def;            /* name and body_list are not used: see below */
    int id;                        /* the caller's */
    size_t name;                   /* offset into names */
    size_t list;                   /* offset of its def.bodies ids (and, once finished, indices) */
    int closure;                   /* id of the closure that it has become, or MBSR_NONE */
    bool resting;                  /* whether every coordinate that it acts on is locked */
    int given[MBSR_FORCE_OPTIONS]; /* coordinates as given; those of def leave out locked ones */
    size_t memory;                 /* offset of its memory in that of a data object */
    mbsr_force_needs needs;        /* bytes of that, and pairs at most */
} mbsri_force;

/* A closure; its bodies by index, a root that moves behind them where the table asks for it. */
typedef struct mbsri_closure {
    mbsr_closure_def def; /* name is not used: see below */
    size_t name;          /* offset into names */
    int force;            /* the element that it was, by id, or MBSR_NONE */
    int given;            /* index of the definition as given among the model's `given`, from 1 on,
                           * where locked coordinates have changed it; 0: as given */
    size_t mixture;       /* offset of `mix` into matrices, 0: none */
    /* from here on set by finish */
    const double
        *mix; /* T (held x held, row by row): position rows are T times the table's; NULL: 1 */
    int rows, held;    /* number of velocity rows; of position rows, which are the first of them */
    int row, held_row; /* index of the first of each among those of all closures */
    int bodies, body[MBSR_CLOSURE_BODIES + 1]; /* its bodies, by index */
    int meets; /* index of the body where the loop closes: the nearest common predecessor of the
                * bodies where the row's forces balance, else the root */
    int columns,
        column[MBSR_CLOSURE_BODIES + 1]; /* first column of each body: V, then u; -1: none */
    size_t at;                           /* offset of its rows x columns numbers */
} mbsri_closure;

struct mbsr_model {
    mbsr_allocator allocator;
    mbsr_error error;
    double rank_tolerance;
    mbsr_root root;
    bool finished;

    mbsri_array entries; /* mbsri_body_entry, by id */
    mbsri_array forces;  /* mbsri_force, by id; once finished in the order of the sweeps */
    size_t carried; /* force elements at the end that are not evaluated: now closures, or resting */
    mbsri_array closures;  /* mbsri_closure, by id */
    mbsri_array names;     /* char; offset 0 is the empty name */
    mbsri_array matrices;  /* double */
    mbsri_array lists;     /* int: ids of the bodies of force elements */
    mbsri_array neglected; /* mbsri_neglected */
    mbsri_array given;     /* mbsr_closure_def */
    mbsri_array tables;    /* mbsr_table *, those that are the model's own */

    /* from here on set by finish */
    int bodies;          /* N */
    int live;            /* number of bodies that are not welded to others; they come first */
    mbsri_stand *stand;  /* the welded bodies, bodies - live */
    double *joint_param; /* parameters of joints that locks have changed */
    int *index;          /* N: index of the body of each id */
    int *list_index;     /* `lists` with indices in the place of ids */
    int *u_of;           /* nu: index in the caller's u of each rate in the order of the sweeps */
    int *q_of;           /* nq: index in the caller's q of each coordinate likewise */
    bool in_order;       /* whether u_of and q_of are the identity */
    bool plain_rates;    /* whether they are, and q' = u in all joints */
    double *armature;    /* nu: armature of each rate in the order of the sweeps, kg m^2 or kg */
    int *member;         /* bodies, group by group, N */
    bool grouped;        /* whether some group has several bodies */
    double *
        scale; /* nu: inertia scale of each joint rate, by groups (assembly/survey.h); NULL: none */
    double *weight; /* nu: weight of position rows at each joint rate (forms/loops.c); NULL: none */
    double length;  /* length typical of the tree, m (assembly/measure.h); 0: not known */
    double frequency; /* frequency typical of the tree, 1/s; 0: not known */
    double mass;      /* mass of all bodies, kg */
    double *span;     /* nq + nu: change of a coordinate that turns its body by 1 rad or moves it by
                       * the length; NULL: all joints are stock ones */
    struct mbsri_sweeps *sweeps; /* the tree of the sweeps (sweeps/tree.h); NULL with closures */
    struct mbsri_sweeps *whole; /* tree with `whole` bodies, and with closures loops, as blocks: for
                                 * Newton systems; mostly the same as `sweeps` */
    struct mbsri_sweeps *evaluated; /* tree of evaluations: users' joints are the sweeps' own */
    mbsri_body *body;               /* N + 1 */
    int nq, nu;
    int max_d, max_n, max_force_bodies;
    size_t size_force_memory; /* bytes of all elements in a data object */
    int max_pairs, pairs;     /* most of one element by pairs; of all such elements together */
    int anywhere;             /* number of elements that act on every body; they come first */
    mbsri_coordinate_elements along; /* elements on one coordinate, which come last */
    int rows, held;                  /* velocity and position rows of all closures */
    struct mbsri_plan *plan; /* order in which loops are eliminated (fronts/plan.h); NULL: none */
    int max_columns;         /* largest number of columns of a closure */
    size_t size_c;           /* rows x columns, summed over the closures */
    bool differences;  /* whether rates of some joint or inertia are differences of the tree */
    size_t size_moved; /* most numbers that such differences of one body take */
    int lapack_work;   /* doubles of workspace for dsyev at max_n */
    /* sums over all bodies, the root included: lengths of the arrays */
    size_t size_p, size_v, size_dd, size_dp, size_dn, size_dg, size_k, size_nn, size_full,
        size_rates, size_bodies;
    mbsri_lengths in_sweeps; /* the same sums over the bodies in the sweeps, which come first */
};

#endif
