/* What a state does not say itself: velocities of what has no mass, accelerations, loop forces.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * An integrator controls the errors of q and of the momenta p. Velocities of directions without
 * mass, accelerations and loop forces are algebraic: between its steps they are interpolated, and
 * are worth much less. All of them follow from q and p at one time,
 *
 *   0 = F_u(t, q, p, u)   C u + g_t = 0         u, and where loops are closed impulses p += C^T I
 *   K (q', p', u', .)^T = c (q', p', ., .)^T - dF/dt
 *       u' and the loop forces lambda, c -> infinity
 *
 * with the Newton matrix K = dF/dy + c dF/dy' of the momentum form (newton.h): a factorisation and
 * a few solutions on the tree, O(N). mbsr_ida_advance does this for the states that it hands out; a
 * solver of your own may do so with
 *
 *   mbsr_completion *c;
 *   mbsr_completion_create(model, NULL, &c, &error);
 *   mbsr_completion_solve(c, data, MBSR_DAE_MOMENTUM, t, y, yp);      q and p of y stay
 *
 * Directions that springs alone hold (index 2): u from the differentiated balance of forces, u'
 * from that differentiated twice; difference quotients of the residual serve there. */
#ifndef MBSRANK_COMPLETION_H
#define MBSRANK_COMPLETION_H

#include <mbsrank/newton.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct mbsr_completion mbsr_completion;

/* Creates one; opt, of its Newton solver, may be NULL (`method` and `max_rank` are chosen here, so
 * that it is exact). Where newton.h does not serve a model a dense matrix takes its place: O(N^2)
 * in memory, O(N^3) a factorisation. The model must outlive it. One object belongs to one thread.
 * Memory is taken from the model's allocator here; calls take none but for what
 * mbsr_forward_dynamics takes with closures that vector code does not serve. On failure *completion
 * is NULL and the reason in *error (may be NULL). MBSR_ERR_NULL, MBSR_ERR_UNFINISHED,
 * MBSR_ERR_NO_MEMORY, statuses of mbsr_newton_create. */
MBSR_API int mbsr_completion_create(const mbsr_model *model, const mbsr_newton_opt *opt,
                                    mbsr_completion **completion, mbsr_error *error);
MBSR_API void mbsr_completion_destroy(mbsr_completion *completion); /* NULL is allowed */

/* Completes y and yp (mbsr_dae_size numbers of the form each) at t. Of y, q and the momenta count:
 * in the momentum form p, in the others those of its velocities, which are a first guess otherwise;
 * in models with closures yp is the first guess of loop forces. What is without mass gets its
 * velocity, yp all rates. With closures positions are closed in the weights of mbsr_assemble, and p
 * changes by impulses of the loops: by what an integrator has left of these equations. The data is
 * at mbsr_stage_accelerations of the state. y and yp are unchanged on failure.
 *
 * MBSR_UNDETERMINED names a joint rate that neither mass nor force nor closure determines;
 * MBSR_NO_CONVERGENCE; MBSR_LOOP_SINGULAR; MBSR_ERR_NULL, MBSR_ERR_MISMATCH, MBSR_ERR_VALUE (form),
 * MBSR_ERR_CLOSURES, MBSR_NOT_FINITE, statuses of the residual and of mbsr_newton_factor. */
MBSR_API int mbsr_completion_solve(mbsr_completion *completion, mbsr_data *data, mbsr_dae_form form,
                                   double t, double *y, double *yp);

/* The state completed last in joint coordinates: q (nq), u, u' (nu) and loop forces (m numbers),
 * each may be NULL. The data is at mbsr_stage_accelerations of it: poses, twists, accelerations and
 * reactions can be asked for at once. MBSR_ERR_NULL, MBSR_ERR_MISMATCH, MBSR_ERR_SEQUENCE where the
 * last call failed, or there was none: the text is the data's. */
MBSR_API int mbsr_completion_motion(const mbsr_completion *completion, mbsr_data *data, double *q,
                                    double *u, double *udot, double *lambda);

/* Forward dynamics where the mass matrix may be singular: accelerations udot (nu) and loop forces
 * lambda (m numbers; may be NULL) at positions q and velocities u under the force elements and the
 * joint forces tau (nu, NULL for none; held). Rates that no mass moves keep the balance of forces
 * as it is: dF_u/dt = 0 along the motion; where u does not balance them (mbsr_dae_imbalance) they
 * keep what it is off by. As mbsr_forward_dynamics where that serves. Stiff closures are springs.
 * Outputs must not overlap inputs. Statuses of mbsr_completion_solve. */
MBSR_API int mbsr_completion_dynamics(mbsr_completion *completion, mbsr_data *data, double t,
                                      const double *q, const double *u, const double *tau,
                                      double *udot, double *lambda);

/* What it has cost so far. */
typedef struct mbsr_completion_info {
    long states, residuals, factorisations, solves;
    size_t bytes; /* memory of the object */
    int damped;   /* 1: some directions of the state completed last move no mass, and dampers hold
                   * them all */
} mbsr_completion_info;

/* What completions have cost so far. MBSR_ERR_NULL. */
MBSR_API int mbsr_completion_get_info(const mbsr_completion *completion,
                                      mbsr_completion_info *info);

/* The last failure; never NULL. */
MBSR_API const mbsr_error *mbsr_completion_error(const mbsr_completion *completion);

#ifdef __cplusplus
}
#endif

#endif
