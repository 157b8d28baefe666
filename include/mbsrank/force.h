/* Force elements: the stock ones, and the table through which a caller defines others.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRANK_FORCE_H
#define MBSRANK_FORCE_H

#include <mbsrank/base.h>
#include <mbsrank/inertia.h>
#include <mbsrank/joint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* One body as a force element sees it. For the ground, p and V are those of the root (not to be
 * read when space is FIXED), n is 0, and what is added to f is dropped. Pointers are valid during
 * the call only. */
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
    double *f;   /* d,  conjugate to V; add to it.  NULL while the energy is asked for */
    double *tau; /* n,  conjugate to u; add to it.  NULL for the ground, and as f */
} mbsr_force_body;

typedef struct mbsr_force_def mbsr_force_def;

typedef struct mbsr_force_args {
    const mbsr_force_def *force; /* the element as given to the model: param, option, user */
    double t;                    /* s */
    int bodies;                  /* number of entries in body */
    const mbsr_force_body *body; /* in the order of the definition */
} mbsr_force_args;

#define MBSR_FORCE_TABLE_VERSION 1u

/* The element acts on every body of the tree: called once a body, with that body alone. */
#define MBSR_FORCE_EVERY_BODY 1u

/* Functions return 0, or a status that ends the evaluation and reaches the caller unchanged (> 0
 * recoverable, < 0 fatal). They may be called by several threads at once, with different
 * arguments. */
typedef struct mbsr_force_table {
    unsigned version; /* MBSR_FORCE_TABLE_VERSION */
    unsigned flags;   /* MBSR_FORCE_EVERY_BODY or 0 */
    const char *name; /* for messages; must outlive the model */

    /* Adds the element's forces to body[k].f and body[k].tau. */
    int (*evaluate)(const mbsr_force_args *args);

    /* Optional: potential energy in J; *energy arrives as zero. */
    int (*energy)(const mbsr_force_args *args, double *energy);

    /* Optional: called once when the model is finished; only id, space, d, np, n and nq of the
     * bodies are set. Not called for elements that act on every body. On refusal returns a status
     * and may write a text. */
    int (*check)(const mbsr_force_args *args, char text[MBSR_TEXT_SIZE]);
} mbsr_force_table;

/* A force as function of time: writes `n` components. Returns 0 or a status. */
typedef int (*mbsr_force_fn)(void *user, double t, int n, double *value);

#define MBSR_FORCE_PARAMS 8
#define MBSR_FORCE_OPTIONS 2

/* A force element; made by a constructor below or mbsr_default_force_def, copied into the model. */
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
    void *user; /* for the table's functions and for function; not copied, may be NULL */
};

MBSR_API mbsr_force_def mbsr_default_force_def(void);

/* Uniform gravity g in m/s^2 on all POINT and PLANAR bodies: f = M (gx, gy, 0). Bodies in GENERAL
 * space are left out: their coordinates have no known direction. */
MBSR_API mbsr_force_def mbsr_force_gravity(double gx, double gy);

/* Linear spring-damper along coordinate axis `axis` (0 .. d-1): with e = p_a[axis] - p_b[axis] the
 * force on a is -(stiffness (e - rest) + damping e'). Either may be the ground (a root at rest
 * counts as p = 0). Units follow the coordinate: N/m, N s/m, m or N m/rad, N m s/rad, rad. Needs V
 * = p' of both bodies. */
MBSR_API mbsr_force_def mbsr_force_axis_spring(int a, int b, int axis, double stiffness,
                                               double damping, double rest);

/* Linear spring-damper along the line from a point of body a to a point of body b (POINT, PLANAR or
 * ground; points in body axes, m; a POINT body has the point {0, 0} only). N/m, N s/m, free length
 * in m. Where the two points coincide the line has no direction: MBSR_DEGENERATE_FORCE, unless free
 * length and damping are zero. */
MBSR_API mbsr_force_def mbsr_force_point_spring(int a, const double point_a[2], int b,
                                                const double point_b[2], double stiffness,
                                                double damping, double free_length);

/* Spring-damper on joint coordinate `coordinate` (0 .. n-1, nq = n) of a body: tau = -(stiffness (q
 * - rest) + damping u). */
MBSR_API mbsr_force_def mbsr_force_joint_spring(int body, int coordinate, double stiffness,
                                                double damping, double rest);

/* Force on a body as function of time: `function` writes d components conjugate to V. */
MBSR_API mbsr_force_def mbsr_force_applied(int body, mbsr_force_fn function, void *user);

/* Joint force or torque as function of time: `function` writes n components conjugate to u. */
MBSR_API mbsr_force_def mbsr_force_joint_applied(int body, mbsr_force_fn function, void *user);

/* An element with the caller's own table. `bodies` lists `count` ids; it must stay valid until the
 * element is added. */
MBSR_API mbsr_force_def mbsr_force_custom(const mbsr_force_table *table, int count,
                                          const int *bodies, void *user);

#ifdef __cplusplus
}
#endif

#endif
