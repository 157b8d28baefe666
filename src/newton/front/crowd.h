/* Pairs that the elimination leaves out: iterations for the forces in them.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Bodies that touch in all directions fill the fronts behind them. Where more bodies hang together
 * than are to be eliminated together, pairs that load no joints are apart: a step takes in what a
 * body feels in such a pair by its own motion, and the rest of it, forces F = E x on each of the
 * two by the motion x of the other, is a load. With x = x0 + S F as both sweeps of a solution have
 * it, (1 - E S) F = E x0 is solved by GMRES, at a cost that grows as bodies and pairs. Where all
 * bodies are alone, E S is a small matrix for each pair. */
#ifndef MBSRI_FRONT_CROWD_H
#define MBSRI_FRONT_CROWD_H

#include "newton/front/front.h"

typedef struct mbsri_front_crowd {
    int together;         /* the most bodies that are eliminated together */
    double error;         /* what iterations leave of the loads beside their size */
    int count;            /* of pairs apart */
    bool *apart;          /* by pair */
    int *order;           /* of these, by the first of their bodies */
    int *group, *size;    /* N + 1: the next body towards the head of its group; its size there */
    size_t block, answer; /* lengths of a block and an answer */
    double *blocks;   /* by pair: forces on the second by the first, on the first by the second */
    bool alone;       /* whether each body floats and is: no step has borders or children */
    double *motions;  /* then, by body: its motion by forces on it; */
    double *answers;  /* by pair: blocks times the former */
    double *weight;   /* size_v: of forces in norms, inverse masses */
    double *loads;    /* size_v: those of the next sweep */
    double *solution; /* size_v: z, F = P z */
    double *given;    /* size_v: E x0 */
    double *zero;     /* a right-hand side of zeros */
    double *basis, *hessenberg, *rotation, *projected;
    long iterations; /* of all solutions */
    int rest;        /* plans that are still to be whole, after one that did not do */
    void *memory;
    size_t bytes;
} mbsri_front_crowd;

/* For fronts of a model with elements by pairs. NULL: there is no memory. */
mbsri_front_crowd *mbsri_front_crowd_create(const mbsr_model *m, int together, double error);
void mbsri_front_crowd_destroy(const mbsr_model *m, mbsri_front_crowd *crowd);

/* Decides which of the pairs of the linearised equations are apart. */
void mbsri_front_crowd_part(mbsri_front *f);

/* Before the steps of a factorisation: weights. */
void mbsri_front_crowd_begin(mbsri_front *f, const mbsr_data *d);

/* Where the derivatives of a pair, of `rows` rows, have what body i feels by its own motion. */
size_t mbsri_front_crowd_own(const mbsri_front *f, int pair, int i, int rows);

/* Keeps what the other body of a pair apart feels by the motion of body i, of the derivatives of
 * the pair: rows x columns. */
void mbsri_front_crowd_keep(mbsri_front *f, int pair, int i, const double *matrix, int rows);

/* Adds loads on bodies to right-hand sides of y. */
void mbsri_front_crowd_load(mbsri_front *f);

/* Solves with r (bodies' loads are added by mbsri_front_crowd_load), and leaves the motion of
 * bodies in f->value. */
typedef void (*mbsri_front_sweep_of)(mbsri_front *f, const double *r);

/* Motion of the body of step k, which floats and is alone, by forces 1 on it, column by column. */
typedef void (*mbsri_front_response_of)(const mbsri_front *f, int k, double *motion);

/* After the steps of a factorisation. */
void mbsri_front_crowd_finish(mbsri_front *f, mbsri_front_response_of response);

/* Leaves in `loads` those that belong to r. False: they did not converge; the next matrices leave
 * nothing apart. */
bool mbsri_front_crowd_solve(mbsri_front *f, const double *r, mbsri_front_sweep_of sweep);

#endif
