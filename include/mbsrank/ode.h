/* The equations of motion as an explicit ODE, for explicit methods, CVODE, ARKODE.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * x = (q, p) with the generalised momenta p = (joint-space mass matrix) u. The velocities in
 * massless directions are no states: Newton's method finds them inside from the balance of forces
 * gamma(q, u, t) = 0. So every massless direction must be damped (differential index 1; see
 * mbsr_index_report_create). */
#ifndef MBSRANK_ODE_H
#define MBSRANK_ODE_H

#include <mbsrank/dae.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct mbsr_ode mbsr_ode;

/* Prepares the right-hand side at a state: the massless directions there are counted and grouped
 * into those that forces couple. model and data must outlive the object, data is used by it. After
 * this no call allocates. MBSR_RANK_CHANGED is returned later where the number of directions
 * changes. All statuses of the stages in dynamics.h, MBSR_ERR_CLOSURES, MBSR_ERR_NO_MEMORY; the
 * text is in mbsr_data_error. On failure *ode is NULL. */
MBSR_API int mbsr_ode_create(const mbsr_model *model, mbsr_data *data, double t, const double *q,
                             const double *u, mbsr_ode **ode);
MBSR_API void mbsr_ode_destroy(mbsr_ode *ode); /* NULL is allowed */

/* Length of x: nq + nu. */
MBSR_API int mbsr_ode_size(const mbsr_ode *ode);

/* State to x, and x to velocities u (nu). u on entry is the start of Newton's iteration and decides
 * nothing else; on failure it is unchanged. MBSR_NO_CONVERGENCE, MBSR_RANK_CHANGED and the statuses
 * of the stages; MBSR_UNDETERMINED names a body in whose massless direction no force changes with
 * velocity by more than rounding makes of a zero, at steps from 1e-11 to 1e6 times the velocities.
 * A direction that is damped so weakly that short differences do not show it costs some 40
 * evaluations of the forces in each Newton step. */
MBSR_API int mbsr_ode_pack(mbsr_ode *ode, double t, const double *q, const double *u, double *x);
MBSR_API int mbsr_ode_velocities(mbsr_ode *ode, double t, const double *x, double *u);

/* The right-hand side x' = (G u, p') at (t, x). Newton's iteration starts from the velocities of
 * the call before. Cost: a momentum residual, and for each Newton step as many evaluations of the
 * forces as the largest coupled group has directions: O(N) when the massless bodies are isolated.
 * Statuses as mbsr_ode_velocities. xdot must not overlap x. */
MBSR_API int mbsr_ode_rhs(mbsr_ode *ode, double t, const double *x, double *xdot);

/* Newton steps and evaluations of the forces since mbsr_ode_create. Outputs may be NULL. */
MBSR_API int mbsr_ode_stats(const mbsr_ode *ode, long *newton_steps, long *evaluations);

#ifdef __cplusplus
}
#endif

#endif
