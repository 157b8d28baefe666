/* An allocator that counts, fails when told to, and checks that what it gave comes back.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_COUNTING_H
#define TEST_COUNTING_H

#include <mbsrank/base.h>

#include <stdlib.h>

typedef struct test_counting {
    long calls;   /* allocations asked for */
    long live;    /* given and not yet returned */
    long fail_at; /* number of the allocation that fails, counted from 1; 0: none */
    int failed;   /* whether it did */
} test_counting;

static inline void *test_counting_allocate(void *user, size_t size)
{
    test_counting *counting = user;
    if (++counting->calls == counting->fail_at) {
        counting->failed = 1;
        return NULL;
    }
    void *memory = malloc(size);
    if (memory) ++counting->live;
    return memory;
}

static inline void test_counting_release(void *user, void *memory)
{
    test_counting *counting = user;
    if (memory) --counting->live;
    free(memory);
}

static inline mbsr_allocator test_counting_allocator(test_counting *counting)
{
    return (mbsr_allocator){test_counting_allocate, test_counting_release, counting};
}

#endif
