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

/*   form               y         F
 *   MOMENTUM           q, p, u   q' - G u;  p' - (.);  u from p, or forces without mass
 *   RECURSIVE          q, u      q' - G u;  (25), the recursion that skips rank-deficient bodies
 *   INVERSE_DYNAMICS   q, u      q' - G u;  J^T mu - tau from (9) and (11), no rank decision
 *   INDEX1             q, v      q' - G u;  (29)-(32), v = (eta, zeta) joint by joint
 *
 * MOMENTUM, with the generalised momenta p = M u, is semi-explicit: q and p are differential, u
 * algebraic, and an integrator can leave u out of its error test. It is the form to integrate; see
 * docs/dae_forms.md for step counts. It needs the rates of K, H and J: joints without a `rates`
 * function and inertias by function get them by central differences of the kinematics, at three
 * times the cost of mbsr_positions.
 *
 * The (q, u) forms are linear in u' with a matrix that is singular exactly when the joint-space
 * mass matrix is. */
typedef enum mbsr_dae_form {
    MBSR_DAE_MOMENTUM = 0,
    MBSR_DAE_RECURSIVE = 1,
    MBSR_DAE_INVERSE_DYNAMICS = 2,
    MBSR_DAE_INDEX1 = 3
} mbsr_dae_form;

/* Length of y, y' and F; -1 if the model is NULL, not finished, or the form unknown. */
MBSR_API int mbsr_dae_size(const mbsr_model *model, mbsr_dae_form form);

/* id (mbsr_dae_size numbers): 1 for differential variables, 0 for algebraic ones. In the momentum
 * form q and p are differential and u algebraic. In the index-1 form it depends on the ranks of the
 * reference in data, see below. In the (q, u) forms which combinations of u are algebraic depends
 * on the state, so all are marked 1. MBSR_ERR_NULL, MBSR_ERR_MISMATCH, MBSR_ERR_VALUE (unknown
 * form), MBSR_ERR_SEQUENCE (no reference). */
MBSR_API int mbsr_dae_id(const mbsr_model *model, mbsr_data *data, mbsr_dae_form form, double *id);

/* State to y and back. y must not overlap q and u.  MBSR_ERR_NULL, MBSR_ERR_MISMATCH,
 * MBSR_ERR_VALUE. */
MBSR_API int mbsr_dae_pack(const mbsr_model *model, mbsr_data *data, mbsr_dae_form form, double t,
                           const double *q, const double *u, double *y);
MBSR_API int mbsr_dae_unpack(const mbsr_model *model, mbsr_data *data, mbsr_dae_form form, double t,
                             const double *y, double *q, double *u);

/* F(t, y, y'). F must not overlap y and yp. Deterministic, allocates nothing, safe for one data a
 * thread. Values in F are finite when MBSR_OK is returned; with MBSR_NOT_FINITE the text names the
 * first quantity that was not. All statuses of the stages in dynamics.h; what a callback returned
 * is handed through unchanged. */
MBSR_API int mbsr_dae_residual(const mbsr_model *model, mbsr_data *data, mbsr_dae_form form,
                               double t, const double *y, const double *yp, double *F);

/* ---- the reference of the index-1 form ----
 * eta_j and zeta_j are the components of a joint's
 * velocities in the range and the null space of its block D_j, in bases that follow the state
 * smoothly: as close as possible to those of a reference kept in the data. mbsr_dae_pack and
 * mbsr_dae_consistent take the present state as reference where there is none; y means something
 * only together with the data it was made with. */

/* Cosine of the largest angle between the bases at y and the reference, 1 when they agree. At half
 * the cost of a residual. Below 0.05 the residual, and this, return the recoverable
 * MBSR_FRAME_TURNED. MBSR_ERR_SEQUENCE without a reference. */
MBSR_API int mbsr_index1_alignment(const mbsr_model *model, mbsr_data *data, double t,
                                   const double *y, double *cosine);

/* Makes the state y the reference. y stays as it is; the differential entries of yp are made
 * consistent again. *restart (may be NULL) is set to 1 if derivatives of y jump, so that an
 * integrator must start anew: that happens only where a range and a null space of one joint are
 * both there and one has two dimensions or more. MBSR_ERR_SEQUENCE without a reference; all
 * statuses of the residual. */
MBSR_API int mbsr_index1_renew(const mbsr_model *model, mbsr_data *data, double t, const double *y,
                               double *yp, int *restart);

/* Forgets the reference, so that the next pack or start takes its own. */
MBSR_API int mbsr_index1_reset(const mbsr_model *model, mbsr_data *data);

typedef struct mbsr_consistent_opt {
    int cookie;         /* set by mbsr_default_consistent_opt */
    int max_iterations; /* Newton steps for positions, and for velocities; default 30 */
    double tolerance;   /* relative size of the last Newton correction; default 1e-12 */
} mbsr_consistent_opt;

MBSR_API mbsr_consistent_opt mbsr_default_consistent_opt(void);

/* What a consistent start found and changed. */
typedef struct mbsr_consistent_info {
    int null_directions;    /* combinations of joint rates that move no mass */
    int elastic_directions; /* of these, the ones that only springs determine (index 2) */
    int iterations;         /* Newton steps taken */
    double position_change; /* largest |change| of an entry of q */
    double velocity_change; /* largest |change| of an entry of u */
    double force_defect;    /* largest |gamma|, the force in a null direction, before */
} mbsr_consistent_info;

/* A consistent start for every form. It keeps the momenta M u. Along the directions that move no
 * mass the forces must balance, gamma(q, u, t) = 0: where they depend on velocity (damped, index 1)
 * it changes u; where springs alone act (elastic, index 2) it changes q until gamma = 0 and u until
 * gamma' = 0. Then yp: u' from the equations of motion and from the derivatives of gamma. y holds a
 * state of the form and is updated; the q and u in it count, p follows. yp is an output. On failure
 * both stay as they were. opt and info may be NULL. Forces are evaluated at states far from y too
 * (see mbsr_index_report_create). Allocates from the model's allocator. Its cost grows with the
 * number of null directions times that of a residual, or, where there are more than 24 and all are
 * damped, as that of a few residuals (docs/newton.md): for the start, not for the path of a solver.
 * MBSR_UNDETERMINED names a joint with a direction that no force determines; MBSR_NO_CONVERGENCE:
 * no state found in which the forces balance; MBSR_RANK_CHANGED, MBSR_ERR_VALUE,
 * MBSR_ERR_NO_DEFAULT, MBSR_ERR_NO_MEMORY and the statuses of the stages. */
MBSR_API int mbsr_dae_consistent(const mbsr_model *model, mbsr_data *data, mbsr_dae_form form,
                                 double t, double *y, double *yp, const mbsr_consistent_opt *opt,
                                 mbsr_consistent_info *info);

#ifdef __cplusplus
}
#endif

#endif
