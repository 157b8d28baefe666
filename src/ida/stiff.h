/* Stiff elements under IDA: an error test and a Newton iteration that are not misled by them.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_IDA_STIFF_H
#define MBSRI_IDA_STIFF_H

#include "ida/compat.h"

#include <mbsrank/sundials.h>

#include <sundials/sundials_nonlinearsolver.h>
#include <sundials/sundials_nvector.h>

#include <stdbool.h>

typedef sunrealtype (*mbsri_masked_norm)(N_Vector x, N_Vector w, N_Vector id);

#define MBSRI_STIFF_ALARM 6.0

/* How errors are measured: by the filter of filter.c; as they are; momenta by what they move, see moved.c. */
typedef enum mbsri_test { MBSRI_TEST_FILTERED, MBSRI_TEST_PLAIN, MBSRI_TEST_MOVED } mbsri_test;

/* The steps before the present attempt. */
enum { MBSRI_PAST_STEPS = 5 }; /* the highest order */
typedef struct mbsri_past {
    double step[MBSRI_PAST_STEPS]; /* lengths, the last step's first */
    int known;                     /* as many of them */
    N_Vector y, attempt; /* where the last step ended, and where the present attempt does */
} mbsri_past;

typedef struct mbsri_stiff {
    SUNNonlinearSolver plain; /* Newton's method of SUNDIALS, for ordinary steps */
    SUNNonlinSolSysFn system; /* IDA's residual, linear system and its solution */
    SUNNonlinSolLSetupFn set_up;
    SUNNonlinSolLSolveFn solve;
    void *memory; /* IDA's, since the first iteration */
    N_Vector change, filtered, trial;
    mbsri_masked_norm masked; /* the norm of the error test without filter */
    int first, last;          /* the momenta are entries first .. last - 1 of y */

    double stricter; /* careful steps are held to errors by this smaller than the tolerances */
    bool dear;       /* a new matrix costs far more than a solution */
    bool
        quotients; /* matrices are made by difference quotients, so that each costs many residuals */
    double wrong; /* share of a correction that an old one may leave, see renewal.c; 0: any, else */
    double due;   /* reached at so many steps */
    int age;      /* attempts with the matrix at hand */
    double quadratic; /* a of steps that do, */
    int rated;        /* known for so many more of them */
    bool iterates;    /* the linear solver has no matrix, but a preconditioner */
    bool learned;     /* what the linear solver is */
    mbsri_past past;
    long steps; /* of IDA before the present attempt */
    double c;   /* of that */
    int order;  /* of its error test */
    mbsri_test test;
    double share;       /* of an error that is left by what it moves, see moved.c */
    bool always;        /* every step is taken carefully */
    bool off;           /* none is, and nothing is filtered */
    bool careful;       /* the last iteration was one of those below */
    long careful_until; /* steps before this one are taken carefully */
    long span;          /* as many of them as were meant to be when they began; 0: none yet */
    bool untested;      /* a matrix has been made since one was put to the test last */
    double tested_step; /* up to which steps none of them needs to be put to the test */
    long tested_at;
    long life; /* steps after which an ordinary one gets a new matrix; 0: when IDA wants one */
    long made_at, measured_at; /* steps of the last one, of the last look at what one had left */
    long turned_at; /* step of the last new matrix that a stiff direction needed; -1: none */
    long failed_at; /* step of the last failure of the plain iteration */
    long iterations, failures; /* of the last attempt */
    long stale;                /* of these, those of the plain iteration */
    bool looks;                /* momenta show what is strained, see iteration.c */
    N_Vector weight;           /* of the present step */
    bool hides;                /* the last correction of the plain iteration did */
    long verify_at, pause;     /* the step from which on that is done; steps to the next after it */
    bool low_order;            /* no order above 2 is allowed, so that a low one says nothing */
    double enough;             /* ends it */
    double alarm;              /* grows with error tests failed at low order */
    long alarmed_at;
    long rejected_at; /* step of the last test that failed; -1: none */
    double slowest;   /* the smallest c of a step that Newton's method solved; 0: none yet */
    N_Vector id;      /* IDA's, since the first error test: what counts in it */
    int norms;        /* of the present error test so far; -1: no error test */
    bool filters;     /* it is filtered */
    int vibrations; /* tests of low order failed by one, since careful steps were begun for them, */
    long vibrated_at; /* the last in this step */
    int patience;     /* spans between these */

    bool suspect; /* the last step may fail its error test: */
    N_Vector error;
    double suspect_norm;
    long tests_failed; /* until then */

    void (*prepare)(void *user, bool careful); /* called when that changes; or NULL */
    /* x becomes dF/dy' x; NULL: entries first .. last - 1 of F have a rate each, and x is all of it */
    int (*weigh)(void *user, N_Vector x);
    void *user;

    N_Vector direction,
        state;         /* the error that the filter took off last, or the correction at which
                                * a careful iteration failed, and where that was */
    double at;         /* time of it */
    bool of_iteration; /* it was an iteration */
    double *stiffness; /* of the force elements, see stiffest.c */
    int forces;        /* as many */
    mbsr_sundials_stiff_info info;
} mbsri_stiff;

/* Vectors made from y, y among them, know s, and measure errors by it. False without memory, and
 * for vectors that are not serial. */
bool mbsri_stiff_attach(mbsri_stiff *s, N_Vector y);

/* Whether the next step of IDA is one to be taken carefully. From now on such steps are: for long, or
 * for a few, and each time that this is asked for shortly after they have ended for twice as many. */
bool mbsri_stiff_careful(const mbsri_stiff *s);
void mbsri_stiff_begin(mbsri_stiff *s);
void mbsri_stiff_try(mbsri_stiff *s);

/* IDA's linear solver, looked at: b is a residual, then a correction. */
int mbsri_stiff_solve(mbsri_stiff *s, N_Vector b);

/* r / c of the momenta in the residual s->change, as their part of the norm. */
double mbsri_stiff_left(const mbsri_stiff *s);

/* One iteration: s->change becomes -F at ee; it is solved for, and ee changes by it. The matrix is new, unless the momenta
 * r / c of the residual are `within` that: then nothing stiff is strained, and the one at hand will do. */
int mbsri_stiff_evaluate(mbsri_stiff *s, N_Vector ee);
int mbsri_stiff_correct(mbsri_stiff *s, N_Vector ee, double within);

/* Both. */
int mbsri_stiff_improve(mbsri_stiff *s, N_Vector ee, double within);

/* The power of the velocities of a correction d along a residual r, see line_search.c. The momentum form has velocities besides
 * the momenta, in the others they stand where these do. */
static inline double mbsri_stiff_power(const mbsri_stiff *s, N_Vector d, N_Vector r)
{
    const int shift = s->last < N_VGetLength(d) ? s->last - s->first : 0;
    const double *velocity = N_VGetArrayPointer(d) + shift, *force = N_VGetArrayPointer(r);
    double sum = 0.0;
    for (int k = s->first; k < s->last; ++k) sum += velocity[k] * force[k];
    return sum;
}

/* Whether forces balance on the way to ee: not looked for; found; not found. */
typedef enum mbsri_search {
    MBSRI_SEARCH_NONE,
    MBSRI_SEARCH_BALANCED,
    MBSRI_SEARCH_IN_VAIN
} mbsri_search;

/* Shortens the correction s->filtered, which has led to ee, where it has gone too far; s->change is -F at ee before and after.
 * `before`: its power where it began; `enough`: momenta r / c that may be left, 0 where the residual does not show them. */
int mbsri_stiff_search(mbsri_stiff *s, N_Vector ee, double before, double enough,
                       mbsri_search *found);

/* The matrix of an ordinary step: the one at hand; it, but improved on by a new one at the end of the step; a new one;
 * a new one that is compared with it first. The last is for mbsri_stiff_begin_anew, the others for plain iterations. */
typedef enum mbsri_matrix {
    MBSRI_MATRIX_OLD,
    MBSRI_MATRIX_LAST,
    MBSRI_MATRIX_NEW,
    MBSRI_MATRIX_BEGIN
} mbsri_matrix;

/* The choice, where IDA asks for a new one or not. */
mbsri_matrix mbsri_stiff_choose(mbsri_stiff *s, bool set_up);

/* After a plain iteration, which has returned `status`: improves ee if it was the last with that matrix, and learns
 * how long matrices live. The status. */
int mbsri_stiff_judge(mbsri_stiff *s, mbsri_matrix matrix, int status, N_Vector ee, N_Vector w,
                      double tolerance);

/* Newton's method with a new matrix, a status of SUNDIALS. */
int mbsri_stiff_begin_anew(mbsri_stiff *s, N_Vector ee, N_Vector w, double tolerance);

/* What v, a vector made from y, knows. */
mbsri_stiff *mbsri_stiff_behind(N_Vector v);

/* The norm of x, an error, the first or a later one of an error test, its momenta measured by what they move with
 * loops closed. */
double mbsri_stiff_moved(mbsri_stiff *s, N_Vector x, N_Vector w, N_Vector id, bool first);

/* The part of the norm of x, by s->weight, that its momenta make. */
double mbsri_stiff_momenta(const mbsri_stiff *s, N_Vector x);

/* What jumps.c has to know: IDA had taken so many steps at the last attempt; an error test begins. */
void mbsri_stiff_note_step(mbsri_stiff *s, long before);
void mbsri_stiff_note_attempt(mbsri_stiff *s);

/* By how much IDA's error constant is smaller than that of equal steps: 1 to 20. */
double mbsri_stiff_unequal(const mbsri_stiff *s);

/* Whether what takes an error x off along s->filtered has acted before the step, too: K s->filtered = s->error. True where
 * that is not known. */
bool mbsri_stiff_acted(mbsri_stiff *s, N_Vector x);

/* Whether the filter leaves little of the momenta of x, a correction: a stiff element asked for it. */
bool mbsri_stiff_moves(mbsri_stiff *s, N_Vector x);

/* Keeps x and the present state for mbsr_ida_stiffest. */
void mbsri_stiff_keep(mbsri_stiff *s, N_Vector x, bool of_iteration);

/* To be called before a step is tried: asks whether the last error test failed, and why. */
void mbsri_stiff_look_back(mbsri_stiff *s);

/* Whether IDA has made a new matrix by difference quotients, and it is wrong along ee, the
 * correction that was found with it. */
bool mbsri_stiff_wrong_matrix(mbsri_stiff *s, N_Vector predicted, N_Vector ee);

/* As mbsr_sundials_stiff, for the momentum and the index-1 form. */
SUNNonlinearSolver mbsri_stiff_create(const mbsr_model *model, mbsr_dae_form form, N_Vector y,
                                      SUNContext context);

/* Careful steps are held to 0.3 of the tolerances, for part of what the filter takes off an error is left,
 * and where a relative one above 7e-5 is asked for, to 0.3 of that: a step is then a large part of a turn. At the whole of
 * them a stiff mechanism gains several times the energy that rigid ones do at the same tolerance. */
void mbsri_stiff_set_rtol(mbsri_stiff *s, double rtol);

/* What belongs to the nonlinear solver; NULL if it is another one. */
mbsri_stiff *mbsri_stiff_of(SUNNonlinearSolver solver);

#endif
