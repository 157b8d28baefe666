/* Threads of the library's own: every piece of work is done once, by more than one of them.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"

#include <mbsrank/threads.h>

#include <stdatomic.h>
#include <string.h>

enum { PIECES = 1000 };

typedef struct work {
    int done[PIECES];
    atomic_int sum;
    int pieces;
} work;

static void piece(void *arg, int k)
{
    work *w = arg;
    assert_in_range(k, 0, w->pieces - 1);
    ++w->done[k];
    atomic_fetch_add(&w->sum, k);
}

/* Calls follow each other at once, and after a while. */
static void every_piece_is_done_once(void **state)
{
    (void)state;
    for (int count = 1; count <= 5; ++count) {
        mbsr_threads *threads;
        mbsr_error error;
        const int status = mbsr_threads_create(count, &threads, &error);
        if (status == MBSR_ERR_UNAVAILABLE) {
            assert_null(threads);
            assert_non_null(strstr(error.text, "without threads"));
            continue;
        }
        assert_ok(status, &error);
        const mbsr_parallel parallel = mbsr_threads_parallel(threads);
        assert_int_equal(parallel.workers, count);
        for (int pieces = 0; pieces <= PIECES; pieces += pieces < 20 ? 1 : 245) {
            work w = {.pieces = pieces};
            atomic_init(&w.sum, 0);
            parallel.run(parallel.user, pieces, piece, &w);
            for (int k = 0; k < PIECES; ++k) assert_int_equal(w.done[k], k < pieces);
            assert_int_equal(atomic_load(&w.sum), pieces * (pieces - 1) / 2);
            for (volatile int pause = 0; pause < 20000 * (pieces % 3); ++pause) {
            }
        }
        mbsr_threads_destroy(threads);
    }
}

/* Piece 0 ends only after piece 1 has begun, which takes a second thread. */
static void wait_for_the_other(void *arg, int k)
{
    atomic_int *begun = arg;
    if (k == 1) atomic_store(begun, 1);
    while (k == 0 && !atomic_load(begun)) {
    }
}

static void pieces_are_done_at_the_same_time(void **state)
{
    (void)state;
    mbsr_threads *threads;
    if (mbsr_threads_create(2, &threads, NULL) == MBSR_ERR_UNAVAILABLE) return;
    const mbsr_parallel parallel = mbsr_threads_parallel(threads);
    for (int round = 0; round < 100; ++round) {
        atomic_int begun;
        atomic_init(&begun, 0);
        parallel.run(parallel.user, 2, wait_for_the_other, &begun);
        assert_int_equal(atomic_load(&begun), 1);
    }
    mbsr_threads_destroy(threads);
}

static void no_threads_are_the_callers(void **state)
{
    (void)state;
    const mbsr_parallel alone = mbsr_threads_parallel(NULL);
    work w = {.pieces = 7};
    atomic_init(&w.sum, 0);
    assert_int_equal(alone.workers, 1);
    alone.run(alone.user, 7, piece, &w);
    assert_int_equal(atomic_load(&w.sum), 21);
    mbsr_threads_destroy(NULL);
}

static void bad_counts_are_refused(void **state)
{
    (void)state;
    mbsr_error error;
    mbsr_threads *threads = (void *)&error;
    assert_int_equal(mbsr_threads_create(0, &threads, &error), MBSR_ERR_VALUE);
    assert_null(threads);
    assert_non_null(strstr(error.text, "count is 0"));
    assert_int_equal(mbsr_threads_create(257, &threads, &error), MBSR_ERR_VALUE);
    assert_int_equal(mbsr_threads_create(2, NULL, &error), MBSR_ERR_NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(every_piece_is_done_once),
                                       cmocka_unit_test(pieces_are_done_at_the_same_time),
                                       cmocka_unit_test(no_threads_are_the_callers),
                                       cmocka_unit_test(bad_counts_are_refused)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
