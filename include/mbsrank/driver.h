/* For whoever writes an integrator, a binding or another driver: what a run needs to know of a
 * model beside what users' programs do.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The component ida is written on this header and on the public ones alone. mbsrank.h does not
 * include it. m = mbsr_model_rows, h = mbsr_model_position_rows; arguments, statuses common to all
 * and overlapping are as in dynamics.h. */
#ifndef MBSRANK_DRIVER_H
#define MBSRANK_DRIVER_H

#include <mbsrank/closure.h>
#include <mbsrank/completion.h>
#include <mbsrank/dae.h>
#include <mbsrank/dynamics.h>
#include <mbsrank/model.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- stages and ranks of a data ---- */

/* Exchanges the watch of the data (on or off, and the ranks watched) with *on and rank, as many
 * numbers as there are bodies, by id. For a caller who watches for a while and leaves the data as
 * they were: exchange, evaluate, exchange back. Nothing is evaluated. MBSR_ERR_VALUE for a rank
 * that the joint of the body cannot have. */
MBSR_API int mbsr_rank_watch_exchange(const mbsr_model *model, mbsr_data *data, int *on, int *rank);

/* Sum of the ranks of all joints, which is the rank of the joint-space mass matrix; -1 before
 * mbsr_stage_backward. */
MBSR_API int mbsr_total_rank(const mbsr_model *model, const mbsr_data *data);

/* ---- tolerances ---- */

/* Masses by which tolerances of velocities become tolerances of momenta, mass (nu), so that with
 * tolerances atol and rtol of u an integrator of one's own tests, as the driver does,
 *
 *   |error of p_k| < mass_k (rtol |u_k| + atol).
 *
 * For each number of u the largest entry of diag(J^T W J) on rates of its kind (turns, moves, or
 * others) in its joint, which is mbsr_rank_info.scale where these are of one kind, but at least 3 %
 * of the diagonal entry of the mass matrix, so that a light body which carries a heavy one is
 * tested as that one; where the joint has no mass, or that of rounding in a lever, the largest of
 * its kind in the tree (where the kind has none but for rounding, of all by typical ways: 1 rad,
 * the typical length, large amplitudes of modes; without any mass what springs and dampers would
 * swing). With closures 0.35 over mbsr_closures_mobility takes the place of the scale, between a
 * thousandth of the largest diagonal entry of its kind and that. The same in all units. Needs
 * mbsr_stage_backward, and leaves its results; with closures it takes memory. MBSR_ERR_NULL,
 * MBSR_ERR_MISMATCH, MBSR_ERR_SEQUENCE, statuses of mbsr_stage_backward and of
 * mbsr_closures_mobility. */
MBSR_API int mbsr_momentum_scales(const mbsr_model *model, mbsr_data *data, double *mass);

/* What a unit impulse on each joint rate changes it by, all others giving way as the loops let
 * them: mobility (nu) = diag(Z (Z^T M Z)^-1 Z^T), where the columns of Z span the rates that the
 * rows allow; its inverse is the inertia that the rate moves. It does not depend on where loops are
 * cut. 0 for rates that the loops do not let change, -1 for those that move no mass. At the
 * positions of mbsr_stage_positions. Stiff rows count as rigid, unless they are not settled. Takes
 * memory for a short time, and O(bodies + loops); results of mbsr_stage_backward are lost.
 * MBSR_ERR_NULL, MBSR_ERR_NO_MEMORY, MBSR_ERR_SEQUENCE, MBSR_NOT_FINITE. */
MBSR_API int mbsr_closures_mobility(const mbsr_model *model, mbsr_data *data, double *mobility);

/* The weights w (nu) with which multipliers of position rows act on coordinates in the momentum
 * form, q' = G (u + w C^T Eta'): inverses of the inertias that the joint rates move at q = 0, of
 * those that move little a thousandth of the largest of their kind. Numbers of the model, in no
 * preferred units. MBSR_ERR_NULL, MBSR_ERR_UNFINISHED. */
MBSR_API int mbsr_closures_weight(const mbsr_model *model, double *w);

/* What row `row` among all measures at the positions of mbsr_stage_positions, so that its gap can
 * be compared: turns of bodies alone (ROTATION, rad), places (TRANSLATION, m), or joint coordinates
 * (OTHER); and the longest lever of the mechanism (m), by which turns move places. One output may
 * be NULL. MBSR_ERR_NULL, MBSR_ERR_SEQUENCE, MBSR_ERR_ID, what a table returned. */
MBSR_API int mbsr_closure_row_kind(const mbsr_model *model, mbsr_data *data, int row,
                                   mbsr_coordinate_kind *kind, double *lever);

/* The stiffness of one of its rows, 0 for a rigid one; -1 where there is none. */
MBSR_API double mbsr_closure_stiffness(const mbsr_model *model, int closure, int row);

/* ---- balance of forces ---- */

/* How far the forces along directions without mass are from their balance at a state y of the form
 * (of which q and u count): *share, the largest |gamma| over the sum of the sizes of what was added
 * up to it, and *body, the first one of the group of joints where that is, MBSR_NONE where all of
 * gamma is zero. About 1e-12 after mbsr_dae_consistent; 1 where nothing balances. Undetermined
 * directions without any force count as balanced, and so do forces that are next to none: 0, where
 * one step of Newton's method on the momentum form changes no rate by a millionth of the largest
 * one or of what is typical of the model. dq (nq) and du (nu), which may be NULL: what this step
 * changes q and u by towards the balance, within a hundredth of the time typical of the model; zero
 * where it is singular. O(N). MBSR_ERR_NULL, MBSR_ERR_MISMATCH, MBSR_ERR_VALUE, MBSR_ERR_CLOSURES
 * (the model has closures), MBSR_ERR_NO_MEMORY and the statuses of the stages. */
MBSR_API int mbsr_dae_imbalance(const mbsr_model *model, mbsr_data *data, mbsr_dae_form form,
                                double t, const double *y, double *share, int *body, double *dq,
                                double *du);

/* ---- rows of the closures ---- */

/* C u + g_t (m) at the state of mbsr_stage_velocities. MBSR_ERR_NULL,
 * MBSR_ERR_MISMATCH, MBSR_ERR_SEQUENCE, MBSR_NOT_FINITE, what a table returned. */
MBSR_API int mbsr_closures_rate(const mbsr_model *model, mbsr_data *data, double *rate);

/* Its time derivative (m) where u' is zero: C' u + (g_t)'. At the state of mbsr_stage_velocities.
 */
MBSR_API int mbsr_closures_bias(const mbsr_model *model, mbsr_data *data, double *bias);

/* Products with the rows of all closures: y (m) = C x (nu), and y (nu) = C^T x (m), at the
 * positions of mbsr_stage_positions. x and y must not overlap. O(bodies + rows). */
MBSR_API int mbsr_closures_apply(const mbsr_model *model, mbsr_data *data, const double *x,
                                 double *y);
MBSR_API int mbsr_closures_transpose(const mbsr_model *model, mbsr_data *data, const double *x,
                                     double *y);

/* Which rows the data leaves out of the momentum form, redundant (m): their multipliers are zero
 * and their gaps only watched; of stiff rows, whose springs stay, those whose Eta alone is zero.
 * mbsr_dae_consistent chooses them; a data of which nothing was asked leaves
 * out none. mbsr_closures_set_redundant sets them, for a run that goes on in another data.
 * MBSR_ERR_NULL, MBSR_ERR_MISMATCH. */
MBSR_API int mbsr_closures_redundant(const mbsr_model *model, mbsr_data *data, int *redundant);
MBSR_API int mbsr_closures_set_redundant(const mbsr_model *model, mbsr_data *data,
                                         const int *redundant);

/* Loop forces lambda (m) at the state of mbsr_stage_velocities, such as those that y' has: the next
 * mbsr_stage_forces adds what they exert, so that mbsr_stage_accelerations and mbsr_joint_reaction
 * take them in. Without it mbsr_stage_forces takes stiff rows as springs and all others as zero.
 * The residual and mbsr_forward_dynamics do this by themselves. MBSR_ERR_NULL, MBSR_ERR_SEQUENCE,
 * MBSR_NOT_FINITE. */
MBSR_API int mbsr_closures_set_lambda(const mbsr_model *model, mbsr_data *data,
                                      const double *lambda);

/* ---- the reference of the index-1 form ---- */

/* Cosine of the largest angle between the bases at y and the reference, 1 when they agree. Costs
 * half a residual. Where it is below 0.05, this function and the residual return the recoverable
 * MBSR_FRAME_TURNED. MBSR_ERR_SEQUENCE without a reference; MBSR_ERR_CLOSURES; MBSR_NOT_FINITE. */
MBSR_API int mbsr_index1_alignment(const mbsr_model *model, mbsr_data *data, double t,
                                   const double *y, double *cosine);

/* Makes the state y the reference. y stays as it is; the differential entries of yp are made
 * consistent again. *restart (may be NULL) is set to 1 if derivatives of y jump, so that an
 * integrator must start anew: that happens only where a range and a null space of one joint are
 * both there and one has two dimensions or more. MBSR_ERR_SEQUENCE without a reference;
 * MBSR_ERR_CLOSURES; all statuses of the residual. */
MBSR_API int mbsr_index1_renew(const mbsr_model *model, mbsr_data *data, double t, const double *y,
                               double *yp, int *restart);

/* Forgets the reference, so that the next pack or start takes its own. MBSR_ERR_CLOSURES. */
MBSR_API int mbsr_index1_reset(const mbsr_model *model, mbsr_data *data);

/* ---- states that were interpolated (completion.h) ---- */

/* What is known of the times around those that will be asked for. */
typedef struct mbsr_completion_times {
    double scale; /* s, in which the motion changes much, such as a period; 0 (default): the model's
                   * own. Difference quotients in time take 1e-7 of it. */
    double from, to; /* s, from < to: functions of time are asked between these only, for difference
                      * quotients; default -INFINITY, INFINITY */
    int follow; /* 1: the states asked for follow one another, and the matrix of one serves to find
                 * the velocities of the next: fewer factorisations, and numbers that depend on
                 * the states before by 1e-10 of their size; 0 (default): on the arguments alone */
} mbsr_completion_times;

/* Says what is known of the times that will be asked for. MBSR_ERR_NULL, MBSR_ERR_VALUE. */
MBSR_API int mbsr_completion_set_times(mbsr_completion *completion,
                                       const mbsr_completion_times *times);

/* Takes the strain out of a state of the momentum form that was interpolated: a stiff spring that
 * is off by a tolerance exerts a large force. Newton's method for F(t, y, y' + rate (y_new - y)) =
 * 0, an implicit Euler step of length 1 / rate (1/s, > 0) along the defect of the interpolation; y
 * and yp change, unless it fails. Statuses of mbsr_completion_solve. */
MBSR_API int mbsr_completion_relax(mbsr_completion *completion, mbsr_data *data, double t,
                                   double rate, double *y, double *yp);

/* ---- lean data ---- */

/* Lean data: about 500 bytes for a rigid body with a joint of one axis instead of some 3500, and
 * 600 where there are force elements on bodies or bodies of other kinds (bodies, joints and
 * inertias of your own, added masses, joints that lack rank); these, the bodies before them and
 * those on which elements act take what they take in full data. It serves mbsr_forward_dynamics,
 * mbsr_inverse_dynamics, mbsr_bias_forces, the residual of the momentum form and lean Newton
 * solvers (newton.h). Everything else is refused with MBSR_ERR_LEAN, and so are states in which the
 * rank of a joint block is not clear at once (docs/performance.md). For models with closures the
 * size is 0 and the other two functions return MBSR_ERR_SPACE. */
MBSR_API size_t mbsr_data_size_lean(const mbsr_model *model);
MBSR_API int mbsr_data_init_lean(const mbsr_model *model, void *memory, size_t size,
                                 mbsr_data **data, mbsr_error *error);
MBSR_API int mbsr_data_create_lean(const mbsr_model *model, mbsr_data **data, mbsr_error *error);

/* ---- locked coordinates of a finished model ---- */

/* The values at which coordinates of a body's joint are locked, NaN for the others, as many as the
 * joint has as it was given (NULL: none is locked, or there is no such body), and whether what acts
 * on them is dropped. */
MBSR_API const double *mbsr_body_locked(const mbsr_model *model, int body);
MBSR_API int mbsr_body_drops(const mbsr_model *model, int body);

#ifdef __cplusplus
}
#endif

#endif
