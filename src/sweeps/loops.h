/* Loops in the vectorised sweeps: what is carried along the tree until they close.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * As fronts/fronts.h has it, which decides wherever this does not serve: v are the forces of the
 * rows of loops that are open, and the motions behind of joints without inertia. At every body
 *
 *   force = Mbar A + p - Q v            Q^T A + F v = s
 *
 * A joint gives, with X = S^T Q + E (E: what rows read of its rate),
 *
 *   u' = D^-1 (e - U^T A + X^T v),   Q -= U D^-1 X,   F += X^T D^-1 X,   s -= Q^T c + X^T D^-1 e
 *
 * or without inertia u' = w, an unknown more with the row X v = -e. Rows that are complete are
 * eliminated by pivots, Mbar += Q F^-1 Q^T. Rows read accelerations less gravity, as the sweeps
 * have them.
 *
 * Inverse dynamics goes the same way in a tree whose only inertia are units of armature at motors,
 * where e is the joint force that the given u' need, and s = 0: joint forces u' = e + X^T v with
 * least |u'|, and zero without motor. */
#ifndef MBSRI_SWEEPS_LOOPS_H
#define MBSRI_SWEEPS_LOOPS_H

#include "algebra/pivots.h"
#include "sweeps/tree.h"

/* One body of a closure with rigid rows. */
typedef struct mbsri_sweep_loop_end {
    int next;       /* next end at the same body; -1: none */
    int d, n;       /* velocities of the body; rates of its joint where rows read them, else 0 */
    int rows, row;  /* number of rows of the closure, and the first of them among all */
    unsigned rigid; /* bit k: row k is rigid */
    bool coupling;  /* whether the rows read the joint alone */
    size_t C;       /* offset of the rows' columns of the body in the data's closure_C */
} mbsri_sweep_loop_end;

/* Loops of the tree: what they need, known when the model is finished. */
struct mbsri_sweep_loops {
    mbsri_sweep_loop_end *end; /* ends of all closures */
    int *first_end;            /* bodies + 1: first end at each body; -1: none */
    int *closes;               /* rows: body at which each is complete */
    bool springs, joints;      /* whether rows are stiff; whether rows read joint rates */
    double reach;              /* longest distance between neighbours at q = 0, m */
    bool slides;               /* whether that distance changes with q */
    size_t parts, groups;      /* most parts that wait at once, that meet at one body */
    size_t waiting, kept; /* doubles of parts that wait, of records for the way to the leaves */
    size_t doubles;       /* doubles of the data's loop_store */
};

/* Loops that are open behind a body, carried to it; numbers by mbsri_open_at. */
typedef struct mbsri_open_part {
    int body, count; /* the body; unknowns: rows and rates without inertia */
    double *at;      /* mbsri_open_size(count) doubles */
} mbsri_open_part;

/* The numbers of such a part. */
typedef struct mbsri_open {
    int count;
    double *Q, *lengths; /* 8 x count: columns (L, p) of four numbers each; sizes added up in Q */
    double *F, *sizes;   /* count x count: F; sizes added up in F */
    int *id; /* rows, or the model's rows + place of a rate in the order of the sweeps */
} mbsri_open;

static inline mbsri_open mbsri_open_at(const mbsri_open_part *part)
{
    const size_t n = (size_t)part->count;
    double *at = part->at;
    return (mbsri_open){part->count,       at,
                        at + 8 * n,        at + 16 * n,
                        at + (16 + n) * n, (int *)(void *)(at + (16 + 2 * n) * n)};
}

static inline size_t mbsri_open_size(size_t n)
{
    return (16 + 2 * n) * n + (n + 1) / 2;
}

/* For the way to the leaves, of a joint: D^-1 X of joints of several axes off the root, else X (n
 * numbers an unknown), and the unknowns, behind them its own; of loops that close: pivots. */
typedef struct mbsri_open_record {
    struct mbsri_open_record *before;
    int body, count, nulls;
    bool closes;
} mbsri_open_record;

/* One evaluation. */
typedef struct mbsri_loop_run {
    const mbsri_sweep_run *run;
    const mbsri_sweep_loops *loops;
    double lever;            /* longest lever in the mechanism, m */
    double size;             /* size of the right-hand sides of rows */
    double *s, *v;           /* rows + nu: right-hand sides; unknowns */
    double *rest;            /* rows: what is left of each at the end */
    double *share;           /* rows: see algebra/pivots.h */
    mbsri_open_part *part;   /* parts that wait, the last ones at the body that is next */
    int parts;               /* number of these */
    double *room, *top;      /* memory of their numbers; its first free double */
    double *store;           /* first free double of the records */
    mbsri_open_record *last; /* last record */
    int *slot, *set;         /* rows + nu: index of an unknown in a set, -1 outside; the set */
    int *group, *mate;       /* group of each part that meets; next part of the same group */
    double Mbar[36];         /* what loops that close add to Mbar */
    double noise[6];         /* what they add to the size of the errors in Mbar */
    double force[6];         /* what they add to -p */
    bool stuck;              /* whether loops failed last, not a rank */
    const double *motor; /* inverse dynamics: 1 for each joint rate that has one, else 0; or NULL */
} mbsri_loop_run;

/* Plans the loops of an evaluated tree, marks its bodies FRONT and CLOSES. False: no memory;
 * without plan where the sweeps do not serve. */
bool mbsri_sweeps_plan_loops(mbsri_sweeps *tree, const mbsr_model *m);
void mbsri_sweeps_release_loops(const mbsr_model *m, mbsri_sweeps *tree);

/* Memory of the run's data. After kinematics, with what rows ask for in `rest`: what is measured by
 * it. */
void mbsri_open_loops_place(mbsri_loop_run *w, const mbsri_sweep_run *run);
void mbsri_open_loops_begin(mbsri_loop_run *w);

/* Before the sweep to the root: nothing is carried yet. */
void mbsri_open_loops_start(mbsri_loop_run *w);

/* What meets at body i, with the ends of closures there; what goes on becomes one part. Where loops
 * close, *closed and what they add. False: the sweeps do not serve. */
bool mbsri_open_loops_meet(mbsri_loop_run *w, int i, bool *closed);

/* Inverse dynamics of a group of parts, those after `head` by w->mate, at body i: v, and what their
 * loops leave to the joints before it, where joints without motors determine them plainly. */
bool mbsri_open_loops_determine(mbsri_loop_run *w, const mbsri_open_part *part, int head, int i);

/* Room for a record; for one unknown more in the last part. */
void *mbsri_open_loops_keep(mbsri_loop_run *w, int body, size_t size);
mbsri_open mbsri_open_loops_append(mbsri_loop_run *w, int id);

/* The ends at body i become parts; those of couplings of joint coordinates, before its joint, join
 * what is carried past that. */
void mbsri_open_loops_end(mbsri_loop_run *w, int i);
void mbsri_open_loops_couple(mbsri_loop_run *w, int i);

/* Adds what rows read of the rates of joint i to X, n numbers each, and its size to `sizes`. */
void mbsri_open_loops_read_joint(mbsri_loop_run *w, int i, const mbsri_open *open, double *X,
                                 double *sizes);

/* On the way back: what loops at body i read, and the unknowns of those that close there. */
void mbsri_open_loops_read(mbsri_loop_run *w, int i);
void mbsri_open_loops_close(mbsri_loop_run *w, int i);

#endif
