/* The evaluation stages, inverse and forward dynamics, mass matrix, energies, ranks.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Symbols and equation numbers are those of M. Arnold, Mech. Sci. 4 (2013) 221-231; docs/theory.md
 * lists them. q, u, u' and tau are vectors over the whole tree (mbsr_model_nq, mbsr_model_nu),
 * ordered by body id. Outputs must not overlap inputs. No function here allocates. Statuses common
 * to all: MBSR_ERR_NULL, MBSR_ERR_MISMATCH (data of another model), and whatever a callback
 * returned, unchanged; the text is in mbsr_data_error. */
#ifndef MBSRANK_DYNAMICS_H
#define MBSRANK_DYNAMICS_H

#include <mbsrank/data.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- the stages, each needing those before it (else MBSR_ERR_SEQUENCE) ---- */

/* Forward recursion of poses (7); K, H, J, kI and M in that pose.  q: nq.
 * MBSR_NOT_FINITE, MBSR_SINGULAR_K, MBSR_RANK_DEFICIENT_J. */
MBSR_API int mbsr_positions(const mbsr_model *model, mbsr_data *data, double t, const double *q);

/* Forward recursion of velocities (8); kII and gyroscopic forces.  u: nu.  MBSR_NOT_FINITE. */
MBSR_API int mbsr_velocities(const mbsr_model *model, mbsr_data *data, const double *u);

/* Applied forces f and joint forces: all force elements, plus tau (nu, may be NULL for none) on the
 * joints. */
MBSR_API int mbsr_forces(const mbsr_model *model, mbsr_data *data, const double *tau);

/* Backward recursion (17): Mbar, fbar, D, ranks.  MBSR_EIGEN_FAILED, MBSR_INDEFINITE_MASS,
 * MBSR_RANK_CHANGED (see mbsr_rank_watch). */
MBSR_API int mbsr_backward(const mbsr_model *model, mbsr_data *data);

/* Forward recursion that skips rank-deficient bodies, (18)-(24), adjacent ones included, and the
 * residual (25): residual = D u' - [tau - J^T fbar - J^T Mbar (H A_pred + kII)], nu numbers; zero
 * on the equations of motion. */
MBSR_API int mbsr_forward(const mbsr_model *model, mbsr_data *data, const double *udot,
                          double *residual);

/* ---- whole evaluations ---- */

/* q' = G(q) u; qdot: nq.  Needs mbsr_velocities. */
MBSR_API int mbsr_coordinate_rates(const mbsr_model *model, mbsr_data *data, double *qdot);

/* Brings q (nq, changed in place) to its normal form: quaternions to length 1. No pose depends on
 * what this changes. mbsr_dae_pack and mbsr_dae_unpack do it. MBSR_ZERO_QUATERNION names the body.
 * */
MBSR_API int mbsr_normalise(const mbsr_model *model, mbsr_data *data, double *q);

/* Residual (25) at a state: the five stages. tau may be NULL.  All statuses of the stages. */
MBSR_API int mbsr_recursive_residual(const mbsr_model *model, mbsr_data *data, double t,
                                     const double *q, const double *u, const double *udot,
                                     const double *tau, double *residual);

/* Inverse dynamics: the joint forces tau (nu) that, in addition to the force elements, give the
 * accelerations udot. (9) root to leaves, (11) leaves to root; no rank decision, no pseudo-inverse.
 * With tau subtracted from what is applied it is the inverse-dynamics residual. */
MBSR_API int mbsr_inverse_dynamics(const mbsr_model *model, mbsr_data *data, double t,
                                   const double *q, const double *u, const double *udot,
                                   double *tau);

/* Forward dynamics: the accelerations udot (nu) under the force elements and tau (nu, may be NULL),
 * O(N). MBSR_UNDETERMINED names the first joint whose block D is rank-deficient: its accelerations
 * follow from no equation of second order (udot then holds the range components only). All statuses
 * of the stages. */
MBSR_API int mbsr_forward_dynamics(const mbsr_model *model, mbsr_data *data, double t,
                                   const double *q, const double *u, const double *tau,
                                   double *udot);

/* Bias forces: what inverse dynamics gives for udot = 0, so that mass matrix udot + bias = tau; the
 * force elements are in it.  bias: nu. */
MBSR_API int mbsr_bias_forces(const mbsr_model *model, mbsr_data *data, double t, const double *q,
                              const double *u, double *bias);

/* Joint-space mass matrix, nu x nu, column-major, symmetric.  O(nu^2).  Needs mbsr_positions; for
 * inertias by function, mbsr_velocities. */
MBSR_API int mbsr_mass_matrix(const mbsr_model *model, mbsr_data *data, double *matrix);

/* Generalised momenta p = M u (+ the part of prescribed motion), nu numbers, O(N). Needs
 * mbsr_velocities. */
MBSR_API int mbsr_momenta(const mbsr_model *model, mbsr_data *data, double *p);

/* Kinetic energy 1/2 sum V^T M V and potential energy of the force elements that have one, in J.
 * Needs mbsr_velocities. Outputs may be NULL. */
MBSR_API int mbsr_energy(const mbsr_model *model, mbsr_data *data, double *kinetic,
                         double *potential);

/* Power in W that the force elements turn into heat, as far as they say so. Needs
 * mbsr_velocities. */
MBSR_API int mbsr_dissipation(const mbsr_model *model, mbsr_data *data, double *power);

/* Potential energy and dissipated power of one force element; zero where it has none. Outputs may
 * be NULL. Needs mbsr_velocities. MBSR_ERR_ID. */
MBSR_API int mbsr_force_power(const mbsr_model *model, mbsr_data *data, int force, double *energy,
                              double *power);

/* Mass and centre of mass (m, world axes; zero if there is no mass) of all POINT, PLANAR and
 * SPATIAL bodies, and their momentum: the angular momentum about the point `about` (NULL: the
 * world's origin; kg m^2/s), then the linear (kg m/s). Outputs may be NULL. Needs mbsr_velocities.
 * MBSR_ERR_SPACE names the first body with inertia that is in GENERAL space. */
MBSR_API int mbsr_tree_momentum(const mbsr_model *model, mbsr_data *data, const double about[3],
                                double *mass, double centre[3], double momentum[6]);

/* Accelerations (9) and joint reactions (11) of the state under its forces, for given udot (nu), as
 * found by mbsr_forward_dynamics or by an integrator. Needs mbsr_forces. */
MBSR_API int mbsr_accelerations(const mbsr_model *model, mbsr_data *data, const double *udot);

/* ---- results per body ---- */

/* Pose p (np numbers) and velocity V (d numbers) of a body; needs mbsr_positions or
 * mbsr_velocities. MBSR_GROUND gives those of the root. MBSR_ERR_ID, MBSR_ERR_SEQUENCE. */
MBSR_API int mbsr_body_pose(const mbsr_model *model, mbsr_data *data, int body, double *pose);
MBSR_API int mbsr_body_twist(const mbsr_model *model, mbsr_data *data, int body, double *twist);

/* Acceleration A = V' of a body (d numbers), and the force (d, conjugate to V) that its joint
 * exerts on it, drives and joint force elements included: -K^T mu, whose reaction -H^T mu acts on
 * the predecessor; for MBSR_GROUND the force that holds
 * the root. Valid from mbsr_accelerations or mbsr_inverse_dynamics until the next stage
 * runs, else MBSR_ERR_SEQUENCE; the reactions after inverse dynamics include the joint forces that
 * it found. MBSR_ERR_ID. */
MBSR_API int mbsr_body_acceleration(const mbsr_model *model, mbsr_data *data, int body,
                                    double *acceleration);
MBSR_API int mbsr_joint_reaction(const mbsr_model *model, mbsr_data *data, int body, double *force);

/* dV/du of a body: d x nu, column-major; V = jacobian u + what prescribed motion adds. Needs
 * mbsr_positions. MBSR_ERR_ID. */
MBSR_API int mbsr_body_jacobian(const mbsr_model *model, mbsr_data *data, int body,
                                double *jacobian);

/* The rank decision of one joint. D = J^T Mbar J is compared with the rounding errors that can be
 * in it: W is the sum of what was added up to make Mbar before cancellation, carried leaves to root
 * to first order (docs/rank_and_index.md), and the eigenvalues are those of D scaled to S D S, S =
 * diag(J^T W J)^(-1/2). They do not depend on units and lie in [0, 1] up to rounding; one counts as
 * zero when it is at most `tolerance`. */
typedef struct mbsr_rank_info {
    int n;                /* size of D */
    int rank;             /* eigenvalues kept */
    double tolerance;     /* of the model; dimensionless */
    double scale;         /* largest entry of diag(J^T W J), in units of D */
    double smallest_kept; /* of the scaled eigenvalues; 0 when none was kept */
    double
        largest_dropped; /* of the scaled eigenvalues, in absolute value; 0 when none was dropped */
} mbsr_rank_info;

/* Needs mbsr_backward. MBSR_ERR_ID, MBSR_ERR_SEQUENCE. */
MBSR_API int mbsr_body_rank(const mbsr_model *model, mbsr_data *data, int body,
                            mbsr_rank_info *info);

/* Remembers the ranks of the last mbsr_backward (on != 0) or forgets them (on == 0). While they are
 * remembered, mbsr_backward returns the recoverable MBSR_RANK_CHANGED, naming the body, where a
 * joint has another rank: the recursive and the momentum form hold between rank changes only. Needs
 * mbsr_backward when switched on. */
MBSR_API int mbsr_rank_watch(const mbsr_model *model, mbsr_data *data, int on);

/* Sum of the ranks of all joints, which is the rank of the joint-space mass matrix; -1 before
 * mbsr_backward. */
MBSR_API int mbsr_total_rank(const mbsr_model *model, const mbsr_data *data);

#ifdef __cplusplus
}
#endif

#endif
