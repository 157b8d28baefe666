/* Steps of fixed size and bounded cost, for real time, games and co-simulation.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Where the driver (ida.h) chooses its steps by the error, a stepper takes the step it is told,
 * in an amount of work that is bounded beforehand. Its methods are one-step methods for the
 * momentum form (dae.h), L-stable, of order 1 or 2; the end of each step satisfies the algebraic
 * equations: loops are closed, forces without mass balance. Each stage is solved by corrections
 * with the Newton systems of newton.h, on the tree.
 *
 *   mbsr_stepper *stepper;
 *   mbsr_stepper_opt opt = mbsr_default_stepper_opt();
 *   opt.h = 1e-3;
 *   mbsr_stepper_create(model, data, &opt, &stepper, &error);
 *   mbsr_stepper_start(stepper, 0.0, q, u);
 *   for (;;) {
 *       torque = ...;                             (held over the step, see mbsr_stored_force)
 *       if (mbsr_stepper_step(stepper)) ...     the state is as it was, mbsr_stepper_error says why
 *       mbsr_body_pose(model, data, body, ...);   data is at mbsr_stage_velocities of the new state
 *   }
 *
 * docs/real_time.md has the methods, what they cost and their limits. */
#ifndef MBSRANK_STEPPER_H
#define MBSRANK_STEPPER_H

#include <mbsrank/newton.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct mbsr_stepper mbsr_stepper;

typedef struct mbsr_stepper_opt {
    int cookie;       /* set by mbsr_default_stepper_opt */
    double h;         /* s, of mbsr_stepper_step; default 1e-3 */
    int order;        /* 1: implicit Euler, or 2 (default): SDIRK of two stages */
    int halvings;     /* how often a step that fails is halved, 0 .. 10; default 4: to h / 16 */
    int corrections;  /* of Newton's method in a stage, at most, 2 .. 100; default 12 */
    int matrix_steps; /* substeps of one length that a matrix serves at most, as long as corrections
                       * are fast; default 1: a new one each, so that all steps cost the same */
    double tolerance; /* what Newton's method leaves, in 1 rad and in the length typical of the tree
                       * (mean radius of gyration of its bodies): 1e-3 at most; default 1e-9 */
    int watch_energy; /* 1 (default): steps that make energy are braked, see below; 0: not */
    mbsr_newton_opt newton; /* default mbsr_default_newton_opt(); must not leave elements out */
} mbsr_stepper_opt;

MBSR_API mbsr_stepper_opt mbsr_default_stepper_opt(void);

/* Operations: of one step, or most of them. */
typedef struct mbsr_stepper_work {
    int factorisations; /* mbsr_newton_factor */
    int residuals;      /* mbsr_dae_residual */
    int solves;         /* mbsr_newton_solve */
    int attempts;       /* at a substep; each takes positions, velocities and energy besides */
    int substeps;       /* 1 where nothing had to be halved */
} mbsr_stepper_work;

/* With H = halvings, N = corrections and the order O a step takes at most
 *
 *   A = 2^(H + 1) - 1 attempts, and 2^H more of order 1 with 4 N corrections, the last resorts,
 *   C = (A O + 4 2^H) N residuals and 2 C solves, C + A O + 2^H factorisations,
 *
 * and with closures A O + 2^H residuals more. An ordinary step takes one attempt, with 1
 * factorisation and 2 or 3 residuals and solves for each order. */
typedef struct mbsr_stepper_info {
    long steps, refused;     /* since the start */
    long last_resorts;       /* substeps tried by the last resort */
    long braked;             /* substeps whose velocities were braked */
    mbsr_stepper_work last;  /* of the last step, refused or not */
    mbsr_stepper_work most;  /* of any step since the start, number by number */
    mbsr_stepper_work bound; /* of any step at all */
    size_t bytes;            /* memory of the object */
} mbsr_stepper_info;

/* Creates a stepper without a state. model and data, which the stepper evaluates in, must
 * outlive it; opt == NULL means mbsr_default_stepper_opt(). Memory is taken from the model's
 * allocator here, for a short time by mbsr_stepper_start, and nowhere else. One object and its
 * data belong to one thread. On failure *stepper is NULL and the reason in *error (which may be
 * NULL). MBSR_ERR_NULL, MBSR_ERR_NO_DEFAULT, MBSR_ERR_UNFINISHED, MBSR_ERR_MISMATCH,
 * MBSR_ERR_LEAN (lean data), MBSR_ERR_VALUE (an option out of range; a Newton solver that is not
 * exact), MBSR_ERR_NO_MEMORY and the statuses of mbsr_newton_create. */
MBSR_API int mbsr_stepper_create(const mbsr_model *model, mbsr_data *data,
                                 const mbsr_stepper_opt *opt, mbsr_stepper **stepper,
                                 mbsr_error *error);
MBSR_API void mbsr_stepper_destroy(mbsr_stepper *stepper); /* NULL is allowed */

/* Starts at t (s) with the consistent state nearest to q (nq), u (nu), as mbsr_dae_consistent
 * finds it; clears the counts. May be called again. On failure the state is as it was before.
 * MBSR_ERR_NULL, and the statuses of mbsr_dae_pack, mbsr_dae_consistent, mbsr_stage_positions,
 * mbsr_stage_velocities and mbsr_energy. */
MBSR_API int mbsr_stepper_start(mbsr_stepper *stepper, double t, const double *q, const double *u);

/* One step: by opt.h, to the start (or the last mbsr_stepper_to) and a multiple of it, so that
 * rounding of t does not add up; or to t_end (s). Functions of time are read in between, inputs
 * that the caller holds (mbsr_stored_force) may be set before. A step that fails is halved, its
 * halves likewise. Afterwards data is at mbsr_stage_velocities of the state, whose quaternions have
 * length 1. The same state, inputs and options give the same bits.
 *
 * Where the root rests, and neither joints nor closures follow functions of time, the energy of
 * mbsr_energy is kept from growing: where it exceeds what it was at an earlier time and what
 * elements without an energy may have fed since by more than a hundredth of the kinetic energy,
 * velocities are multiplied by a number between a half and 1, and a step that exceeds it by much
 * is halved before.
 *
 * Refused with a status > 0 where no substep of h / 2^halvings succeeds either:
 * MBSR_NO_CONVERGENCE, MBSR_NOT_FINITE, MBSR_SINGULAR_BLOCK, MBSR_LOOP_SINGULAR, and other
 * statuses of the residual and of Newton systems; at once with one < 0 that a callback returned.
 * Both are handed through unchanged, with a text that names the cause, and leave t and the state
 * exactly as they were. MBSR_ERR_NULL, MBSR_ERR_SEQUENCE before a start, MBSR_ERR_VALUE for a
 * t_end that is not finite or not later than t, or a step that t + h does not show. */
MBSR_API int mbsr_stepper_step(mbsr_stepper *stepper);
MBSR_API int mbsr_stepper_to(mbsr_stepper *stepper, double t_end);

/* The present state; t, q (nq) and u (nu) may each be NULL. MBSR_ERR_NULL, MBSR_ERR_SEQUENCE
 * before a start. */
MBSR_API int mbsr_stepper_motion(mbsr_stepper *stepper, double *t, double *q, double *u);

/* The state as y and y' of the momentum form (mbsr_dae_size numbers each, either may be NULL):
 * with both mbsr_stepper_resume goes on there, later or in another stepper of the same model, as
 * if nothing had happened between but for the account of energy, which is opened anew (a
 * rejected step of a co-simulation, a game that is loaded); with closures, in data that leave
 * out the same rows (mbsr_closures_set_redundant). y' holds the loop forces lambda
 * (mbsr_closures_set_lambda), Lambda itself begins at zero in each step. On failure of resume the
 * state is as it was before. MBSR_ERR_NULL, MBSR_ERR_SEQUENCE; resume: MBSR_NOT_FINITE, the
 * statuses of mbsr_stage_positions, mbsr_stage_velocities and mbsr_energy. */
MBSR_API int mbsr_stepper_state(mbsr_stepper *stepper, double *t, double *y, double *yp);
MBSR_API int mbsr_stepper_resume(mbsr_stepper *stepper, double t, const double *y,
                                 const double *yp);

/* Says that something has changed that has an energy, such as an element switched on
 * (mbsr_force_switch) or the rest length of a spring of your own: what mbsr_energy says now is
 * what may be there. Forces held need not be told. Statuses of mbsr_stepper_resume;
 * MBSR_ERR_SEQUENCE before a start. */
MBSR_API int mbsr_stepper_jump(mbsr_stepper *stepper);

/* Work of the last step, the most so far, and the bound. MBSR_ERR_NULL. */
MBSR_API int mbsr_stepper_get_info(const mbsr_stepper *stepper, mbsr_stepper_info *info);

/* The last failure; never NULL. */
MBSR_API const mbsr_error *mbsr_stepper_error(const mbsr_stepper *stepper);

#ifdef __cplusplus
}
#endif

#endif
