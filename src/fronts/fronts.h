/* Equations of motion with loops, eliminated front by front in the order of a plan.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   M x - C^T lambda = g,    C x = b          with the rows of C that are not left out
 *
 * A front is a symmetric matrix over unknowns: lambda of loops, rates that move no mass, and
 * motions a of bodies,
 *
 *   row of lambda or of a rate   F v + Q^T a = s          reaction of a body
 *       mu = Q v - Mbar a - s
 *
 * A step takes the fronts that have its body's motion, or its closure's lambda, adds the ends of
 * closures there, and eliminates what is complete by symmetric pivots (algebra/pivots.h). Passing
 * the joint of a body, a = -(H a_pred + J x), gives
 *
 *   x = D^+ (e - U^T H a_pred - X v) + N w,   X = J^T Q - E,    Q_pred = -H^T (Q - G X),
 *       F += X^T D^+ X,
 *
 * where v is all else that the front has, motions of other bodies too, E is what the rows read of x
 * itself and N spans the null space of D: w joins v, its row says that forces along N balance, -N^T
 * X v = -N^T e. The inertia of plain subtrees goes from body to body without fronts.
 *
 * What turns out to be zero but for rounding is left out: rows that depend on others, whose lambda
 * have the least norm (idle.h); and motions that nothing determines (`free`). */
#ifndef MBSRI_FRONTS_FRONTS_H
#define MBSRI_FRONTS_FRONTS_H

#include "fronts/names.h"
#include "recursion/data.h"

/* One evaluation. Unknowns by number: rows, then joint rates by their places in the order of the
 * sweeps, then motions of bodies, body after body (size_v). */
typedef struct mbsri_fronts {
    const mbsr_model *m;
    mbsr_data *d;
    const mbsri_plan *plan;
    mbsri_plan *own_plan;       /* where that of the model does not serve */
    mbsri_part **part;          /* steps: left by each, until it is taken; NULL: nothing */
    mbsri_pivots front;         /* of the step at work */
    int room;                   /* unknowns that it may have */
    bool planned;               /* its unknowns are as in the plan */
    mbsri_pivots **pivots;      /* steps: names of a front, and L; NULL: there is none */
    mbsri_passing **passing;    /* steps; NULL: nothing passes */
    bool *left_out;             /* rows: without a part in the equations; stiff ones at first */
    const double *compliance;   /* rows: P in C x + P lambda = b; NULL: zero */
    int *slot, *set;            /* unknowns: place in the list at work, -1: none; that list */
    double *s, *v;              /* unknowns: right-hand sides, solution */
    double *e;                  /* nu: joint forces, then rates */
    double *share;              /* rows: scale of its lambda in norms (algebra/pivots.h) */
    double lever;               /* the longest lever of the mechanism, m */
    int *free, frees;           /* joint rates that have most of motions nothing determines */
    struct mbsri_idle *idle;    /* of redundant rows (idle.h); NULL: none that matters */
    struct mbsri_chunk *chunks; /* blocks of memory, the last first */
    struct mbsri_chunk *kept;   /* the last one that had been taken from before a factorisation */
    size_t kept_bytes;          /* bytes of it in use then */
    void *unused[96];           /* free lists of parts, by size */
    double *scratch;
    size_t scratch_size;
} mbsri_fronts;

/* Takes memory that the data has for it, and from the model's allocator where unknowns are late and
 * that is not enough, or others are open; mbsri_fronts_close gives it back, after a failure too.
 * `far`: the inertia of bodies, or armature of all joints, counts (choose.h). */
int mbsri_fronts_open(mbsri_fronts *w, const mbsr_model *m, mbsr_data *d, bool far,
                      const char *function);
void mbsri_fronts_close(mbsri_fronts *w);

/* The memory that an evaluation takes from the data of a finished model, in bytes. */
size_t mbsri_fronts_bytes(const mbsr_model *m);

/* Memory for the factors, and for a short time (numbers, until the next call): NULL where there is
 * none. A part of so many unknowns, and its end. Room for a front of so many. */
void *mbsri_fronts_allocate(mbsri_fronts *w, size_t size);
double *mbsri_fronts_scratch(mbsri_fronts *w, size_t numbers);
mbsri_part *mbsri_fronts_open_part(mbsri_fronts *w, int count);
void mbsri_fronts_close_part(mbsri_fronts *w, mbsri_part *part);
bool mbsri_fronts_make_room(mbsri_fronts *w, int unknowns);

/* What a factorisation before took is free again, with all that was allocated since. */
bool mbsri_fronts_begin(mbsri_fronts *w);

/* At the positions of the data, after the derivatives of the closures. Overwrites Mbar, D and what
 * belongs to them. `armature` (nu, in the order of the sweeps): of joints without other masses;
 * NULL: M is the mass matrix of the tree. */
int mbsri_fronts_factor(mbsri_fronts *w, const double *armature, const char *function);

/* x (nu, by the caller's order) and lambda (rows, zero in those left out), from g (nu, likewise)
 * and b (rows). */
void mbsri_fronts_solve(mbsri_fronts *w, const double *g, const double *b, double *x,
                        double *lambda);

/* x (nu, in the order of the sweeps) becomes what of it the equations do not determine, x - y where
 * K y = K x. work: 2 nu + rows + 2 size_v. */
void mbsri_fronts_leave_free(mbsri_fronts *w, double *x, double *work);

/* Step k on the way back, where s has what is left of the right-hand sides, e joint forces, and v
 * what its front leaves: the rates of its joint into e, with `work` of n; motion of its body and
 * unknowns that it has eliminated into v. */
void mbsri_fronts_rates(mbsri_fronts *w, int k, double *work);
void mbsri_fronts_move(mbsri_fronts *w, int k);

/* Of one front: s less what its pivots take of it, that of motions too; v of its pivots, where the
 * others are there. */
void mbsri_fronts_reduce(const mbsri_pivots *f, double *s);
void mbsri_fronts_substitute(const mbsri_pivots *f, const double *s, double *v);

/* A motion that has most of joint rate `rate` (in the order of the sweeps), which nothing
 * determines. */
static inline void mbsri_fronts_note_free(mbsri_fronts *w, int rate)
{
    w->free[w->frees++] = rate;
}

/* The joint rate (place in the caller's u) that has most of a motion that nothing determines; there
 * is one. */
int mbsri_fronts_free_rate(const mbsri_fronts *w);

/* N (n): column l of the null space of the D of body i; its largest number is 1, whatever rounding
 * there is in D. */
void mbsri_fronts_null_column(const mbsri_fronts *w, int i, int l, double *N);

/* x (nu, in the order of the sweeps): rates of one joint that move no mass there, those of motion l
 * of the `frees`; what the equations do not determine of x is such a motion. */
void mbsri_fronts_free_seed(const mbsri_fronts *w, int l, double *x);

/* The number of the first unknown that is a rate; that is a motion of body i. */
static inline int mbsri_rate_number(const mbsri_fronts *w, const mbsri_body *b)
{
    return w->m->rows + b->iu;
}

static inline int mbsri_motion_number(const mbsri_fronts *w, const mbsri_body *b)
{
    return mbsri_motion_name(w->m, b);
}

#endif
