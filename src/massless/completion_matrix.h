/* Completing a state: what its parts share, see completion.c.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_COMPLETION_MATRIX_H
#define MBSRI_COMPLETION_MATRIX_H

#include "recursion/data.h"

#include <mbsrank/completion.h>

/* c of the second of two matrices over that of the first. */
#define MBSRI_COMPLETION_RATIO 100.0

struct mbsr_completion {
    const mbsr_model *m;
    mbsr_data *d; /* of the call under way */
    double t;     /* s, likewise */
    mbsr_error error;
    mbsr_completion_times times;
    mbsr_completion_info info;
    int size, rates, loops, places; /* of the momentum form's y; where u, Lambda, Eta begin */

    mbsr_newton *newton;        /* NULL: the dense matrix */
    double *inverse, *work;     /* size^2, and 4 size */
    double factored;            /* c of the matrix at hand; 0: none at this state */
    int *pivots;                /* size */
    double *ahead, *ahead_rate; /* size: y, y' that are differenced; also along a path */

    double *y, *yp, *F;    /* size: the state, y' = (0, 0, 0, lambda, 0), the residual there */
    double *r, *x, *other; /* size: a right side, solutions for c and for another one */
    double *rate;          /* size: what q', p', s' and u' are found to be */
    double *time;          /* size: -dF/dt of the algebraic equations */
    double *given;         /* size + rows: the state as it was given, and loop forces */
    double *further;       /* size: a second right side */
    double *force_rate;    /* rows: lambda', where springs alone hold directions */
    double *q, *u, *tau;   /* nq, nu, nu: of a form; what is applied to the joints, or zero */
    bool deficient;        /* some direction moves no mass */
    bool elastic;          /* springs alone hold some: */
    bool found;            /* the state and its rates are those of the last call */
    void *memory;
};

/* F at (t, y, yp); a status, with the text in w->error, as all of these. */
int mbsri_completion_residual(mbsr_completion *w, double t, const double *y, const double *yp);

/* K(c) at w->y, w->yp is factored; x from r with that. */
int mbsri_completion_factor(mbsr_completion *w, double c);
int mbsri_completion_solve(mbsr_completion *w, const double *r, double *x);

/* Largest of the rates x (nu) over their spans, 1/s; 1/s itself where nothing is typical. */
double mbsri_completion_speed(const mbsr_completion *w, const double *x);

/* A time in which the state changes much, s. */
double mbsri_completion_time(const mbsr_completion *w);

int mbsri_completion_fail(mbsr_completion *w, int status, const char *text);

#endif
