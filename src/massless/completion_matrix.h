/* Completing a state: what its parts share, see completion.c.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_COMPLETION_MATRIX_H
#define MBSRI_COMPLETION_MATRIX_H

#include "recursion/data.h"

#include <mbsrank/completion.h>
#include <mbsrank/driver.h>

/* The two matrices, for c and for MBSRI_COMPLETION_RATIO c. */
#define MBSRI_COMPLETION_RATIO 100.0
enum { MBSRI_NEAR, MBSRI_FAR, MBSRI_MATRICES };

/* One of them. Where no body may be without mass there is one record for both. */
typedef struct mbsri_completion_matrix {
    mbsr_newton *newton; /* NULL: the dense matrix */
    double *inverse;     /* size^2 */
    double c;            /* what it was made for; 0: nothing */
} mbsri_completion_matrix;

struct mbsr_completion {
    const mbsr_model *m;
    mbsr_data *d; /* of the call under way */
    double t;     /* s, likewise */
    mbsr_error error;
    mbsr_completion_times times;
    mbsr_completion_info info;
    int size, rates, loops, places; /* length of y; where u, Lambda and Eta begin in it */

    struct {
        mbsri_completion_matrix matrix[MBSRI_MATRICES]; /* of this state, or of an earlier one */
        bool pair;    /* whether MBSRI_FAR has a matrix of its own */
        double c;     /* 1/s: factor of MBSRI_NEAR */
        double *work; /* 4 size */
        int *pivots;  /* size */
    } solver;
    struct {
        double *y, *yp;
        double *errors; /* twice rows and position rows: C u + g_t and g, at the state and there */
    } ahead;            /* size: y, y' that are differenced; also along a path */

    double *y, *yp, *F;    /* size: the state, y' = (0, 0, 0, lambda, 0), the residual there */
    double *r, *x, *other; /* size: a right side, solutions for c and for the factor of MBSRI_FAR */
    double *rate;          /* size: what q', p', s' and u' are found to be */
    double *time;          /* size: -dF/dt of the algebraic equations */
    double *given;         /* size + rows: the state as it was given, and loop forces */
    double *further;       /* size: a second right side, for MBSRI_FAR */
    double *force_rate;    /* rows: lambda', where springs alone hold directions */
    struct {
        double *per;  /* nu: 1 over the typical size of each joint rate */
        double least; /* 1/s: the typical rate of the model */
        double *loop; /* rows: loop forces that are measured */
    } span;
    bool *lacks; /* nu: whether the joint, or its group, lacks rank */
    struct {
        double *q, *u; /* nq, nu: of the state in another form */
    } form;
    double *tau; /* nu: what is applied to the joints, or zero */
    struct {
        bool deficient; /* some direction moves no mass */
        bool elastic;   /* springs alone hold some */
        bool faster;    /* or neither these: a push moves some by more than c times a number */
    } kind;
    struct {
        bool found;   /* whether the last call has succeeded */
        bool follows; /* whether the call before it had */
    } last;
    void *memory;
};

/* F at (t, y, yp); a status, with the text in w->error, as all of these. */
int mbsri_completion_residual(mbsr_completion *w, double t, const double *y, const double *yp);

/* c of MBSRI_NEAR or MBSRI_FAR. */
static inline double mbsri_completion_c(const mbsr_completion *w, int which)
{
    return which == MBSRI_FAR ? MBSRI_COMPLETION_RATIO * w->solver.c : w->solver.c;
}

/* K(c) of MBSRI_NEAR or MBSRI_FAR at w->y, w->yp is factored; x from r with that, which is made if
 * it is not there. */
int mbsri_completion_factor(mbsr_completion *w, int which);
int mbsri_completion_solve(mbsr_completion *w, int which, const double *r, double *x);

/* Whether it is there, of this state or an earlier one; none is from now on. */
bool mbsri_completion_has(const mbsr_completion *w, int which);
void mbsri_completion_forget(mbsr_completion *w);

/* Largest of the rates x (nu) over their spans, 1/s; 1/s itself where nothing is typical. */
double mbsri_completion_speed(const mbsr_completion *w, const double *x);

/* A time in which the state changes much, s. */
double mbsri_completion_time(const mbsr_completion *w);

/* Of accelerations udot (nu), 1/s^2, for what is relative to it: at rest they are rounding. */
double mbsri_completion_size(const mbsr_completion *w, const double *udot);

/* Largest of loads (nu) times the spans of the rates that they act along, and that of what rigid
 * rows exert with the forces lambda (rows) at the state evaluated last. */
double mbsri_completion_load(const mbsr_completion *w, const double *load);
double mbsri_completion_force(mbsr_completion *w, const double *lambda);

/* Whether corrections of these sizes, relative to what is corrected, are followed by none that
 * counts: above `enough`, or at rounding, which is below `near`. */
bool mbsri_completion_converged(double change, double last, double enough, double near);

int mbsri_completion_fail(mbsr_completion *w, int status, const char *text);

#endif
