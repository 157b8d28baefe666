/* The Newton system of the momentum form, solved on the tree in O(N).
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * An implicit integrator for F(t, y, y') = 0 (dae.h) solves in each Newton iteration
 *
 *   (dF/dy + c dF/dy') delta = r,      c = dy'/dy of its formula, in 1/s (1/h for implicit Euler)
 *
 * On a tree the bodies' equations can be eliminated leaves to root and solved root to leaves, as in
 * the articulated-body algorithm: mbsr_newton_factor and mbsr_newton_solve take O(N) operations and
 * no memory. The matrix is that of the linearised equations of motion, from formulas and not by
 * differences of F (docs/newton.md has them). With closures, the multipliers' part of y is solved
 * for along with the rest, in a number of operations that grows as bodies and local loops. At
 * states of a solution, where the algebraic equations hold, it is the derivative of F; elsewhere it
 * lacks terms proportional to the defect of these equations, as Newton's method allows.
 *
 *   mbsr_newton *newton;
 *   mbsr_newton_create(model, MBSR_DAE_MOMENTUM, NULL, &newton, &error);
 *   in each iteration:  mbsr_dae_residual(model, data, form, t, y, yp, F);
 *                       mbsr_newton_factor(newton, data, t, y, yp, c);     (or an earlier one's)
 *                       mbsr_newton_solve(newton, F, delta);               y -= delta */
#ifndef MBSRANK_NEWTON_H
#define MBSRANK_NEWTON_H

#include <mbsrank/dae.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct mbsr_newton mbsr_newton;

/* Force elements between bodies that are not predecessor and successor couple what the tree
 * separates. Where bodies are eliminated by the front, which takes any model, such elements are
 * part of it, at a constant cost for each body between them where these are short, as in a vehicle.
 * Beside the sweeps in vector code their part of the matrix is a correction of low rank (Sherman,
 * Morrison, Woodbury), for which factoring costs one solution for each unit of rank; or it is left
 * out. */
typedef enum mbsr_newton_method {
    MBSR_NEWTON_AUTO = 0, /* CORRECTED where vector code serves, up to `max_rank`, and where that
                             takes fewer operations; else ELIMINATED */
    MBSR_NEWTON_TREE = 1, /* left out where vector code serves: exact without such elements, else a
                                  preconditioner */
    MBSR_NEWTON_CORRECTED = 2, /* beside vector code where that serves all bodies: exact */
    MBSR_NEWTON_ELIMINATED = 3 /* by the front: exact */
} mbsr_newton_method;

typedef struct mbsr_newton_opt {
    int cookie;                /* set by mbsr_default_newton_opt */
    mbsr_newton_method method; /* default MBSR_NEWTON_AUTO */
    int max_rank;              /* of the correction, for AUTO; default 120 */
    int by_blocks; /* 1: by the front, which serves any model, and not the sweeps in vector code;
                                  default 0 */
    int lean; /* 1: memory for these sweeps alone, a few hundred bytes a rigid body instead of some
                 kB; what they do not serve, closures and elements across mixed trees too, is
                 refused with MBSR_ERR_LEAN; default 0 */
    int products; /* 1: memory for mbsr_newton_linearise, some 10 kB a body; not lean; default 0 */
    int transposes; /* 1: mbsr_newton_solve_transposed and _adjoint serve. Models with elements
                 across or bodies of several kinds are passed by the front, as with by_blocks; not
                 lean; default 0 */
    int together;   /* n > 0: where joints, elements and pairs of elements by pairs tie more than n
                       bodies to each other, forces in those pairs that load no joints are found by
                       GMRES, in a number of operations that grows as bodies and pairs; not with
                       transposes; default 0, that of the driver 64 */
    double pairs_error; /* what GMRES leaves of these forces beside their size, above 0 and below 1;
                           default 1e-5, that of the driver 1e-3 */
} mbsr_newton_opt;

MBSR_API mbsr_newton_opt mbsr_default_newton_opt(void);

/* What a solver is and has done. */
typedef struct mbsr_newton_info {
    mbsr_newton_method method; /* TREE, CORRECTED or ELIMINATED */
    int exact;       /* 1: solve gives the solution, at the last factorisation; 0: an approximation,
                      * with which to precondition an iterative method (SPGMR and the like) */
    int across;      /* force elements between other bodies */
    int rank;        /* of the correction, at the last factorisation; without one: 0 */
    int vector_code; /* 1: rigid bodies were in vector code at the last factorisation */
    int blocks;      /* bodies that were passed by a front, by their functions */
    long factorisations, solves;
    long iterations; /* of GMRES in all these solutions (mbsr_newton_opt, together) */
    size_t bytes;    /* memory of the object */
} mbsr_newton_info;

/* Creates a solver for Newton systems of a model; opt == NULL means mbsr_default_newton_opt(). The
 * model must outlive it. One object belongs to one thread. On failure *newton is NULL and the
 * reason in *error (which may be NULL). Memory is taken from the model's allocator here and nowhere
 * else.  MBSR_ERR_NULL, MBSR_ERR_NO_DEFAULT, MBSR_ERR_UNFINISHED, MBSR_ERR_NO_MEMORY,
 * MBSR_ERR_VALUE (an option out of range; a form other than MBSR_DAE_MOMENTUM, whose rows are not
 * those of the linearised equations of motion), MBSR_ERR_SPACE: a joint or an inertia by function
 * leaves its rates to differences behind a body whose velocities are not rates of its pose, or a
 * closure reads coordinates of a joint whose rates are not u. */
MBSR_API int mbsr_newton_create(const mbsr_model *model, mbsr_dae_form form,
                                const mbsr_newton_opt *opt, mbsr_newton **newton,
                                mbsr_error *error);
MBSR_API void mbsr_newton_destroy(mbsr_newton *newton); /* NULL is allowed */

/* Linearises F at (t, y, y') and eliminates, for c > 0 or < 0 (an integration backward in time).
 * data belongs to the same model; it is at mbsr_stage_backward of that state afterwards, and not
 * needed by mbsr_newton_solve. Lean data serves where the sweeps in vector code do. What force
 * elements and joints without derivatives of their own exert is differenced locally (joint.h,
 * force.h). Statuses of mbsr_dae_residual; MBSR_SINGULAR_BLOCK, recoverable, names the body whose
 * equations do not determine its rates and what to do; MBSR_LOOP_SINGULAR, recoverable, names a row
 * of a closure that depends on others, which the data does not leave out; MBSR_ERR_VALUE for a c
 * that is zero or not finite; MBSR_ERR_LEAN (see mbsr_newton_opt). After a failure there is no
 * factorisation. */
MBSR_API int mbsr_newton_factor(mbsr_newton *newton, mbsr_data *data, double t, const double *y,
                                const double *yp, double c);

/* Solves for delta (mbsr_dae_size numbers) from r; they may be the same. MBSR_ERR_NULL,
 * MBSR_ERR_SEQUENCE without a factorisation, MBSR_NOT_FINITE for an r that is not finite and for a
 * delta that would not be, MBSR_NO_CONVERGENCE, recoverable, where GMRES does not converge (the
 * next ten plans eliminate all then); delta is not written in these cases. */
MBSR_API int mbsr_newton_solve(mbsr_newton *newton, const double *r, double *delta);

/* Solves A^T x = v, A = dF/dy + c dF/dy' of the last factorisation, from the same factors: x and v
 * have mbsr_dae_size numbers, v in the units of 1/y and x in those of 1/F, and may be the same. For
 * sensitivities of all parameters at once (adjoint equations), and for condition estimates. Where
 * the front has factored a closed model it is refined, as mbsr_newton_solve is. MBSR_ERR_NULL,
 * MBSR_ERR_SEQUENCE without a factorisation or without `transposes` in mbsr_newton_opt,
 * MBSR_NOT_FINITE for a v that is not finite and for an x that would not be; x is not written then.
 */
MBSR_API int mbsr_newton_solve_transposed(mbsr_newton *newton, const double *v, double *x);

/* The product with the matrix itself, r = (dF/dy + c dF/dy') delta, at any state: for line
 * searches, iterative solvers and the error of a solution. `linearise` evaluates and keeps the
 * derivatives at (t, y, y'), for any finite c; it has nothing to do with factorisations, which stay
 * as they are, so that one at an earlier state can precondition. The data is at mbsr_stage_backward
 * of that state afterwards. `multiply` takes O(N) operations, elements across the tree and closures
 * included, whatever `method` says; delta and r (mbsr_dae_size numbers) may be the same. The matrix
 * is that of mbsr_newton_factor: the derivative of F where the algebraic equations hold, elsewhere
 * without what is proportional to their defect. linearise: MBSR_ERR_SEQUENCE without `products` in
 * mbsr_newton_opt, MBSR_ERR_LEAN, statuses of mbsr_dae_residual and of derivatives; multiply:
 * MBSR_ERR_NULL, MBSR_ERR_SEQUENCE before linearise, MBSR_NOT_FINITE, and r is not written then. */
MBSR_API int mbsr_newton_linearise(mbsr_newton *newton, mbsr_data *data, double t, const double *y,
                                   const double *yp, double c);
MBSR_API int mbsr_newton_multiply(mbsr_newton *newton, const double *delta, double *r);

/* What joint forces tau (nu) beside all others would add to F at the state linearised: r
 * (mbsr_dae_size numbers) = dF/dtau tau, the right-hand side of an input. Statuses of
 * mbsr_newton_multiply. */
MBSR_API int mbsr_newton_multiply_torque(mbsr_newton *newton, const double *tau, double *r);

/* The product with its transpose, v = (dF/dy + c dF/dy')^T x, of the same derivatives and with the
 * same statuses as mbsr_newton_multiply; x and v may be the same. */
MBSR_API int mbsr_newton_multiply_transposed(mbsr_newton *newton, const double *x, double *v);

/* A part of the matrix, at the state linearised: r = dF/dy' x (mbsr_dae_size numbers each), which
 * on a tree is the unit matrix of q and p. Arguments may be the same. Statuses of
 * mbsr_newton_multiply. */
MBSR_API int mbsr_newton_multiply_rate(mbsr_newton *newton, const double *x, double *r);

/* A step of the linearised equations of a run (sensitivity.h), with the last factorisation and
 * nothing else: delta with
 *
 *   (dF/dy + c dF/dy') delta = dF/dtau tau - dF/dy' history
 *
 * for changes tau (nu) of joint forces and mbsr_dae_size numbers of history; or its transpose, for
 * v (mbsr_dae_size): with A^T x = v, A the matrix on the left, tau = (dF/dtau)^T x and history =
 * -(dF/dy')^T x. delta and history may be the same, and v and history. MBSR_ERR_NULL,
 * MBSR_ERR_LEAN, MBSR_ERR_SEQUENCE as the solutions above, MBSR_NOT_FINITE; nothing is written
 * then. */
MBSR_API int mbsr_newton_solve_sensitivity(mbsr_newton *newton, const double *tau,
                                           const double *history, double *delta);
MBSR_API int mbsr_newton_solve_adjoint(mbsr_newton *newton, const double *v, double *tau,
                                       double *history);

/* How the systems are solved, and what that has cost. MBSR_ERR_NULL. */
MBSR_API int mbsr_newton_get_info(const mbsr_newton *newton, mbsr_newton_info *info);

/* The last failure; never NULL. */
MBSR_API const mbsr_error *mbsr_newton_error(const mbsr_newton *newton);

#ifdef __cplusplus
}
#endif

#endif
