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

/* What it has of the joint as the caller gives it, and that of it, but for param and option. */
#define MBSRI_JOINT_FIELDS(from)                                                                   \
    .table = (from)->table, .space = (from)->space, .d = (from)->d, .np = (from)->np,              \
    .n = (from)->n, .nq = (from)->nq, .params = (from)->params, .motion = (from)->motion,          \
    .user = (from)->user

/* Bodies, and joint rates, of a group (recursion/group.h) of more than one body. */
enum { MBSRI_GROUP_MOST = 6 };

/* Lengths of the arrays of the data that have numbers of each body, or rate or coordinate of a
 * group. */
typedef struct mbsri_lengths {
    size_t p, v, dd, dp, dn, dg, k, nn, full, rates, coordinates, bodies;
} mbsri_lengths;

/* Where a body stands on another that it is welded to; `angle`: in the plane, where the frame turns
 * about z. */
typedef struct mbsri_stand {
    int host; /* that body: an id, in a finished model an index */
    int next; /* another one on it, from 1 on; 0: none */
    mbsr_frame frame;
    double angle;
} mbsri_stand;

typedef struct mbsri_body {
    int id;        /* the caller's; MBSR_GROUND for the root */
    int parent;    /* index of the predecessor; 0 for the bodies on the root, -1 for the root */
    int d, d_pred; /* velocity coordinates of the body and of its predecessor */
    int welded; /* the first body that is welded to it, from 1 on in the model's `stand`; 0: none */
    bool modal; /* a flexible body on its mount, all modes free: recursion/modal.h */
    bool upright;  /* and with the frame of the marker it is held at: J = [0; -1] in every pose */
    bool factored; /* and its joint block may be in factors: recursion/flexible_factors.h */
    int first_marker, next_marker; /* markers on it, and on its predecessor from it on; 0: none */
    int np;                        /* numbers in the pose */
    int n, nq;                     /* joint velocity and position coordinates */
    int q, u;                      /* places in the caller's vectors q and u, in the order of ids */
    int iq, iu;                    /* places in the data's, in the order of the sweeps */
    size_t pred_p, pred_v, pred_dd; /* the predecessor's offsets, which save a look at its record */
    mbsr_space pred_space;
    size_t p, v;       /* offsets of np and d numbers */
    size_t dd, dp, dn; /* offsets of d x d, d x d_pred and d x n numbers */
    size_t k;          /* offset of K^-1; only bodies without MBSR_JOINT_UNIT_K take room */
    size_t nn;         /* offset of n x n numbers; n is that of its group at the head of one */
    size_t dg;         /* offset of d x n numbers, likewise */
    int head;          /* first body of its group (recursion/group.h), mostly itself */
    int members;       /* of the group it is the head of; 0: none */
    int group_n;       /* joint rates of that, else of its own joint */
    int group_nq;      /* joint coordinates, likewise */
    int at;            /* its place in `member` */
    int ig, igq;       /* places of its rates and coordinates in vectors by groups */
    bool coupled;      /* the sweeps do not take its group apart (assembly/survey.h) */
    bool whole;        /* the sweeps leave it to the steps of recursion/ (assembly/survey.h) */
    bool open;         /* a loop is open past its joint: it closes nearer to the root */
    bool empty;        /* with closures: neither it nor anything behind it has inertia */
    bool light;        /* open, empty, and loops hold it and all behind it */
    bool closes;       /* a loop closes on it */
    bool by_blocks;    /* one of these in Newton systems that not vector code serves */
    bool users;        /* a user's joint that the sweeps take as their own (sweeps/users_joint.h) */
    bool seen;         /* its arrays are read or written by the sweeps too (assembly/places.h) */
    size_t seat;       /* offset of one number */
    mbsri_joint joint;
    mbsr_inertia inertia; /* matrix points into the model */
    size_t name;          /* offset into names */
    bool regular;         /* M is positive definite in every pose */
    const double *added;  /* d x d, part of M in every pose; NULL: none */
    int locks; /* coordinates of `joint` that are held; n and nq count the others. None where what
                  is left is a stock joint, which `joint` is then */
    const double *held;       /* their values, NaN for the others (joint.n); NULL: none */
    const double *given_held; /* values of all that are locked, of the joint as given; NULL: none */
    const double *armature;   /* inertia along each joint rate (n), which D has on its diagonal */
    size_t full;              /* offset of joint.n numbers, where some are held */
    int usual;     /* rank of the joint where the model was looked at (assembly/survey.h), and 1 */
    int neglected; /* its place in the model's `neglected`, and 1; 0: nothing is */
} mbsri_body;

/* A body as added. */
typedef struct mbsri_body_entry {
    int parent;
    size_t name, matrix;
    size_t param; /* offset into matrices */
    mbsri_joint joint;
    mbsr_inertia inertia;
    bool regular;
    size_t added, held, armature; /* offsets into matrices, 0: none */
    int locks;
    bool drops;    /* what acts on locked coordinates is dropped */
    int neglected; /* as in mbsri_body */
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
    int closure;                   /* that it has become, or MBSR_NONE */
    bool resting;                  /* every coordinate that it acts on is locked */
    int given[MBSR_FORCE_OPTIONS]; /* coordinates as given, which def counts without locked ones */
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
    const double *mix; /* held x held, row by row: what the table's position rows are combined by;
                          NULL: not at all. Points into the model */
    int rows, held;    /* velocity rows; the first of them position rows */
    int row, held_row; /* where they begin among those of all closures */
    int bodies, body[MBSR_CLOSURE_BODIES + 1];
    int meets; /* the body where it closes: the nearest common predecessor of its bodies, before
                  those whose joints it reads, where its forces balance, else the root */
    int columns, column[MBSR_CLOSURE_BODIES + 1]; /* of V, then u of each body; -1: none */
    size_t at;                                    /* offset of its rows x columns numbers */
} mbsri_closure;

struct mbsr_model {
    mbsr_allocator allocator;
    mbsr_error error;
    double rank_tolerance;
    mbsr_root root;
    bool finished;

    mbsri_array entries; /* mbsri_body_entry, by id */
    mbsri_array forces;  /* mbsri_force, by id; once finished in the order of the sweeps */
    size_t carried; /* elements behind these, which are not evaluated: closures now, or resting */
    mbsri_array closures;  /* mbsri_closure, by id */
    mbsri_array names;     /* char; offset 0 is the empty name */
    mbsri_array matrices;  /* double */
    mbsri_array lists;     /* int: ids of the bodies of force elements */
    mbsri_array neglected; /* mbsri_neglected */
    mbsri_array given;     /* mbsr_closure_def */

    /* from here on set by finish */
    int bodies;          /* N */
    int live;            /* those that are not welded to others, which come first */
    mbsri_stand *stand;  /* of the others, bodies - live */
    double *joint_param; /* of joints that are not as given */
    int *index;          /* id -> index, N */
    int *list_index;     /* the lists as indices */
    int *u_of;           /* place of each joint rate of the sweeps in the caller's vectors, nu */
    int *q_of;           /* of each joint coordinate, nq */
    bool in_order;       /* both are the identity */
    bool plain_rates;    /* and q' = u in all joints */
    double *armature;    /* of each joint rate in the order of the sweeps, nu; kg m^2 or kg */
    int *member;         /* bodies, group by group, N */
    bool grouped;        /* some group has several */
    double *scale;       /* of joint rates by groups, nu (assembly/survey.h); NULL: not known */
    double *weight; /* of joint rates, for position rows, nu (forms/loops.c); NULL: no closures */
    double length,
        frequency; /* typical of the tree (assembly/measure.h), m and 1/s; 0: not known */
    double mass;   /* of all bodies, kg */
    double *span; /* nq + nu: what turns a body by 1 rad or moves it by the length; NULL: all joints
                     are stock ones */
    struct mbsri_sweeps *sweeps; /* the tree of the sweeps (sweeps/tree.h); NULL with closures */
    struct mbsri_sweeps *whole;  /* the same with whole bodies as blocks; mostly the same tree; with
                                       closures that of Newton systems, loops as blocks */
    struct mbsri_sweeps *evaluated; /* with users' joints among the sweeps' own, too: what
                                     * evaluations run over */
    mbsri_body *body;               /* N + 1 */
    int nq, nu;
    int max_d, max_n, max_force_bodies;
    int anywhere; /* elements that act on no body in particular, which are the first */
    mbsri_coordinate_elements along; /* those on one coordinate, which are the last */
    int rows, held;                  /* of all closures */
    struct mbsri_plan
        *plan; /* in which order loops are eliminated (fronts/plan.h); NULL without closures */
    int max_columns;   /* of one */
    size_t size_c;     /* sum of their rows x columns */
    bool differences;  /* the rates of some joint or inertia are differences of the whole tree */
    size_t size_moved; /* most numbers that those of one body take (recursion/rates.h) */
    int lapack_work;   /* doubles of workspace for dsyev at max_n */
    /* sums over all bodies, the root included: lengths of the arrays */
    size_t size_p, size_v, size_dd, size_dp, size_dn, size_dg, size_k, size_nn, size_full,
        size_rates, size_bodies;
    mbsri_lengths seen; /* the same over the bodies that are seen, which come first */
};

#endif
