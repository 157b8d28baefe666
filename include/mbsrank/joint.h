/* Joints: the stock ones, and the table through which a caller defines others.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A joint here is what Simbody and Drake call a mobilizer: it gives its body n freedoms
 * (mobilities) relative to the predecessor, in minimal coordinates. */
#ifndef MBSRANK_JOINT_H
#define MBSRANK_JOINT_H

#include <mbsrank/base.h>
#include <mbsrank/spatial.h>

#ifdef __cplusplus
extern "C" {
#endif

/* What the d velocity coordinates V of a body mean.
 *
 *   space    d     pose p               velocity V            used for
 *   FIXED    0     -                    -                     a root at rest
 *   POINT    2     x y                  its time derivative   point masses in the plane
 *   PLANAR   3     x y angle            its time derivative   rigid bodies in the plane
 *   SPATIAL  6     R r (12 numbers)     omega v               rigid bodies
 *   FLEXIBLE 6+n   R r s                omega v s'            bodies with n modes (flex.h)
 *   GENERAL  any   np numbers, any      d numbers, any        what the joint's callbacks say
 *
 * x, y in m along the world axes, angle in rad counter-clockwise. R (3 x 3, column-major): columns
 * are the body's axes in the world; r: the body's origin, m. V of a SPATIAL body is its twist
 * (spatial velocity): omega: angular velocity, rad/s; v = r', m/s; both along the world axes. A =
 * V' = (omega', r''), the classical acceleration. Forces are conjugate to V: for a SPATIAL body a
 * wrench (spatial force), the moment about its origin (N m), then the force (N), along the world
 * axes. The first six numbers of a FLEXIBLE body mean the same of its frame; s: modal coordinates,
 * with forces conjugate to s'. */
typedef enum mbsr_space {
    MBSR_SPACE_FIXED = 0,
    MBSR_SPACE_GENERAL = 1,
    MBSR_SPACE_POINT = 2,
    MBSR_SPACE_PLANAR = 3,
    MBSR_SPACE_SPATIAL = 4,
    MBSR_SPACE_FLEXIBLE = 5
} mbsr_space;

/* Where R and r stand in the pose of a SPATIAL or FLEXIBLE body. s stands at MBSR_POSE_SIZE. */
#define MBSR_POSE_R 0
#define MBSR_POSE_X 9
#define MBSR_POSE_SIZE 12

/* ---- the table of a joint ---- */

typedef struct mbsr_joint mbsr_joint;

/* A motion prescribed as a function of time: writes value, first and second time derivative of each
 * prescribed coordinate. Returns 0 or a status (see mbsr_joint_table). */
typedef int (*mbsr_motion_fn)(void *user, double t, double *s, double *sdot, double *sddot);

/* What a joint's functions may read. Pointers are valid during the call only. */
typedef struct mbsr_joint_args {
    const double *param; /* param, option, motion, user, d, np, n, nq as in the mbsr_joint given */
    const int *option;
    mbsr_motion_fn motion;
    void *user;
    int d, np, n, nq;
    double t;              /* s */
    const double *q;       /* nq   joint position coordinates */
    const double *u;       /* n    joint velocity coordinates; NULL for position and jacobians */
    mbsr_space pred_space; /* what the predecessor's coordinates mean */
    int pred_d;            /* number of the predecessor's velocity coordinates */
    const double *p_pred;  /* predecessor's pose; not to be read when pred_space is FIXED */
    const double *V_pred;  /* pred_d; NULL for position and jacobians */
    const double *p;       /* np   the body's own pose; NULL for position */
    const double *V;       /* d    the body's own velocity; NULL for position and jacobians */
} mbsr_joint_args;

/* Changes of what a joint's functions read, field by field; p_pred and p are changes of the numbers
 * of the pose (for a SPATIAL body the 12 of a turned R and a moved r). Pointers that are NULL in
 * the args of the function are NULL here. */
typedef struct mbsr_joint_change {
    const double *q, *u, *p_pred, *V_pred, *p, *V;
} mbsr_joint_change;

/* Sizes of the changes over which functions of a table change noticeably, but not altogether: where
 * the library has to difference them, its steps are some 1e-4 of these. What is zero the library
 * chooses: for lengths the geometric mean of the bodies' radii of gyration about their origins
 * (where no body has one, of the ways between origins at q = 0, or of points that forces act at;
 * else 1 m), for angles 1 rad, for times 1 / frequency of a pendulum of that length under the
 * model's gravity, without gravity what velocities and forces tell, else 1 s. Velocities count as
 * length / time and angle / time. Finite, not negative. */
typedef struct mbsr_scales {
    double length; /* m */
    double angle;  /* rad */
    double other; /* coordinates of joints by a caller's table, poses of bodies in GENERAL space; 0:
                      what turns a body by 1 rad or moves it by the length; 1 in GENERAL space */
    double time;  /* s */
} mbsr_scales;

#define MBSR_JOINT_TABLE_VERSION 1u

/* K is always the unit matrix: `jacobians` is called with K == NULL and nothing is factored. */
#define MBSR_JOINT_UNIT_K 1u
/* J has full column rank in every state by construction: the library does not check it. */
#define MBSR_JOINT_REGULAR_J 2u

/* The joint between a body i and its predecessor pi, in M. Arnold's notation (Mech. Sci. 4, 2013,
 * doi:10.5194/ms-4-221-2013, (7)-(9)):
 *
 *   0 = k(p_i, p_pi, q_i, t)
 *   0 = K V_i + H V_pi + J u_i + kI
 *   0 = K A_i + H A_pi + J u_i' + kII
 *
 * with K = dk/dp_i (d x d), H = dk/dp_pi (d x d_pi), J = dk/dq_i (d x n); where V is not p', as for
 * SPATIAL bodies, the second line defines them. Solved for V and A,
 *
 *   V_i = X V_pi + S u - K^-1 kI,     A_i = X A_pi + S u' + c
 *   X = -K^-1 H,   S = -K^-1 J,   c = -K^-1 kII
 *
 * where S spans the joint's motion subspace and c is the bias (velocity-product) acceleration,
 * which with prescribed coordinates contains their accelerations.
 *
 * Matrices are column-major without padding. Outputs arrive preset: K the unit matrix, all others
 * zero, so that a function writes only what differs. Each function returns 0, or a status that ends
 * the evaluation and reaches the caller unchanged (> 0 recoverable, < 0 fatal). Functions may be
 * called by several threads at once. */
typedef struct mbsr_joint_table {
    unsigned version; /* MBSR_JOINT_TABLE_VERSION */
    unsigned flags;   /* MBSR_JOINT_UNIT_K | MBSR_JOINT_REGULAR_J */
    const char *name; /* for messages; must outlive the model */

    /* Solves (7) for the pose p (np). */
    int (*position)(const mbsr_joint_args *args, double *p);

    /* K (NULL with MBSR_JOINT_UNIT_K), H, J and kI (d); all depend on (t, q, p, p_pred) only. */
    int (*jacobians)(const mbsr_joint_args *args, double *K, double *H, double *J, double *kI);

    /* kII (d) = K' V + H' V_pred + J' u + kI', what is left of (9) where A, A_pred, u' are 0. */
    int (*bias)(const mbsr_joint_args *args, double *kII);

    /* Optional: time derivatives of K (NULL with MBSR_JOINT_UNIT_K), H and J along the motion. */
    int (*rates)(const mbsr_joint_args *args, double *Kdot, double *Hdot, double *Jdot);

    /* Optional: q' (nq) = G(q) u. Without it q' = u and nq must equal n. */
    int (*coordinate_rates)(const mbsr_joint_args *args, double *qdot);

    /* Optional: brings q (nq, may be changed) to its normal form, such as quaternions to length 1;
     * mbsr_dae_pack and mbsr_dae_unpack call it. The pose must not depend on what it changes. */
    int (*normalise)(const mbsr_joint_args *args, double *q);

    /* Optional: called once when the model is finished. On refusal returns a status and may write a
     * text. */
    int (*check)(const mbsr_joint *joint, mbsr_space pred_space, int pred_d,
                 char text[MBSR_TEXT_SIZE]);

    /* Optional: name of parameter k for messages, such as " (pitch)". */
    const char *(*parameter)(int k);

    /* Optional, for newton.h: the derivatives along `by` of what `position` and `jacobians` write,
     * t held; dK is NULL with MBSR_JOINT_UNIT_K. args as for jacobians; of `by` q and p_pred.
     * Without it they are differenced. */
    int (*tangent)(const mbsr_joint_args *args, const mbsr_joint_change *by, double *dp, double *dK,
                   double *dH, double *dJ, double *dkI);

    /* Optional, likewise: the derivatives of what `bias`, `rates` and, where there is one,
     * `coordinate_rates` write (dKdot, dqdot NULL where those do not write). args and `by` with
     * velocities; p and V of `by` are the changes that follow from the others. */
    int (*rate_tangent)(const mbsr_joint_args *args, const mbsr_joint_change *by, double *dkII,
                        double *dKdot, double *dHdot, double *dJdot, double *dqdot);

    /* Optional: called when the body is added, for what does not depend on the predecessor. The
     * fields of the joint may have been changed since a constructor made it; d, np, n, nq and
     * params are in their ranges and param is finite. On refusal returns a status and may write a
     * text. */
    int (*check_fields)(const mbsr_joint *joint, char text[MBSR_TEXT_SIZE]);

    /* Optional: steps of differences where rates, tangent or rate_tangent are missing. */
    mbsr_scales scales;
} mbsr_joint_table;

#define MBSR_JOINT_PARAMS 48
#define MBSR_JOINT_OPTIONS 8

/* A joint as a value; made by a constructor below, copied into the model. Fields of a stock joint
 * that were changed so that they do not fit each other are refused when the body is added. */
struct mbsr_joint {
    const mbsr_joint_table *table;   /* must outlive the model */
    mbsr_space space;                /* meaning of the body's coordinates */
    int d;                           /* velocity coordinates of the body, 1 .. MBSR_MAX_D */
    int np;                          /* numbers in its pose */
    int n;                           /* joint velocity coordinates (mobilities), 0 .. d */
    int nq;                          /* joint position coordinates */
    int params;                      /* how many entries of param are used; the model keeps these */
    double param[MBSR_JOINT_PARAMS]; /* constants of the joint, finite */
    int option[MBSR_JOINT_OPTIONS];  /* choices of the joint */
    mbsr_motion_fn motion;           /* prescribed coordinates, or NULL */
    void *user; /* for the table's functions and for motion; not copied, may be NULL */
};

#define MBSR_MAX_D 256

/* ---- stock joints in the plane ---- */

/* A frame fixed to a body: origin in the body's axes (m) and angle (rad). */
typedef struct mbsr_planar_frame {
    double x, y, angle;
} mbsr_planar_frame;

/* Coordinates of frame B (on the body) relative to frame A (on the predecessor), in this order. */
#define MBSR_X 1     /* displacement along A's x axis, m */
#define MBSR_Y 2     /* displacement along A's y axis, m */
#define MBSR_ANGLE 4 /* rotation, rad */

/* The planar joint in general: the coordinates in `free` are the joint coordinates q, those in
 * `driven` follow `motion` (one entry each, in the order x, y, angle), the others stay zero. The
 * body is PLANAR (d = 3); the predecessor a PLANAR body, a POINT (whose axes do not turn) or a
 * root. `user` goes to `motion`. */
MBSR_API mbsr_joint mbsr_joint_planar(mbsr_planar_frame A, mbsr_planar_frame B, int free,
                                      int driven, mbsr_motion_fn motion, void *user);

/* Its common cases. n = 0, 1, 1, 2, 3. */
MBSR_API mbsr_joint mbsr_joint_planar_weld(mbsr_planar_frame A, mbsr_planar_frame B);
MBSR_API mbsr_joint mbsr_joint_planar_revolute(mbsr_planar_frame A, mbsr_planar_frame B);
MBSR_API mbsr_joint mbsr_joint_planar_prismatic(mbsr_planar_frame A,
                                                mbsr_planar_frame B); /* along A's x axis */
MBSR_API mbsr_joint mbsr_joint_planar_pin_slot(mbsr_planar_frame A,
                                               mbsr_planar_frame B); /* x and angle */
/* All three coordinates free: x, y and angle; n = 3. */
MBSR_API mbsr_joint mbsr_joint_planar_free(mbsr_planar_frame A, mbsr_planar_frame B);

/* A point (d = 2) at x, y in frame A of its predecessor: `free` and `driven` from MBSR_X and
 * MBSR_Y. */
MBSR_API mbsr_joint mbsr_joint_point(mbsr_planar_frame A, int free, int driven,
                                     mbsr_motion_fn motion, void *user);

/* A point that may move in both directions from its predecessor: p_i = p_pi + q_i. n = 2. */
MBSR_API mbsr_joint mbsr_joint_point_free(void);

/* ---- stock joints in space ----
 *
 * Frame A is fixed to the predecessor, frame B to the body (each in the axes of its own body; NULL:
 * the body's own frame). The joint moves B in A; the coordinates are zero where B lies on A. The
 * body is SPATIAL (d = 6); the predecessor a SPATIAL body, a PLANAR body or POINT (in the plane z =
 * 0), or a root. Frames whose axes are not orthonormal, axes of length zero and the like are
 * refused when the body is added. A direction that is NULL counts as one of length zero. */

typedef enum mbsr_axis_kind {
    MBSR_AXIS_ROTATION = 1,    /* rad about the axis */
    MBSR_AXIS_TRANSLATION = 2, /* m along it */
    MBSR_AXIS_SCREW = 3        /* rad about it, with pitch m/rad along it */
} mbsr_axis_kind;

/* One coordinate of a compound joint. */
typedef struct mbsr_axis {
    mbsr_axis_kind kind;
    double direction[3]; /* any length but zero, in A as moved by the axes before */
    double pitch;        /* m/rad, SCREW only */
    int driven;          /* 0: a joint coordinate; 1: follows the joint's motion function */
} mbsr_axis;

/* Several axes in one body, without bodies between them: from A, each axis moves what follows it.
 * q, u are the coordinates of the axes that are not driven, in their order; `motion` gives those
 * that are, in their order. count: 0 .. 6; axes may be NULL for 0, and is refused elsewhere when
 * the body is added. Where axes without armature become dependent (gimbal lock) the state is
 * refused with MBSR_RANK_DEFICIENT_J. */
MBSR_API mbsr_joint mbsr_joint_compound(const mbsr_frame *A, const mbsr_frame *B, int count,
                                        const mbsr_axis *axes, mbsr_motion_fn motion, void *user);

/* Common cases of compound joints. Axes in A. The first one holds B on A; n = 0. */
MBSR_API mbsr_joint mbsr_joint_weld(const mbsr_frame *A, const mbsr_frame *B);
/* Joints with one freedom: the angle about the axis in rad, or the displacement along it in m. */
MBSR_API mbsr_joint mbsr_joint_revolute(const mbsr_frame *A, const mbsr_frame *B,
                                        const double axis[3]);
MBSR_API mbsr_joint mbsr_joint_prismatic(const mbsr_frame *A, const mbsr_frame *B,
                                         const double axis[3]);
/* A turn about the axis that moves along it: q in rad; pitch in m/rad. */
MBSR_API mbsr_joint mbsr_joint_screw(const mbsr_frame *A, const mbsr_frame *B, const double axis[3],
                                     double pitch);
/* A turn about the axis and a displacement along it: q = (angle, displacement). */
MBSR_API mbsr_joint mbsr_joint_cylindrical(const mbsr_frame *A, const mbsr_frame *B,
                                           const double axis[3]);
/* Two turns: the first axis fixed in A, the second turned by it; they must not be parallel. */
MBSR_API mbsr_joint mbsr_joint_universal(const mbsr_frame *A, const mbsr_frame *B,
                                         const double first[3], const double second[3]);
/* B slides in the x-y plane of A and turns about its z axis: q = (x, y, angle). */
MBSR_API mbsr_joint mbsr_joint_in_plane(const mbsr_frame *A, const mbsr_frame *B);
/* B moves without rotation: q = (x, y, z) along A's axes. */
MBSR_API mbsr_joint mbsr_joint_translational(const mbsr_frame *A, const mbsr_frame *B);

/* Orientation of B in A by a quaternion q = (w, x, y, z); u = omega of B relative to A, along A's
 * axes (rad/s); q' = G(q) u = 1/2 (0, u) q (mbsr_coordinate_rates), so u is not the rate of any
 * coordinate. nq = 4, n = 3. The rotation is that of q / |q|. q' is
 * perpendicular to q, so |q| changes by errors of integration only and need not be watched; |q| = 0
 * is refused with MBSR_ZERO_QUATERNION. No orientation is singular. */
MBSR_API mbsr_joint mbsr_joint_spherical(const mbsr_frame *A, const mbsr_frame *B);

/* The floating base of robotics: q = (quaternion, x, y, z), u = (omega, v), as the spherical joint,
 * with x, y, z the origin of B in A and v = (x', y', z'), all along A's axes; nq = 7, n = 6. */
MBSR_API mbsr_joint mbsr_joint_free(const mbsr_frame *A, const mbsr_frame *B);

/* A stock joint in space as what it is made of: axes one after the other and then, with
 * `quaternion` = 1, a rotation by a quaternion, whose numbers come first in q (4) and u (3). */
typedef struct mbsr_joint_chain {
    mbsr_frame A, B;
    int axes;
    mbsr_axis axis[6];
    int quaternion;
} mbsr_joint_chain;

/* Status: MBSR_OK, MBSR_ERR_NULL, MBSR_ERR_SPACE (it is no stock joint in space), or that with
 * which the joint would be refused. */
MBSR_API int mbsr_joint_chain_of(const mbsr_joint *joint, mbsr_joint_chain *chain);

/* ---- user-defined joints ---- */

/* A joint with the caller's own table: GENERAL space, np = d, nq = n, params = 8; change these
 * fields where they differ. With space = MBSR_SPACE_SPATIAL, d = 6, np = MBSR_POSE_SIZE the stock
 * inertias and force elements apply. */
MBSR_API mbsr_joint mbsr_joint_custom(const mbsr_joint_table *table, int d, int n, void *user);

#ifdef __cplusplus
}
#endif

#endif
