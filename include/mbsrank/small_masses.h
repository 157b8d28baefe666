/* Small masses: which may be zero, what that costs, and a start without the fast oscillation.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A joint direction with little inertia m beside its stiffness k and damping d moves fast, with the
 * roots of lambda^2 m + lambda d + k = 0, around a smooth motion. Without the mass the model has
 * that smooth motion alone, but for an error of first order (docs/small_masses.md): with w the
 * inertia force, less the weight, that is neglected along the smooth motion,
 *
 *   (equations of motion of the reduced model, linearised) delta = -w.
 *
 *   mbsr_small_masses *small;
 *   mbsr_small_masses_create(model, &opt, &small, &error);      all candidates without their mass
 *   mbsr_small_masses_start(small, t, q, u);                    the report at a state
 *   mbsr_small_masses_step(small, t, y, yp);
 *       ... and along a run of the reduced model
 *   mbsr_small_masses_get_report(small, &report);
 *
 * mbsr_small_masses_run (ida.h) does such a run. What is decided to be zero the caller states:
 * mbsr_model_copy, mbsr_model_neglect, mbsr_model_finish. */
#ifndef MBSRANK_SMALL_MASSES_H
#define MBSRANK_SMALL_MASSES_H

#include <mbsrank/newton.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct mbsr_small_masses mbsr_small_masses;

/* A mass to be looked at. */
typedef struct mbsr_small_part {
    int body;  /* id */
    int parts; /* MBSR_MASS, MBSR_MOMENT or both (mbsr_model_neglect) */
} mbsr_small_part;

/* Writes `outputs` numbers that are asked for at (t, q, u). Returns 0 or a status. */
typedef int (*mbsr_small_output_fn)(void *user, double t, const double *q, const double *u,
                                    double *value);

typedef struct mbsr_small_masses_opt {
    int cookie;        /* set by mbsr_default_small_masses_opt */
    double duration;   /* s, of the run that the report is for; to be given, > 0 */
    double time_scale; /* s, of the slow motion, 1 / its largest rate; 0 (default): duration / 30 */
    /* candidates: */
    int parts;                   /* how many are named; default 0 */
    const mbsr_small_part *part; /* NULL (default): those found, see below; read at creation */
    double ratio; /* found are masses up to so much of their neighbours'; default 0.1 */
    int most;     /* at most so many are found, the smallest ones; default 64 */
    /* outputs and what error is allowed in them: */
    int outputs;                 /* 0 (default): all q */
    mbsr_small_output_fn output; /* NULL exactly when outputs is 0 */
    void *output_user;
    double tolerance;             /* error allowed in an output, default 1e-3 */
    const double *tolerance_each; /* for each output, read at creation; NULL (default): tolerance */
    /* what the integrator is asked for (mbsr_ida_opt), for the steps saved: */
    double rtol, atol;    /* default 1e-6 */
    double atol_velocity; /* of u; 0 (default): atol */
} mbsr_small_masses_opt;

MBSR_API mbsr_small_masses_opt mbsr_default_small_masses_opt(void);

/* What a zero in the place of a mass would do. */
typedef enum mbsr_small_verdict {
    MBSR_SMALL_MAY_BE_ZERO = 0, /* at this tolerance */
    MBSR_SMALL_UNDAMPED = 1,    /* but an oscillation about it, larger than allowed, is lost */
    MBSR_SMALL_MAY_NOT_BE_ZERO = 2,
    MBSR_SMALL_UNDETERMINED = 3 /* no force determines the motion without it (index.h) */
} mbsr_small_verdict;

/* The words of the table for a verdict; never NULL. */
MBSR_API const char *mbsr_small_verdict_text(mbsr_small_verdict verdict);

/* A joint rate of which the inertia is one of the masses looked at, as it is with all of them
 * present; units of that coordinate, kg or kg m^2 for translations and rotations. */
typedef struct mbsr_small_direction {
    int body, coordinate; /* id; 0 .. n-1 within the joint */
    int mass;             /* whose: place in the list of masses */
    double inertia;       /* m */
    double stiffness;     /* k, of what holds it while the rest of the model stays */
    double damping;       /* d */
    double frequency;     /* rad/s, sqrt(k / m) */
    double damping_ratio; /* d / (2 sqrt(k m)), 1e6 at most */
    double rate;          /* 1/s, the largest |lambda| */
    double decay;         /* 1/s, at which the fast motion dies out */
    double fastness;      /* rate x time scale of the slow motion */
    double amplitude;     /* of the fast motion, in the coordinate's unit: from the start given, and
                           * the largest that the run has excited */
} mbsr_small_direction;

/* One mass or moment of inertia that was looked at. */
typedef struct mbsr_small_mass {
    int body, parts; /* as mbsr_small_part */
    double ratio;    /* mass beside that of the heaviest neighbour; 0 where nothing is known */
    int direction;   /* the fastest of its directions, a place in their list; MBSR_NONE */
    double error; /* the largest error that its zero makes in an output, in that one's unit ... */
    int output;   /* ... and which output: an index, of q where no outputs are given */
    double time;  /* ... and at which time */
    double share; /* error / tolerance of that output */
    double amplitude; /* of the oscillation that is lost, largest of its directions, as a share of
                         the tolerance of these coordinates (outputs given: of the output) */
    double steps; /* that its zero saves: of the start's swing, or of all along a run whose states
                   * are an integrator's steps */
    mbsr_small_verdict verdict;
} mbsr_small_mass;

/* What was found of all of them. */
typedef struct mbsr_small_masses_report {
    int masses, directions;
    const mbsr_small_mass *mass; /* in the order named, or found: the smallest ratio first */
    const mbsr_small_direction *direction;
    double from, to;    /* s, what has been looked at: one state, or a run */
    int states;         /* of it */
    double error, time; /* of all zeros together, as in mbsr_small_mass */
    int output;
    double share;
    int body;            /* whose mass has the largest error; MBSR_NONE */
    double amplitude;    /* of the oscillations that are lost, beside the error: those of all masses
                          * added up, which may meet; a share as in mbsr_small_mass */
    double steps;        /* that they save together */
    long factorisations; /* of Newton matrices for mbsr_small_masses_start */
    const char *text;    /* a table for people */
} mbsr_small_masses_report;

/* Makes copies of the model with and without the candidates' masses. Candidates are those named;
 * or, with part == NULL, bodies whose mass is at most `ratio` of the largest among their
 * predecessor, successors and bodies they share a force element with, and past those of these that
 * are candidates themselves, so that of several light bodies in a row all are; masses that the
 * model neglects already are candidates in both cases. (Mass and moment: trace(mass) / dimension +
 * trace(tensor) / length^2 with mbsr_model_length, of a MATRIX too; in GENERAL space the first.)
 * opt is required. The model must outlive the object. Memory comes from the model's allocator, here
 * and in `start`. MBSR_ERR_NULL, MBSR_ERR_NO_DEFAULT, MBSR_ERR_UNFINISHED, MBSR_ERR_VALUE,
 * MBSR_ERR_ID, MBSR_ERR_NO_MEMORY, statuses of mbsr_newton_create. */
MBSR_API int mbsr_small_masses_create(const mbsr_model *model, const mbsr_small_masses_opt *opt,
                                      mbsr_small_masses **small, mbsr_error *error);
MBSR_API void mbsr_small_masses_destroy(mbsr_small_masses *small); /* NULL is allowed */

/* Looks at (t, q, u), a state of the model with all masses: finds the consistent state of the
 * reduced model near it, the directions, and first-order errors at the end of `duration` if nothing
 * changes: five factorisations of a Newton matrix, and one solution for each candidate and
 * direction, O(N) each. Masses without which nothing determines the motion keep it
 * (MBSR_SMALL_UNDETERMINED). Statuses of mbsr_dae_consistent and mbsr_newton_factor. After a
 * failure there is no report. */
MBSR_API int mbsr_small_masses_start(mbsr_small_masses *small, double t, const double *q,
                                     const double *u);

/* The consistent state of the reduced model that `start` has found, in its momentum form:
 * mbsr_dae_size numbers each. MBSR_ERR_NULL, MBSR_ERR_SEQUENCE. */
MBSR_API int mbsr_small_masses_state(const mbsr_small_masses *small, double *t, double *y,
                                     double *yp);

/* The reduced model without the masses that `start` has left out, for a run; as long as the object
 * lives, or until the next start. NULL before `start`. */
MBSR_API const mbsr_model *mbsr_small_masses_reduced(const mbsr_small_masses *small);

/* The next state of a run of the reduced model, in its momentum form, later than the last one: what
 * the neglected inertia forces are there, and what errors they have made so far, integrated along
 * the run by BDF of order 2 over the states given (implicit Euler in the first), and what fast
 * motion they excite. Give as many as the slow motion needs, such as all steps of an integrator,
 * and the states before and soon after forces or rates jump. One factorisation, and a solution for
 * each candidate. MBSR_ERR_SEQUENCE before `start`, MBSR_ERR_VALUE for a t that is not later,
 * statuses of mbsr_newton_factor. */
MBSR_API int mbsr_small_masses_step(mbsr_small_masses *small, double t, const double *y,
                                    const double *yp);

/* What has been found; pointers are valid until the next call with this object. MBSR_ERR_NULL,
 * MBSR_ERR_SEQUENCE before `start`. */
MBSR_API int mbsr_small_masses_get_report(mbsr_small_masses *small,
                                          mbsr_small_masses_report *report);

/* A start of the model with all its masses on the smooth motion near (t, q, u), which
 * mbsr_small_masses_start looked at: order 1, the state of the reduced model; order 2, that with
 * the neglected inertia forces and their rates as a load, so that the fast motion begins with an
 * amplitude of second order in the masses. q (nq), u (nu). MBSR_ERR_VALUE for another order,
 * MBSR_ERR_SEQUENCE, statuses of mbsr_dae_consistent. */
MBSR_API int mbsr_small_masses_smooth(mbsr_small_masses *small, int order, double *q, double *u);

/* The last failure; never NULL. */
MBSR_API const mbsr_error *mbsr_small_masses_error(const mbsr_small_masses *small);

#ifdef __cplusplus
}
#endif

#endif
