/* The model: bodies, joints and force elements; built, finished, then read-only.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRANK_MODEL_H
#define MBSRANK_MODEL_H

#include <mbsrank/base.h>
#include <mbsrank/force.h>
#include <mbsrank/inertia.h>
#include <mbsrank/joint.h>
#include <mbsrank/table.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct mbsr_model mbsr_model;

/* Motion of the root: pose (np), velocity (d) and acceleration (d) at time t; all arrive as zero,
 * R of a SPATIAL root as the unit matrix. */
typedef int (*mbsr_root_fn)(void *user, double t, double *p, double *V, double *A);

/* The root of the tree (body 0 of the paper): at rest with d = 0, or moved by a function of
 * time. */
typedef struct mbsr_root {
    mbsr_space space;
    int d, np;
    mbsr_root_fn motion; /* NULL: at rest at p = 0, R = 1 */
    void *user;          /* for motion; not copied, may be NULL */
} mbsr_root;

MBSR_API mbsr_root mbsr_root_fixed(void); /* FIXED, d = 0: the default */
/* A root that moves as a function of time says. */
MBSR_API mbsr_root mbsr_root_moving(mbsr_space space, int d, int np, mbsr_root_fn motion,
                                    void *user);

typedef struct mbsr_model_def {
    int cookie;               /* set by mbsr_default_model_def */
    mbsr_root root;           /* default: fixed */
    double rank_tolerance;    /* see mbsr_rank_info; default 1e-12 */
    mbsr_allocator allocator; /* default: malloc and free (both functions NULL) */
} mbsr_model_def;

MBSR_API mbsr_model_def mbsr_default_model_def(void);

/* A body and the joint that carries it: a link with its inboard joint, or a mobilized body. One
 * without inertia is a dummy link. */
typedef struct mbsr_body_def {
    int cookie;           /* set by mbsr_default_body_def */
    const char *name;     /* copied; NULL: none */
    int parent;           /* id of the predecessor, which may be added later; default MBSR_GROUND */
    mbsr_joint joint;     /* between predecessor and this body; must be set */
    mbsr_inertia inertia; /* default: not given, which counts as zero, and zero is honoured */
} mbsr_body_def;

MBSR_API mbsr_body_def mbsr_default_body_def(void);

/* Makes an empty model. def == NULL means mbsr_default_model_def(). On failure *model is NULL and
 * the reason is in *error (which may be NULL). Status: MBSR_OK, MBSR_ERR_NULL, MBSR_ERR_NO_DEFAULT,
 * MBSR_ERR_VALUE, MBSR_ERR_NO_MEMORY. */
MBSR_API int mbsr_model_create(const mbsr_model_def *def, mbsr_model **model, mbsr_error *error);

/* Frees a model and all it owns; NULL is allowed. No mbsr_data of it may be used afterwards. */
MBSR_API void mbsr_model_destroy(mbsr_model *model);

/* Adds a body and writes its id (0, 1, 2, ... in the order of adding) to *id, which may be NULL.
 * Everything the definition points to is copied, except tables and user pointers. A refused body
 * leaves the model as it was. Status: MBSR_OK, MBSR_ERR_NULL, MBSR_ERR_NO_DEFAULT, MBSR_ERR_VALUE,
 * MBSR_ERR_SPACE, MBSR_ERR_ID, MBSR_ERR_FINISHED, MBSR_ERR_NO_MEMORY; the text is in
 * mbsr_model_error. */
MBSR_API int mbsr_model_add_body(mbsr_model *model, const mbsr_body_def *def, int *id);

/* Adds a force element and writes its id (0, 1, 2, ...) to *id, which may be NULL. Its bodies may
 * be added later. Status as mbsr_model_add_body. */
MBSR_API int mbsr_model_add_force(mbsr_model *model, const mbsr_force_def *def, int *id);

/* ---- amendments, each stated by the caller, none made silently. Before mbsr_model_finish, of a
 * body that has been added. Status: MBSR_OK, MBSR_ERR_NULL, MBSR_ERR_FINISHED, MBSR_ERR_ID,
 * MBSR_ERR_VALUE, MBSR_ERR_SPACE, MBSR_ERR_NO_MEMORY; the text is in mbsr_model_error. */

/* Adds a constant symmetric positive semi-definite matrix (d x d, copied, in the units of the
 * body's mass matrix) to the mass matrix of a body in every pose, whatever its inertia; for a
 * SPATIAL body along its axes (see mbsr_inertia_matrix). It is mass of the body, on which gravity
 * pulls, and not an armature (mbsr_model_armature). At
 * most one for each body; MBSR_ERR_VALUE for a second. */
MBSR_API int mbsr_model_regularise(mbsr_model *model, int body, int d, const double *matrix);

/* Holds joint coordinate `coordinate` (0 .. n-1, as the joint counts) of a body at `value`. It is
 * no unknown any more: n and nq of the body shrink by one, in q, u, tau, results and reports the
 * coordinates left move up. Only for joints with q' = u (MBSR_ERR_SPACE).
 *
 * The library's elements on joint coordinates (springs, stops, friction, servos, curves, gears) and
 * couplings name coordinates as the joint counts them, locked or not, before the call or after it.
 * Those on locked coordinates hold: they exert nothing that moves anything, and their potential
 * energy is that at the value. Of gears and couplings with other coordinates too, the value is a
 * constant. A coupling whose coordinates are all locked has no rows, and is refused by
 * mbsr_model_finish where their values contradict it or it moves with time (MBSR_ERR_VALUE).
 * Elements and closures of your own, and mbsr_force_joint_applied, see the coordinates that are
 * left; a joint of your own sees all of its q and u, zero in the rates held.
 *
 * Joints of the library whose coordinates are all locked, and welds, cost nothing in forward and
 * inverse dynamics, residuals and Newton systems where a body of the same kind carries them and
 * neither closures nor elements on bodies act on the body; all results of it are there, its
 * reaction too. */
MBSR_API int mbsr_model_lock(mbsr_model *model, int body, int coordinate, double value);

/* Drops what the library's elements and couplings do on locked coordinates of a body, in place of
 * holding it: elements, gears and couplings among whose coordinates such a one is do nothing at
 * all, and have no energy. */
MBSR_API int mbsr_model_drop_locked(mbsr_model *model, int body);

/* Gives the joint of a body armature: inertia along its rates, such as that of rotors behind gears,
 * moment times ratio squared (kg m^2; kg along translations). values: one number for each of the n
 * rates of the joint (copied), finite and not negative; a second call replaces them, those of
 * locked coordinates do not count. Armature a_k adds a_k to the diagonal of the joint-space mass
 * matrix, a_k u_k' to the joint forces, a_k u_k to the momenta and a_k u_k^2 / 2 to the kinetic
 * energy, and counts in all ranks. No weight acts on it, and no gyroscopic force of the rotor on
 * the bodies. The three rates of a quaternion must have the same; other joints with q' = G(q) u
 * have none (MBSR_ERR_SPACE). */
MBSR_API int mbsr_model_armature(mbsr_model *model, int body, int n, const double *values);

/* Puts a motion in the place of that which the joint of a body follows, such as in a copy of a
 * model: as many entries, a `user` of its own (which functions of a joint's own table are given
 * too). MBSR_ERR_VALUE for a joint that follows none, MBSR_ERR_NULL for a motion that is NULL. */
MBSR_API int mbsr_model_drive(mbsr_model *model, int body, mbsr_motion_fn motion, void *user);

/* Likewise of a closure. */
MBSR_API int mbsr_model_drive_closure(mbsr_model *model, int closure, mbsr_motion_fn motion,
                                      void *user);

/* What of an inertia is neglected. */
enum {
    MBSR_MASS = 1,   /* the mass, and what it adds to the tensor about the body's origin */
    MBSR_MOMENT = 2, /* the moment or tensor of inertia about the centre of mass */
    MBSR_MASS_AND_MOMENT = 3
};

/* Counts the mass of a body, its moment of inertia about the centre of mass, or both (`parts`) as
 * zero. The model keeps what was given: mbsr_body_neglected names it, mbsr_model_restore brings it
 * back, and mbsr_small_masses_create measures what it would have done (small_masses.h). A second
 * call says anew which parts. Inertias by matrix and by function have no parts:
 * MBSR_MASS_AND_MOMENT; what mbsr_model_regularise has added stays. MBSR_ERR_VALUE for a body
 * without inertia, or without that part. */
MBSR_API int mbsr_model_neglect(mbsr_model *model, int body, int parts);

/* The inertia as it was given. A body of which nothing is neglected stays as it is. */
MBSR_API int mbsr_model_restore(mbsr_model *model, int body);

/* A copy of a model, finished or not: its definition, with all amendments, not finished, so that it
 * can be amended and added to. Bodies, force elements and closures have the same ids; tables and
 * user pointers are shared. On failure *copy is NULL and the reason in *error (which may be NULL).
 * MBSR_ERR_NULL, MBSR_ERR_NO_MEMORY. */
MBSR_API int mbsr_model_copy(const mbsr_model *model, mbsr_model **copy, mbsr_error *error);

/* Checks the tree, numbers it parent before child and freezes it. Ids stay valid. On failure the
 * model stays as it was and can be added to. Time and memory grow linearly with the number of
 * bodies. Where joints of several rates or groups of joints may lack rank, functions of joints,
 * motions and inertias are called at t = 0 for a position or two. Status: MBSR_OK, MBSR_ERR_NULL,
 * MBSR_ERR_FINISHED, MBSR_ERR_ID (unknown predecessor, unknown body of a force), MBSR_ERR_CYCLE,
 * MBSR_ERR_SPACE, MBSR_ERR_VALUE, MBSR_ERR_NO_MEMORY, or what a table's check returned. */
MBSR_API int mbsr_model_finish(mbsr_model *model);

/* The last failure of a function above on this model; never NULL. */
MBSR_API const mbsr_error *mbsr_model_error(const mbsr_model *model);

/* ---- reading a finished model. A model that is NULL or not finished, or an id that does not
 * exist, gives -1. */

MBSR_API int mbsr_model_bodies(const mbsr_model *model); /* number of bodies */
MBSR_API int mbsr_model_forces(const mbsr_model *model); /* number of force elements */
MBSR_API int mbsr_model_nq(const mbsr_model *model);     /* joint position coordinates in all */
MBSR_API int mbsr_model_nu(const mbsr_model *model);     /* joint velocity coordinates in all: the
                                                        degrees of freedom (mobilities) */

/* The length typical of the model, m: the geometric mean of its bodies' radii of gyration about
 * their origins, else of arms, ways between origins, of points that forces act at, or of rests and
 * limits of springs along joints; steps of differences and tolerances are measured by it. 0: there
 * is none. -1 as above. */
MBSR_API double mbsr_model_length(const mbsr_model *model);

/* The rate typical of the model, 1/s: of a pendulum of that length under its gravity, else of its
 * mass at the springs or dampers of its elements, else of springs at dampers. 0: none is known. -1
 * as above. */
MBSR_API double mbsr_model_rate(const mbsr_model *model);

/* Where a body's coordinates stand in q and u: q[q_index .. q_index+nq), u[u_index .. u_index+n).
 * Bodies follow each other in the order of their ids. Outputs may be NULL. Status: MBSR_OK,
 * MBSR_ERR_NULL, MBSR_ERR_UNFINISHED, MBSR_ERR_ID. */
MBSR_API int mbsr_body_coordinates(const mbsr_model *model, int body, int *q_index, int *nq,
                                   int *u_index, int *n);

/* What a joint coordinate measures. The four numbers of a quaternion and the angle of a screw count
 * as rotations; of a caller's own joint nothing is known. */
typedef enum mbsr_coordinate_kind {
    MBSR_COORDINATE_OTHER = 0,
    MBSR_COORDINATE_ROTATION = 1,   /* rad, rad/s */
    MBSR_COORDINATE_TRANSLATION = 2 /* m, m/s */
} mbsr_coordinate_kind;

/* Kinds of a body's joint coordinates: position nq, velocity n of mbsr_body_coordinates. Outputs
 * may be NULL. Status: MBSR_OK, MBSR_ERR_NULL, MBSR_ERR_UNFINISHED, MBSR_ERR_ID. */
MBSR_API int mbsr_body_coordinate_kinds(const mbsr_model *model, int body,
                                        mbsr_coordinate_kind *position,
                                        mbsr_coordinate_kind *velocity);

MBSR_API int mbsr_body_parent(const mbsr_model *model,
                              int body); /* an id, MBSR_GROUND, or MBSR_NONE */
MBSR_API int mbsr_body_dimension(const mbsr_model *model, int body); /* d */
MBSR_API int mbsr_body_pose_size(const mbsr_model *model, int body); /* np */

/* The first body of the group whose joints are eliminated as one block, an id: mostly the body
 * itself. Groups are joints next to each other that move nothing of their own bodies' masses, as
 * those of dummy bodies in a row; up to twelve bodies and joint rates. What is more is cut,
 * with no effect on results but that a rank which passes from one group to another counts as
 * changed (docs/rank_and_index.md). MBSR_NONE where there is no such body. */
MBSR_API int mbsr_body_group(const mbsr_model *model, int body);

/* The next kink beyond t, strictly, in a direction (+1 or -1) that tables bring into the model,
 * those of its motions (mbsr_table_motion) and forces (mbsr_table_force): the nearest, {direction *
 * INFINITY, 1} without one. MBSR_ERR_NULL, MBSR_ERR_UNFINISHED, MBSR_ERR_VALUE (direction),
 * MBSR_NOT_FINITE (t is NaN). */
MBSR_API int mbsr_model_kink(const mbsr_model *model, double t, int direction, mbsr_kink *next);

/* How many of the joint's coordinates are locked, and the matrix (d x d) that was added to the
 * body's mass matrix: NULL when there is none. */
MBSR_API int mbsr_body_locks(const mbsr_model *model, int body);
MBSR_API const double *mbsr_body_regularisation(const mbsr_model *model, int body);

/* The armature of a body's joint, n numbers of mbsr_body_coordinates, zero where none was given;
 * NULL if there is no such body. */
MBSR_API const double *mbsr_body_armature(const mbsr_model *model, int body);

/* Which parts of a body's inertia are neglected (mbsr_model_neglect): 0 for none. */
MBSR_API int mbsr_body_neglected(const mbsr_model *model, int body);

/* The name given, or "" where there is none; NULL if there is no such body. */
MBSR_API const char *mbsr_body_name(const mbsr_model *model, int body);

/* The first body of that name, or MBSR_NONE; no body has the name "". */
MBSR_API int mbsr_model_find_body(const mbsr_model *model, const char *name);

/* What a finished model, a body and a force element of it were defined as, a value that can be
 * added to another model; names, matrices and lists of bodies are the model's and live as long. A
 * body's inertia is what counts in the model: without what is neglected. Amendments are asked for
 * apart (mbsr_body_locks, mbsr_body_regularisation, mbsr_body_armature). Elements are found in time
 * proportional to their number. Status: MBSR_OK, MBSR_ERR_NULL, MBSR_ERR_UNFINISHED, MBSR_ERR_ID.
 */
MBSR_API int mbsr_model_definition(const mbsr_model *model, mbsr_model_def *def);
MBSR_API int mbsr_body_definition(const mbsr_model *model, int body, mbsr_body_def *def);
MBSR_API int mbsr_force_definition(const mbsr_model *model, int force, mbsr_force_def *def);

#ifdef __cplusplus
}
#endif

#endif
