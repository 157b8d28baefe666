/* The equations of motion as a residual F(t, y, y') = 0 for a DAE solver.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A caller's own solver needs mbsr_dae_size, mbsr_dae_id, mbsr_dae_consistent and
 * mbsr_dae_residual. */
#ifndef MBSRANK_DAE_H
#define MBSRANK_DAE_H

#include <mbsrank/dynamics.h>

#ifdef __cplusplus
extern "C" {
#endif

/*   form               y       F
 *   RECURSIVE          q, u    q' - G u;  (25), the recursion that skips rank-deficient bodies
 *   INVERSE_DYNAMICS   q, u    q' - G u;  J^T mu - tau from (9) and (11), no rank decision
 *
 * Both are linear in u' with a matrix that is singular exactly when the joint-space mass matrix
 * is. */
typedef enum mbsr_dae_form { MBSR_DAE_RECURSIVE = 1, MBSR_DAE_INVERSE_DYNAMICS = 2 } mbsr_dae_form;

/* Length of y, y' and F; -1 if the model is NULL, not finished, or the form unknown. */
MBSR_API int mbsr_dae_size(const mbsr_model *model, mbsr_dae_form form);

/* id (mbsr_dae_size numbers): 1 for differential variables, 0 for algebraic ones. In the (q, u)
 * forms which combinations of u are algebraic depends on the state, so all are marked 1.
 * MBSR_ERR_NULL, MBSR_ERR_UNFINISHED, MBSR_ERR_VALUE (unknown form). */
MBSR_API int mbsr_dae_id(const mbsr_model *model, mbsr_dae_form form, double *id);

/* State to y and back. y must not overlap q and u.  MBSR_ERR_NULL, MBSR_ERR_MISMATCH,
 * MBSR_ERR_VALUE. */
MBSR_API int mbsr_dae_pack(const mbsr_model *model, mbsr_data *data, mbsr_dae_form form, double t,
                           const double *q, const double *u, double *y);
MBSR_API int mbsr_dae_unpack(const mbsr_model *model, mbsr_data *data, mbsr_dae_form form, double t,
                             const double *y, double *q, double *u);

/* F(t, y, y'). Deterministic, allocates nothing, safe for one data a thread. Values in F are finite
 * when MBSR_OK is returned; with MBSR_NOT_FINITE the text names the first quantity that was not.
 * All statuses of the stages in dynamics.h; what a callback returned is handed through
 * unchanged. */
MBSR_API int mbsr_dae_residual(const mbsr_model *model, mbsr_data *data, mbsr_dae_form form,
                               double t, const double *y, const double *yp, double *F);

typedef struct mbsr_consistent_opt {
    int cookie;         /* set by mbsr_default_consistent_opt */
    int max_iterations; /* Newton steps for the algebraic velocities; default 20 */
    double tolerance;   /* relative size of the last Newton correction; default 1e-12 */
} mbsr_consistent_opt;

MBSR_API mbsr_consistent_opt mbsr_default_consistent_opt(void);

/* What a consistent start changed. */
typedef struct mbsr_consistent_info {
    int null_directions;    /* combinations of joint rates that move no mass */
    int iterations;         /* Newton steps taken */
    double velocity_change; /* largest |change| of an entry of u */
    double force_defect;    /* largest |gamma| (applied force in a null direction) before */
} mbsr_consistent_info;

/* A consistent start: keeps q and the momenta of y, changes u only in directions that move no mass
 * until the forces in these directions balance (gamma(q, u, t) = 0), then computes yp: u' from the
 * equations of second order and from gamma' = 0. y holds q, u and is updated; yp is an output. On
 * failure both stay as they were. opt and info may be NULL. Allocates from the model's allocator,
 * cost grows with the square of the number of null directions: for the start, not for the path of a
 * solver. MBSR_UNDETERMINED: some null direction is not determined by a force that depends on
 * velocity (index > 1 or no force at all), MBSR_NO_CONVERGENCE, MBSR_ERR_NO_MEMORY and the statuses
 * of mbsr_dae_residual. */
MBSR_API int mbsr_dae_consistent(const mbsr_model *model, mbsr_data *data, mbsr_dae_form form,
                                 double t, double *y, double *yp, const mbsr_consistent_opt *opt,
                                 mbsr_consistent_info *info);

#ifdef __cplusplus
}
#endif

#endif
