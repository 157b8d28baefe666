/* What the steps of a consistent start share, and its Newton systems: see start.c.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_START_SYSTEMS_H
#define MBSRI_START_SYSTEMS_H

#include "massless/completion_matrix.h"
#include "massless/masses.h"

#include <mbsrank/dae.h>

typedef enum mbsri_start_from {
    MBSRI_FROM_GIVEN,
    MBSRI_FROM_REST,
    MBSRI_FROM_ELSEWHERE /* moving at a rate that is typical of the model */
} mbsri_start_from;

/* Ways back that are remembered (start_return.c). */
enum { MBSRI_WAYS = 4 };

typedef struct mbsri_start {
    mbsr_completion *w; /* the state that is being improved, its matrices, and the rates found */
    const mbsr_consistent_opt *opt;
    mbsr_consistent_info *info;
    const double *offset; /* position_rows: gaps wanted; NULL: zero */
    struct {
        const double *q, *u; /* nq, nu: closed positions, velocities */
        const double *load;  /* rows: loop forces there */
    } given;
    double widest;         /* largest rotation in a step of positions, rad */
    double longest;        /* largest step of positions, in spans of coordinates */
    double time;           /* time in which the state given changes much, s */
    mbsri_start_from from; /* where velocities of what has no mass begin */
    const char *sought;    /* name of the part of a state found last or in vain */
    int searches;          /* for a balance of springs, in vain */
    bool displaced;        /* whether positions have left those given */
    bool doubtful;         /* whether some direction may be undetermined at the state given */
    mbsri_masses masses;   /* of the state given */
    double *per_place;     /* nq: 1 over the span of each coordinate */
    double *target;        /* nu: momenta of the velocities given, at the positions reached */
    double *beyond;        /* nu: their excess over those of given.u there */
    double *missing;       /* nu: target and impulses of loops, less the momenta */
    double *impulse;       /* rows: of loops */
    double *before;        /* size: the state before a step */
    double *impulse_before, *load_before; /* rows: impulses and loop forces before it */
    double *step;                         /* size: the correction of a state */
    double *load_step;                    /* rows: the correction of loop forces */
    double *columns;                      /* scratch of start_return.c, and nu numbers of start.c */
    double *found;                        /* 2 (size + 3 rows): the last balance, and the first */
    double *ways;                         /* 2 MBSRI_WAYS x nu: scratch of start_return.c */
    struct {
        double balanced; /* 1/s, of the first balance from which no way led on; 0: none */
        double rounded;  /* 1/s, of the first velocities that rounding ended; 0: none */
        double widest;   /* of that search */
        bool serves;     /* no other c has led further than rounding */
    } c;
    bool *lacks; /* nu: whether a direction of the rate's joint moves no mass */
    void *memory;
} mbsri_start;

/* Room for starts of the model of w, whose record is kept in s; MBSR_OK or no memory, reported in
 * w->error. */
int mbsri_start_open(mbsri_start *s, mbsr_completion *w);
void mbsri_start_close(mbsri_start *s);

/* w->F at w->y, with momenta of w->y's velocities (own) or as they are. */
int mbsri_start_evaluate(mbsri_start *s, bool own);

/* w->r = (0, 0, F_u, F_Lambda, F_Eta - offset), those of F_u that are balances of forces. */
void mbsri_start_rows(mbsri_start *s, bool forces, bool rates, bool gaps);

/* Both solutions for w->r and c times `momenta` (nu, NULL: none) in r_p: of q, p limits and of
 * Lambda impulses in w->x; of u what is not elastic in w->x and what is over c in w->other, as loop
 * forces. */
int mbsri_start_solve(mbsri_start *s, const double *momenta);

/* Both matrices at w->y, w->yp. */
int mbsri_start_factor(mbsri_start *s);

/* Whether forces along directions without mass are rounding beside the largest that act, at w->y.
 */
bool mbsri_start_balances(mbsri_start *s);

/* The largest of changes of q over what coordinates span. */
double mbsri_start_extent(const mbsri_start *s, const double *dq);

#endif
