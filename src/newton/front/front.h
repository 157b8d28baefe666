/* The Newton system of the momentum form by elimination, for any kind of model.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Columns and rows have numbers. Columns: x of a body, dq, du and du' of its joint, u' in the range
 * of a D, multipliers. Rows: y of a body (impulse, its rate, reaction), with the loads kappa that
 * eta exerts on it; loads tau and pushes of eta on a joint; q', (a) and (b) of a joint, (a) in the
 * range of D; rows of closures. */
#ifndef MBSRI_NEWTON_FRONT_H
#define MBSRI_NEWTON_FRONT_H

#include "newton/front/plan.h"
#include "newton/linear/product.h"

/* What a row or column is that is an equation or unknown. Those of one kind go together, own ones
 * with lambda too; rows and columns that are pending wait for the head of their group. */
typedef enum mbsri_front_kind {
    MBSRI_FRONT_NONE,
    MBSRI_FRONT_PLACE,  /* q' and dq */
    MBSRI_FRONT_OWN,    /* (a), (b); du, u' */
    MBSRI_FRONT_LAMBDA, /* velocity rows */
    MBSRI_FRONT_ETA,    /* position rows */
    MBSRI_FRONT_PENDING
} mbsri_front_kind;

/* Where the numbers of a body begin. */
typedef struct mbsri_front_names {
    int x, q, u, rates, range;                        /* columns; rates: u' of the joint */
    int y, kappa, tau, push, place, a, b, range_of_a; /* rows; and d(M u), and dp' but for c dp */
    int momentum, rate;
} mbsri_front_names;

/* What is left of a step: the numbers of its rows and columns, eliminated ones first. `plain`: it
 * is y of the predecessor over its x. */
typedef struct mbsri_front_left {
    int done, rows, columns, carried;
    bool plain;
} mbsri_front_left;

/* Rows or columns of all fronts, by number. */
typedef struct mbsri_front_numbers {
    int count;
    int *owner; /* the body, or -1 - closure */
    unsigned char *kind;
    int *at; /* its place in the present front */
} mbsri_front_numbers;

/* Memory that plans are made in, one after the other. */
typedef struct mbsri_front_arena {
    unsigned char *memory; /* NULL: the one plan is made once, by the model's allocator */
    size_t size, used;
} mbsri_front_arena;

typedef struct mbsri_front {
    const mbsr_model *model;
    mbsri_front_arena *arena;        /* of a model with elements by pairs; else NULL */
    struct mbsri_front_crowd *crowd; /* of pairs apart (crowd.h); NULL: all are eliminated */
    mbsri_acting *planned;           /* the pairs that its plan is for */
    int planned_count;
    bool *served; /* N + 1: bodies that it passes; NULL: all */
    mbsri_linear *linear;
    mbsri_front_plan plan;
    mbsri_vectors vectors;
    double c;
    mbsri_front_names *names; /* N + 1 */
    mbsri_front_numbers rows, columns;
    int multipliers;        /* number of the first multiplier, as row and as column */
    mbsri_front_left *left; /* by step */
    int *numbers;           /* of rows, then columns, of the steps */
    double *LU, *matrices;
    struct {
        int *row, *column; /* numbers of its rows and columns */
        double *M, *N;     /* its matrix, and what was added up in its entries */
        double *row_scale, *column_scale, *largest;
    } now;                           /* the present front */
    struct mbsri_floating *floating; /* of bodies that float (floating.h); NULL: none does */
    double *value, *h;               /* by number: the solution; right-hand sides */
    double *local;                   /* of one step */
    double *rates;                   /* 4 nu: L (1 - P) r_u, then scratch */
    double *wbar;                    /* size_v: part of w of the successors, as an impulse */
    double *left_over;               /* 2 size: residual, correction of a refinement */
    void *memory;
    unsigned char *of_plan; /* part of `memory` whose size the plan determines */
    size_t room, bytes;     /* bytes of that part, and of all */
} mbsri_front;

/* What a text of MBSR_SINGULAR_BLOCK says of a joint. */
#define MBSRI_SINGULAR_ADVICE                                                                      \
    "nothing determines its rates: give it inertia, a spring or a damper, or lock it "             \
    "(mbsr_index_report_create names all such directions)"

/* served: see plan.h. together: of bodies that elements by pairs tie, how many are eliminated
 * together at most; 0: all; error: what solutions leave of the forces in pairs apart beside their
 * size. transposes: it solves transposed systems, and leaves no pairs apart. NULL: there is no
 * memory. */
mbsri_front *mbsri_front_create(const mbsr_model *m, const bool *served, int together, double error,
                                bool transposes);
void mbsri_front_destroy(mbsri_front *f);

/* The plan of the pairs that act, as the linearised equations have them. A status, with a text in
 * the data. */
int mbsri_front_replan(mbsri_front *f, mbsr_data *d);

/* Linearises and eliminates at the state (t, y), with the loop forces of y', for the factor c. A
 * status, with a text in the data. */
int mbsri_front_factor(mbsri_front *f, mbsr_data *d, double t, const double *y, const double *yp,
                       double c);

/* MBSR_LOOP_SINGULAR: a row of a closure depends on others. */
int mbsri_front_refuse_row(const mbsr_model *m, mbsr_data *d, int closure, int row);

/* Solves for delta with right-hand side r, which do not overlap; false: loads of pairs apart did
 * not converge. */
bool mbsri_front_solve(mbsri_front *f, const double *r, double *delta);

/* Whether the last factorisation has left pairs apart, for which a solution iterates. */
bool mbsri_front_iterates(const mbsri_front *f);

/* Iterations of all solutions so far. */
long mbsri_front_iterations(const mbsri_front *f);

/* Whether step k takes in nothing and leaves nothing: all of its body is found at once. */
static inline bool mbsri_front_is_alone(const mbsri_front *f, int k)
{
    return f->plan.step[k].borders == 0 && f->plan.step[k].children == 0;
}

/* Both sweeps of a solution: unknowns, and the motion of bodies, in f->value. */
void mbsri_front_sweep(mbsri_front *f, const double *r);

/* ---- body by body ---- */

/* The same of one body that is served, after its successors: the data has all of it, and ranks are
 * marked. What it leaves to a predecessor, y over x, stands in the matrix of its step. A status. */
int mbsri_front_pass_body(mbsri_front *f, mbsr_data *d, int i);

static inline double *mbsri_front_matrix(const mbsri_front *f, int i)
{
    return f->matrices + f->plan.step[f->plan.position[i]].matrix;
}

/* Says that what body i, which is not served, leaves to its predecessor stands there. */
void mbsri_front_hand_on(mbsri_front *f, int i);

/* A solution: before the first body; past body i, leaves to root, of a group with its head; back,
 * after the predecessor; and delta of the bodies. On the way the right-hand sides of y of a body,
 * and w, stand in h and wbar; its motion in value. */
void mbsri_front_start(mbsri_front *f);
void mbsri_front_reduce(mbsri_front *f, int i, const double *r);
void mbsri_front_substitute(mbsri_front *f, int i);
void mbsri_front_finish(mbsri_front *f, double *delta);

#endif
