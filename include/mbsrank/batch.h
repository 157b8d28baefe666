/* One model at many states in one call: parameter studies, difference Jacobians, Monte Carlo.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Several states are evaluated side by side in the lanes of the processor's vector registers: two,
 * with AVX2 four, with AVX-512 eight. This serves rigid bodies in space and in the plane whose
 * joints are those of the library. Other bodies among them, and force elements, are
 * called state by state in between.
 *
 * The functions of dynamics.h serve, one by one and at their price, all states of models without
 * any such rigid body, and those states of others in which a joint's rank is not clearly full, an
 * angle is beyond 1e5 rad, or anything fails. Results are the same. */
#ifndef MBSRANK_BATCH_H
#define MBSRANK_BATCH_H

#include <mbsrank/dynamics.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct mbsr_batch mbsr_batch;

/* Memory for batches of a finished model, which must outlive it, from the model's allocator: an
 * mbsr_data and, for each body, about 35 numbers a lane; lean data (driver.h) a lane where bodies
 * are called state by state. After this no call allocates. Several batches of one model may be used
 * by several threads at once, one batch by one thread at a time. On failure *batch is NULL; *error
 * may be NULL. Status: MBSR_OK, MBSR_ERR_NULL, MBSR_ERR_UNFINISHED, MBSR_ERR_CLOSURES,
 * MBSR_ERR_NO_MEMORY. */
MBSR_API int mbsr_batch_create(const mbsr_model *model, mbsr_batch **batch, mbsr_error *error);
MBSR_API void mbsr_batch_destroy(mbsr_batch *batch); /* NULL is allowed */

/* States that go side by side; 1 where all go one by one. The last states of a call fill as many
 * lanes as all others, so multiples of this number are cheapest. 0 for NULL. */
MBSR_API int mbsr_batch_lanes(const mbsr_batch *batch);

/* Forward dynamics (ABA), as mbsr_forward_dynamics, of `states` >= 1 states at one time t. q: nq x
 * states, u, tau (may be NULL for none), udot: nu x states, one column a state without padding:
 * state k begins at q + k nq and u + k nu. udot must not overlap the inputs. All states are
 * evaluated whatever becomes of the others, and no result depends on the states beside it.
 *
 * status: `states` numbers, or NULL: what mbsr_forward_dynamics returns for each. The result is
 * that of the first state that failed, which mbsr_batch_failed and mbsr_batch_error name, or
 * MBSR_OK. udot of a state with MBSR_UNDETERMINED holds the range components, of others that failed
 * NaN. MBSR_ERR_NULL, MBSR_ERR_MISMATCH (batch of another model) and MBSR_ERR_VALUE (states < 1)
 * leave udot and status as they are. */
MBSR_API int mbsr_batch_forward_dynamics(const mbsr_model *model, mbsr_batch *batch, double t,
                                         int states, const double *q, const double *u,
                                         const double *tau, double *udot, int *status);

/* Inverse dynamics (RNEA) likewise, as mbsr_inverse_dynamics; udot is an input, tau the result. */
MBSR_API int mbsr_batch_inverse_dynamics(const mbsr_model *model, mbsr_batch *batch, double t,
                                         int states, const double *q, const double *u,
                                         const double *udot, double *tau, int *status);

/* Of the last call: the first state that failed, counted from 0, or -1; how many states went one
 * by one; and the failure, with the number of the state in the text (never NULL). */
MBSR_API int mbsr_batch_failed(const mbsr_batch *batch);
MBSR_API int mbsr_batch_one_by_one(const mbsr_batch *batch);
MBSR_API const mbsr_error *mbsr_batch_error(const mbsr_batch *batch);

#ifdef __cplusplus
}
#endif

#endif
