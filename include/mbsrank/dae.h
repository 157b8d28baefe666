/* The equations of motion as a residual F(t, y, y') = 0 for a solver of differential-algebraic
 * equations (DAE).
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Unknowns are minimal (joint) coordinates; a tree has no constraints and no multipliers. What is
 * algebraic are the velocities in directions without mass: the differential index is 1 where
 * dampers determine them, 2 where springs alone do (index.h).
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
 * MOMENTUM, with the generalised momenta p = (joint-space mass matrix) u, is a semi-explicit DAE: q
 * and p are differential, u is algebraic, and an integrator can leave u out of its error test. With
 * index 1, dF_u/du is regular (Hessenberg form of size 1). It is the form to integrate; see
 * docs/dae_forms.md for step counts. It needs the rates of K, H and J: joints without a `rates`
 * function and inertias by function get them by central differences of the kinematics, at three
 * times the cost of mbsr_stage_positions. Rows of u are momenta in a joint with mass in all
 * directions, forces in others; momenta in those are times mbsr_model_rate (0: 1/s).
 *
 * With closures (closure.h), which MOMENTUM alone takes, y = (q, p, u, Lambda, Eta): one number for
 * each velocity row, then one for each position row, both algebraic. Loop forces are rates, lambda
 * = Lambda', and come with y'; Eta' is zero on solutions:
 *
 *   q' - G (u + w C^T Eta');  p' - (.) - C^T Lambda';  u from p, or forces without mass;
 *   C u + g_t;  g                                  w: mbsr_closures_weight (driver.h)
 *
 * In the place of a stiff row's Lambda stands the force s of its spring, and lambda = -(s +
 * (damping / stiffness) s'). Origins of Lambda and Eta are free: mbsr_dae_pack gives zero, and the
 * s of the positions. An integrator should leave all of them out of its error test.
 *
 * The (q, u) forms are linearly implicit, E(q) u' = ..., with an E that is singular exactly when
 * the joint-space mass matrix is. INDEX1 is (2) of the paper, semi-explicit like MOMENTUM. */
typedef enum mbsr_dae_form {
    MBSR_DAE_MOMENTUM = 0,
    MBSR_DAE_RECURSIVE = 1,
    MBSR_DAE_INVERSE_DYNAMICS = 2,
    MBSR_DAE_INDEX1 = 3
} mbsr_dae_form;

/* Length of y, y' and F; -1 if the model is NULL, not finished, or the form unknown or one that
 * does not take the model's closures. All functions below return MBSR_ERR_CLOSURES for such a form.
 */
MBSR_API int mbsr_dae_size(const mbsr_model *model, mbsr_dae_form form);

/* Which variables are differential: id (mbsr_dae_size numbers) is 1 for these, 0 for algebraic
 * ones. In the momentum form q and p are differential and u algebraic. In the index-1 form it
 * depends on the ranks of the reference in data, see below. In the (q, u) forms which combinations
 * of u are algebraic depends on the state, so all are marked 1. MBSR_ERR_NULL, MBSR_ERR_MISMATCH,
 * MBSR_ERR_VALUE (unknown form), MBSR_ERR_SEQUENCE (no reference). */
MBSR_API int mbsr_dae_id(const mbsr_model *model, mbsr_data *data, mbsr_dae_form form, double *id);

/* State to y and back. y must not overlap q and u.  MBSR_ERR_NULL, MBSR_ERR_MISMATCH,
 * MBSR_ERR_VALUE, MBSR_NOT_FINITE (an argument, or a momentum that overflows). */
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
 * eta_j and zeta_j are the components of a joint's velocities in the range and the null space of
 * its block D_j. Their bases follow the state smoothly: they are as close as possible to those of a
 * reference that the data keeps. So y means something only together with the data it was made with.
 * mbsr_dae_pack and mbsr_dae_consistent take the present state as reference where there is none. */

typedef struct mbsr_consistent_opt {
    int cookie;         /* set by mbsr_default_consistent_opt */
    int max_iterations; /* Newton steps for positions, and for velocities; default 30 */
    double tolerance;   /* relative size of the last Newton correction; default 1e-12 */
    int side; /* times at which functions of time are asked for differences: 0 (default) before and
               * after t, 1 not before t, -1 not after it: for a start where they jump at t; trees
               */
    /* nu each, NULL (default): none. How many times more than the others a coordinate resists where
     * loops are closed, positive, as in mbsr_assembly_opt; 1 for coordinates, and for joint rates,
     * that stay as y has them. */
    const double *weight;
    const int *keep_position, *keep_rate;
} mbsr_consistent_opt;

MBSR_API mbsr_consistent_opt mbsr_default_consistent_opt(void);

/* What a consistent start found and changed. */
typedef struct mbsr_consistent_info {
    int null_directions;    /* combinations of joint rates that move no mass */
    int elastic;            /* 1: springs alone determine some of these (index 2); 0 */
    int iterations;         /* Newton steps taken */
    double position_change; /* largest |change| of an entry of q */
    double velocity_change; /* largest |change| of an entry of u */
    int position_changed;   /* which entry that is, MBSR_NONE: none has changed */
    int velocity_changed;
    double force_defect; /* largest |gamma|, the force in a null direction, before */
} mbsr_consistent_info;

/* Consistent initial values for every form. y (a state of the form, of which q and u count; p
 * follows) is updated, yp is an output; on failure both stay as they were. opt and info may be
 * NULL.
 *
 * Along the directions that move no mass the forces must balance, gamma(q, u, t) = 0. Where they
 * depend on velocity (damped, index 1), u changes until gamma = 0; where springs alone act
 * (elastic, index 2), q changes until gamma = 0 and u until gamma' = 0, by a displacement that lies
 * along elastic directions at the state found. Masses stay where they are, and so do their momenta.
 * Then yp: u' from the equations of motion and the derivatives of gamma.
 *
 * Forces are also evaluated at states far from y (see mbsr_index_report_create). Allocates from the
 * model's allocator. Trees take two Newton solvers (newton.h), some ten residuals and
 * factorisations, elastic ones forty; in O(N), unless forces hardly resist some direction, or no
 * state is found, and the index report is asked. Made for the start, not for every step of a
 * solver.
 *
 * With closures q is brought to a closed position near it (in the measure of mbsr_assemble), the
 * rows to be left out as redundant are chosen (mbsr_closures_redundant), u changes by impulses of
 * the loops alone, and directions without mass count where no loop holds them. These are balanced
 * as in trees. All is O(bodies + loops) where loops are local (docs/closed_loops.md); in other
 * models rows are chosen in dense linear algebra, whose cost grows with the cube of joint rates and
 * rows. Settled stiff rows that depend on others share what they bear by their compliance.
 * MBSR_LOOP_OPEN where loops do not close or contradict each other.
 *
 * Coordinates and joint rates that opt keeps stay to the last digit (rates in the index-1 form but
 * for rounding), and the others follow: loops close around these coordinates, and motors at these
 * rates exert impulses, which bodies without mass pass on through their dampers and springs. Of all
 * velocities that closures, balances and kept rates allow, u is the one nearest to the given one in
 * the metric of the masses (where dampers are symmetric). It takes two or three starts for one, and
 * for each rate that is kept a few solutions on the tree. Of the three turns of a quaternion all
 * are kept, or none: MBSR_ERR_VALUE. MBSR_LOOP_OPEN where loops do not allow a rate that is kept,
 * with body, rate and row of a closure in the text; MBSR_NO_CONVERGENCE where balances of forces on
 * bodies without mass determine it, or the coordinate.
 *
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
