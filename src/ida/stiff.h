/* Stiff elements under IDA: an error test and a Newton iteration that are not misled by them. What
 * goes on from step to step is decided in control.c; the functions below are told what they work
 * with, and tell what they have seen.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_IDA_STIFF_H
#define MBSRI_IDA_STIFF_H

#include "ida/compat.h"
#include "ida/control.h"

#include <mbsrank/sundials.h>

#include <sundials/sundials_nonlinearsolver.h>
#include <sundials/sundials_nvector.h>

#include <stdbool.h>

typedef sunrealtype (*mbsri_masked_norm)(N_Vector x, N_Vector w, N_Vector id);

/* How errors are measured: by the filter of filter.c; as they are; momenta by what they move, see
 * filter.c. */
typedef enum mbsri_test { MBSRI_TEST_FILTERED, MBSRI_TEST_PLAIN, MBSRI_TEST_MOVED } mbsri_test;

/* The last masked norm that IDA has asked for, see error_test.c: none of an error test; none yet;
 * of its order; one below; two below; one above. */
typedef enum mbsri_call {
    MBSRI_CALL_NONE,
    MBSRI_CALL_AWAITED,
    MBSRI_CALL_OF_ORDER,
    MBSRI_CALL_BELOW,
    MBSRI_CALL_TWO_BELOW,
    MBSRI_CALL_ABOVE
} mbsri_call;

/* What an error test measures of an error: all; what the filter leaves; all but the momenta. */
typedef enum mbsri_measure {
    MBSRI_MEASURE_ALL,
    MBSRI_MEASURE_FILTERED,
    MBSRI_MEASURE_COORDINATES
} mbsri_measure;

/* The present attempt at a step. */
typedef struct mbsri_attempt {
    long steps;          /* steps of IDA before it */
    double c;            /* factor in its matrix dF/dy + c dF/dy', 1/s */
    int order;           /* order of its error test */
    bool careful;        /* whether its iteration is careful */
    long iterations;     /* iterations of Newton's method */
    long failures;       /* iterations that did not converge */
    long stale;          /* those of them that the plain iteration ran */
    bool hides;          /* whether its last correction left momenta for something stiff */
    mbsri_call call;     /* norm that its error test has reached */
    mbsri_measure tests; /* what its error test measures */
    bool low;            /* whether its order is not to exceed 2 */
    double norm;         /* first norm of its error test */
    mbsri_errors errors; /* norms of its error test, part by part */
    double share;        /* part of an error that is left by what it moves, see filter.c */
    bool suspect;        /* whether it may fail its error test, which the next attempt tells */
    double suspect_norm; /* norm of s->error where it is suspect */
    long tests_failed;   /* error tests that failed before it */
} mbsri_attempt;

/* The steps before the present attempt. */
enum { MBSRI_PAST_STEPS = 5 }; /* the highest order */
typedef struct mbsri_past {
    double step[MBSRI_PAST_STEPS];  /* lengths of the last steps, s, the latest first */
    int known;                      /* number of steps known */
    N_Vector y, rate;               /* y and y' at the end of the last step */
    N_Vector attempt, attempt_rate; /* y and y' at the end of the present attempt */
} mbsri_past;

/* What mbsr_ida_stiffest is told. */
typedef struct mbsri_blame {
    N_Vector direction; /* what the filter took off last, or the correction at which a careful
                           iteration failed */
    N_Vector state;     /* y where that was */
    double at;          /* time of that, s */
    bool of_iteration;  /* whether it was an iteration */
    double slowest;     /* smallest c of a step that Newton's method solved, 1/s; 0: none yet */
    double *stiffness;  /* forces: stiffness of each force element, see stiffest.c */
    int forces;         /* number of force elements */
} mbsri_blame;

typedef struct mbsri_stiff {
    SUNNonlinearSolver plain; /* Newton's method of SUNDIALS, for ordinary steps */
    SUNNonlinSolSysFn system; /* IDA's residual, linear system and its solution */
    SUNNonlinSolLSetupFn set_up;
    SUNNonlinSolLSolveFn solve;
    void *memory;             /* memory of IDA, from the first iteration on */
    mbsri_masked_norm masked; /* norm of the error test without filter */
    N_Vector weight;          /* IDA's weights of errors in the present step */
    N_Vector id; /* IDA's mask of what counts in an error test, from the first one on */
    N_Vector change, filtered, trial, error; /* vectors like y, scratch of the functions below */
    int first, last;                         /* range of the momenta in y: first .. last - 1 */

    mbsri_test test;
    bool low_order;  /* whether no order above 2 is allowed, so that a low one says nothing */
    double stricter; /* factor of the norms of errors in careful steps, 1 or more */
    void (*prepare)(void *user,
                    bool careful); /* called where steps become careful, or plain; or NULL */
    /* x becomes dF/dy' x; NULL: entries first .. last - 1 of F have a rate each, and x is all of it
     */
    int (*weigh)(void *user, N_Vector x);
    void *user;

    mbsri_control control;
    mbsri_attempt now;
    struct {
        long step;
        double c;
    } made; /* of the attempt that made the matrix at hand */
    struct {
        double norm;
        long at;
    } rounding; /* what it leaves in the momenta, and the step of that; see rounding.c */
    mbsri_past past;
    mbsri_blame blame;
    mbsr_sundials_stiff_info info;
} mbsri_stiff;

/* ---- the error test ---- */

/* Vectors made from y, y among them, know s, and measure errors by it. False without memory, and
 * for vectors that are not serial. */
bool mbsri_stiff_attach(mbsri_stiff *s, N_Vector y);

/* What v, a vector made from y, knows. */
mbsri_stiff *mbsri_stiff_behind(N_Vector v);

/* To be called before a step is tried: asks whether the last error test failed, and why. */
void mbsri_stiff_look_back(mbsri_stiff *s);

/* s->filtered becomes K^-1 (0, c e_p, 0), K the present matrix and e_p the momenta of x that count;
 * right, unless it is NULL, what is in brackets. Nonzero if the linear solver fails. */
int mbsri_stiff_filter(mbsri_stiff *s, N_Vector x, N_Vector right);

/* The norm of x with its momenta filtered; negative if the linear solver fails. */
double mbsri_stiff_filtered_norm(mbsri_stiff *s, N_Vector x);

/* Norm of the momenta of x in the error test. */
double mbsri_stiff_momentum_norm(mbsri_stiff *s, N_Vector x);

/* Norm of all but the momenta of x. */
double mbsri_stiff_coordinate_norm(mbsri_stiff *s, N_Vector x);

/* Whether the momenta of x, an error, are no more than rounding leaves in them, see rounding.c. */
bool mbsri_stiff_is_rounding(mbsri_stiff *s, N_Vector x);

/* Whether the filter leaves little of the momenta of x, a correction: a stiff element asked for it.
 */
bool mbsri_stiff_moves(mbsri_stiff *s, N_Vector x);

/* The norm of x, an error, the first or a later one of an error test, its momenta measured by what
 * they move with loops closed. */
double mbsri_stiff_moved(mbsri_stiff *s, N_Vector x, bool first);

/* What jumps.c has to know: IDA had taken so many steps at the last attempt; an error test begins.
 */
void mbsri_stiff_note_step(mbsri_stiff *s, long before);
void mbsri_stiff_note_attempt(mbsri_stiff *s);

/* By how much IDA's error constant is smaller than that of equal steps, or than 1 where steps have
 * become short; at least 1. Less where an error of norm `momenta` in its momenta is larger than
 * what the last rates were wrong by. */
double mbsri_stiff_unequal(mbsri_stiff *s, double momenta);

/* Whether what takes an error x off along s->filtered has acted before the step, too: K s->filtered
 * = s->error. True where that is not known. */
bool mbsri_stiff_acted(mbsri_stiff *s, N_Vector x);

/* ---- Newton's method ---- */

/* One iteration: s->change becomes -F at ee; it is solved for, and ee changes by it. The matrix is
 * new, unless the momenta r / c of the residual are `within` that: then nothing stiff is strained,
 * and the one at hand will do. */
int mbsri_stiff_evaluate(mbsri_stiff *s, N_Vector ee);
int mbsri_stiff_correct(mbsri_stiff *s, N_Vector ee, double within);

/* IDA's linear solver, looked at: b is a residual, then a correction. */
int mbsri_stiff_solve(mbsri_stiff *s, N_Vector b);

/* The part of the norm of x, by s->weight, that its momenta make. */
double mbsri_stiff_momenta(const mbsri_stiff *s, N_Vector x);

/* r / c of the momenta in the residual s->change, as their part of the norm. */
double mbsri_stiff_left(const mbsri_stiff *s);

/* The power of the velocities of a correction d along a residual r, see line_search.c. The momentum
 * form has velocities besides the momenta, in the others they stand where these do. */
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

/* Shortens the correction s->filtered, which has led to ee, where it has gone too far; s->change is
 * -F at ee before and after. `before`: its power where it began; `enough`: momenta r / c that may
 * be left, 0 where the residual does not show them; `stay`: it is not shortened in vain. */
int mbsri_stiff_search(mbsri_stiff *s, N_Vector ee, double before, double enough, bool stay,
                       mbsri_search *found);

/* A careful step; within `rounding` corrections need not shrink; `young`: the matrix at hand may
 * serve. A status of SUNDIALS, as those below. */
int mbsri_stiff_iterate(mbsri_stiff *s, N_Vector ee, double tolerance, double rounding, bool young);

/* A matrix is made in the present attempt. */
void mbsri_stiff_note_matrix(mbsri_stiff *s);

/* An ordinary step. SUN_NLS_CONTINUE: its matrix was wrong, and the step is to be tried carefully.
 */
int mbsri_stiff_iterate_plainly(mbsri_stiff *s, N_Vector predicted, N_Vector ee, double tolerance,
                                bool set_up);

/* Iterations with the matrix at hand, a `fresh` one or not, after a correction of size `before`. */
int mbsri_stiff_settle(mbsri_stiff *s, N_Vector ee, double before, double tolerance, bool fresh);

/* Newton's method with a new matrix, compared with the old one. */
int mbsri_stiff_begin_anew(mbsri_stiff *s, N_Vector ee, double tolerance);

/* After a plain iteration, which has returned `status`: improves ee if it was the last with that
 * matrix, and tells how long matrices live. The status. */
int mbsri_stiff_judge(mbsri_stiff *s, mbsri_matrix matrix, int status, N_Vector ee,
                      double tolerance);

/* Whether IDA has made a new matrix by difference quotients, and it is wrong along ee, the
 * correction that was found with it. */
bool mbsri_stiff_wrong_matrix(mbsri_stiff *s, N_Vector predicted, N_Vector ee);

/* Tells the driver's functions, and an iterative linear solver, that steps are careful now, or not.
 */
void mbsri_stiff_prepare(mbsri_stiff *s, bool careful);

/* A sign of Newton's method. */
void mbsri_stiff_note(mbsri_stiff *s, mbsri_sign sign);

/* Keeps x and the present state for mbsr_ida_stiffest. */
void mbsri_stiff_keep(mbsri_stiff *s, N_Vector x, bool of_iteration);

/* ---- the solver ---- */

/* As mbsr_sundials_stiff, for the momentum and the index-1 form. */
SUNNonlinearSolver mbsri_stiff_create(const mbsr_model *model, mbsr_dae_form form, N_Vector y,
                                      SUNContext context);

/* Careful steps are held to 0.3 of the tolerances, for part of what the filter takes off an error
 * is left, and where a relative one above 7e-5 is asked for, to 0.3 of that: a step is then a large
 * part of a turn. At the whole of them a stiff mechanism gains several times the energy that rigid
 * ones do at the same tolerance. */
void mbsri_stiff_set_rtol(mbsri_stiff *s, double rtol);

/* What belongs to the nonlinear solver; NULL if it is another one. */
mbsri_stiff *mbsri_stiff_of(SUNNonlinearSolver solver);

#endif
