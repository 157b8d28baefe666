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

#include <mbsrank/dae.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct mbsr_ida mbsr_ida;

/* Event functions: writes `events` values at (t, y, yp); the driver stops where one of them changes
 * sign. Returns 0 or a status. */
typedef int (*mbsr_event_fn)(void *user, double t, const double *y, const double *yp,
                             double *value);

typedef struct mbsr_ida_opt {
    int cookie;              /* set by mbsr_default_ida_opt */
    mbsr_dae_form form;      /* default MBSR_DAE_MOMENTUM */
    double rtol;             /* relative tolerance, default 1e-6 */
    double atol;             /* of q and u, default 1e-6; for others see below */
    const double *atol_each; /* mbsr_dae_size tolerances, read at creation; NULL: atol */
    int suppress_algebraic;  /* leave algebraic variables out of the error test, default 1 */
    int watch_ranks;         /* MBSR_RANK_CHANGED where a rank changes, default 1 */
    double initial_step;     /* s; 0 (default): from y'', at most 1e-3 s */
    double max_step;         /* s; 0: none (default) */
    int max_order;           /* 1 .. 5, default 5 */
    long max_steps;          /* internal steps in one call of mbsr_ida_advance, default 1 000 000 */
    int events;              /* number of event functions, default 0 */
    mbsr_event_fn event;     /* NULL exactly when events is 0 */
    void *event_user;
} mbsr_ida_opt;

/* Unless atol_each is given, momenta are tested with the error they make in a velocity: p of a
 * joint with mass (rtol |u| + atol), where mass is its mbsr_rank_info.scale at the start, and the
 * velocities v of the index-1 form with rtol |v| + sqrt(mass) atol. Where that scale is zero, the
 * largest in the tree counts. */
MBSR_API mbsr_ida_opt mbsr_default_ida_opt(void);

/* What the integration has cost so far. Dense linear algebra, Jacobian by differences. */
typedef struct mbsr_ida_stats {
    long steps;
    long residuals;          /* evaluations of F in all, those for the Jacobian included */
    long jacobian_residuals; /* of these, for difference quotients */
    long jacobians;
    long newton_iterations;
    long newton_failures; /* iterations that did not converge; some succeed with a new Jacobian */
    long error_test_failures;
    long events; /* evaluations of the event functions */
    int last_order;
    double last_step; /* s */
} mbsr_ida_stats;

/* Creates a driver at rest. model and data must outlive it; opt == NULL means
 * mbsr_default_ida_opt(). On failure *ida is NULL and the reason in *error (which may be NULL).
 * MBSR_ERR_NULL, MBSR_ERR_NO_DEFAULT, MBSR_ERR_VALUE, MBSR_ERR_UNFINISHED, MBSR_ERR_MISMATCH,
 * MBSR_ERR_NO_MEMORY, MBSR_ERR_SOLVER. */
MBSR_API int mbsr_ida_create(const mbsr_model *model, mbsr_data *data, const mbsr_ida_opt *opt,
                             mbsr_ida **ida, mbsr_error *error);
MBSR_API void mbsr_ida_destroy(mbsr_ida *ida); /* NULL is allowed */

/* Sets the state at t and clears the statistics; may be called again for another run. y and yp
 * (mbsr_dae_size numbers) must be consistent (see mbsr_dae_consistent). Arguments that are not
 * finite are refused with MBSR_NOT_FINITE and change nothing. The residual is evaluated once; if it
 * fails its status is returned and the driver is left without a state. MBSR_ERR_NULL,
 * MBSR_ERR_SOLVER. */
MBSR_API int mbsr_ida_start(mbsr_ida *ida, double t, const double *y, const double *yp);

/* Integrates to t_end (either direction of time) or to the first event before it, and writes time
 * and state there. The steps are IDA's own, the result interpolated (dense output): where output is
 * asked for does not change the steps. IDA usually steps past t_end before it interpolates, so the
 * model must be defined a little further than the last t_end. Later calls go on in the direction of
 * the first; a t_end where the integration already is gives the state there. t, y and yp may each
 * be NULL. Returns MBSR_OK at t_end, MBSR_EVENT at an event, MBSR_ERR_SEQUENCE before
 * mbsr_ida_start, MBSR_ERR_VALUE for a t_end that is not finite, behind the present, or too close
 * to the start, and for an entry of y whose tolerance is zero, MBSR_ERR_SOLVER when IDA gives up,
 * or, when the residual or an event function failed for good, the status of that failure. A
 * recoverable failure of the residual is one for good when shorter steps do not help, or when it
 * comes back again and again at one time that they do not pass. On failure t, y and yp are not
 * written. When max_steps was too small the call may be repeated to go on; after other failures of
 * the integration mbsr_ida_start begins anew. */
MBSR_API int mbsr_ida_advance(mbsr_ida *ida, double t_end, double *t, double *y, double *yp);

/* After MBSR_EVENT: direction of each event function, +1 rising, -1 falling, 0 not involved.
 * direction: events ints. MBSR_ERR_NULL, MBSR_ERR_SEQUENCE when the last call of mbsr_ida_advance
 * did not end in an event. */
MBSR_API int mbsr_ida_event_info(const mbsr_ida *ida, int *direction);

/* k-th derivative of y at a time within the last step, from IDA's interpolation polynomial; k from
 * 0 to the order of that step. dky: mbsr_dae_size numbers. MBSR_ERR_NULL, MBSR_ERR_SEQUENCE before
 * the first step, MBSR_ERR_VALUE. */
MBSR_API int mbsr_ida_dense(mbsr_ida *ida, double t, int k, double *dky);

/* MBSR_ERR_NULL. */
MBSR_API int mbsr_ida_get_stats(const mbsr_ida *ida, mbsr_ida_stats *stats);

/* The last failure; never NULL. */
MBSR_API const mbsr_error *mbsr_ida_error(const mbsr_ida *ida);

/* IDA's own memory, for any IDAGet/IDASet call not offered here; owned by the driver. */
MBSR_API void *mbsr_ida_memory(const mbsr_ida *ida);

#ifdef __cplusplus
}
#endif

#endif
