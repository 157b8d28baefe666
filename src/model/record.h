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
enum { MBSRI_GROUP_MOST = 12 };

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

/* Bodies whose joints are eliminated as one block (recursion/group.h), as each of them has it; most
 * bodies are a group of their own. */
typedef struct mbsri_grouping {
    int head;    /* first body of the group */
    int members; /* number of its bodies at the head; 0 at others */
    int n, nq;   /* joint rates and coordinates: of the group at the head, of the joint at others */
    int at;      /* index in the model's `order.member` */
    int iu, iq;  /* first index of the own rates and coordinates in vectors by groups */
    bool coupled; /* whether the sweeps keep the group in one piece (assembly/survey.h) */
} mbsri_grouping;

/* A body of the finished tree, with its joint. Offsets are into arrays of the data
 * (recursion/data.h) that have numbers of every body. */
typedef struct mbsri_body {
    /* --- the tree */
    int id;     /* id as added; MBSR_GROUND for the root */
    int parent; /* index of the predecessor; 0: on the root; -1: the root itself */
    struct {
        int welded; /* first body welded to this one, index into the model's `stand` from 1; 0: none
                     */
        int first, next; /* index of the first body mounted here at a marker; of the next one on the
                          * same predecessor; 0: none */
    } on;
    /* --- sizes, and where its numbers stand */
    int d;                /* velocity coordinates */
    int np;               /* numbers in the pose */
    int n, nq;            /* joint velocity and position coordinates, without locked ones */
    int q, u;             /* first index in the caller's vectors q and u, by id */
    int iq, iu;           /* first index in the data's vectors, by order of the sweeps */
    size_t p, v;          /* offsets of np and d numbers */
    size_t dd, dp, dn;    /* offsets of d x d, d x pred.d and d x n numbers */
    size_t k;             /* offset of K^-1 (d x d); none with MBSR_JOINT_UNIT_K */
    size_t nn, dg;        /* offsets of n x n and d x n numbers; n: of the group at a head */
    size_t scalar_offset; /* offset into arrays with one number a body */
    struct {
        mbsr_space space; /* space of the predecessor */
        int d;            /* its velocity coordinates */
        size_t p, v, dd;  /* its offsets of these names */
    } pred;
    mbsri_grouping group; /* the group that its joint is eliminated with */
    /* --- what evaluations do with it */
    struct {
        bool modal;    /* whether it is flexible, on its mount, all modes free: recursion/modal.h */
        bool upright;  /* whether it is modal and J = [0; -1] in every pose */
        bool factored; /* whether its joint block may be in factors: recursion/flexible_factors.h */
    } flexible;
    struct {
        bool spans;     /* whether a loop spans its joint, and closes nearer to the root */
        bool empty;     /* with closures: whether neither it nor a body behind it has inertia */
        bool massless;  /* whether it spans and is empty, and rows of loops hold all its rates */
        bool closes;    /* whether a loop closes on it */
        bool by_blocks; /* whether vector code passes its loop body by body (sweeps/build.c) */
    } loop;
    struct {
        bool whole; /* whether the steps of recursion/ eliminate it */
        bool users; /* whether its joint is a user's that the sweeps take (sweeps/users_joint.h) */
        bool in_sweeps; /* whether the sweeps read or write its arrays too (assembly/places.h) */
        int rank;       /* rank of the joint at the surveyed position, plus 1; 0: not clear there */
    } survey;           /* assembly/survey.h */
    /* --- joint and inertia */
    mbsri_joint joint;    /* the joint, of which locked coordinates are part */
    mbsr_inertia inertia; /* the inertia; its matrix points into the model */
    size_t name;          /* offset into names */
    struct {
        bool regular;           /* whether M is positive definite in every pose */
        const double *added;    /* d x d, part of M in every pose; NULL: none */
        int neglected;          /* index into the model's `given.inertias`, plus 1; 0: nothing is */
        const double *armature; /* inertia along each joint rate (n), kg m^2 or kg */
    } mass;
    struct {
        int count;              /* locked coordinates of `joint`, 0 where a stock joint is left */
        const double *at;       /* joint.n values of locked coordinates, NaN for others, or NULL */
        const double *given_at; /* the same for the joint as given, or NULL */
        size_t full;            /* offset of joint.n numbers, where some are locked */
    } lock;
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
    int given;            /* index of the definition as given among the model's `given.closures`,
                           * from 1 on, where locked coordinates have changed it; 0: as given */
    size_t mixture;       /* offset of `mix` into matrices, 0: none */
    /* from here on set by finish */
    const double *mix; /* T (square, row by row): position rows are T times the table's; NULL: 1 */
    int rows, position_rows; /* number of velocity rows; of position rows, the first of them */
    int row, position_row;   /* index of the first of each among those of all closures */
    int bodies, body[MBSR_CLOSURE_BODIES + 1]; /* its bodies, by index */
    int meets; /* index of the body where the loop closes: the nearest common predecessor of the
                * bodies where the row's forces balance, else the root */
    int columns,
        column[MBSR_CLOSURE_BODIES + 1]; /* first column of each body: V, then u; -1: none */
    size_t at;                           /* offset of its rows x columns numbers */
} mbsri_closure;

/* Orders of a finished model: of the sweeps, in which the data's vectors are; by groups. */
typedef struct mbsri_orders {
    int *u_of;        /* nu: index in the caller's u of each rate in the order of the sweeps */
    int *q_of;        /* nq: index in the caller's q of each coordinate likewise */
    bool as_given;    /* whether u_of and q_of are the identity */
    bool plain_rates; /* whether they are, and q' = u in all joints */
    int *member;      /* bodies, group by group, N */
    bool grouped;     /* whether some group has several bodies */
} mbsri_orders;

/* Scales of a model, by which numbers of different units are compared. */
typedef struct mbsri_scales {
    double *inertia;  /* nu: inertia of each joint rate, by groups (assembly/survey.h), or NULL */
    double *weight;   /* nu: weight of position rows at each rate (forms/loops.c), or NULL */
    double *span;     /* nq + nu: change of a coordinate that turns its body by 1 rad or moves it by
                       * the length; NULL: all joints are stock ones */
    double length;    /* length of the tree, m (assembly/measure.h); 0: not known */
    double frequency; /* frequency of the tree, 1/s; 0: not known */
    double mass;      /* mass of all bodies, kg */
} mbsri_scales;

/* Trees of the vector code (sweeps/tree.h); NULL: the sweeps do not serve. */
typedef struct mbsri_trees {
    struct mbsri_sweeps *plain;  /* all bodies in vector code that can be; NULL with closures */
    struct mbsri_sweeps *newton; /* of Newton systems: `whole` bodies, and with closures loops, as
                                  * blocks; mostly the same as `plain` */
    struct mbsri_sweeps *evaluated; /* of evaluations: users' joints are the sweeps' own */
} mbsri_trees;

/* Force elements of a finished model beside their list. */
typedef struct mbsri_elements {
    size_t idle;   /* elements at the end that are not evaluated: closures now, or resting */
    size_t memory; /* bytes that all want in a data object */
    int pairs;     /* most pairs of all elements by pairs together */
    int anywhere;  /* elements that act on every body; they come first */
    mbsri_coordinate_elements along; /* elements on one coordinate, which come last */
} mbsri_elements;

/* Largest numbers of one body, joint, element or closure, by which scratch is sized. */
typedef struct mbsri_maxima {
    int d;              /* velocity coordinates of a body, or joint rates of a group */
    int n;              /* joint rates of a group */
    int element_bodies; /* bodies of a force element */
    int pairs;          /* pairs of an element by pairs */
    int columns;        /* columns of a closure */
    size_t displaced;   /* numbers that differences of the tree take for one body */
    int lapack_work;    /* doubles of workspace for dsyev at n */
} mbsri_maxima;

struct mbsr_model {
    mbsr_allocator allocator;
    mbsr_error error;
    double rank_tolerance;
    mbsr_root root;
    bool finished;

    mbsri_array entries;  /* mbsri_body_entry, by id */
    mbsri_array forces;   /* mbsri_force, by id; once finished in the order of the sweeps */
    mbsri_array closures; /* mbsri_closure, by id */
    struct {
        mbsri_array names;    /* char; offset 0 is the empty name */
        mbsri_array matrices; /* double */
        mbsri_array lists;    /* int: ids of the bodies of force elements */
        int *list_index;      /* `lists` with indices in the place of ids, set by finish */
        double *joint_param;  /* parameters of joints that locks have changed, likewise */
        mbsri_array tables;   /* mbsr_table *, those that are the model's own */
    } stored;
    struct {
        mbsri_array inertias; /* mbsri_neglected */
        mbsri_array closures; /* mbsr_closure_def, before locked coordinates changed them */
    } given;

    /* from here on set by finish */
    int bodies;         /* N */
    int live;           /* number of bodies that are not welded to others; they come first */
    mbsri_body *body;   /* N + 1 */
    mbsri_stand *stand; /* the welded bodies, bodies - live */
    int *index;         /* N: index of the body of each id */
    int nq, nu;         /* position and velocity coordinates of all joints, locked ones left out */
    double *armature;   /* nu: armature of each rate in the order of the sweeps, kg m^2 or kg */
    mbsri_orders order;
    mbsri_scales typical;
    mbsri_trees tree;
    mbsri_elements elements;
    int rows, position_rows; /* velocity and position rows of all closures */
    size_t size_c;           /* rows x columns, summed over the closures */
    struct mbsri_plan *plan; /* order in which loops are eliminated (fronts/plan.h); NULL: none */
    bool differences; /* whether rates of some joint or inertia are differences of the tree */
    mbsri_maxima most;
    mbsri_lengths size;      /* lengths of arrays over all bodies, the root included */
    mbsri_lengths in_sweeps; /* the same over the bodies in the sweeps, which come first */
};

#endif
