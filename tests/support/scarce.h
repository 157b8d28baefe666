/* malloc and its like of this program and of the libraries that it loads, in their place: they
 * count, and fail when told to. Needs glibc, no sanitizer, and one source that includes it.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_SCARCE_H
#define TEST_SCARCE_H

#include <stdbool.h>
#include <stdlib.h>

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#if defined(__has_feature)
#if !__has_feature(address_sanitizer) && !__has_feature(thread_sanitizer) &&                       \
    !__has_feature(memory_sanitizer)
#define TEST_SCARCE 1
#endif
#else
#define TEST_SCARCE 1
#endif
#endif

typedef struct test_scarce {
    bool on;      /* else nothing is counted */
    long calls;   /* allocations asked for */
    long live;    /* given and not yet returned */
    long fail_at; /* number of the allocation that fails, counted from 1; 0: none */
    bool own;     /* those of this program alone fail: SUNDIALS does not survive that of its own */
} test_scarce;

static test_scarce test_memory;

#if defined(TEST_SCARCE)
extern void *__libc_malloc(size_t size);
extern void *__libc_calloc(size_t count, size_t size);
extern void *__libc_realloc(void *memory, size_t size);
extern void __libc_free(void *memory);

extern const char __executable_start, etext;

static bool test_scarce_fails(const char *caller)
{
    if (!test_memory.on) return false;
    if (test_memory.own && (caller < &__executable_start || caller >= &etext)) return false;
    return ++test_memory.calls == test_memory.fail_at;
}

static void *test_scarce_given(void *memory)
{
    test_memory.live += test_memory.on && memory;
    return memory;
}

void *malloc(size_t size)
{
    if (test_scarce_fails(__builtin_return_address(0))) return NULL;
    return test_scarce_given(__libc_malloc(size));
}

void *calloc(size_t count, size_t size)
{
    if (test_scarce_fails(__builtin_return_address(0))) return NULL;
    return test_scarce_given(__libc_calloc(count, size));
}

void *realloc(void *memory, size_t size)
{
    if (test_scarce_fails(__builtin_return_address(0))) return NULL;
    return memory ? __libc_realloc(memory, size) : test_scarce_given(__libc_malloc(size));
}

void free(void *memory)
{
    test_memory.live -= test_memory.on && memory;
    __libc_free(memory);
}
#endif

/* Counts the allocations of a call that succeeds, then lets each `every`th of them fail: the call
 * says `refused`, but for a few that are not needed (qsort sorts in place without), and nothing is
 * lost. Returns how many there are; -1 where nothing is counted, -2 where a call said something
 * else. */
static inline long test_scarce_each(int (*call)(void *user), void *user, int refused, long every)
{
#if defined(TEST_SCARCE)
    const bool own = test_memory.own;
    if (!own) { /* valgrind has an allocator of its own */
        test_memory = (test_scarce){.on = true};
        void *volatile probe = malloc(1);
        free(probe);
        if (test_memory.calls == 0) return -1;
    }
    test_memory = (test_scarce){.on = true, .own = own};
    int status = call(user);
    const long count = test_memory.calls;
    bool good = status == 0 && test_memory.live == 0;
    long spared = 0;
    for (long k = 1; k <= count && good; k += every) {
        test_memory = (test_scarce){.on = true, .fail_at = k, .own = own};
        status = call(user);
        spared += status == 0;
        good = (status == refused || (status == 0 && spared <= 4)) && test_memory.live == 0;
    }
    test_memory.on = false;
    return good ? count : -2;
#else
    (void)call, (void)user, (void)refused, (void)every;
    return -1;
#endif
}

#endif
