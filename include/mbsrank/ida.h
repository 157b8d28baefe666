/* Driver: integrates a model with SUNDIALS IDA (component ida).
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The driver owns its SUNDIALS objects; the SUNDIALS headers are not needed to use it. One driver
 * belongs to one data and one thread. Statuses are those of the library and of the callbacks; a
 * failure inside IDA is MBSR_ERR_SOLVER with IDA's flag and message in the text. Nothing is
 * printed.
 *
 * Where SUNDIALS notices that it gets no memory for a new driver, the status is MBSR_ERR_NO_MEMORY;
 * its versions up to 7.1 do not check every allocation, and 6 prints when IDACreate gets none. */
#ifndef MBSRANK_IDA_H
#define MBSRANK_IDA_H

#include <mbsrank/closure.h>
#include <mbsrank/newton.h>
#include <mbsrank/small_masses.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct mbsr_ida mbsr_ida;

/* Event functions: writes `events` values at (t, y, yp); the driver stops where one of them changes
 * sign. Returns 0 or a status. */
typedef int (*mbsr_event_fn)(void *user, double t, const double *y, const double *yp,
                             double *value);

/* How far a run is, for a progress function. */
typedef struct mbsr_ida_progress {
    double t;    /* s, the end of the last step */
    long steps;  /* since mbsr_ida_start */
    double step; /* s, the last one; negative backwards in time */
    int order;   /* of the last one */
} mbsr_ida_progress;

/* Called between two steps. Returns 0 or a status that stops the run there: mbsr_ida_advance and
 * mbsr_ida_run return it, and the next call goes on as if there had been no stop. May call
 * mbsr_ida_dense and mbsr_ida_get_stats. */
typedef int (*mbsr_ida_progress_fn)(void *user, const mbsr_ida_progress *now);

/* Receives the state of output time `index`: y and yp, mbsr_dae_size numbers, valid during the call
 * only. Returns 0 or a status that stops the run, as above. */
typedef int (*mbsr_ida_output_fn)(void *user, int index, double t, const double *y,
                                  const double *yp);

/* Names the next kink beyond t, strictly, in the direction of the run, +1 or -1: next arrives as
 * {direction * INFINITY, 1}, which is none. Returns 0 or a status that ends the call. */
typedef int (*mbsr_kink_fn)(void *user, double t, int direction, mbsr_kink *next);

/* What solves the linear systems of the Newton iterations. */
typedef enum mbsr_ida_solver {
    MBSR_IDA_AUTO = 0,  /* momentum form: TREE if it is exact, else KRYLOV; DENSE for the other
                         * forms and for models whose joints newton.h does not serve */
    MBSR_IDA_DENSE = 1, /* a matrix by difference quotients: O(N^2) in memory and for each step,
                         * O(N^3) for each Jacobian */
    MBSR_IDA_TREE = 2,  /* mbsr_newton: O(N) in memory, for each step and each Jacobian. Where
                         * force elements across the tree are left out of it (mbsr_newton_info.exact
                         * is 0), Newton's iterations converge slowly or not at all */
    MBSR_IDA_KRYLOV = 3 /* SPGMR (GMRES), preconditioned by mbsr_newton; on difference quotients, or
                         * with newton.products on products (mbsr_newton_multiply) */
} mbsr_ida_solver;

typedef struct mbsr_ida_opt {
    int cookie;              /* set by mbsr_default_ida_opt */
    mbsr_dae_form form;      /* default MBSR_DAE_MOMENTUM */
    double rtol;             /* relative tolerance, default 1e-6 */
    double atol;             /* of q and u, default 1e-6; for others see below */
    const double *atol_each; /* mbsr_dae_size tolerances, read at creation; NULL: atol */
    /* atol by kind of variable (mbsr_coordinate_kind); 0 (default): atol. Not with atol_each */
    double atol_angle;            /* rad, and numbers of quaternions */
    double atol_length;           /* m */
    double atol_angular_velocity; /* rad/s */
    double atol_velocity;         /* m/s */
    int max_norm; /* errors are measured by the largest entry, not by the root of their mean square;
                   * default 0, see below */
    int suppress_algebraic;        /* leave algebraic variables out of the error test, default 1 */
    int watch_ranks;               /* MBSR_RANK_CHANGED where a rank changes, default 1 */
    mbsr_ida_solver linear_solver; /* default MBSR_IDA_AUTO; TREE and KRYLOV: momentum form only */
    mbsr_newton_opt newton;        /* of TREE and KRYLOV, default mbsr_default_newton_opt() */
    int renew_matrices; /* TREE: steps begin with a new matrix where the old one has become wrong,
                         * default 1, see below */
    int krylov_size;    /* vectors that KRYLOV spans a solution by at most, default 30 */
    int raw_outputs; /* 1: states are handed out as they are interpolated, default 0, see below */
    double initial_step; /* s; 0 (default): from y'', see below */
    double max_step;     /* s; 0: none (default) */
    int max_order;       /* 1 .. 5, default 5 */
    long max_steps;      /* internal steps in one call of mbsr_ida_advance, default 1 000 000 */
    int events;          /* number of event functions, default 0 */
    mbsr_event_fn event; /* NULL exactly when events is 0 */
    void *event_user;
    mbsr_kink_fn kink; /* kinks besides those of the model's tables (mbsr_model_kink); NULL
                        * (default): none */
    void *kink_user;
    mbsr_ida_progress_fn progress; /* NULL (default): none */
    void *progress_user;
    long progress_steps;      /* steps between its calls, default 1 */
    double progress_interval; /* s of real time between its calls at least, default 0 */
} mbsr_ida_opt;

/* Unless atol_each is given, momenta are tested by the error they make in a velocity. With mass
 * that of mbsr_momentum_scales at the start, for index-1 velocities the mbsr_rank_info.scale of the
 * joint (where that is zero, the smallest of mbsr_momentum_scales there), and atol that of the
 * joint's u, for index-1 velocities the smallest of the joint's, tolerances are
 *
 *   momentum p             mass (rtol |u| + atol)
 *   index-1 velocity v     rtol |v| + sqrt(mass) atol
 *
 * In a joint that turns and moves, or joints of a group that do (mbsr_body_group), errors of the
 * one kind may have the energy that the other kind's may: with E the largest sqrt(mass) atol of the
 * rates, mass rtol |u| + sqrt(mass) E and rtol |v| + E, the same in all units, whatever the size of
 * the body.
 *
 * In models with closures errors e_p of momenta are tested together by the velocities that they
 * make with the loops closed, e_u in (., ., e_u, .) = K^-1 (0, c e_p, 0, 0) with K = dF/dy + c
 * dF/dy', against rtol |u| + atol of the velocities, 1.5 times more strictly, where that is less:
 * docs/closed_loops.md. Not so with atol_each, or a linear solver without matrices.
 *
 * IDA measures errors by sqrt(sum (e_k / tolerance_k)^2 / n) over the n entries of y: in a large
 * system the error of one body alone may exceed its tolerances sqrt(n) times. With max_norm no
 * entry may exceed its own, in the error test as in the test for convergence of Newton's
 * iterations, at the price of shorter steps; the measure is max |e_k| / tolerance_k then. Entries
 * that the error test leaves out (suppress_algebraic) are left out of it here too.
 *
 * The first step, unless it is given, makes an error h^2 y'' / 2 of half the tolerances, and is at
 * most 1e-3 of the time in which a velocity that errs by its tolerance moves its coordinate by that
 * one's: the least of atol of a coordinate / atol of its velocity, 1 s where they are equal.
 * Tolerances that are given in the units of the model (by kind, or atol_each) make it, as all other
 * steps, independent of these units. With index-1 velocities that have tolerances of their own it
 * is 1e-3 s.
 *
 * States are handed out completed (completion.h): IDA interpolates y between its steps, and what
 * the error test leaves out, u of directions without mass, loop forces and y', is worth much less
 * there than q and the momenta. A state costs about as much as one or two steps; one whose massless
 * directions springs alone hold (index 2) four to ten. raw_outputs = 1 hands out what is
 * interpolated. mbsr_ida_dense, event functions and progress functions see that always. A state
 * that cannot be completed is handed out as it was interpolated, and counts (raw_states).
 *
 * IDA keeps a matrix of Newton's method until the step changes or the iteration fails. On the tree
 * a new one takes no more than two residuals, and what an old one leaves grows from step to step:
 * with renew_matrices the driver measures how wrong the old one is and makes a new one in time
 * (docs/dae_forms.md), unless bodies are flexible or many force elements lie across the tree.
 * Without, matrices live as long as IDA lets them. */
MBSR_API mbsr_ida_opt mbsr_default_ida_opt(void);

/* What the integration has cost so far. */
typedef struct mbsr_ida_stats {
    long steps;
    long residuals;          /* evaluations of F in all, those for difference quotients included */
    long jacobian_residuals; /* of these, for difference quotients */
    long jacobians;          /* DENSE, TREE: that IDA asked for */
    long newton_iterations;
    long newton_failures; /* iterations that did not converge; some succeed with a new Jacobian */
    long error_test_failures;
    long events;     /* evaluations of the event functions */
    long raw_states; /* handed out as interpolated, though completed ones were asked for: they could
                        not be found */
    int last_order;
    double last_step;              /* s */
    mbsr_ida_solver linear_solver; /* the one that runs: DENSE, TREE or KRYLOV */
    long factorisations;           /* of the matrix, or mbsr_newton_factor */
    long solves;                   /* with them; KRYLOV: as preconditioner */
    long krylov_iterations;
    /* Stiff force elements (docs/dae_forms.md): */
    long stiff_tests;      /* error tests failed by momenta in a stiff direction alone */
    long stiff_iterations; /* Newton's method failed twice within 10 steps, or a matrix of
                            * difference quotients was wrong */
    long careful_attempts; /* steps tried with a new matrix in each iteration and filtered tests */
    long careful_failures; /* of these, those in which Newton's method did not converge */
    long filter_solves;    /* solutions for these tests, contained in solves */
    long renewals; /* steps that began with a new matrix (renew_matrices); each takes a solution
                      more */
} mbsr_ida_stats;

/* Creates a driver at rest. model and data must outlive it; opt == NULL means
 * mbsr_default_ida_opt(). On failure *ida is NULL and the reason in *error (which may be NULL).
 * MBSR_ERR_NULL, MBSR_ERR_NO_DEFAULT, MBSR_ERR_VALUE, MBSR_ERR_UNFINISHED, MBSR_ERR_MISMATCH,
 * MBSR_ERR_NO_MEMORY, MBSR_ERR_SOLVER, and unless DENSE is asked for the statuses of
 * mbsr_newton_create. */
MBSR_API int mbsr_ida_create(const mbsr_model *model, mbsr_data *data, const mbsr_ida_opt *opt,
                             mbsr_ida **ida, mbsr_error *error);
MBSR_API void mbsr_ida_destroy(mbsr_ida *ida); /* NULL is allowed */

/* Sets the state at t and clears the statistics; may be called again for another run. y and yp
 * (mbsr_dae_size numbers) must be consistent (see mbsr_dae_consistent). Arguments that are not
 * finite are refused with MBSR_NOT_FINITE and change nothing. The residual is evaluated; if it
 * fails its status is returned and the driver is left without a state. So it is after
 * MBSR_UNDETERMINED: a joint rate that moves no mass and that no force determines, which
 * mbsr_dae_consistent refuses too (where ranks are deficient, an index report of the state may be
 * made, see index.h), and after MBSR_NO_CONVERGENCE: forces along directions without mass are off
 * balance by more than a thousandth of them, and a Newton step towards it changes the state by more
 * than 1e4 tolerances (mbsr_dae_imbalance; not with closures). MBSR_ERR_NULL, MBSR_ERR_SOLVER. */
MBSR_API int mbsr_ida_start(mbsr_ida *ida, double t, const double *y, const double *yp);

/* Integrates to t_end (either direction of time) or to the first event before it, and writes time
 * and state there. The steps are IDA's own, q and the momenta interpolated (dense output);
 * velocities of what has no mass, loop forces and all of y' solve the equations there
 * (completion.h), unless raw_outputs is set: where output is asked for does not change the steps.
 * IDA usually steps past t_end before it interpolates, so the model must be defined a little
 * further than the last t_end. Later calls go on in the direction of the first; a t_end where the
 * integration already is, the start among them, gives the state there. t, y and yp may each be
 * NULL; on failure they are not written.
 *
 * MBSR_OK at t_end; MBSR_EVENT at an event; MBSR_ERR_SEQUENCE before mbsr_ida_start; MBSR_ERR_VALUE
 * for a t_end that is not finite or behind the present, and for an entry of y whose tolerance is
 * zero; MBSR_ERR_SOLVER when IDA gives up, or 10000 steps in a row do not move the time, as where
 * rates grow beyond all bounds; else the status of the residual or the event function that failed.
 * A recoverable status of the residual ends the run only when shorter steps do not help, or when it
 * returns again and again at a time that the steps do not pass. If max_steps was too small, the
 * same call goes on; after other failures of the integration mbsr_ida_start begins anew, from the
 * last good state if that is wanted (mbsr_ida_state).
 *
 * With watch_ranks the ranks of the start are watched during the call; afterwards the data is
 * watched as it was before (mbsr_rank_watch). */
MBSR_API int mbsr_ida_advance(mbsr_ida *ida, double t_end, double *t, double *y, double *yp);

/* Says that something the equations read has jumped at the present time: a force that the caller
 * has set anew, a switch. The next call goes on with q and the momenta as they are, u and y' found
 * again, and the order of the steps is restarted; statistics go on. (mbsr_ida_start begins another
 * run.) MBSR_ERR_NULL, MBSR_ERR_SEQUENCE. */
MBSR_API int mbsr_ida_jump(mbsr_ida *ida);

/* One period of a sampled control: as mbsr_ida_jump, which takes the inputs set for it, and then
 * mbsr_ida_advance to t_end, where the last step ends: nothing is evaluated beyond. t_end need not
 * be the next kink. After MBSR_EVENT, a stop by a callback, or too few max_steps the same call
 * goes on. Statuses of mbsr_ida_advance. */
MBSR_API int mbsr_ida_sample(mbsr_ida *ida, double t_end, double *t, double *y, double *yp);

/* Integrates over the output times times[*next .. count-1], which follow each other in the run's
 * direction of time, and calls `output` at each, with the result interpolated as by
 * mbsr_ida_advance; one of them may be the present time. *next, 0 in the first call, becomes the
 * index of the first time not given out yet: after MBSR_EVENT, a stop by a callback, or too few
 * max_steps the same call goes on; mbsr_ida_state then has the state at that point. MBSR_OK when
 * all times are given out, MBSR_ERR_NULL, MBSR_ERR_VALUE (count, *next or a time that does not
 * fit), what `output` returned, and the statuses of mbsr_ida_advance. */
MBSR_API int mbsr_ida_run(mbsr_ida *ida, int count, const double *times, int *next,
                          mbsr_ida_output_fn output, void *user);

/* The state that the run has reached; t, y and yp may each be NULL. After a failure that ended the
 * run it is the last good one: the end of the last step that succeeded, which may be later than the
 * last output, or the start if none did. MBSR_ERR_NULL, MBSR_ERR_SEQUENCE without a state: before
 * mbsr_ida_start, and after one that failed. */
MBSR_API int mbsr_ida_state(mbsr_ida *ida, double *t, double *y, double *yp);

/* The state of mbsr_ida_state in joint coordinates: q (nq), u and accelerations u' (nu), loop
 * forces lambda (m numbers, those of stiff rows included); each may be NULL. The data is then at
 * mbsr_stage_accelerations there, so that poses, twists, accelerations, reactions, energies and
 * what force elements exert can be asked for at once. MBSR_ERR_NULL, MBSR_ERR_SEQUENCE,
 * MBSR_ERR_VALUE (the index-1 form as it is interpolated), statuses of the residual. */
MBSR_API int mbsr_ida_motion(mbsr_ida *ida, double *q, double *u, double *udot, double *lambda);

/* After MBSR_EVENT: direction of each event function, +1 rising, -1 falling, 0 not involved.
 * direction: events ints. MBSR_ERR_NULL, MBSR_ERR_SEQUENCE when the last call of mbsr_ida_advance
 * (or mbsr_ida_run) did not end in an event. */
MBSR_API int mbsr_ida_event_info(const mbsr_ida *ida, int *direction);

/* The k-th derivative of y at a time within the last step, from IDA's interpolation polynomial; k
 * from 0 to the order of that step. dky: mbsr_dae_size numbers. MBSR_ERR_NULL, MBSR_ERR_SEQUENCE
 * before the first step, MBSR_ERR_VALUE for another k or t: nothing is extrapolated. */
MBSR_API int mbsr_ida_dense(mbsr_ida *ida, double t, int k, double *dky);

/* What has been integrated since the start has cost. MBSR_ERR_NULL. */
MBSR_API int mbsr_ida_get_stats(const mbsr_ida *ida, mbsr_ida_stats *stats);

/* How far the present state, the last good one after a failure, is from what should hold. */
typedef struct mbsr_ida_drift {
    double gap;         /* largest |g| of closures, m or rad */
    double largest_gap; /* of this and of states at which mbsr_ida_advance has ended, one a step */
    double rate;        /* largest |C u + g_t| of closures */
    double energy; /* kinetic and potential, J; force elements without an energy count for nothing,
                      stiff rows of closures with the energy of their forces, s^2 / 2 k */
    double energy_change; /* since mbsr_ida_start: with neither dampers nor motors the driver's
                             error */
} mbsr_ida_drift;

/* Evaluates positions and velocities in the driver's data. MBSR_ERR_NULL, MBSR_ERR_SEQUENCE before
 * mbsr_ida_start, MBSR_NOT_FINITE, and what the functions of joints, elements and closures return.
 */
MBSR_API int mbsr_ida_get_drift(mbsr_ida *ida, mbsr_ida_drift *drift);

/* The force elements that make the model stiff, largest first: at most `most` ids into force, and
 * their shares of what all elements together do, 0 to 1, into share; *count is how many. Where an
 * error test found last that a stiff direction alone failed it (stiff_tests) it is what they do
 * against a motion in that direction, stiffness and damping over the step; where Newton's method
 * failed last in a step tried carefully (careful_failures), the sum of that over mass for the
 * single coordinates that move mass. Where neither has told anything, or in the index-1 form or
 * with closures, and error tests or Newton's method have ended the run, it is that at the last
 * state. Elements with neither energy nor dissipation are not seen, nor, of single coordinates,
 * where all of them are slow beside the longest step. None, and MBSR_OK, else. The data is left at
 * that state. When the driver gives up, its error names the first. MBSR_ERR_NULL, and the statuses
 * of mbsr_stage_positions, mbsr_energy and mbsr_force_power. */
MBSR_API int mbsr_ida_stiffest(mbsr_ida *ida, int most, int *force, double *share, int *count);

/* The last failure; never NULL. */
MBSR_API const mbsr_error *mbsr_ida_error(const mbsr_ida *ida);

/* The Newton solver of TREE and KRYLOV, for mbsr_newton_get_info; owned by the driver. NULL with
 * DENSE. */
MBSR_API const mbsr_newton *mbsr_ida_newton(const mbsr_ida *ida);

/* IDA's own memory, for any IDAGet/IDASet call not offered here; owned by the driver. */
MBSR_API void *mbsr_ida_memory(const mbsr_ida *ida);

/* Integrates the reduced model of a report on small masses from its start to t_end (later than
 * that) and takes every step, and the states before kinks of derivative 1, into the report: the
 * errors of its zeros along the run, a check after the fact, and what fast motion is excited. opt
 * as for mbsr_ida_create, with the momentum form; its progress function is called after every step.
 * stats and error may be NULL. MBSR_ERR_NULL, MBSR_ERR_SEQUENCE (before mbsr_small_masses_start),
 * MBSR_ERR_VALUE (another form), MBSR_SINGULAR_BLOCK where the smooth motion ends in a jump, with
 * the joint that runs away; statuses of mbsr_ida_create, mbsr_ida_start, mbsr_ida_advance and
 * mbsr_small_masses_step. */
MBSR_API int mbsr_small_masses_run(mbsr_small_masses *small, const mbsr_ida_opt *opt, double t_end,
                                   mbsr_ida_stats *stats, mbsr_error *error);

#ifdef __cplusplus
}
#endif

#endif
