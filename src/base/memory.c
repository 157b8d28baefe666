/* The caller's allocator, or malloc and free.
 * SPDX-License-Identifier: BSD-3-Clause */
#if defined(__linux__) && !defined(_DEFAULT_SOURCE)
/* for madvise */
#define _DEFAULT_SOURCE
#endif

#include "base/memory.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#if defined(__linux__)
#include <sys/mman.h>
#endif

/* A block of many pages, which the sweeps run through from end to end: on huge pages where the
 * system has them, with a 512th of the entries in its translation tables. */
static void *allocate_large(size_t size)
{
#if defined(__linux__) && defined(MADV_HUGEPAGE)
    const size_t huge = (size_t)1 << 21, rounded = (size + huge - 1) / huge * huge;
    void *memory = rounded >= size ? aligned_alloc(huge, rounded) : NULL;
    /* advice: nothing is lost where it is not taken */
    if (memory) (void)madvise(memory, rounded, MADV_HUGEPAGE);
    return memory;
#else
    return malloc(size);
#endif
}

static void *allocate_default(size_t size)
{
    enum { LARGE = 1 << 22 };
    return size < LARGE ? malloc(size) : allocate_large(size);
}

void *mbsri_allocate(const mbsr_allocator *allocator, size_t size)
{
    if (size == 0) size = 1;
    return allocator->allocate ? allocator->allocate(allocator->user, size)
                               : allocate_default(size);
}

void mbsri_release(const mbsr_allocator *allocator, void *memory)
{
    if (!memory) return;
    if (allocator->release) {
        allocator->release(allocator->user, memory);
    } else {
        free(memory);
    }
}

bool mbsri_reserve(const mbsr_allocator *allocator, mbsri_array *array, size_t more, size_t element)
{
    if (array->count + more <= array->capacity) return true;
    size_t capacity = array->capacity ? array->capacity : 8;
    while (capacity < array->count + more) {
        if (capacity > SIZE_MAX / 2 / element) return false;
        capacity *= 2;
    }
    void *data = mbsri_allocate(allocator, capacity * element);
    if (!data) return false;
    if (array->count > 0) memcpy(data, array->data, array->count * element);
    mbsri_release(allocator, array->data);
    array->data = data;
    array->capacity = capacity;
    return true;
}
