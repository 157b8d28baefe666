/* Internal structures: the finished model, the data block, and what source files share.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_INTERNAL_H
#define MBSRI_INTERNAL_H

#include <mbsrank/mbsrank.h>

#include <stdbool.h>
#include <stddef.h>

#if defined(__GNUC__)
#define MBSRI_FORMAT(a, b) __attribute__((format(printf, a, b)))
#else
#define MBSRI_FORMAT(a, b)
#endif

/* What the default functions write into a definition; a definition without it was not
 * initialised. */
enum { MBSRI_COOKIE = 0x6d627372 };

/* ---- model ----
 * Bodies 1 .. N are numbered parent before child, in depth-first order; body 0 is the root. Each
 * array of the data is indexed through the offsets below. */
/* A joint as the model keeps it; param points into the model. */
typedef struct mbsri_joint {
    const mbsr_joint_table *table;
    mbsr_space space;
    int d, np, n, nq;
    int params;
    const double *param;
    mbsr_motion_fn motion;
    void *user;
    int option[MBSR_JOINT_OPTIONS];
} mbsri_joint;

typedef struct mbsri_body {
    int id;        /* the caller's; MBSR_GROUND for the root */
    int parent;    /* index of the predecessor; 0 for the bodies on the root, -1 for the root */
    int d, d_pred; /* velocity coordinates of the body and of its predecessor */
    int np;        /* numbers in the pose */
    int n, nq;     /* joint velocity and position coordinates */
    int q, u;      /* places in the caller's vectors q and u, in the order of ids */
    int iq, iu;    /* places in the data's, in the order of the sweeps */
    size_t pred_p, pred_v, pred_dd; /* the predecessor's offsets, which save a look at its record */
    mbsr_space pred_space;
    size_t p, v;       /* offsets of np and d numbers */
    size_t dd, dp, dn; /* offsets of d x d, d x d_pred and d x n numbers */
    size_t k;          /* offset of K^-1; only bodies without MBSR_JOINT_UNIT_K take room */
    size_t nn;         /* offset of n x n numbers */
    mbsri_joint joint;
    mbsr_inertia inertia; /* matrix points into the model */
    size_t name;          /* offset into names */
    bool regular;         /* M is positive definite in every pose */
    const double *added;  /* d x d, part of M in every pose; NULL: none */
    int locks;            /* coordinates of the joint that are held; n and nq count the others */
    const double *held;   /* their values, NaN for the others (joint.n); NULL: none */
    size_t full;          /* offset of joint.n numbers, where some are held */
} mbsri_body;

/* A body as added, until the model is finished. */
typedef struct mbsri_body_entry {
    int parent;
    size_t name, matrix;
    size_t param; /* offset into matrices */
    mbsri_joint joint;
    mbsr_inertia inertia;
    bool regular;
    size_t added, held; /* offsets into matrices, 0: none */
    int locks;
} mbsri_body_entry;

typedef struct mbsri_force {
    mbsr_force_def def; /* name and body_list are not used: see below */
    int id;             /* the caller's */
    size_t name;        /* offset into names */
    size_t list;        /* offset of its def.bodies ids (and, once finished, indices) */
} mbsri_force;

/* A growing array; `count` elements of it are in use. */
typedef struct mbsri_array {
    void *data;
    size_t count, capacity;
} mbsri_array;

struct mbsr_model {
    mbsr_allocator allocator;
    mbsr_error error;
    double rank_tolerance;
    mbsr_root root;
    bool finished;

    mbsri_array entries;  /* mbsri_body_entry, by id; emptied by finish */
    mbsri_array forces;   /* mbsri_force, by id; once finished in the order of the sweeps */
    mbsri_array names;    /* char; offset 0 is the empty name */
    mbsri_array matrices; /* double */
    mbsri_array lists;    /* int: ids of the bodies of force elements */

    /* from here on set by finish */
    int bodies;      /* N */
    int *index;      /* id -> index, N */
    int *list_index; /* the lists as indices */
    int *u_of;       /* place of each joint rate of the sweeps in the caller's vectors, nu */
    int *q_of;       /* of each joint coordinate, nq */
    bool in_order;   /* both are the identity */
    struct mbsri_fast *fast; /* sweeps for rigid bodies in space, where they serve (fast/fast.h) */
    mbsri_body *body;        /* N + 1 */
    int nq, nu;
    int max_d, max_n, max_force_bodies;
    bool differences; /* some joint or inertia leaves its rates to differences */
    int lapack_work;  /* doubles of workspace for dsyev at max_n */
    /* sums over all bodies, the root included: lengths of the arrays */
    size_t size_p, size_v, size_dd, size_dp, size_dn, size_k, size_nn, size_full;
};

/* ---- data ----
 * ARRAY(name, length): arrays of doubles in the block, body after body. Shapes in mbsri_body's
 * terms. K is divided out: H, J, kI, kII are those of (7)-(9) multiplied by K^-1, mu is K^T mu,
 * Mbar is K^T Mbar K; D, tau and the residuals are the same with and without. */
/* clang-format off */
#define MBSRI_DATA_ARRAYS(ARRAY)                                                                   \
    ARRAY(q, m->nq)                /* nq        joint positions, as swept           positions */   \
    ARRAY(q_full, m->size_full)    /* joint.n   with those held, where some are     positions */   \
    ARRAY(u_full, m->size_full)    /* joint.n                                       velocities */  \
    ARRAY(u, m->nu)                /* nu        joint velocities, as swept          velocities */  \
    ARRAY(p, m->size_p)            /* np        pose (7)                            positions */   \
    ARRAY(Kinv, m->size_k)         /* d x d     K^-1, where K is not the unit matrixpositions */   \
    ARRAY(H, m->size_dp)           /* d x d_pred                                    positions */   \
    ARRAY(J, m->size_dn)           /* d x n                                         positions */   \
    ARRAY(kI, m->size_v)           /* d                                             positions */   \
    ARRAY(M, m->size_dd)           /* d x d     body mass matrix                    positions */   \
    ARRAY(V, m->size_v)            /* d         velocity (8)                        velocities */  \
    ARRAY(kII, m->size_v)          /* d                                             velocities */  \
    ARRAY(h, m->size_v)            /* d         gyroscopic force                    velocities */  \
    ARRAY(f, m->size_v)            /* d         applied and gyroscopic forces       forces */      \
    ARRAY(tau, m->nu)              /* n         joint forces                        forces */      \
    ARRAY(Mbar, m->size_dd)        /* d x d     (17a)                               backward */    \
    ARRAY(W, m->size_dd)           /* d x d     scale of the rounding errors in Mbarbackward */    \
    ARRAY(fbar, m->size_v)         /* d         (17b)                               backward */    \
    ARRAY(D, m->size_nn)           /* n x n     J^T Mbar J                          backward */    \
    ARRAY(Dinv, m->size_nn)        /* n x n     its pseudo-inverse                  backward */    \
    ARRAY(X, m->size_nn)           /* n x n     eigenvectors of S D S, range first  backward */    \
    ARRAY(s, m->nu)                /* n         S = diag(s)                         backward */    \
    ARRAY(lambda, m->nu)           /* n         eigenvalues of S D S, descending    backward */    \
    ARRAY(U, m->size_dn)           /* d x n     Mbar J                              backward */    \
    ARRAY(G, m->size_dn)           /* d x n     Mbar J D^+                          backward */    \
    ARRAY(e, m->nu)                /* n         tau - J^T (fbar + Mbar kII)         backward */    \
    ARRAY(scale, (size_t)m->bodies + 1) /* 1    largest entry of diag(J^T W J)      backward */ \
    ARRAY(A, m->size_v)            /* d         acceleration (9), its known part    inverse */     \
    ARRAY(Az, m->size_v)           /* d         part of null accelerations          forward */     \
    ARRAY(mu, m->size_v)           /* d         joint reaction                      inverse */    \
    ARRAY(vec, m->nu)              /* n         null accelerations                  forward */     \
    ARRAY(Hdot, m->size_dp)        /* d x d_predrate of H along the motion          rates */       \
    ARRAY(Jdot, m->size_dn)        /* d x n     rate of J                           rates */       \
    ARRAY(Mdot, m->size_dd)        /* d x d     rate of M                           rates */       \
    ARRAY(qdot, m->nq)             /* nq        q' = G u, as the caller's q         rates */       \
    ARRAY(udot, m->nu)             /* n         u' in the order of the sweeps       inverse, forward */ \
    ARRAY(out, m->nu)              /* n         a result in that order              inverse, forward */ \
    ARRAY(q_base, m->nq)           /* nq        the caller's q while displaced      rates */       \
    ARRAY(u_base, m->nu)           /* nu        the caller's u, likewise            rates */       \
    ARRAY(q_moved, m->nq)          /* nq        the displaced q                     rates */       \
    ARRAY(imp, m->size_v)          /* d         joint impulse m                     momentum */    \
    ARRAY(sigma, m->size_v)        /* d         its rate but for the reaction       momentum */    \
    ARRAY(impbar, m->size_v)       /* d         (17b) for momenta                   momentum */    \
    ARRAY(ep, m->nu)               /* n         p - J^T (impbar + Mbar kI)          momentum */    \
    ARRAY(w, m->nu)                /* n         index-1 velocities before X         index1 */      \
    ARRAY(Y, m->size_v)            /* d         Vz' - Az                            index1 */      \
    ARRAY(Mbardot, m->size_dd)     /* d x d     rate of Mbar                        index1 */      \
    ARRAY(Gdot, m->size_dn)        /* d x n     rate of G                           index1 */      \
    ARRAY(Xdot, m->size_nn)        /* n x n     rate of X                           index1 */      \
    ARRAY(s_frame, m->nu)          /* n         S of the reference                  frame */       \
    ARRAY(X_frame, m->size_nn)     /* n x n     X of the reference                  frame */       \
    ARRAY(u_given, m->nu)          /* nu        the caller's u, found from v        index1 */      \
    ARRAY(v_given, m->nu)          /* nu        the caller's v                      index1 */      \
    ARRAY(q_last, m->nq)           /* nq        the caller's q of a pending evaluation fast */     \
    ARRAY(u_last, m->nu)           /* nu        u                                   fast */        \
    ARRAY(load_last, m->nu)        /* nu        tau, or for inverse dynamics u'     fast */        \
    ARRAY(sincos, mbsri_fast_sincos(m)) /* 2 a coordinate                           fast */        \
    ARRAY(scratch, mbsri_scratch_size(m))

/* What is left of them in lean data. */
#define MBSRI_LEAN_ARRAYS(ARRAY)                                                                   \
    ARRAY(q, m->nq)                                                                                \
    ARRAY(u, m->nu)                                                                                \
    ARRAY(p, m->root.np)                                                                           \
    ARRAY(V, m->root.d)                                                                            \
    ARRAY(A, m->root.d)                                                                            \
    ARRAY(tau, m->nu)                                                                              \
    ARRAY(udot, m->nu)                                                                             \
    ARRAY(out, m->nu)                                                                              \
    ARRAY(vec, m->nu)                                                                              \
    ARRAY(w, m->nu)                                                                                \
    ARRAY(u_given, m->nu)                                                                          \
    ARRAY(q_last, m->nq)                                                                           \
    ARRAY(u_last, m->nu)                                                                           \
    ARRAY(load_last, m->nu)                                                                        \
    ARRAY(sincos, mbsri_fast_sincos(m))
/* clang-format on */

typedef enum mbsri_stage {
    MBSRI_STAGE_NONE,
    MBSRI_STAGE_POSITIONS,
    MBSRI_STAGE_VELOCITIES,
    MBSRI_STAGE_FORCES,
    MBSRI_STAGE_BACKWARD
} mbsri_stage;

/* A whole evaluation by the fast sweeps, whose stages run when somebody asks for what they hold. */
typedef enum mbsri_pending {
    MBSRI_PENDING_NONE,
    MBSRI_PENDING_FORWARD,
    MBSRI_PENDING_INVERSE
} mbsri_pending;

struct mbsr_data {
    const mbsr_model *model;
    bool lean;  /* only the arrays of MBSRI_LEAN_ARRAYS are there */
    bool owned; /* by the model's allocator */
    mbsr_allocator allocator;
    mbsr_error error;
    mbsri_stage stage;
    double t;
    int total_rank;
    bool accelerated;      /* A and mu are those of given joint accelerations */
    mbsri_pending pending; /* what the stages would hold if the fast sweeps had not been taken */
    struct mbsri_fast_state *fast_state; /* N + 1 */
    struct mbsri_fast_many *fast_many;
    struct mbsri_carry *fast_stack, *fast_noise;
    struct mbsri_flow *fast_flows;
    struct mbsri_fast_load *fast_load;
    int *rank;    /* N + 1 */
    int *watched; /* N + 1: the ranks expected, where `watching` */
    bool watching;
    int *frame_rank;               /* N + 1: ranks of the reference of the index-1 form */
    bool framed;                   /* there is such a reference */
    bool use_frame;                /* joint blocks are scaled by its S */
    double alignment;              /* cosine of the largest angle to it */
    int *pivots;                   /* max_d */
    bool *carries;                 /* N + 1: whether Az of the body may differ from zero */
    mbsr_force_body *force_bodies; /* max_force_bodies */
#define MBSRI_DECLARE(name, length) double *name;
    MBSRI_DATA_ARRAYS(MBSRI_DECLARE)
#undef MBSRI_DECLARE
};

size_t mbsri_scratch_size(const mbsr_model *m);
size_t mbsri_fast_sincos(const mbsr_model *m);

/* Fills every working array with NaN and forgets all stages, so that a test sees what reads before
 * writing. */
void mbsri_data_poison(mbsr_data *d);

/* ---- errors ---- */

/* Writes *error (if not NULL) and returns status. */
int mbsri_fail(mbsr_error *error, int status, int body, int force, const char *format, ...)
    MBSRI_FORMAT(5, 6);

/* "body 3 'rod'" into a buffer of MBSRI_LABEL; returns the buffer. */
enum { MBSRI_LABEL = 80 };
const char *mbsri_label(char *buffer, const char *kind, int id, const char *name);

/* The same for a body of a finished model, by index. */
const char *mbsri_body_label(const mbsr_model *m, int i, char *buffer);

/* Checks of every call on a data object: NULL, other model, missing stage. `outputs` false: a
 * required pointer is NULL. */
int mbsri_enter(const mbsr_model *m, mbsr_data *d, bool outputs, mbsri_stage needed,
                const char *function);

/* Index of a body by id; -1 if there is none. MBSR_GROUND is 0. */
int mbsri_index(const mbsr_model *m, int id);

/* Whether the joint is a stock joint in the plane; its free coordinates (MBSR_X and so on). */
bool mbsri_planar_coordinates(const mbsri_joint *joint, int *free);

/* Reports a callback's status for body i's joint. */
int mbsri_joint_failed(const mbsr_model *m, mbsr_data *d, int i, int status, const char *function);

bool mbsri_finite(size_t n, const double *x);

/* Largest absolute value of n numbers. */
double mbsri_largest(int n, const double *x);

/* MBSR_NOT_FINITE with a text that names the first quantity along the evaluation that is not
 * finite. */
int mbsri_report_not_finite(const mbsr_model *m, mbsr_data *d);

/* ---- memory of a model (model/memory.c) ---- */

void *mbsri_allocate(const mbsr_allocator *allocator, size_t size);
void mbsri_release(const mbsr_allocator *allocator, void *memory);

/* Makes room for `more` elements behind those in use; false if memory is short (the array is then
 * unchanged). */
bool mbsri_reserve(const mbsr_allocator *allocator, mbsri_array *array, size_t more,
                   size_t element);

/* ---- pieces shared by the stages ---- */

/* Pose, velocity and acceleration of the root at the data's time (kinematics.c). */
int mbsri_move_root(const mbsr_model *m, mbsr_data *d);

/* Keeps the caller's inputs of an evaluation by the fast sweeps; load may be NULL for zero. */
void mbsri_remember(const mbsr_model *m, mbsr_data *d, mbsri_pending pending, const double *q,
                    const double *u, const double *load);

/* Runs the stages of a pending evaluation up to the one that is needed. */
int mbsri_catch_up(const mbsr_model *m, mbsr_data *d, mbsri_stage needed);

/* Forward dynamics by the stages; data is left at mbsr_backward (forward.c). */
int mbsri_forward_by_stages(const mbsr_model *m, mbsr_data *d, double t, const double *q,
                            const double *u, const double *tau, double *udot);

/* Adds to tau what the force elements that act on joints alone exert; q, u in the order of the
 * sweeps (forces.c). */
int mbsri_joint_elements(const mbsr_model *m, mbsr_data *d, const double *q, const double *u);

/* Adds to f and tau what the others exert, gravity left out; reads p, V, M, q, u of the data. */
int mbsri_body_elements(const mbsr_model *m, mbsr_data *d);

/* Fills the data's force_bodies for a call of an element's derivatives, with f and tau NULL; `body`
 * is the one of an element that acts on every body. Returns how many (forces.c). */
int mbsri_force_bodies(const mbsr_model *m, mbsr_data *d, const mbsri_force *force, int body);

/* Reports the status of an element's function. */
int mbsri_force_failed(const mbsr_model *m, mbsr_data *d, const mbsri_force *force, int status,
                       const char *function);

/* The element of that id; NULL, reported as MBSR_ERR_ID, if there is none. */
const mbsri_force *mbsri_find_force(const mbsr_model *m, mbsr_data *d, int id,
                                    const char *function);

/* Numbers of a perturbation of a body's pose. */
static inline int mbsri_pose_numbers(mbsr_space space, int np)
{
    return space == MBSR_SPACE_SPATIAL ? 6 : np;
}

/* Columns of V, q and u of a body among the derivatives of an element, and the row of its tau,
 * where its first ones are `column` and `row`. */
static inline int mbsri_V_column(const mbsr_force_body *body, int column)
{
    return column + mbsri_pose_numbers(body->space, body->np);
}

static inline int mbsri_q_column(const mbsr_force_body *body, int column)
{
    return mbsri_V_column(body, column) + body->d;
}

static inline int mbsri_u_column(const mbsr_force_body *body, int column)
{
    return mbsri_q_column(body, column) + body->nq;
}

static inline int mbsri_tau_row(const mbsr_force_body *body, int row)
{
    return row + body->d;
}

/* Whether an element is mbsr_force_gravity. */
bool mbsri_is_gravity(const mbsr_force_def *def);

/* The arguments of body i's joint functions; `velocities`: V, V_pred and u are there. */
mbsr_joint_args mbsri_joint_args(const mbsr_model *m, const mbsr_data *d, int i, bool velocities);

/* M, and for inertias by function M and h (inertia.c). */
void mbsri_inertia_mass(const mbsri_body *b, const double *p, double *M);
void mbsri_inertia_mass_rate(const mbsri_body *b, const double *p, const double *V, const double *M,
                             double *Mdot);
int mbsri_inertia_velocity(const mbsri_body *b, double t, const double *p, const double *V,
                           double *M, double *h);

/* full = x with the values held, or zeros, put in; J = full without the columns held. For bodies
 * with locks (model/amend.c). */
void mbsri_with_held(const mbsri_body *b, const double *x, bool values, double *full);
void mbsri_drop_held(const mbsri_body *b, const double *full, double *J);

/* Eigen-decomposition and rank of one joint block, see rank.c. */
int mbsri_rank_decision(const mbsr_model *m, mbsr_data *d, int i);

/* MBSR_RANK_CHANGED if body i's rank is watched and another. */
int mbsri_rank_watched(const mbsr_model *m, mbsr_data *d, int i);

/* y = (I - D^+ D) x for body i: the part of a joint rate that D does not see. y and x may be the
 * same. */
void mbsri_null_part(const mbsr_model *m, const mbsr_data *d, int i, const double *x, double *y);

/* y = projection of x, a joint force or momentum of body i, on what D cannot take up; see rank.c.
 * For x = e it is gamma_i. y and x may be the same. */
void mbsri_null_force(const mbsr_model *m, const mbsr_data *d, int i, const double *x, double *y);

/* Hdot, Jdot, Mdot along the motion of the state at mbsr_velocities (rates.c). */
int mbsri_rates(const mbsr_model *m, mbsr_data *d);
bool mbsri_rates_by_differences(const mbsri_body *b);

/* One step of the recursion that carries null rates z to the leaves (forward.c),
 *   Az_i = -H_i Az_pi - J_i (z_i - D_i^+ J_i^T Mbar_i H_i Az_pi),
 * for accelerations, velocities or directions alike; Az and carries are in the data. The first
 * gives x = H Az_pi, or false where that is zero. The second takes z (n) where `own` is set, zero
 * otherwise, leaves z - G^T x in it, and writes Az_i. */
bool mbsri_null_below(const mbsr_model *m, const mbsr_data *d, int i, double *x);
void mbsri_null_pass(const mbsr_model *m, mbsr_data *d, int i, bool own, bool below,
                     const double *x, double *z);

/* Vectors over all joint rates between the caller's order and that of the sweeps. */
void mbsri_gather(const mbsr_model *m, const double *caller, double *swept);
void mbsri_scatter(const mbsr_model *m, const double *swept, double *caller);

/* A0 of body i and its load w = e - U^T H A0_pi, rate = D^+ w; n numbers each (forward.c). */
void mbsri_known_part(const mbsr_model *m, mbsr_data *d, int i, double *w, double *rate);

/* The two halves of mbsr_backward: Mbar, D and what follows from masses alone (needs
 * mbsr_velocities); then fbar, e, mu from forces. */
int mbsri_backward_masses(const mbsr_model *m, mbsr_data *d);
void mbsri_backward_loads(const mbsr_model *m, mbsr_data *d);

/* Forward part of inverse dynamics and its backward part; udot by id. Writes A, mu and the joint
 * forces that are missing, J^T mu - tau, to `out`. */
void mbsri_inverse_sweeps(const mbsr_model *m, mbsr_data *d, const double *udot);

/* ---- DAE forms ---- */

/* One form of the equations of motion. y = (q, rest). */
typedef struct mbsri_dae_form {
    mbsr_dae_form form;
    int (*size)(const mbsr_model *m);
    int (*id)(const mbsr_model *m, mbsr_data *d, double *id);
    int (*pack)(const mbsr_model *m, mbsr_data *d, double t, const double *q, const double *u,
                double *y);
    int (*unpack)(const mbsr_model *m, mbsr_data *d, double t, const double *y, double *q,
                  double *u);
    /* y' at y, where u' is given; the data is at mbsr_backward of that state */
    int (*start)(const mbsr_model *m, mbsr_data *d, double t, const double *y, const double *udot,
                 double *yp);
    int (*residual)(const mbsr_model *m, mbsr_data *d, double t, const double *y, const double *yp,
                    double *F);
} mbsri_dae_form;

extern const mbsri_dae_form mbsri_form_recursive, mbsri_form_inverse_dynamics, mbsri_form_momentum,
    mbsri_form_index1;

/* pack, unpack of a form, with q brought to its normal form. */
int mbsri_pack(const mbsri_dae_form *form, const mbsr_model *m, mbsr_data *d, double t,
               const double *q, const double *u, double *y);
int mbsri_unpack(const mbsri_dae_form *form, const mbsr_model *m, mbsr_data *d, double t,
                 const double *y, double *q, double *u);

/* The form of that number; NULL if there is none. */
const mbsri_dae_form *mbsri_find_form(mbsr_dae_form form);

#endif
