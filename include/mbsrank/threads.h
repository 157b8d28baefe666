/* Several threads for one evaluation: the subtrees of a large tree, or the states of a batch, side
 * by side.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   mbsr_threads *threads;
 *   mbsr_split *split;
 *   mbsr_threads_create(2, &threads, &error);
 *   const mbsr_parallel parallel = mbsr_threads_parallel(threads);
 *   mbsr_split_create(model, &parallel, &split, &error);
 *   mbsr_data_use_split(data, split);
 *   mbsr_forward_dynamics(model, data, ...);      and so on, with two threads
 *
 * Nothing else uses threads. Results are the same to the last bit, with any number of threads. A
 * program with threads of its own hands these over instead: an mbsr_parallel is all that is asked
 * for. */
#ifndef MBSRANK_THREADS_H
#define MBSRANK_THREADS_H

#include <mbsrank/batch.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Piece k of some work. */
typedef void (*mbsr_task_fn)(void *arg, int k);

/* Who does the work. `run` calls task(arg, k) once for each k = 0 .. tasks-1, in any order and from
 * any threads, and returns when all have returned; what they wrote is then seen by the caller. */
typedef struct mbsr_parallel {
    int workers; /* pieces that are done at the same time, >= 1 */
    void (*run)(void *user, int tasks, mbsr_task_fn task, void *arg);
    void *user;
} mbsr_parallel;

/* ---- threads of the library's own (pthreads) ---- */

typedef struct mbsr_threads mbsr_threads;

/* `count` >= 1 threads, the caller's among them; at most 256. They wait for work for less
 * than a millisecond awake, then asleep.
 * No call allocates after this. MBSR_ERR_NULL, MBSR_ERR_VALUE, MBSR_ERR_NO_MEMORY (also where the
 * system gives no more threads), MBSR_ERR_UNAVAILABLE (the library was built without threads, count
 * > 1). */
MBSR_API int mbsr_threads_create(int count, mbsr_threads **threads, mbsr_error *error);
MBSR_API void mbsr_threads_destroy(mbsr_threads *threads); /* NULL is allowed */

/* They, for one call at a time and as long as they live. NULL: the caller's thread alone. */
MBSR_API mbsr_parallel mbsr_threads_parallel(mbsr_threads *threads);

/* ---- one large tree ---- */

typedef struct mbsr_split mbsr_split;

/* Subtrees of a finished model that are worth a thread each; model, and what `parallel` (which is
 * copied) refers to, must outlive it. It serves mbsr_forward_dynamics, mbsr_inverse_dynamics and
 * the residual of the momentum form where all bodies are rigid, on stock joints, and force elements
 * act along joints or are gravity; other models are evaluated by one thread, and so is a tree
 * without large branches, such as a chain. Motions that are prescribed are called from several
 * threads. Memory comes from the model's allocator. MBSR_ERR_NULL, MBSR_ERR_UNFINISHED,
 * MBSR_ERR_VALUE (parallel), MBSR_ERR_NO_MEMORY. */
MBSR_API int mbsr_split_create(const mbsr_model *model, const mbsr_parallel *parallel,
                               mbsr_split **split, mbsr_error *error);
MBSR_API void mbsr_split_destroy(mbsr_split *split); /* NULL is allowed */

/* How many pieces of work the tree has been split into; 0: one thread evaluates it. */
MBSR_API int mbsr_split_tasks(const mbsr_split *split);

/* From now on `data` is evaluated so; NULL: by one thread again. A split is used by one call at a
 * time, and must outlive its use. MBSR_ERR_NULL (data), MBSR_ERR_MISMATCH. */
MBSR_API int mbsr_data_use_split(mbsr_data *data, mbsr_split *split);

/* ---- many states ---- */

/* A batch (batch.h) of which each call is shared out among the workers, as many states to each;
 * each has the memory of a batch. What `parallel` refers to must outlive the batch; functions of
 * the model's are called from several threads. Statuses of mbsr_batch_create, MBSR_ERR_VALUE
 * (parallel). */
MBSR_API int mbsr_batch_create_parallel(const mbsr_model *model, const mbsr_parallel *parallel,
                                        mbsr_batch **batch, mbsr_error *error);

#ifdef __cplusplus
}
#endif

#endif
