/* The evaluation stages, inverse and forward dynamics, mass matrix, energies, ranks.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   forward dynamics   articulated-body algorithm (ABA, Featherstone)   mbsr_forward_dynamics
 *   inverse dynamics   recursive Newton-Euler algorithm (RNEA)          mbsr_inverse_dynamics
 *   mass matrix        composite rigid-body algorithm (CRBA)            mbsr_mass_matrix
 *
 * Symbols and equation numbers are those of M. Arnold, Mech. Sci. 4 (2013) 221-231,
 * doi:10.5194/ms-4-221-2013; docs/theory.md lists them, and docs/neighbours.md ("What you may know
 * it as") has the names that other books and libraries use. As there, K is divided out: K = 1, H
 * carries a motion of the predecessor to the body with the sign reversed, and J = -S, where S spans
 * the joint's motion subspace.
 *
 * q, u, u' and tau are vectors over the whole tree (mbsr_model_nq, mbsr_model_nu), ordered by body
 * id: joint (minimal) coordinates, their velocities and accelerations, and generalised forces.
 * Outputs must not overlap inputs. No function here allocates, but forward and inverse dynamics of
 * models with closures that vector code does not serve, where many more rows or motions without
 * mass wait for each other than the data has memory for: they take more from the model's allocator,
 * for the call. Statuses common to all: MBSR_ERR_NULL, MBSR_ERR_MISMATCH (data of another model),
 * MBSR_NOT_FINITE (an argument or a result is NaN or infinite, such as one that overflows: with
 * MBSR_OK all numbers are finite), and whatever a callback returned, unchanged; the text is in
 * mbsr_data_error. */
#ifndef MBSRANK_DYNAMICS_H
#define MBSRANK_DYNAMICS_H

#include <mbsrank/data.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- the stages, each needing those before it (else MBSR_ERR_SEQUENCE) ---- */

/* Forward kinematics: poses (7), root to leaves; K, H, J, kI and M in that pose.  q: nq.
 * MBSR_NOT_FINITE, MBSR_SINGULAR_K, MBSR_RANK_DEFICIENT_J. */
MBSR_API int mbsr_stage_positions(const mbsr_model *model, mbsr_data *data, double t,
                                  const double *q);

/* Velocities (twists), root to leaves: V = -(H V_pred + J u + kI) (8). What depends on velocities:
 * the bias acceleration -kII of (9) and the gyroscopic force h of M A + h.  u: nu.
 * MBSR_NOT_FINITE. */
MBSR_API int mbsr_stage_velocities(const mbsr_model *model, mbsr_data *data, const double *u);

/* Forces: f (d, a wrench for a SPATIAL body: what the force elements exert, less h) and joint
 * forces: those of the force elements, plus tau (nu, may be NULL for none). */
MBSR_API int mbsr_stage_forces(const mbsr_model *model, mbsr_data *data, const double *tau);

/* Backward recursion (17), the inward pass of the ABA: Mbar, fbar, D, ranks. With sums over the
 * successors j, and the pseudo-inverse D^+ where the ABA has D^-1,
 *
 *   D    = J^T Mbar J
 *   Mbar = M + sum H_j^T (Mbar_j - Mbar_j J_j D_j^+ J_j^T Mbar_j) H_j
 *   fbar = f - sum H_j^T m_j,     m = (1 - Mbar J D^+ J^T) (fbar + Mbar kII) + Mbar J D^+ tau
 *
 * Mbar is the articulated-body inertia and -fbar the articulated-body bias force: the joint must
 * exert Mbar A - fbar on the body for it to have the acceleration A.  MBSR_EIGEN_FAILED,
 * MBSR_INDEFINITE_MASS, MBSR_RANK_CHANGED (see mbsr_rank_watch). */
MBSR_API int mbsr_stage_backward(const mbsr_model *model, mbsr_data *data);

/* Forward recursion (18)-(24), the outward pass of the ABA, for given u' (nu): accelerations root
 * to leaves, where rank-deficient bodies, adjacent ones too, are skipped; and the residual (25),
 *
 *   residual = D u' - [tau - J^T fbar - J^T Mbar (H A_pred + kII)],      nu numbers,
 *
 * which is zero on the equations of motion. MBSR_ERR_CLOSURES. */
MBSR_API int mbsr_stage_forward(const mbsr_model *model, mbsr_data *data, const double *udot,
                                double *residual);

/* ---- whole evaluations ---- */

/* Rates of the joint coordinates, q' = G(q) u; qdot: nq. G is the unit matrix but for quaternions
 * and a caller's own joints.  Needs mbsr_stage_velocities. */
MBSR_API int mbsr_coordinate_rates(const mbsr_model *model, mbsr_data *data, double *qdot);

/* Brings q (nq, changed in place) to its normal form: quaternions to length 1. No pose depends on
 * what this changes. mbsr_dae_pack and mbsr_dae_unpack do it.
 * MBSR_ZERO_QUATERNION names the body. */
MBSR_API int mbsr_normalise(const mbsr_model *model, mbsr_data *data, double *q);

/* Residual (25) at a state: the five stages. tau may be NULL.  All statuses of the stages. */
MBSR_API int mbsr_recursive_residual(const mbsr_model *model, mbsr_data *data, double t,
                                     const double *q, const double *u, const double *udot,
                                     const double *tau, double *residual);

/* The joint rates that have a motor. */
typedef struct mbsr_motors {
    int count;       /* 0 .. nu */
    const int *rate; /* indices of u, each at most once; may be NULL for none */
} mbsr_motors;

/* Inverse dynamics by the recursive Newton-Euler algorithm (RNEA), O(N): the joint forces tau (nu)
 * that, in addition to the force elements, give the accelerations udot (nu):
 *
 *   A    = -(H A_pred + J u' + kII)      root to leaves (9)
 *   mu   = f - M A - sum H_j^T mu_j      leaves to root (11), over the successors j
 *   need = J^T mu - (joint forces of the force elements)
 *
 * No rank decision, no pseudo-inverse. Gravity is a force element like any other, not an
 * acceleration of the root. Stiff rows of closures are springs, and count among the force elements.
 * tau less the tau that is applied is the inverse-dynamics residual of dae.h.
 *
 * motors NULL: every joint rate has a motor, tau = need, and rigid rows of closures exert nothing.
 * Else tau is zero at rates without a motor, and with the rigid rows C
 *
 *   tau + C^T lambda = need                  lambda: mbsr_closures_lambda (closure.h)
 *
 * in O(bodies + loops). Where there are more motors than freedoms |tau| is the least; rows that are
 * redundant where a loop closes share by least norm there, of moments and of forces times the
 * model's length. MBSR_UNDETERMINED names a joint that the motors cannot move as asked for; tau is
 * then as it was. Where vector code does not serve the model, memory is taken for the call:
 * MBSR_ERR_NO_MEMORY. MBSR_ERR_VALUE names an entry of motors. All statuses of
 * mbsr_stage_positions, mbsr_stage_velocities and mbsr_stage_forces. */
MBSR_API int mbsr_inverse_dynamics(const mbsr_model *model, mbsr_data *data, double t,
                                   const double *q, const double *u, const double *udot,
                                   const mbsr_motors *motors, double *tau);

/* Forward dynamics by the articulated-body algorithm (ABA), O(N): the accelerations udot (nu) under
 * the force elements and tau (nu, may be NULL). MBSR_UNDETERMINED names the first joint whose block
 * D is rank-deficient: no equation of second order determines its accelerations. udot then holds
 * those in the range of the blocks D, and accelerations of all bodies with mass are right; what
 * forces and closures make of the others mbsr_completion_dynamics finds (completion.h). All
 * statuses of the stages.
 *
 * With closures (closure.h) at a state that they allow: udot, and the loop forces for
 * mbsr_closures_lambda, in O(bodies + loops),
 *
 *   M udot - C^T lambda = tau - (inverse dynamics at udot = 0),    C udot = -bias
 *
 * with the rigid rows C; stiff rows are springs. Rows that are redundant where a loop closes share
 * by least norm there. MBSR_UNDETERMINED names a joint that moves no mass and that no rigid row
 * holds (mbsr_completion_dynamics). Also MBSR_ERR_NO_MEMORY, MBSR_LOOP_OPEN where rows contradict
 * each other, MBSR_LOOP_SINGULAR where they depend so nearly on others that the accelerations do
 * not balance the forces. */
MBSR_API int mbsr_forward_dynamics(const mbsr_model *model, mbsr_data *data, double t,
                                   const double *q, const double *u, const double *tau,
                                   double *udot);

/* Forward dynamics with an estimate of the error in it, O(N), at about twice the price of the five
 * stages: the accelerations are corrected twice by forward dynamics of what inverse dynamics finds
 * missing,
 *
 *   r = tau - (inverse dynamics of udot),     M du = r,     udot <- udot + du.
 *
 * error (nu, may be NULL): the error left in each number of udot, in its units, never negative: the
 * size of the last correction and what rounding in the forces makes of the rest. *relative (may be
 * NULL), without units, 0 .. 1: the largest over all joints of (error) / (acceleration), where a
 * joint's x has the size sqrt(x^T D x). 1e-10 and less is usual; 1 means that a joint's
 * acceleration is nothing but error, or that it is zero up to rounding, as of a joint at rest. An
 * estimate, no bound; q, u, tau and the model count as exact. What makes errors large are masses
 * and lengths that differ by many powers of ten along a tree; see docs/rank_and_index.md.
 *
 * Statuses of mbsr_forward_dynamics; MBSR_UNDETERMINED leaves error and *relative as they were;
 * MBSR_ERR_CLOSURES. */
MBSR_API int mbsr_forward_dynamics_refined(const mbsr_model *model, mbsr_data *data, double t,
                                           const double *q, const double *u, const double *tau,
                                           double *udot, double *error, double *relative);

/* Generalised bias forces (non-linear effects): inverse dynamics of udot = 0, so that
 *
 *   mass matrix * udot + bias = tau.
 *
 * bias (nu): Coriolis, centrifugal and gyroscopic terms and those of prescribed motion, less the
 * generalised forces of all force elements, gravity among them. Statuses of
 * mbsr_inverse_dynamics. */
MBSR_API int mbsr_bias_forces(const mbsr_model *model, mbsr_data *data, double t, const double *q,
                              const double *u, double *bias);

/* Joint-space mass matrix (joint-space inertia matrix), nu x nu, column-major, symmetric, both
 * triangles written; positive semi-definite. By the composite rigid-body algorithm (CRBA):
 *
 *   C_i = M_i + sum H_j^T C_j H_j,     block (i, i) = J_i^T C_i J_i,
 *   block (k, i) = J_k^T (-H^T) ... (-H^T) C_i J_i for the predecessors k of i.
 *
 * O(nu^2).  Needs mbsr_stage_positions; for inertias by function, mbsr_stage_velocities. Composite
 * inertias take the place of Mbar, so mbsr_stage_backward must run again before what needs it. */
MBSR_API int mbsr_mass_matrix(const mbsr_model *model, mbsr_data *data, double *matrix);

/* Generalised momenta p = (joint-space mass matrix) u + what prescribed motion adds, nu numbers,
 * without the matrix, O(N): p = J^T m with M V + m + sum H_j^T m_j = 0. Needs
 * mbsr_stage_velocities. */
MBSR_API int mbsr_momenta(const mbsr_model *model, mbsr_data *data, double *p);

/* Kinetic energy 1/2 sum V^T M V and potential energy of the force elements that have one, in J.
 * Needs mbsr_stage_velocities. Outputs may be NULL. */
MBSR_API int mbsr_energy(const mbsr_model *model, mbsr_data *data, double *kinetic,
                         double *potential);

/* Kinetic energy of one body, in J: 1/2 V^T M V, and that of the armature of its joint. Needs
 * mbsr_stage_velocities. The ground has none. MBSR_ERR_ID. */
MBSR_API int mbsr_body_energy(const mbsr_model *model, mbsr_data *data, int body, double *kinetic);

/* Power in W that the force elements turn into heat; those without a function for it count as
 * zero. Needs mbsr_stage_velocities. */
MBSR_API int mbsr_dissipation(const mbsr_model *model, mbsr_data *data, double *power);

/* Potential energy and dissipated power of one force element; zero where it has none. Outputs may
 * be NULL. Needs mbsr_stage_velocities. MBSR_ERR_ID. */
MBSR_API int mbsr_force_power(const mbsr_model *model, mbsr_data *data, int force, double *energy,
                              double *power);

/* What one force element exerts on one of its bodies: f (d numbers, conjugate to V; for a SPATIAL
 * body the wrench about its origin, moment first, world axes) and tau (n, conjugate to u; as
 * mbsr_force_body). place: 0 .. bodies - 1 in the element's list; the id of the body for an element
 * that acts on every body. Outputs may be NULL; for the ground f has the root's d numbers and tau
 * none. An element that is switched off exerts nothing. Needs mbsr_stage_velocities. MBSR_ERR_ID,
 * MBSR_ERR_VALUE (place), MBSR_NOT_FINITE, what the element returned. */
MBSR_API int mbsr_force_load(const mbsr_model *model, mbsr_data *data, int force, int place,
                             double *f, double *tau);

/* A contact (mbsr_force_contact) at a state. */
typedef struct mbsr_contact_state {
    double depth, rate;  /* m, positive where there is contact; m/s. The rest is zero without */
    double normal_force; /* N, never negative */
    double friction[3];  /* N, on body a along the plane, world axes */
    double sliding[3];   /* m/s, velocity of a against b along the plane */
    double normal[3];    /* unit vector from b to a */
    double point[3];     /* m, of the world: the point of the sphere that is deepest */
} mbsr_contact_state;

/* Depth, forces and sliding of a contact. Needs mbsr_stage_velocities. MBSR_ERR_NULL, MBSR_ERR_ID,
 * MBSR_ERR_VALUE (the element is no contact). */
MBSR_API int mbsr_contact_at(const mbsr_model *model, mbsr_data *data, int force,
                             mbsr_contact_state *state);

/* Calls `look` once with what the functions of an element are called with at this state, f and tau
 * NULL; for elements of your own that are to be asked for more than forces. Needs
 * mbsr_stage_velocities. What look returns other than 0 is reported as its status. MBSR_ERR_NULL,
 * MBSR_ERR_ID, MBSR_ERR_VALUE (the element acts on every body). */
MBSR_API int mbsr_force_inspect(const mbsr_model *model, mbsr_data *data, int force,
                                int (*look)(const mbsr_force_args *args, void *user), void *user);

/* Switches a force element off in these data (on = 0) and on again: it then exerts nothing, has no
 * energy and no derivatives there, as if the model had been made without it. For inverse dynamics
 * without the element that a controller stands for, say. Gravity cannot be switched off. Batches
 * and other data do not notice. Stages from mbsr_stage_forces on have to run again. MBSR_ERR_NULL,
 * MBSR_ERR_MISMATCH, MBSR_ERR_ID, MBSR_ERR_VALUE (gravity; on is neither 0 nor 1). */
MBSR_API int mbsr_force_switch(const mbsr_model *model, mbsr_data *data, int force, int on);

/* Mass and centre of mass (m, world axes; zero if there is no mass) of all POINT, PLANAR and
 * SPATIAL bodies, and their spatial momentum: the angular momentum about the point `about` (NULL:
 * the world's origin; kg m^2/s), then the linear (kg m/s), world axes. With about = centre it is
 * the centroidal momentum. Outputs may be NULL. Needs mbsr_stage_velocities.
 * MBSR_ERR_SPACE names the first body with inertia that is in GENERAL space. */
MBSR_API int mbsr_tree_momentum(const mbsr_model *model, mbsr_data *data, const double about[3],
                                double *mass, double centre[3], double momentum[6]);

/* The accelerations (9) and joint reactions (11) that belong to udot (nu), as found by
 * mbsr_forward_dynamics or by an integrator, under the forces of the state: for
 * mbsr_body_acceleration and mbsr_joint_reaction. Needs mbsr_stage_forces. */
MBSR_API int mbsr_stage_accelerations(const mbsr_model *model, mbsr_data *data, const double *udot);

/* ---- results per body ---- */

/* Pose p (np numbers; needs mbsr_stage_positions) and velocity V (d numbers; needs
 * mbsr_stage_velocities) of a body. V of a SPATIAL body is its twist (spatial velocity) (omega, v):
 * world axes, v of the body's origin. MBSR_GROUND gives those of the root. MBSR_ERR_ID,
 * MBSR_ERR_SEQUENCE. */
MBSR_API int mbsr_body_pose(const mbsr_model *model, mbsr_data *data, int body, double *pose);
MBSR_API int mbsr_body_twist(const mbsr_model *model, mbsr_data *data, int body, double *twist);

/* Acceleration A = V' of a body (d numbers). Of a SPATIAL body it is (omega', r'') with the second
 * derivative r'' of the origin's position, the classical acceleration. (Featherstone's spatial
 * acceleration is (omega', r'' - omega x v).)
 *
 * Joint reaction (d, conjugate to V; a wrench for a SPATIAL body, moment first): -K^T mu, what the
 * joint exerts on the body, drives and joint force elements included. The predecessor feels -H^T
 * mu. For MBSR_GROUND: the force that holds the root.
 *
 * Both are valid from mbsr_stage_accelerations or mbsr_inverse_dynamics until the next stage runs,
 * else MBSR_ERR_SEQUENCE; after inverse dynamics the reactions include the joint forces that it
 * found. MBSR_ERR_ID. */
MBSR_API int mbsr_body_acceleration(const mbsr_model *model, mbsr_data *data, int body,
                                    double *acceleration);
MBSR_API int mbsr_joint_reaction(const mbsr_model *model, mbsr_data *data, int body, double *force);

/* Where a point fixed on a body is in the world (m), its velocity (m/s) and its acceleration
 * (m/s^2), each may be NULL and needs mbsr_stage_positions, mbsr_stage_velocities,
 * mbsr_stage_accelerations (or mbsr_inverse_dynamics): of the point p on a SPATIAL body
 *
 *   r + R p,   v + omega x R p,   r'' + omega' x R p + omega x (omega x R p).
 *
 * point: along the body's axes (NULL: its origin); of PLANAR bodies the third component is of no
 * matter, of POINT bodies all are. Of a FLEXIBLE body it is fixed in the frame and does not follow
 * the deformation; markers do (flex.h). The ground is the root. MBSR_ERR_ID, MBSR_ERR_SPACE (a
 * GENERAL body), MBSR_ERR_SEQUENCE. */
MBSR_API int mbsr_body_point(const mbsr_model *model, mbsr_data *data, int body,
                             const double point[3], double position[3], double velocity[3],
                             double acceleration[3]);

/* Geometric Jacobian dV/du of a body's origin: d x nu, column-major; V = jacobian u + what
 * prescribed motion adds. Rows as in V: for a SPATIAL body three angular ones, then three linear
 * ones, world axes. (Not J, which is of one joint and has the other sign.) Needs
 * mbsr_stage_positions. MBSR_ERR_ID. */
MBSR_API int mbsr_body_jacobian(const mbsr_model *model, mbsr_data *data, int body,
                                double *jacobian);

/* The rank decision of one joint. D = J^T Mbar J is compared with the rounding errors that can be
 * in it, machine precision times J^T W J: W runs beside Mbar from the leaves to the root and adds
 * up the sizes of its terms before anything cancels (docs/rank_and_index.md). The eigenvalues below
 * are those of
 *
 *   S D S,     S = diag(J^T W J)^(-1/2)     (a scaling, not the motion subspace).
 *
 * They have no units and lie between 0 and 1, or a little above 1 for n > 1; one counts as zero
 * when it is at most `tolerance`, or 3e-4 of that where all of it is known to 32 digits
 * (docs/rank_and_index.md). */
typedef struct mbsr_rank_info {
    int n;                /* size of D */
    int rank;             /* eigenvalues kept */
    double tolerance;     /* of the model; dimensionless */
    double scale;         /* largest entry of diag(J^T W J), in units of D */
    double smallest_kept; /* of the scaled eigenvalues; 0 when none was kept */
    double
        largest_dropped; /* of the scaled eigenvalues, in absolute value; 0 when none was dropped */
} mbsr_rank_info;

/* How the rank of a joint was decided. Needs mbsr_stage_backward. MBSR_ERR_ID, MBSR_ERR_SEQUENCE.
 */
MBSR_API int mbsr_body_rank(const mbsr_model *model, mbsr_data *data, int body,
                            mbsr_rank_info *info);

/* Remembers the ranks of the last mbsr_stage_backward (on != 0; needs it) or forgets them (on ==
 * 0). While they are remembered, mbsr_stage_backward returns the recoverable MBSR_RANK_CHANGED,
 * naming the body, where a joint has another rank. The momentum, index-1 and recursive forms hold
 * between changes of rank only. */
MBSR_API int mbsr_rank_watch(const mbsr_model *model, mbsr_data *data, int on);

#ifdef __cplusplus
}
#endif

#endif
