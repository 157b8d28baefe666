/* Force elements: the stock ones, and the table through which a caller defines others.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRANK_FORCE_H
#define MBSRANK_FORCE_H

#include <mbsrank/base.h>
#include <mbsrank/inertia.h>
#include <mbsrank/joint.h>
#include <mbsrank/table.h>

#ifdef __cplusplus
extern "C" {
#endif

/* One body as a force element sees it. For the ground, p and V are those of the root (not to be
 * read when space is FIXED), n is 0, and what is added to f is dropped. f of a SPATIAL body is a
 * wrench (spatial force): moment about its origin, then force, world axes. Pointers are valid
 * during the call only. */
typedef struct mbsr_force_body {
    int id;           /* as given by mbsr_model_add_body, or MBSR_GROUND */
    mbsr_space space; /* meaning of p, V and f */
    int d, np, n, nq;
    const double *p;             /* np */
    const double *V;             /* d;  NULL while the energy is asked for */
    const double *M;             /* d x d, the body's own mass matrix; NULL for the ground */
    const mbsr_inertia *inertia; /* as given to the model; NULL for the ground */
    const double *q;             /* nq; NULL for the ground */
    const double *u;             /* n;  NULL for the ground and while the energy is asked for */
    /* NULL while the energy or the dissipation is asked for: */
    double *f;   /* d,  conjugate to V; add to it */
    double *tau; /* n,  conjugate to u; add to it.  NULL for the ground */
    /* values of the coordinates that the joint has as it was given, NaN for those left, which q, u
     * and tau have; NULL: none is locked (mbsr_model_lock) */
    const double *locked_at;
} mbsr_force_body;

typedef struct mbsr_force_def mbsr_force_def;

/* What the functions of a force element are called with. */
typedef struct mbsr_force_args {
    const mbsr_force_def *force; /* the element as given to the model: param, option, user */
    double t;                    /* s */
    int bodies;                  /* number of entries in body */
    const mbsr_force_body *body; /* in the order of the definition */
    char *text; /* MBSR_TEXT_SIZE: where evaluate and pairs may explain the status they return; NULL
                   in check */
    void *memory;    /* what `needs` asked for, of one data object, zero at first; NULL in check */
    const int *pair; /* in derivatives of an element by pairs: places of both bodies in the
                        definition, body has these two; else NULL */
} mbsr_force_args;

/* What an element wants of every data object. */
typedef struct mbsr_force_needs {
    size_t bytes; /* of args->memory */
    int pairs;    /* that act on each other at a time, at most; elements by pairs */
} mbsr_force_needs;

/* Derivatives of the forces of an element: matrix (rows x columns, column-major). Body k of args
 * has its f (d) in the rows from row[k] on, then its tau (n); in the columns from column[k] on its
 * pose, V (d), q (nq) and u (n). The pose of a SPATIAL body counts six columns: its rotation by a
 * small angle about its origin, along the world's axes, and the displacement of its origin; that of
 * a FLEXIBLE body s besides; that of another body its np numbers. The ground has no rows and
 * columns (row[k] = column[k] = -1). */
typedef struct mbsr_force_derivatives {
    double *matrix;
    int rows, columns;
    const int *row, *column;
} mbsr_force_derivatives;

#define MBSR_FORCE_TABLE_VERSION 3u

/* The element acts on every body of the tree: called once a body, with that body alone. */
#define MBSR_FORCE_EVERY_BODY 1u

/* The element reads q and u of its bodies and adds to their tau only: their p, V, M and f may be
 * NULL. */
#define MBSR_FORCE_JOINT_ONLY 2u

/* The element does not read M of its bodies, which may be NULL. */
#define MBSR_FORCE_NO_MASS 4u

/* The element reads p, V and M of its bodies and adds to their f only. */
#define MBSR_FORCE_NO_JOINT 8u

/* The element acts between two of its many bodies at a time, and few of these pairs act in a state,
 * such as contacts. It has `needs`, `pairs` and `derivatives`, and MBSR_FORCE_NO_MASS and _NO_JOINT
 * besides. Newton systems are eliminated in an order that these pairs determine. */
#define MBSR_FORCE_BY_PAIRS 16u

/* Functions return 0, or a status that ends the evaluation and reaches the caller unchanged (> 0
 * recoverable, < 0 fatal). They may be called by several threads at once, with different
 * arguments. */
typedef struct mbsr_force_table {
    unsigned version; /* MBSR_FORCE_TABLE_VERSION */
    unsigned flags;   /* MBSR_FORCE_EVERY_BODY, _JOINT_ONLY, _NO_MASS, _NO_JOINT, or 0 */
    const char *name; /* for messages; must outlive the model */

    /* Adds the element's forces to body[k].f and body[k].tau. */
    int (*evaluate)(const mbsr_force_args *args);

    /* Optional: potential energy in J; *energy arrives as zero. */
    int (*energy)(const mbsr_force_args *args, double *energy);

    /* Optional: power that the element turns into heat, in W, not negative: minus the power of its
     * forces, less the rate of its energy. *power arrives as zero. */
    int (*dissipation)(const mbsr_force_args *args, double *power);

    /* Optional: called once when the model is finished; only id, space, d, np, n and nq of the
     * bodies are set. Not called for elements that act on every body. On refusal returns a status
     * and may write a text. */
    int (*check)(const mbsr_force_args *args, char text[MBSR_TEXT_SIZE]);

    /* Optional: name of parameter k for messages, such as " (radius)"; "" where it has none. */
    const char *(*parameter)(int k);

    /* Optional, for newton.h: adds the derivatives of what evaluate adds to f and tau, t held; f
     * and tau of args are NULL. M turns with the pose: that is part of it. The pose, V, q and u
     * count as independent. Without it they are differenced, and so they are where the element
     * reads M and one of its bodies has its mass by function. */
    int (*derivatives)(const mbsr_force_args *args, const mbsr_force_derivatives *out);

    /* Optional: called when the element is added, for what does not depend on its bodies, whose
     * number is one of it. The fields may have been changed since a constructor made the element;
     * param is finite. On refusal returns a status and may write a text. */
    int (*check_fields)(const mbsr_force_def *force, char text[MBSR_TEXT_SIZE]);

    /* Optional: steps of differences where derivatives are missing. */
    mbsr_scales scales;

    /* Optional: memory that every data object sets aside for the element, and pairs at most. */
    void (*needs)(const mbsr_force_def *force, mbsr_force_needs *needs);

    /* Of elements by pairs: the pairs that act at this state, by their places in body, and their
     * number, which is not above needs.pairs: more is for a status. Each once, of different bodies;
     * the ground may be one. derivatives is then called for each of them, with args->pair, and adds
     * what follows from this pair; its row and column have two entries. */
    int (*pairs)(const mbsr_force_args *args, int (*pair)[2], int *count);

    /* Optional, for sensitivity.h: a number of the branch that the law takes at this state, as of a
     * stop that is hit or not; f and tau of args are NULL. Where it changes derivatives of forces
     * may jump; where the forces do, sensitivities are refused. */
    double (*side)(const mbsr_force_args *args);
} mbsr_force_table;

/* A force as function of time: writes `n` components. Returns 0 or a status. */
typedef int (*mbsr_force_fn)(void *user, double t, int n, double *value);

/* The law of a spring-damper: force (N, positive pulls together) and potential energy (J) at length
 * x (m) and rate v (m/s), and the power turned into heat (W) at v. All outputs arrive as zero;
 * energy and power may be NULL; v is 0 while the energy is asked for. Returns 0 or a status. */
typedef int (*mbsr_spring_fn)(void *user, double x, double v, double *force, double *energy,
                              double *power);

#define MBSR_FORCE_PARAMS 32
#define MBSR_FORCE_OPTIONS 2

/* A force element; made by a constructor below or mbsr_default_force_def, copied into the model.
 * Fields of a stock element that were changed so that they do not fit each other (bodies, option,
 * function) are refused when it is added. */
struct mbsr_force_def {
    int cookie;                    /* set by the constructors */
    const char *name;              /* copied; NULL: none */
    const mbsr_force_table *table; /* must outlive the model */
    int bodies;                    /* how many bodies it acts on */
    int body[2];                   /* their ids, MBSR_GROUND allowed, when body_list is NULL */
    const int *body_list;          /* their ids, copied, when there are more than two; else NULL */
    double param[MBSR_FORCE_PARAMS];
    int option[MBSR_FORCE_OPTIONS];
    mbsr_force_fn function; /* elements given as function of time; else NULL */
    mbsr_spring_fn spring;  /* spring-dampers given by a function; else NULL */
    void *user; /* for the table's functions and for function; not copied, may be NULL */
    /* MBSR_SPRING_SETTLED or MBSR_SPRING_LOOSE: the element becomes a closure with stiff rows
     * (closure.h) when the model is finished, behind those that were added and by the element's
     * name. Its force is then an unknown of the momentum form, and no stiffness makes steps short.
     * Linear springs with a stiffness above zero only: point, axis and joint springs, bushings in
     * space and in the plane, gears without backlash. Refused when it is added, or when the model
     * is finished: others; damping where there is no stiffness. The force is the same (the angular
     * damping of a bushing in space makes the moment J^-T damping theta', which is damping omega
     * for small theta). The element keeps its id, and cannot be switched off. Default 0: a force.
     */
    int as_closure;
};

/* What a start does with a spring that is a closure. */
typedef enum mbsr_spring_start {
    MBSR_SPRING_SETTLED = 1, /* closes it like a rigid joint and loads it with the force needed */
    MBSR_SPRING_LOOSE = 2    /* takes it as it is at the positions given, as it does with forces */
} mbsr_spring_start;

MBSR_API mbsr_force_def mbsr_default_force_def(void);

/* ---- stock elements ----
 *
 * Points and directions are given in body axes, those on the ground in the axes of the root, which
 * for a root at rest are the world's; m. A point that is NULL is the body's origin. POINT and
 * PLANAR bodies lie in the plane z = 0, turn about z, and feel what of a force is in that plane; a
 * point of a PLANAR body may lie off the plane, one of a POINT is its origin. Elements at points
 * refuse bodies in GENERAL space; those between two bodies refuse one body twice. Stiffnesses,
 * damping constants and other sizes that are negative are refused, when the model is finished; what
 * has no meaning as NULL (a law, a contact, a function of time) is refused when the element is
 * added.
 *
 * What turns power into heat says how much (mbsr_dissipation). One-sided elements (cables, stops)
 * have a damping force that is at most as large as the elastic force: so they never pull the wrong
 * way, and their force, which tends to zero where contact begins and ends, does not jump at any
 * velocity. Damping without stiffness, which would have no effect, is refused there. */

/* Uniform gravity g in m/s^2 on all POINT, PLANAR and SPATIAL bodies: f = M g. On a SPATIAL body it
 * is the wrench (s x g, m g) with its mass m and first moment s = m (centre of mass - origin); if M
 * is not a rigid body's, with the m and s of mbsr_inertia_matrix. On a FLEXIBLE body it is
 * M (0, g, 0), which its massless modes do not feel. Bodies in GENERAL space are left out: their
 * coordinates have no known direction. Gravity is a force, not an acceleration of the
 * root: a body at rest has A = 0. */
MBSR_API mbsr_force_def mbsr_force_gravity(double gx, double gy, double gz);

/* Linear spring-damper along coordinate axis `axis` (0 .. d-1): with e = p_a[axis] - p_b[axis] the
 * force on a is -(stiffness (e - rest) + damping e'). Either may be the ground (a root at rest
 * counts as p = 0). Units follow the coordinate: N/m, N s/m, m or N m/rad, N m s/rad, rad. Needs V
 * = p' of both bodies: SPATIAL ones are refused, bodies in GENERAL space are taken at their
 * word. */
MBSR_API mbsr_force_def mbsr_force_axis_spring(int a, int b, int axis, double stiffness,
                                               double damping, double rest);

/* Coulomb friction along coordinate axis `axis` of the same bodies, made smooth near rest: with e'
 * = V_a[axis] - V_b[axis] the force on a is -force e' / sqrt(e'^2 + slip^2). force in N (N m), >=
 * 0; slip > 0 in m/s (rad/s). */
MBSR_API mbsr_force_def mbsr_force_axis_friction(int a, int b, int axis, double force, double slip);

/* Spring-damper along the line from a point of body a to a point of body b. With length l and its
 * rate l' the force pulling together is
 *
 *   stiffness (l - l0) + cubic (l - l0)^3 + damping l'
 *
 * N/m, N/m^3, N s/m, free length l0 in m, none of them negative. A cable (one_sided) has no force
 * for l <= l0, and beyond, with the elastic force F of the first two terms, the force F + min(max(
 * damping l', -F), F). Where the two points coincide (with l0 > 0 or a function: but for
 * rounding) the line has no direction: MBSR_DEGENERATE_FORCE, unless it needs none, because the
 * element is a cable or l0 and damping are zero. */
typedef struct mbsr_spring {
    double stiffness, cubic, damping, free_length;
    int one_sided;           /* 1: a cable, which pulls only */
    mbsr_spring_fn function; /* the law, instead of all above; NULL: these */
    void *user;              /* for function */
} mbsr_spring;

/* A spring between two points by the law above; points along the axes of their bodies, m (NULL: the
 * origin). */
MBSR_API mbsr_force_def mbsr_force_spring(int a, const double point_a[3], int b,
                                          const double point_b[3], const mbsr_spring *spring);

/* The linear one. */
MBSR_API mbsr_force_def mbsr_force_point_spring(int a, const double point_a[3], int b,
                                                const double point_b[3], double stiffness,
                                                double damping, double free_length);

/* Bushing between frame A on body a and frame B on body b (SPATIAL or ground; NULL: the body's own
 * frame): with the origin e of B in A, its rate e' as seen from A, the rotation vector theta of B
 * in A (|theta| < pi) and the angular velocity omega of B relative to A, all along A's axes, the
 * moment and force on b are
 *
 *   -(J^-T stiffness theta + damping omega),   -(stiffness e + damping e')
 *
 * entry by entry, three angular entries first (N m/rad, N m s/rad), then three of translation (N/m,
 * N s/m), none negative, NULL: all zero; the force acts at B's origin, its reaction on a at the
 * same point. J(theta) is the matrix of omega = J theta', so that the forces follow from the energy
 * 1/2 sum of stiffness theta^2 + 1/2 sum of stiffness e^2; since J^-T theta = theta, it shows only
 * where the angular stiffnesses differ. At |theta| = pi theta jumps, and the moment with it:
 * MBSR_DEGENERATE_FORCE there, unless only entries without stiffness do. Frames that are
 * left-handed or whose axes are not orthonormal to 1e-6 are refused. */
MBSR_API mbsr_force_def mbsr_force_bushing(int a, const mbsr_frame *A, int b, const mbsr_frame *B,
                                           const double stiffness[6], const double damping[6]);

/* Bushing in the plane, between frame A on body a and frame B on body b (PLANAR, or the ground at
 * rest or PLANAR): with e = (x, y, angle) of B relative to A, along A's axes as in the planar
 * joints, and e' its rate as seen from A, force (x and y) and moment on b are
 *
 *   -(stiffness e + damping e'),
 *       two symmetric positive semi-definite 3 x 3 matrices, column-major,
 *
 * N/m, N/rad and N m/m, N m/rad and the same times s; NULL: zero. The force acts at B's origin, its
 * reaction on a at the same point. Whole turns count: the angle is the difference of the bodies'.
 */
MBSR_API mbsr_force_def mbsr_force_planar_bushing(int a, mbsr_planar_frame A, int b,
                                                  mbsr_planar_frame B, const double stiffness[9],
                                                  const double damping[9]);

/* Spring-damper on joint coordinate `coordinate` (0 .. n-1, nq = n) of a body: tau = -(stiffness (q
 * - rest) + damping u). */
MBSR_API mbsr_force_def mbsr_force_joint_spring(int body, int coordinate, double stiffness,
                                                double damping, double rest);

/* The same with a cubic term: tau = -(stiffness e + cubic e^3 + damping u), e = q - rest; cubic in
 * N/m^3 or N m/rad^3, not negative. */
MBSR_API mbsr_force_def mbsr_force_joint_cubic_spring(int body, int coordinate, double stiffness,
                                                      double cubic, double damping, double rest);

/* Spring-damper on the orientation of a spherical or free joint, or of a joint of your own whose q
 * begins with a quaternion (w, x, y, z) and u with the angular velocity omega as theirs do (nq = n
 * + 1): with the rotation vector theta (|theta| < pi) that leads from the orientation `rest` (a
 * quaternion of any length but zero; NULL: (1, 0, 0, 0), B along A) to the present one, both in
 * frame A,
 *
 *   tau = -(J^-T stiffness theta + damping omega)
 *
 * entry by entry along A's axes (N m/rad, N m s/rad), none negative, NULL: all zero. J(theta) is
 * the matrix of omega = J theta', so that tau follows from the energy 1/2 sum of stiffness theta^2;
 * as mbsr_force_bushing. The length of q does not matter. At |theta| = pi it has no direction, as
 * there; a zero q gives MBSR_ZERO_QUATERNION. */
MBSR_API mbsr_force_def mbsr_force_joint_rotation_spring(int body, const double stiffness[3],
                                                         const double damping[3],
                                                         const double rest[4]);

/* Stops of joint coordinate `coordinate` (as mbsr_force_joint_spring): no force for lower <= q <=
 * upper; beyond a stop by x > 0 the joint force pushes back by F + min(max(damping x', -F), F), F =
 * stiffness x. lower < upper; -INFINITY and INFINITY: no such stop. */
MBSR_API mbsr_force_def mbsr_force_joint_stop(int body, int coordinate, double lower, double upper,
                                              double stiffness, double damping);

/* Coulomb friction of joint velocity `coordinate` (0 .. n-1, any nq), made smooth near rest: tau =
 * -force u / sqrt(u^2 + slip^2). force in N or N m, >= 0; slip > 0 in m/s or rad/s. */
MBSR_API mbsr_force_def mbsr_force_joint_friction(int body, int coordinate, double force,
                                                  double slip);

/* A drive of joint coordinate `coordinate` (as mbsr_force_joint_spring) towards a reference r(t):
 *
 *   tau = kp (r - q) + kd (r' - u)
 *
 * N/m and N s/m, or N m/rad and N m s/rad, none negative; where `limit` is above zero |tau| is at
 * most that. It has neither energy nor dissipation: the motor exchanges power. */
typedef struct mbsr_servo {
    double kp, kd, limit;
    double reference;  /* a constant r, unless one of these is given: */
    mbsr_table *table; /* r(t), one column, whose kinks the driver knows; must outlive the model */
    mbsr_force_fn function; /* writes two numbers, r and r' (n = 2) */
    void *user;             /* for function */
} mbsr_servo;

/* A drive of one joint coordinate towards the reference above. */
MBSR_API mbsr_force_def mbsr_force_joint_servo(int body, int coordinate, const mbsr_servo *servo);

/* The characteristic of a motor, brake or damper: tau of joint velocity `coordinate` (0 .. n-1, any
 * nq) is torque(u), a table of one column over u, which must outlive the model. Two points (0,
 * stall torque) and (no-load speed, 0) with MBSR_TABLE_STRAIGHT make the torque-speed line of a
 * d.c. motor. */
MBSR_API mbsr_force_def mbsr_force_joint_curve(int body, int coordinate, mbsr_table *torque);

/* A compliant gear between two joint coordinates, of one body or of two anywhere in the tree (nq =
 * n): with e = q_a - ratio q_b - rest and its torque T on a,
 *
 *   tau_a = -T, tau_b = ratio T,   T = stiffness e + damping e'
 *
 * and with a backlash > 0 (the whole play, in the unit of q_a) T = sign(e) (F + min(max(damping x',
 * -F), F)), F = stiffness x, for the depth x = |e| - backlash / 2 > 0, and none in between.
 * Stiffness, damping and backlash are not negative, ratio is not zero. */
typedef struct mbsr_gear {
    double ratio, stiffness, damping, backlash, rest;
} mbsr_gear;

/* A compliant gear between two joint coordinates by the law above. */
MBSR_API mbsr_force_def mbsr_force_gear(int a, int coordinate_a, int b, int coordinate_b,
                                        const mbsr_gear *gear);

/* Force on a body as function of time: `function` writes d components conjugate to V, for a SPATIAL
 * body the moment about its origin and the force along the world axes. */
MBSR_API mbsr_force_def mbsr_force_applied(int body, mbsr_force_fn function, void *user);

/* Wrench (spatial force) on a SPATIAL body as function of time: `function` writes six components,
 * the moment about a point of the body (N m), then the force there (N), along the world axes
 * (body_axes == 0) or along the body's. */
MBSR_API mbsr_force_def mbsr_force_wrench(int body, const double point[3], int body_axes,
                                          mbsr_force_fn function, void *user);

/* Joint force or torque as function of time, such as a motor: `function` writes n components
 * conjugate to u. */
MBSR_API mbsr_force_def mbsr_force_joint_applied(int body, mbsr_force_fn function, void *user);

/* Numbers that the caller keeps, as mbsr_force_fn: the n numbers at `stored`, the `user` of
 * the element and not NULL. They may change where the driver is told: before mbsr_ida_sample, which
 * holds them for a period, and before mbsr_ida_jump. */
MBSR_API int mbsr_stored_force(void *stored, double t, int n, double *value);

/* Contact of a sphere on body a with a plane on body b; either may be in the plane (z = 0), where
 * the sphere is a circle. The sphere is pressed in by x = radius - distance of its centre from the
 * plane; while x > 0 the normal force is (Hunt and Crossley, 1975)
 *
 *   N = stiffness x^exponent (1 + damping x'), never negative,
 *
 * and friction friction N v / sqrt(|v|^2 + slip^2 + creep^2 |w|^2) acts against the sliding
 * velocity v; both at the point of the sphere that is deepest. w is the velocity along the plane at
 * which the centre travels over it. So creep > 0 makes a tyre: at speed its force grows with the
 * ratio of v to w, the slip, at first by friction N / creep; 0.05 .. 0.1 for tyres of cars. */
typedef struct mbsr_contact {
    double centre[3], radius;   /* of the sphere, in body a; radius > 0 m */
    double point[3], normal[3]; /* of the plane, in body b; the normal, of any length but zero,
                                   points away from what is solid */
    double stiffness, exponent; /* N/m^exponent, >= 0; exponent >= 1, 1.5 for a sphere */
    double damping;             /* s/m, >= 0 */
    double friction, slip;      /* coefficient >= 0; m/s, > 0 where friction is not zero */
    double creep;               /* >= 0 */
} mbsr_contact;

/* Contact of a sphere on body a with a plane on body b by the law above. */
MBSR_API mbsr_force_def mbsr_force_contact(int a, int b, const mbsr_contact *contact);

/* Friction at a point of body a that slides over body b, pressed on it by a load N(t) that is
 * known. With the velocity of the point relative to what of b is there, and its part v that slides,
 *
 *   -(coefficient N / sqrt(|v|^2 + slip^2 + creep^2 |w|^2) + viscous) v
 *
 * acts on a at the point, and the reaction on b there. v is the whole relative velocity; or, given
 * the normal of a surface on b, what of it is along the surface; or, given the axle of a wheel on a
 * which rolls freely, what of it is along the axle. w is the rest in the last case, the velocity of
 * rolling: with creep > 0 the side force of a tyre grows with the tangent |v| / |w| of its slip
 * angle, at first by coefficient N / creep; else w is zero. Neither body is held at rest: they
 * creep. A load below zero counts as zero. */
typedef struct mbsr_friction {
    double coefficient; /* >= 0 */
    double viscous;     /* N s/m, >= 0 */
    double slip;        /* m/s, > 0 */
    double creep;       /* >= 0, and zero without an axle */
    double normal[3];   /* in body b, of any length; (0, 0, 0): none */
    double axle[3];     /* in body a, likewise; not both */
    double load;        /* N, >= 0: a constant, unless one of these is given: */
    mbsr_table *table;  /* N(t), one column, whose kinks the driver knows; must outlive the model */
    mbsr_force_fn function; /* writes one number, N(t) */
    void *user;             /* for function */
} mbsr_friction;

/* Friction of a point of body a on body b by the law above. */
MBSR_API mbsr_force_def mbsr_force_point_friction(int a, const double point[3], int b,
                                                  const mbsr_friction *friction);

/* Friction of a bearing, a clutch or a brake between two bodies anywhere in the tree (PLANAR,
 * SPATIAL or the ground): with the angular velocity omega of a relative to b, or what of it is
 * about an axis on b, the moment on a is -(torque / sqrt(|omega|^2 + slip^2) + viscous) omega. A
 * torque below zero counts as zero. */
typedef struct mbsr_bearing {
    double viscous; /* N m s/rad, >= 0 */
    double slip;    /* rad/s, > 0 */
    double axis[3]; /* in body b, of any length; (0, 0, 0): all of omega */
    double torque;  /* N m, >= 0: a constant, unless one of these is given: */
    mbsr_table
        *table; /* torque(t), one column, whose kinks the driver knows; must outlive the model */
    mbsr_force_fn function; /* writes one number, torque(t) */
    void *user;             /* for function */
} mbsr_bearing;

/* Friction about an axis between two bodies by the law above. */
MBSR_API mbsr_force_def mbsr_force_bearing_friction(int a, int b, const mbsr_bearing *bearing);

/* An element with the caller's own table. `bodies` lists `count` ids; it must stay valid until the
 * element is added. */
MBSR_API mbsr_force_def mbsr_force_custom(const mbsr_force_table *table, int count,
                                          const int *bodies, void *user);

#ifdef __cplusplus
}
#endif

#endif
