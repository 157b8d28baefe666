/* Closures: constraints that close loops over the tree.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A closure holds rows of
 *
 *   g(q, t) = 0                 position rows (holonomic)
 *   C u + g_t = 0               velocity rows: the derivatives of those, and nonholonomic ones
 *
 * exactly: there is no stiffness and no gain to tune. A row k exerts the loop force lambda_k along
 * itself on the first body and against it on the others, so that the joints of the tree feel C^T
 * lambda. Any joint closes a loop: put it into the tree with a body that has no mass, the cut body,
 * and weld that to the other side (mbsr_model_add_loop_joint). See docs/closed_loops.md. */
#ifndef MBSRANK_CLOSURE_H
#define MBSRANK_CLOSURE_H

#include <mbsrank/data.h>
#include <mbsrank/force.h>
#include <mbsrank/model.h>
#include <mbsrank/spatial.h>

#ifdef __cplusplus
extern "C" {
#endif

#define MBSR_CLOSURE_BODIES 8
#define MBSR_CLOSURE_ROWS 12
#define MBSR_CLOSURE_PARAMS 40
#define MBSR_CLOSURE_OPTIONS 8

typedef struct mbsr_closure_def mbsr_closure_def;

/* What the functions of a closure read. Bodies stand in the order of the definition; of each p, V,
 * q and u (V and u are NULL for position and jacobian; f, tau, M and inertia always). The ground
 * has the pose and the velocity of the root, which are not to be read when its space is FIXED. */
typedef struct mbsr_closure_args {
    const mbsr_closure_def *closure;
    double t; /* s */
    int bodies;
    const mbsr_force_body *body;
} mbsr_closure_args;

/* Derivatives of velocity rows (rows x columns, column-major): body k has in the columns from
 * column[k] on its V (d), then, with MBSR_CLOSURE_JOINTS, its u (n). A root at rest has none
 * (column[k] = -1). */
typedef struct mbsr_closure_jacobian {
    double *matrix;
    int rows, columns;
    const int *column;
} mbsr_closure_jacobian;

/* Derivatives, for Newton systems, with respect to displacements of the bodies, one column for each
 * column of C: its body turned about its origin by a small angle and moved, along V; its joint's
 * coordinates moved, along u. force (columns x columns, column-major): of the loop forces C^T
 * lambda on the bodies; rate (rows x columns): of C (V, u) + g_t. t, lambda, V and u are held. */
typedef struct mbsr_closure_tangent {
    double *force, *rate;
    int rows, columns;
    const int *column;
} mbsr_closure_tangent;

#define MBSR_CLOSURE_TABLE_VERSION 1u

/* The closure reads q and u of its bodies. */
#define MBSR_CLOSURE_JOINTS 1u

/* A root that moves stands behind the bodies given, as one more. */
#define MBSR_CLOSURE_ROOT 2u

/* Its bodies must have joints with q' = u. */
#define MBSR_CLOSURE_PLAIN 4u

/* The rows depend on where the bodies stand to each other, not on where they all stand. */
#define MBSR_CLOSURE_RELATIVE 8u

/* Promises that spare work in Newton systems. BALANCED: what a row exerts on the bodies adds up to
 * nothing, forces and moments, where the loop is closed (with MBSR_CLOSURE_ROOT: unless it follows
 * a motion or has stiff rows). OWN: the columns of C of a body, and what they make of its
 * velocities, depend on the place of that body alone (unless it has stiff rows). */
#define MBSR_CLOSURE_BALANCED 16u
#define MBSR_CLOSURE_OWN 32u

/* With MBSR_CLOSURE_JOINTS: of its bodies it reads q and u alone (poses and velocities need not be
 * there), and the columns of V are zero. Newton systems take such closures in vector code; their
 * forces balance, and OWN speaks of coordinates, of stiff rows too. */
#define MBSR_CLOSURE_COORDINATES 64u

/* Functions return 0, or a status that ends the evaluation and reaches the caller unchanged (> 0
 * recoverable, < 0 fatal). They may be called by several threads at once. Outputs arrive as zero.
 */
typedef struct mbsr_closure_table {
    unsigned version; /* MBSR_CLOSURE_TABLE_VERSION */
    unsigned flags;   /* MBSR_CLOSURE_JOINTS and the others above, or 0 */
    const char *name; /* for messages; must outlive the model */

    /* g of the position rows; may be NULL where there are none. */
    int (*position)(const mbsr_closure_args *args, double *g);

    /* C: derivatives of all velocity rows with respect to V and u of the bodies. Optional where all
     * rows are position rows: then g is differenced, which needs bodies whose coordinates the
     * library knows (none in GENERAL space) and joints with q' = u. */
    int (*jacobian)(const mbsr_closure_args *args, const mbsr_closure_jacobian *out);

    /* Optional: what of the velocity rows does not depend on velocities, g_t. Without it, g is
     * differenced over time; it is zero for nonholonomic rows. */
    int (*drift)(const mbsr_closure_args *args, double *gt);

    /* Optional: the time derivative of the velocity rows where the accelerations A and u' of the
     * bodies are zero. Without it the rows are differenced along the motion. */
    int (*bias)(const mbsr_closure_args *args, double *bias);

    /* Optional: adds these derivatives to what arrives as zero; along the root they are not read.
     * Without it what jacobian and drift give is differenced. */
    int (*tangent)(const mbsr_closure_args *args, const double *lambda,
                   const mbsr_closure_tangent *out);

    /* Optional: how many rows there are, of which the first *position_rows are such. Called when
     * the model is finished; of the bodies id, space, d, np, n and nq are set. Without it those of
     * the definition count. */
    int (*count)(const mbsr_closure_args *args, int *rows, int *position_rows);

    /* Optional: called when the model is finished, as count. On refusal returns a status and may
     * write a text. */
    int (*check)(const mbsr_closure_args *args, char text[MBSR_TEXT_SIZE]);

    /* Optional: called when the closure is added, for what does not depend on its bodies. */
    int (*check_fields)(const mbsr_closure_def *closure, char text[MBSR_TEXT_SIZE]);

    /* Optional: name of row k for messages, such as "x" or "turn about z". */
    const char *(*row)(const mbsr_closure_args *args, int k);

    /* Optional: the point of the world (m) at which the rows act: of a ball joint or weld that of
     * body a, where a rolling body touches. For reports and pictures; bodies have no velocities. */
    int (*point)(const mbsr_closure_args *args, double x[3]);

    /* Optional: steps of differences where jacobian, drift or bias are missing. */
    mbsr_scales scales;
} mbsr_closure_table;

/* A closure; made by a constructor below or by mbsr_default_closure_def, copied into the model. */
struct mbsr_closure_def {
    int cookie;                      /* set by the constructors */
    const char *name;                /* copied; NULL: none */
    const mbsr_closure_table *table; /* must outlive the model */
    int rows, position_rows;         /* velocity rows, position rows (the first of them); for
                                        tables without `count` */
    int bodies;                      /* how many it reads, 1 .. MBSR_CLOSURE_BODIES */
    int body[MBSR_CLOSURE_BODIES];   /* their ids, MBSR_GROUND allowed */
    double param[MBSR_CLOSURE_PARAMS];
    int option[MBSR_CLOSURE_OPTIONS];
    /* Stiff rows: with stiffness[k] > 0 position row k is no constraint but a spring of that
     * stiffness (N/m, N m/rad) and damping (N s/m, N m s/rad) along it, which costs an integrator
     * what the rigid row costs, however stiff it is. Default 0: rigid. */
    double stiffness[MBSR_CLOSURE_ROWS], damping[MBSR_CLOSURE_ROWS];
    /* The same by matrices (compliant x compliant, column-major, copied), instead of the numbers
     * above; compliant is the number of position rows, 0: none. At rest the gaps give way to the
     * loop forces by g = -compliance lambda (m/N, rad/(N m) and between them), symmetric positive
     * semi-definite; combinations of rows without compliance are rigid. compliance_damping: D of a
     * damping force -D g' (N s/m, N m s/rad), likewise, or NULL; what it does along rigid
     * combinations has no effect. The position rows of the closure are then T times those of its
     * table, in which springs and dampers act apart (mbsr_closure_mixture). */
    int compliant;
    const double *compliance, *compliance_damping;
    /* 1 (default): a start closes stiff rows like rigid ones and loads their springs with the force
     * that keeps them so; 0: it takes their springs as they are at the positions given. */
    int settled;
    mbsr_motion_fn motion; /* what the rows follow, where the constructor says so; else NULL */
    void *user;            /* for the table's functions and motion; not copied, may be NULL */
};

MBSR_API mbsr_closure_def mbsr_default_closure_def(void);

/* ---- stock closures ----
 *
 * Frames and points stand in body axes, those on the ground in the axes of the root; NULL is the
 * body's own frame or origin. Rows are taken along the axes of the root, so that bodies in the
 * plane and points have those in the plane; two bodies of which one is in space have those of
 * space. Those of a weld or ball that has stiffness, between two bodies and without motion, are
 * taken along the axes of body b, which turn with it. Loop forces act on body a, the opposite ones
 * on body b. Both on one body, or both on the ground, is refused, and so are bodies in GENERAL
 * space. */

/* In a definition a weld and a ball have in param their frames or points, frame a from 0 and frame
 * b from 12 on (origin, then axes); a coupling coefficient k in param[k], coordinate k in
 * option[k], and its offset in param[MBSR_CLOSURE_BODIES]. */

/* The two frames stay together: 3 rows for the turn (a's against b's, rad) and 3 for the origins
 * (m) in space; x, y, turn in the plane; x, y where a POINT takes part, which has no turn. */
MBSR_API mbsr_closure_def mbsr_closure_weld(int a, const mbsr_frame *frame_a, int b,
                                            const mbsr_frame *frame_b);

/* The two points stay together: a ball joint, in the plane a pin; 3 or 2 rows. With `motion` set,
 * point a is ahead of point b by the vector s(t) that it writes. */
MBSR_API mbsr_closure_def mbsr_closure_ball(int a, const double point_a[3], int b,
                                            const double point_b[3]);

/* The vector from point b to point a has no component along `count` (1 .. 3) directions, which are
 * fixed in the root and independent, of any length but zero: a point in a plane or on a line.
 * direction: 3 numbers each. With `motion` set, the components along the unit vectors are s(t). */
MBSR_API mbsr_closure_def mbsr_closure_rows(int a, const double point_a[3], int b,
                                            const double point_b[3], int count,
                                            const double *direction);

/* The same with directions that are fixed in body b and turn with it: a point in a slot or on a
 * face of a body. The row's force acts on both bodies along its direction at point a. */
MBSR_API mbsr_closure_def mbsr_closure_body_rows(int a, const double point_a[3], int b,
                                                 const double point_b[3], int count,
                                                 const double *direction);

/* The two points stay at the distance `length` > 0 m: g = (|d|^2 - length^2) / (2 length). With
 * `motion` set, at the distance s(t). The row's force is along d, positive apart. */
MBSR_API mbsr_closure_def mbsr_closure_distance(int a, const double point_a[3], int b,
                                                const double point_b[3], double length);

/* Sum of coefficient[k] q[coordinate[k]] of body[k] = offset, for `count` (1 .. 8) joint
 * coordinates: gears, mimicking joints, rack and pinion. With `motion` set, offset + s(t). For
 * joints with q' = u; coordinates count as the joint has them, locked or not (mbsr_model_lock). */
MBSR_API mbsr_closure_def mbsr_closure_coupling(int count, const int *body, const int *coordinate,
                                                const double *coefficient, double offset);

/* A ball of that radius, centre at a point of body a, rolls on a plane of body b: the z plane of
 * frame_b, with the ball on the side of its z axis. One position row (the ball touches the plane)
 * and two nonholonomic ones (it does not slip along x and y of the frame); for bodies in the plane,
 * where the ball is a wheel and z of frame_b must lie in it, one and one. Forces in the axes of
 * frame_b: along z, then along the slip rows. */
MBSR_API mbsr_closure_def mbsr_closure_rolling_ball(int a, const double centre[3], double radius,
                                                    int b, const mbsr_frame *frame_b);

/* A sharp-edged disc of that radius in the plane z = 0 of frame_a, about its origin, rolls
 * likewise: bodies in space only. The disc must not lie flat (MBSR_DEGENERATE_FORCE). */
MBSR_API mbsr_closure_def mbsr_closure_rolling_disc(int a, const mbsr_frame *frame_a, double radius,
                                                    int b, const mbsr_frame *frame_b);

/* A closure of the caller's own: bodies copied, rows and position_rows as in mbsr_closure_def. */
MBSR_API mbsr_closure_def mbsr_closure_custom(const mbsr_closure_table *table, int bodies,
                                              const int *body, int rows, int position_rows,
                                              void *user);

/* ---- building ---- */

/* Adds a closure and writes its id (0, 1, 2, ...) to *id, which may be NULL. Its bodies may be
 * added later. Everything but the table and user pointers is copied. A refused closure leaves the
 * model as it was. Status: MBSR_OK, MBSR_ERR_NULL, MBSR_ERR_NO_DEFAULT, MBSR_ERR_VALUE,
 * MBSR_ERR_ID, MBSR_ERR_FINISHED, MBSR_ERR_NO_MEMORY, or what the table returned; the text is in
 * mbsr_model_error. */
MBSR_API int mbsr_model_add_closure(mbsr_model *model, const mbsr_closure_def *def, int *id);

/* A loop-closing joint of any kind between `body` and `other`: a body without mass is added on
 * `body` by the joint (the cut body, whose coordinates are those of the joint: motors, springs and
 * motions act on it), and welded to frame_other of `other`. The joint's frames are those between
 * body and cut body. Both bear the name. closure and cut_body (outputs) may be NULL. Status: those
 * of mbsr_model_add_body and mbsr_model_add_closure; on failure nothing was added. */
MBSR_API int mbsr_model_add_loop_joint(mbsr_model *model, const char *name, int body,
                                       const mbsr_joint *joint, int other,
                                       const mbsr_frame *frame_other, int *closure, int *cut_body);

/* ---- reading a finished model. A model that is NULL or not finished, or an id that does not
 * exist, gives -1, a name NULL. */

MBSR_API int mbsr_model_closures(const mbsr_model *model);
MBSR_API int mbsr_model_rows(const mbsr_model *model);          /* velocity rows of all closures */
MBSR_API int mbsr_model_position_rows(const mbsr_model *model); /* position rows of all closures */

/* Where the rows of a closure stand among all: velocity rows [row .. row+rows), position rows
 * [position_row .. position_row+position_rows). Outputs may be NULL. MBSR_ERR_NULL,
 * MBSR_ERR_UNFINISHED, MBSR_ERR_ID. */
MBSR_API int mbsr_closure_indices(const mbsr_model *model, int closure, int *row, int *rows,
                                  int *position_row, int *position_rows);
/* How the h position rows of a closure follow from those of its table: T (h x h,
 * column-major), the identity but for those with a compliance matrix, which have rows of length 1.
 * Loop forces along the table's rows are T^T lambda. MBSR_ERR_NULL, MBSR_ERR_UNFINISHED,
 * MBSR_ERR_ID. */
MBSR_API int mbsr_closure_mixture(const mbsr_model *model, int closure, double *T);
/* The closure that a force element has become (as_closure), or MBSR_NONE. */
MBSR_API int mbsr_force_closure(const mbsr_model *model, int force);
MBSR_API const char *mbsr_closure_name(const mbsr_model *model, int closure);
MBSR_API int mbsr_model_find_closure(const mbsr_model *model, const char *name);
/* What a closure was defined as, a value that can be added to another model; its name is the
 * model's. Compliance matrices are not kept, and such a closure is refused elsewhere.
 * MBSR_ERR_NULL, MBSR_ERR_UNFINISHED, MBSR_ERR_ID. */
MBSR_API int mbsr_closure_definition(const mbsr_model *model, int closure, mbsr_closure_def *def);

/* ---- closures at a state ----
 *
 * m = mbsr_model_rows, h = mbsr_model_position_rows, nq and nu as in the model. mbsr_assemble and
 * mbsr_closures_report take memory from the model's allocator for the call, in O(nu + m). Dense
 * matrices, O((nu + m)^2), are made by reports of models with stiff rows or with directions without
 * mass, or where ranks in O(nu + m) fail a check (loops anywhere in a large tree), and by
 * mbsr_assemble where stiff rows cannot all be closed. All others look up what is known. */

/* What the loops are open by: g (h) at the positions of mbsr_stage_positions. MBSR_ERR_NULL,
 * MBSR_ERR_MISMATCH, MBSR_ERR_SEQUENCE, MBSR_NOT_FINITE, what a table returned. */
MBSR_API int mbsr_closures_gap(const mbsr_model *model, mbsr_data *data, double *g);

/* ---- closing loops ---- */

/* How mbsr_assemble closes loops. */
typedef struct mbsr_assembly_opt {
    int cookie;         /* set by mbsr_default_assembly_opt */
    int max_iterations; /* default 100 */
    double
        tolerance; /* of each gap: turns in rad, places over the longest lever of the mechanism
                    * or   over their distance from the origin, whichever is more; default 1e-12 */
    /* nu each, NULL (default): none. How many times more than the others a coordinate resists,
     * positive: 1e6 keeps it where it is, as far as the loops let it; 1 for coordinates that stay
     * where they are. */
    const double *weight;
    const int *keep_position;
} mbsr_assembly_opt;

MBSR_API mbsr_assembly_opt mbsr_default_assembly_opt(void);

/* What mbsr_assemble has found. */
typedef struct mbsr_assembly_info {
    int iterations;
    int closure;            /* the one that is open widest, MBSR_NONE where all are closed */
    double gap_before, gap; /* largest |g| of the guess, and of q_closed */
    double change;          /* largest |change| of an entry of q */
} mbsr_assembly_info;

/* Positions that close all loops, near the guess q (nq), by the Levenberg-Marquardt method: the
 * change is small, of turns in rad, of ways over the longest lever of the mechanism, so that units
 * do not matter. Coordinates that a closure knows through its bodies alone, as a pin its angle,
 * have no part in that. q_closed (nq) may be q. Stiff rows are closed like rigid ones; where they
 * are more than the freedoms and cannot all be closed, those that depend on others at q are left as
 * they come, and their gaps are not counted. info may be NULL.
 *
 * MBSR_LOOP_OPEN where no position is found in which all gaps vanish: because there is none, or
 * because the guess leads to a position from which all ways make the gaps larger. q_closed and info
 * then hold the nearest position found, and the text names the loops that are open, and by how
 * much. Also MBSR_ERR_NULL, MBSR_ERR_NO_DEFAULT, MBSR_ERR_VALUE, MBSR_ERR_NO_MEMORY,
 * MBSR_NOT_FINITE and what mbsr_stage_positions returns; q_closed is then as it was. */
MBSR_API int mbsr_assemble(const mbsr_model *model, mbsr_data *data, double t, const double *q,
                           const mbsr_assembly_opt *opt, double *q_closed,
                           mbsr_assembly_info *info);

/* ---- ranks of the rows ---- */

/* What the rows hold at a position. Ranks are those of C with the
 * rows of a closure scaled so that the longest of them has length 1; rows count in
 * the order of their closures, position rows first, so that of several that are redundant together
 * the last counts as redundant. */
typedef struct mbsr_closure_report {
    int rows;         /* m */
    int independent;  /* rank of C here */
    int nearby;       /* and in closed positions nearby: larger where the position is singular */
    int mobility;     /* freedoms that are left: nu - independent - undetermined */
    int massless;     /* directions of the tree that move no mass */
    int undetermined; /* of these, the ones that no loop holds, neither by rigid nor by stiff rows
                       */
    double smallest_kept;   /* squared distance of an independent row from the span of all others
                               that are rigid */
    double largest_dropped; /* of a dependent one */
    int weakest; /* of the rigid rows that the data does not leave out, the one nearest to the span
                             of the others; MBSR_NONE where there are none */
    double weakest_pivot; /* its squared distance */
    double gap;           /* largest |g| */
    double stretch; /* smallest over largest singular value of the rows on the directions without
                       mass that they hold, each of which begins at a joint; 1 where there are none.
                       Where it vanishes these bodies are stretched: a motion that goes on would be
                       an impact */
    int stretched;  /* the row that has most part in it, or MBSR_NONE */
} mbsr_closure_report;

/* Reports on the position q, which should be closed. redundant (m): 1 for each row that depends on
 * those before it in every closed position nearby. unique (m): 1 where the loop force of the row is
 * determined by motion and applied forces, 0 where it is a matter of elasticity that the model has
 * not. Both may be NULL. MBSR_ERR_NULL, MBSR_ERR_NO_MEMORY and statuses of mbsr_stage_positions. */
MBSR_API int mbsr_closures_report(const mbsr_model *model, mbsr_data *data, double t,
                                  const double *q, mbsr_closure_report *report, int *redundant,
                                  int *unique);

/* The closure of row `row` among all, its own number of the row, and the row's name ("" where the
 * table gives none). Outputs may be NULL. MBSR_ERR_NULL, MBSR_ERR_UNFINISHED, MBSR_ERR_ID. */
MBSR_API int mbsr_closure_of_row(const mbsr_model *model, int row, int *closure, int *own,
                                 const char **name);

/* ---- loop forces ---- */

/* Loop forces lambda (m) of the last evaluation: of mbsr_stage_forces, mbsr_forward_dynamics, the
 * residual, or mbsr_inverse_dynamics. Those of stiff rows are the forces of their springs, those of
 * rigid rows zero after mbsr_stage_forces and inverse dynamics without motors. MBSR_ERR_NULL,
 * MBSR_ERR_SEQUENCE. */
MBSR_API int mbsr_closures_lambda(const mbsr_model *model, mbsr_data *data, double *lambda);

/* What one closure exerts on one of its bodies by these loop forces, such as the force of contact
 * on a rolling wheel: f (d numbers, conjugate to V; for a SPATIAL body the wrench about its origin,
 * moment first, world axes) and tau (n, conjugate to u), as mbsr_force_load. place: 0 .. bodies - 1
 * in its definition; a root at rest has no numbers. One output may be NULL. MBSR_ERR_NULL,
 * MBSR_ERR_SEQUENCE, MBSR_ERR_ID, MBSR_ERR_VALUE (place), MBSR_NOT_FINITE, what the table returned.
 */
MBSR_API int mbsr_closure_reaction(const mbsr_model *model, mbsr_data *data, int closure, int place,
                                   double *f, double *tau);

/* Where it acts, m, world axes (`point` of mbsr_closure_table): of balls, welds, rows and distances
 * the point of the first body, of rolling bodies that of contact. At the positions of
 * mbsr_stage_positions. MBSR_ERR_NULL, MBSR_ERR_SEQUENCE, MBSR_ERR_ID, MBSR_ERR_VALUE where it has
 * none, such as a coupling; MBSR_NOT_FINITE, what the table returned. */
MBSR_API int mbsr_closure_point(const mbsr_model *model, mbsr_data *data, int closure,
                                double point[3]);

#ifdef __cplusplus
}
#endif

#endif
