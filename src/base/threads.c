/* Threads that wait for work, and share it out among them and the caller.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "base/threads.h"

#include "base/error.h"
#include "base/memory.h"

#include <string.h>

enum { MOST_THREADS = 256 };

static const mbsr_allocator heap = {NULL, NULL, NULL};

/* The caller's thread alone. */
static void one_by_one(void *user, int tasks, mbsr_task_fn task, void *arg)
{
    (void)user;
    for (int k = 0; k < tasks; ++k) task(arg, k);
}

#if defined(MBSR_WITH_THREADS)

#include <pthread.h>
#include <stdatomic.h>

/* Looks before a thread falls asleep, less than a millisecond: to wake it may take as long. */
enum { PATIENCE = 20000 };

struct mbsr_threads {
    pthread_mutex_t lock;
    pthread_cond_t begins, ends;
    int helpers;       /* threads beside the caller's */
    mbsr_task_fn task; /* the work, of which `next` is the first piece that nobody has begun */
    void *arg;
    int tasks;
    atomic_int next;
    atomic_int round; /* counts the calls */
    atomic_int busy;  /* helpers that are not done with this one */
    atomic_bool ending;
    pthread_t helper[MOST_THREADS];
};

static void pause_briefly(void)
{
#if defined(__x86_64__) || defined(__i386__)
    __builtin_ia32_pause();
#endif
}

static void work(mbsr_threads *t)
{
    int k;
    while ((k = atomic_fetch_add(&t->next, 1)) < t->tasks) t->task(t->arg, k);
}

/* Returns once there is another round than `seen`, or the end. */
static void wait_for_round(mbsr_threads *t, int seen)
{
    for (int look = 0; look < PATIENCE; ++look) {
        if (atomic_load(&t->round) != seen || atomic_load(&t->ending)) return;
        pause_briefly();
    }
    pthread_mutex_lock(&t->lock);
    while (atomic_load(&t->round) == seen && !atomic_load(&t->ending))
        pthread_cond_wait(&t->begins, &t->lock);
    pthread_mutex_unlock(&t->lock);
}

static void *help(void *arg)
{
    mbsr_threads *t = arg;
    for (int seen = 0;; ++seen) {
        wait_for_round(t, seen);
        if (atomic_load(&t->ending)) return NULL;
        work(t);
        if (atomic_fetch_sub(&t->busy, 1) > 1) continue;
        pthread_mutex_lock(&t->lock);
        pthread_cond_signal(&t->ends);
        pthread_mutex_unlock(&t->lock);
    }
}

static void run_on_threads(void *user, int tasks, mbsr_task_fn task, void *arg)
{
    mbsr_threads *t = user;
    t->task = task;
    t->arg = arg;
    t->tasks = tasks;
    atomic_store(&t->next, 0);
    atomic_store(&t->busy, t->helpers);
    pthread_mutex_lock(&t->lock);
    atomic_fetch_add(&t->round, 1);
    pthread_cond_broadcast(&t->begins);
    pthread_mutex_unlock(&t->lock);
    work(t);
    for (int look = 0; look < PATIENCE && atomic_load(&t->busy) > 0; ++look) pause_briefly();
    pthread_mutex_lock(&t->lock);
    while (atomic_load(&t->busy) > 0) pthread_cond_wait(&t->ends, &t->lock);
    pthread_mutex_unlock(&t->lock);
}

void mbsr_threads_destroy(mbsr_threads *threads)
{
    if (!threads) return;
    pthread_mutex_lock(&threads->lock);
    atomic_store(&threads->ending, true);
    pthread_cond_broadcast(&threads->begins);
    pthread_mutex_unlock(&threads->lock);
    for (int k = 0; k < threads->helpers; ++k) pthread_join(threads->helper[k], NULL);
    pthread_cond_destroy(&threads->begins);
    pthread_cond_destroy(&threads->ends);
    pthread_mutex_destroy(&threads->lock);
    mbsri_release(&heap, threads);
}

static mbsr_threads *start_helpers(int helpers)
{
    mbsr_threads *t = mbsri_allocate(&heap, sizeof *t);
    if (!t) return NULL;
    memset(t, 0, sizeof *t);
    if (pthread_mutex_init(&t->lock, NULL) || pthread_cond_init(&t->begins, NULL) ||
        pthread_cond_init(&t->ends, NULL)) {
        mbsri_release(&heap, t);
        return NULL;
    }
    for (; t->helpers < helpers; ++t->helpers) {
        if (pthread_create(t->helper + t->helpers, NULL, help, t)) {
            mbsr_threads_destroy(t);
            return NULL;
        }
    }
    return t;
}

static int helpers_of(const mbsr_threads *t)
{
    return t->helpers;
}

#else

struct mbsr_threads {
    int none;
};

static void run_on_threads(void *user, int tasks, mbsr_task_fn task, void *arg)
{
    one_by_one(user, tasks, task, arg);
}

void mbsr_threads_destroy(mbsr_threads *threads)
{
    mbsri_release(&heap, threads);
}

static mbsr_threads *start_helpers(int helpers)
{
    mbsr_threads *t = helpers > 0 ? NULL : mbsri_allocate(&heap, sizeof *t);
    if (t) t->none = 0;
    return t;
}

static int helpers_of(const mbsr_threads *t)
{
    return t->none;
}

#endif

int mbsr_threads_create(int count, mbsr_threads **threads, mbsr_error *error)
{
    static const char function[] = "mbsr_threads_create";
    if (!threads) {
        return mbsri_fail(error, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "%s: threads is NULL",
                          function);
    }
    *threads = NULL;
    if (count < 1 || count > MOST_THREADS) {
        return mbsri_fail(error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                          "%s: count is %d, must be from 1 to %d", function, count, MOST_THREADS);
    }
#if !defined(MBSR_WITH_THREADS)
    if (count > 1) {
        return mbsri_fail(error, MBSR_ERR_UNAVAILABLE, MBSR_NONE, MBSR_NONE,
                          "%s: count is %d, but the library was built without threads", function,
                          count);
    }
#endif
    *threads = start_helpers(count - 1);
    if (*threads) return MBSR_OK;
    return mbsri_fail(error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                      "%s: the system gives no %d threads", function, count);
}

mbsr_parallel mbsr_threads_parallel(mbsr_threads *threads)
{
    if (!threads) return (mbsr_parallel){1, one_by_one, NULL};
    return (mbsr_parallel){helpers_of(threads) + 1, run_on_threads, threads};
}

int mbsri_parallel_check(const mbsr_parallel *parallel, const char *function, mbsr_error *error)
{
    if (!parallel) {
        return mbsri_fail(error, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE, "%s: parallel is NULL",
                          function);
    }
    if (!parallel->run) {
        return mbsri_fail(error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE, "%s: parallel.run is NULL",
                          function);
    }
    if (parallel->workers >= 1) return MBSR_OK;
    return mbsri_fail(error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                      "%s: parallel.workers is %d, must be at least 1", function,
                      parallel->workers);
}
