/* Sensitivities of runs: how a motion changes with parameters of its model (component ida).
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   mbsr_sensitivity_opt opt = mbsr_default_sensitivity_opt();
 *   opt.list = list, opt.parameters = 2, opt.which = which;      parameters.h
 *   mbsr_sensitivity_create(model, &opt, &s, &error);
 *   mbsr_sensitivity_run(s, 0.0, q, u, times, time, q_at, u_at);
 *   mbsr_sensitivity_forward(s, dq, du);          each parameter: O(N) a step
 *   mbsr_sensitivity_adjoint(s, w_q, w_u, by);    all parameters together: O(N) a step
 *
 * The run is one of the driver (ida.h) in the momentum form, which keeps the ends of its steps.
 * Along these the linearised equations are solved,
 *
 *   dF/dy s + dF/dy' s' = dF/dtau d(tau)/d(parameter)
 *
 * with tau the result of inverse dynamics (derivatives.h), by the formulas of the same steps and
 * orders (backward differences) as the run. The adjoint solves the transposes of the very same
 * systems, from the last step to the first. So both give the same numbers but for rounding. The
 * driver's error test does not see them: the run is made with a tenth of the tolerances that
 * opt.ida asks for, steps that are too long for what a parameter would set swinging are divided
 * afterwards, and errors are within 100 of these tolerances, but where contacts of an exponent
 * below 2 begin and end, and behind a start next to one at which forces leave a rate undetermined,
 * which changes faster than the steps follow: there tighter tolerances show what numbers are worth.
 * docs/study.md says how much more, and what sensitivities cost. */
#ifndef MBSRANK_SENSITIVITY_H
#define MBSRANK_SENSITIVITY_H

#include <mbsrank/ida.h>
#include <mbsrank/parameters.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct mbsr_sensitivity mbsr_sensitivity;

typedef struct mbsr_sensitivity_opt {
    int cookie;                  /* set by mbsr_default_sensitivity_opt */
    mbsr_ida_opt ida;            /* of the run; the momentum form, no event functions */
    int parameters;              /* how many, at least 1 */
    const int *which;            /* their numbers in the list */
    const mbsr_parameters *list; /* made of the model; is not needed after the creation */
} mbsr_sensitivity_opt;

MBSR_API mbsr_sensitivity_opt mbsr_default_sensitivity_opt(void);

/* Creates an object for a finished model, which must outlive it; one object belongs to one thread.
 * On failure *sensitivity is NULL and the reason in *error (may be NULL). MBSR_ERR_NULL,
 * MBSR_ERR_NO_DEFAULT, MBSR_ERR_VALUE (count, form, events), MBSR_ERR_ID (which[k]),
 * MBSR_ERR_NO_MEMORY; MBSR_ERR_SPACE for what has no derivatives, by name: see
 * mbsr_derivatives_parameters, and frames of joints in models with closures, which they would open;
 * statuses of mbsr_derivatives_create, mbsr_newton_create and mbsr_ida_create. */
MBSR_API int mbsr_sensitivity_create(const mbsr_model *model, const mbsr_sensitivity_opt *opt,
                                     mbsr_sensitivity **sensitivity, mbsr_error *error);
MBSR_API void mbsr_sensitivity_destroy(mbsr_sensitivity *sensitivity); /* NULL is allowed */

/* Runs from the state that mbsr_dae_consistent makes of q (nq; NULL: all coordinates zero,
 * quaternions 1) and u (nu; NULL: at rest) at t0, over time[0 .. times-1], increasing and not
 * before t0. q_at (times x nq) and u_at (times x nu): the states there, one behind the other; may
 * be NULL. Steps are kept, 16 bytes for each number of y and step, and solvers for forward and
 * adjoint made, by malloc and the model's allocator. What the equations read must be functions of
 * time and state alone: it is read again later. Forces may jump at times that the model's tables or
 * opt.ida.kink name. Where an element takes another branch (`side` of its table, force.h), as
 * stops, cables, contacts, limits and teeth do, steps are divided. Forces must be continuous there:
 * those of stock elements are, but for the moments of bushings and rotation springs at half a turn.
 * Borders that no `side` tells are not noticed.
 *
 * MBSR_ERR_NULL, MBSR_ERR_VALUE (times), MBSR_NOT_FINITE; MBSR_ERR_SPACE: a mass, moment or
 * armature of zero is chosen where directions without mass are, which another value would take
 * away; a force jumps where it takes another branch; one does, springs alone hold directions
 * without mass, and frames of joints are chosen; statuses of mbsr_dae_consistent and
 * mbsr_ida_advance, MBSR_RANK_CHANGED among them. After a failure there is no run. */
MBSR_API int mbsr_sensitivity_run(mbsr_sensitivity *sensitivity, double t0, const double *q,
                                  const double *u, int times, const double *time, double *q_at,
                                  double *u_at);

/* Derivatives of q and u at the times of the run in each parameter, where q and u of the start are
 * held, but for what has no mass and follows; in models with closures as mbsr_dae_consistent has
 * made them, and so are the forces with which it has loaded settled stiff rows: dq (parameters x
 * times x nq, those of the first parameter first) and du (parameters x times x nu); either may be
 * NULL. MBSR_ERR_SEQUENCE without a run, MBSR_ERR_NO_MEMORY, statuses of mbsr_derivatives_inverse,
 * mbsr_newton_factor and mbsr_newton_solve. After a failure their contents are not specified. */
MBSR_API int mbsr_sensitivity_forward(mbsr_sensitivity *sensitivity, double *dq, double *du);

/* The gradient of a function of the states at these times: by (parameters) = sum over all times of
 * w_q . dq + w_u . du, with w_q (times x nq) and w_u (times x nu) the function's derivatives in
 * them, NULL for zero. An integral over time is a sum with the weights of a quadrature. The cost
 * does not depend on how many parameters there are, but for the few multiplications of each.
 * Statuses likewise. */
MBSR_API int mbsr_sensitivity_adjoint(mbsr_sensitivity *sensitivity, const double *w_q,
                                      const double *w_u, double *by);

/* Steps of the run that are kept; 0 without one, and for NULL. The first solution forward or
 * adjoint may have divided some. */
MBSR_API long mbsr_sensitivity_steps(const mbsr_sensitivity *sensitivity);

/* The last failure; never NULL. */
MBSR_API const mbsr_error *mbsr_sensitivity_error(const mbsr_sensitivity *sensitivity);

#ifdef __cplusplus
}
#endif

#endif
