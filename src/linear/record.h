/* Linear equations about a state: what the object holds.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_LINEAR_RECORD_H
#define MBSRI_LINEAR_RECORD_H

#include "files/arena.h"

#include <mbsrank/linear.h>

#include <stdbool.h>

struct mbsr_linear {
    mbsri_arena arena;
    mbsr_linear_info info;
    int nu, closure_rows, inputs, outputs; /* closure_rows: velocity rows */
    double *part[MBSR_LINEAR_PARTS];
    int rows[MBSR_LINEAR_PARTS], columns[MBSR_LINEAR_PARTS];
    double *shapes;  /* nu x states: dq of z */
    double *output;  /* outputs x size: y of x */
    double *direct;  /* outputs x inputs: y of w at x */
    mbsr_mode *mode; /* once they have been asked for */
    int modes;
    double *vectors; /* states x states: of the modes, real parts and imaginary parts of pairs in
                        two columns */
    int *column;     /* of each mode */
};

/* Joint rates in the place of changes of q, at a state. */
typedef struct mbsri_coordinates {
    const mbsr_model *model;
    mbsr_data *data;
    double t;
    int nq, nu, bodies, size; /* size: of y */
    int rows;                 /* of the pencil, with value and rate of motions that are inputs */
    double *G, *left,
        *turning; /* of each body from `at` on: G (nq x n), G^+ (n x nq), G^+ G' (n x n) */
    int *at;
    int (*joint)[4]; /* of each body: first coordinate, how many; first rate, how many */
} mbsri_coordinates;

void mbsri_coordinates_of(mbsri_coordinates *c, const mbsr_model *model, mbsr_data *data, double t);

/* G, G^+ and G^+ G' along q', in memory of the arena. A status of the data. */
int mbsri_coordinates_find(mbsri_coordinates *c, mbsri_arena *arena, const double *q,
                           const double *qdot);

/* dq (nq) = G x; x (nu) = G^+ dq. */
void mbsri_coordinates_lift(const mbsri_coordinates *c, const double *x, double *dq);
void mbsri_coordinates_take(const mbsri_coordinates *c, const double *dq, double *x);

/* A consistent state y, yp at q and u (NULL: zero), in memory of the arena. A status, with
 * `function` in the text. */
int mbsri_pencil_start(const mbsr_model *model, mbsr_data *data, double t, const double *q,
                       const double *u, const char *function, mbsri_arena *arena, double **y,
                       double **yp, mbsr_error *error);

mbsr_mode mbsri_mode_of(double real, double imaginary, double shift);

/* E, A and B in the coordinates dq, dp, du, forces, which *c becomes; Newton's matrices by
 * products. A status. */
int mbsri_pencil_assemble(mbsr_linear *l, mbsri_coordinates *c, const mbsr_model *model,
                          mbsr_data *data, double t, const double *y, const double *yp,
                          const mbsr_linear_opt *opt, mbsr_error *error);

/* Columns of B, `seen` and `direct` of signals that are no joint forces; before that
 * the rows of the pencil: r (size of y) times `factor`. A status. */
void mbsri_pencil_rows(const mbsri_coordinates *c, const double *r, double factor, double *to);
int mbsri_signals_enter(mbsr_linear *l, const mbsri_coordinates *c, const double *y,
                        const double *yp, const mbsr_linear_opt *opt, mbsr_error *error);

/* Motions among the signals: whether one is, how many a joint or closure has, and the columns of
 * input j, with its two states from `at` on; r: 2 numbers for each of y. A status. */
static inline bool mbsri_is_motion(const mbsr_signal *s)
{
    return s->kind == MBSR_SIGNAL_MOTION || s->kind == MBSR_SIGNAL_CLOSURE_MOTION;
}

int mbsri_motions_of(const mbsr_model *m, mbsr_signal_kind kind, int id);
int mbsri_motion_enter(mbsr_linear *l, const mbsri_coordinates *c, const double *y,
                       const double *yp, const mbsr_linear_opt *opt, int j, int at, double *r,
                       mbsr_error *error);

/* The body at a place of an element's list; MBSR_GROUND also where there is no such place. And one
 * number of what it exerts there; the data is at velocities. A status. */
int mbsri_body_of_force(const mbsr_model *m, int force, int place);
int mbsri_sample_force(const mbsr_model *m, mbsr_data *d, const mbsr_signal *s, double *value);

/* Whether these exist in the model. A status. */
int mbsri_signals_check(const mbsr_model *model, const mbsr_linear_opt *opt, mbsr_error *error);

/* Ar, Br, Cr, Dr from these; rank: of the mass matrix M of the tree (nu x nu); mass: of rates
 * (mbsr_momentum_scales); typical: rate of the model, 0 for none. A status. */
int mbsri_pencil_reduce(mbsr_linear *l, int rank, const double *mass, const double *M,
                        double typical, mbsr_error *error);

#endif
