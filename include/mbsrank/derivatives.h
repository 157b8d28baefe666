/* Derivatives of inverse and forward dynamics and of the residual of the momentum form: products
 * with their Jacobians and the transposes, O(N).
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   inverse dynamics   tau(q, u, u')     mbsr_derivatives_inverse
 *   forward dynamics   u'(q, u, tau)     mbsr_derivatives_forward
 *
 * are linearised at a state, from formulas of joints, inertias, elements and closures where these
 * have them, else from differences of one of their functions at a time. Then, as often as wanted,
 *
 *   mbsr_derivatives_tangent
 *       change of the result along changes of q, u and of u' or tau (Jacobian times vector)
 *   mbsr_derivatives_adjoint
 *       gradient of a weighted sum of the result (transpose of the Jacobian times vector)
 *
 * Trees, loops, flexible bodies and users' own are served alike. A direction in q is given as joint
 * rates, nu numbers x for the change G(q) x of q: where q' = u that is the change of q itself,
 * along a quaternion three rates. u is held along it number by number.
 *
 * Of forward dynamics, with M the mass matrix, C the rigid rows and h their curvature,
 *
 *   M u' - C^T lambda = tau - (inverse dynamics at u' = 0, with the springs of stiff rows),
 *       C u' = -h
 *
 * is linearised as it stands: d(u', lambda) = K^-1 (dtau - d(inverse dynamics), -d(C u' + h)) with
 * u' and lambda held on the right. K is symmetric but for a sign, so that its factors serve the
 * adjoint too, which ends with the transpose of linearised inverse dynamics. docs/derivatives.md
 * has the equations and what they cost.
 *
 *   mbsr_derivatives *d;
 *   mbsr_derivatives_create(model, &d, &error);
 *   mbsr_derivatives_forward(d, t, q, u, tau, udot, NULL);
 *   mbsr_derivatives_tangent(d, dq, du, dtau, dudot, NULL);
 *   mbsr_derivatives_adjoint(d, w, NULL, by_q, by_u, by_tau); */
#ifndef MBSRANK_DERIVATIVES_H
#define MBSRANK_DERIVATIVES_H

#include <mbsrank/dynamics.h>
#include <mbsrank/parameters.h>
#include <mbsrank/threads.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct mbsr_derivatives mbsr_derivatives;

/* Creates an object for a finished model, which must outlive it; one object belongs to one thread.
 * Memory is taken from the model's allocator here, some 20 kB a body; later
 * mbsr_derivatives_forward takes what forward dynamics takes with closures. On failure *derivatives
 * is NULL and the reason in *error (which may be NULL). MBSR_ERR_NULL, MBSR_ERR_UNFINISHED,
 * MBSR_ERR_NO_MEMORY, MBSR_ERR_SPACE: a joint or an inertia by function leaves its rates to
 * differences behind a body whose velocities are not rates of its pose, or a closure reads
 * coordinates of a joint whose rates are not u. */
MBSR_API int mbsr_derivatives_create(const mbsr_model *model, mbsr_derivatives **derivatives,
                                     mbsr_error *error);
MBSR_API void mbsr_derivatives_destroy(mbsr_derivatives *derivatives); /* NULL is allowed */

/* The data in which states are evaluated: to switch elements off there, or to ask for results at
 * the state. Evaluating another state in it makes products wrong until the next linearisation. NULL
 * for NULL. */
MBSR_API mbsr_data *mbsr_derivatives_data(mbsr_derivatives *derivatives);

/* Linearises inverse dynamics at q (nq), u and udot (nu). tau (nu): its result, as
 * mbsr_inverse_dynamics gives it, may be NULL. With closures it is what motors and rigid rows exert
 * together. Any rank of the mass matrix will do. Statuses of mbsr_inverse_dynamics and of the
 * functions that are differenced; MBSR_ERR_NULL. After a failure there are no derivatives. */
MBSR_API int mbsr_derivatives_inverse(mbsr_derivatives *derivatives, double t, const double *q,
                                      const double *u, const double *udot, double *tau);

/* Linearises forward dynamics at q (nq), u and tau (nu; NULL: zero). udot (nu): its result, and
 * lambda (as many as closures have rows): the loop forces, those of stiff rows by their law; both
 * may be NULL. With closures at a state that they allow: derivatives are right along the directions
 * that they allow, and elsewhere those of the equations above. Statuses of mbsr_forward_dynamics;
 * MBSR_UNDETERMINED names a joint whose acceleration masses do not determine (its u follows from a
 * balance of forces instead: mbsr_newton_linearise has its derivatives). */
MBSR_API int mbsr_derivatives_forward(mbsr_derivatives *derivatives, double t, const double *q,
                                      const double *u, const double *tau, double *udot,
                                      double *lambda);

/* The change of the result along dq, du and dload (nu each; NULL: zero), load being udot of inverse
 * and tau of forward dynamics: into out (nu), and of the loop forces into dlambda (rows; may be
 * NULL, of forward dynamics alone). Linear in its inputs; outputs may be inputs. MBSR_ERR_NULL,
 * MBSR_ERR_SEQUENCE without a linearisation, MBSR_ERR_VALUE for a dlambda of inverse dynamics,
 * MBSR_LOOP_SINGULAR for one where rows depend on others, so that forces do not determine lambda;
 * MBSR_NOT_FINITE. Nothing is written then. */
MBSR_API int mbsr_derivatives_tangent(mbsr_derivatives *derivatives, const double *dq,
                                      const double *du, const double *dload, double *out,
                                      double *dlambda);

/* The transpose: by_q, by_u, by_load (nu each; may be NULL) of sum w_k out_k + sum w_lambda_k
 * dlambda_k, w (nu) and w_lambda (rows) NULL for zero. Of q along x as above. Statuses likewise. */
MBSR_API int mbsr_derivatives_adjoint(mbsr_derivatives *derivatives, const double *w,
                                      const double *w_lambda, double *by_q, double *by_u,
                                      double *by_load);

/* The matrices: of the result by q along joint rates, by u and by load (each nu x nu, column-major,
 * column k for a unit change of number k; NULL: not wanted). Of trees of rigid bodies on stock
 * joints, with gravity and elements on one coordinate, by sweeps of their own, O(nu depth) for
 * inverse and O(nu^2) for forward dynamics; else by nu tangents each. No memory is taken. Statuses
 * of mbsr_derivatives_tangent; after a failure their contents are not specified. */
MBSR_API int mbsr_derivatives_matrices(mbsr_derivatives *derivatives, double *by_q, double *by_u,
                                       double *by_load);

/* ---- in parameters ----
 *
 * Masses, centres and tensors of bodies, armatures, origins of joints (in the plane their angles
 * too), param of force elements, stiffnesses and dampings of stiff rows, all at the values that the
 * model of this object has. The state q, u and udot or tau stay. Where loops are moved by a joint
 * the equations above hold off what they allow. */

/* Chooses parameters which[k], k = 0 .. count-1, of a list made of this model, or of one from whose
 * list this model was made (mbsr_parameters_model). 0 chooses none; the last choice counts. Then
 * linearise: what is there is forgotten. The list is not needed afterwards. Memory is taken here.
 * MBSR_ERR_NULL, MBSR_ERR_ID (which[k]), MBSR_ERR_VALUE (count, a list of another model),
 * MBSR_ERR_NO_MEMORY; MBSR_ERR_SPACE for what has no derivatives, by name: numbers of tables,
 * springs that are closures, rows that locked coordinates have changed, an inertia that a force
 * element on few bodies reads. The choice then stays as it was. */
MBSR_API int mbsr_derivatives_parameters(mbsr_derivatives *derivatives, const mbsr_parameters *list,
                                         int count, const int *which);

/* The change of the result along dtheta (as many as chosen), in units of the parameters, as of
 * mbsr_derivatives_tangent. MBSR_ERR_SEQUENCE without a choice or a linearisation; its statuses. */
MBSR_API int mbsr_derivatives_parameter_tangent(mbsr_derivatives *derivatives, const double *dtheta,
                                                double *out, double *dlambda);

/* The transpose: by_theta (as many as chosen) of sum w_k out_k + sum w_lambda_k dlambda_k, for all
 * parameters together in O(N + parameters). Statuses of mbsr_derivatives_adjoint. */
MBSR_API int mbsr_derivatives_parameter_adjoint(mbsr_derivatives *derivatives, const double *w,
                                                const double *w_lambda, double *by_theta);

/* ---- of the residual ----
 *
 * Of F(t, y, y') of the momentum form (dae.h, MBSR_DAE_MOMENTUM) in y, y' and the parameters
 * chosen, for models of any rank, with closures too. As the matrix of Newton systems (newton.h) it
 * is the derivative of F where the algebraic equations hold; elsewhere it lacks what is
 * proportional to their defect. Rows are left out that the data of this object leaves out: which a
 * start there decides (mbsr_derivatives_data). */

/* Linearises F at y and y' (mbsr_dae_size numbers each). F: its value, may be NULL. Statuses of
 * mbsr_dae_residual and of the functions that are differenced; MBSR_ERR_NULL. What was linearised
 * before is forgotten, after a failure too. */
MBSR_API int mbsr_derivatives_residual(mbsr_derivatives *derivatives, double t, const double *y,
                                       const double *yp, double *F);

/* The change dF of F along dy and dyp (mbsr_dae_size numbers each) and dtheta (as many as chosen),
 * in O(N); NULL: zero. Outputs may be inputs. MBSR_ERR_NULL, MBSR_ERR_SEQUENCE without
 * mbsr_derivatives_residual, or with dtheta and without a choice; MBSR_NOT_FINITE. Nothing is
 * written then. */
MBSR_API int mbsr_derivatives_residual_tangent(mbsr_derivatives *derivatives, const double *dy,
                                               const double *dyp, const double *dtheta, double *dF);

/* The transpose: by_y, by_yp (mbsr_dae_size numbers) and by_theta (as many as chosen), each may be
 * NULL, of sum w_k F_k, w (mbsr_dae_size). Statuses likewise. */
MBSR_API int mbsr_derivatives_residual_adjoint(mbsr_derivatives *derivatives, const double *w,
                                               double *by_y, double *by_yp, double *by_theta);

/* ---- at many states ----
 *
 * Of forward dynamics, as mbsr_derivatives_forward and a product at each state give it, number by
 * number. Arrays have one column a state without padding, of nq numbers in q and nu in others, nu x
 * nu in matrices. All states are evaluated whatever becomes of the others. */

typedef struct mbsr_derivatives_batch mbsr_derivatives_batch;

/* An object of one state for each worker of `parallel` (threads.h; NULL: the caller's thread
 * alone), which share the states out. What `parallel` refers to must outlive it, and functions of
 * the model are called from several threads. One batch belongs to one call at a time. Statuses of
 * mbsr_derivatives_create, MBSR_ERR_VALUE (parallel). */
MBSR_API int mbsr_derivatives_batch_create(const mbsr_model *model, const mbsr_parallel *parallel,
                                           mbsr_derivatives_batch **batch, mbsr_error *error);
MBSR_API void mbsr_derivatives_batch_destroy(mbsr_derivatives_batch *batch); /* NULL is allowed */

/* At `states` >= 1 states q, u, tau (NULL: none) at time t: udot (may be NULL), and its change
 * dudot along dq, du, dtau (NULL: zero). Outputs must not overlap inputs. status: `states` numbers,
 * or NULL: those of mbsr_derivatives_forward and mbsr_derivatives_tangent. The result is that of
 * the first state that failed, which mbsr_derivatives_batch_failed and mbsr_derivatives_batch_error
 * name, or MBSR_OK; the outputs of such states are NaN. MBSR_ERR_NULL and MBSR_ERR_VALUE (states <
 * 1) leave outputs and status as they are. */
MBSR_API int mbsr_derivatives_batch_tangent(mbsr_derivatives_batch *batch, double t, int states,
                                            const double *q, const double *u, const double *tau,
                                            const double *dq, const double *du, const double *dtau,
                                            double *udot, double *dudot, int *status);

/* Likewise the gradients of sum w_k udot_k by q along joint rates, by u and tau; each may be NULL.
 */
MBSR_API int mbsr_derivatives_batch_adjoint(mbsr_derivatives_batch *batch, double t, int states,
                                            const double *q, const double *u, const double *tau,
                                            const double *w, double *udot, double *by_q,
                                            double *by_u, double *by_tau, int *status);

/* Likewise the matrices of mbsr_derivatives_matrices; each may be NULL. */
MBSR_API int mbsr_derivatives_batch_matrices(mbsr_derivatives_batch *batch, double t, int states,
                                             const double *q, const double *u, const double *tau,
                                             double *udot, double *by_q, double *by_u,
                                             double *by_tau, int *status);

/* Of the last call: the first state that failed, counted from 0, or -1; and the failure, with the
 * number of the state in the text (never NULL). */
MBSR_API int mbsr_derivatives_batch_failed(const mbsr_derivatives_batch *batch);
MBSR_API const mbsr_error *mbsr_derivatives_batch_error(const mbsr_derivatives_batch *batch);

/* The last failure; never NULL. */
MBSR_API const mbsr_error *mbsr_derivatives_error(const mbsr_derivatives *derivatives);

#ifdef __cplusplus
}
#endif

#endif
