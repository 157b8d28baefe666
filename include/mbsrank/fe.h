/* Flexible bodies from finite elements: reduction of K and M to modal data, and SID_FEM files
 * (component fe).
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Given are stiffness and mass matrix of a body that nothing holds, its nodes, and markers: nodes
 * or sets of nodes to which joints and loads go. The first marker, the root, is the frame of the
 * body: all motions u are seen from it, u - T C^T u, with T the six rigid motions and C^T u the
 * motion of the root.
 *
 *   1. normal modes phi, K phi = omega^2 M phi, of the body held at the root, or free
 *   2. attachment modes K^-1 F, F the loads of a marker, less what the normal modes have of them
 *   3. all together diagonal in K and M; those above a cutoff frequency without mass
 *   4. integrals of the modes over the mass, markers, damping: mbsr_flex (flex.h)
 *
 * Deflections of loaded markers under loads there are those of the whole model whatever the number
 * of normal modes. docs/flexible.md has the formulas.
 *
 * Functions on different objects may run in several threads. With CHOLMOD part of the memory comes
 * from malloc whatever the allocator is. */
#ifndef MBSRANK_FE_H
#define MBSRANK_FE_H

#include <mbsrank/flex.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A symmetric sparse matrix, n x n, indices from 0. Entries with equal indices are added. */
typedef struct mbsr_fe_matrix {
    int rows;         /* n */
    size_t entries;   /* at most INT_MAX */
    const int *start; /* compressed columns: entries of column j are start[j] .. start[j + 1] - 1
                         (n + 1 numbers); NULL: coordinates */
    const int *row;
    const int *column; /* coordinates only */
    const double *value;
    int whole; /* 0: one triangle, upper or lower; 1: both, which have to agree to 1e-9 */
} mbsr_fe_matrix;

/* One node, or the average of a set: with d_k = x_k - x_mean, u = mean u_k and rotation S^-1 sum
 * d_k x u_k, S = sum (|d_k|^2 1 - d_k d_k^T); loads are spread likewise. One node without rotations
 * does not turn and takes forces only. Axes are those of the coordinates. */
typedef struct mbsr_fe_marker {
    const char *name; /* for texts; NULL: none */
    int nodes;        /* 1: the node itself; 3 or more: their average */
    const int *node;  /* their ids */
    int loaded;       /* 1: static modes for all its loads; of the root it means nothing */
} mbsr_fe_marker;

/* How K is factored. */
typedef enum mbsr_fe_solver {
    MBSR_FE_AUTO = 0,  /* dense up to 600 dofs; without CHOLMOD up to 5000, and no further */
    MBSR_FE_DENSE = 1, /* LAPACK: n^2 numbers, n^3 / 3 operations */
    MBSR_FE_SPARSE = 2 /* CHOLMOD; MBSR_ERR_UNAVAILABLE without it */
} mbsr_fe_solver;

/* Called now and then: what is being done, and which part of that, 0 .. 1. What it returns other
 * than 0 stops the reduction and is its status. */
typedef int (*mbsr_fe_progress_fn)(void *user, const char *stage, double done);

typedef struct mbsr_fe_def {
    int cookie;             /* set by mbsr_default_fe_def */
    mbsr_fe_matrix K, M, D; /* N/m, kg, N s/m (N m for rotations ...); D.rows = 0: none */
    int nodes;
    const int *id;                /* of the nodes; NULL: 0, 1, ... */
    const double *x;              /* 3 x nodes, m */
    const int *dof_node;          /* of each row of K: id of its node; NULL: node by node ... */
    const int *dof_direction;     /* ... three displacements or, with 6 rows a node, three rotations
                                 behind them. 0 .. 2: displacement, 3 .. 5: rotation */
    int markers;                  /* 1 or more */
    const mbsr_fe_marker *marker; /* first the root, whose rotation must be determined */
    int free;         /* 1: normal modes of the free body; 0 (default): held at the root */
    int modes;        /* normal modes at most, the lowest ones; default 10 */
    double frequency; /* rad/s: no normal mode above; default INFINITY */
    double cutoff;    /* rad/s: modes above it are massless; default 0: the highest frequency of the
                         normal modes. INFINITY: all modes keep their mass */
    double damping;   /* ratio zeta >= 0 of all modes, as for beams (flex.h), beside D; default 0 */
    double rigid;     /* |K T| beside |K| |T| that passes for rounding; default 1e-8 */
    double tolerance; /* residual of a normal mode beside 1 / omega^2; default 1e-10 */
    mbsr_fe_solver solver;
    mbsr_fe_progress_fn progress; /* may be NULL */
    void *user;                   /* for progress */
    mbsr_allocator allocator;     /* of the result and of what it takes; default: malloc and free */
} mbsr_fe_def;

MBSR_API mbsr_fe_def mbsr_default_fe_def(void);

/* A mode of the modal data. */
typedef struct mbsr_fe_mode {
    double omega; /* rad/s; of a massless one sqrt(K / M) with the mass left out, 0 where there was
                     none */
    double damping; /* D / (2 omega M), of a massless one 0 */
    int massless;
    double effective[6]; /* mass that takes part in moving the root: its share of moment of inertia
                            about the axes of the root (kg m^2), then of the mass along them (kg) */
} mbsr_fe_mode;

/* What a reduction has found. */
typedef struct mbsr_fe_report {
    int dofs, nodes;
    mbsr_fe_solver solver; /* that was used */
    double entries;        /* of the Cholesky factor of K */
    int solves;            /* with this factor */
    int normal;            /* normal modes found */
    const double *omega;   /* their frequencies, rad/s, held or free as wanted */
    int loads;             /* unit loads that got static modes */
    int dependent;         /* of their modes, those left out: others have them already */
    int modes;
    const mbsr_fe_mode *mode; /* of the modal data, by frequency */
    double mass, c0[3], J[9]; /* kg, kg m, kg m^2: of the rigid body, about the root */
    double lost[6];  /* part of J's diagonal and of the mass that no mode with mass moves, 0 .. 1 */
    double rigid;    /* largest |K T| beside |K| |T| */
    double definite; /* lowest eigenvalue of M(0) of modes with mass, scaled to unit diagonal */
    double difference; /* of M(0) from that of the matrices, so scaled: rounding for solids, and
                          where nodes have rotations what lumping the mass does */
    const char *text;  /* all this as a table */
} mbsr_fe_report;

/* Reduces a model to modal data, whose markers are those of def, along the axes of the coordinates;
 * origin is the root. Modes are by frequency; those with mass have mass 1, those without K = 1.
 * Damping of modes with mass is 2 zeta omega, of the others 2 zeta / omega_c K, omega_c the cutoff
 * or the highest frequency with mass, what is larger; D adds Phi^T D Phi.
 *
 * Integrals are exact where nodes have displacements only and mass is the same along all three axes
 * (solids): M = Ms x 1. Where nodes have rotations, the matrices do not say where mass is: it is
 * lumped at the nodes, with the blocks on the diagonal of M as particle and tensor of inertia, and
 * modal fields are so scaled that the modal masses remain those of M; report->difference says how
 * far off M(0) then is.
 *
 * *flex is released by mbsr_flex_destroy, *report (NULL: not wanted) by mbsr_fe_report_destroy. On
 * failure both are NULL and the reason, with dof, node, marker and value, is in *error (may be
 * NULL): MBSR_ERR_NULL, MBSR_ERR_NO_DEFAULT, MBSR_ERR_NO_MEMORY, MBSR_ERR_UNAVAILABLE (too many
 * dofs without CHOLMOD), MBSR_ERR_NUMERICS, what `progress` returned, and
 * MBSR_ERR_VALUE: numbers that are not finite, K, M or D that are not symmetric, K that is grounded
 * (a rigid motion costs energy), indefinite or has mechanisms, M that is indefinite or has
 * different mass along different axes, wrong dofs, nodes and markers, more than MBSR_MAX_MODES
 * modes.
 *
 * Memory and time: of the factor of K and, at 5 to 8 solves for each normal mode, of solving with
 * it. */
MBSR_API int mbsr_fe_reduce(const mbsr_fe_def *def, mbsr_flex **flex, mbsr_fe_report **report,
                            mbsr_error *error);
MBSR_API void mbsr_fe_report_destroy(mbsr_fe_report *report); /* NULL is allowed */

/* ---- from files ---- */

/* The contents of a file; the library opens none. */
typedef struct mbsr_fe_text {
    const char *text; /* NULL: there is none */
    size_t size;      /* bytes */
    const char *name; /* for error texts; NULL: the name of the field */
} mbsr_fe_text;

/* K, M, D: Matrix Market, "matrix coordinate real symmetric" or "general". nodes: lines "id x y z".
 * dofs: lines "node direction", or "node.direction", direction 1 .. 6, in the order of the rows;
 * without it as dof_node NULL. markers: lines "name kind node ..." with kind "node" or "average",
 * the root first. Numbers are separated by blanks or commas; lines that begin with # and empty ones
 * are left out. */
typedef struct mbsr_fe_files {
    mbsr_fe_text K, M, D, nodes, dofs, markers; /* D and dofs may be left out */
} mbsr_fe_files;

/* What was read: fill in the rest of def, then reduce it. */
typedef struct mbsr_fe_input {
    mbsr_fe_def def;        /* defaults, and what the files say */
    mbsr_fe_marker *marker; /* those of def; all but the root are loaded */
} mbsr_fe_input;

/* On success *input belongs to the caller and holds all that it points to. On failure it is NULL,
 * and the reason, with file and line, in *error (may be NULL): MBSR_ERR_NULL, MBSR_ERR_NO_MEMORY,
 * MBSR_ERR_FILE. allocator NULL: malloc and free. */
MBSR_API int mbsr_fe_read(const mbsr_fe_files *files, const mbsr_allocator *allocator,
                          mbsr_fe_input **input, mbsr_error *error);
MBSR_API void mbsr_fe_input_destroy(mbsr_fe_input *input); /* NULL is allowed */

#ifdef __cplusplus
}
#endif

#endif
