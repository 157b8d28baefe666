/* The controller: all that the driver remembers from step to step about stiff elements and old
 * matrices.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_IDA_CONTROL_H
#define MBSRI_IDA_CONTROL_H

#include <stdbool.h>

/* How the next step is taken. */
typedef enum mbsri_mode {
    MBSRI_MODE_ORDINARY, /* by IDA */
    MBSRI_MODE_TRIAL,    /* carefully, with a few others */
    MBSRI_MODE_CAREFUL   /* carefully, with a hundred others */
} mbsri_mode;

/* Which steps are careful: those that signs ask for; all; none. */
typedef enum mbsri_care { MBSRI_CARE_BY_SIGNS, MBSRI_CARE_ALWAYS, MBSRI_CARE_NEVER } mbsri_care;

/* What is seen in a step, by whom: the table in control.c. */
typedef enum mbsri_sign {
    MBSRI_SIGN_NONE,
    MBSRI_SIGN_STIFF,
    MBSRI_SIGN_PARTLY_STIFF,
    MBSRI_SIGN_VIBRATES,
    MBSRI_SIGN_LOW_ORDER,
    MBSRI_SIGN_TURNS,
    MBSRI_SIGN_TURNED,
    MBSRI_SIGN_MISLED,
    MBSRI_SIGN_WRONG_QUOTIENTS,
    MBSRI_SIGN_MUCH_LEFT,
    MBSRI_SIGN_LITTLE_LEFT,
    MBSRI_SIGNS
} mbsri_sign;

/* The matrix of an ordinary step: the one at hand; it, but improved on by a new one at the end of
 * the step; a new one; a new one that is compared with it first. */
typedef enum mbsri_matrix {
    MBSRI_MATRIX_OLD,
    MBSRI_MATRIX_LAST,
    MBSRI_MATRIX_NEW,
    MBSRI_MATRIX_BEGIN
} mbsri_matrix;

/* Steps that begin with a new matrix, see renewal.c, and tests of matrices, see iteration.c and
 * quotients.c. */
typedef struct mbsri_matrices {
    double share; /* of a correction that an old one may leave; 0: any, none is renewed for it */
    double due;   /* attempts after which a step begins with a new matrix */
    int age;      /* attempts with the one at hand */
    long made_at; /* step in which it was made */
    long life;    /* steps after which an ordinary one gets a new matrix; 0: when IDA wants one */
    long compared_at;   /* step in which what one has left was looked at */
    double quadratic;   /* a of |d2| = a |d1|^2, d1 and d2 corrections one after the other */
    int rated;          /* steps for which `quadratic` still serves */
    long verify_at;     /* step from which on plain iterations are verified by new matrices again */
    long pause;         /* steps from one to the next after it */
    bool untested;      /* whether the matrix at hand has not been checked along a direction */
    double tested_step; /* the longest step for which the last check serves, s */
    long tested_at;     /* the step of that check */
    long kept;          /* age in steps up to which careful ones keep the matrix; 0: none do */
} mbsri_matrices;

typedef struct mbsri_evidence {
    double points; /* collected, fading (control.c) */
    long at;       /* step of the last */
} mbsri_evidence;

/* Norms of an error test: of the momenta in the errors of its order and one below, of the
 * coordinates in the latter. */
typedef struct mbsri_errors {
    double momenta, momenta_below, coordinates_below;
} mbsri_errors;

/* A vibration in the errors, see stability.c: sums of their squares, fading. */
typedef struct mbsri_vibration {
    double higher, lower;        /* of momenta, of order k and k - 1 */
    double momenta, coordinates; /* squares of its amplitudes, in tolerances */
    long steps;                  /* in which it was there and small enough to go */
} mbsri_vibration;

typedef struct mbsri_control {
    bool learned;   /* whether the fields below on the linear solver are known */
    bool iterates;  /* it has no matrix, but a preconditioner */
    bool quotients; /* its matrices are made by difference quotients */
    bool dear;      /* a new matrix costs far more than a solution */
    bool looks;     /* whether residuals of momenta show what is strained (iteration.c) */
    mbsri_care care;
    long until;         /* the first step that is ordinary again */
    long span;          /* length of the last stretch of careful steps; 0: none yet */
    double doubt;       /* low orders have to show so many times the points */
    int patience;       /* spans between those of something that vibrates */
    long failed_at;     /* step of the last error test that failed; -1: none */
    long low_until;     /* steps before this one are of order 2 at most */
    double long_enough; /* length of a step that ends `low_until` early, s */
    mbsri_vibration vibration;
    mbsri_evidence evidence[MBSRI_SIGNS];
    mbsri_matrices matrices;
} mbsri_control;

/* A run begins: what has been seen is forgotten, what the linear solver is and the options stay. */
void mbsri_control_begin(mbsri_control *c);

/* How the step after so many others is taken. */
mbsri_mode mbsri_control_mode(const mbsri_control *c, long step);

/* Something is seen, and counts so many points: 1, or those of low orders. True where it is enough
 * to change something. */
bool mbsri_control_note(mbsri_control *c, long step, mbsri_sign sign, double points);

/* The matrix of an ordinary step, where IDA asks for a new one or not; `able`: it can be made. */
mbsri_matrix mbsri_control_choose(mbsri_control *c, long step, bool asked, bool able);

/* A matrix has been made; the one before was off by `off` in a correction of `size`. */
void mbsri_control_plan(mbsri_control *c, long step, double off, double size);

/* The plain iteration has needed a new one. */
void mbsri_control_stale(mbsri_control *c, long step);

/* The last step of a matrix has been corrected by a new one, by `left` of what IDA lets be left.
 * True if that is much. */
bool mbsri_control_compared(mbsri_control *c, long step, double left);

/* A second correction has been `quadratic` times the square of the first; whether, after a first
 * one of `size`, the second will be within `enough`. */
void mbsri_control_rate(mbsri_control *c, double quadratic);
bool mbsri_control_predicts(mbsri_control *c, double size, double enough);

/* Iterations with new matrices have found that plain ones were right, or misled. */
void mbsri_control_verified(mbsri_control *c, long step, bool misled);

/* Whether a matrix of quotients for steps of h has to be tested; and its defect, of which `most` is
 * allowed. */
bool mbsri_control_tests(const mbsri_control *c, long step, double h);
void mbsri_control_tested(mbsri_control *c, long step, double h, double defect, double most);

/* An error test of order 3 or more in a step of h; and whether the next step is of order 2 at most.
 */
void mbsri_control_note_errors(mbsri_control *c, long step, double h, int order,
                               const mbsri_errors *e);
bool mbsri_control_low_order(mbsri_control *c, long step, double h);

/* Whether an error test has failed in one of the last steps. */
bool mbsri_control_failed_soon(const mbsri_control *c, long step);

#endif
